// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/detail/rest_gap.h>
#include <selvedge/scene/fabric_file.h>

#include "scene_file.h"

#include <algorithm>
#include <cmath>

namespace selvedge::scene_test {
namespace {

TEST_F(EverythingFile, PiecesAreJoinedScaledTurnedAndMoved) {
  Scene scene = read_everything();
  scene.perturbation.speed = 0.0;
  scene.contact.self = true;  // which the body with a mass needs
  const BuiltScene built = build_scene(scene);
  ASSERT_EQ(built.piece_begin.size(), 18u);
  EXPECT_EQ(built.piece_begin[0], 0);
  const auto& x = built.cloth.surface.vertices;
  EXPECT_EQ(static_cast<std::size_t>(built.piece_begin[17]), x.size());
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
  EXPECT_EQ(built.bodies[10]->vertex_count(), 3u) << "welded";
  EXPECT_EQ(built.bodies[11]->vertex_count(), 4u) << "the object skin and the material pale";
  // The skirt, after which only the body with a mass comes, is flat at rest.
  const auto skirt = built.piece_begin[16] - built.piece_begin[15];
  ASSERT_GT(skirt, 50);
  const auto end_of_skirt =
      built.rest.vertices.end() - (built.piece_begin[17] - built.piece_begin[16]);
  for (auto p = end_of_skirt - skirt; p != end_of_skirt; ++p) ASSERT_EQ(p->z(), 0.0);
  EXPECT_EQ(built.bodies.size(), scene.bodies.size());
}

TEST_F(SceneFile, WeldTakesADistanceAndSaysWhatItJoined) {
  const auto body = [&](const char* weld) {
    return build_scene(read(std::string(R"({"geometry": [{"name": "a"}], "obstacles": [{"mesh": {
        "vertices": [[0, 0, 9], [1, 0, 9], [0, 1, 9], [1, 1e-6, 9], [1, 1, 9], [0, 1, 9]],
        "triangles": [[0, 1, 2], [3, 4, 5]]}, "weld": )") +
                            weld + "}]}"));
  };
  const BuiltScene near = body("1e-5");
  EXPECT_EQ(near.bodies[0]->vertex_count(), 4u);
  EXPECT_SAYS(near.warnings.at(0), "1 of 5 vertices were joined");
  EXPECT_SAYS(near.warnings.at(0), "1e-06 m");
  EXPECT_SAYS(body("1e-7").warnings.at(0), "none were joined");
  EXPECT_EQ(body("true").bodies[0]->vertex_count(), 5u);
  EXPECT_EQ(body("false").bodies[0]->vertex_count(), 6u);
  EXPECT_THROW(body("0"), std::invalid_argument);
  EXPECT_THROW(body("\"near\""), std::invalid_argument);
}

TEST_F(SceneFile, APerturbationAddsVelocitiesUpToItsSpeedByItsSeed) {
  Scene scene = read(R"({"geometry": [{"name": "a", "cells": [20, 20], "velocity": [1, 0, 0]}]})");
  const auto velocities = [&](double speed, std::uint64_t seed) {
    scene.perturbation = {speed, seed};
    return build_scene(scene).velocity;
  };
  constexpr double speed = 1e-3;
  const auto v = velocities(speed, 3);
  EXPECT_EQ(v, velocities(speed, 3));
  EXPECT_NE(v, velocities(speed, 4));
  EXPECT_EQ(velocities(0.0, 3), std::vector<Vec3>(v.size(), Vec3(1, 0, 0)));
  Vec3 sum = Vec3::Zero(), squares = Vec3::Zero();
  double largest = 0.0;
  for (const Vec3& of_particle : v) {
    const Vec3 added = of_particle - Vec3(1, 0, 0);
    sum += added;
    squares += added.cwiseAbs2();
    largest = std::max(largest, added.cwiseAbs().maxCoeff());
  }
  const double n = static_cast<double>(v.size());
  EXPECT_LE(largest, speed * (1.0 + 1e-12));
  // Uniform numbers: no mean, and a third of the square of the largest. Bounds of four sigma.
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(sum[k] / n, 0.0, 4.0 * speed / std::sqrt(3.0 * n));
    EXPECT_NEAR(squares[k] / n, speed * speed / 3.0, 4.0 * 0.3 * speed * speed / std::sqrt(n));
  }
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
  EXPECT_EQ(made(R"("stretch_law": "tension_only")").curves.at(0).law, "tension_only");
  EXPECT_EQ(made(R"("stretch_law": "biphasic")").curves.at(0).law, "biphasic");
  EXPECT_EQ(made(R"("stretch_law": "kawabata")").curves.at(0).law, "kawabata");
  EXPECT_TRUE(made(R"("stretch_law": "hooke")").curves.empty());
  EXPECT_EQ(made(R"("shear_law": "twisting")").twists.size(), 4u * 16);
  EXPECT_TRUE(made(R"("bending_law": "bridson")").hinges.at(0).sine);
  EXPECT_FALSE(made(R"("bending_law": "hinge")").hinges.at(0).sine);
  EXPECT_FALSE(made(R"("bending_law": "buckling")").links.empty());
  EXPECT_FALSE(made(R"("bending_law": "twisting")").twists.empty());
  EXPECT_FALSE(made(R"("bending_law": "beam")").beams.empty());
}

TEST_F(SceneFile, FiniteElementsHaveTheConstantsOfTheScene) {
  const auto made = [&](const std::string& law) {
    const std::string laws = R"("stretch_law": ")" + law +
                             R"(", "stretch_stiffness": 300, "poisson": 0.5, "shear_stiffness": 7)";
    return build_scene(read(with_laws(R"("cells": [4, 4])", laws))).cloth.membranes;
  };
  for (const auto& [name, strain] : {std::pair{"corotated", MembraneStrain::corotated},
                                     std::pair{"st_venant_kirchhoff", MembraneStrain::green}}) {
    const auto membranes = made(name);
    ASSERT_EQ(membranes.size(), 32u);
    EXPECT_EQ(membranes[0].strain, strain);
    EXPECT_NEAR(membranes[0].c11, 400.0, 1e-9);
    EXPECT_NEAR(membranes[0].c12, 200.0, 1e-9);
    EXPECT_EQ(membranes[0].c33, 7.0);
  }
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
  EXPECT_SAYS(refusal(R"("pattern": "arc")", R"("bending_law": "buckling")"), "\"hinge\"");
  EXPECT_SAYS(refusal(R"("pattern": "simplified")", R"("shear_law": "twisting")"), "rectangular");
  EXPECT_SAYS(refusal(R"("pattern": "arc", "size": [1, 2])", ""), "diameter");
  EXPECT_SAYS(refusal(R"("pattern": "responsive")", R"("stretch_law": "corotated")"), "tension");
  for (const BendingLaw& law : fabric_laws().bending) {
    const bool served = law.name == "buckling" || law.name == Material{}.bending_law;
    const std::string given = R"("bending_law": ")" + law.name + "\"";
    const std::string sentence = refusal(R"("pattern": "responsive")", given);
    EXPECT_EQ(sentence.find("has no effect") != std::string::npos, !served) << law.name << sentence;
  }
  EXPECT_SAYS(refusal(R"("pattern": "rectangular")", R"("poisson": 0.2)"), "corotated");
  EXPECT_SAYS(refusal(R"("pattern": {"type": "triangular"}, "plate": 0.3)",
                      R"("stretch_law": "corotated")"),
              "plate");
  EXPECT_SAYS(
      refusal(R"("pattern": {"type": "triangular"}, "plate": 0.3)", R"("shear_law": "angle")"),
      "take shear_law \"springs\"");
}

TEST_F(SceneFile, AnArcMeshSaysWhichStiffnessItHas) {
  const auto warning = [&](const std::string& laws) -> std::string {
    const BuiltScene built =
        build_scene(read(with_laws(R"("pattern": "arc", "cells": [24, 8], "size": [0.3, 0.3])",
                                   R"("stretch_stiffness": 500, )" + laws)));
    return built.warnings.empty() ? "" : built.warnings[0];
  };
  const std::string shear = warning(R"("shear_stiffness": 40)");
  EXPECT_SAYS(shear, "(asked: 40)");
  EXPECT_SAYS(shear, "geometry[0]");
  EXPECT_SAYS(warning(R"("shear_stiffness": 40, "stretch_weft": 300)"), "300 along the weft");
  EXPECT_EQ(warning(R"("shear_stiffness": 40, "shear_law": "angle")"), "");
  EXPECT_EQ(warning(R"("shear_stiffness": 40, "stretch_law": "corotated")"), "");
}

TEST_F(SceneFile, EveryLawIsReadAndWrittenByItsName) {
  const auto each = [&](const auto& laws, const char* key, auto member) {
    for (const auto& law : laws) {
      Material m;
      m.*member = law.name;
      EXPECT_EQ(Json::parse(material_json(m))[key], law.name);
      const Scene s = read(
          with_laws("\"cells\": [2, 2]", "\"" + std::string(key) + "\": \"" + law.name + "\""));
      EXPECT_EQ(s.materials.at("m").*member, law.name);
    }
  };
  each(fabric_laws().stretch, "stretch_law", &Material::stretch_law);
  each(fabric_laws().shear, "shear_law", &Material::shear_law);
  each(fabric_laws().bending, "bending_law", &Material::bending_law);
  EXPECT_THROW(make_rectangular({1, 1, 2, 2}, {.bending_law = "plate"}), std::invalid_argument);
}

TEST_F(SceneFile, ScalingClothScalesItsRestShape) {
  write("quad.obj", quad);
  for (const char* piece :
       {R"({"cells": [1, 1], "scale": 3})", R"({"mesh": "quad.obj", "scale": 3})"}) {
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

TEST_F(SceneFile, APathThatDoesNotFitItsClothIsRefused) {
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

TEST_F(SceneFile, ATurnAboveHalfACircleBetweenKeyframesIsNamed) {
  const auto warnings = [&](const std::string& rotations, const std::string& more = "") {
    return build_scene(read(R"({"geometry": [{"name": "a"}], "obstacles": [{"name": "box",
        "shape": {"type": "box"}, "transformation": {"translation": [0, 0, -2]}, "motion": )" +
                            rotations + "}]" + more + "}"))
        .warnings;
  };
  const auto turned = [](const std::vector<std::string>& rotations) {
    std::string keys = R"([{"time": 0})";
    for (std::size_t i = 0; i < rotations.size(); ++i)
      keys += fmt::format(R"(, {{"time": {}, "rotation": {}}})", i + 1, rotations[i]);
    return keys + "]";
  };
  const auto about = [](const char* axis, double angle) {
    return fmt::format(R"({{"axis": {}, "angle_deg": {}}})", axis, angle);
  };
  const char *const z = "[0, 0, 1]", *const down = "[0, 0, -2]", *const x = "[1, 0, 0]";
  for (const double angle : {181.0, 360.0, -360.0, 540.0, 720.0, 3600.0}) {
    const auto found = warnings(turned({about(z, angle)}));
    ASSERT_EQ(found.size(), 1u) << angle;
    EXPECT_SAYS(found[0], "obstacles[0].motion[1].rotation");
    EXPECT_SAYS(found[0], fmt::format("{:g} degrees", std::abs(angle)));
    EXPECT_SAYS(found[0], "keyframes in between");
  }
  for (const double angle : {0.0, 90.0, 180.0, -180.0})
    EXPECT_TRUE(warnings(turned({about(z, angle)})).empty()) << angle;
  EXPECT_TRUE(
      warnings(turned({about(z, 120), about(z, 240), about(z, 360), about(z, 480)})).empty());
  EXPECT_TRUE(warnings(turned({about(z, 90), about(down, 90)})).empty());
  EXPECT_SAYS(warnings(turned({about(z, 100), about(down, 100)})).at(0), "200 degrees");
  EXPECT_SAYS(warnings(turned({about(z, 100), "[]", about(z, 200)})).at(0), "motion[3]");
  EXPECT_SAYS(warnings(turned({"[" + about(z, 170) + ", " + about(z, 40) + "]"})).at(0), "210");
  EXPECT_TRUE(warnings(turned({about(z, 90), about(x, 90)})).empty());
  EXPECT_EQ(warnings(turned({about(z, 170), about(x, -170), about(x, 170)})).size(), 1u);
  const auto named = warnings(
      "\"spin\"", R"(, "motions": {"spin": )" + turned({about(z, 360)}) +
                      R"(}, "handles": [{"geometry": "a", "select": "x0", "motion": "spin"}])");
  ASSERT_EQ(named.size(), 1u) << "one motion, used twice";
  EXPECT_SAYS(named[0], "motions.spin[1].rotation");
}

TEST_F(SceneFile, ARestGapAboveAnEdgeIsExplained) {
  const BuiltScene fine =
      build_scene(read(R"({"geometry": [{"size": [0.1, 0.1], "cells": [40, 40]}]})"));
  EXPECT_TRUE(fine.warnings.empty());
  const BuiltScene coarse = build_scene(read(
      R"({"geometry": [{"size": [0.1, 0.1], "cells": [40, 40]}], "contact": {"rest_gap": 0.005}})"));
  ASSERT_EQ(coarse.warnings.size(), 1u);
  EXPECT_SAYS(coarse.warnings[0], "geometry[0]");
  EXPECT_SAYS(coarse.warnings[0], "contact.rest_gap");
  EXPECT_SAYS(coarse.warnings[0], "0.0025");
}

TEST_F(SceneFile, ARestGapOfManyCellsIsRefusedIfItTakesGigabytes) {
  const auto scene = [](int cells, const std::string& more, const std::string& contact) {
    const std::string n = std::to_string(cells);
    return R"({"geometry": [{"name": "c", "size": [0.001, 0.001], "cells": [)" + n + ", " + n +
           R"(], "transformation": {"translation": [0, 0, 0.01]}}], "obstacles": [{"name": "b", "shape": {"type": "sphere", "radius": )" +
           more + R"(}}], "contact": {"rest_gap": 0.002)" + contact + "}}";
  };
  const auto refused = [&](const std::string& text) {
    try {
      build_scene(read(text));
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("built");
  };
  EXPECT_SAYS(refused(scene(30, "0.0003", "")), "would be in reach at once");
  EXPECT_SAYS(refused(scene(30, "0.0003", R"(, "self": false)")), "geometry[0] (\"c\")");
  EXPECT_SAYS(refused(scene(45, "0.5", "")), "would be in reach at once");
  EXPECT_NO_THROW(build_scene(read(scene(10, "0.0003", ""))));
  EXPECT_NO_THROW(build_scene(read(scene(30, "0.5", "")))) << "the ball has few vertices in reach";
  const std::string apart = R"(, "pairs": [{"a": "c", "b": "b", "collide": false}])";
  EXPECT_NO_THROW(build_scene(read(scene(20, "0.0003", apart))));
}

TEST_F(SceneFile, VerticesWithoutTrianglesAreInNoPair) {
  const std::vector<Vec3> x{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}, {6, 6, 6}};
  const detail::SurfaceGrain grain = detail::grain_of(x, std::vector<Triangle>{{0, 1, 2}});
  EXPECT_EQ(grain.vertices, 3.0);
  EXPECT_EQ(grain.area, 0.5);
}

TEST_F(SceneFile, ARestGapOfAPairAboveAnEdgeIsExplained) {
  const char* const text = R"({"geometry": [{"name": "a", "size": [0.1, 0.1], "cells": [40, 40]}],
    "contact": {"pairs": [{"a": "a", "b": "default", "rest_gap": 0.005}]}})";
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
  says(R"({"a": "shirt", "b": "ball"})", "give it \"friction\", \"rest_gap\" or \"collide\"");
  says(R"({"a": "shirt", "friction": 1})", "needs the key \"b\"");
  says(R"({"a": "shirt", "b": "ball", "friction": -0.1})", "contact.pairs[0].friction");
  says(R"({"a": "shirt", "b": "ball", "rest_gap": 0})", "contact.pairs[0].rest_gap");
  says(R"({"a": "shirt", "b": "ball", "rest_gap": -1})", "contact.pairs[0].rest_gap");
  says(R"({"a": "shirt", "b": "ball", "rest_gab": 1})", "nearest is \"rest_gap\"");
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

/// Stiffness of the springs of a piece along a direction of space, over that across it.
double stiffness_ratio(const BuiltScene& built, std::size_t piece, const Vec3& along,
                       const Vec3& across) {
  double warp = 0.0, weft = 0.0;
  for (const Spring& spring : built.cloth.springs) {
    if (spring.a < built.piece_begin[piece] || spring.a >= built.piece_begin[piece + 1]) continue;
    const Vec3 way =
        (built.cloth.surface.vertices[spring.b] - built.cloth.surface.vertices[spring.a])
            .normalized();
    warp += spring.stiffness * std::pow(way.dot(along), 4);
    weft += spring.stiffness * std::pow(way.dot(across), 4);
  }
  return warp / weft;
}

TEST_F(SceneFile, TheWarpOfASewingPatternRunsAlongItsGrain) {
  for (const bool is_across : {false, true}) {
    const std::string grain = is_across ? R"("grain": [-1, 0],)" : "";
    write("flag.json", R"({"pattern": {"panels": {"flag": {
      "translation": [0, 10, 0], "rotation": [0, 0, 0], )" +
                           grain + R"(
      "vertices": [[0, 0], [40, 0], [40, 60], [0, 60]],
      "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]}, {"endpoints": [3, 0]}]}},
      "stitches": [[{"panel": "flag", "edge": 1}, {"panel": "flag", "edge": 3}]]},
      "properties": {"units_in_meter": 100, "curvature_coords": "relative"}})");
    const BuiltScene built = build_scene(read(R"({"gravity": [0, 0, 0],
      "geometry": [{"name": "flag", "sewing_pattern": "flag.json", "edge_length": 0.03, "up": "y", "material": "cloth"}],
      "materials": {"cloth": {"stretch_stiffness": 90, "stretch_weft": 30, "shear_stiffness": 10}}})"));
    // y of the panel stands upright.
    const double ratio = stiffness_ratio(built, 0, Vec3::UnitZ(), Vec3::UnitX());
    if (is_across)
      EXPECT_LT(ratio, 0.6);
    else
      EXPECT_GT(ratio, 1.7);
  }
}

}  // namespace
}  // namespace selvedge::scene_test
