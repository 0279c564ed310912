// SPDX-License-Identifier: MIT
#include <selvedge/core/base/elementary.h>
#include <selvedge/dress/detail/dress_pictures.h>
#include <selvedge/pictures/picture_files.h>
#include <selvedge/pictures/renderer/render.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace selvedge::detail {
namespace {

namespace fs = std::filesystem;

/// Largest principal strain of each triangle.
std::vector<double> largest_strains(const DressResult& r) {
  std::vector<double> strain;
  for (std::size_t i = 0; i < r.garment.triangles.size(); ++i) {
    const auto gradient = deformation(r, i).gradient;
    const Eigen::Matrix2d c = gradient.transpose() * gradient;
    const double mean = 0.5 * (c(0, 0) + c(1, 1)), half = 0.5 * (c(0, 0) - c(1, 1));
    strain.push_back(std::sqrt(mean + elementary::hypot(half, c(0, 1))) - 1.0);
  }
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

struct PanelDye {
  Vec3 front, back;  // linear RGB; the back is the inner side
};
constexpr double kPictureGrid = 0.05;  // m

const std::array<PanelDye, 4>& panel_dyes() {
  static const std::array<PanelDye, 4> list = {{{{0.045, 0.21, 0.27}, {0.62, 0.34, 0.050}},
                                                {{0.10, 0.27, 0.33}, {0.62, 0.34, 0.050}},
                                                {{0.03, 0.16, 0.22}, {0.62, 0.34, 0.050}},
                                                {{0.07, 0.24, 0.24}, {0.62, 0.34, 0.050}}}};
  return list;
}

/// The garment cut open along its seams, so that the grid of each panel is that of its pattern.
struct CutGarment {
  std::vector<Vec3> x;
  std::vector<Eigen::Vector2d> material;
  std::vector<std::vector<Triangle>> panels;
};

CutGarment cut(const DressResult& r, std::span<const Vec3> x) {
  CutGarment out;
  out.x.assign(r.flat.vertices.size(), Vec3::Zero());
  for (const Vec3& u : r.flat.vertices) out.material.emplace_back(u.x(), u.y());
  for (std::size_t i = 0; i < r.flat.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) out.x[r.flat.triangles[i][k]] = x[r.garment.triangles[i][k]];
    const auto panel = static_cast<std::size_t>(r.panel_of_triangle[i]);
    if (panel >= out.panels.size()) out.panels.resize(panel + 1);
    out.panels[panel].push_back(r.flat.triangles[i]);
  }
  return out;
}

std::pair<Vec3, Vec3> box_of(std::span<const Vec3> x) {
  Vec3 low = x.front(), high = x.front();
  for (const Vec3& p : x) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return {low, high};
}

/// The garments below, in shades of grey.
std::vector<RenderSurface> surfaces_below(const DressResult& result, const Worn& worn) {
  std::vector<RenderSurface> surfaces;
  std::size_t at = result.garment.vertices.size();
  for (const UnderReport& under : result.under) {
    const TriangleMesh& mesh = under.garment.surface;
    RenderSurface surface;
    surface.x = worn.cloth.subspan(at, mesh.vertices.size());
    surface.triangles = mesh.triangles;
    surface.front = surface.back =
        surfaces.size() % 2 == 0 ? Vec3(0.75, 0.72, 0.66) : Vec3(0.35, 0.30, 0.26);
    surfaces.push_back(surface);
    at += mesh.vertices.size();
  }
  return surfaces;
}

void draw(const fs::path& file, const DressResult& result, const Worn& worn,
          const std::vector<RenderSurface>& cloth, double side) {
  std::vector<RenderSurface> surfaces = surfaces_below(result, worn);
  RenderSurface skin;
  skin.x = worn.body;
  skin.triangles = result.body.triangles;
  skin.front = skin.back = Vec3(0.47, 0.475, 0.485);
  surfaces.push_back(skin);
  surfaces.insert(surfaces.end(), cloth.begin(), cloth.end());
  const auto [body_low, body_high] = box_of(worn.body);
  const auto [cloth_low, cloth_high] = box_of(worn.cloth);
  const Vec3 low = body_low.cwiseMin(cloth_low), high = body_high.cwiseMax(cloth_high);
  const Vec3 centre = 0.5 * (low + high);
  Camera camera;
  camera.target = centre;
  camera.eye = centre + Vec3(0.5, side * -2.5, 0.4);
  camera.field_of_view = 30.0;
  camera.width = 720;
  camera.height = 720;
  write_png(file, render(framed(camera, low, high), surfaces));
}

/// NAMEfront.png and NAMEback.png.
void draw_both(const fs::path& folder, const std::string& name, const DressResult& result,
               const Worn& worn, const std::vector<RenderSurface>& cloth) {
  draw(folder / (name + "front.png"), result, worn, cloth, 1.0);
  draw(folder / (name + "back.png"), result, worn, cloth, -1.0);
}

/// From dark blue over teal and green to yellow, linear RGB; `share` in [0,1].
Vec3 scale_colour(double share) {
  static const std::array<Vec3, 4> stops = {
      {{0.03, 0.05, 0.25}, {0.02, 0.30, 0.42}, {0.22, 0.55, 0.16}, {0.95, 0.75, 0.06}}};
  const double place = std::clamp(share, 0.0, 1.0) * 3.0;
  const auto k = std::min<std::size_t>(2, static_cast<std::size_t>(place));
  const double w = place - static_cast<double>(k);
  return (1.0 - w) * stops[k] + w * stops[k + 1];
}

}  // namespace

Deformation deformation(const DressResult& r, std::size_t triangle) {
  const Triangle &t = r.garment.triangles[triangle], &f = r.flat.triangles[triangle];
  Eigen::Matrix2d rest;
  Eigen::Matrix<double, 3, 2> now;
  for (int k = 0; k < 2; ++k) {
    rest.col(k) = (r.flat.vertices[f[k + 1]] - r.flat.vertices[f[0]]).head<2>();
    now.col(k) = r.garment.vertices[t[k + 1]] - r.garment.vertices[t[0]];
  }
  return {std::abs(rest.determinant()), now * rest.inverse()};
}

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

void draw_dressed(const fs::path& folder, const std::string& name, const DressResult& result,
                  const Worn& worn) {
  const CutGarment garment = cut(result, worn.cloth);
  std::vector<RenderSurface> panels;
  for (std::size_t p = 0; p < garment.panels.size(); ++p) {
    RenderSurface panel;
    panel.x = garment.x;
    panel.triangles = garment.panels[p];
    panel.front = panel_dyes()[p % panel_dyes().size()].front;
    panel.back = panel_dyes()[p % panel_dyes().size()].back;
    panel.material = garment.material;
    panel.grid = kPictureGrid;
    panel.sheen = 0.4;
    panels.push_back(panel);
  }
  draw_both(folder, name, result, worn, panels);
}

void draw_scale(const fs::path& folder, const std::string& name, const DressResult& result,
                const ColourScale& scale) {
  constexpr std::size_t steps = 24;
  std::vector<std::vector<Triangle>> triangles(steps);
  for (std::size_t i = 0; i < scale.values.size(); ++i) {
    const double share = std::clamp(scale.values[i] / scale.top, 0.0, 1.0);
    triangles[static_cast<std::size_t>(share * (steps - 1) + 0.5)].push_back(
        result.garment.triangles[i]);
  }
  std::vector<RenderSurface> surfaces;
  for (std::size_t k = 0; k < steps; ++k) {
    if (triangles[k].empty()) continue;
    RenderSurface surface;
    surface.x = result.garment.vertices;
    surface.triangles = triangles[k];
    surface.front = surface.back = scale_colour(static_cast<double>(k) / (steps - 1));
    surfaces.push_back(surface);
  }
  const std::vector<Vec3> cloth = all_cloth(result);
  draw_both(folder, name, result, {cloth, result.body.vertices}, surfaces);
}

}  // namespace selvedge::detail
