// SPDX-License-Identifier: MIT
#include <selvedge/dress/detail/body_surface.h>
#include <selvedge/narrowphase/distance.h>

#include <Eigen/Geometry>
#include <cmath>

namespace selvedge::detail {
namespace {

constexpr double kInside = 0.5;     // winding number
constexpr double kLastReach = 1e6;  // of the first one

}  // namespace

BodySurface::BodySurface(const TriangleMesh& body)
    : body_(body), winding_(body), tree_(body.triangles) {
  tree_.fit(body.vertices);
}

const Vec3& BodySurface::corner(std::int32_t triangle, int k) const {
  return body_.vertices[body_.triangles[triangle][k]];
}

Vec3 BodySurface::normal(std::int32_t triangle) const {
  const Vec3& a = corner(triangle, 0);
  return (corner(triangle, 1) - a).cross(corner(triangle, 2) - a).stableNormalized();
}

bool BodySurface::is_inside(const Vec3& p) const { return std::abs(winding_.at(p)) > kInside; }

BodySurface::Nearest BodySurface::nearest_within(const Vec3& p, double reach) const {
  Nearest near{.point = p};
  tree_.for_each_near(p, reach, [&](std::int32_t i) {
    const ClosestPoints to = point_triangle_closest(p, corner(i, 0), corner(i, 1), corner(i, 2));
    const bool is_nearer =
        to.distance < near.distance || (to.distance == near.distance && i < near.triangle);
    if (to.distance <= reach && is_nearer) near = {p - to.separation, i, to.distance};
  });
  return near;
}

BodySurface::Nearest BodySurface::nearest(const Vec3& p, double reach) const {
  Nearest near{.point = p};
  for (double r = reach; near.triangle < 0 && r <= kLastReach * reach; r *= 2.0)
    near = nearest_within(p, r);
  return near;
}

}  // namespace selvedge::detail
