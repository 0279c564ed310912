// SPDX-License-Identifier: MIT
#include "scene_file.h"

namespace selvedge::scene_test {
namespace {

TEST_F(SceneFile, MissingFilesFoldersAndEmptyFilesAreNamed) {
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
      R"({"geometry": [{"size": [1, 2.5]}], "time": {"fps": 6e1}, "output": {"formats": ["vtk"]}})";
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
  EXPECT_SAYS(fault(R"({"geometry": [{}], "contact": {"rest_gab": 1}})"),
              "nearest is \"rest_gap\"");
  EXPECT_SAYS(fault(R"({"geometry": [{}], "time": {"frmaes": 1}})"), "time.frmaes");
  EXPECT_SAYS(fault(R"({"geometry": [{}], "materials": {"x": {"desnity": 1}}})"),
              "materials.x.desnity: unknown key; nearest is \"density\"");
  EXPECT_SAYS(
      fault(R"({"geometry": [{}], "obstacles": [{"shape": {"type": "sphere", "radious": 1}}]})"),
      "nearest is \"radius\"");
}

TEST_F(SceneFile, ASetOfAnUnknownKeyNamesTheNearestKey) {
  const char* const text = R"({"geometry": [{}], "time": {"frames": 3}})";
  EXPECT_SAYS(fault(text, {{"time.framez", "5"}}), "nearest is \"frames\"");
}

TEST_F(SceneFile, TheOldNameOfTheRestGapIsStillRead) {
  const char* const text = R"({"geometry": [{"name": "shirt"}], "contact": {"thickness": 0.003,
    "pairs": [{"a": "shirt", "b": "shirt", "thickness": 0.004}]}})";
  const Scene scene = read(text);
  EXPECT_EQ(scene.contact.rest_gap, 0.003);
  EXPECT_EQ(scene.contact.pairs.at(0).rest_gap, 0.004);
  EXPECT_EQ(scene.json.find("thickness"), std::string::npos);
  const Scene set = read_scene(write("old.json", text), {{"contact.thickness", "0.005"},
                                                         {"contact.pairs[0].thickness", "0.006"}});
  EXPECT_EQ(set.contact.rest_gap, 0.005);
  EXPECT_EQ(set.contact.pairs.at(0).rest_gap, 0.006);
}

TEST_F(SceneFile, TheRestGapUnderBothNamesIsRefused) {
  EXPECT_SAYS(
      fault("{\"geometry\": [{}], \"contact\": {\"rest_gap\": 0.001,\n\"thickness\": 0.001}}"),
      "line 2, contact.thickness: is the old name of \"rest_gap\", which is there, too; keep "
      "\"rest_gap\"");
  EXPECT_SAYS(fault(R"({"geometry": [{"name": "a"}], "contact": {"pairs":
    [{"a": "a", "b": "a", "thickness": 0.001, "rest_gap": 0.002}]}})"),
              "contact.pairs[0].thickness: is the old name");
}

TEST_F(SceneFile, AnOldKeyInTheWrongObjectIsStillAFault) {
  EXPECT_SAYS(fault(R"({"geometry": [{}], "contact": ["thickness"]})"), "contact: must be");
  EXPECT_SAYS(fault(R"({"geometry": [{}], "contact": {"pairs": {"thickness": 1}}})"),
              "contact.pairs: must be a list");
  EXPECT_SAYS(fault(R"({"geometry": [{}], "time": {"thickness": 1}})"), "time.thickness: unknown");
}

TEST_F(SceneFile, AKeyOfAnotherKindOfPieceIsRefused) {
  write("quad.obj", quad);
  EXPECT_SAYS(fault(R"({"geometry": [{"mesh": "quad.obj", "cells": [1, 1]}]})"),
              "geometry[0].cells: cannot be combined with the other keys");
  EXPECT_SAYS(
      fault(R"({"geometry": [{}], "obstacles": [{"shape": {"type": "sphere", "tube": 1}}]})"),
      "cannot be combined with");
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
        std::pair{"kawabata_strain", "0"}, std::pair{"kawabata_rt", "0"},
        std::pair{"kawabata_rt", "1.1"}, std::pair{"biphasic_strain", "-1"},
        std::pair{"biphasic_growth", "-1"}, std::pair{"bending_law", "plate"},
        std::pair{"stretch_law", "rubber"}, std::pair{"shear_law", "none"}})
    refused(std::string("materials.default.") + key, value);
  for (const char* value : {"0", "-0.001", "true", "null", "[]", "\"thick\"", "nan"})
    refused("contact.rest_gap", value);
  for (const char* value :
       {"0", "-5", "1.5", "1e10", "-9223372036854775808", "18446744073709551615", "x"})
    refused("time.frames", value);
  refused("time.fps", "0");
  refused("time.steps_per_frame", "0");
  refused("time.step_error", "-0.1");
  refused("time.sleep_speed", "-0.1");
  refused("time.max_halvings", "-1");
  refused("gravity", "[0, 0]");
  refused("gravity", "[0, 0, \"-9.81\"]");
  refused("solver.tolerance", "0");
  refused("solver.integrator", "euler");
  refused("solver.strain_limiter", "positon");
  refused("solver.strain_limiter", "1");
  refused("solver.error", "0");
  refused("solver.drag", "-1");
  refused("solver.max_newton", "0");
  refused("plan", "1");
  refused("closed_form", "slide");
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
  refused("output.camera.field_of_view", "180");
  refused("output.camera.target", "[1.6, -2.2, 1.4]");
  refused("geometry.0.size", "[1, 0]");
  refused("geometry.0.scale", "0");
  refused("geometry.0.pattern", "hexagonal");
  refused("geometry", "[]");
  refused("geometry", "{}");
}

TEST_F(SceneFile, AKeyThatIsGoneIsAnsweredUnlessItChangesNothing) {
  const auto with = [&](const std::string& path, const std::string& value) {
    return fault(R"({"geometry": [{}], "obstacles": [{"shape": {"type": "sphere"}}]})",
                 {{path, value}});
  };
  EXPECT_SAYS(with("output.vtk", "1"),
              "output.vtk: this key is gone: write \"output\": {\"formats\": [\"vtk\"]}");
  EXPECT_EQ(with("output.vtk", "false"), "");
  EXPECT_EQ(with("output.camera.width", "640"), "");
  EXPECT_SAYS(with("obstacles.0.transformation.scale", "2"),
              "obstacles[0].transformation.scale: this key is gone: give the sizes");
  EXPECT_EQ(with("obstacles.0.transformation.scale", "1.0"), "");
  EXPECT_SAYS(with("contact.broad_phase", R"({"type": "bvh_aabb", "leaf_size": 4})"),
              "contact.broad_phase.leaf_size: this key is gone");
  EXPECT_SAYS(with("materials", R"({"m": {"tension_curve": {"strain": [0, 1], "force": [1]}}})"),
              "tension_curve.strain: this key is gone: a curve is the list of its points");
  EXPECT_SAYS(with("geometry.0.pattern", R"({"type": "simplified_net", "alternating": true})"),
              "geometry[0].pattern.alternating: this key is gone: in pattern \"checkerboard\"");
}

TEST_F(SceneFile, CurvesOfTwoListsAreRead) {
  const auto law = [&](const std::string& curve) {
    const Scene scene =
        read(R"({"geometry": [{}], "materials": {"default": {"stretch_law": "measured",
                                 "tension_curve": )" +
             curve + "}}}");
    return scene.materials.at("default").tension_curve;
  };
  const MonotoneCurve points = law("[[0, 0], [0.1, 5], [0.2, 20]]");
  EXPECT_FALSE(points.empty());
  EXPECT_EQ(law(R"({"strain": [0, 0.1, 0.2], "force": [0, 5, 20]})"), points);
}

TEST_F(SceneFile, OldSwitchesOfOutputFormatsAreRead) {
  const auto formats = [&](const std::string& output) {
    return read(R"({"geometry": [{}], "output": )" + output + "}").output.formats;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(formats(R"({"vtk": true, "pc2": true})"), (Names{"vtk", "pc2"}));
  EXPECT_EQ(formats(R"({"pc2": true, "vtk": false, "formats": ["obj"]})"), (Names{"obj", "pc2"}));
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
      fault(R"({"geometry": [{"name": "a"}], "handles": [{"geometry": "b", "select": "x0"}]})"),
      "there is no geometry \"b\"");
  EXPECT_SAYS(fault(R"({"geometry": [{}], "handles": [{"select": "x0", "motion": "up"}]})"),
              "there is no motion \"up\"");
  EXPECT_SAYS(
      fault(R"({"geometry": [{"name": "a"}, {"name": "b"}], "handles": [{"select": "x0"}]})"),
      "needs the key \"geometry\"");
  EXPECT_SAYS(fault(R"({"geometry": [{"name": "a"}, {"name": "a"}]})"), "is taken");
}

TEST_F(SceneFile, APinThatDoesNotExistIsRefused) {
  const auto with = [&](const std::string& select) {
    return fault(R"({"geometry": [{"name": "g", "cells": [2, 3]}], "handles": [{"select": )" +
                 select + "}]}");
  };
  EXPECT_SAYS(with("[0, 12]"),
              "handles[0].select[1]: there is no vertex 12; \"g\" has vertices 0 to 11");
  EXPECT_SAYS(with("[-1]"), "must be at least 0");
  EXPECT_SAYS(with("[]"), "at least 1");
  EXPECT_SAYS(with(R"({"box": [[5, 5, 5], [6, 6, 6]]})"),
              "selects nothing; \"g\" lies from (-0.5, -0.5, 0) to (0.5, 0.5, 0) m");
  EXPECT_SAYS(with(R"({"box": [[1, 0, 0], [0, 1, 1]]})"), "must be the lowest");
  EXPECT_SAYS(with(R"(["x2y0"])"), "unknown value");
  EXPECT_SAYS(with(R"("x2")"), "nearest is \"x0\"");
  EXPECT_SAYS(with(R"({})"), "or an object with \"box\"");
  EXPECT_SAYS(with(R"({"edge": "x0", "vertices": [1]})"), "or an object with \"box\"");
}

TEST_F(SceneFile, AVertexHeldTwiceIsRefused) {
  EXPECT_SAYS(fault(R"({"geometry": [{"name": "g"}], "handles": [
    {"name": "one", "select": "x0"}, {"select": ["x0y0"]}]})"),
              "vertex 0 of \"g\" is held by \"one\" already");
}

TEST_F(SceneFile, KeyframesMustRiseAndAHandleMustStartWhereItIs) {
  const auto with = [&](const std::string& motion) {
    return fault(R"({"geometry": [{}], "handles": [{"select": "x0", "motion": )" + motion + "}]}");
  };
  EXPECT_SAYS(with(R"([{"time": 0}, {"time": 0}])"), "handles[0].motion[1].time: must be later");
  EXPECT_SAYS(with(R"([{"time": 0, "translation": [0, 0, 1]}])"), "must not translate or rotate");
  EXPECT_SAYS(with(R"([{"translation": [0, 0, 1]}])"), "needs the key \"time\"");
  EXPECT_EQ(with(R"([{"time": 1}, {"time": 2, "translation": [0, 0, 1]}])"), "");
}

TEST_F(SceneFile, CornersAndEdgesOfAGridAreTheRightOnes) {
  const Scene s = read(
      R"({"geometry": [{"cells": [2, 3], "transformation": {"rotation": {"axis": [1, 0, 0], "angle_deg": 90}}}],
    "handles": [{"select": ["x1y0", "x0y1"]}, {"select": "y0"}]})",
      {{"handles.1.select", "x1"}, {"handles.0.select", "[\"x0y1\"]"}});
  EXPECT_EQ(s.handles[0].vertices, (std::vector<std::int32_t>{9}));
  EXPECT_EQ(s.handles[1].vertices, (std::vector<std::int32_t>{2, 5, 8, 11}));
}

TEST_F(SceneFile, SidesCornersAndNumbersAreSelectedTogether) {
  const Scene s =
      read(R"({"geometry": [{"cells": [2, 3]}], "handles": [{"select": ["y0", 4, "x1y1", 4]}]})");
  EXPECT_EQ(s.handles[0].vertices, (std::vector<std::int32_t>{0, 1, 2, 4, 11}));
}

TEST_F(SceneFile, OldFormsOfKeysAreRead) {
  write("quad.obj", garment);
  const Scene old =
      read(R"({"geometry": [{"name": "g", "cells": [2, 3], "transformation": {"scale": 2}},
      {"name": "m", "mesh": "quad.obj", "rest": "texture"}, {"name": "n", "mesh": "quad.obj", "rest": "mesh"}],
    "handles": [{"geometry": "g", "select": {"edge": "y0"}}],
    "weights": [{"geometry": "g", "select": {"vertices": [4, 3]}, "mass": 1}],
    "seams": [{"a": {"geometry": "g", "select": {"vertices": [9, 6]}}, "b": {"geometry": "g", "select": {"corners": ["x0y0", "x1y0"]}}}],
    "water": {"sources": [{"geometry": "g", "select": {"corners": ["x1y1"]}, "rate": 1}]},
    "obstacles": [{"name": "slope", "shape": {"type": "capsule", "length": 0.7}}],
    "closed_form": {"motion": "incline", "body": "slope"}})",
           {{"geometry.0.transformation.scale", "3"}});
  EXPECT_EQ(old.cloths[0].scale, 3.0);
  EXPECT_EQ(std::get<ClothFile>(old.cloths[1].shape).texture_unit, 1.0);
  EXPECT_EQ(std::get<ClothFile>(old.cloths[2].shape).texture_unit, 0.0);
  EXPECT_EQ(old.handles[0].vertices, (std::vector<std::int32_t>{0, 1, 2}));
  EXPECT_EQ(old.weights[0].vertices, (std::vector<std::int32_t>{3, 4}));
  EXPECT_EQ(old.seams[0].vertices[0], (std::vector<std::int32_t>{9, 6}));
  EXPECT_EQ(old.seams[0].vertices[1], (std::vector<std::int32_t>{0, 2}));
  EXPECT_EQ(old.water->sources[0].vertices, (std::vector<std::int32_t>{11}));
  EXPECT_EQ(std::get<Capsule>(std::get<BodyShape>(old.bodies[0].shape).shape).length, 0.7);
  EXPECT_EQ(old.closed_form, ClosedForm::incline);
}

TEST_F(SceneFile, CornersOfAMeshAreRefused) {
  write("quad.obj", quad);
  EXPECT_SAYS(fault(R"({"geometry": [{"mesh": "quad.obj"}], "handles": [{"select": "x0"}]})"),
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

TEST_F(SceneFile, ANumberThatIsMissingInASequenceIsNamed) {
  for (const char* name : {"walk_00.obj", "walk_01.obj", "walk_07.obj", "walk_03.obj", "walk_.obj",
                           "walk_-9.obj", "walk_0x.obj"})
    write(name, quad);
  EXPECT_SAYS(fault(R"({"geometry": [{}], "obstacles": [{"sequence": {"files": "walk_##.obj"}}]})"),
              "files: number 2 is missing although walk_03.obj exists");
}

}  // namespace
}  // namespace selvedge::scene_test
