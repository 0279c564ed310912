// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/origin.h>
#include <selvedge/dress/detail/worn_measures.h>
#include <selvedge/dress/dress.h>
#include <selvedge/garment/sewing_pattern.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "dress_shapes.h"

namespace selvedge::verdict_test {
namespace {

namespace fs = std::filesystem;
const fs::path kRoot = SELVEDGE_SOURCE_DIR;

/// An upright cylinder, and a sheet around it whose flat pattern has the share `rest` of its girth.
struct Ring {
  TriangleMesh body, worn, flat;
  std::vector<std::int32_t> panel;
};
Ring ring(double radius, double rest) {
  Ring made;
  constexpr int kAround = 48, kUp = 6;
  const auto tube = [&](double r, TriangleMesh& mesh) {
    for (int k = 0; k <= kUp; ++k)
      for (int i = 0; i < kAround; ++i) {
        const double a = 2.0 * std::numbers::pi * i / kAround;
        mesh.vertices.emplace_back(r * std::cos(a), r * std::sin(a), 0.05 * k);
      }
    for (int k = 0; k < kUp; ++k)
      for (int i = 0; i < kAround; ++i) {
        const int a = k * kAround + i, b = k * kAround + (i + 1) % kAround;
        mesh.triangles.push_back({a, b, b + kAround});
        mesh.triangles.push_back({a, b + kAround, a + kAround});
      }
  };
  tube(radius, made.body);
  tube(radius + 0.002, made.worn);
  const double girth = rest * 2.0 * std::numbers::pi * (radius + 0.002);
  for (int k = 0; k <= kUp; ++k)
    for (int i = 0; i <= kAround; ++i)
      made.flat.vertices.emplace_back(girth * i / kAround, 0.05 * k, 0.0);
  for (int k = 0; k < kUp; ++k)
    for (int i = 0; i < kAround; ++i) {
      const int a = k * (kAround + 1) + i, b = a + kAround + 1;
      made.flat.triangles.push_back({a, a + 1, b + 1});
      made.flat.triangles.push_back({a, b + 1, b});
    }
  made.panel.assign(made.flat.triangles.size(), 0);
  return made;
}

TEST(WornMeasures, AGirthIsThatOfPatternAndTape) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> radius(0.05, 0.3), rest(0.5, 1.3), turn(-3.0, 3.0);
  for (int seed = 0; seed < 40; ++seed) {
    const double r = radius(random), share = rest(random);
    Ring made = ring(r, share);
    const Mat3 rotation = (Eigen::AngleAxisd(turn(random), Vec3::UnitX()) *
                           Eigen::AngleAxisd(turn(random), Vec3::UnitZ()))
                              .toRotationMatrix();
    for (TriangleMesh* mesh : {&made.body, &made.worn})
      for (Vec3& x : mesh->vertices) x = rotation * x;
    const detail::Girth girth = detail::girth_at(
        made.worn, made.flat, made.body, made.panel.size() / 2 + 1, rotation * Vec3::UnitZ());
    const double tape = 2.0 * std::numbers::pi * r;
    EXPECT_NEAR(girth.body, tape, 0.005) << seed;
    EXPECT_NEAR(girth.worn, tape + 2.0 * std::numbers::pi * 0.002, 0.005) << seed;
    EXPECT_NEAR(girth.cloth, share * 2.0 * std::numbers::pi * (r + 0.002), 1e-9) << seed;
  }
}

TEST(WornMeasures, AnOpenGarmentHasNoGirth) {
  Ring made = ring(0.2, 1.0);
  made.worn.triangles.resize(made.worn.triangles.size() / 2);
  std::erase_if(made.worn.triangles, [](const Triangle& t) { return t[0] % 48 == 5; });
  EXPECT_EQ(detail::girth_at(made.worn, made.flat, made.body, 20, Vec3::UnitZ()).cloth, 0.0);
}

/// A strip over a plane, of which the part `folded` lies in three layers, as after a fold.
TriangleMesh strip(double length, double folded) {
  TriangleMesh mesh;
  constexpr double kCell = 0.01, kLayer = 0.003;
  const auto count = static_cast<int>(std::lround((length + 2.0 * folded) / kCell));
  for (int i = 0; i <= count; ++i) {
    const double s = kCell * i, first = 0.5 * (length + folded);
    double x = s, z = 0.002;
    if (s > first + folded)
      x = s - 2.0 * folded, z += 2.0 * kLayer;
    else if (s > first)
      x = 2.0 * first - s, z += kLayer;
    for (int k = 0; k <= 10; ++k) mesh.vertices.emplace_back(x, 0.01 * k, z);
  }
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < 10; ++k) {
      const int a = 11 * i + k;
      mesh.triangles.push_back({a, a + 11, a + 12});
      mesh.triangles.push_back({a, a + 12, a + 1});
    }
  return mesh;
}

TEST(WornMeasures, TheFoldedShareIsThatOfTheLayers) {
  for (const double folded : {0.0, 0.03, 0.06, 0.1}) {
    const TriangleMesh cloth = strip(0.3, folded);
    TriangleMesh plane;
    for (int i = -1; i < 40; ++i)
      for (int k = -1; k < 12; ++k) {
        const auto first = static_cast<std::int32_t>(plane.vertices.size());
        for (const auto& [dx, dy] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}})
          plane.vertices.emplace_back(0.01 * (i + dx), 0.01 * (k + dy), 0.0);
        plane.triangles.push_back({first, first + 1, first + 2});
        plane.triangles.push_back({first, first + 2, first + 3});
      }
    const std::vector<std::int32_t> panel(cloth.triangles.size(), 0);
    const double share = detail::folded_areas(cloth, panel, plane, 1)[0];
    EXPECT_NEAR(share, 3.0 * folded / (0.3 + 2.0 * folded), 0.12) << folded;
    EXPECT_EQ(share > 0.0, folded > 0.0);
    if (folded < 0.1) continue;
    // Layers of different panels are not a fold.
    std::vector<std::int32_t> two = panel;
    for (std::size_t i = 0; i < two.size(); ++i) {
      double height = 0.0;
      for (const std::int32_t v : cloth.triangles[i]) height += cloth.vertices[v].z() / 3.0;
      two[i] = height > 0.0035 && height < 0.0065 ? 1 : 0;
    }
    EXPECT_LT(detail::folded_areas(cloth, two, plane, 2)[0], 0.5 * share);
  }
}

// ---- the origin ------------------------------------------------------------------------------

TEST(OriginFit, PublicPatternsStandWellOnTheirBodiesAlone) {
  const fs::path shared = kRoot / "../shared/data/garments";
  if (!fs::exists(shared)) GTEST_SKIP() << shared << " does not exist";
  LoadConfig file;
  file.up = UpAxis::y;
  for (const char* name :
       {"f_smpl_template.obj", "f_smpl_average_A40.obj", "m_smpl_average_A40.obj"}) {
    const TriangleMesh body = load_mesh(shared / "bodies" / name, file);
    const bool stands = std::string(name).find("A40") != std::string::npos;
    for (const auto& entry : fs::directory_iterator(shared / "patterns")) {
      const GarmentMesh mesh = mesh_garment(
          turned_upright(read_sewing_pattern(entry.path()), UpAxis::y), {.edge_length = 0.05});
      const detail::OriginFit fit = detail::fit_origin(mesh, body);
      const bool for_standing = entry.path().stem().string().ends_with("_specification");
      EXPECT_EQ(fit.is_beside(), stands != for_standing)
          << name << " " << entry.path() << " " << fit.distance << " " << fit.distance_by;
    }
  }
}

TEST(OriginFit, APatternForAnotherOriginIsMovedToItsPlace) {
  const TriangleMesh standing = read_mesh(kRoot / "data/bodies/mannequin_arms_out.ply");
  double height = 0.0;
  for (const Vec3& x : standing.vertices) height = std::max(height, x.z());
  const Vec3 pelvis(0.0, 0.0, 0.676 * height);
  int patterns = 0;
  for (const auto& entry : fs::directory_iterator(kRoot / "data/patterns")) {
    if (entry.path().extension() != ".json") continue;
    ++patterns;
    GarmentMesh mesh = mesh_garment(read_sewing_pattern(entry.path()), {.edge_length = 0.05});
    EXPECT_FALSE(detail::fit_origin(mesh, standing).is_beside()) << entry.path();
    // For a body whose origin is at the pelvis.
    for (Vec3& x : mesh.placed) x -= pelvis;
    const detail::OriginFit fit = detail::fit_origin(mesh, standing);
    ASSERT_TRUE(fit.is_beside()) << entry.path() << " " << fit.distance << " " << fit.distance_by;
    EXPECT_LT((fit.by - pelvis).norm(), 0.02) << entry.path();
    EXPECT_NE(fit.fault().find("m below its place"), std::string::npos) << fit.fault();
    // On such a body it stands well, and the pattern for a standing one does not.
    TriangleMesh centred = standing;
    for (Vec3& x : centred.vertices) x -= pelvis;
    EXPECT_FALSE(detail::fit_origin(mesh, centred).is_beside()) << entry.path();
    for (Vec3& x : mesh.placed) x += pelvis;
    const detail::OriginFit back = detail::fit_origin(mesh, centred);
    ASSERT_TRUE(back.is_beside()) << entry.path();
    EXPECT_LT((back.by + pelvis).norm(), 0.02) << entry.path();
    for (Vec3& x : mesh.placed) x += Vec3(0.0, 30.0, 0.0);
    EXPECT_TRUE(detail::fit_origin(mesh, centred).is_beside()) << entry.path();
  }
  EXPECT_EQ(patterns, 5);
}

TEST(PatternStand, AHeightAndArmsOfAnotherBodyAreSeen) {
  const SewingPattern tee = read_sewing_pattern(kRoot / "data/patterns/tee.json");
  const TriangleMesh out = read_mesh(kRoot / "data/bodies/mannequin_arms_out.ply"),
                     down = read_mesh(kRoot / "data/bodies/mannequin.ply");
  const BodyLandmarks marks = find_landmarks(out), marks_down = find_landmarks(down);
  const detail::PatternStand stand = detail::stand_of(tee, out, marks);
  EXPECT_LT(std::abs(stand.height), 0.06);
  EXPECT_LT(stand.sleeves, 0.06);
  EXPECT_GT(detail::stand_of(tee, down, marks_down).sleeves, 0.06);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> off(-0.3, 0.3);
  for (int seed = 0; seed < 5; ++seed) {
    SewingPattern moved = tee;
    const double by = off(random);
    for (PatternPanel& panel : moved.panels) panel.translation.z() -= by;
    const detail::PatternStand now = detail::stand_of(moved, out, marks);
    EXPECT_NEAR(now.height, stand.height + by, 1e-9) << seed;
    EXPECT_NEAR(now.sleeves, stand.sleeves, 1e-9) << seed;
  }
}

/// Turned over about any level axis through its middle, a pattern is upside down; others are not.
TEST(PatternStand, UpsideDownIsSeen) {
  const TriangleMesh body = read_mesh(kRoot / "data/bodies/mannequin_arms_out.ply");
  const BodyLandmarks marks = find_landmarks(body);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> way(-3.1, 3.1), tilt(-0.5, 0.5);
  for (const auto& entry : fs::directory_iterator(kRoot / "data/patterns")) {
    if (entry.path().extension() != ".json") continue;
    const SewingPattern pattern = read_sewing_pattern(entry.path());
    for (const bool is_over : {false, true}) {
      const double angle = (is_over ? 3.14159 : 0.0) + tilt(random), at = way(random);
      const Mat3 turn = Eigen::AngleAxisd(angle, Vec3(std::cos(at), std::sin(at), 0.0)).matrix();
      const Vec3 middle = marks.waist.middle;
      SewingPattern placed = pattern;
      for (PatternPanel& panel : placed.panels) {
        panel.rotation = turn * panel.rotation;
        panel.translation = middle + turn * (panel.translation - middle);
      }
      EXPECT_EQ(detail::stand_of(placed, body, marks).is_upside_down, is_over) << entry.path();
    }
  }
}

TEST(PatternStand, PublicPatternsStandWellOnTheirBodiesAlone) {
  const fs::path shared = kRoot / "../shared/data/garments";
  if (!fs::exists(shared)) GTEST_SKIP() << shared << " does not exist";
  LoadConfig file;
  file.up = UpAxis::y;
  const auto load = [&](const char* name) { return load_mesh(shared / "bodies" / name, file); };
  const TriangleMesh level = load("f_smpl_template.obj"), standing = load("f_smpl_average_A40.obj"),
                     taller = load("m_smpl_average_A40.obj");
  for (const auto& entry : fs::directory_iterator(shared / "patterns")) {
    const SewingPattern pattern = turned_upright(read_sewing_pattern(entry.path()), UpAxis::y);
    const bool is_newer = entry.path().stem().string().ends_with("_specification");
    const TriangleMesh& body = is_newer ? standing : level;
    const detail::PatternStand stand = detail::stand_of(pattern, body, find_landmarks(body));
    EXPECT_LT(std::abs(stand.height), 0.06) << entry.path();
    EXPECT_LT(stand.sleeves, 0.06) << entry.path();
    EXPECT_FALSE(stand.is_upside_down) << entry.path();
    if (!is_newer) continue;
    const detail::PatternStand low = detail::stand_of(pattern, taller, find_landmarks(taller));
    EXPECT_NEAR(low.height - stand.height, 0.12, 0.02) << entry.path();
  }
}

// ---- the verdict -----------------------------------------------------------------------------

DressResult worn_result() {
  DressResult r;
  r.clean = r.sewn = r.at_rest = true;
  r.strain_limit = 0.8;
  r.wearable_stretch = 0.3;
  r.largest_drop = 0.2;
  r.panel_names = {"front", "back"};
  r.panel_drop = {0.0, 0.0};
  r.panel_folded = {0.0, 0.0};
  return r;
}

TEST(Verdict, SaysTheTrueReasonFirst) {
  DressResult r = worn_result();
  EXPECT_EQ(r.verdict(), "good");
  r.panel_drop[1] = -0.3;
  EXPECT_EQ(r.verdict(), "worn, but panel \"back\" lies 0.30 m higher than the pattern places it");
  r.panel_drop[1] = 0.3;
  EXPECT_EQ(r.verdict(), "worn, but panel \"back\" lies 0.30 m lower than the pattern places it");
  r = worn_result();
  r.folded = 0.05;
  r.panel_folded = {0.01, 0.09};
  EXPECT_NE(r.verdict().find("worn, but folded over itself on 5.0 %"), std::string::npos);
  EXPECT_NE(r.verdict().find("\"back\""), std::string::npos);
  r = worn_result();
  r.asymmetry = 0.03;
  r.asymmetric_panel = 0;
  EXPECT_NE(r.verdict().find("worn, but one-sided"), std::string::npos);
  r.max_stretch = 0.5;
  r.tight.panel = 1;
  r.tight.strain = 0.5;
  r.tight.area_share = 0.2;
  r.tight.cloth = 0.54;
  r.tight.body = 0.81;
  EXPECT_NE(
      r.verdict().find("worn, but too small at panel \"back\" (cloth 0.54 m around, body 0.81 m)"),
      std::string::npos)
      << r.verdict();
  EXPECT_NE(r.verdict().find("; one-sided"), std::string::npos) << "the others follow";
  EXPECT_TRUE(r.worn());
  EXPECT_FALSE(r.good());
  // Without a ring there, the zone with the least ease explains it.
  DressResult zones = r;
  zones.tight.cloth = zones.tight.body = 0.0;
  for (const auto& [name, cloth] : {std::pair("bust", 0.8), {"waist", 0.75}, {"hip", 1.2}}) {
    FitZone zone;
    zone.name = name;
    zone.body = 0.9;
    zone.cloth = cloth;
    zone.is_closed = true;
    zone.strain_max = 0.5;
    zones.fit.push_back(zone);
  }
  EXPECT_NE(zones.verdict().find("(waist: cloth 0.75 m around, body 0.90 m)"), std::string::npos)
      << zones.verdict();
  EXPECT_NE(zones.verdict().find("30 %, also at the bust (cloth 0.80 m around, body 0.90 m)"),
            std::string::npos)
      << zones.verdict();
  EXPECT_EQ(zones.verdict().find("hip"), std::string::npos) << "wide enough";
  // A long ring that is hardly too short does not explain much stretch.
  zones.tight.cloth = 1.74;
  zones.tight.body = 1.77;
  EXPECT_EQ(zones.verdict().find("1.77"), std::string::npos) << zones.verdict();
  zones.tight.body = 1.90;
  EXPECT_NE(zones.verdict().find("(cloth 1.74 m around, body 1.90 m)"), std::string::npos);
  EXPECT_NE(zones.verdict().find("also at the waist"), std::string::npos);
  zones.tight.cloth = zones.tight.body = 0.0;
  // One that is not stretched as much is no reason.
  for (FitZone& zone : zones.fit) zone.strain_max = 0.3;
  EXPECT_EQ(zones.verdict().find("waist"), std::string::npos) << zones.verdict();
  // An open seam of a garment that is too small is its consequence.
  r.sewn = false;
  r.largest_opening = 0.004;
  r.seams = {{.name = "stitch 1", .opening_end = 0.004}};
  EXPECT_TRUE(r.verdict().starts_with("too small at panel \"back\"")) << r.verdict();
  EXPECT_TRUE(r.verdict().ends_with("stitch 1 is open by 4.00 mm")) << r.verdict();
  r.body_crossings = 3;
  EXPECT_NE(r.verdict().find("3 pairs of triangles"), std::string::npos);
  EXPECT_FALSE(r.worn());
}

}  // namespace
}  // namespace selvedge::verdict_test
