// SPDX-License-Identifier: MIT
// Sleeves on an arm that bends or swings, and a strip that is twisted: the kin of held_cloth_test.
#include <gtest/gtest.h>
#include <selvedge/bodies/body.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace selvedge::elbow_test {
namespace {

constexpr double kLimit = 0.1;  // of the default material

struct Draw {
  std::mt19937 random;
  double operator()(double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  }
};

/// A tube along x, open at both ends.
TriangleMesh tube(double radius, double from, double to, int around, int along) {
  TriangleMesh mesh;
  for (int i = 0; i <= along; ++i)
    for (int j = 0; j < around; ++j) {
      const double a = 2.0 * std::numbers::pi * (j + 0.5 * (i % 2)) / around;
      mesh.vertices.emplace_back(from + (to - from) * i / along, radius * std::cos(a),
                                 radius * std::sin(a));
    }
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < around; ++j) {
      const int a = i * around + j, b = i * around + (j + 1) % around;
      if (i % 2 == 0) {
        mesh.triangles.push_back({a, b, a + around});
        mesh.triangles.push_back({b, b + around, a + around});
      } else {
        mesh.triangles.push_back({a, b + around, a + around});
        mesh.triangles.push_back({a, b, b + around});
      }
    }
  return mesh;
}

/// The same, closed.
TriangleMesh limb(double radius, double from, double to, int around, int along) {
  TriangleMesh mesh = tube(radius, from, to, around, along);
  const auto first = static_cast<std::int32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(from, 0, 0);
  mesh.vertices.emplace_back(to, 0, 0);
  for (int j = 0; j < around; ++j) {
    const int k = (j + 1) % around, last = along * around;
    mesh.triangles.push_back({first, k, j});
    mesh.triangles.push_back({first + 1, last + j, last + k});
  }
  return mesh;
}

/// The skin of an arm whose elbow, at the origin, bends by an angle: as in most animations, each
/// vertex goes to the mean of where its two bones take it, so that the skin folds inwards.
TriangleMesh bent(TriangleMesh arm, double angle, double blend) {
  for (Vec3& x : arm.vertices) {
    const double share = std::clamp(0.5 + 0.5 * x.x() / blend, 0.0, 1.0);
    const Eigen::AngleAxisd upper(-0.5 * angle, Vec3::UnitZ()), lower(0.5 * angle, Vec3::UnitZ());
    x = (1.0 - share) * (upper * x) + share * (lower * x);
  }
  return arm;
}

Scene sleeve_on(const TriangleMesh& arm, const TriangleMesh& sleeve, double friction,
                double seconds) {
  Scene scene;
  scene.name = "sleeve";
  scene.materials["default"] = Material{};
  ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.name = "sleeve";
  cloth.shape = ClothFile{.file = {}, .rest_file = {}, .mesh = sleeve};
  BodySpec& body = scene.bodies.emplace_back();
  body.name = "arm";
  body.friction = friction;
  body.shape = BodyFile{.file = {}, .load = {}, .mesh = arm};
  scene.contact.carry_tangled = true;
  scene.time.frames = static_cast<int>(std::ceil(scene.time.fps * seconds)) + 5;
  return scene;
}

RunResult run(const Scene& scene, BuiltScene built) {
  Simulation simulation(scene, std::move(built));
  for (int frame = 1; frame <= scene.time.frames; ++frame) simulation.advance_to_frame(frame);
  return simulation.result();
}

RunResult elbow(unsigned seed) {
  Draw draw{std::mt19937(seed)};
  const double radius = draw(0.035, 0.055), room = draw(0.004, 0.012);
  const double angle = draw(1.9, 2.4), blend = radius * draw(0.6, 1.2), seconds = draw(0.4, 0.7);
  const TriangleMesh arm = limb(radius, -0.22, 0.22, 16, 28);
  const TriangleMesh sleeve = tube(radius + room, -draw(0.06, 0.1), draw(0.06, 0.1), 16, 9);
  const Scene scene = sleeve_on(arm, sleeve, draw(0.0, 0.6), seconds);
  BuiltScene built = build_scene(scene);
  constexpr int kFrames = 24;
  std::vector<TriangleMesh> frames;
  for (int k = 0; k <= kFrames; ++k) {
    const double share = 0.5 - 0.5 * std::cos(std::numbers::pi * k / kFrames);
    frames.push_back(bent(arm, share * angle, blend));
  }
  built.bodies[0] = make_sequence_body(std::move(frames), kFrames / seconds, 0.0);
  return run(scene, std::move(built));
}

TEST(Elbow, StrainOfASleeveStaysNearItsLimitInTheFold) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const RunResult result = elbow(seed);
    EXPECT_LE(result.max_stretch, 1.5 * kLimit) << "seed " << seed;
    EXPECT_TRUE(result.clean_elsewhere) << "seed " << seed;
  }
}

TEST(Sleeve, StrainStaysNearItsLimitOnAFastArm) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Draw draw{std::mt19937(seed)};
    const double radius = draw(0.03, 0.06), room = draw(0.008, 0.014), turn = draw(2.0, 2.8);
    const TriangleMesh arm = limb(radius, 0.0, 0.6, 20, 16);
    const double from = draw(0.02, 0.08);
    const TriangleMesh sleeve = tube(radius + room, from, from + draw(0.3, 0.5), 16, 22);
    const double begin = 0.05, seconds = turn / draw(16.0, 24.0);  // rad/s
    Scene scene = sleeve_on(arm, sleeve, draw(0.0, 0.6), begin + seconds);
    scene.bodies[0].motion = {{0.0},
                              {begin},
                              {begin + seconds, Vec3::Zero(),
                               Eigen::Quaterniond(Eigen::AngleAxisd(turn, Vec3::UnitZ()))}};
    const RunResult result = run(scene, build_scene(scene));
    EXPECT_LE(result.max_stretch, 1.5 * kLimit) << "seed " << seed;
    EXPECT_TRUE(result.clean) << "seed " << seed;
  }
}

TEST(Twist, StrainOfAStripStaysNearItsLimitUntilARope) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Draw draw{std::mt19937(seed)};
    constexpr int kAlong = 24, kAcross = 4;
    Scene scene;
    scene.name = "strip";
    scene.materials["default"] = Material{};
    ClothSpec& cloth = scene.cloths.emplace_back();
    cloth.name = "strip";
    const double length = draw(0.25, 0.4);
    cloth.shape = ClothGrid{"rectangular", {length, draw(0.05, 0.08), kAlong, kAcross}};
    for (const int end : {0, 1}) {
      HandleSpec& handle = scene.handles.emplace_back();
      handle.name = end == 0 ? "still" : "turned";
      handle.geometry = "strip";
      for (int j = 0; j <= kAcross; ++j) handle.vertices.push_back(j * (kAlong + 1) + end * kAlong);
    }
    const int quarters = static_cast<int>(draw(8.0, 11.0));
    const double seconds = 0.06 * quarters, nearer = draw(0.4, 0.5) * length;
    for (int k = 0; k <= quarters; ++k) {
      const double share = static_cast<double>(k) / quarters;
      scene.handles[1].motion.push_back(
          {seconds * share, Vec3(-nearer * share * share, 0, 0),
           Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * std::numbers::pi * k, Vec3::UnitX()))});
    }
    scene.time.frames = static_cast<int>(std::ceil(scene.time.fps * seconds)) + 5;
    const RunResult result = run(scene, build_scene(scene));
    EXPECT_LE(result.max_stretch, 1.5 * kLimit) << "seed " << seed;
    EXPECT_TRUE(result.clean) << "seed " << seed;
  }
}

}  // namespace
}  // namespace selvedge::elbow_test
