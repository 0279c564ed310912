// SPDX-License-Identifier: MIT
#include <selvedge/dress/detail/colour_scales.h>
#include <selvedge/dress/detail/deformation.h>

#include <algorithm>
#include <utility>

namespace selvedge::detail {
namespace {

/// Largest principal strain of each triangle.
std::vector<double> largest_strains(const DressResult& r) {
  std::vector<double> strain;
  for (std::size_t i = 0; i < r.garment.triangles.size(); ++i)
    strain.push_back(deformation(r.garment, r.flat, i).largest_strain());
  return strain;
}

/// Mean of the vertices of each triangle; empty without pressures.
std::vector<double> mean_pressures(const DressResult& r) {
  std::vector<double> mean;
  if (r.pressure.empty()) return mean;
  for (const Triangle& t : r.garment.triangles)
    mean.push_back((r.pressure[t[0]] + r.pressure[t[1]] + r.pressure[t[2]]) / 3.0);
  return mean;
}

/// Up to the value that 2 % of the triangles exceed, but at least `least`.
ColourScale scale_of(std::vector<double> values, double least) {
  if (values.empty()) return {{}, least};
  std::vector<double> sorted = values;
  const auto place =
      sorted.begin() + static_cast<std::ptrdiff_t>(0.98 * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), place, sorted.end());
  return {std::move(values), std::max(least, *place)};
}
constexpr double kLeastStrain = 0.01, kLeastPressure = 10.0;  // -, Pa: the shortest scales

}  // namespace

ColourScale strain_scale(const DressResult& r) {
  return scale_of(largest_strains(r), kLeastStrain);
}
ColourScale pressure_scale(const DressResult& r) {
  return scale_of(mean_pressures(r), kLeastPressure);
}

std::vector<Vec3> all_cloth(const DressResult& r) {
  std::vector<Vec3> x = r.garment.vertices;
  for (const UnderReport& under : r.under)
    x.insert(x.end(), under.garment.surface.vertices.begin(), under.garment.surface.vertices.end());
  return x;
}

}  // namespace selvedge::detail
