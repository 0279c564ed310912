// SPDX-License-Identifier: MIT
// Every detector on steps of two real simulations, which lie beside the project where they are
// lent: none that says it misses nothing may miss a pair that the exact narrow phase finds.
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/types.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/scene/methods.h>

#include <algorithm>
#include <filesystem>
#include <iostream>

namespace selvedge::real_frames_test {
namespace {

struct Step {
  std::vector<Vec3> x_t0, x_t1;
  std::vector<Edge> edges;
  std::vector<Triangle> triangles;

  SurfaceView view() const { return {x_t0, x_t1, edges, triangles, 0.0, 0}; }
};

Step load_step(const std::filesystem::path& from, const std::filesystem::path& to) {
  const TriangleMesh start = load_mesh(from), end = load_mesh(to);
  return {start.vertices, end.vertices, unique_edges(start.triangles), start.triangles};
}

template <class Pair>
std::size_t missing(const std::vector<Pair>& wanted, const std::vector<Pair>& found) {
  return static_cast<std::size_t>(std::count_if(wanted.begin(), wanted.end(), [&](const Pair& p) {
    return !std::binary_search(found.begin(), found.end(), p);
  }));
}

/// Of the pairs, those that collide.
CandidatePairs colliding(const Step& step, const CandidatePairs& pairs) {
  const auto exact = make_ccd_exact();
  const auto collides = [&](const Query& query) {
    double toi = 0.0;
    return exact->collides(query, toi);
  };
  const auto corners = [&](const std::array<std::int32_t, 4>& v, ContactKind kind) {
    Query query{kind, {}, {}};
    for (int k = 0; k < 4; ++k) {
      query.x_t0[k] = step.x_t0[v[k]];
      query.x_t1[k] = step.x_t1[v[k]];
    }
    return query;
  };
  CandidatePairs out;
  for (const PointTrianglePair& p : pairs.point_triangle) {
    const Triangle& t = step.triangles[p.triangle];
    if (collides(corners({p.point, t[0], t[1], t[2]}, ContactKind::point_triangle)))
      out.point_triangle.push_back(p);
  }
  for (const EdgeEdgePair& p : pairs.edge_edge) {
    const Edge &e = step.edges[p.edge_a], &f = step.edges[p.edge_b];
    if (collides(corners({e[0], e[1], f[0], f[1]}, ContactKind::edge_edge)))
      out.edge_edge.push_back(p);
  }
  return out;
}

/// The step of one simulation; `collisions`: how many there are.
void expect_nothing_missed(const char* simulation, const char* from, const char* to,
                           std::size_t collisions) {
  const std::filesystem::path folder =
      std::filesystem::path(SELVEDGE_SOURCE_DIR) / "../shared/data/frames" / simulation;
  if (!std::filesystem::exists(folder / from))
    GTEST_SKIP() << "the frames of " << simulation << " do not lie beside the project";
  const Step step = load_step(folder / from, folder / to);
  CandidatePairs boxes, found;
  make_bvh_aabb()->find_self_pairs(step.view(), boxes);
  const CandidatePairs exact = colliding(step, boxes);
  EXPECT_EQ(exact.size(), collisions);
  for (const auto& [name, make] : methods_of_this_build().broad_phases) {
    const auto detector = make();
    const BroadPhaseTraits traits = detector->traits();
    const bool serves = traits.self && traits.deforming && !traits.closed_body_only;
    // Brute force would take a minute.
    if (!serves || traits.guarantee == Guarantee::approximate || name == "brute_force") continue;
    detector->find_self_pairs(step.view(), found);
    const std::size_t missed = missing(exact.point_triangle, found.point_triangle) +
                               missing(exact.edge_edge, found.edge_edge);
    EXPECT_EQ(missed, 0u) << name << " misses that many of " << exact.size();
    if (traits.pairs == PairSet::boxes) {
      EXPECT_EQ(found.point_triangle, boxes.point_triangle) << name;
      EXPECT_EQ(found.edge_edge, boxes.edge_edge) << name;
    }
    std::cout << name << ": " << found.size() << " pairs, " << missed << " missed\n";
  }
}

}  // namespace

TEST(RealFrames, NoConservativeDetectorMissesACollisionOfTwistedRods) {
  expect_nothing_missed("rod-twist", "3036.ply", "3037.ply", 4944);
}

TEST(RealFrames, NoConservativeDetectorMissesACollisionOfClothInAFunnel) {
  expect_nothing_missed("cloth-funnel", "227.ply", "228.ply", 134);
}

}  // namespace selvedge::real_frames_test
