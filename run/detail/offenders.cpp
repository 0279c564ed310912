// SPDX-License-Identifier: MIT
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/narrowphase/query_file.h>
#include <selvedge/run/detail/offenders.h>
#include <selvedge/run/detail/run_folder.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>

#include <algorithm>
#include <span>
#include <vector>

namespace selvedge::detail {
namespace {

namespace fs = std::filesystem;

// Largest number of candidates of each list that are kept beside the colliding pairs.
constexpr std::size_t kNeighbours = 500;

using Primitive = std::vector<std::int32_t>;  // one to three vertices

/// The two primitives of each pair, or the particle whose position is not finite.
std::vector<Primitive> offending_primitives(const RejectedAttempt& failed) {
  std::vector<Primitive> primitives;
  for (const ContactPoint& c : failed.pairs) {
    const auto middle = c.vertex.begin() + (c.kind == ContactKind::edge_edge ? 2 : 1);
    primitives.emplace_back(c.vertex.begin(), middle);
    primitives.emplace_back(middle, c.vertex.end());
  }
  if (failed.not_finite >= 0) primitives.push_back({failed.not_finite});
  return primitives;
}

bool contains(const Triangle& triangle, const Primitive& primitive) {
  return std::all_of(primitive.begin(), primitive.end(), [&](auto v) {
    return std::find(triangle.begin(), triangle.end(), v) != triangle.end();
  });
}

/// The cloth, or the bodies, in the joint index space of ContactPoint.
struct Side {
  std::span<const Triangle> triangles;
  std::int32_t first;  ///< added to their indices, it gives joint ones
};

/// The triangles with an offending primitive as corner, edge or face; joint indices.
std::vector<Triangle> triangles_at(const Side& side, const std::vector<Primitive>& primitives,
                                   std::size_t vertices) {
  std::vector<std::vector<std::size_t>> at(vertices);  // primitives by their first vertex
  for (std::size_t i = 0; i < primitives.size(); ++i) at[primitives[i][0]].push_back(i);
  std::vector<Triangle> chosen;
  for (const Triangle& t : side.triangles) {
    const Triangle joint{t[0] + side.first, t[1] + side.first, t[2] + side.first};
    const bool offends = std::any_of(joint.begin(), joint.end(), [&](auto v) {
      return std::any_of(at[v].begin(), at[v].end(),
                         [&](auto i) { return contains(joint, primitives[i]); });
    });
    if (offends) chosen.push_back(joint);
  }
  return chosen;
}

bool all_finite(std::span<const Vec3> x) {
  return std::all_of(x.begin(), x.end(), [](const Vec3& p) { return p.allFinite(); });
}

/// Writes the triangles at both times. Each vertex has its index in its piece or body, the index of
/// that piece or body, and whether it belongs to an offending primitive.
void write_meshes(const fs::path& folder, const char* stem, const std::vector<Triangle>& triangles,
                  const std::vector<Primitive>& primitives, const Simulation& simulation) {
  std::vector<std::int32_t> vertices;
  for (const Triangle& t : triangles) vertices.insert(vertices.end(), t.begin(), t.end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  const auto compact = [&](std::int32_t v) {
    return static_cast<std::int32_t>(std::lower_bound(vertices.begin(), vertices.end(), v) -
                                     vertices.begin());
  };
  std::vector<Triangle> own;
  for (const Triangle& t : triangles) own.push_back({compact(t[0]), compact(t[1]), compact(t[2])});
  std::vector<NamedValues> values = {{"vertex", {}}, {"owner", {}}, {"collides", {}}};
  const VertexNames& names = simulation.names();
  for (const std::int32_t v : vertices) {
    values[0].values.push_back(names.local(v));
    values[1].values.push_back(static_cast<double>(names.owner_index(v)));
  }
  values[2].values.assign(vertices.size(), 0.0);
  for (const Primitive& primitive : primitives)
    for (const std::int32_t v : primitive)
      if (std::binary_search(vertices.begin(), vertices.end(), v))
        values[2].values[compact(v)] = 1.0;
  const RejectedAttempt& failed = simulation.last_step().rejected;
  int number = 0;
  for (const auto* x : {&failed.x_t0, &failed.x_t1}) {
    std::vector<Vec3> points;
    for (const std::int32_t v : vertices) points.push_back((*x)[v]);
    const std::string name = std::string(stem) + (number++ == 0 ? "_00000.ply" : "_00001.ply");
    if (all_finite(points)) write_ply(folder / name, points, own, values);
  }
}

Query query_of(const ContactPoint& c, const RejectedAttempt& failed) {
  Query query;
  query.kind = c.kind == ContactKind::edge_edge ? c.kind : ContactKind::point_triangle;
  for (int k = 0; k < 4; ++k) {
    query.x_t0[k] = failed.x_t0[c.vertex[k]];
    query.x_t1[k] = failed.x_t1[c.vertex[k]];
  }
  return query;
}

/// Keeps the first kNeighbours pairs that satisfy `wanted`.
template <class Pair, class Wanted>
void thin(std::vector<Pair>& pairs, const Wanted& wanted) {
  std::erase_if(pairs, [&](const Pair& p) { return !wanted(p); });
  if (pairs.size() > kNeighbours) pairs.resize(kNeighbours);
}

/// Candidates with an offending vertex.
class Neighbourhood {
 public:
  Neighbourhood(const Simulation& simulation, const std::vector<Primitive>& primitives)
      : failed_(simulation.last_step().rejected),
        particles_(simulation.state().x.size()),
        cloth_(make_side(simulation.cloth_triangles(), 0, particles_)),
        body_(make_side(simulation.body_triangles(), particles_, failed_.x_t0.size())),
        offends_(failed_.x_t0.size(), false) {
    for (const Primitive& primitive : primitives)
      for (const std::int32_t v : primitive) offends_[v] = true;
  }

  void record(QueryRecorder& recorder) {
    const auto broad = make_bvh_aabb();
    CandidatePairs pairs;
    broad->find_self_pairs(cloth_.view, pairs);
    add(pairs, cloth_, 0, cloth_, 0, recorder);
    if (body_.view.triangles.empty()) return;
    broad->find_pairs(cloth_.view, body_.view, pairs);
    add(pairs, cloth_, 0, body_, particles_, recorder);
  }

 private:
  struct Surface {
    std::vector<Edge> edges;
    SurfaceView view;
  };

  Surface make_side(std::span<const Triangle> triangles, std::size_t begin, std::size_t end) const {
    Surface side{unique_edges(triangles), {}};
    side.view.x_t0 = std::span(failed_.x_t0).subspan(begin, end - begin);
    side.view.x_t1 = std::span(failed_.x_t1).subspan(begin, end - begin);
    side.view.triangles = triangles;
    side.view.edges = side.edges;
    return side;
  }

  template <std::size_t N>
  bool offends(const std::array<std::int32_t, N>& vertices, std::size_t first) const {
    return std::any_of(vertices.begin(), vertices.end(),
                       [&](auto v) { return offends_[first + static_cast<std::size_t>(v)]; });
  }

  void add(CandidatePairs& pairs, const Surface& a, std::size_t first_a, const Surface& b,
           std::size_t first_b, QueryRecorder& recorder) const {
    const auto point = [](std::int32_t v) { return std::array{v}; };
    thin(pairs.point_triangle, [&](const PointTrianglePair& p) {
      return offends(point(p.point), first_a) || offends(b.view.triangles[p.triangle], first_b);
    });
    thin(pairs.triangle_point, [&](const PointTrianglePair& p) {
      return offends(point(p.point), first_b) || offends(a.view.triangles[p.triangle], first_a);
    });
    thin(pairs.edge_edge, [&](const EdgeEdgePair& p) {
      return offends(a.edges[p.edge_a], first_a) || offends(b.edges[p.edge_b], first_b);
    });
    recorder.add(a.view, b.view, pairs);
  }

  const RejectedAttempt& failed_;
  std::size_t particles_;
  Surface cloth_, body_;
  std::vector<bool> offends_;
};

}  // namespace

void write_offenders(const fs::path& folder, const Simulation& simulation) {
  const RejectedAttempt& failed = simulation.last_step().rejected;
  const std::vector<Primitive> primitives = offending_primitives(failed);
  if (primitives.empty()) return;
  const std::size_t vertices = failed.x_t0.size();
  const auto first = static_cast<std::int32_t>(simulation.state().x.size());
  const auto cloth = triangles_at({simulation.cloth_triangles(), 0}, primitives, vertices);
  const auto body = triangles_at({simulation.body_triangles(), first}, primitives, vertices);
  make_folder(folder / "frames");
  write_meshes(folder / "frames", "cloth", cloth, primitives, simulation);
  if (!body.empty()) write_meshes(folder / "frames", "bodies", body, primitives, simulation);
  if (!all_finite(failed.x_t1)) return;
  make_folder(folder / "queries");
  QueryRecorder recorder({folder / "queries", 0});
  for (const ContactPoint& c : failed.pairs) recorder.add(query_of(c, failed));
  Neighbourhood(simulation, primitives).record(recorder);
  recorder.write();
}

}  // namespace selvedge::detail
