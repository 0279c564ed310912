// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/detail/error_bounds.h>
#include <selvedge/narrowphase/detail/in_plane.h>
#include <selvedge/narrowphase/detail/quadratic.h>

#include <algorithm>
#include <array>
#include <cmath>

// The four vertices lie in one plane at each time. If component i of a normal of that plane is not
// zero at any time, the projection along axis i maps the plane one to one at each time, and the
// primitives touch iff their projections do. Two sets in a plane that do not touch at t = 0 touch
// first where an end point of one of two edges lies on the other, or where the point lies on a side
// of the triangle. So the first contact is that of a vertex and an edge in the projection, and this
// again is a contact of two edges in space: the edge, and one parallel to axis i through the
// vertex.

namespace selvedge::detail {
namespace {

/// A vertex and the ends of an edge.
struct VertexEdge {
  int vertex, tail, head;
};
constexpr std::array<VertexEdge, 4> kOfEdges{{{0, 2, 3}, {1, 2, 3}, {2, 0, 1}, {3, 0, 1}}};
constexpr std::array<VertexEdge, 3> kOfPointTriangle{{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}};

/// The axis along which a normal of the plane certainly has a component during the whole step, as
/// large as possible; -1 if there is none.
int certain_axis(const std::array<Motion, 3>& differences) {
  int axis = -1;
  double best = kConstraintError * kRoundoff;
  for (int k = 0; k < 3; ++k) {
    const Motion &a = differences[k], &b = differences[(k + 1) % 3];
    const double size = a.largest() * b.largest();
    for (int i = 0; i < 3; ++i) {
      const Quadratic n = cross_component(a, b, i);
      const double least = std::max(std::min({n.b0, n.b1, n.b2}), -std::max({n.b0, n.b1, n.b2}));
      if (least > best * size) best = least / size, axis = i;
    }
  }
  return axis;
}

/// The contact of a vertex and an edge in the projection along `axis`, as a query of two edges. The
/// first extends by `reach` to both sides of the plane in which the second lies.
Query projected(const Query& query, const VertexEdge& pair, int axis, double reach) {
  Query out{ContactKind::edge_edge, {}, {}};
  const auto project = [&](const std::array<Vec3, 4>& x, std::array<Vec3, 4>& y) {
    y = {x[pair.vertex], x[pair.vertex], x[pair.tail], x[pair.head]};
    y[0][axis] = -reach, y[1][axis] = reach;
    y[2][axis] = y[3][axis] = 0.0;
  };
  project(query.x_t0, out.x_t0);
  project(query.x_t1, out.x_t1);
  return out;
}

}  // namespace

ContactDecision first_contact_in_plane(const FilterKernel& kernel, const Query& query,
                                       double& toi) {
  const auto difference = [&](int head) {
    return Motion{query.x_t0[head] - query.x_t0[0], query.x_t1[head] - query.x_t1[0]};
  };
  const std::array<Motion, 3> differences{difference(1), difference(2), difference(3)};
  double size = 0.0;
  for (const Motion& d : differences) size = std::max(size, d.largest());
  if (!(size > kSmallest && size < kLargest)) return ContactDecision::open;
  const int axis = certain_axis(differences);
  if (axis < 0) return ContactDecision::open;

  const double reach = std::ldexp(1.0, std::ilogb(size));
  std::array<Query, 4> events;
  std::size_t n = 0;
  const auto add = [&](const VertexEdge& pair) {
    events[n++] = projected(query, pair, axis, reach);
  };
  if (query.kind == ContactKind::edge_edge)
    std::for_each(kOfEdges.begin(), kOfEdges.end(), add);
  else
    std::for_each(kOfPointTriangle.begin(), kOfPointTriangle.end(), add);

  QueryBlock block;
  for (std::size_t j = 0; j < block.size(); ++j) block[j] = &events[std::min(j, n - 1)];
  std::array<double, kFilterBlock> times;
  const std::uint32_t apart =
      kernel.separated_on_axes(block, true) | kernel.never_coplanar(block, true);
  const std::uint32_t decided = kernel.decided_at_simple_roots(block, true, times);
  double first = kNoCollision;
  for (std::size_t j = 0; j < n; ++j) {
    if ((apart >> j & 1U) != 0) continue;
    if ((decided >> j & 1U) == 0) {
      bool is_exact = false;
      const ContactDecision decision = isolate_contact(events[j], times[j], is_exact);
      if (decision == ContactDecision::open) return decision;
      if (decision == ContactDecision::no) continue;
    }
    first = std::min(first, times[j]);
  }
  toi = first;
  return first <= 1.0 ? ContactDecision::yes : ContactDecision::no;
}

}  // namespace selvedge::detail
