// SPDX-License-Identifier: MIT
// A garment over another one.
#include "dress_shapes.h"

#include <gtest/gtest.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/dressing.h>
#include <selvedge/garment/sewing_pattern.h>
#include <selvedge/scene/build.h>

#include <algorithm>
#include <cmath>

namespace selvedge::dress_layers_test {
namespace {

using namespace selvedge::dress_shapes;

SewingPattern tube_at(double distance) { return tube(0.6, 0.3, distance); }

DressConfig coarse() {
  DressConfig config;
  config.edge_length = config.sewing_edge_length = 0.06;
  return config;
}

WornGarment worn(const DressResult& result) {
  return {.name = "inner",
          .surface = result.garment,
          .flat = result.flat,
          .fabric_name = "",
          .fabric = coarse().fabric};
}

/// Mean distance from the axis of the cone, m.
double mean_radius(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const Vec3& x : mesh.vertices) sum += std::hypot(x.x(), x.y());
  return sum / static_cast<double>(mesh.vertices.size());
}

TEST(DressLayers, AGarmentIsPutOverAnotherWithoutACrossing) {
  const TriangleMesh body = cone(0.3, 0.6);
  const DressResult inner = dress(tube_at(0.32), body, coarse());
  ASSERT_EQ(inner.fault(), "");
  DressConfig config = coarse();
  config.under = {worn(inner)};
  // Finer than the garment below.
  config.edge_length = 0.03;
  std::vector<DressResult> results;
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    std::size_t crossings = 0;
    DressObserver observer;
    observer.accepted = [&](const Simulation& now, DressPhase) {
      crossings += find_crossings(now.positions(), now.cloth_triangles()).size();
      crossings +=
          find_crossings({now.positions(), now.cloth_triangles()}, {body.vertices, body.triangles})
              .size();
    };
    results.push_back(dress(tube_at(0.32), body, config, {}, observer));
    const DressResult& r = results.back();
    EXPECT_EQ(r.fault(), "");
    EXPECT_EQ(crossings, 0u);
    ASSERT_EQ(r.under.size(), 1u);
    EXPECT_EQ(r.flags.size(), r.garment.vertices.size());
    EXPECT_EQ(r.pressure.size(), r.garment.vertices.size());
    EXPECT_EQ(r.under[0].garment.surface.triangles, inner.garment.triangles);
    // The garment below gave way a little, but stays below.
    EXPECT_NE(r.under[0].garment.surface.vertices, inner.garment.vertices);
    EXPECT_LT(std::abs(r.under[0].drop), 0.05);
    EXPECT_GT(r.under[0].max_stretch, 0.0);
    EXPECT_GT(mean_radius(r.garment), mean_radius(r.under[0].garment.surface));
    DressResult strict = r;
    strict.under[0].garment.fabric.strain_limit = 0.5 * r.under[0].max_stretch;
    EXPECT_NE(strict.reservation().find("the garment below, \"inner\""), std::string::npos)
        << strict.reservation();
  }
  EXPECT_EQ(results[0].state_hash, results[1].state_hash);
  EXPECT_EQ(results[0].garment.vertices, results[1].garment.vertices);
}

TEST(DressLayers, EachLayerHasItsOwnFriction) {
  const TriangleMesh body = cone(0.3, 0.6);
  WornGarment first, second;
  first.surface.vertices = {Vec3(0, 0, 1), Vec3(1, 0, 1), Vec3(0, 1, 1)};
  first.surface.triangles = {{0, 1, 2}};
  first.flat = first.surface;
  first.body_friction = 0.6;
  first.outer_friction = 0.1;
  second = first;
  for (Vec3& x : second.surface.vertices) x.z() += 0.1;
  second.body_friction = 0.5;
  second.outer_friction = 0.2;
  second.fabric.friction = 0.7;
  const std::vector<WornGarment> under = {first, second};
  const detail::Garment garment =
      detail::start_garment(mesh_garment(tube_at(0.5), {.edge_length = 0.3}), under);
  const detail::DressScene settling =
      detail::make_dress_scene(garment, body, coarse(), {.friction = 0.4});
  ASSERT_EQ(settling.built.piece_begin.size(), 4u);
  const ContactPairs pairs(settling.scene);
  const std::int32_t skin = 3;
  EXPECT_EQ(pairs.friction(0, skin), 0.4);
  EXPECT_EQ(pairs.friction(1, skin), 0.6);
  EXPECT_EQ(pairs.friction(2, skin), 0.5);
  EXPECT_EQ(pairs.friction(0, 1), 0.1);
  EXPECT_EQ(pairs.friction(0, 2), 0.2);
  EXPECT_EQ(pairs.friction(1, 2), 0.1);
  EXPECT_EQ(pairs.friction(2, 2), 0.7);
  // While seams close, the garments below rest, and the new one slides on them.
  const detail::DressScene sewing =
      detail::make_dress_scene(garment, body, coarse(), {.hold_under = true});
  EXPECT_EQ(sewing.built.piece_begin.size(), 2u);
  ASSERT_EQ(sewing.scene.bodies.size(), 3u);
  EXPECT_EQ(ContactPairs(sewing.scene).friction(0, 2), 0.0);
}

TEST(DressLayers, GarmentsBelowThatCrossAreRefused) {
  const TriangleMesh body = cone(0.3, 0.6);
  const DressResult inner = dress(tube_at(0.32), body, coarse());
  DressConfig config = coarse();
  config.under = {worn(inner), worn(inner)};
  EXPECT_THROW(dress(tube_at(0.32), body, config), std::invalid_argument);
  config.under.pop_back();
  for (Vec3& x : config.under[0].surface.vertices) x.x() += 0.1;
  EXPECT_THROW(dress(tube_at(0.32), body, config), std::invalid_argument);
}

TEST(DressLayers, PanelsStartOutsideTheGarmentBelow) {
  TriangleMesh body = cone(0.3, 0.6);
  WornGarment wall;  // in front of the cone, where the front panel stands
  wall.surface.vertices = {Vec3(-0.1, -0.40, 0.1), Vec3(0.1, -0.30, 0.1), Vec3(0.0, -0.36, 0.2)};
  wall.surface.triangles = {{0, 1, 2}};
  GarmentMesh mesh = mesh_garment(tube_at(0.36), {.edge_length = 0.1});
  EXPECT_TRUE(find_free_start(mesh, body, 0.5).empty());
  const std::vector<MovedPanel> moved = find_free_start(mesh, body, 0.5, {&wall, 1});
  ASSERT_EQ(moved.size(), 1u);
  EXPECT_EQ(moved[0].panel, 0);
  EXPECT_NEAR(moved[0].by.y(), -0.045, 0.011);
}

}  // namespace
}  // namespace selvedge::dress_layers_test
