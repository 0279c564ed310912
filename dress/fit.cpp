// SPDX-License-Identifier: MIT
#include <selvedge/dress/detail/deformation.h>
#include <selvedge/dress/detail/fit.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace selvedge::detail {
namespace {

constexpr double kHalfBand = 0.03;    // m, of the cloth on both sides of a tape that counts
constexpr double kOtherLimb = 0.5;    // of the girth of a part, above which another one counts
constexpr double kLeastAround = 0.5;  // of the body's tape, that open cloth has to cover

using Part = Section::Part;

/// The part of the body in the middle of a plane.
const Part* body_part(const Section& body) {
  const Part* found = nullptr;
  for (const Part& part : body.parts)
    if (contains(part.hull, Eigen::Vector2d::Zero()) && (!found || part.tape > found->tape))
      found = &part;
  return found;
}

/// Whether cloth lies around this part of the body alone, as a sleeve does around an arm and a
/// skirt does not around a thigh.
bool is_around_alone(const Part& cloth, const Section& body, const Part& own) {
  if (!contains(cloth.hull, own.middle)) return false;
  return std::none_of(body.parts.begin(), body.parts.end(), [&](const Part& other) {
    return &other != &own && other.tape > kOtherLimb * own.tape &&
           !contains(own.hull, other.middle) && contains(cloth.hull, other.middle);
  });
}

/// The cloth around the part: a ring before open cloth, and of these the longest.
const Part* cloth_around(const Section& cloth, const Section& body, const Part& own) {
  const Part* found = nullptr;
  for (const Part& part : cloth.parts) {
    if (!is_around_alone(part, body, own)) continue;
    if (!part.is_ring && part.length < kLeastAround * own.tape) continue;
    const auto rank = [](const Part& p) { return std::pair(p.is_ring, p.length); };
    if (!found || rank(part) > rank(*found)) found = &part;
  }
  return found;
}

/// Whether a point lies in a hull, or at most kHalfBand outside of it.
bool is_near(std::span<const Eigen::Vector2d> hull, const Eigen::Vector2d& p) {
  if (contains(hull, p)) return true;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d way = hull[(i + 1) % hull.size()] - hull[i], from = p - hull[i];
    const double along = std::clamp(from.dot(way) / way.squaredNorm(), 0.0, 1.0);
    if ((from - along * way).norm() <= kHalfBand) return true;
  }
  return false;
}

/// Strain and pressure of the triangles in the band about the tape.
void measure_band(const DressResult& r, const CutPlane& plane, const Part& cloth, FitZone& zone) {
  double area = 0.0, strain = 0.0, pressure = 0.0;
  for (std::size_t i = 0; i < r.garment.triangles.size(); ++i) {
    const Triangle& t = r.garment.triangles[i];
    const Vec3 middle =
        (r.garment.vertices[t[0]] + r.garment.vertices[t[1]] + r.garment.vertices[t[2]]) / 3.0;
    if (std::abs(plane.height(middle)) > kHalfBand || !is_near(cloth.hull, plane.flat(middle)))
      continue;
    const Deformation d = deformation(r.garment, r.flat, i);
    const double p =
        r.pressure.empty() ? 0.0 : (r.pressure[t[0]] + r.pressure[t[1]] + r.pressure[t[2]]) / 3.0;
    area += d.area;
    strain += d.area * d.largest_strain();
    pressure += d.area * p;
    zone.strain_max = std::max(zone.strain_max, d.largest_strain());
    zone.pressure_max = std::max(zone.pressure_max, p);
    zone.triangles.push_back(static_cast<std::int32_t>(i));
  }
  if (area <= 0.0) return;
  zone.strain = strain / area;
  zone.pressure = pressure / area;
}

}  // namespace

void measure_fit(const std::vector<BodyZone>& zones, DressResult& r) {
  for (const BodyZone& place : zones) {
    const Section body = section_of(r.body, place.plane);
    const Part* own = body_part(body);
    if (!own) continue;
    FitZone zone;
    zone.name = place.name;
    zone.at = place.plane.point();
    zone.normal = place.plane.normal();
    zone.body = own->tape;
    const Section section = section_of(r.garment, place.plane);
    if (const Part* cloth = cloth_around(section, body, *own)) {
      zone.is_closed = cloth->is_ring;
      zone.cloth = length_in(r.flat, r.garment, cloth->segments);
      zone.worn = cloth->tape;
      measure_band(r, place.plane, *cloth, zone);
    }
    r.fit.push_back(std::move(zone));
  }
}

}  // namespace selvedge::detail
