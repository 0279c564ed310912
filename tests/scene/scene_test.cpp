// SPDX-License-Identifier: MIT
#include "scene_file.h"

#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/scene/internal/scene_text.h>

#include <iostream>
#include <map>
#include <numbers>
#include <set>
#include <tuple>

namespace selvedge::scene_test {
namespace {

TEST_F(SceneFile, TheShortestSceneHasTheDefaultsOfTheHeader) {
  const Scene is = read(R"({"geometry": [{}]})");
  const Scene should;
  EXPECT_EQ(is.name, "scene");
  EXPECT_EQ(is.gravity, should.gravity);
  EXPECT_EQ(is.air.wind, should.air.wind);
  EXPECT_EQ(is.air.normal_drag, should.air.normal_drag);
  EXPECT_EQ(is.air.viscous_drag, should.air.viscous_drag);
  EXPECT_EQ(is.air.gusts.speed, should.air.gusts.speed);
  EXPECT_EQ(is.air.gusts.length, should.air.gusts.length);
  EXPECT_EQ(is.air.gusts.seed, should.air.gusts.seed);
  EXPECT_EQ(is.perturbation.speed, should.perturbation.speed);
  EXPECT_EQ(is.perturbation.seed, should.perturbation.seed);
  EXPECT_EQ(is.time.frames, should.time.frames);
  EXPECT_EQ(is.time.fps, should.time.fps);
  EXPECT_EQ(is.time.steps_per_frame, should.time.steps_per_frame);
  EXPECT_EQ(is.time.step_error, should.time.step_error);
  EXPECT_EQ(is.time.sleep_speed, should.time.sleep_speed);
  EXPECT_EQ(is.time.until_rest, should.time.until_rest);
  EXPECT_EQ(is.time.max_halvings, should.time.max_halvings);
  EXPECT_EQ(is.time.energy_guard, should.time.energy_guard);
  EXPECT_EQ(is.contact.rest_gap, should.contact.rest_gap);
  EXPECT_EQ(is.contact.self, should.contact.self);
  EXPECT_EQ(is.contact.untangle_start, should.contact.untangle_start);
  EXPECT_EQ(is.contact.carry_tangled, should.contact.carry_tangled);
  EXPECT_EQ(is.contact.broad_phase, should.contact.broad_phase);
  EXPECT_EQ(is.contact.narrow_phase, should.contact.narrow_phase);
  EXPECT_EQ(is.contact.response, should.contact.response);
  EXPECT_EQ(is.contact.fail_safe, should.contact.fail_safe);
  EXPECT_EQ(is.contact.broad_phase_options, should.contact.broad_phase_options);
  EXPECT_EQ(is.contact.narrow_phase_options, should.contact.narrow_phase_options);
  EXPECT_EQ(is.contact.response_options, should.contact.response_options);
  EXPECT_EQ(is.contact.fail_safe_options, should.contact.fail_safe_options);
  EXPECT_EQ(is.solver.integrator_options, should.solver.integrator_options);
  EXPECT_EQ(is.solver.limiter_options, should.solver.limiter_options);
  EXPECT_EQ(is.solver.integrator, should.solver.integrator);
  EXPECT_EQ(is.solver.strain_limiter, should.solver.strain_limiter);
  EXPECT_EQ(is.solver.limiter, should.solver.limiter);
  EXPECT_EQ(is.solver.refuse_unstable_step, should.solver.refuse_unstable_step);
  EXPECT_EQ(is.solver.tolerance, should.solver.tolerance);
  EXPECT_EQ(is.plan.proofs, should.plan.proofs);
  EXPECT_EQ(is.closed_form, should.closed_form);
  EXPECT_EQ(is.output.formats, should.output.formats);
  EXPECT_EQ(is.output.format_options, should.output.format_options);
  const CameraSpec &camera = is.output.camera, &camera_default = should.output.camera;
  EXPECT_EQ(camera.eye, camera_default.eye);
  EXPECT_EQ(camera.target, camera_default.target);
  EXPECT_EQ(camera.field_of_view, camera_default.field_of_view);
  ASSERT_EQ(is.cloths.size(), 1u);
  const auto& grid = std::get<ClothGrid>(is.cloths[0].shape);
  EXPECT_EQ(grid.pattern, ClothGrid{}.pattern);
  EXPECT_EQ(grid.grid.size_x, GridConfig{}.size_x);
  EXPECT_EQ(grid.grid.size_y, GridConfig{}.size_y);
  EXPECT_EQ(grid.grid.cells_x, GridConfig{}.cells_x);
  EXPECT_EQ(grid.grid.cells_y, GridConfig{}.cells_y);
  EXPECT_EQ(is.cloths[0].scale, 1.0);
  EXPECT_EQ(is.cloths[0].material, "default");
}

TEST_F(SceneFile, AMaterialAndObstaclesHaveTheDefaultsOfTheHeader) {
  write("quad.obj", quad);
  const Scene is = read(R"({"geometry": [{}], "materials": {"default": {}, "x": {}}, "obstacles": [
    {"shape": {"type": "plane"}}, {"shape": {"type": "box"}}, {"shape": {"type": "sphere"}},
    {"shape": {"type": "capsule"}}, {"shape": {"type": "cylinder"}}, {"shape": {"type": "cone"}},
    {"shape": {"type": "torus"}}, {"mesh": "quad.obj"}, {"sequence": {"files": ["quad.obj", "quad.obj"]}}]})");
  const Material m = is.materials.at("x"), d;
  EXPECT_EQ(m.density, d.density);
  EXPECT_EQ(m.stretch_stiffness, d.stretch_stiffness);
  EXPECT_EQ(m.shear_stiffness, d.shear_stiffness);
  EXPECT_EQ(m.bending_stiffness, d.bending_stiffness);
  EXPECT_EQ(m.spring_damping, d.spring_damping);
  EXPECT_EQ(m.bending_damping, d.bending_damping);
  EXPECT_EQ(m.strain_limit, d.strain_limit);
  EXPECT_EQ(m.friction, d.friction);
  EXPECT_EQ(m.stretch_law, d.stretch_law);
  EXPECT_EQ(m.shear_law, d.shear_law);
  EXPECT_EQ(m.bending_law, d.bending_law);
  for (const LawConstant& constant : fabric_laws().constants)
    EXPECT_EQ(constant(m), constant(d)) << constant.name;
  EXPECT_EQ(m.kawabata_lt, d.kawabata_lt);
  EXPECT_EQ(m.kawabata_strain, d.kawabata_strain);
  EXPECT_EQ(m.kawabata_rt, d.kawabata_rt);
  const auto shape = [&](int i) { return std::get<BodyShape>(is.bodies[i].shape); };
  EXPECT_EQ(std::get<Plane>(shape(0).shape).size, Plane{}.size);
  EXPECT_EQ(std::get<Box>(shape(1).shape).size, Box{}.size);
  EXPECT_EQ(std::get<Sphere>(shape(2).shape).radius, Sphere{}.radius);
  EXPECT_EQ(std::get<Capsule>(shape(3).shape).radius, Capsule{}.radius);
  EXPECT_EQ(std::get<Capsule>(shape(3).shape).length, Capsule{}.length);
  EXPECT_EQ(std::get<Cylinder>(shape(4).shape).radius, Cylinder{}.radius);
  EXPECT_EQ(std::get<Cylinder>(shape(4).shape).height, Cylinder{}.height);
  EXPECT_EQ(std::get<Cone>(shape(5).shape).radius, Cone{}.radius);
  EXPECT_EQ(std::get<Cone>(shape(5).shape).height, Cone{}.height);
  EXPECT_EQ(std::get<Torus>(shape(6).shape).radius, Torus{}.radius);
  EXPECT_EQ(std::get<Torus>(shape(6).shape).tube, Torus{}.tube);
  for (int i = 0; i < 7; ++i) EXPECT_EQ(shape(i).resolution, BodyShape{}.resolution) << i;
  const auto& load = std::get<BodyFile>(is.bodies[7].shape).load;
  EXPECT_EQ(load.unit, LoadConfig{}.unit);
  EXPECT_EQ(load.up, LoadConfig{}.up);
  EXPECT_EQ(load.weld, LoadConfig{}.weld);
  EXPECT_EQ(std::get<BodySequence>(is.bodies[8].shape).fps, BodySequence{}.fps);
  EXPECT_EQ(std::get<BodySequence>(is.bodies[8].shape).start, BodySequence{}.start);
  for (const BodySpec& body : is.bodies) EXPECT_EQ(body.friction, BodySpec{}.friction);
}

TEST_F(EverythingFile, EveryNumberGoesToItsField) {
  const Scene s = read_everything();
  EXPECT_EQ(s.name, "everything");
  EXPECT_EQ(s.gravity, Vec3(1, 2, -3));
  EXPECT_EQ(s.air.wind, Vec3(1, 0, 0));
  EXPECT_EQ(s.air.normal_drag, 0.5);
  EXPECT_EQ(s.air.viscous_drag, 0.25);
  EXPECT_EQ(s.air.gusts.speed, 0.75);
  EXPECT_EQ(s.air.gusts.length, 2.0);
  EXPECT_EQ(s.air.gusts.seed, 7u);
  ASSERT_EQ(s.air.jets.size(), 1u);
  EXPECT_EQ(s.air.jets[0].position, Vec3(1, 2, 3));
  EXPECT_EQ(s.air.jets[0].direction, Vec3(0, 0, 2));
  EXPECT_EQ(s.air.jets[0].speed, 4.0);
  EXPECT_EQ(s.air.jets[0].diameter, 0.5);
  EXPECT_EQ(s.perturbation.speed, 1e-5);
  EXPECT_EQ(s.perturbation.seed, 7u);
  EXPECT_EQ(s.time.frames, 30);
  EXPECT_EQ(s.time.fps, 25);
  EXPECT_EQ(s.time.steps_per_frame, 3);
  EXPECT_EQ(s.time.step_error, 0.003);
  EXPECT_EQ(s.time.sleep_speed, 0.02);
  EXPECT_TRUE(s.time.until_rest);
  EXPECT_EQ(s.time.max_halvings, 4);
  EXPECT_FALSE(s.time.energy_guard);
  EXPECT_EQ(s.contact.rest_gap, 0.003);
  EXPECT_FALSE(s.contact.self);
  EXPECT_EQ(s.contact.response, "impulse");
  EXPECT_EQ(s.contact.response_options, (MethodOptions{{"restitution", 0.25}}));
  EXPECT_TRUE(s.contact.untangle_start);
  EXPECT_TRUE(s.contact.carry_tangled);
  EXPECT_EQ(s.contact.broad_phase, "hash_grid");
  EXPECT_EQ(s.contact.broad_phase_options, (MethodOptions{{"cell", 0.5}}));
  EXPECT_EQ(s.contact.narrow_phase, "ccd_exact");
  EXPECT_EQ(s.contact.fail_safe, "impulse_zones");
  EXPECT_EQ(s.solver.integrator, "damped_verlet");
  EXPECT_EQ(s.solver.integrator_options, (MethodOptions{{"drag", 0.25}}));
  EXPECT_FALSE(s.solver.strain_limiter);
  EXPECT_EQ(s.solver.limiter, "none");
  EXPECT_FALSE(s.plan.proofs);
  EXPECT_EQ(s.closed_form, ClosedForm::free_fall);
  EXPECT_EQ(s.solver.tolerance, 1e-5);
  EXPECT_EQ(s.output.formats, (std::vector<std::string>{"obj", "vtk", "pc2"}));
  EXPECT_EQ(s.output.format_options.size(), 1u);
  EXPECT_EQ(s.output.format_options.at("vtk"), (MethodOptions{{"binary", 1.0}, {"digits", 9.0}}));
  EXPECT_EQ(s.output.all_formats(), (std::vector<std::string>{"obj", "pc2", "vtk"}));
  EXPECT_EQ(s.output.camera.eye, Vec3(1, 1, 1));
  EXPECT_EQ(s.output.camera.target, Vec3(0, 0, 1));
  EXPECT_EQ(s.output.camera.field_of_view, 40);
}

TEST_F(EverythingFile, EveryPieceOfClothAndItsMaterialIsRead) {
  const Scene s = read_everything();
  ASSERT_EQ(s.cloths.size(), 17u);
  const SolidSpec* heavy = solid_of(s.cloths[16]);
  ASSERT_NE(heavy, nullptr);
  EXPECT_EQ(s.cloths[16].name, "heavy");
  EXPECT_EQ(s.cloths[16].placement.translation, Vec3(0, 0, 90));
  EXPECT_EQ(heavy->mass, 4.0);
  EXPECT_EQ(heavy->slide, Vec3(0, 1, 0));
  EXPECT_EQ(heavy->force, Vec3(5, 6, 7));
  EXPECT_EQ(heavy->friction, 0.6);
  EXPECT_EQ(solid_of(s.cloths[0]), nullptr);
  const ClothSpec &grid = s.cloths[0], &file = s.cloths[1];
  EXPECT_EQ(grid.name, "grid");
  EXPECT_EQ(std::get<ClothGrid>(grid.shape).pattern, "triangular");
  EXPECT_EQ(std::get<ClothGrid>(grid.shape).grid.size_x, 0.5);
  EXPECT_EQ(std::get<ClothGrid>(grid.shape).grid.size_y, 0.75);
  EXPECT_EQ(std::get<ClothGrid>(grid.shape).grid.cells_x, 4);
  EXPECT_EQ(std::get<ClothGrid>(grid.shape).grid.cells_y, 6);
  EXPECT_EQ(grid.placement.translation, Vec3(1, 2, 3));
  EXPECT_EQ(grid.scale, 2);
  EXPECT_LT((grid.placement.rotation * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
  EXPECT_EQ(grid.velocity, Vec3(0, 1, 0));
  EXPECT_EQ(grid.material, "silk");
  EXPECT_EQ(std::get<ClothFile>(file.shape).file, folder_ / "quad.obj");
  EXPECT_EQ(std::get<ClothFile>(file.shape).rest_file, folder_ / "rest.obj");
  EXPECT_EQ(file.placement.translation, Vec3(0, 0, 9));
  EXPECT_EQ(file.velocity, Vec3(0, 0, -1));
  const StripPath& path = std::get<ClothGrid>(s.cloths[2].shape).path;
  EXPECT_EQ(path.points.size(), 3u);
  EXPECT_EQ(path.points[1], Vec3(0.25, 0, 20));
  EXPECT_EQ(path.side, Vec3(0, 1, 1));
  EXPECT_EQ(std::get<ClothFile>(file.shape).refine.levels, 2);
  EXPECT_EQ(std::get<ClothFile>(s.cloths[3].shape).mesh.vertices[2], Vec3(0, 1, 30));
  EXPECT_EQ(std::get<ClothFile>(s.cloths[3].shape).plate, 0.2);
  EXPECT_EQ(std::get<ClothGrid>(s.cloths[5].shape).plate, 0.25);
  EXPECT_EQ(s.cloths[5].virtual_springs.stiffness, 7.0);
  EXPECT_TRUE(s.cloths[5].virtual_springs.follow);
  const ClothGrid& layered = std::get<ClothGrid>(s.cloths[6].shape);
  EXPECT_EQ(layered.pattern, "bilayered");
  EXPECT_EQ(layered.pattern_options,
            (MethodOptions{{"ratio", 5.0}, {"share", 0.3}, {"hold", 900.0}}));
  const RefineSpec& refine = std::get<ClothGrid>(s.cloths[7].shape).refine;
  EXPECT_EQ(std::tuple(refine.when, refine.levels, refine.speed, refine.energy, refine.after),
            std::tuple(RefineSpec::When::curved, 3, 0.2, 0.01, 0.7));
  EXPECT_NEAR(refine.angle(), std::numbers::pi / 6.0, 1e-15);
  EXPECT_NEAR(refine.join(), std::numbers::pi / 20.0, 1e-15);
  EXPECT_EQ(std::get<ClothFile>(s.cloths[8].shape).support->stiffness, 60.0);
  EXPECT_EQ(std::get<ClothFile>(s.cloths[8].shape).support->share, 0.4);
  const auto net = [&](std::size_t i) {
    return std::get<ClothGrid>(s.cloths[i].shape).pattern_options;
  };
  EXPECT_EQ(net(9), (MethodOptions{{"structural", 1.0}, {"shear", 2.0}, {"flexion", 3.0}}));
  EXPECT_EQ(net(10), (MethodOptions{{"structural", 4.0}, {"shear", 5.0}, {"flexion", 6.0}}));
  EXPECT_EQ(net(11), (MethodOptions{{"structural", 7.0}, {"shear", 8.0}, {"flexion", 9.0}}));
  EXPECT_EQ(net(12), (MethodOptions{{"structural", 10.0}, {"flexion", 11.0}}));
  EXPECT_EQ(net(13), (MethodOptions{{"over", 4.0},
                                    {"under", 3.0},
                                    {"step", 2.0},
                                    {"warp_tex", 21.0},
                                    {"weft_tex", 22.0},
                                    {"modulus", 24.0},
                                    {"bending_share", 0.25},
                                    {"contact", 27.0},
                                    {"rotation", 28.0},
                                    {"links", 6.0}}));
  EXPECT_EQ(net(14), (MethodOptions{{"tex", 31.0},
                                    {"modulus", 33.0},
                                    {"bending_share", 0.35},
                                    {"contact", 36.0},
                                    {"sliding", 37.0},
                                    {"rotation", 38.0},
                                    {"links", 4.0}}));
  ASSERT_EQ(s.weights.size(), 1u);
  EXPECT_EQ(s.weights[0].geometry, "inline");
  EXPECT_EQ(s.weights[0].vertices, (std::vector<std::int32_t>{1}));
  EXPECT_EQ(s.weights[0].mass, 0.5);
  const Material& m = s.materials.at("silk");
  EXPECT_EQ(m.density, 0.1);
  EXPECT_EQ(m.stretch_stiffness, 400);
  EXPECT_EQ(m.shear_stiffness, 50);
  EXPECT_EQ(m.bending_stiffness, 2e-5);
  EXPECT_EQ(m.stretch_weft, 300.0);
  EXPECT_EQ(m.bending_weft, 1e-5);
  EXPECT_EQ(m.spring_damping, 0.02);
  EXPECT_EQ(m.bending_damping, 0.03);
  EXPECT_EQ(m.strain_limit, 0.05);
  EXPECT_EQ(m.friction, 0.2);
  EXPECT_EQ(m.stretch_law, "kawabata");
  EXPECT_EQ(m.bending_law, "bridson");
  EXPECT_EQ(constant_of_law(m, "biphasic_strain"), 0.03);
  EXPECT_EQ(constant_of_law(m, "biphasic_growth"), 7.0);
  EXPECT_EQ(m.kawabata_lt, 0.6);
  EXPECT_EQ(m.kawabata_strain, 0.04);
  EXPECT_EQ(m.kawabata_rt, 0.6);
}

TEST_F(EverythingFile, SeamsWaterAndPatternsAreRead) {
  const Scene s = read_everything();
  EXPECT_EQ(std::get<ClothFile>(s.cloths[4].shape).texture_unit, 0.5);
  ASSERT_EQ(s.seams.size(), 3u);
  EXPECT_EQ(s.seams[0].geometry[1], "grid");
  EXPECT_EQ(s.seams[0].vertices[0].size(), s.seams[0].vertices[1].size());
  EXPECT_GT(s.seams[0].vertices[1].front(), s.seams[0].vertices[1].back());
  EXPECT_EQ(s.seams[0].sewing.pull, 20.0);
  EXPECT_EQ(s.seams[0].sewing.acceleration, 3.0);
  EXPECT_EQ(s.seams[0].merge, 0.02);
  EXPECT_EQ(s.seams[1].name,
            "skirt: stitch 0: edge 1 of panel \"front\" to edge 1 of panel \"back\"");
  EXPECT_EQ(s.seams[1].geometry[0], "skirt");
  EXPECT_EQ(s.seams[1].vertices[0].size(), s.seams[1].vertices[1].size());
  EXPECT_EQ(s.seams[2].sewing.pull, 30.0);
  EXPECT_EQ(s.seams[2].merge, 0.03);
  const auto& skirt = std::get<ClothFile>(s.cloths[15].shape);
  EXPECT_EQ(skirt.mesh.triangles, skirt.rest_mesh.triangles);
  EXPECT_EQ(s.cloths[15].material, "silk");
  EXPECT_EQ(s.cloths[15].velocity, Vec3(0, 0, -2));
  EXPECT_EQ(s.cloths[15].virtual_springs.stiffness, 5.0);
  // The file has y up; the front stands at z = 0.2 m there, the back is moved.
  EXPECT_NEAR(skirt.mesh.vertices.back().y(), -0.2, 1e-12);
  EXPECT_NEAR(skirt.mesh.vertices.front().y(), 0.2 + 0.5, 1e-12);
  EXPECT_GT(skirt.mesh.vertices.front().z(), 49.0);
  ASSERT_TRUE(s.water.has_value());
  EXPECT_EQ(s.water->wetting.diffusivity, 2e-6);
  ASSERT_EQ(s.water->sources.size(), 1u);
  EXPECT_EQ(s.water->sources[0].rate, 0.01);
  EXPECT_EQ(s.water->sources[0].velocity, Vec3(0, 0, -3));
}

TEST_F(SceneFile, AFabricGivesWhatTheMaterialDoesNotSay) {
  const Scene s = read(R"({"geometry": [{"material": "twill"}],
    "materials": {"twill": {"fabric": "petrak_2025/M1", "strain_limit": 0.03, "density": 0.5}}})");
  const Material& m = s.materials.at("twill");
  EXPECT_EQ(m.density, 0.5);
  EXPECT_EQ(m.strain_limit, 0.03);
  EXPECT_EQ(m.stretch_stiffness, 477.0);
  EXPECT_EQ(m.stretch_weft, 459.0);
  EXPECT_NEAR(m.bending_stiffness, 1.95e-6, 1e-18);
  EXPECT_NEAR(*m.bending_weft, 0.61e-6, 1e-18);
  EXPECT_SAYS(s.json, "Petrak");  // in the description
}

TEST_F(SceneFile, AConstantBesideAFabricIsThatOfBothYarns) {
  const Scene s = read(R"({"geometry": [{"material": "twill"}],
    "materials": {"twill": {"fabric": "petrak_2025/M1", "bending_stiffness": 1e-5}}})");
  const Material& m = s.materials.at("twill");
  EXPECT_EQ(m.bending_stiffness, 1e-5);
  EXPECT_FALSE(m.bending_weft.has_value());
  EXPECT_EQ(m.stretch_weft, 459.0);
}

TEST_F(EverythingFile, EveryPairIsRead) {
  const std::vector<PairSpec> pairs = read_everything().contact.pairs;
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].a, "plane");
  EXPECT_EQ(pairs[0].b, "silk");
  EXPECT_EQ(pairs[0].friction, 0.6);
  EXPECT_EQ(pairs[0].rest_gap, 0.004);
  EXPECT_EQ(pairs[1].friction, 0.0);
  EXPECT_FALSE(pairs[1].rest_gap.has_value());
  EXPECT_EQ(pairs[0].collide, true);
  EXPECT_FALSE(pairs[1].collide.has_value());
}

TEST_F(EverythingFile, EveryHandleSelectsItsVertices) {
  const Scene s = read_everything();
  ASSERT_EQ(s.handles.size(), 4u);
  EXPECT_EQ(s.handles[0].geometry, "grid");
  EXPECT_EQ(s.handles[0].vertices.size(), 2u);
  EXPECT_EQ(s.handles[0].vertices.front(), 0);
  EXPECT_EQ(s.handles[0].release, 0.5);
  ASSERT_EQ(s.handles[0].motion.size(), 2u);
  EXPECT_EQ(s.handles[0].motion[1].time, 1.5);
  EXPECT_EQ(s.handles[0].motion[1].translation, Vec3(0, 0, 1));
  // First about z, which takes x to y, then about x, which takes y to z.
  const Vec3 turned = s.handles[0].motion[1].rotation * Vec3::UnitX();
  EXPECT_LT((turned - Vec3::UnitZ()).norm(), 1e-15);
  EXPECT_EQ(s.handles[1].vertices, (std::vector<std::int32_t>{0, 2}));
  EXPECT_FALSE(s.handles[1].release);
  EXPECT_TRUE(s.handles[1].motion.empty());
  EXPECT_EQ(s.handles[2].vertices, (std::vector<std::int32_t>{1}));
  EXPECT_GE(s.handles[3].vertices.size(), 4u);
}

TEST_F(EverythingFile, EveryObstacleIsRead) {
  const Scene s = read_everything();
  ASSERT_EQ(s.bodies.size(), 12u);
  const auto shape = [&](int i) { return std::get<BodyShape>(s.bodies[i].shape); };
  EXPECT_EQ(std::get<Plane>(shape(0).shape).size, 3);
  EXPECT_EQ(s.bodies[0].motion.size(), 2u);
  EXPECT_EQ(s.bodies[0].friction, 0.7);
  EXPECT_EQ(std::get<Box>(shape(1).shape).size, Vec3(1, 2, 3));
  EXPECT_EQ(std::get<Sphere>(shape(2).shape).radius, 0.2);
  EXPECT_EQ(std::get<Capsule>(shape(3).shape).radius, 0.3);
  EXPECT_EQ(std::get<Capsule>(shape(3).shape).length, 0.4);
  EXPECT_EQ(std::get<Cylinder>(shape(4).shape).radius, 0.6);
  EXPECT_EQ(std::get<Cylinder>(shape(4).shape).height, 0.7);
  EXPECT_EQ(std::get<Cone>(shape(5).shape).radius, 0.8);
  EXPECT_EQ(std::get<Cone>(shape(5).shape).height, 0.9);
  EXPECT_EQ(std::get<Torus>(shape(6).shape).radius, 0.4);
  EXPECT_EQ(std::get<Torus>(shape(6).shape).tube, 0.06);
  for (int i = 2; i < 7; ++i) EXPECT_EQ(shape(i).resolution, 14 + i);
  const auto& mesh = std::get<BodyFile>(s.bodies[7].shape);
  EXPECT_EQ(mesh.file, folder_ / "quad.obj");
  EXPECT_EQ(mesh.load.unit, 0.01);
  EXPECT_EQ(mesh.load.up, UpAxis::y);
  EXPECT_FALSE(mesh.load.weld);
  EXPECT_EQ(s.bodies[7].placement.translation, Vec3(0, 0, 1));
  EXPECT_EQ(s.bodies[7].friction, 0.1);
  const auto& walk = std::get<BodySequence>(s.bodies[8].shape);
  EXPECT_EQ(walk.files,
            (std::vector<fs::path>{folder_ / "walk_007.obj", folder_ / "walk_008.obj"}));
  EXPECT_EQ(walk.fps, 24);
  EXPECT_EQ(walk.load.unit, 0.1);
  EXPECT_EQ(walk.load.up, UpAxis::x);
  EXPECT_EQ(s.bodies[8].friction, 0.9);
  EXPECT_EQ(std::get<BodySequence>(s.bodies[9].shape).files, walk.files);
  EXPECT_EQ(std::get<BodySequence>(s.bodies[9].shape).load.groups,
            std::vector<std::string>{"skin"});
  const LoadConfig& parts = std::get<BodyFile>(s.bodies[11].shape).load;
  EXPECT_EQ(parts.groups, (std::vector<std::string>{"skin", "pale"}));
  const auto& inline_mesh = std::get<BodyFile>(s.bodies[10].shape);
  EXPECT_EQ(inline_mesh.load.unit, 2);
  EXPECT_EQ(inline_mesh.mesh.triangles[1], (Triangle{1, 2, 3}));
}

class Schema {
 public:
  Schema() : root_(Json::parse(scene_schema_text())) {}

  const Json& root() const { return root_; }
  const Json& resolve(const Json& schema) const {
    if (!schema.contains("$ref")) return schema;
    return resolve(root_.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1))));
  }

  /// Calls visit(path, property) for every property.
  template <class Visit>
  void walk(const Json& given, const std::string& path, const Visit& visit) const {
    const Json& schema = resolve(given);
    for (const Json& branch : schema.value("oneOf", Json::array())) walk(branch, path, visit);
    if (schema.contains("items")) walk(schema["items"], path + "[]", visit);
    if (schema.contains("additionalProperties") && schema["additionalProperties"].is_object())
      walk(schema["additionalProperties"], path + ".*", visit);
    if (!schema.contains("properties")) return;
    for (const auto& [key, property] : schema["properties"].items()) {
      visit(path + "." + key, property);
      walk(property, path + "." + key, visit);
    }
  }

 private:
  Json root_;
};

TEST(Schema, DescribesEveryKeyAndGivesEveryNumberAUnitAndARange) {
  const Schema schema;
  schema.walk(schema.root(), "", [&](const std::string& path, const Json& property) {
    const Json& full = schema.resolve(property);
    if (full.contains("const")) return;
    const std::string text = property.value("description", full.value("description", ""));
    EXPECT_GT(text.size(), 1u) << path << " has no description";
    const auto type = full.value("type", "");
    if (type != "number" && type != "integer") return;
    EXPECT_NE(text.find('['), std::string::npos) << path << " has no unit";
    EXPECT_TRUE(full.contains("minimum") || full.contains("exclusiveMinimum")) << path;
    EXPECT_TRUE(full.contains("maximum")) << path;
  });
}

std::string published(const char* file) {
  std::ifstream in(source_dir / file);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Schema, AndTableThatArePublishedAreThoseOfTheProgram) {
  EXPECT_TRUE(published("data/scenes/scene.schema.json") == scene_schema_text())
      << "selvedge list --scene schema > data/scenes/scene.schema.json";
  const std::string page = published("docs/scene_files.md");
  const auto begin = page.find("| part |"), end = page.find("<!-- end of the table -->");
  EXPECT_EQ(page.substr(begin, end - begin), scene_table_text()) << "selvedge list --scene table";
}

TEST(Schema, ReadsEveryScenePublishedBesideIt) {
  int scenes = 0, skipped = 0;
  for (const auto& entry : fs::directory_iterator(source_dir / "data/scenes")) {
    const fs::path file = entry.path();
    if (file.extension() != ".json" || file.filename() == "scene.schema.json") continue;
    try {
      EXPECT_EQ(read_scene(file).name, file.stem().string());
      ++scenes;
    } catch (const std::invalid_argument& error) {
      // Bodies that are not ours to pass on are fetched by a script.
      EXPECT_SAYS(std::string(error.what()), "fetch_bodies.sh");
      ++skipped;
    }
  }
  EXPECT_GE(scenes, 8);
  if (skipped > 0) std::cout << skipped << " scenes need scripts/fetch_bodies.sh\n";
}

TEST_F(SceneFile, AnOverrideReplacesAddsAndIsNamedWhenItIsWrong) {
  const std::string text = R"({"geometry": [{"name": "cloth"}]})";
  EXPECT_EQ(read(text, {{"time.frames", "7"}}).time.frames, 7);
  EXPECT_EQ(read(text, {{"name", "other"}}).name, "other");
  for (const char* path : {"geometry.0.cells", "geometry[0].cells", "geometry.cloth.cells"})
    EXPECT_EQ(std::get<ClothGrid>(read(text, {{path, "[3,4]"}}).cloths[0].shape).grid.cells_y, 4);
  EXPECT_SAYS(fault(text, {{"time.frames", "-1"}}),
              "--set time.frames, time.frames: must be at least 1");
  EXPECT_SAYS(fault(text, {{"geometry.1.cells", "[3,4]"}}), "no element \"1\"");
  EXPECT_SAYS(fault(text, {{"geometry.cloth.name.x", "1"}}), "has no part");
  EXPECT_SAYS(fault(text, {{"tine.frames", "1"}}), "nearest is \"time\"");
  EXPECT_SAYS(fault(text, {{"", "1"}}), "empty part");
}

TEST_F(SceneFile, TheCompletedSceneReadsBackTheSameFromAnywhere) {
  write("deep/quad.obj", quad);
  const fs::path file =
      write("deep/scene.json", R"({"geometry": [{}], "obstacles": [{"mesh": "quad.obj"}]})");
  const Scene first = read_scene(file, {{"contact.rest_gap", "0.0012345678901234567"}});
  const Scene second = read_scene(write("copy.json", first.json));
  EXPECT_EQ(second.json, first.json);
  EXPECT_EQ(second.contact.rest_gap, first.contact.rest_gap);
  EXPECT_EQ(std::get<BodyFile>(second.bodies[0].shape).file, folder_ / "deep/quad.obj");
}

TEST_F(SceneFile, ATextInMemoryReadsAsTheFileOfThatName) {
  write("quad.obj", quad);
  const std::string text = R"({"geometry": [{}], "obstacles": [{"mesh": "quad.obj"}]})";
  const fs::path file = write("scene.json", text);
  EXPECT_EQ(read_scene_text(text, file).json, read_scene(file).json);
  const Scene changed = read_scene_text(text, folder_ / "none", {{"time.frames", "7"}});
  EXPECT_EQ(changed.time.frames, 7);
  EXPECT_EQ(changed.name, "none");
  try {
    (void)read_scene_text("{", "here.json");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_SAYS(std::string(error.what()), "here.json, line 1: not valid JSON");
  }
}

}  // namespace
}  // namespace selvedge::scene_test
