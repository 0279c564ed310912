// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_report.h>
#include <selvedge/data/makers/mannequin.h>

#include <algorithm>
#include <cmath>

namespace selvedge::walking_mannequin_test {
namespace {

const BendingMannequin& figure() {
  static const BendingMannequin made({.faces = 5000});
  return made;
}

MeshReport report_of(const WalkPose& walk) {
  return report_mesh({figure().bent(walk.left, walk.right), figure().triangles()});
}

TEST(WalkingMannequin, StaysClosedAndFreeOfSelfIntersectionsThroughACycle) {
  const double standing = report_of({}).volume;
  const WalkConfig config;
  for (int k = 0; k < 8; ++k) {
    const MeshReport report = report_of(walk_at(config.start + config.cycle * k / 8.0, config));
    EXPECT_EQ(report.self_intersections, 0u) << "phase " << k;
    EXPECT_TRUE(report.closed());
    EXPECT_NEAR(report.volume / standing, 1.0, 0.03) << "phase " << k;
  }
}

TEST(WalkingMannequin, BendsTheKneeAndKeepsTheHead) {
  LimbPose bent;
  bent.knee = 0.8;
  const std::vector<Vec3> standing = figure().bent({}, {}), lifted = figure().bent(bent, {});
  double head = 0.0, foot = 0.0;
  for (std::size_t i = 0; i < standing.size(); ++i) {
    const double moved = (lifted[i] - standing[i]).norm();
    if (standing[i].z() > 1.0) head = std::max(head, moved);
    if (standing[i].z() < 0.1 && standing[i].x() > 0.0) foot = std::max(foot, moved);
  }
  EXPECT_LT(head, 1e-3) << "but for the soles, which differ a little";
  EXPECT_GT(foot, 0.25);
}

TEST(WalkingMannequin, ComesForwardByItsStridesAndStartsGently) {
  const WalkConfig config;
  EXPECT_EQ(walk_at(-0.5).way, 0.0);
  const double cycle = walk_at(5.0 + config.cycle).way - walk_at(5.0).way;
  EXPECT_NEAR(cycle, 4.0 * 0.88 * std::sin(config.stride), 1e-12);
  constexpr double small = 1e-4;
  EXPECT_LT(walk_at(small).way / small, 1e-3) << "m/s at the first moment";
  const double before = walk_at(config.start - small).way,
               after = walk_at(config.start + small).way;
  EXPECT_NEAR((after - before) / (2.0 * small), cycle / config.cycle, 1e-3);
}

TEST(WalkingMannequin, RefusesAStrideThatWouldFoldIt) {
  EXPECT_THROW(walk_at(0.0, {.stride = 0.6}), std::invalid_argument);
  EXPECT_THROW(walk_at(0.0, {.stride = std::nan("")}), std::invalid_argument);
  EXPECT_THROW(walk_at(0.0, {.cycle = 0.0}), std::invalid_argument);
}

}  // namespace
}  // namespace selvedge::walking_mannequin_test
