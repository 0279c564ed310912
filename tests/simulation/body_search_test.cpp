// SPDX-License-Identifier: MIT
// The bodies of a scene in groups against all of them as one surface.
#include <gtest/gtest.h>
#include <selvedge/core/base/types.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/simulation/contacts/detail/body_search.h>

#include <cmath>
#include <numbers>

namespace selvedge::body_search_test {
namespace {

/// A rough ball; `rings` rings of as many sectors.
TriangleMesh ball(int rings, const Vec3& middle, double radius) {
  TriangleMesh mesh;
  for (int j = 0; j <= rings; ++j)
    for (int i = 0; i < rings; ++i) {
      const double polar = std::numbers::pi * (0.02 + 0.96 * j / rings);
      const double turn = 2.0 * std::numbers::pi * i / rings;
      const double r = radius * (1.0 + 0.1 * std::sin(5.0 * turn));
      mesh.vertices.push_back(middle + r * Vec3(std::sin(polar) * std::cos(turn),
                                                std::sin(polar) * std::sin(turn), std::cos(polar)));
    }
  for (int j = 0; j < rings; ++j)
    for (int i = 0; i < rings; ++i) {
      const int k = (i + 1) % rings, a = j * rings, b = a + rings;
      mesh.triangles.push_back({a + i, b + i, b + k});
      mesh.triangles.push_back({a + i, b + k, a + k});
    }
  return mesh;
}

/// A sheet that falls through everything, one body that stands, a large one that turns, a small
/// one that moves, one that changes its shape.
struct Stage {
  std::vector<std::unique_ptr<Body>> bodies;
  std::vector<Triangle> sheet, joint;
  std::vector<Edge> sheet_edges, joint_edges;
  std::vector<Vec3> cloth_t0, cloth_t1, x_t0, x_t1;
  double thickness = 0.01;

  Stage() {
    const auto turn = [](double angle) {
      return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3(1.0, 2.0, 0.5).normalized()));
    };
    bodies.push_back(make_keyframed_body(ball(6, Vec3::Zero(), 0.1),
                                         {{0.0, Vec3(0.7, 0.5, 0.0)}, {1.0, Vec3(0.7, 0.5, 0.3)}}));
    bodies.push_back(make_static_body(ball(10, Vec3(0.2, 0.3, 0.0), 0.2)));
    bodies.push_back(
        make_keyframed_body(ball(20, Vec3::Zero(), 0.3), {{0.0, Vec3(0.5, 0.5, 0.0)},
                                                          {0.5, Vec3(0.5, 0.5, 0.0)},
                                                          {1.5, Vec3(0.6, 0.4, 0.1), turn(2.0)}}));
    bodies.push_back(make_sequence_body(
        {ball(5, Vec3(0.8, 0.2, 0.0), 0.1), ball(5, Vec3(0.8, 0.2, 0.1), 0.15)}, 1.0, 0.0));
    bodies.push_back(make_static_body(ball(4, Vec3(0.9, 0.9, 0.0), 0.1)));
    std::int32_t first = 0;
    for (const auto& body : bodies) {
      for (const Triangle& t : body->triangles())
        joint.push_back({t[0] + first, t[1] + first, t[2] + first});
      first += static_cast<std::int32_t>(body->vertex_count());
    }
    joint_edges = unique_edges(joint);
    x_t0.resize(static_cast<std::size_t>(first));
    x_t1.resize(x_t0.size());
    constexpr int n = 15;
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i)
        cloth_t1.push_back({static_cast<double>(i) / n, static_cast<double>(j) / n, 0.35});
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = j * (n + 1) + i, b = a + n + 1;
        sheet.push_back({a, a + 1, b + 1});
        sheet.push_back({a, b + 1, b});
      }
    sheet_edges = unique_edges(sheet);
  }

  void go(double t0, double t1) {
    std::size_t first = 0;
    for (const auto& body : bodies) {
      body->positions(t0, std::span(x_t0).subspan(first, body->vertex_count()));
      body->positions(t1, std::span(x_t1).subspan(first, body->vertex_count()));
      first += body->vertex_count();
    }
    cloth_t0 = cloth_t1;
    for (Vec3& x : cloth_t1) x.z() -= 0.5 * (t1 - t0) * (1.0 + 0.5 * std::sin(9.0 * x.x()));
  }
  SurfaceView cloth() const { return {cloth_t0, cloth_t1, sheet_edges, sheet}; }
  SurfaceView all_bodies() const { return {x_t0, x_t1, joint_edges, joint, thickness}; }
};

std::vector<std::array<std::int32_t, 5>> contacts(const Stage& stage, const CandidatePairs& pairs) {
  std::vector<Contact> found;
  make_ccd_exact()->find_contacts(stage.cloth(), stage.all_bodies(), pairs, found);
  std::vector<std::array<std::int32_t, 5>> out;
  for (const Contact& c : found)
    out.push_back(
        {static_cast<std::int32_t>(c.kind), c.vertex[0], c.vertex[1], c.vertex[2], c.vertex[3]});
  return out;
}

bool same(const CandidatePairs& a, const CandidatePairs& b) {
  return a.point_triangle == b.point_triangle && a.triangle_point == b.triangle_point &&
         a.edge_edge == b.edge_edge;
}

}  // namespace

TEST(BodySearch, FindsTheContactsOfAllBodiesAsOneSurfaceWithEveryDetector) {
  for (const auto& [name, make] : broad_phases()) {
    const BroadPhaseTraits traits = make()->traits();
    if (traits.guarantee == Guarantee::approximate || traits.closed_body_only) continue;
    Stage stage;
    detail::BodySearch search(stage.bodies, stage.sheet.size(), make);
    CandidatePairs found, all;
    std::size_t hits = 0;
    for (int step = 0; step < 10; ++step) {
      const double t0 = 0.15 * step, t1 = t0 + 0.15;
      stage.go(t0, t1);
      search.set_motion(stage.x_t0, stage.x_t1, true, detail::StepTimes{t0, t1});
      search.find_pairs(stage.cloth(), 0.02, stage.thickness, found);
      SurfaceView cloth = stage.cloth();
      cloth.thickness = 0.02;
      make_brute_force()->find_pairs(cloth, stage.all_bodies(), all);
      const auto right = contacts(stage, all);
      EXPECT_EQ(contacts(stage, found), right) << name << ", step " << step;
      if (!traits.rigid && traits.pairs == PairSet::boxes) {
        EXPECT_TRUE(same(found, all)) << name << ", step " << step;
      }
      hits += right.size();
    }
    EXPECT_GT(hits, 300u);
  }
}

TEST(BodySearch, LargeRigidBodiesAreAGroupOfTheirOwn) {
  const Stage stage;
  const detail::BodySearch trees(stage.bodies, stage.sheet.size(), [] { return make_bvh_aabb(); });
  EXPECT_EQ(trees.groups(), 3u);  // the resting, the large one, the others
  EXPECT_EQ(trees.rigid_groups(), 1u);
  const detail::BodySearch grids(stage.bodies, stage.sheet.size(),
                                 [] { return make_uniform_grid(); });
  EXPECT_EQ(grids.groups(), 2u);
  EXPECT_EQ(grids.rigid_groups(), 0u);
  const detail::BodySearch large_cloth(stage.bodies, 100000, [] { return make_bvh_aabb(); });
  EXPECT_EQ(large_cloth.rigid_groups(), 0u);
}

TEST(BodySearch, WithoutTimesAnyBodyMayHaveMoved) {
  Stage stage;
  detail::BodySearch search(stage.bodies, stage.sheet.size(), [] { return make_bvh_aabb(); });
  CandidatePairs found, all;
  stage.go(0.0, 0.1);
  for (int step = 0; step < 3; ++step) {
    for (auto* xs : {&stage.x_t0, &stage.x_t1})
      for (Vec3& x : *xs) x.z() += 0.1;
    search.set_motion(stage.x_t0, stage.x_t1, true, {});
    search.find_pairs(stage.cloth(), 0.0, stage.thickness, found);
    make_brute_force()->find_pairs(stage.cloth(), stage.all_bodies(), all);
    EXPECT_TRUE(same(found, all)) << "step " << step;
    EXPECT_GT(all.size(), 0u);
  }
}

TEST(BodySearch, ASceneWithoutBodiesHasNoPairs) {
  const Stage stage;
  detail::BodySearch search({}, stage.sheet.size(), [] { return make_bvh_aabb(); });
  CandidatePairs found;
  found.edge_edge.push_back({1, 2});
  search.set_motion({}, {}, false, {});
  search.find_pairs(stage.cloth(), 0.01, 0.01, found);
  EXPECT_EQ(found.size(), 0u);
}

}  // namespace selvedge::body_search_test
