// SPDX-License-Identifier: MIT
#include <selvedge/pictures/renderer/internal/garment_views.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace selvedge {
namespace {

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

CutGarment cut(const PicturedGarment& g) {
  CutGarment out;
  out.x.assign(g.pattern.vertices.size(), Vec3::Zero());
  for (const Vec3& u : g.pattern.vertices) out.material.emplace_back(u.x(), u.y());
  for (std::size_t i = 0; i < g.pattern.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) out.x[g.pattern.triangles[i][k]] = g.cloth[g.triangles[i][k]];
    const auto panel = static_cast<std::size_t>(g.panel_of_triangle[i]);
    if (panel >= out.panels.size()) out.panels.resize(panel + 1);
    out.panels[panel].push_back(g.pattern.triangles[i]);
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

/// The vertices of the garment itself.
std::span<const Vec3> vertices_of(const PicturedGarment& g) {
  std::size_t below = 0;
  for (const TriangleMesh* mesh : g.below) below += mesh->vertices.size();
  return g.cloth.first(g.cloth.size() - below);
}

/// The garments below, in shades of grey.
std::vector<RenderSurface> surfaces_below(const PicturedGarment& g) {
  std::vector<RenderSurface> surfaces;
  std::size_t at = vertices_of(g).size();
  for (const TriangleMesh* mesh : g.below) {
    RenderSurface surface;
    surface.x = g.cloth.subspan(at, mesh->vertices.size());
    surface.triangles = mesh->triangles;
    surface.front = surface.back =
        surfaces.size() % 2 == 0 ? Vec3(0.75, 0.72, 0.66) : Vec3(0.35, 0.30, 0.26);
    surfaces.push_back(surface);
    at += mesh->vertices.size();
  }
  return surfaces;
}

/// Seen against the direction `from`.
Image draw(const PicturedGarment& g, const std::vector<RenderSurface>& cloth, const Vec3& from) {
  std::vector<RenderSurface> surfaces = surfaces_below(g);
  RenderSurface skin;
  skin.x = g.body;
  skin.triangles = g.body_triangles;
  skin.front = skin.back = Vec3(0.47, 0.475, 0.485);
  surfaces.push_back(skin);
  surfaces.insert(surfaces.end(), cloth.begin(), cloth.end());
  const auto [body_low, body_high] = box_of(g.body);
  const auto [cloth_low, cloth_high] = box_of(g.cloth);
  const Vec3 low = body_low.cwiseMin(cloth_low), high = body_high.cwiseMax(cloth_high);
  const Vec3 centre = 0.5 * (low + high);
  Camera camera;
  camera.target = centre;
  camera.eye = centre + from;
  camera.field_of_view = 30.0;
  camera.width = 720;
  camera.height = 720;
  return render(framed(camera, low, high), surfaces);
}

std::vector<GarmentView> front_and_back(const PicturedGarment& g,
                                        const std::vector<RenderSurface>& cloth) {
  return {{"front", draw(g, cloth, Vec3(0.5, -2.5, 0.4))},
          {"back", draw(g, cloth, Vec3(0.5, 2.5, 0.4))}};
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

bool is_before(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

}  // namespace

std::vector<GarmentView> views_of_panels(const PicturedGarment& g) {
  const CutGarment garment = cut(g);
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
  return front_and_back(g, panels);
}

std::vector<GarmentView> views_by_scale(const PicturedGarment& g, const ColourScale& scale) {
  constexpr std::size_t steps = 24;
  std::vector<std::vector<Triangle>> triangles(steps);
  for (std::size_t i = 0; i < scale.values.size(); ++i) {
    const double share = std::clamp(scale.values[i] / scale.top, 0.0, 1.0);
    triangles[static_cast<std::size_t>(share * (steps - 1) + 0.5)].push_back(g.triangles[i]);
  }
  std::vector<RenderSurface> surfaces;
  for (std::size_t k = 0; k < steps; ++k) {
    if (triangles[k].empty()) continue;
    RenderSurface surface;
    surface.x = vertices_of(g);
    surface.triangles = triangles[k];
    surface.front = surface.back = scale_colour(static_cast<double>(k) / (steps - 1));
    surfaces.push_back(surface);
  }
  return front_and_back(g, surfaces);
}

std::vector<GarmentView> views_by_colour(const PicturedGarment& g, std::span<const Vec3> colours) {
  std::map<Vec3, std::vector<Triangle>, decltype(&is_before)> triangles(is_before);
  for (std::size_t i = 0; i < colours.size(); ++i) triangles[colours[i]].push_back(g.triangles[i]);
  std::vector<RenderSurface> surfaces;
  for (const auto& [colour, list] : triangles) {
    RenderSurface surface;
    surface.x = vertices_of(g);
    surface.triangles = list;
    surface.front = surface.back = colour;
    surfaces.push_back(surface);
  }
  std::vector<GarmentView> views = front_and_back(g, surfaces);
  views.push_back({"left", draw(g, surfaces, Vec3(2.5, -0.5, 0.4))});
  views.push_back({"right", draw(g, surfaces, Vec3(-2.5, -0.5, 0.4))});
  return views;
}

}  // namespace selvedge
