// SPDX-License-Identifier: MIT
// What the maps of a particle detector choose from body and rest gap, and where a scene is warned.
#include <gtest/gtest.h>
#include <selvedge/bodies/body.h>
#include <selvedge/broadphase/image_space/image_space.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/detail/between_particles.h>
#include <selvedge/scene/methods.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "owned_surface.h"

namespace selvedge::particle_maps_test {
namespace {

OwnedSurface surface_of(const TriangleMesh& mesh) {
  return {mesh.vertices, mesh.vertices, unique_edges(mesh.triangles), mesh.triangles};
}

OwnedSurface one_point(const Vec3& x) { return {{x}, {x}, {}, {}}; }

TEST(ParticleMapChoices, ChoosesAsManyViewsAsTheBodyNeeds) {
  std::vector<ParticleContact> out;
  for (const auto& [mesh, views] : {std::pair{tessellate(Sphere{0.3}, 48), 3},
                                    {tessellate(Box{Vec3(1.0, 1.0, 0.002)}, 3), 1}}) {
    const OwnedSurface body = surface_of(mesh), point = one_point(Vec3(0.0, 0.0, 2.0));
    ParticleMaps detector;
    EXPECT_EQ(detector.views(), 0) << "nothing was drawn";
    detector.find_particle_contacts(point.view(), body.view(), 0.02, out);
    EXPECT_EQ(detector.views(), views);
  }
}

TEST(ParticleMapChoices, ChoosesTexelsForAnEighthOfTheReach) {
  std::mt19937 random(std::random_device{}());
  const auto seed = random();
  SCOPED_TRACE("seed " + std::to_string(seed));
  random.seed(seed);
  std::uniform_real_distribution<double> radius(0.1, 0.5), share(0.02, 0.1);
  std::vector<ParticleContact> out;
  for (int trial = 0; trial < 5; ++trial) {
    const double r = radius(random), reach = share(random) * r;
    const OwnedSurface body = surface_of(tessellate(Sphere{r}, 32)),
                       point = one_point(Vec3(0.0, 0.0, r));
    ParticleMaps detector;
    detector.find_particle_contacts(point.view(), body.view(), reach, out);
    // A picture is a little larger than the body, and texels come in steps of 64.
    EXPECT_LE(detector.sideways_error(), 0.125 * reach * 1.1) << r << " m, " << reach << " m";
    EXPECT_GE(detector.sideways_error(), 0.125 * reach * 0.4) << r << " m, " << reach << " m";
  }
}

TEST(RiseAboveEdge, OfASphereIsThatOfAnArc) {
  std::mt19937 random(std::random_device{}());
  const auto seed = random();
  SCOPED_TRACE("seed " + std::to_string(seed));
  random.seed(seed);
  std::uniform_real_distribution<double> radius(0.05, 1.0), share(0.2, 0.6);
  for (int trial = 0; trial < 5; ++trial) {
    const double r = radius(random), length = share(random) * r;
    const TriangleMesh ball = tessellate(Sphere{r}, 96);
    const double exact = r - std::sqrt(r * r - 0.25 * length * length);
    const double found = detail::rise_above_edge(ball.vertices, ball.triangles, length);
    EXPECT_GT(found, 0.7 * exact) << r << " m, " << length << " m";
    EXPECT_LT(found, 2.0 * exact) << r << " m, " << length << " m";
  }
}

TEST(RiseAboveEdge, OfACornerIsHalfTheEdge) {
  const TriangleMesh box = tessellate(Box{Vec3(1.0, 0.8, 0.6)}, 3);
  EXPECT_NEAR(detail::rise_above_edge(box.vertices, box.triangles, 0.1), 0.05, 1e-12);
}

Scene sheet_on_ball(const std::string& broad_phase, int cells) {
  Scene scene;
  scene.materials["default"] = Material{};
  ClothSpec cloth;
  cloth.name = "cloth";
  cloth.shape = ClothGrid{"rectangular", {1.0, 1.0, cells, cells}, {}};
  scene.cloths.push_back(cloth);
  BodySpec body;
  body.name = "ball";
  body.shape = BodyShape{Sphere{0.3}, 48};
  scene.bodies.push_back(body);
  scene.contact.broad_phase = broad_phase;
  scene.contact.rest_gap = 0.002;
  return scene;
}

// An edge of 0.14 m sags by 8 mm over the ball, one of 14 mm by 0.08 mm.
TEST(ParticleMapWarnings, CoarseClothIsWarnedOfWhatLiesBetweenItsParticles) {
  const Methods methods = methods_of_this_build();
  const auto warnings = [&](const std::string& broad_phase, int cells) {
    return build_scene(sheet_on_ball(broad_phase, cells), methods).warnings;
  };
  const std::vector<std::string> coarse = warnings("depth_normal_maps", 10);
  ASSERT_EQ(coarse.size(), 1u);
  EXPECT_NE(coarse[0].find("obstacle \"ball\""), std::string::npos) << coarse[0];
  EXPECT_NE(coarse[0].find("smaller cells"), std::string::npos) << coarse[0];
  EXPECT_TRUE(warnings("depth_normal_maps", 100).empty());
  EXPECT_TRUE(warnings("bvh_aabb", 10).empty()) << "tests edges too";
}

}  // namespace
}  // namespace selvedge::particle_maps_test
