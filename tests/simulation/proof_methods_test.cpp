// SPDX-License-Identifier: MIT
//
// Every proof beside every registered limiter, response, fail-safe, integrator and law: random
// small scenes give the same bits and counts with proofs and without.
#include <gtest/gtest.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>

#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>

namespace selvedge::proof_methods_test {
namespace {

constexpr int kDraws = 4;
constexpr int kFrames = 10;

double between(std::mt19937& random, double low, double high) {
  return low + (high - low) * (random() / 4294967296.0);
}

/// A sheet whose two ends are pushed, pulled, shifted or turned against each other, above a ball
/// that they may meet. The limits are so small that stretch and compression pass them.
Scene drawn(unsigned seed) {
  std::mt19937 random(seed);
  Scene scene;
  scene.name = "draw " + std::to_string(seed);
  scene.gravity = seed % 2 == 0 ? Vec3(0.0, 0.0, -9.81) : Vec3(0.0, 0.0, 0.0);
  ClothSpec sheet;
  sheet.name = "sheet";
  sheet.shape = ClothGrid{"rectangular", {0.3, 0.2, 6, 4}, {}};
  sheet.placement.translation.z() = between(random, 0.005, 0.03);
  scene.cloths.push_back(sheet);
  Material& m = scene.materials["default"];
  m.stretch_stiffness = between(random, 20.0, 300.0);
  m.shear_stiffness = between(random, 5.0, 40.0);
  m.bending_stiffness = 1e-5;
  m.strain_limit = between(random, 0.005, 0.05);
  // Mostly towards each other, and slowly, as a proof needs it.
  const double apart = between(random, -0.005, 0.02);
  for (const bool right : {false, true}) {
    HandleSpec handle;
    handle.name = right ? "right" : "left";
    handle.geometry = "sheet";
    for (std::int32_t j = 0; j <= 4; ++j) handle.vertices.push_back(7 * j + (right ? 6 : 0));
    const Vec3 to((right ? -apart : apart), between(random, -0.003, 0.003), 0.0);
    handle.motion = {{.time = 0.0}, {.time = kFrames / 30.0, .translation = to}};
    scene.handles.push_back(handle);
  }
  BodySpec ball;
  ball.name = "ball";
  ball.shape = BodyShape{Sphere{0.1}, 12};
  ball.placement.translation.z() = -0.1;
  scene.bodies.push_back(ball);
  scene.contact.rest_gap = 0.002;
  scene.time.frames = kFrames;
  scene.time.fps = 30.0;
  scene.time.steps_per_frame = 3;
  return scene;
}

/// How a run ended, and what it counted but for the work that proofs leave out.
struct Outcome {
  std::string stopped;
  RunResult result;

  std::map<std::string, double> counters() const {
    std::map<std::string, double> found = result.counters;
    found.erase("candidate_rebuilds");
    return found;
  }
};

Outcome run(Scene scene, bool proofs) {
  scene.plan.proofs = proofs;
  Outcome outcome;
  try {
    Simulation simulation(scene);
    try {
      for (int frame = 1; frame <= kFrames; ++frame) simulation.advance_to_frame(frame);
    } catch (const SimulationFailed& failure) {
      outcome.stopped = failure.what();
    }
    outcome.result = simulation.result();
  } catch (const std::invalid_argument& error) {
    outcome.stopped = error.what();
  }
  return outcome;
}

/// How often limits were left out of the scenes that `change` makes.
std::int64_t expect_same_bits(const std::string& name, const std::function<void(Scene&)>& change) {
  std::int64_t left_out = 0;
  int complete = 0;
  for (unsigned draw = 0; draw < kDraws; ++draw) {
    const unsigned seed = std::accumulate(name.begin(), name.end(), 1000u * draw);
    SCOPED_TRACE(name + ", seed " + std::to_string(seed));
    Scene scene = drawn(seed);
    change(scene);
    const Outcome with = run(scene, true), without = run(scene, false);
    EXPECT_EQ(with.stopped, without.stopped);
    complete += with.stopped.empty() ? 1 : 0;
    EXPECT_EQ(with.result.state_hash, without.result.state_hash);
    EXPECT_EQ(with.result.steps, without.result.steps);
    EXPECT_EQ(with.result.max_stretch, without.result.max_stretch);
    EXPECT_EQ(with.result.strain_residual, without.result.strain_residual);
    EXPECT_EQ(with.result.clean, without.result.clean);
    EXPECT_EQ(with.counters(), without.counters());
    EXPECT_EQ(with.result.ledger, without.result.ledger);
    if (const auto part = with.result.plan.find("strain_limit"); part != with.result.plan.end())
      left_out += part->second.left_out;
  }
  EXPECT_GT(complete, 0) << name;
  return left_out;
}

TEST(ProofsBesideMethods, EveryLimiterHasTheSameBitsWithoutThem) {
  std::int64_t left_out = 0;
  for (const auto& [name, entry] : strain_limiters())
    left_out += expect_same_bits(name, [&, limiter = name](Scene& scene) {
      scene.solver.strain_limiter = true;
      scene.solver.limiter = limiter;
    });
  EXPECT_GT(left_out, 0) << "nothing was tried";
}

TEST(ProofsBesideMethods, EveryResponseHasTheSameBitsWithoutThem) {
  for (const auto& [name, entry] : responses())
    expect_same_bits(name, [response = name](Scene& scene) { scene.contact.response = response; });
}

TEST(ProofsBesideMethods, EveryFailSafeHasTheSameBitsWithoutThem) {
  for (const auto& [name, entry] : fail_safes())
    expect_same_bits(name, [safe = name](Scene& scene) { scene.contact.fail_safe = safe; });
}

TEST(ProofsBesideMethods, EveryIntegratorHasTheSameBitsWithoutThem) {
  for (const auto& [name, entry] : integrators())
    expect_same_bits(name, [integrator = name](Scene& scene) {
      scene.solver.integrator = integrator;
      scene.materials["default"].stretch_stiffness = 20.0;
      scene.materials["default"].shear_stiffness = 5.0;
    });
}

TEST(ProofsBesideMethods, EveryLawHasTheSameBitsWithoutThem) {
  const auto each = [](const auto& laws, auto member) {
    for (const auto& law : laws)
      expect_same_bits(law.name, [&](Scene& scene) {
        Material& m = scene.materials["default"];
        m.*member = law.name;
        if (m.stretch_law == "measured") {
          m.tension_curve = MonotoneCurve({0.0, 0.02, 0.05}, {0.0, 2.0, 8.0});
          set_curves(m);
        }
      });
  };
  each(fabric_laws().stretch, &Material::stretch_law);
  each(fabric_laws().shear, &Material::shear_law);
  each(fabric_laws().bending, &Material::bending_law);
}

}  // namespace
}  // namespace selvedge::proof_methods_test
