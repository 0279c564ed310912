// SPDX-License-Identifier: MIT
#include <selvedge/simulation/contacts/detail/body_search.h>

#include <algorithm>
#include <limits>
#include <numbers>

namespace selvedge::detail {
namespace {

/// Whether a detector accepts the matrix as a rotation, with some tolerance to spare.
bool is_rotation(const Mat3& r) {
  constexpr double kOrthonormal = 0x1p-44;
  return (r.transpose() * r - Mat3::Identity()).cwiseAbs().maxCoeff() <= kOrthonormal &&
         r.col(0).cross(r.col(1)).dot(r.col(2)) > 0.0;
}

bool never_moves(const Body& body) {
  constexpr double kEver = std::numeric_limits<double>::max();
  return body.is_static(-kEver, kEver);
}

template <class Pair>
void append_sorted(const std::vector<Pair>& from, std::vector<Pair>& to) {
  const auto middle = static_cast<std::ptrdiff_t>(to.size());
  to.insert(to.end(), from.begin(), from.end());
  std::inplace_merge(to.begin(), to.begin() + middle, to.end());
}

}  // namespace

BodySearch::BodySearch(std::span<const std::unique_ptr<Body>> bodies, std::size_t cloth_triangles,
                       const Make& make)
    : bodies_(bodies), vertex_begin_(1, 0), triangle_begin_(1, 0) {
  std::vector<Triangle> joint;
  for (const auto& body : bodies_) {
    const std::int32_t first = vertex_begin_.back();
    for (const Triangle& t : body->triangles())
      joint.push_back({t[0] + first, t[1] + first, t[2] + first});
    vertex_begin_.push_back(first + static_cast<std::int32_t>(body->vertex_count()));
    triangle_begin_.push_back(static_cast<std::int32_t>(joint.size()));
  }
  joint_edges_ = unique_edges(joint);
  std::vector<std::size_t> resting, moving;
  const BroadPhaseTraits traits = make()->traits();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (traits.particles) {
      add_group(make, {b}, false);
      continue;
    }
    if (never_moves(*bodies_[b])) {
      resting.push_back(b);
      continue;
    }
    // In the frame of a rigid body the tree of the cloth has to be fitted instead of the body's.
    const bool pays = traits.rigid && bodies_[b]->pose(0.0).has_value() &&
                      bodies_[b]->triangles().size() > cloth_triangles;
    if (pays)
      add_group(make, {b}, true);
    else
      moving.push_back(b);
  }
  for (auto* rest : {&resting, &moving})
    if (!rest->empty()) add_group(make, std::move(*rest), false);
}

void BodySearch::add_group(const Make& make, std::vector<std::size_t> bodies, bool is_rigid) {
  Group group;
  group.detector = make();
  group.is_rigid = is_rigid;
  for (const std::size_t b : bodies) {
    const std::int32_t first = vertex_begin_[b];
    const auto shift = static_cast<std::int32_t>(group.vertices.size()) - first;
    for (std::int32_t v = first; v < vertex_begin_[b + 1]; ++v) group.vertices.push_back(v);
    for (std::int32_t t = triangle_begin_[b]; t < triangle_begin_[b + 1]; ++t)
      group.triangles.push_back(t);
    for (const Triangle& t : bodies_[b]->triangles())
      group.own_triangles.push_back(
          {t[0] + first + shift, t[1] + first + shift, t[2] + first + shift});
    // Edges are sorted by their lesser vertex, so that those of one body are consecutive.
    const auto from = std::lower_bound(joint_edges_.begin(), joint_edges_.end(), Edge{first, 0});
    for (auto e = from; e != joint_edges_.end() && (*e)[0] < vertex_begin_[b + 1]; ++e) {
      group.edges.push_back(static_cast<std::int32_t>(e - joint_edges_.begin()));
      group.own_edges.push_back({(*e)[0] + shift, (*e)[1] + shift});
    }
  }
  group.motion.id = bodies.front() + 1;
  group.bodies = std::move(bodies);
  groups_.push_back(std::move(group));
}

std::size_t BodySearch::rigid_groups() const {
  return static_cast<std::size_t>(
      std::count_if(groups_.begin(), groups_.end(), [](const Group& g) { return g.is_rigid; }));
}

void BodySearch::set_motion(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1, bool move,
                            const std::optional<StepTimes>& times) {
  x_t0_ = x_t0;
  x_t1_ = x_t1;
  for (Group& group : groups_) set_motion(group, move, times);
}

void BodySearch::set_motion(Group& group, bool move, const std::optional<StepTimes>& times) {
  const bool moves =
      times
          ? std::any_of(group.bodies.begin(), group.bodies.end(),
                        [&](std::size_t b) { return !bodies_[b]->is_static(times->t0, times->t1); })
          : move;
  if (moves || group.moves) {
    ++group.static_id;  // the step after a motion starts elsewhere
    group.x_t0.clear();
  }
  group.moves = moves;
  group.promises = false;
  if (!moves || !group.is_rigid || !times) return;
  const Body& body = *bodies_[group.bodies.front()];
  group.motion.t0 = body.pose(times->t0).value();
  group.motion.t1 = body.pose(times->t1).value();
  group.promises = is_rotation(group.motion.t0.rotation) && is_rotation(group.motion.t1.rotation);
}

void BodySearch::gather(Group& group) const {
  if (groups_.size() == 1 || !group.x_t0.empty()) return;
  group.x_t0.resize(group.vertices.size());
  group.x_t1.resize(group.vertices.size());
  for (std::size_t i = 0; i < group.vertices.size(); ++i) {
    group.x_t0[i] = x_t0_[group.vertices[i]];
    group.x_t1[i] = x_t1_[group.vertices[i]];
  }
}

SurfaceView BodySearch::view(const Group& group, double thickness) const {
  const bool alone = groups_.size() == 1;
  return {alone ? x_t0_ : std::span<const Vec3>(group.x_t0),
          alone ? x_t1_ : std::span<const Vec3>(group.x_t1),
          group.own_edges,
          group.own_triangles,
          thickness,
          group.moves ? 0 : group.static_id,
          group.promises ? &group.motion : nullptr};
}

void BodySearch::renumber(const Group& group, CandidatePairs& pairs) {
  for (PointTrianglePair& p : pairs.point_triangle) p.triangle = group.triangles[p.triangle];
  for (PointTrianglePair& p : pairs.triangle_point) p.point = group.vertices[p.point];
  for (EdgeEdgePair& p : pairs.edge_edge) p.edge_b = group.edges[p.edge_b];
}

bool BodySearch::by_distance(const Group& group) {
  return group.promises || group.detector->traits().pairs == PairSet::culled;
}

bool BodySearch::compares_boxes() const { return std::ranges::none_of(groups_, by_distance); }

void BodySearch::find_pairs(const SurfaceView& cloth, double margin, double thickness,
                            CandidatePairs& out) {
  out.clear();
  for (Group& group : groups_) {
    gather(group);
    // The margin is that of boxes; a search by distance needs the diagonal.
    SurfaceView inflated = cloth;
    inflated.thickness += by_distance(group) ? std::numbers::sqrt3 * margin : margin;
    const SurfaceView body = view(group, thickness);
    if (groups_.size() == 1) {
      group.detector->find_pairs(inflated, body, out);
      return;
    }
    group.detector->find_pairs(inflated, body, found_);
    renumber(group, found_);
    append_sorted(found_.point_triangle, out.point_triangle);
    append_sorted(found_.triangle_point, out.triangle_point);
    append_sorted(found_.edge_edge, out.edge_edge);
  }
}

void BodySearch::find_particle_contacts(const SurfaceView& cloth, double reach,
                                        std::vector<ParticleContact>& out) {
  out.clear();
  for (Group& group : groups_) {
    gather(group);
    group.detector->find_particle_contacts(cloth, view(group, 0.0), reach, found_contacts_);
    for (ParticleContact& c : found_contacts_) c.pair.triangle = group.triangles[c.pair.triangle];
    out.insert(out.end(), found_contacts_.begin(), found_contacts_.end());
  }
}

}  // namespace selvedge::detail
