// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/distance.h>
#include <selvedge/simulation/contacts/detail/contact_filter.h>
#include <selvedge/simulation/contacts/detail/surface_union.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace selvedge::detail {

/// A point q on a border of a primitive, and the way from it to the other primitive.
struct SurfaceUnion::Meeting {
  std::array<std::int32_t, 3> vertex{};  // of the border: one of a vertex, two of an edge
  std::size_t size = 0;
  Vec3 q, towards;
  double slope = 0.0;  // above which a face rises

  bool is_open = false;  // along edges with one triangle

  /// Whether ContactFilter has judged the triangle: it goes round a vertex, but along an open edge
  /// it does not see what lies against it.
  bool is_of(const Triangle& t) const {
    const auto border = std::span(vertex).first(size);
    const auto has = [&](std::int32_t v) { return v == t[0] || v == t[1] || v == t[2]; };
    return is_open ? std::ranges::all_of(border, has) : std::ranges::any_of(border, has);
  }
  bool is_below(const Vec3& from, const Vec3& to) const {
    const Vec3 u = to - from;
    return towards.dot(u) > slope * towards.norm() * u.norm();
  }
};

struct SurfaceUnion::Verdict {
  bool is_wall = false;
  double nearest = 0.0;  // m, distance of the face that turns the normal
  std::int32_t turned_by = -1;
};

std::vector<char> border_vertices(std::span<const Triangle> triangles, std::size_t n) {
  std::vector<Edge> sides;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k)
      sides.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
  std::sort(sides.begin(), sides.end());
  std::vector<char> border(n, 0);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if (i > 0 && sides[i] == sides[i - 1]) continue;
    if (i + 1 < sides.size() && sides[i] == sides[i + 1]) continue;
    border[sides[i][0]] = border[sides[i][1]] = 1;
  }
  return border;
}

SurfaceUnion::SurfaceUnion(std::vector<Triangle> triangles) : tree_(std::move(triangles)) {
  std::int32_t last = -1;
  for (const Triangle& t : tree_.triangles()) last = std::max({last, t[0], t[1], t[2]});
  is_open_ = border_vertices(tree_.triangles(), static_cast<std::size_t>(last + 1));
}

SurfaceUnion::Verdict SurfaceUnion::judge(const Meeting& m, std::span<const Vec3> x,
                                          const Reach& reach) const {
  Verdict verdict;
  const auto on_border = [&](std::int32_t v) {
    return reach.border.empty() || reach.border[v] != 0;
  };
  if (!std::all_of(m.vertex.begin(), m.vertex.begin() + static_cast<std::ptrdiff_t>(m.size),
                   on_border))
    return verdict;
  const Vec3 p = m.q + m.towards;
  const double distance = m.towards.norm();
  tree_.for_each_near(m.q, reach.tolerance, [&](std::int32_t k) {
    const Triangle& t = tree_.triangles()[k];
    if (verdict.is_wall || m.is_of(t) || std::none_of(t.begin(), t.end(), on_border)) return;
    if (!reach.collides.empty() && reach.collides[reach.surface[t[0]]] == 0) return;
    const ClosestPoints here = point_triangle_closest(m.q, x[t[0]], x[t[1]], x[t[2]]);
    if (here.distance > reach.tolerance) return;
    const Vec3 from = m.q - here.separation;
    if (!m.is_below(from, x[t[0]]) && !m.is_below(from, x[t[1]]) && !m.is_below(from, x[t[2]]))
      return;
    // A face on the far side of p does not carry it.
    const ClosestPoints there = point_triangle_closest(p, x[t[0]], x[t[1]], x[t[2]]);
    if (!(there.separation.dot(m.towards) > 0.0)) return;
    if (there.distance < distance) {
      verdict.is_wall = true;
    } else if (verdict.turned_by < 0 || there.distance < verdict.nearest ||
               (there.distance == verdict.nearest && k < verdict.turned_by)) {
      verdict.nearest = there.distance;
      verdict.turned_by = k;
    }
  });
  return verdict;
}

void SurfaceUnion::turn(ContactPoint& c, const Vec3& normal, std::span<const Vec3> x) {
  const double length = normal.norm();
  if (!(length > 0.0)) return;
  c.normal = normal / (normal.dot(c.normal) < 0.0 ? -length : length);
  c.gap = c.normal.dot(relative(c, x));
}

namespace {

Vec3 normal_at(const Triangle& t, std::span<const Vec3> x) {
  return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
}

}  // namespace

bool SurfaceUnion::is_true_contact(ContactPoint& c, std::span<const Vec3> x,
                                   const Reach& reach) const {
  Meeting m;
  const int first = first_count(c);
  for (int k = first; k < 4; ++k)
    if (-c.weight[k] > kBorder) m.vertex[m.size++] = c.vertex[k];
  if (m.size == 3) return true;  // inside the face
  m.towards = relative(c, x);
  m.q = Vec3::Zero();
  for (int k = first; k < 4; ++k) m.q -= c.weight[k] * x[c.vertex[k]];
  m.slope = c.kind == ContactKind::edge_edge ? kEdgeSlope : kPointSlope;
  // The hems of cloth meet their own faces in folds.
  m.is_open =
      reach.border.empty() && std::ranges::all_of(std::span(m.vertex).first(m.size),
                                                  [&](std::int32_t v) { return is_open_[v] != 0; });
  const Verdict verdict = judge(m, x, reach);
  if (verdict.turned_by >= 0 && !verdict.is_wall)
    turn(c, normal_at(tree_.triangles()[verdict.turned_by], x), x);
  return !verdict.is_wall;
}

}  // namespace selvedge::detail
