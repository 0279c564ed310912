// SPDX-License-Identifier: MIT
// Every fail-safe alone, on one step of generated motion.
#include "fail_safe_trial.h"

#include <gtest/gtest.h>

namespace selvedge {
namespace {

constexpr unsigned kSeeds = 6;

TEST(FailSafe, EachEndsEveryStepOfAFreeSwarmCleanWithItsMomentumAndNoMoreEnergy) {
  for (const auto& [name, make] : fail_safes())
    for (unsigned seed = 1; seed <= kSeeds; ++seed)
      for (const double speed : {0.1, 0.5, 1.0}) {
        SCOPED_TRACE(name + ", seed " + std::to_string(seed));
        Trial trial(swarm(seed, speed));
        const auto fail_safe = make();
        const double share = trial.resolve_halved(*fail_safe);
        ASSERT_GT(share, 0.0) << fail_safe->trouble();
        std::vector<Vec3> end = trial.x_t1;
        trial.aim(share);
        const Vec3 linear = trial.momentum(), angular = trial.angular_momentum();
        const double energy = trial.energy();
        trial.x_t1.swap(end);
        EXPECT_LT((trial.momentum() - linear).norm(), 1e-12 * linear.norm());
        EXPECT_LE(trial.energy(), energy * (1.0 + 1e-12));
        if (name == "projection_zones") {
          EXPECT_LT((trial.angular_momentum() - angular).norm(), 1e-12 * angular.norm());
        }
      }
}

TEST(FailSafe, NoneMovesABodyOrAHeldParticleByOneBit) {
  for (const auto& [name, make] : fail_safes())
    for (unsigned seed = 1; seed <= kSeeds; ++seed)
      for (const bool moving : {false, true}) {
        SCOPED_TRACE(name + ", seed " + std::to_string(seed));
        Trial trial(swarm_with_anchors(seed, 0.6, moving));
        ASSERT_FALSE(trial.hits.empty());
        const auto fail_safe = make();
        const double share = trial.resolve_halved(*fail_safe);
        ASSERT_GT(share, 0.0) << fail_safe->trouble();
        const std::vector<Vec3> after = trial.x_t1;
        trial.aim(share);
        EXPECT_NE(after, trial.x_t1);
        for (std::size_t i = 0; i < after.size(); ++i)
          if (trial.inv_mass[i] == 0.0) {
            EXPECT_EQ(after[i], trial.x_t1[i]) << "vertex " << i;
          }
      }
}

TEST(FailSafe, NoneGainsEnergyAtAStaticBody) {
  for (const auto& [name, make] : fail_safes())
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      SCOPED_TRACE(name + ", seed " + std::to_string(seed));
      Trial trial(swarm_with_anchors(seed, 0.6, false));
      const auto fail_safe = make();
      const double share = trial.resolve_halved(*fail_safe);
      ASSERT_GT(share, 0.0) << fail_safe->trouble();
      const double after = trial.energy();
      trial.aim(share);
      EXPECT_LE(after, trial.energy() * (1.0 + 1e-12));
    }
}

// Closed form: the plate takes the fall p and friction takes mu p of what slides; what is between
// the sheets is internal.
TEST(FailSafe, ProjectionLeavesASlidingStackWhatCoulombDoes) {
  for (const int sheets : {1, 4})
    for (const double mu : {0.0, 0.3}) {
      Stage stage = falling_sheets(sheets, 3, {0.05, 0.0, -0.05});
      stage.friction = mu;
      Trial trial(stage);
      const auto fail_safe = make_projection_zones();
      ASSERT_GT(trial.resolve(*fail_safe), 0);
      const Vec3 left = mean_move(trial, stage.n());
      const double taken = 0.05 + left.z();  // of the fall
      EXPECT_GT(taken, 0.035);
      EXPECT_NEAR(left.x(), 0.05 - mu * taken, 0.01 * 0.05) << sheets << " sheets, mu " << mu;
    }
}

TEST(FailSafe, ClothBetweenJawsThatCloseIsReportedJammedWithItsParticlesAndAnchors) {
  for (const auto& [name, make] : fail_safes()) {
    SCOPED_TRACE(name);
    Stage stage = falling_sheets(1, 3, Vec3::Zero());
    for (const Vec3& x : {Vec3(-1, -1, 0.006), Vec3(0, 2, 0.006), Vec3(1, -1, 0.006)})
      stage.body.vertices.push_back(x);
    stage.body.triangles.push_back({3, 4, 5});
    for (int k = 0; k < 3; ++k) stage.move.push_back(Vec3(0, 0, -0.0061));  // past the other jaw
    Trial trial(stage);
    const auto fail_safe = make();
    EXPECT_EQ(trial.resolve(*fail_safe), -1);
    EXPECT_NE(fail_safe->trouble().find("jammed: "), std::string::npos) << fail_safe->trouble();
    EXPECT_NE(fail_safe->trouble().find(" between body vertex 0 and body vertex "),
              std::string::npos)
        << fail_safe->trouble();
  }
}

}  // namespace
}  // namespace selvedge
