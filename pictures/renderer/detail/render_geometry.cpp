// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/pictures/renderer/detail/render_geometry.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace selvedge::detail {
namespace {

void check_surface(const RenderSurface& surface, std::size_t index) {
  const std::string name = "surface " + std::to_string(index);
  for (std::size_t i = 0; i < surface.x.size(); ++i)
    if (!surface.x[i].allFinite())
      throw std::invalid_argument(name + ": vertex " + std::to_string(i) + " is not finite");
  const auto n = static_cast<std::int32_t>(surface.x.size());
  for (std::size_t k = 0; k < surface.triangles.size(); ++k)
    for (const std::int32_t v : surface.triangles[k])
      if (v < 0 || v >= n)
        throw std::invalid_argument(name + ": triangle " + std::to_string(k) + " names vertex " +
                                    std::to_string(v) + " of " + std::to_string(n));
  if (!surface.material.empty() && surface.material.size() != surface.x.size())
    throw std::invalid_argument(name + ": material positions and vertices differ in number");
}

struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  /// Vertices without a triangle are ignored, because they are not drawn.
  void add(const RenderSurface& surface) {
    for (const Triangle& t : surface.triangles)
      for (const std::int32_t v : t) {
        low = low.cwiseMin(surface.x[static_cast<std::size_t>(v)]);
        high = high.cwiseMax(surface.x[static_cast<std::size_t>(v)]);
      }
  }
  bool empty() const { return !(low.x() <= high.x()); }
};

/// Box at which the lights are aimed: that of all surfaces except the backdrop, or that of the
/// backdrop if there is no other surface.
Box lit_box(std::span<const RenderSurface> surfaces) {
  Box aimed, all;
  for (const RenderSurface& surface : surfaces) {
    all.add(surface);
    if (!surface.backdrop) aimed.add(surface);
  }
  if (aimed.empty()) aimed = all;
  if (aimed.empty()) aimed.low = aimed.high = Vec3::Zero();
  return aimed;
}

/// Triangles around each vertex, stored in one array with an offset per vertex.
struct Fans {
  std::vector<std::int32_t> begin, triangle;
};

Fans fans(std::size_t vertices, std::span<const Triangle> triangles) {
  Fans result;
  result.begin.assign(vertices + 2, 0);
  for (const Triangle& t : triangles)
    for (const std::int32_t v : t) ++result.begin[static_cast<std::size_t>(v) + 2];
  for (std::size_t i = 2; i < result.begin.size(); ++i) result.begin[i] += result.begin[i - 1];
  result.triangle.resize(3 * triangles.size());
  for (std::size_t k = 0; k < triangles.size(); ++k)
    for (const std::int32_t v : triangles[k])
      result.triangle[static_cast<std::size_t>(result.begin[static_cast<std::size_t>(v) + 1]++)] =
          static_cast<std::int32_t>(k);
  return result;
}

/// Normal of each corner: the area-weighted mean over those faces around the vertex whose angle to
/// the corner's own face is at most the crease angle.
void add_normals(const RenderSurface& surface, std::size_t first_triangle, Geometry& geometry) {
  constexpr std::size_t grain = 4096;
  const auto triangles = std::span(geometry.triangles).subspan(first_triangle);
  std::vector<Vec3f> area(triangles.size()), face(triangles.size());
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    const auto corner = [&](int i) -> const Vec3f& {
      return geometry.x[static_cast<std::size_t>(triangles[k][static_cast<std::size_t>(i)])];
    };
    area[k] = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    face[k] = unit_or_zero(area[k]);
  }
  const Fans fan = fans(geometry.x.size(), triangles);
  const auto least_cosine =
      static_cast<float>(std::cos(surface.crease * std::numbers::pi / 180.0) - 1e-6);
  geometry.normals.resize(geometry.triangles.size());
  parallel_for(triangles.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      for (std::size_t i = 0; i < 3; ++i) {
        const auto v = static_cast<std::size_t>(triangles[k][i]);
        Vec3f sum = Vec3f::Zero();
        for (std::int32_t f = fan.begin[v]; f < fan.begin[v + 1]; ++f) {
          const auto other = static_cast<std::size_t>(fan.triangle[static_cast<std::size_t>(f)]);
          if (face[other].dot(face[k]) >= least_cosine) sum += area[other];
        }
        geometry.normals[first_triangle + k][i] = unit_or_zero(sum);
      }
  });
}

/// Appends the triangles of the surface and the vertices that they use.
void add_surface(const RenderSurface& surface, Geometry& geometry) {
  std::vector<std::int32_t> place(surface.x.size(), -1);
  geometry.triangles.reserve(geometry.triangles.size() + surface.triangles.size());
  for (const Triangle& t : surface.triangles) {
    Triangle& joined = geometry.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(t[k]);
      if (place[v] < 0) {
        place[v] = static_cast<std::int32_t>(geometry.x.size());
        geometry.x.push_back((surface.x[v] - geometry.origin).cast<float>());
        geometry.material.push_back(surface.material.empty()
                                        ? Vec2f(Vec2f::Zero())
                                        : Vec2f(surface.material[v].cast<float>()));
      }
      joined[k] = place[v];
    }
  }
}

}  // namespace

Geometry gather(std::span<const RenderSurface> surfaces) {
  for (std::size_t s = 0; s < surfaces.size(); ++s) check_surface(surfaces[s], s);
  Geometry geometry;
  const Box box = lit_box(surfaces);
  geometry.origin = 0.5 * (box.low + box.high);
  constexpr double margin = 1.02, smallest = 1e-9;
  geometry.radius =
      static_cast<float>(std::max(0.5 * margin * (box.high - box.low).norm(), smallest));
  geometry.lowest = static_cast<float>(box.low.z() - geometry.origin.z());
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    const std::size_t first_triangle = geometry.triangles.size();
    add_surface(surfaces[s], geometry);
    geometry.surface.resize(geometry.triangles.size(), static_cast<std::int32_t>(s));
    add_normals(surfaces[s], first_triangle, geometry);
  }
  return geometry;
}

}  // namespace selvedge::detail
