// SPDX-License-Identifier: MIT
// Every fail-safe alone, on one step of generated motion.
#include "fail_safe_trial.h"

#include <gtest/gtest.h>
#include <selvedge/narrowphase/distance.h>
#include <selvedge/response/detail/reference_motion.h>
#include <selvedge/response/detail/separating_planes.h>

namespace selvedge::fail_safe_test {
namespace {

using namespace detail;

constexpr unsigned kSeeds = 6;

TEST(FailSafe, EachEndsAFreeSwarmCleanWithItsMomentum) {
  for (const auto& [name, make] : fail_safes())
    for (unsigned seed = 1; seed <= kSeeds; ++seed)
      for (const double speed : {0.1, 0.5, 1.0}) {
        SCOPED_TRACE(name + ", seed " + std::to_string(seed));
        Trial trial(swarm(seed, speed));
        const auto fail_safe = make();
        const double share = trial.resolve_halved(*fail_safe);
        ASSERT_GT(share, 0.0) << fail_safe->failure_reason();
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
        ASSERT_GT(share, 0.0) << fail_safe->failure_reason();
        const std::vector<Vec3> after = trial.x_t1;
        trial.aim(share);
        EXPECT_NE(after, trial.x_t1);
        for (std::size_t i = 0; i < after.size(); ++i)
          if (trial.inv_mass[i] == 0.0) {
            EXPECT_EQ(after[i], trial.x_t1[i]) << "vertex " << i;
          }
      }
}

TEST(ReferenceMotion, AnchorsOnALineDoNotSpinAboutIt) {
  std::mt19937 random(3);
  const auto draw = [&] { return static_cast<double>(random()) / 4294967296.0 - 0.5; };
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3 line = Vec3(draw(), draw(), draw()).normalized(), middle(draw(), draw(), draw());
    const Vec3 axis = line.cross(Vec3(draw(), draw(), draw())).normalized();
    const double angle = 0.4 * draw();  // rad
    const Mat3 turn = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    std::vector<Vec3> x_t0, x_t1;
    std::vector<std::int32_t> anchors;
    for (int k = 0; k < 2 + trial % 6; ++k) {
      anchors.push_back(k);
      x_t0.push_back(middle + 0.01 * k * line);
      x_t1.push_back(middle + 0.01 * k * (turn * line));
    }
    const ReferenceMotion motion = anchor_motion(anchors, x_t0, x_t1);
    EXPECT_LT(motion.residual, 1e-9);
    EXPECT_NEAR(angle_of(motion), 2.0 * std::abs(std::sin(0.5 * angle)), 1e-9) << "trial " << trial;
  }
}

TEST(FailSafe, NoneGainsEnergyAtAStaticBody) {
  for (const auto& [name, make] : fail_safes())
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      SCOPED_TRACE(name + ", seed " + std::to_string(seed));
      Trial trial(swarm_with_anchors(seed, 0.6, false));
      const auto fail_safe = make();
      const double share = trial.resolve_halved(*fail_safe);
      ASSERT_GT(share, 0.0) << fail_safe->failure_reason();
      const double after = trial.energy();
      trial.aim(share);
      EXPECT_LE(after, trial.energy() * (1.0 + 1e-12));
    }
}

// Closed form: the plate takes the fall p and friction takes mu p of what slides; what is between
// the sheets is internal.
TEST(FailSafe, ThoseThatKnowFrictionLeaveASlidingStackWhatCoulombDoes) {
  const auto all = fail_safes();
  for (const std::string name : {"projection_zones", "separating_planes", "layered"})
    for (const int sheets : {1, 4})
      for (const double mu : {0.0, 0.3}) {
        SCOPED_TRACE(name + ", " + std::to_string(sheets) + " sheets, mu " + std::to_string(mu));
        Stage stage = falling_sheets(sheets, 3, {0.05, 0.0, -0.05});
        stage.friction = mu;
        Trial trial(stage);
        const auto fail_safe = all.at(name)();
        ASSERT_GT(trial.resolve(*fail_safe), 0);
        const Vec3 left = mean_move(trial, stage.n());
        const double taken = 0.05 + left.z();  // of the fall
        EXPECT_GT(taken, 0.035);
        EXPECT_NEAR(left.x(), 0.05 - mu * taken, 0.015 * 0.05);
      }
}

TEST(FailSafe, AStackThatRigidZonesFreezeSlidesWithTheDefault) {
  Stage stage = falling_sheets(10, 4, {0.1, 0.0, -0.1});
  const auto still = [&](FailSafe& fail_safe) {
    Trial trial(stage);
    EXPECT_GT(trial.resolve(fail_safe), 0);
    int count = 0;
    for (std::size_t i = 0; i < stage.n(); ++i) count += trial.x_t1[i] == trial.x_t0[i] ? 1 : 0;
    return count;
  };
  EXPECT_GT(still(*make_impulse_zones()), static_cast<int>(stage.n()) / 2);
  EXPECT_EQ(still(*fail_safes().at(ContactSpec{}.fail_safe)()), 0);
}

TEST(FailSafe, FewerRoundsEndCleanAsWell) {
  struct FirstLayer {
    std::string counter;
    std::unique_ptr<FailSafe> (*make)(const FailSafeRounds&);
    int FailSafeRounds::*rounds;
  };
  const FirstLayer first_layers[] = {
      {"impulse_passes", make_impulse_zones, &FailSafeRounds::impulse_passes},
      {"projection_rounds", make_projection_zones, &FailSafeRounds::projection_rounds},
      {"projection_rounds", make_layered, &FailSafeRounds::projection_rounds}};
  for (const FirstLayer& layer : first_layers)
    for (unsigned seed = 1; seed <= kSeeds; ++seed)
      for (const int most : {0, 1}) {
        SCOPED_TRACE(layer.counter + ", seed " + std::to_string(seed));
        Trial trial(swarm(seed, 1.0));
        FailSafeRounds rounds;
        rounds.*layer.rounds = most;
        const auto fail_safe = layer.make(rounds);
        EXPECT_GT(trial.resolve_halved(*fail_safe), 0.0) << fail_safe->failure_reason();
        EXPECT_EQ(fail_safe->counters().contains(layer.counter), most > 0);
      }
  const FailSafeRounds none{.projection_rounds = 0, .plane_rounds = 0};
  for (const auto make : {make_separating_planes, make_layered}) {
    Trial trial(swarm(1, 1.0));
    const auto fail_safe = make(none);
    EXPECT_GT(trial.resolve(*fail_safe), 0) << fail_safe->failure_reason();
    EXPECT_EQ(fail_safe->counters().at("all_pairs_bounded"), 1.0);
  }
}

TEST(FailSafe, BoundsOnAllDisplacementsEndInOneRound) {
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Trial free(swarm(seed, 1.0));
    EXPECT_EQ(free.resolve(*make_displacement_bound()), 1) << "seed " << seed;
    Trial anchored(swarm_with_anchors(seed, 0.6, false));
    EXPECT_EQ(anchored.resolve(*make_displacement_bound()), 1) << "seed " << seed;
  }
  Trial sheets(falling_sheets(4, 4, {0.05, 0.0, -0.05}));
  EXPECT_EQ(sheets.resolve(*make_displacement_bound()), 1);
}

// A body that passes the cloth from behind: its shift is everybody's, and the step need not be
// shortened though the body moves by many times the distance.
TEST(FailSafe, APlateFasterThanTheClothCarriesItInAWholeStep) {
  for (const auto& [name, make] : fail_safes()) {
    SCOPED_TRACE(name);
    Stage stage = falling_sheets(2, 3, Vec3::Zero());
    for (std::size_t k = stage.n(); k < stage.move.size(); ++k) stage.move[k] = Vec3(0, 0, 0.08);
    Trial trial(stage);
    const auto fail_safe = make();
    EXPECT_GT(trial.resolve(*fail_safe), 0) << fail_safe->failure_reason();
    for (std::size_t i = 0; i < stage.n(); ++i) EXPECT_GT(trial.x_t1[i].z(), 0.08);
  }
}

TEST(FailSafe, PlanesForAllPairsPartWhatPlanesForNoneWould) {
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Trial trial(swarm(seed, 1.0));
    if (trial.hits.empty()) continue;
    const Vec3 shift = shared_shift(trial.hits, trial.step(), trial.x_t1);
    SeparatingPlanes planes;
    planes.begin(trial.step(), trial.x_t1);
    std::vector<ContactPoint> pairs;
    trial.clearances().all(shift, pairs);
    planes.fix_reference(shift);
    planes.add(pairs);
    ASSERT_TRUE(planes.apply(trial.x_t1)) << planes.failure_reason();
    trial.find();
    EXPECT_TRUE(trial.hits.empty()) << "seed " << seed;
  }
}

TEST(Clearances, SlabsAreNoWiderThanTheDistanceAndHoldEveryVertex) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  int apart = 0;
  for (int k = 0; k < 2000; ++k) {
    const bool edges = k % 2 == 0;
    std::array<Vec3, 4> x;
    for (Vec3& v : x) v = Vec3(normal(random), normal(random), k % 5 ? normal(random) : 0.0);
    const SeparatingSlab slab =
        separating_slab(edges ? ContactKind::edge_edge : ContactKind::point_triangle, x);
    const double distance = edges ? edge_edge_closest(x[0], x[1], x[2], x[3]).distance
                                  : point_triangle_closest(x[0], x[1], x[2], x[3]).distance;
    EXPECT_LE(slab.width, distance);
    EXPECT_GE(slab.width, distance - 1e-12);
    for (int i = 0; i < (edges ? 2 : 1); ++i)
      for (int j = edges ? 2 : 1; j < 4; ++j) EXPECT_GE(slab.normal.dot(x[i] - x[j]), slab.width);
    apart += slab.width > 0.01;
  }
  EXPECT_GT(apart, 1000);
}

TEST(FailSafe, ClothBetweenClosingJawsIsJammedWithItsParticlesNamed) {
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
    EXPECT_NE(fail_safe->failure_reason().find("jammed: "), std::string::npos)
        << fail_safe->failure_reason();
    EXPECT_NE(fail_safe->failure_reason().find(" between body vertex 0 and body vertex "),
              std::string::npos)
        << fail_safe->failure_reason();
  }
}

}  // namespace
}  // namespace selvedge::fail_safe_test
