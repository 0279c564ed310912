// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/scene/scene.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

const fs::path source_dir = SELVEDGE_SOURCE_DIR;

/// A folder of its own for each test, gone afterwards.
class SceneFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("selvedge_scene_" + std::to_string(getpid()) + "_" + info->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  Scene read(const std::string& text, const std::vector<Override>& set = {}) const {
    return read_scene(write("scene.json", text), set);
  }

  /// The sentence with which the text is refused; "" if it is not.
  std::string fault(const std::string& text, const std::vector<Override>& set = {}) const {
    return fault_of_file(write("scene.json", text), set);
  }

  std::string fault_of_file(const fs::path& file, const std::vector<Override>& set = {}) const {
    try {
      read_scene(file, set);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

#define EXPECT_SAYS(sentence, part) \
  EXPECT_NE((sentence).find(part), std::string::npos) << "the sentence is: " << (sentence)

const char* const quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";

const char* const garment =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 2 0\nvt 2 2\nvt 0 2\nvt 5 0\nvt 7 2\nvt 5 2\n"
    "f 1/1 2/2 3/3\nf 1/5 3/6 4/7\n";

/// Every key of the schema at least once, nothing at its default.
const char* const everything = R"({
  // comments are welcome /* of both */
  "$schema": "scene.schema.json",
  "name": "everything",
  "description": "all keys", /* so */
  "gravity": [1, 2, -3],
  "geometry": [
    {"name": "grid", "pattern": "triangular", "size": [0.5, 0.75], "cells": [4, 6],
     "transformation": {"translation": [1, 2, 3], "rotation": {"axis": [0, 0, 2], "angle_deg": 90}, "scale": 2},
     "velocity": [0, 1, 0], "material": "silk"},
    {"name": "file", "mesh": "quad.obj", "rest_mesh": "rest.obj", "transformation": {"translation": [0, 0, 9]},
     "velocity": [0, 0, -1], "material": "silk"},
    {"name": "strip", "size": [0.5, 0.1], "cells": [10, 2],
     "path": {"points": [[0, 0, 20], [0.25, 0, 20], [0.5, 0, 20]], "side": [0, 1, 1]}},
    {"name": "inline", "mesh": {"vertices": [[0, 0, 30], [1, 0, 30], [0, 1, 30]], "triangles": [[0, 1, 2]]},
     "plate": {"poisson": 0.2}},
    {"name": "garment", "mesh": "garment.obj", "rest": "texture", "texture_unit": 0.5,
     "transformation": {"translation": [0, 0, 40]}},
    {"name": "plate", "pattern": "triangular", "plate": {"poisson": 0.25}, "virtual_springs": {"stiffness": 7, "follow": true}},
    {"name": "layers", "pattern": "bilayered", "layers": {"ratio": 5, "share": 0.3, "hold": 900}},
    {"name": "refined", "refine": {"when": "settled", "levels": 3, "speed": 0.2, "energy": 0.01, "after": 0.7, "angle_deg": 30}},
    {"name": "body", "mesh": {"vertices": [[0, 0, 40], [1, 0, 40], [0, 1, 40], [0, 0, 41]],
     "triangles": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]}, "support": {"stiffness": 60, "share": 0.4},
     "virtual_springs": {"stiffness": 3}}
  ],
  "seams": [{"name": "side", "a": {"geometry": "grid", "select": {"edge": "x0"}},
             "b": {"geometry": "grid", "select": {"edge": "x1"}}, "reverse": true, "pull": 20,
             "tolerance": 0.01, "damping": 0.1}],
  "water": {"diffusivity": 2e-6, "saturation": 1.5, "sources": [
    {"geometry": "inline", "select": {"vertices": [1]}, "rate": 0.01, "begin": 0.1, "end": 0.2, "velocity": [0, 0, -3]}]},
  "materials": {"silk": {"density": 0.1, "stretch_stiffness": 400, "shear_stiffness": 50,
    "bending_stiffness": 2e-5, "spring_damping": 0.02, "bending_damping": 0.03, "strain_limit": 0.05,
    "friction": 0.2, "stretch_law": "kawabata", "shear_law": "springs", "bending_law": "bridson",
    "biphasic_strain": 0.03, "biphasic_growth": 7, "kawabata_lt": 0.6, "kawabata_strain": 0.04,
    "shear_friction": 0, "bending_friction": 0, "fabric": "petrak_2025/M1", "fabric_source": "a book",
    "stretch_weft": 300, "bending_weft": 1e-5}},
  "handles": [
    {"name": "a", "geometry": "grid", "select": {"corners": ["x0y0", "x1y0"]}, "motion": "lift", "release": 0.5},
    {"name": "b", "geometry": "file", "select": {"vertices": [2, 0, 2]}},
    {"name": "c", "geometry": "file", "select": {"box": [[0.5, -0.5, 8], [1.5, 0.5, 10]]}},
    {"name": "d", "geometry": "grid", "select": {"edge": "y1"}, "motion": []}
  ],
  "weights": [{"name": "button", "geometry": "inline", "select": {"vertices": [1]}, "mass": 0.5}],
  "motions": {"lift": [{"time": 0}, {"time": 1.5, "translation": [0, 0, 1],
    "rotation": [{"axis": [0, 0, 1], "angle_deg": 90}, {"axis": [1, 0, 0], "angle_deg": 90}]}]},
  "obstacles": [
    {"name": "plane", "shape": {"type": "plane", "size": 3}, "transformation": {"scale": 4}, "motion": "lift", "friction": 0.7},
    {"name": "box", "shape": {"type": "box", "size": [1, 2, 3]}},
    {"name": "sphere", "shape": {"type": "sphere", "radius": 0.2, "resolution": 16}},
    {"name": "capsule", "shape": {"type": "capsule", "radius": 0.3, "length": 0.4, "resolution": 17}},
    {"name": "cylinder", "shape": {"type": "cylinder", "radius": 0.6, "height": 0.7, "resolution": 18}},
    {"name": "cone", "shape": {"type": "cone", "radius": 0.8, "height": 0.9, "resolution": 19}},
    {"name": "torus", "shape": {"type": "torus", "radius": 0.4, "tube": 0.06, "resolution": 20}},
    {"name": "mesh", "mesh": "quad.obj", "unit": 0.01, "up": "y", "weld": false,
     "transformation": {"translation": [0, 0, 1]}, "motion": "lift", "friction": 0.1},
    {"name": "walk", "sequence": {"files": "walk_###.obj", "first": 7, "fps": 24, "start": 0.25}, "unit": 0.1,
     "up": "x", "transformation": {"scale": 3}, "friction": 0.9},
    {"name": "listed", "sequence": {"files": ["walk_007.obj", "walk_008.obj"]}},
    {"name": "inline", "mesh": {"vertices": [[0, 0, 0], [0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [[0, 2, 3], [1, 2, 3]]},
     "unit": 2}
  ],
  "air": {"wind": [1, 0, 0], "normal_drag": 0.5, "viscous_drag": 0.25},
  "time": {"frames": 30, "fps": 25, "steps_per_frame": 3, "max_halvings": 4},
  "contact": {"thickness": 0.003, "self": false, "broad_phase": "brute_force", "narrow_phase": "ccd_exact",
              "response": "impulse", "stiffness": 50, "damping": 0.5, "restitution": 0.25,
              "retention": 0.75, "slip_speed": 0.002, "sticking": true, "fail_safe": "impulse_zones",
              "start": "untangle", "still_tangled": "carry",
              "pairs": [{"a": "plane", "b": "silk", "friction": 0.6, "thickness": 0.004},
                        {"a": "strip", "b": "strip", "friction": 0}]},
  "solver": {"integrator": "symplectic_euler", "strain_limiter": false, "tolerance": 1e-5, "max_iterations": 50,
             "unstable_step": "refuse", "error": 1e-7, "drag": 0.25, "max_newton": 7},
  "plan": {"proofs": false},
  "closed_form": {"motion": "incline", "body": "plane"},
  "output": {"vtk": true, "pc2": true, "picture_every": 10,
    "camera": {"eye": [1, 1, 1], "target": [0, 0, 1], "field_of_view": 40, "width": 320, "height": 240}}
})";

class EverythingFile : public SceneFile {
 protected:
  Scene read_everything() const {
    write("quad.obj", quad);
    write("garment.obj", garment);
    write("rest.obj", quad);
    write("walk_007.obj", quad);
    write("walk_008.obj", quad);
    return read(everything);
  }
};

TEST_F(SceneFile, TheShortestSceneHasTheDefaultsOfTheHeader) {
  const Scene is = read(R"({"geometry": [{}]})");
  const Scene should;
  EXPECT_EQ(is.name, "scene");
  EXPECT_EQ(is.gravity, should.gravity);
  EXPECT_EQ(is.air.wind, should.air.wind);
  EXPECT_EQ(is.air.normal_drag, should.air.normal_drag);
  EXPECT_EQ(is.air.viscous_drag, should.air.viscous_drag);
  EXPECT_EQ(is.time.frames, should.time.frames);
  EXPECT_EQ(is.time.fps, should.time.fps);
  EXPECT_EQ(is.time.steps_per_frame, should.time.steps_per_frame);
  EXPECT_EQ(is.time.max_halvings, should.time.max_halvings);
  EXPECT_EQ(is.contact.thickness, should.contact.thickness);
  EXPECT_EQ(is.contact.self, should.contact.self);
  EXPECT_EQ(is.contact.untangle_start, should.contact.untangle_start);
  EXPECT_EQ(is.contact.carry_tangled, should.contact.carry_tangled);
  EXPECT_EQ(is.contact.broad_phase, should.contact.broad_phase);
  EXPECT_EQ(is.contact.narrow_phase, should.contact.narrow_phase);
  EXPECT_EQ(is.contact.response, should.contact.response);
  EXPECT_EQ(is.contact.fail_safe, should.contact.fail_safe);
  const ResponseConfig &answer = is.contact.response_config,
                       &header = should.contact.response_config;
  EXPECT_EQ(answer.stiffness, header.stiffness);
  EXPECT_EQ(answer.damping, header.damping);
  EXPECT_EQ(answer.restitution, header.restitution);
  EXPECT_EQ(answer.retention, header.retention);
  EXPECT_EQ(answer.slip_speed, header.slip_speed);
  EXPECT_EQ(answer.sticking, header.sticking);
  EXPECT_EQ(is.solver.integrator, should.solver.integrator);
  EXPECT_EQ(is.solver.strain_limiter, should.solver.strain_limiter);
  EXPECT_EQ(is.solver.limiter, should.solver.limiter);
  EXPECT_EQ(is.solver.refuse_unstable_step, should.solver.refuse_unstable_step);
  EXPECT_EQ(is.solver.error, should.solver.error);
  EXPECT_EQ(is.solver.drag, should.solver.drag);
  EXPECT_EQ(is.solver.max_newton, should.solver.max_newton);
  EXPECT_EQ(is.solver.tolerance, should.solver.tolerance);
  EXPECT_EQ(is.solver.max_iterations, should.solver.max_iterations);
  EXPECT_EQ(is.plan.proofs, should.plan.proofs);
  EXPECT_EQ(is.closed_form.motion, should.closed_form.motion);
  EXPECT_EQ(is.output.vtk, should.output.vtk);
  EXPECT_EQ(is.output.pc2, should.output.pc2);
  EXPECT_EQ(is.output.picture_every, should.output.picture_every);
  const CameraSpec &camera = is.output.camera, &camera_default = should.output.camera;
  EXPECT_EQ(camera.eye, camera_default.eye);
  EXPECT_EQ(camera.target, camera_default.target);
  EXPECT_EQ(camera.field_of_view, camera_default.field_of_view);
  EXPECT_EQ(camera.width, camera_default.width);
  EXPECT_EQ(camera.height, camera_default.height);
  ASSERT_EQ(is.cloths.size(), 1u);
  const auto& grid = std::get<ClothGrid>(is.cloths[0].shape);
  EXPECT_EQ(grid.pattern, ClothGrid{}.pattern);
  EXPECT_EQ(grid.grid.size_x, GridConfig{}.size_x);
  EXPECT_EQ(grid.grid.size_y, GridConfig{}.size_y);
  EXPECT_EQ(grid.grid.cells_x, GridConfig{}.cells_x);
  EXPECT_EQ(grid.grid.cells_y, GridConfig{}.cells_y);
  EXPECT_EQ(is.cloths[0].placement.scale, 1.0);
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
  EXPECT_EQ(m.biphasic_strain, d.biphasic_strain);
  EXPECT_EQ(m.biphasic_growth, d.biphasic_growth);
  EXPECT_EQ(m.kawabata_lt, d.kawabata_lt);
  EXPECT_EQ(m.kawabata_strain, d.kawabata_strain);
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
  EXPECT_EQ(s.time.frames, 30);
  EXPECT_EQ(s.time.fps, 25);
  EXPECT_EQ(s.time.steps_per_frame, 3);
  EXPECT_EQ(s.time.max_halvings, 4);
  EXPECT_EQ(s.contact.thickness, 0.003);
  EXPECT_FALSE(s.contact.self);
  EXPECT_EQ(s.contact.response, "impulse");
  const ResponseConfig& answer = s.contact.response_config;
  EXPECT_EQ(answer.stiffness, 50.0);
  EXPECT_EQ(answer.damping, 0.5);
  EXPECT_EQ(answer.restitution, 0.25);
  EXPECT_EQ(answer.retention, 0.75);
  EXPECT_EQ(answer.slip_speed, 0.002);
  EXPECT_TRUE(answer.sticking);
  EXPECT_TRUE(s.contact.untangle_start);
  EXPECT_TRUE(s.contact.carry_tangled);
  EXPECT_EQ(s.contact.broad_phase, "brute_force");
  EXPECT_EQ(s.solver.integrator, "symplectic_euler");
  EXPECT_FALSE(s.solver.strain_limiter);
  EXPECT_EQ(s.solver.limiter, "none");
  EXPECT_TRUE(s.solver.refuse_unstable_step);
  EXPECT_EQ(s.solver.error, 1e-7);
  EXPECT_EQ(s.solver.drag, 0.25);
  EXPECT_EQ(s.solver.max_newton, 7);
  EXPECT_FALSE(s.plan.proofs);
  EXPECT_EQ(s.closed_form.motion, ClosedForm::incline);
  EXPECT_EQ(s.closed_form.body, "plane");
  EXPECT_EQ(s.solver.tolerance, 1e-5);
  EXPECT_EQ(s.solver.max_iterations, 50);
  EXPECT_TRUE(s.output.vtk);
  EXPECT_TRUE(s.output.pc2);
  EXPECT_EQ(s.output.picture_every, 10);
  EXPECT_EQ(s.output.camera.eye, Vec3(1, 1, 1));
  EXPECT_EQ(s.output.camera.target, Vec3(0, 0, 1));
  EXPECT_EQ(s.output.camera.field_of_view, 40);
  EXPECT_EQ(s.output.camera.width, 320);
  EXPECT_EQ(s.output.camera.height, 240);
}

TEST_F(EverythingFile, EveryPieceOfClothAndItsMaterialIsRead) {
  const Scene s = read_everything();
  ASSERT_EQ(s.cloths.size(), 9u);
  const ClothSpec &grid = s.cloths[0], &file = s.cloths[1];
  EXPECT_EQ(grid.name, "grid");
  EXPECT_EQ(std::get<ClothGrid>(grid.shape).pattern, ClothPattern::triangular);
  EXPECT_EQ(std::get<ClothGrid>(grid.shape).grid.size_x, 0.5);
  EXPECT_EQ(std::get<ClothGrid>(grid.shape).grid.size_y, 0.75);
  EXPECT_EQ(std::get<ClothGrid>(grid.shape).grid.cells_x, 4);
  EXPECT_EQ(std::get<ClothGrid>(grid.shape).grid.cells_y, 6);
  EXPECT_EQ(grid.placement.translation, Vec3(1, 2, 3));
  EXPECT_EQ(grid.placement.scale, 2);
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
  EXPECT_EQ(std::get<ClothFile>(s.cloths[3].shape).mesh.vertices[2], Vec3(0, 1, 30));
  EXPECT_EQ(std::get<ClothFile>(s.cloths[3].shape).plate->poisson, 0.2);
  EXPECT_EQ(std::get<ClothGrid>(s.cloths[5].shape).plate->poisson, 0.25);
  EXPECT_EQ(s.cloths[5].virtual_springs.stiffness, 7.0);
  EXPECT_TRUE(s.cloths[5].virtual_springs.follow);
  const LayerConfig& layers = std::get<ClothGrid>(s.cloths[6].shape).layers;
  EXPECT_EQ(std::tuple(layers.ratio, layers.share, layers.hold), std::tuple(5, 0.3, 900.0));
  const RefineSpec& refine = std::get<ClothGrid>(s.cloths[7].shape).refine;
  EXPECT_EQ(std::tuple(refine.when, refine.levels, refine.speed, refine.energy, refine.after),
            std::tuple(RefineSpec::When::settled, 3, 0.2, 0.01, 0.7));
  EXPECT_NEAR(refine.angle, std::numbers::pi / 6.0, 1e-15);
  EXPECT_EQ(std::get<ClothFile>(s.cloths[8].shape).support->stiffness, 60.0);
  EXPECT_EQ(std::get<ClothFile>(s.cloths[8].shape).support->share, 0.4);
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
  EXPECT_EQ(m.stretch_law, StretchLaw::kawabata);
  EXPECT_EQ(m.bending_law, BendingLaw::bridson);
  EXPECT_EQ(m.biphasic_strain, 0.03);
  EXPECT_EQ(m.biphasic_growth, 7.0);
  EXPECT_EQ(m.kawabata_lt, 0.6);
  EXPECT_EQ(m.kawabata_strain, 0.04);
}

TEST_F(EverythingFile, SeamsWaterAndPatternsAreRead) {
  const Scene s = read_everything();
  EXPECT_EQ(std::get<ClothFile>(s.cloths[4].shape).texture_unit, 0.5);
  ASSERT_EQ(s.seams.size(), 1u);
  EXPECT_EQ(s.seams[0].geometry[1], "grid");
  EXPECT_EQ(s.seams[0].vertices[0].size(), s.seams[0].vertices[1].size());
  EXPECT_GT(s.seams[0].vertices[1].front(), s.seams[0].vertices[1].back());
  EXPECT_EQ(s.seams[0].sewing.pull, 20.0);
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
  EXPECT_SAYS(s.json, "Petrak");
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
  EXPECT_EQ(pairs[0].thickness, 0.004);
  EXPECT_EQ(pairs[1].friction, 0.0);
  EXPECT_FALSE(pairs[1].thickness.has_value());
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
  EXPECT_LT(s.handles[1].release, 0.0);
  EXPECT_TRUE(s.handles[1].motion.empty());
  EXPECT_EQ(s.handles[2].vertices, (std::vector<std::int32_t>{1}));
  EXPECT_GE(s.handles[3].vertices.size(), 4u);
}

TEST_F(EverythingFile, EveryObstacleIsRead) {
  const Scene s = read_everything();
  ASSERT_EQ(s.bodies.size(), 11u);
  const auto shape = [&](int i) { return std::get<BodyShape>(s.bodies[i].shape); };
  EXPECT_EQ(std::get<Plane>(shape(0).shape).size, 3);
  EXPECT_EQ(s.bodies[0].placement.scale, 4);
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
  EXPECT_EQ(walk.start, 0.25);
  EXPECT_EQ(walk.load.unit, 0.1);
  EXPECT_EQ(walk.load.up, UpAxis::x);
  EXPECT_EQ(s.bodies[8].placement.scale, 3);
  EXPECT_EQ(s.bodies[8].friction, 0.9);
  EXPECT_EQ(std::get<BodySequence>(s.bodies[9].shape).files, walk.files);
  const auto& inline_mesh = std::get<BodyFile>(s.bodies[10].shape);
  EXPECT_EQ(inline_mesh.load.unit, 2);
  EXPECT_EQ(inline_mesh.mesh.triangles[1], (Triangle{1, 2, 3}));
}

// -- schema and parser
// ------------------------------------------------------------------------------

class Schema {
 public:
  Schema() : root_(Json::parse(std::ifstream(source_dir / "data/scenes/scene.schema.json"))) {}

  const Json& root() const { return root_; }
  const Json& resolve(const Json& schema) const {
    if (!schema.contains("$ref")) return schema;
    return resolve(root_.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1))));
  }

  /// Calls visit(path, property, values of it) for every property; `values` are those in use.
  template <class Visit>
  void walk(const Json& given, const std::vector<const Json*>& values, const std::string& path,
            const Visit& visit) const {
    const Json& schema = resolve(given);
    if (schema.contains("oneOf"))
      for (const Json& branch : schema["oneOf"])
        walk(branch, fitting(values, resolve(branch)), path, visit);
    if (schema.contains("items")) walk(schema["items"], elements(values), path + "[]", visit);
    if (schema.contains("additionalProperties") && schema["additionalProperties"].is_object())
      walk(schema["additionalProperties"], elements(values), path + ".*", visit);
    if (!schema.contains("properties")) return;
    for (const auto& [key, property] : schema["properties"].items()) {
      std::vector<const Json*> members;
      for (const Json* value : values)
        if (value->is_object() && value->contains(key)) members.push_back(&(*value)[key]);
      visit(path + "." + key, property, members);
      walk(property, members, path + "." + key, visit);
    }
  }

 private:
  static std::vector<const Json*> elements(const std::vector<const Json*>& values) {
    std::vector<const Json*> all;
    for (const Json* value : values)
      for (const Json& element : *value) all.push_back(&element);
    return all;
  }

  static std::vector<const Json*> fitting(const std::vector<const Json*>& values,
                                          const Json& branch) {
    std::vector<const Json*> all;
    for (const Json* value : values) {
      if (value->type_name() != branch["type"].get<std::string>()) continue;
      bool fits = true;
      for (const Json& key : branch.value("required", Json::array()))
        fits = fits && value->contains(key.get<std::string>());
      if (fits && branch.contains("properties") && branch["properties"].contains("type"))
        fits = (*value)["type"] == branch["properties"]["type"]["const"];
      if (fits) all.push_back(value);
    }
    return all;
  }

  Json root_;
};

TEST(Schema, HasNoKeyThatTheTestOfAllFieldsLeavesOut) {
  const Schema schema;
  const Json document = Json::parse(everything, nullptr, true, /*ignore_comments=*/true);
  std::map<const Json*, std::string> unused;  // definitions count once, wherever they are used
  std::set<const Json*> used;
  schema.walk(schema.root(), {&document}, "",
              [&](const std::string& path, const Json& property, const auto& values) {
                if (values.empty())
                  unused.emplace(&property, path);
                else
                  used.insert(&property);
              });
  for (const auto& [property, path] : unused)
    EXPECT_TRUE(used.contains(property)) << path << " is in the schema but nothing tests it";
  EXPECT_GT(used.size(), 90u);
}

TEST(Schema, DescribesEveryKeyWithUnitRangeAndDefault) {
  const Schema schema;
  schema.walk(
      schema.root(), {}, "", [&](const std::string& path, const Json& property, const auto&) {
        const Json& full = schema.resolve(property);
        if (full.contains("const")) return;
        const std::string text = property.value("description", full.value("description", ""));
        EXPECT_FALSE(text.empty()) << path << " has no description";
        const auto type = full.value("type", "");
        if (type != "number" && type != "integer") return;
        EXPECT_NE(text.find('['), std::string::npos) << path << " has no unit";
        EXPECT_TRUE(full.contains("minimum") || full.contains("exclusiveMinimum")) << path;
        EXPECT_TRUE(full.contains("maximum")) << path;
      });
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

// -- faults
// -----------------------------------------------------------------------------------------

TEST_F(SceneFile, AMissingFileAFolderAndAnEmptyFileAreSaidToBeThat) {
  EXPECT_SAYS(fault_of_file(folder_ / "none.json"), "no such file");
  EXPECT_SAYS(fault_of_file(folder_), "is a folder");
  EXPECT_SAYS(fault(""), "the file is empty");
  EXPECT_SAYS(fault(" \n\t\n"), "the file is empty");
}

TEST_F(SceneFile, ASyntaxErrorHasItsLine) {
  EXPECT_SAYS(fault("{\n  \"geometry\": [{}],\n  \"time\" {}\n}"), "line 3");
  EXPECT_SAYS(fault("{\"geometry\": [{}]"), "not valid JSON");
  EXPECT_SAYS(fault("{\"geometry\": [{}]} x"), "not valid JSON");
  EXPECT_SAYS(fault("{\"gravity\": [0, 0, NaN], \"geometry\": [{}]}"), "not valid JSON");
  EXPECT_SAYS(fault("{\"gravity\": [0, 0, 1e999], \"geometry\": [{}]}"), "not valid JSON");
  EXPECT_SAYS(fault("\x7f"
                    "ELF\x01\x02"),
              "not valid JSON");
}

TEST_F(SceneFile, TruncationAtAnyByteIsAnErrorAndNeverACrash) {
  const std::string text =
      R"({"geometry": [{"size": [1, 2.5]}], "time": {"fps": 6e1}, "output": {"vtk": true}})";
  for (std::size_t size = 0; size < text.size(); ++size)
    EXPECT_NE(fault(text.substr(0, size)), "") << size;
  EXPECT_EQ(fault(text), "");
}

TEST_F(SceneFile, EndlessBracketsAreRefused) {
  EXPECT_SAYS(fault(std::string(1000000, '[')), "levels of brackets");
}

TEST_F(SceneFile, ADuplicateKeyIsRefusedWithBothLines) {
  const std::string sentence =
      fault("{\n\"geometry\": [{}],\n\"time\": {\"fps\": 1,\n\"fps\": 2}\n}");
  EXPECT_SAYS(sentence, "line 4, time.fps");
  EXPECT_SAYS(sentence, "first in line 3");
}

TEST_F(SceneFile, AnUnknownKeyNamesTheNearestKnownOne) {
  EXPECT_SAYS(fault(R"({"geometry": [{}], "obstacels": []})"), "nearest is \"obstacles\"");
  EXPECT_SAYS(fault(R"({"geometry": [{"cell": [1, 1]}]})"), "nearest is \"cells\"");
  EXPECT_SAYS(fault(R"({"geometry": [{}], "contact": {"thikness": 1}})"),
              "nearest is \"thickness\"");
  EXPECT_SAYS(fault(R"({"geometry": [{}], "time": {"frmaes": 1}})"), "time.frmaes");
  EXPECT_SAYS(fault(R"({"geometry": [{}], "materials": {"x": {"desnity": 1}}})"),
              "materials.x.desnity: unknown key; nearest is \"density\"");
  EXPECT_SAYS(
      fault(R"({"geometry": [{}], "obstacles": [{"shape": {"type": "sphere", "radious": 1}}]})"),
      "nearest is \"radius\"");
}

TEST_F(SceneFile, AKeyOfAnotherKindOfPieceIsSaidNotToGoWithIt) {
  write("quad.obj", quad);
  EXPECT_SAYS(fault(R"({"geometry": [{"mesh": "quad.obj", "cells": [1, 1]}]})"),
              "geometry[0].cells: does not go with the other keys");
  EXPECT_SAYS(
      fault(R"({"geometry": [{}], "obstacles": [{"shape": {"type": "sphere", "tube": 1}}]})"),
      "does not go with");
  EXPECT_SAYS(fault(R"({"geometry": [{}], "obstacles": [{}]})"), "needs one of the keys");
  EXPECT_SAYS(fault(R"({"geometry": [{}], "obstacles": [{"shape": {"type": "spehre"}}]})"),
              "nearest is \"sphere\"");
  EXPECT_SAYS(fault(R"({"geometry": [{}], "obstacles": [{"shape": {"radius": 1}}]})"),
              "needs the key \"type\"");
}

TEST_F(SceneFile, AValueOutOfRangeHasLinePathAndBound) {
  const std::string sentence = fault("{\n\"geometry\": [{\"cells\": [\n5,\n0\n]}]}");
  EXPECT_SAYS(sentence, "line 4, geometry[0].cells[1]: must be at least 1, is 0");
}

TEST_F(SceneFile, EachBadNumberIsRefused) {
  const auto refused = [&](const std::string& path, const std::string& value) {
    const std::string sentence =
        fault(R"({"geometry": [{}], "materials": {"default": {}}})", {{path, value}});
    EXPECT_NE(sentence, "") << path << " = " << value << " was accepted";
    EXPECT_SAYS(sentence, path.substr(path.rfind('.') + 1));
  };
  for (const char* key : {"density", "stretch_stiffness", "strain_limit"}) {
    refused(std::string("materials.default.") + key, "0");
    refused(std::string("materials.default.") + key, "-1");
  }
  for (const char* key :
       {"shear_stiffness", "bending_stiffness", "spring_damping", "bending_damping", "friction"})
    refused(std::string("materials.default.") + key, "-1e-9");
  for (const auto& [key, value] :
       {std::pair{"kawabata_lt", "0.5"}, std::pair{"kawabata_lt", "1.1"},
        std::pair{"kawabata_strain", "0"}, std::pair{"biphasic_strain", "-1"},
        std::pair{"biphasic_growth", "-1"}, std::pair{"bending_law", "plate"},
        std::pair{"stretch_law", "rubber"}, std::pair{"shear_law", "none"}})
    refused(std::string("materials.default.") + key, value);
  for (const char* value : {"0", "-0.001", "true", "null", "[]", "\"thick\"", "nan"})
    refused("contact.thickness", value);
  for (const char* value :
       {"0", "-5", "1.5", "1e10", "-9223372036854775808", "18446744073709551615", "x"})
    refused("time.frames", value);
  refused("time.fps", "0");
  refused("time.steps_per_frame", "0");
  refused("time.max_halvings", "-1");
  refused("gravity", "[0, 0]");
  refused("gravity", "[0, 0, \"-9.81\"]");
  refused("solver.tolerance", "0");
  refused("solver.max_iterations", "0");
  refused("solver.integrator", "euler");
  refused("solver.strain_limiter", "positon");
  refused("solver.strain_limiter", "1");
  refused("solver.unstable_step", "divide");
  refused("solver.error", "0");
  refused("solver.drag", "-1");
  refused("solver.max_newton", "0");
  refused("plan.proofs", "1");
  refused("closed_form.motion", "slide");
  refused("contact.self", "1");
  refused("contact.broad_phase", "bvh");
  refused("contact.narrow_phase", "ccd");
  refused("contact.response", "contactforce");
  refused("contact.stiffness", "-1");
  refused("contact.damping", "-1");
  refused("contact.restitution", "1.5");
  refused("contact.retention", "-0.1");
  refused("contact.slip_speed", "0");
  refused("contact.sticking", "1");
  refused("contact.fail_safe", "zones");
  refused("output.camera.width", "0");
  refused("output.camera.field_of_view", "180");
  refused("output.camera.target", "[1.6, -2.2, 1.4]");
  refused("geometry.0.size", "[1, 0]");
  refused("geometry.0.transformation.scale", "0");
  refused("geometry.0.pattern", "hexagonal");
  refused("geometry", "[]");
  refused("geometry", "{}");
}

TEST_F(SceneFile, ARotationWithoutAxisIsRefused) {
  EXPECT_SAYS(
      fault(
          R"({"geometry": [{"transformation": {"rotation": {"axis": [0, 0, 0], "angle_deg": 1}}}]})"),
      "geometry[0].transformation.rotation.axis: must not be the zero vector");
  EXPECT_SAYS(fault(R"({"geometry": [{"transformation": {"rotation": {"axis": [0, 0, 1]}}}]})"),
              "needs the key \"angle_deg\"");
}

TEST_F(SceneFile, AnUnknownMethodNamesTheNearestKnownOne) {
  EXPECT_SAYS(fault(R"({"geometry": [{}], "contact": {"broad_phase": "brute_fource"}})"),
              "nearest is \"brute_force\"");
}

TEST_F(SceneFile, AReferenceToNothingNamesTheNearestKnownOne) {
  EXPECT_SAYS(fault(R"({"geometry": [{"material": "sillk"}], "materials": {"silk": {}}})"),
              "there is no material \"sillk\"; nearest is \"silk\"");
  EXPECT_SAYS(
      fault(
          R"({"geometry": [{"name": "a"}], "handles": [{"geometry": "b", "select": {"edge": "x0"}}]})"),
      "there is no geometry \"b\"");
  EXPECT_SAYS(
      fault(R"({"geometry": [{}], "handles": [{"select": {"edge": "x0"}, "motion": "up"}]})"),
      "there is no motion \"up\"");
  EXPECT_SAYS(
      fault(
          R"({"geometry": [{"name": "a"}, {"name": "b"}], "handles": [{"select": {"edge": "x0"}}]})"),
      "needs the key \"geometry\"");
  EXPECT_SAYS(fault(R"({"geometry": [{"name": "a"}, {"name": "a"}]})"), "is taken");
}

TEST_F(SceneFile, APinThatDoesNotExistIsRefused) {
  const auto with = [&](const std::string& select) {
    return fault(R"({"geometry": [{"name": "g", "cells": [2, 3]}], "handles": [{"select": )" +
                 select + "}]}");
  };
  EXPECT_SAYS(with(R"({"vertices": [0, 12]})"),
              "handles[0].select.vertices[1]: there is no vertex 12; \"g\" has vertices 0 to 11");
  EXPECT_SAYS(with(R"({"vertices": [-1]})"), "must be at least 0");
  EXPECT_SAYS(with(R"({"vertices": []})"), "at least 1");
  EXPECT_SAYS(with(R"({"box": [[5, 5, 5], [6, 6, 6]]})"),
              "selects nothing; \"g\" lies from (-0.5, -0.5, 0) to (0.5, 0.5, 0) m");
  EXPECT_SAYS(with(R"({"box": [[1, 0, 0], [0, 1, 1]]})"), "must be the lowest");
  EXPECT_SAYS(with(R"({"corners": ["x2y0"]})"), "unknown value");
  EXPECT_SAYS(with(R"({})"), "needs one of the keys");
  EXPECT_SAYS(with(R"({"edge": "x0", "vertices": [1]})"), "does not go with");
}

TEST_F(SceneFile, AVertexHeldTwiceIsRefused) {
  EXPECT_SAYS(fault(R"({"geometry": [{"name": "g"}], "handles": [
    {"name": "one", "select": {"edge": "x0"}}, {"select": {"corners": ["x0y0"]}}]})"),
              "vertex 0 of \"g\" is held by \"one\" already");
}

TEST_F(SceneFile, KeyframesMustRiseAndAHandleMustStartWhereItIs) {
  const auto with = [&](const std::string& motion) {
    return fault(R"({"geometry": [{}], "handles": [{"select": {"edge": "x0"}, "motion": )" +
                 motion + "}]}");
  };
  EXPECT_SAYS(with(R"([{"time": 0}, {"time": 0}])"), "handles[0].motion[1].time: must be later");
  EXPECT_SAYS(with(R"([{"time": 0, "translation": [0, 0, 1]}])"), "must not translate or rotate");
  EXPECT_SAYS(with(R"([{"translation": [0, 0, 1]}])"), "needs the key \"time\"");
  EXPECT_EQ(with(R"([{"time": 1}, {"time": 2, "translation": [0, 0, 1]}])"), "");
}

TEST_F(SceneFile, CornersAndEdgesOfAGridAreTheRightOnes) {
  const Scene s = read(
      R"({"geometry": [{"cells": [2, 3], "transformation": {"rotation": {"axis": [1, 0, 0], "angle_deg": 90}}}],
    "handles": [{"select": {"corners": ["x1y0", "x0y1"]}}, {"select": {"edge": "y0"}}]})",
      {{"handles.1.select.edge", "x1"}, {"handles.0.select.corners", "[\"x0y1\"]"}});
  EXPECT_EQ(s.handles[0].vertices, (std::vector<std::int32_t>{9}));
  EXPECT_EQ(s.handles[1].vertices, (std::vector<std::int32_t>{2, 5, 8, 11}));
}

TEST_F(SceneFile, CornersOfAMeshAreRefused) {
  write("quad.obj", quad);
  EXPECT_SAYS(
      fault(R"({"geometry": [{"mesh": "quad.obj"}], "handles": [{"select": {"edge": "x0"}}]})"),
      "is a mesh and not a grid");
}

TEST_F(SceneFile, AMissingMeshIsNamedWithARemedy) {
  EXPECT_SAYS(fault(R"({"geometry": [{"mesh": "none.obj"}]})"),
              "geometry[0].mesh: there is no file");
  EXPECT_SAYS(fault(R"({"geometry": [{}], "obstacles": [{"mesh": "../fetched/none.off"}]})"),
              "fetch it with scripts/fetch_bodies.sh");
  EXPECT_SAYS(fault(R"({"geometry": [{}], "obstacles": [{"mesh": "."}]})"), "is a folder");
  EXPECT_SAYS(fault(R"({"geometry": [{}], "obstacles": [{"sequence": {"files": "w_##.obj"}}]})"),
              "there is no file");
  EXPECT_SAYS(fault(R"({"geometry": [{}], "obstacles": [{"sequence": {"files": "w.obj"}}]})"),
              "needs a list of files");
}

// -- overrides and completion
// -----------------------------------------------------------------------

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
  const Scene first = read_scene(file, {{"contact.thickness", "0.0012345678901234567"}});
  const Scene second = read_scene(write("copy.json", first.json));
  EXPECT_EQ(second.json, first.json);
  EXPECT_EQ(second.contact.thickness, first.contact.thickness);
  EXPECT_EQ(std::get<BodyFile>(second.bodies[0].shape).file, folder_ / "deep/quad.obj");
}

// -- build_scene
// ------------------------------------------------------------------------------------

TEST_F(EverythingFile, PiecesAreJoinedScaledTurnedAndMoved) {
  const Scene scene = read_everything();
  const BuiltScene built = build_scene(scene);
  ASSERT_EQ(built.piece_begin.size(), 10u);
  EXPECT_EQ(built.piece_begin[0], 0);
  const auto& x = built.cloth.surface.vertices;
  EXPECT_EQ(static_cast<std::size_t>(built.piece_begin[9]), x.size());
  ASSERT_EQ(built.velocity.size(), x.size());
  EXPECT_EQ(built.velocity.front(), Vec3(0, 1, 0));
  EXPECT_EQ(built.velocity[built.piece_begin[2] - 1], Vec3(0, 0, -1));
  // Twice 0.5 x 0.75 m about (1, 2, 3), turned by a quarter: 1.5 along x, 1 along y.
  Vec3 low = x[0], high = x[0];
  for (int i = 0; i < built.piece_begin[1]; ++i) {
    low = low.cwiseMin(x[i]);
    high = high.cwiseMax(x[i]);
  }
  EXPECT_LT((high - Vec3(1.75, 2.5, 3)).norm(), 1e-12) << high.transpose();
  EXPECT_LT((low - Vec3(0.25, 1.5, 3)).norm(), 1e-12) << low.transpose();
  EXPECT_EQ(x[built.piece_begin[2] - 1], Vec3(0, 1, 9));
  const std::int32_t end = built.piece_begin[4];  // of the inline mesh
  EXPECT_EQ(x[end - 1], Vec3(0, 1, 30));
  EXPECT_NEAR(built.cloth.mass[end - 2] - built.cloth.mass[end - 1], 0.5, 1e-15);
  EXPECT_EQ(built.bodies.back()->vertex_count(), 3u) << "welded";
  EXPECT_EQ(built.bodies.size(), scene.bodies.size());
}

TEST_F(SceneFile, FabricsOfOneSceneKeepTheirOwnDamping) {
  const BuiltScene built = build_scene(read(R"({"geometry": [{"name": "a", "material": "m"},
    {"name": "b", "transformation": {"translation": [0, 0, 1]}}],
    "materials": {"m": {"spring_damping": 0.5, "bending_damping": 0}}})"));
  const std::int32_t second = built.piece_begin[1];
  for (const Spring& s : built.cloth.springs)
    ASSERT_EQ(s.damping, s.a < second ? 0.5 : Material{}.spring_damping);
  for (const Hinge& h : built.cloth.hinges)
    ASSERT_EQ(h.damping, h.v[0] < second ? 0.0 : Material{}.bending_damping);
}

TEST_F(SceneFile, EveryPatternMakesItsMesh) {
  const auto made = [&](const std::string& pattern) {
    const std::string piece = R"({"cells": [6, 4], "pattern": ")" + pattern + "\"}";
    return build_scene(read(R"({"geometry": [)" + piece + "]}")).cloth;
  };
  EXPECT_EQ(made("rectangular").springs.size(), 58u + 48);
  EXPECT_EQ(made("simplified").springs.size(), 58u + 24);
  EXPECT_EQ(made("checkerboard").springs.size(), 58u + 24);
  EXPECT_NE(made("checkerboard").surface.triangles, made("simplified").surface.triangles);
  EXPECT_TRUE(made("responsive").hinges.empty());
  EXPECT_FALSE(made("responsive").links.empty());
  EXPECT_EQ(made("arc").surface.vertices.size(), 1u + 6 * 4);
  EXPECT_EQ(made("triangular").springs.size(), made("triangular").edges.size());
}

/// A scene of one piece with a material of these laws.
std::string with_laws(const std::string& piece, const std::string& laws) {
  return R"({"geometry": [{"material": "m", )" + piece + R"(}], "materials": {"m": {)" + laws +
         "}}}";
}

TEST_F(SceneFile, EveryLawReachesTheMesh) {
  const auto made = [&](const std::string& laws) {
    return build_scene(read(with_laws(R"("cells": [4, 4])", laws))).cloth;
  };
  EXPECT_EQ(made(R"("stretch_law": "tension_only")").curves.at(0).law, StretchLaw::tension_only);
  EXPECT_EQ(made(R"("stretch_law": "biphasic")").curves.at(0).law, StretchLaw::biphasic);
  EXPECT_EQ(made(R"("stretch_law": "kawabata")").curves.at(0).law, StretchLaw::kawabata);
  EXPECT_TRUE(made(R"("stretch_law": "hooke")").curves.empty());
  EXPECT_EQ(made(R"("shear_law": "twisting")").twists.size(), 4u * 16);
  EXPECT_TRUE(made(R"("bending_law": "bridson")").hinges.at(0).sine);
  EXPECT_FALSE(made(R"("bending_law": "hinge")").hinges.at(0).sine);
  EXPECT_FALSE(made(R"("bending_law": "buckling")").links.empty());
  EXPECT_FALSE(made(R"("bending_law": "twisting")").twists.empty());
}

TEST_F(SceneFile, ALawThatAPatternCannotServeIsRefusedWithItsPlace) {
  const auto refusal = [&](const std::string& piece, const std::string& laws) -> std::string {
    try {
      build_scene(read(with_laws(piece, laws)));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_SAYS(refusal(R"("pattern": "triangular")", R"("bending_law": "twisting")"), "geometry[0]");
  EXPECT_SAYS(refusal(R"("pattern": "arc")", R"("bending_law": "buckling")"), "take \"hinge\"");
  EXPECT_SAYS(refusal(R"("pattern": "simplified")", R"("shear_law": "twisting")"), "rectangular");
  EXPECT_SAYS(refusal(R"("pattern": "arc", "size": [1, 2])", ""), "diameter");
}

TEST_F(SceneFile, ScalingClothScalesItsRestShape) {
  write("quad.obj", quad);
  for (const char* piece : {R"({"cells": [1, 1], "transformation": {"scale": 3}})",
                            R"({"mesh": "quad.obj", "transformation": {"scale": 3}})"}) {
    const BuiltScene built = build_scene(read(std::string(R"({"geometry": [)") + piece + "]}"));
    for (const Spring& s : built.cloth.springs) {
      const auto& x = built.cloth.surface.vertices;
      EXPECT_NEAR((x[s.a] - x[s.b]).norm(), s.rest_length, 1e-12);
    }
  }
}

TEST_F(SceneFile, AGridLaidAlongACurveKeepsItsLengths) {
  // Half a circle of radius 0.1 in the xz-plane, after and before a straight piece.
  std::string points = "[-0.2, 0, 0], [-0.1, 0, 0], [0, 0, 0]";
  for (int k = 1; k < 8; ++k) {
    const double angle = std::acos(-1.0) * k / 8;
    points += ", [" + std::to_string(0.1 * std::sin(angle)) + ", 0, " +
              std::to_string(0.1 - 0.1 * std::cos(angle)) + "]";
  }
  points += ", [0, 0, 0.2], [-0.1, 0, 0.2], [-0.2, 0, 0.2]";
  const BuiltScene built = build_scene(
      read(R"({"geometry": [{"size": [0.71416, 0.1], "cells": [140, 20], "path": {"points": [)" +
           points + "]}, \"transformation\": {\"translation\": [0, 0, 1]}}]}"));
  const auto& x = built.cloth.surface.vertices;
  // Chords of arcs of 5 mm are shorter by (5/100)²/24; the curve itself is a circle within 1 %.
  for (const Spring& s : built.cloth.springs)
    ASSERT_NEAR((x[s.a] - x[s.b]).norm() / s.rest_length, 1.0, 0.01);
  EXPECT_LT((x.front() - Vec3(-0.2, -0.05, 1)).norm(), 1e-12);
  EXPECT_LT((x.back() - Vec3(-0.2, 0.05, 1.2)).norm(), 1e-12);
}

TEST_F(SceneFile, APathThatDoesNotFitItsClothIsRefusedWithItsLength) {
  const auto with = [&](const std::string& path) {
    try {
      build_scene(
          read(R"({"geometry": [{"size": [1, 0.1], "cells": [50, 5], "path": )" + path + "}]}"));
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_SAYS(with(R"({"points": [[0, 0, 0], [2, 0, 0]]})"), "the curve is 2 m long");
  EXPECT_SAYS(with(R"({"points": [[0, 0, 0], [1, 0, 0]], "side": [1, 0, 0]})"), "\"side\"");
  EXPECT_SAYS(with(R"({"points": [[0, 0, 0], [0, 0, 0]]})"), "points 0 and 1 are the same");
  EXPECT_SAYS(with(R"({"points": [[0, 0, 0]]})"), "at least 2");
  EXPECT_EQ(with(R"({"points": [[0, 0, 0], [1, 0, 0]]})"), "");
}

TEST_F(SceneFile, DoubledVerticesOfClothAreRefusedBecauseTheyWouldCollide) {
  try {
    build_scene(read(R"({"geometry": [{"name": "c", "mesh": {
      "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
      "triangles": [[0, 1, 2], [3, 4, 5]]}}]})"));
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_SAYS(std::string(error.what()), "vertices 2 and 5 are at the same place");
    EXPECT_SAYS(std::string(error.what()), "weld");
  }
}

TEST_F(SceneFile, AThicknessAboveAnEdgeIsExplained) {
  const BuiltScene fine =
      build_scene(read(R"({"geometry": [{"size": [0.1, 0.1], "cells": [40, 40]}]})"));
  EXPECT_TRUE(fine.warnings.empty());
  const BuiltScene coarse = build_scene(read(
      R"({"geometry": [{"size": [0.1, 0.1], "cells": [40, 40]}], "contact": {"thickness": 0.005}})"));
  ASSERT_EQ(coarse.warnings.size(), 1u);
  EXPECT_SAYS(coarse.warnings[0], "geometry[0]");
  EXPECT_SAYS(coarse.warnings[0], "contact.thickness");
  EXPECT_SAYS(coarse.warnings[0], "0.0025");
}

TEST_F(SceneFile, AThicknessOfAPairAboveAnEdgeIsExplained) {
  const char* const text = R"({"geometry": [{"name": "a", "size": [0.1, 0.1], "cells": [40, 40]}],
    "contact": {"pairs": [{"a": "a", "b": "default", "thickness": 0.005}]}})";
  const BuiltScene coarse = build_scene(read(text));
  ASSERT_EQ(coarse.warnings.size(), 1u);
  EXPECT_SAYS(coarse.warnings[0], "contact.pairs) is 0.005 m");
}

TEST_F(SceneFile, AFaultyPairIsRefusedInOneSentence) {
  const auto says = [&](const std::string& pair, const std::string& part) {
    EXPECT_SAYS(fault(R"({"geometry": [{"name": "shirt"}, {"name": "both"}],
      "obstacles": [{"name": "ball", "shape": {"type": "sphere", "radius": 1}},
                    {"name": "both", "shape": {"type": "sphere", "radius": 1}}, {"name": "box",
        "shape": {"type": "box", "size": [1, 1, 1]}}], "contact": {"pairs": [)" +
                      pair + "]}}"),
                part);
  };
  says(R"({"a": "shirt", "b": "bal", "friction": 1})",
       "contact.pairs[0].b: there is no piece, material or obstacle \"bal\"; nearest is \"ball\"");
  says(R"({"a": "shrit", "b": "ball", "friction": 1})", "nearest is \"shirt\"");
  says(R"({"a": "defualt", "b": "ball", "friction": 1})", "nearest is \"default\"");
  says(R"({"a": "ball", "b": "box", "friction": 1})", "two obstacles");
  says(R"({"a": "shirt", "b": "both", "friction": 1})", "names more than one");
  says(R"({"a": "shirt", "b": "ball"})", "give it \"friction\" or \"thickness\"");
  says(R"({"a": "shirt", "friction": 1})", "needs the key \"b\"");
  says(R"({"a": "shirt", "b": "ball", "friction": -0.1})", "contact.pairs[0].friction");
  says(R"({"a": "shirt", "b": "ball", "thickness": 0})", "contact.pairs[0].thickness");
  says(R"({"a": "shirt", "b": "ball", "thickness": -1})", "contact.pairs[0].thickness");
  says(R"({"a": "shirt", "b": "ball", "thicknes": 1})", "nearest is \"thickness\"");
}

TEST_F(SceneFile, AMovingObstacleTurnsAboutItsOwnOrigin) {
  const BuiltScene built = build_scene(read(R"({"geometry": [{}], "obstacles": [{
    "shape": {"type": "box", "size": [2, 2, 2]}, "transformation": {"translation": [5, 0, 0]},
    "motion": [{"time": 0}, {"time": 1, "translation": [0, 0, 1], "rotation": {"axis": [0, 0, 1], "angle_deg": 180}}]}]})"));
  const Body& body = *built.bodies[0];
  std::vector<Vec3> start(body.vertex_count()), end(body.vertex_count());
  body.positions(0.0, start);
  body.positions(1.0, end);
  for (std::size_t i = 0; i < start.size(); ++i) {
    const Vec3 turned(10 - start[i].x(), -start[i].y(), start[i].z() + 1);
    EXPECT_LT((end[i] - turned).norm(), 1e-12);
  }
  EXPECT_FALSE(body.is_static(0.0, 1.0));
}

TEST_F(SceneFile, AnOpenBodyIsWarnedOf) {
  write("quad.obj", quad);
  const BuiltScene built = build_scene(
      read(R"({"geometry": [{}], "obstacles": [{"name": "sheet", "mesh": "quad.obj"}]})"));
  ASSERT_FALSE(built.warnings.empty());
  EXPECT_SAYS(built.warnings[0], "obstacles[0] (\"sheet\")");
}

TEST_F(SceneFile, ABadMeshIsRefusedWithThePlaceInTheScene) {
  const auto build_fault = [&](const std::string& text) {
    try {
      build_scene(read(text));
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  write("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
  write("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  write("empty.obj", "");
  write("cut.ply", "ply\nformat ascii 1.0\n");
  write("points.obj", "v 0 0 0\n");
  write("quad.obj", quad);
  write("other.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
  for (const char* name : {"range.obj", "nan.obj", "empty.obj", "cut.ply", "points.obj"}) {
    const std::string cloth =
        build_fault(std::string(R"({"geometry": [{"name": "c", "mesh": ")") + name + "\"}]}");
    EXPECT_SAYS(cloth, "geometry[0] (\"c\")");
    EXPECT_SAYS(cloth, name);
    const std::string body =
        build_fault(std::string(R"({"geometry": [{}], "obstacles": [{"name": "b", "mesh": ")") +
                    name + "\"}]}");
    EXPECT_SAYS(body, "obstacles[0] (\"b\")");
    EXPECT_SAYS(body, name);
  }
  EXPECT_SAYS(build_fault(R"({"geometry": [{"mesh": "quad.obj", "rest_mesh": "other.obj"}]})"),
              "same vertices and triangles");
  EXPECT_SAYS(
      build_fault(
          R"({"geometry": [{}], "obstacles": [{"sequence": {"files": ["quad.obj", "other.obj"]}}]})"),
      "same vertices and triangles");
}

}  // namespace
}  // namespace selvedge
