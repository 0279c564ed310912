// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/lab/fabric_drape.h>
#include <selvedge/scene/fabric_file.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <set>
#include <stdexcept>

namespace selvedge::fabric_test {
namespace {

namespace fs = std::filesystem;

class FabricFile : public ::testing::Test {
 protected:
  FabricFile() : folder_(fs::temp_directory_path() / ("fabric_test_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~FabricFile() override { fs::remove_all(folder_); }

  Fabric read(const std::string& text) const {
    const fs::path file = folder_ / "cloth.json";
    std::ofstream(file) << text;
    return read_fabrics(file).front();
  }
  std::string refusal(const std::string& text) const {
    try {
      read(text);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "was read";
  }

  fs::path folder_;
};

#define EXPECT_SAYS(sentence, part) \
  EXPECT_NE((sentence).find(part), std::string::npos) << "the sentence is: " << (sentence)

TEST(MeasuredFabrics, AreAllReadAndEachHasItsSource) {
  const std::vector<Fabric> all = measured_fabrics();
  std::set<std::string> names;
  for (const Fabric& fabric : all) {
    names.insert(fabric.name);
    EXPECT_FALSE(fabric.source.empty()) << fabric.name;
  }
  EXPECT_EQ(names.size(), all.size());
  for (const char* name : {"petrak_2025/M1", "petrak_2025/M6", "matsudaira_2015/cotton_broad",
                           "wang_2011/11oz-black-denim", "feng_2022/q50"})
    EXPECT_TRUE(names.contains(name)) << name;
}

TEST(MeasuredFabrics, PetraksHaveTheBendingLengthsAndStripBoundsOfTheirTable) {
  const double c[] = {9.9, 9.0, 10.6, 9.9, 11.4, 13.1}, strip[] = {7.8, 6.7, 8.8, 7.8, 10.1, 12.9};
  for (int i = 0; i < 6; ++i) {
    const Fabric f = find_fabric("petrak_2025/M" + std::to_string(i + 1), ".");
    const double mean = f.constants.bending->mean();
    const double length = bending_length(mean, f.material.density);
    EXPECT_NEAR(1e3 * length, c[i], 0.06) << f.name;
    EXPECT_NEAR(strip_drape_coefficient(length), strip[i], 0.15) << f.name;
    EXPECT_GT(*f.constants.drape_coefficient, strip_drape_coefficient(length)) << f.name;
  }
}

TEST(MeasuredFabrics, TheNearestIsNamedWhereThereIsNone) {
  try {
    find_fabric("petrak_2025/M7", "/nowhere");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_SAYS(std::string(error.what()), "petrak_2025/M");
  }
}

TEST(MeasuredFabrics, EverydayNamesStandForMeasuredOnes) {
  for (const auto& [name, fabric] : everyday_fabrics()) {
    EXPECT_EQ(find_fabric(name, "/nowhere").name, fabric);
    EXPECT_FALSE(find_fabric(name, "/nowhere").source.empty());
  }
  EXPECT_NEAR(find_fabric("denim", "/nowhere").material.density, 0.324, 1e-12);
  for (const char* name : {"silk", "felt", "leather"}) {
    try {
      find_fabric(name, "/nowhere");
      FAIL() << name;
    } catch (const std::invalid_argument& error) {
      EXPECT_SAYS(std::string(error.what()), "no published measurement");
    }
  }
}

// LT is the work over that of a straight line, G and B slopes of the chords between the places at
// which Kawabata's sheets take them.
TEST(Fabrics, PlainFiguresHasTheFiguresOfTheCurvesOfPlainCurves) {
  const Material curves = find_fabric("usual_kes/plain_curves", "/nowhere").material,
                 figures = find_fabric("usual_kes/plain_figures", "/nowhere").material;
  const MonotoneCurve& pull = curves.tension_curve;
  const double end = pull.x().back();
  EXPECT_NEAR(end, figures.kawabata_strain, 1e-12);
  EXPECT_NEAR(pull.work(end) / (0.5 * end * pull.value(end)), figures.kawabata_lt, 0.01);
  const auto chord = [](const MonotoneCurve& of, double from, double to) {
    return (of.value(to) - of.value(from)) / (to - from);
  };
  const double degree = std::numbers::pi / 180.0;
  EXPECT_NEAR(chord(curves.shear_curve, 0.5 * degree, 2.5 * degree) / figures.shear_stiffness, 1.0,
              0.01);
  EXPECT_NEAR(chord(curves.bending_curve, 50.0, 150.0) / figures.bending_stiffness, 1.0, 0.01);
}

TEST_F(FabricFile, UnitsAreConvertedToSI) {
  const Fabric f = read(R"json({"source": "me", "density": {"value": 5, "unit": "oz/yd2"},
    "stretch": {"warp": 500, "weft": 300, "unit": "gf/cm"}, "shear": {"value": 1, "unit": "gf/(cm*deg)"},
    "bending": {"value": 1, "unit": "gf*cm2/cm"}, "bending_hysteresis": {"value": 1, "unit": "gf*cm/cm"},
    "thickness": {"value": 0.4, "unit": "mm"}})json");
  EXPECT_NEAR(f.material.density, 0.16953, 1e-5);
  EXPECT_NEAR(f.material.stretch_stiffness, 490.3325, 1e-9);
  EXPECT_NEAR(*f.material.stretch_weft, 294.1995, 1e-9);
  EXPECT_NEAR(f.material.shear_stiffness, 56.188, 1e-3);
  EXPECT_NEAR(f.material.bending_stiffness, 9.80665e-5, 1e-15);
  EXPECT_NEAR(f.material.bending_friction, 0.5 * 9.80665e-3, 1e-12);
  EXPECT_NEAR(*f.constants.thickness, 4e-4, 1e-12);
  EXPECT_FALSE(f.material.bending_weft.has_value());
  EXPECT_TRUE(f.notes.empty());
}

TEST_F(FabricFile, GramsPerSecondSquaredAreMillinewtonsPerMetre) {
  const Fabric f = read(R"json({"source": "me", "density": {"value": 100, "unit": "g/m2"},
    "shear": {"value": 41000, "unit": "g/s2"}, "bending": {"value": 1950, "unit": "g*mm2/s2"}})json");
  EXPECT_NEAR(f.material.shear_stiffness, 41.0, 1e-12);
  EXPECT_NEAR(f.material.bending_stiffness, 1.95e-6, 1e-18);
}

TEST_F(FabricFile, AKesSheetIsItsMaterial) {
  const std::string head =
      R"json({"kind": "kes", "source": "me", "W": {"value": 20, "unit": "mg/cm2"},
    "EMT": {"value": 5, "unit": "%"}, "G": {"value": 0.7, "unit": "gf/(cm*deg)"},
    "2HG": {"value": 1, "unit": "gf/cm"}, "B": {"warp": 0.12, "weft": 0.08, "unit": "gf*cm2/cm"},
    "2HB": {"value": 0.04, "unit": "gf*cm/cm"}, )json";
  const std::string lt = R"json("LT": {"value": 0.7, "unit": "1"})json";
  const Fabric f = read(head + lt + "}");
  EXPECT_NEAR(f.material.density, 0.2, 1e-12);
  EXPECT_EQ(f.material.stretch_law, "kawabata");
  EXPECT_NEAR(f.material.bending_stiffness, 0.12 * 9.80665e-5, 1e-15);
  EXPECT_NEAR(*f.material.bending_weft, 0.08 * 9.80665e-5, 1e-15);
  EXPECT_NEAR(f.material.shear_friction, 0.5 * 0.980665, 1e-12);
  // WT = LT · 500 gf/cm · EMT/2 says the same.
  const Fabric work = read(head + R"json("WT": {"value": 8.75, "unit": "gf*cm/cm2"}})json");
  EXPECT_NEAR(work.material.kawabata_lt, 0.7, 1e-12);
  const std::string both =
      refusal(head + lt + R"json(, "WT": {"value": 20, "unit": "gf*cm/cm2"}})json");
  EXPECT_SAYS(both, "WT and EMT give LT = 1.600");
  EXPECT_EQ(f.material.kawabata_rt, 1.0);
  const std::string rt = R"json(, "RT": {"warp": 62, "weft": 58, "unit": "%"}})json";
  EXPECT_NEAR(read(head + lt + rt).material.kawabata_rt, 0.6, 1e-12);
  for (const char* bad : {R"("value": 0)", R"("value": 101)", R"("warp": 120, "weft": 60)"})
    EXPECT_SAYS(refusal(head + lt + R"json(, "RT": {)json" + bad + R"json(, "unit": "%"}})json"),
                "RT: must be above 0 and at most 100 %");
}

TEST_F(FabricFile, ReadingsOfShearAndOfLoopsAlongWarpAndWeftAreAveraged) {
  const Fabric sheet = read(R"json({"kind": "kes", "source": "me",
    "W": {"value": 20, "unit": "mg/cm2"}, "EMT": {"value": 5, "unit": "%"},
    "LT": {"warp": 0.75, "weft": 0.65, "unit": "1"},
    "G": {"warp": 0.9, "weft": 0.7, "unit": "gf/(cm*deg)"},
    "2HG": {"warp": 1.4, "weft": 1, "unit": "gf/cm"}, "B": {"value": 0.1, "unit": "gf*cm2/cm"},
    "2HB": {"warp": 0.05, "weft": 0.03, "unit": "gf*cm/cm"}})json");
  EXPECT_NEAR(sheet.material.shear_stiffness, 0.8 * 56.188, 1e-3);
  EXPECT_NEAR(sheet.material.shear_friction, 0.6 * 0.980665, 1e-12);
  EXPECT_NEAR(sheet.material.bending_friction, 0.02 * 9.80665e-3, 1e-12);
  EXPECT_NEAR(sheet.material.kawabata_lt, 0.7, 1e-12);
  const Fabric plain = read(R"json({"source": "me", "density": {"value": 0.2, "unit": "kg/m2"},
    "shear": {"warp": 30, "weft": 50, "unit": "N/m"},
    "shear_hysteresis": {"warp": 1, "weft": 3, "unit": "N/m"}})json");
  EXPECT_NEAR(plain.material.shear_stiffness, 40.0, 1e-12);
  EXPECT_NEAR(plain.material.shear_friction, 1.0, 1e-12);
}

TEST_F(FabricFile, AFastSheetIsConverted) {
  const std::string text =
      R"json({"kind": "fast", "source": "me", "W": {"value": 200, "unit": "g/m2"},
    "C": {"warp": 18, "weft": 16, "unit": "mm"}, "E5": {"value": 0.5, "unit": "%"},
    "E20": {"value": 1, "unit": "%"}, "E100": {"warp": 3, "weft": 5, "unit": "%"},
    "EB5": {"value": 3, "unit": "%"}})json";
  const Fabric f = read(text);
  EXPECT_NEAR(f.material.shear_stiffness, 41.0, 1e-12);
  // w c³, and (100 - 20) gf/cm over 2 % and 4 %.
  EXPECT_NEAR(f.constants.bending->warp, 0.2 * 9.81 * 5.832e-6, 1e-12);
  EXPECT_NEAR(f.constants.stretch->warp, 78.4532 / 0.02, 1e-6);
  EXPECT_NEAR(f.constants.stretch->weft, 78.4532 / 0.04, 1e-6);
  std::string falling = text;
  const std::string rising = "\"E20\": {\"value\": 1";
  falling.replace(falling.find(rising), rising.size(), "\"E20\": {\"value\": 4");
  EXPECT_SAYS(refusal(falling), "must not decrease with the load");
}

TEST_F(FabricFile, ACantileverHasHalfItsOverhangAsBendingLength) {
  const Fabric f = read(R"json({"kind": "cantilever", "source": "me",
    "density": {"value": 150, "unit": "g/m2"}, "overhang": {"warp": 4, "weft": 3, "unit": "cm"}})json");
  EXPECT_NEAR(f.constants.bending->warp, 0.15 * 9.81 * 8e-6, 1e-15);
  EXPECT_NEAR(bending_length(f.constants.bending->weft, 0.15), 0.015, 1e-12);
}

TEST_F(FabricFile, ADrapeCoefficientBoundsTheBendingLength) {
  const Fabric f = read(R"json({"kind": "drape", "source": "me",
    "density": {"value": 150, "unit": "g/m2"}, "drape_coefficient": {"value": 49.3, "unit": "%"}})json");
  EXPECT_NEAR(bending_length(f.material.bending_stiffness, 0.15), 0.025, 2e-5);
}

TEST_F(FabricFile, ATensionCurveIsItsLinearity) {
  const std::string head = R"json({"source": "me", "density": {"value": 0.2, "unit": "kg/m2"},
    "tension_curve": {"strain_unit": "%", "force_unit": "gf/cm", "strain": [0, 2, 4], )json";
  const Fabric f = read(head + "\"force\": [0, 150, 500]}}");
  EXPECT_NEAR(f.material.kawabata_lt, (150.0 + 650.0) / 1000.0, 1e-12);
  EXPECT_NEAR(f.material.kawabata_strain, 0.04, 1e-15);
  EXPECT_NEAR(f.material.stretch_stiffness, 0.6 * 490.3325 / 0.04, 1e-6);
  EXPECT_SAYS(refusal(head + "\"force\": [0, 150, 100]}}"), "decreases at its point 2");
}

TEST_F(FabricFile, BadOnesAreRefusedInOneSentenceWithFileAndPlace) {
  const auto with = [&](const std::string& rest) {
    return refusal("{\"source\": \"me\", \"density\": {\"value\": 0.2, \"unit\": \"kg/m2\"}, " +
                   rest + "}");
  };
  EXPECT_SAYS(with("\"bending\": {\"value\": 1e-5}"), "cloth.json.bending: has no \"unit\"");
  EXPECT_SAYS(with("\"bending\": {\"value\": 1e-5, \"unit\": \"gf\"}"), "\"gf\" is not a unit");
  EXPECT_SAYS(with("\"stretch\": {\"value\": -5, \"unit\": \"N/m\"}"), "must not be negative");
  EXPECT_SAYS(with("\"stretch\": {\"value\": 0, \"unit\": \"N/m\"}"), "positive");
  EXPECT_SAYS(with("\"stretching\": {\"value\": 5, \"unit\": \"N/m\"}"), "nearest is \"stretch\"");
  EXPECT_SAYS(with("\"kind\": \"test\""), "there is no kind");
  EXPECT_SAYS(refusal("{\"density\": {\"value\": 0.2, \"unit\": \"kg/m2\"}}"), "has no \"source\"");
}

/// What a flat mesh has of a cloth whose warp is stiffer than its weft.
ContinuumConstants constants_of(const ClothMesh& cloth) {
  const auto& x = cloth.surface.vertices;
  return continuum_constants(cloth, x, surface_area(x, cloth.surface.triangles));
}

/// Strip modulus along weft.
double weft_modulus(ContinuumConstants c) {
  std::swap(c.c11, c.c22);
  std::swap(c.c13, c.c23);
  return strip_modulus(c);
}

TEST(WarpAndWeft, EachHasItsStripModulusOnEveryGrid) {
  Material m;
  m.stretch_stiffness = 600.0;
  m.stretch_weft = 300.0;
  m.shear_stiffness = 50.0;
  const GridConfig grid{1, 1, 40, 50};
  for (const ClothMesh& cloth : {make_rectangular(grid, m), make_simplified(grid, m, true)}) {
    const ContinuumConstants c = constants_of(cloth);
    EXPECT_NEAR(strip_modulus(c), 600.0, 1e-9);
    EXPECT_NEAR(weft_modulus(c), 300.0, 1e-9);
    EXPECT_NEAR(c.c33, 50.0, 1e-9);
  }
  const ContinuumConstants one_way = constants_of(make_simplified(grid, m, false));
  EXPECT_NEAR(strip_modulus(one_way), 600.0, 1e-9);
  EXPECT_NEAR(weft_modulus(one_way), 300.0, 1e-9);
  // Triangles have three springs for four constants.
  const ContinuumConstants free = constants_of(make_triangular({1, 0.866, 40, 40}, m));
  EXPECT_NEAR(strip_modulus(free), 600.0, 0.05 * 600.0);
  EXPECT_NEAR(weft_modulus(free), 300.0, 0.05 * 300.0);
}

TEST(WarpAndWeft, AGridStoresTheRigidityOfEachAndPeircesBetween) {
  Material m;
  m.bending_stiffness = 4e-5;
  m.bending_weft = 1e-5;
  const ClothMesh cloth = make_rectangular({1, 1, 20, 20}, m);
  const auto& flat = cloth.surface.vertices;
  constexpr double radius = 100.0;
  const auto force = make_bending_force(cloth.hinges, flat.size());
  const auto rigidity = [&](double angle) {
    const Vec3 n(std::cos(angle), std::sin(angle), 0.0);
    std::vector<Vec3> x = flat, v(flat.size(), Vec3::Zero());
    for (Vec3& p : x) p.z() = 0.5 * n.dot(p) * n.dot(p) / radius;
    return force->energy({x, v, {}, 0.0}) * 2.0 * radius * radius;
  };
  // A strip of 19 of the 20 rows turns along warp or weft, all cells twist.
  EXPECT_NEAR(rigidity(0.0), 0.95 * 4e-5, 1e-9);
  EXPECT_NEAR(rigidity(0.5 * std::numbers::pi), 0.95 * 1e-5, 1e-9);
  EXPECT_NEAR(rigidity(0.25 * std::numbers::pi), 0.25 * (0.95 * 5e-5 + 2.0 * 2e-5), 1e-9);
}

TEST(WovenDisc, HasTheAreaMassAndConstantsOfItsCloth) {
  Material m;
  const ClothMesh disc = make_woven_disc(0.15, 60, m);
  const auto& x = disc.surface.vertices;
  const double area = surface_area(x, disc.surface.triangles);
  EXPECT_NEAR(area / (std::numbers::pi * 0.0225), 1.0, 0.005);
  double mass = 0.0;
  for (const double kg : disc.mass) mass += kg;
  EXPECT_NEAR(mass, m.density * area, 1e-12);
  const ContinuumConstants c = continuum_constants(disc, x, area);
  EXPECT_NEAR(c.c33, m.shear_stiffness, 0.06 * m.shear_stiffness);  // the rim is ragged
  EXPECT_NEAR(strip_modulus(c), m.stretch_stiffness, 0.06 * m.stretch_stiffness);
}

/// A disc without its springs, so that only bending and shear are left.
ClothMesh without_springs(ClothMesh cloth) {
  cloth.springs.clear();
  cloth.strain_limit.clear();
  cloth.curves.clear();
  cloth.curve_of_spring.clear();
  return cloth;
}

double energy(const ClothMesh& cloth, const std::vector<Vec3>& x) {
  const std::vector<Vec3> v(x.size(), Vec3::Zero());
  double sum = 0.0;
  for (const auto& force : make_internal_forces(cloth)) sum += force->energy({x, v, {}, 0.0});
  return sum;
}

/// Bending energy per area of a cloth rolled along x to a radius of 0.2 m.
double rolled_energy(const ClothMesh& cloth) {
  constexpr double radius = 0.2;
  const auto& flat = cloth.surface.vertices;
  std::vector<Vec3> x = flat;
  for (Vec3& p : x)
    p = {radius * std::sin(p.x() / radius), p.y(), radius * (1.0 - std::cos(p.x() / radius))};
  return energy(without_springs(cloth), x) / surface_area(flat, cloth.surface.triangles);
}

TEST(WovenDisc, HasTheBendingEnergyOfTheSheetThatItIsCutFrom) {
  Material m;
  for (const std::string law : {"hinge", "buckling", "twisting"}) {
    m.bending_law = law;
    const ClothMesh disc = make_woven_disc(0.15, 40, m);
    const ClothMesh sheet = make_rectangular({0.3, 0.3, 40, 40}, m);
    EXPECT_NEAR(rolled_energy(disc) / rolled_energy(sheet), 1.0, 0.15) << law;
    const auto n = static_cast<std::int32_t>(disc.surface.vertices.size());
    for (const BucklingLink& link : disc.links) EXPECT_LT(std::max(link.a, link.b), n);
    if (law == "buckling") {
      EXPECT_GT(disc.links.size(), 5u * n / 2u);
    }
  }
}

TEST(WovenDisc, IsAtRestWithAnyLaw) {
  for (const std::string bending : {"hinge", "bridson", "buckling", "twisting"})
    for (const std::string shear : {"springs", "twisting"}) {
      Material m;
      m.bending_law = bending;
      m.shear_law = shear;
      const ClothMesh disc = make_woven_disc(0.15, 24, m);
      const auto& x = disc.surface.vertices;
      const std::vector<Vec3> v(x.size(), Vec3::Zero());
      std::vector<Vec3> f(x.size(), Vec3::Zero());
      for (const auto& force : make_internal_forces(disc))
        force->add_force({x, v, disc.mass, 0.0}, f);
      double largest = 0.0;
      for (const Vec3& force : f) largest = std::max(largest, force.norm());
      EXPECT_LT(largest, 1e-9) << bending << ", " << shear;
    }
}

/// Twice the signed area of a triangle in the xy-plane, m².
double doubled_area(std::span<const Vec3> x, std::int32_t a, std::int32_t b, std::int32_t c) {
  return (x[b] - x[a]).cross(x[c] - x[a]).z();
}

TEST(WovenDisc, HasNoFoldedHinge) {
  Material m;
  m.bending_friction = 1e-3;
  for (const std::int32_t cells : {8, 13, 24, 40}) {
    const ClothMesh disc = make_woven_disc(0.15, cells, m);
    const auto& x = disc.surface.vertices;
    const auto is_folded = [&](const auto& element) {
      const auto& v = element.v;
      return doubled_area(x, v[2], v[3], v[0]) * doubled_area(x, v[3], v[2], v[1]) <= 0.0;
    };
    const auto& frictions = disc.hinge_frictions;
    ASSERT_FALSE(frictions.empty());
    EXPECT_EQ(std::count_if(disc.hinges.begin(), disc.hinges.end(), is_folded), 0) << cells;
    EXPECT_EQ(std::count_if(frictions.begin(), frictions.end(), is_folded), 0) << cells;
  }
}

TEST(WovenDisc, TakesFrictionAlong) {
  Material m;
  m.bending_friction = 1e-3;
  m.shear_law = "twisting";
  m.shear_friction = 0.1;
  const ClothMesh disc = make_woven_disc(0.15, 24, m);
  const auto n = static_cast<std::int32_t>(disc.surface.vertices.size());
  ASSERT_FALSE(disc.hinge_frictions.empty());
  ASSERT_FALSE(disc.corner_frictions.empty());
  for (const HingeFriction& friction : disc.hinge_frictions)
    for (const std::int32_t i : friction.v) EXPECT_LT(i, n);
  for (const CornerFriction& friction : disc.corner_frictions) {
    const auto same = std::find_if(disc.twists.begin(), disc.twists.end(),
                                   [&](const TwistSpring& t) { return t.v == friction.v; });
    ASSERT_NE(same, disc.twists.end());
    EXPECT_EQ(friction.rest_angle, same->rest_angle);
  }
}

TEST(DrapeTrial, AStiffClothStaysFlatAndASoftOneHangs) {
  Material m;
  DrapeTrial trial;
  trial.cells = 10;
  m.bending_stiffness = 1e-2;
  EXPECT_NEAR(drape(m, trial).coefficient, 100.0, 1.0);
  m.bending_stiffness = 1e-7;
  const DrapeOutcome soft = drape(m, trial);
  EXPECT_LT(soft.coefficient, 70.0);  // ten rings are coarse for it
  EXPECT_GE(soft.rim.folds, 2);
  for (const Vec3& p : soft.shape.vertices) EXPECT_TRUE(p.allFinite());
}

TEST(DrapeTrial, LaidOnOneDiscItLiftsBehindTheEdgeAndHangsLower) {
  Material m;
  m.bending_stiffness = 3e-5;
  DrapeTrial trial;
  trial.cells = 10;
  const DrapeOutcome held = drape(m, trial);
  trial.hold = DrapeHold::laid;
  const DrapeOutcome laid = drape(m, trial);
  EXPECT_TRUE(laid.settled);
  EXPECT_LT(laid.coefficient, held.coefficient - 1.0);
  double lowest = 0.0, highest = 0.0;  // of what lies over the disc
  for (const Vec3& x : laid.shape.vertices) {
    if (x.head<2>().norm() > trial.support - 1e-3) continue;
    lowest = std::min(lowest, x.z());
    highest = std::max(highest, x.z());
  }
  EXPECT_GT(lowest, -5e-4);
  EXPECT_GT(highest, 1e-4);
}

TEST(DrapeTrial, RisesWithTheBendingAndLiesAboveTheStrips) {
  double before = 0.0;
  DrapeTrial trial;
  trial.cells = 10;
  for (const double bending : {3e-6, 3e-5, 3e-4}) {
    Material m;
    m.bending_stiffness = bending;
    const double dc = drape(m, trial).coefficient;
    EXPECT_GT(dc, before);
    EXPECT_GT(dc, strip_drape_coefficient(bending_length(bending, m.density)) - 2.0);
    before = dc;
  }
}

TEST(DrapeTrial, FinerMeshesKeepTheFoldsAndApproachEachOther) {
  Material m;
  m.bending_stiffness = 3e-5;
  DrapeTrial trial;
  trial.cells = 6;
  const std::vector<DrapeOutcome> levels = drape_refined(m, trial, 3);
  ASSERT_EQ(levels.size(), 3u);
  EXPECT_EQ(levels[0].coefficient, drape(m, trial).coefficient);
  EXPECT_EQ(levels[1].rim.folds, levels[2].rim.folds);
  EXPECT_NEAR(levels[2].coefficient, levels[1].coefficient, 1.0);
  // Each starts where the one before came to rest: the folds are where they were.
  const auto& coarse = levels[1].shape.vertices;
  const auto& fine = levels[2].shape.vertices;
  for (std::size_t k = 1; k <= 5u * 12u; ++k)
    EXPECT_LT((coarse[coarse.size() - k] - fine[fine.size() - (2 * k)]).norm(), 0.01) << k;
}

TEST(DrapeTrial, ATriangularDiscCoversItsCircleWithoutLongEdges) {
  const Material m;
  DrapeTrial trial;
  trial.mesh = DrapeMesh::triangular;
  trial.cells = 16;
  trial.most_steps = 1;
  trial.step = 1e-9;
  const TriangleMesh disc = drape(m, trial).shape;
  constexpr int rings = 8;
  EXPECT_EQ(disc.triangles.size(), 6u * rings * rings);
  EXPECT_EQ(disc.vertices.size(), 1u + 3u * rings * (rings + 1));
  double area = 0.0;
  for (const Triangle& t : disc.triangles) {
    const Vec3 &a = disc.vertices[t[0]], &b = disc.vertices[t[1]], &c = disc.vertices[t[2]];
    area += 0.5 * (b - a).cross(c - a).z();
    for (const double edge : {(b - a).norm(), (c - b).norm(), (a - c).norm()}) {
      EXPECT_GT(edge / (trial.specimen / rings), 0.95);
      EXPECT_LT(edge / (trial.specimen / rings), std::numbers::sqrt2);
    }
  }
  const double sides = 6.0 * rings;  // of the rim
  EXPECT_NEAR(
      area,
      0.5 * sides * trial.specimen * trial.specimen * std::sin(2.0 * std::numbers::pi / sides),
      1e-6);
  trial.cells = 15;
  EXPECT_THROW(drape(m, trial), std::invalid_argument);
}

TEST(DrapeTrial, ATriangularDiscIsFlatIfStiffAndHangsIfSoft) {
  DrapeTrial trial;
  trial.mesh = DrapeMesh::triangular;
  Material m;
  m.bending_stiffness = 1e-2;
  EXPECT_GT(drape(m, trial).coefficient, 97.0);
  m.bending_stiffness = 1e-5;
  const DrapeOutcome soft = drape(m, trial);
  EXPECT_TRUE(soft.settled);
  EXPECT_LT(soft.coefficient, 60.0);
  EXPECT_GT(soft.coefficient, strip_drape_coefficient(bending_length(1e-5, m.density)));
}

TEST(DrapeTrial, EveryMeshStartsFromTheSameSurface) {
  Material m;
  DrapeTrial trial;
  trial.most_steps = 1;
  trial.noise = 1e-3;
  trial.step = 1e-9;
  std::vector<std::vector<Vec3>> rims;
  for (const std::int32_t cells : {16, 32}) {
    trial.cells = cells;
    const std::vector<Vec3> x = drape(m, trial).shape.vertices;
    rims.emplace_back(x.end() - 5 * cells, x.end());
  }
  double highest = 0.0;
  for (std::size_t k = 0; k < rims[0].size(); ++k) {
    EXPECT_NEAR((rims[0][k] - rims[1][2 * k]).norm(), 0.0, 1e-9) << k;
    highest = std::max(highest, rims[0][k].z());
  }
  EXPECT_GT(highest, 0.2 * trial.noise);
}

TEST(MeshLimit, IsThatOfValuesWhichConvergeByAnOrder) {
  // 20 + 8 h²
  const MeshLimit three = mesh_limit(std::vector{28.0, 22.0, 20.5});
  EXPECT_NEAR(three.value, 20.0, 1e-12);
  EXPECT_NEAR(three.order, 2.0, 1e-12);
  EXPECT_NEAR(three.uncertainty, 1.25 * 0.5, 1e-12);
  const MeshLimit two = mesh_limit(std::vector{22.0, 20.5});
  EXPECT_NEAR(two.value, 20.0, 1e-12);
  EXPECT_NEAR(two.uncertainty, 1.5, 1e-12);
  const MeshLimit first = mesh_limit(std::vector{28.0, 24.0, 22.0});  // 20 + 8 h
  EXPECT_NEAR(first.value, 20.0, 1e-12);
  EXPECT_NEAR(first.order, 1.0, 1e-12);
}

TEST(MeshLimit, OfDivergingValuesIsTheLastWithAllTheirDistance) {
  const MeshLimit limit = mesh_limit(std::vector{20.0, 23.0, 21.0});
  EXPECT_EQ(limit.value, 21.0);
  EXPECT_EQ(limit.uncertainty, 3.0);
  EXPECT_EQ(limit.order, 0.0);
  EXPECT_THROW(mesh_limit(std::vector{20.0}), std::invalid_argument);
}

}  // namespace
}  // namespace selvedge::fabric_test
