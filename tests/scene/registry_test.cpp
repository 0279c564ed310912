// SPDX-License-Identifier: MIT
//
// The registries: what they refuse and how they say it, that every option reaches its method and
// scene files, and that a method made by name is the one that its make function makes.
#include <gtest/gtest.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/internal/minimal_enclosure.h>
#include <selvedge/compare/compare_plan.h>
#include <selvedge/core/base/registry.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/scene/methods.h>
#include <selvedge/scene/scene.h>

#include <functional>
#include <random>

#include "scene_file.h"

namespace selvedge::registry_test {
namespace {

// -- the template with a family of its own --------------------------------------------------------

struct Shape {
  virtual ~Shape() = default;
  struct Traits {
    std::string promise, source;
  };
  Traits traits() const { return {.promise = "has an area", .source = "Euclid, Elements"}; }
  double area = 0.0;
};
using Shapes = Registry<std::unique_ptr<Shape>, Shape::Traits, double>;

Shapes shapes() {
  Shapes registry;
  registry.add(
      "square",
      {{.name = "side", .initial = 2.0, .unit = "m", .least = 0.0, .above_least = true},
       {.name = "count", .initial = 1.0, .unit = "1", .most = 9.0, .kind = OptionKind::whole},
       {.name = "hollow", .kind = OptionKind::boolean}},
      [](const MethodOptions& o, double scale) {
        auto shape = std::make_unique<Shape>();
        shape->area = o.flag("hollow") ? 0.0 : scale * o.whole("count") * o["side"] * o["side"];
        return shape;
      });
  registry.add("point", {}, [](const MethodOptions&, double) { return std::make_unique<Shape>(); });
  registry.add_absent("spline", "libspline");
  return registry;
}

std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Registry, MakesAMethodWithDefaultsOptionsAndArguments) {
  const Shapes registry = shapes();
  EXPECT_EQ(registry.at("square")(1.0)->area, 4.0);
  EXPECT_EQ(registry.at("square")({{"side", 3.0}, {"count", 2.0}}, 10.0)->area, 180.0);
  EXPECT_EQ(registry.at("square")({{"hollow", 1.0}}, 1.0)->area, 0.0);
  EXPECT_EQ(registry.at("square").promise(), "has an area");
  EXPECT_EQ(registry.at("square").source(), "Euclid, Elements");
  EXPECT_EQ(registry.names(), (std::vector<std::string>{"point", "square"}));
}

TEST(Registry, NamesTheNearestMethodAndAllOthers) {
  const Shapes registry = shapes();
  EXPECT_EQ(refusal([&] { registry.at("sqaure"); }),
            "there is no \"sqaure\" in this build; nearest is \"square\", known are \"point\", "
            "\"square\"");
  EXPECT_EQ(refusal([&] { registry.at("spline"); }),
            "\"spline\" needs libspline, which this build does not have");
}

TEST(Registry, RefusesAnUnknownOptionAndNamesTheNearest) {
  const Shapes registry = shapes();
  EXPECT_EQ(refusal([&] {
              registry.at("square")({{"sides", 1.0}}, 1.0);
            }),
            "square: has no option \"sides\"; nearest is \"side\", known are \"side\", \"count\", "
            "\"hollow\"");
  EXPECT_EQ(refusal([&] {
              registry.at("point")({{"side", 1.0}}, 1.0);
            }),
            "point: has no option \"side\" and no other option");
}

TEST(Registry, RefusesAValueOutOfRangeOrOfAnotherKind) {
  const Shapes registry = shapes();
  const auto fault = [&](const std::string& option, double value) {
    return refusal([&] { registry.at("square")({{option, value}}, 1.0); });
  };
  EXPECT_EQ(fault("side", 0.0), "square: needs \"side\" to be greater than 0, is 0");
  EXPECT_EQ(fault("count", 9.5), "square: needs \"count\" to be a whole number, is 9.5");
  EXPECT_EQ(fault("count", 10.0), "square: needs \"count\" to be at most 9, is 10");
  EXPECT_EQ(fault("hollow", 0.5), "square: needs \"hollow\" to be true or false, is 0.5");
  EXPECT_EQ(fault("side", std::nan("")), "square: needs \"side\" to be finite, is nan");
  EXPECT_EQ(fault("side", 0.1), "");
}

TEST(Registry, AnAbsentMethodBecomesAvailableWhenItIsAdded) {
  Shapes registry = shapes();
  EXPECT_EQ(registry.absent().at("spline"), "libspline");
  registry.add("spline", {},
               [](const MethodOptions&, double) { return std::make_unique<Shape>(); });
  EXPECT_TRUE(registry.absent().empty());
  EXPECT_EQ(registry.at("spline").library(), "libspline");
  registry.add_absent("square", "nothing");
  EXPECT_TRUE(registry.absent().empty());
}

TEST(Registry, KeepsTheOrderInWhichMethodsWereAdded) {
  Shapes registry = shapes();
  const auto order = [&] {
    std::vector<std::string> names;
    for (const auto* entry : registry.in_order()) names.push_back(entry->name());
    return names;
  };
  const auto none = [](const MethodOptions&, double) { return std::make_unique<Shape>(); };
  registry.add("circle", {}, none);
  EXPECT_EQ(order(), (std::vector<std::string>{"square", "point", "circle"}));
  registry.add("square", {}, none);
  EXPECT_EQ(order(), (std::vector<std::string>{"square", "point", "circle"}));
  registry.erase("point");
  registry.add("point", {}, none);
  EXPECT_EQ(order(), (std::vector<std::string>{"square", "circle", "point"}));
}

TEST(Registry, NamesTheKeyOfAMethodThatHasItsOwn) {
  Shapes registry = shapes();
  registry.add_keyed("disc", "round.shape", {.promise = "has a rim", .source = "Archimedes"});
  EXPECT_FALSE(registry.contains("disc"));
  EXPECT_EQ(refusal([&] { registry.at("disc"); }),
            "\"disc\" is selected by the key \"round.shape\", not by name");
  const auto listed = list_family("shape", "shapes", registry);
  ASSERT_EQ(listed.size(), 4u);
  EXPECT_EQ(listed[2].name, "disc");
  EXPECT_EQ(listed[2].key, "round.shape");
  EXPECT_TRUE(listed[2].keyed);
  EXPECT_EQ(listed[3].name, "spline");
  EXPECT_FALSE(listed[3].available);
  registry.add("disc", {}, [](const MethodOptions&, double) { return std::make_unique<Shape>(); });
  EXPECT_EQ(registry.at("disc")(1.0)->area, 0.0);
  EXPECT_TRUE(registry.keyed().empty());
}

// -- the families ---------------------------------------------------------------------------------

TEST(Methods, EachHasAPromiseASourceAndDescribedOptions) {
  std::size_t options = 0;
  for (const ListedMethod& method : list_methods(methods_of_this_build())) {
    EXPECT_FALSE(method.promise.empty()) << method.key << " " << method.name;
    if (method.available && method.name != "none") {
      EXPECT_FALSE(method.source.empty()) << method.key << " " << method.name;
    }
    for (const MethodOption& option : method.options) {
      const std::string place = method.name + "." + option.name;
      EXPECT_EQ(option_fault(method.options, option.name, option.initial), "") << place;
      EXPECT_EQ(option.unit.empty(), option.kind == OptionKind::boolean) << place;
      EXPECT_FALSE(option.meaning.empty()) << place;
      ++options;
    }
  }
  EXPECT_GT(options, 40u);
}

// Random triangles that move; some nearly touch, some cross.
struct Soup {
  explicit Soup(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const auto point = [&](double size) {
      return Vec3(size * unit(random), size * unit(random), size * unit(random));
    };
    for (std::int32_t t = 0; t < 60; ++t) {
      const Vec3 corner = point(1.0);
      for (int k = 0; k < 3; ++k) x_t0.push_back(corner + point(0.2));
      triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
      edges.insert(edges.end(), {{3 * t, 3 * t + 1}, {3 * t, 3 * t + 2}, {3 * t + 1, 3 * t + 2}});
    }
    for (const Vec3& x : x_t0) x_t1.push_back(x + point(0.1));
  }
  SurfaceView view() const {
    return {.x_t0 = x_t0, .x_t1 = x_t1, .edges = edges, .triangles = triangles, .thickness = 0.01};
  }
  std::vector<Vec3> x_t0, x_t1;
  std::vector<Edge> edges;
  std::vector<Triangle> triangles;
};

TEST(Methods, ADetectorMadeByNameReportsThePairsOfItsMakeFunction) {
  const std::map<std::string, std::function<std::unique_ptr<BroadPhase>()>> made{
      {"brute_force", [] { return make_brute_force(); }},
      {"bvh_aabb", [] { return make_bvh_aabb(); }},
      {"bvh_kdop6", [] { return make_bvh_kdop(6); }},
      {"bvh_kdop14", [] { return make_bvh_kdop(14); }},
      {"bvh_kdop18", [] { return make_bvh_kdop(18); }},
      {"bvh_kdop26", [] { return make_bvh_kdop(26); }},
      {"bvh_obb", [] { return make_bvh_obb(); }},
      {"curvature_cone", [] { return make_curvature_cone(); }},
      {"hash_grid", [] { return make_hash_grid(); }},
      {"minimal_enclosure", [] { return make_minimal_enclosure(); }},
      {"normal_cone", [] { return make_normal_cone(); }},
      {"sweep_and_prune", [] { return make_sweep_and_prune(); }},
      {"uniform_grid", [] { return make_uniform_grid(); }},
      {"verlet_bvh", [] { return make_verlet_list(make_bvh_aabb()); }},
      {"voxel", [] { return make_voxel(); }}};
  const BroadPhaseRegistry registry = broad_phases();
  EXPECT_EQ(registry.size(), made.size());
  const Soup a(1), b(2);
  for (const auto& [name, make] : made) {
    CandidatePairs by_name, by_function;
    const auto detector = registry.at(name)();
    const auto other = make();
    detector->find_pairs(a.view(), b.view(), by_name);
    other->find_pairs(a.view(), b.view(), by_function);
    EXPECT_GT(by_name.size(), 0u) << name;
    EXPECT_EQ(by_name.point_triangle, by_function.point_triangle) << name;
    EXPECT_EQ(by_name.edge_edge, by_function.edge_edge) << name;
    // The memory depends on leaf sizes, cells and voxels; that of kept lists also on measured
    // times.
    if (name == "verlet_bvh") continue;
    EXPECT_EQ(detector->last_cost().bytes, other->last_cost().bytes) << name;
  }
}

TEST(Methods, AnOptionOfADetectorReachesIt) {
  const BroadPhaseRegistry registry = broad_phases();
  const Soup a(1), b(2);
  const auto bytes = [&](const std::string& name, const MethodOptions& options) {
    CandidatePairs pairs;
    const auto detector = registry.at(name)(options);
    detector->find_pairs(a.view(), b.view(), pairs);
    return detector->last_cost().bytes;
  };
  EXPECT_NE(bytes("voxel", {}), bytes("voxel", {{"voxel", 0.25}}));
}

TEST(Methods, ANarrowPhaseByNameGivesTheSameTimes) {
  const std::map<std::string, std::function<std::unique_ptr<NarrowPhase>()>> made{
      {"ccd_additive", [] { return make_ccd_additive(CcdAdditiveConfig{}); }},
      {"ccd_cubic", [] { return make_ccd_cubic(); }},
      {"ccd_cubic_bridson", [] { return make_ccd_cubic_bridson(); }},
      {"ccd_cubic_provot", [] { return make_ccd_cubic_provot(); }},
      {"ccd_exact", [] { return make_ccd_exact(); }},
      {"ccd_inclusion", [] { return make_ccd_inclusion(CcdInclusionConfig{}); }},
      {"ccd_root_parity", [] { return make_ccd_root_parity(); }},
      {"centroid_velocity", [] { return make_centroid_velocity(); }},
      {"plane_crossing", [] { return make_plane_crossing(); }},
      {"proximity", [] { return make_proximity(); }}};
  const NarrowPhaseRegistry registry = narrow_phases();
  EXPECT_EQ(registry.size(), made.size());
  const Soup a(3), b(4);
  CandidatePairs pairs;
  make_brute_force()->find_pairs(a.view(), b.view(), pairs);
  for (const auto& [name, make] : made) {
    std::vector<Contact> by_name, by_function;
    registry.at(name)()->find_contacts(a.view(), b.view(), pairs, by_name);
    make()->find_contacts(a.view(), b.view(), pairs, by_function);
    ASSERT_EQ(by_name.size(), by_function.size()) << name;
    for (std::size_t i = 0; i < by_name.size(); ++i) {
      EXPECT_EQ(by_name[i].vertex, by_function[i].vertex) << name;
      EXPECT_EQ(by_name[i].toi, by_function[i].toi) << name;
    }
  }
}

TEST(Methods, AResponseTakesItsOptions) {
  const ResponseRegistry registry = responses();
  EXPECT_LT(registry.at("penalty")({{"stiffness", 1e6}})->stable_step(1e4),
            registry.at("penalty")()->stable_step(1e4));
}

TEST(Methods, ALimiterSaysWhetherItIsAMethodForceOrPolicy) {
  const ClothMesh cloth = make_rectangular({0.5, 0.5, 4, 4}, Material{});
  std::map<LimiterKind, int> kinds;
  for (const auto& [name, entry] : strain_limiters()) {
    const LimiterKind kind = entry.traits().kind;
    const StrainLimit limit = entry(cloth.springs, cloth.strain_limit, cloth.mass.size());
    EXPECT_EQ(limit.method != nullptr, kind == LimiterKind::method) << name;
    // Han's method also stiffens the springs.
    const bool han = name == "han";
    EXPECT_EQ(limit.force != nullptr, kind == LimiterKind::force || han) << name;
    EXPECT_EQ(entry.options().size(), kind == LimiterKind::method ? 2u : 0u) << name;
    ++kinds[kind];
  }
  EXPECT_EQ(kinds[LimiterKind::none], 1);
  EXPECT_EQ(kinds[LimiterKind::method], 10);
  EXPECT_EQ(kinds[LimiterKind::force], 4);
  EXPECT_EQ(kinds[LimiterKind::critical_step], 1);
  EXPECT_EQ(kinds[LimiterKind::stiffens], 1);
}

// -- scene files ----------------------------------------------------------------------------------

std::string value_text(const MethodOption& option) {
  if (option.kind == OptionKind::boolean) return option.initial != 0.0 ? "true" : "false";
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", option.initial);
  return text;
}

const MethodOptions& options_of(const Scene& scene, const std::string& key) {
  if (key == kMethodKeys[0]) return scene.contact.broad_phase_options;
  if (key == kMethodKeys[1]) return scene.contact.narrow_phase_options;
  if (key == kMethodKeys[2]) return scene.contact.response_options;
  if (key == kMethodKeys[3]) return scene.contact.fail_safe_options;
  if (key == kMethodKeys[4]) return scene.solver.integrator_options;
  if (key == kMethodKeys[5]) return scene.solver.limiter_options;
  return std::get<ClothGrid>(scene.cloths[0].shape).pattern_options;
}

class OptionsOfMethods : public SceneFile {
 protected:
  void SetUp() override {
    SceneFile::SetUp();
    write("s.json", R"({"geometry": [{"size": [1, 1], "cells": [2, 2]}]})");
  }
  Scene read_with(const std::vector<Override>& overrides) const {
    return read_scene(folder_ / "s.json", overrides, methods_);
  }
  std::string fault_of(const std::vector<Override>& overrides) const {
    return refusal([&] { read_with(overrides); });
  }
  const Methods methods_ = methods_of_this_build();
};

TEST_F(OptionsOfMethods, EachIsReadFromScenesAndInTheSchema) {
  std::set<std::string> keys;
  for (const SceneKey& key : scene_keys()) keys.insert(key.path);
  for (const ListedMethod& method : list_methods(methods_))
    for (const MethodOption& option : method.options) {
      if (method.key == kForceLawKey) continue;  // see OfAForceLawStandUnderItsName
      const std::string path = method.key + "." + option.name;
      const bool of_library = method.library.empty();  // the schema is the same in every build
      EXPECT_TRUE(keys.contains(path) || !of_library) << path << " is not in the schema";
      const auto of_piece = [](std::string key) {
        return key.starts_with("geometry.*") ? key.replace(9, 1, "0") : key;
      };
      const Scene scene =
          read_with({{of_piece(method.key), method.name}, {of_piece(path), value_text(option)}});
      EXPECT_EQ(options_of(scene, method.key), (MethodOptions{{option.name, option.initial}}))
          << path;
    }
}

TEST_F(OptionsOfMethods, ThatTheMethodDoesNotHaveAreRefusedInEitherForm) {
  EXPECT_SAYS(fault_of({{"contact.broad_phase", R"({"type": "voxel", "cell": 1})"}}),
              "contact.broad_phase.cell: voxel has no option \"cell\"; nearest is \"voxel\"");
  EXPECT_SAYS(
      fault_of({{"contact.broad_phase", R"({"type": "voxle"})"}}),
      "contact.broad_phase.type: there is no \"voxle\" in this build; nearest is \"voxel\"");
  EXPECT_SAYS(fault_of({{"contact.response", "impulse"}, {"contact.stiffness", "10"}}),
              "contact.response.stiffness: impulse has no option \"stiffness\"; nearest is "
              "\"restitution\"");
  EXPECT_SAYS(fault_of({{"contact.response", "[1]"}, {"contact.stiffness", "10"}}),
              "contact.response: must be a string or an object {...}, is [1]");
  EXPECT_SAYS(fault_of({{"solver.drag", "0.1"}}),
              "solver.integrator.drag: implicit_blend has no option \"drag\" and no other option");
  EXPECT_SAYS(fault_of({{"contact.broad_phase", R"({"type": "hash_grid", "cell": true})"}}),
              "contact.broad_phase.cell: must be a number");
  EXPECT_SAYS(
      fault_of({{"contact.response", R"({"type": "penalty", "stiffness": 1})"},
                {"contact.stiffness", "1"}}),
      "contact.stiffness: is the old name of \"contact.response.stiffness\", which is there, too");
}

TEST_F(OptionsOfMethods, BesideTheNameMeanTheSameAsInItsObject) {
  const Scene flat = read_with({{"contact.response", "penalty"}, {"contact.stiffness", "12.5"}});
  const Scene inside =
      read_with({{"contact.response", R"({"type": "penalty", "stiffness": 12.5})"}});
  EXPECT_EQ(flat.contact.response_options, (MethodOptions{{"stiffness", 12.5}}));
  EXPECT_EQ(flat.contact.response_options, inside.contact.response_options);
  const Scene of_default =
      read_with({{"geometry.0.pattern", "bilayered"}, {"geometry.0.pattern.ratio", "2"}});
  EXPECT_EQ(std::get<ClothGrid>(of_default.cloths[0].shape).pattern_options,
            (MethodOptions{{"ratio", 2.0}}));
}

TEST_F(OptionsOfMethods, OfASceneAsWrittenReadTheSame) {
  const Scene scene = read_with({{"contact.broad_phase", "voxel"},
                                 {"contact.broad_phase.voxel", "2.5"},
                                 {"solver.integrator", "rkf45"},
                                 {"solver.error", "1e-4"}});
  write("again.json", scene.json);
  const Scene again = read_scene(folder_ / "again.json", {}, methods_);
  EXPECT_EQ(again.contact.broad_phase_options, (MethodOptions{{"voxel", 2.5}}));
  EXPECT_EQ(again.solver.integrator_options, (MethodOptions{{"error", 1e-4}}));
  EXPECT_EQ(again.json, scene.json);
}

TEST_F(OptionsOfMethods, OfAPatternMayStandUnderLayersAsInOlderScenes) {
  const auto options = [](const Scene& scene) {
    const auto& grid = std::get<ClothGrid>(scene.cloths[0].shape);
    EXPECT_EQ(grid.pattern, "bilayered");
    return grid.pattern_options;
  };
  const MethodOptions given{{"ratio", 2.0}, {"hold", 900.0}};
  const std::vector<Override> old{{"geometry.0.pattern", "bilayered"},
                                  {"geometry.0.layers", R"({"ratio": 2, "hold": 900})"}};
  EXPECT_EQ(options(read_with(old)), given);
  EXPECT_EQ(options(read_with({{"geometry[0].pattern", "bilayered"},
                               {"geometry[0].layers.ratio", "2"},
                               {"geometry.0.layers.hold", "900"}})),
            given);
  write("old.json", R"({"geometry": [{"pattern": "bilayered",
      "layers": {"ratio": 2,
                 "share": 2}}]})");
  EXPECT_SAYS(refusal([&] { read_scene(folder_ / "old.json"); }),
              "line 3, geometry[0].pattern.share: must be at most 0.99, is 2");
  EXPECT_SAYS(fault_of({{"geometry.0.layers", R"({"ratio": 2})"}}),
              "geometry[0].pattern.ratio: rectangular has no option \"ratio\"");
  write("both.json", R"({"geometry": [{"pattern": {"type": "bilayered", "ratio": 2},
                                       "layers": {"ratio": 3}}]})");
  EXPECT_SAYS(refusal([&] { read_scene(folder_ / "both.json"); }),
              "geometry[0].layers.ratio: is the old name of \"geometry.0.pattern.ratio\"");
  EXPECT_SAYS(fault_of({{"geometry.0.pattern", "refine curved"}}),
              "\"refine curved\" is selected by the key \"geometry.*.refine\", not by name");
}

TEST_F(OptionsOfMethods, OfAPatternAreAxesOfACompareForEveryGrid) {
  const auto axes = read_axes({"pattern.ratio=2,4", "pattern=bilayered"}, methods_);
  const Scene base = read_with({});
  const Scene cell = read_with(cell_overrides(axes, {"4", "bilayered"}, base));
  const auto& grid = std::get<ClothGrid>(cell.cloths[0].shape);
  EXPECT_EQ(grid.pattern, "bilayered");
  EXPECT_EQ(grid.pattern_options, (MethodOptions{{"ratio", 4.0}}));
  const auto one = read_axes({"geometry.0.pattern=all"}, methods_);
  EXPECT_EQ(one[0].values, methods_.patterns.names());
  EXPECT_EQ(read_axes({"geometry.0.layers.ratio=2,4"}, methods_)[0].values.size(), 2u);
  EXPECT_SAYS(refusal([&] { read_axes({"pattern.ratoi=1"}, methods_); }),
              "no method has the option \"ratoi\"; nearest is \"ratio\"");
}

/// A law without forces that has a number and a switch.
Methods with_a_law() {
  Methods methods;
  methods.force_laws.add("magnet",
                         {{.name = "pull", .initial = 1.0, .unit = "N", .least = 0.0},
                          {.name = "swing", .kind = OptionKind::boolean}},
                         [](const MethodOptions&, const ClothMesh&) { return ForceList{}; },
                         {.promise = "none", .source = "tests"});
  return methods;
}

TEST_F(OptionsOfMethods, OfAForceLawStandUnderItsName) {
  const Methods methods = with_a_law();
  const auto read = [&](const std::vector<Override>& overrides) {
    return read_scene(folder_ / "s.json", overrides, methods);
  };
  const auto fault = [&](const std::vector<Override>& overrides) {
    return refusal([&] { read(overrides); });
  };
  const MethodOptions given{{"pull", 2.5}, {"swing", 1.0}};
  const Scene scene = read({{"force_laws", R"({"magnet": {"pull": 2.5, "swing": true}})"}});
  EXPECT_EQ(scene.force_laws, (ForceLawOptions{{"magnet", given}}));
  EXPECT_EQ(
      read({{"force_laws.magnet.pull", "2.5"}, {"force_laws.magnet.swing", "true"}}).force_laws,
      scene.force_laws);
  write("again.json", scene.json);
  EXPECT_EQ(read_scene(folder_ / "again.json", {}, methods).force_laws, scene.force_laws);
  EXPECT_TRUE(read({}).force_laws.empty());
  EXPECT_SAYS(fault({{"force_laws.magent.pull", "1"}}),
              "force_laws.magent: there is no \"magent\" in this build; nearest is \"magnet\"");
  EXPECT_SAYS(fault({{"force_laws.magnet.pul", "1"}}),
              "force_laws.magnet.pul: magnet has no option \"pul\"; nearest is \"pull\"");
  EXPECT_SAYS(fault({{"force_laws.magnet.pull", "-1"}}),
              "force_laws.magnet.pull: magnet needs \"pull\" to be at least 0, is -1");
  EXPECT_SAYS(fault({{"force_laws.magnet.swing", "1"}}),
              "force_laws.magnet.swing: must be true or false");
  EXPECT_SAYS(fault({{"force_laws.hooke.stiffness", "1"}}),
              "force_laws.hooke.stiffness: hooke has no option \"stiffness\" and no other option");
  EXPECT_SAYS(fault({{"force_laws.sewing.pull", "1"}}),
              "\"sewing\" is selected by the key \"seams\", not by name");
}

TEST_F(OptionsOfMethods, OfAForceLawAreAxesOfACompare) {
  const Methods methods = with_a_law();
  const auto axes = read_axes({"force_laws.magnet.pull=1,2", "force_laws.magnet.swing"}, methods);
  ASSERT_EQ(axes.size(), 2u);
  EXPECT_TRUE(axes[0].numeric);
  EXPECT_EQ(axes[1].values, (std::vector<std::string>{"false", "true"}));
  const Scene cell =
      read_scene(folder_ / "s.json", cell_overrides(axes, {"2", "true"}, read_with({})), methods);
  EXPECT_EQ(cell.force_laws.at("magnet"), (MethodOptions{{"pull", 2.0}, {"swing", 1.0}}));
  const auto fault = [&](const std::string& axis) {
    return refusal([&] { read_axes({axis}, methods); });
  };
  EXPECT_SAYS(fault("force_laws.magent.pull=1"), "nearest is \"magnet\"");
  EXPECT_SAYS(fault("force_laws.magnet.pul=1"), "has no option \"pul\"; nearest is \"pull\"");
  EXPECT_SAYS(fault("force_laws.magnet.pull"), "has no list of all values");
}

TEST_F(OptionsOfMethods, AreAxesOfACompareWhateverTheirOrder) {
  const auto axes =
      read_axes({"broad_phase.cell=0.5,1,2", "broad_phase=hash_grid,uniform_grid"}, methods_);
  ASSERT_EQ(axes.size(), 2u);
  EXPECT_TRUE(axes[0].numeric);
  const Scene base = read_with({});
  const Scene cell = read_with(cell_overrides(axes, {"0.5", "uniform_grid"}, base));
  EXPECT_EQ(cell.contact.broad_phase, "uniform_grid");
  EXPECT_EQ(cell.contact.broad_phase_options, (MethodOptions{{"cell", 0.5}}));
  EXPECT_EQ(read_axes({"response.sticking"}, methods_)[0].values,
            (std::vector<std::string>{"false", "true"}));
  EXPECT_SAYS(refusal([&] { read_axes({"broad_phase.cel=1"}, methods_); }),
              "no method has the option \"cel\"; nearest is \"cell\"");
}

}  // namespace
}  // namespace selvedge::registry_test
