// SPDX-License-Identifier: MIT
// The fit report: where a body is measured, and the tapes around body and garment.
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/dress/detail/fit.h>
#include <selvedge/dress/detail/fit_page.h>
#include <selvedge/dress/dress.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <set>

namespace selvedge::fit_test {
namespace {

namespace fs = std::filesystem;
const fs::path kRoot = SELVEDGE_SOURCE_DIR;

struct NamedBody {
  std::string name;
  TriangleMesh mesh;
};
/// Those of the repository, and the public ones where they are.
std::vector<NamedBody> bodies() {
  std::vector<NamedBody> list = {
      {"mannequin_arms_out", read_mesh(kRoot / "data/bodies/mannequin_arms_out.ply")}};
  LoadConfig y_up;
  y_up.up = UpAxis::y;
  const fs::path shared = kRoot / "../shared/data/garments/bodies";
  for (const char* name : {"f_smpl_template", "f_smpl_average_A40", "m_smpl_average_A40"})
    if (fs::exists(shared / (std::string(name) + ".obj")))
      list.push_back({name, load_mesh(shared / (std::string(name) + ".obj"), y_up)});
  return list;
}

std::map<std::string, FitZone> fit_of(const TriangleMesh& body, const TriangleMesh& garment = {},
                                      const TriangleMesh& flat = {}) {
  DressResult r;
  r.body = body;
  r.garment = garment;
  r.flat = flat;
  detail::measure_fit(detail::body_zones(body), r);
  std::map<std::string, FitZone> zones;
  for (const FitZone& zone : r.fit) zones[zone.name] = zone;
  return zones;
}

/// The length of a taut tape by another way: the circumference of a convex curve is the integral of
/// its support function over all directions. The part is that whose cut triangles hang together by
/// their vertices and lie nearest to `at`.
double tape_by_support(const TriangleMesh& mesh, const Vec3& at, const Vec3& normal) {
  const auto height = [&](std::int32_t v) { return normal.dot(mesh.vertices[v] - at); };
  const Vec3 a = normal.unitOrthogonal(), b = normal.cross(a);
  std::map<std::int32_t, std::vector<std::size_t>> of_vertex;
  std::vector<std::size_t> cut;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    const double low = std::min({height(t[0]), height(t[1]), height(t[2])}),
                 high = std::max({height(t[0]), height(t[1]), height(t[2])});
    if (low > 0.0 || high < 0.0) continue;
    cut.push_back(i);
    for (const std::int32_t v : t) of_vertex[v].push_back(i);
  }
  std::set<std::size_t> seen;
  double best = 0.0, least = 1e9;
  for (const std::size_t first : cut) {
    if (seen.contains(first)) continue;
    std::vector<std::size_t> open = {first};
    seen.insert(first);
    std::vector<Vec3> points;
    while (!open.empty()) {
      const Triangle t = mesh.triangles[open.back()];
      open.pop_back();
      for (int k = 0; k < 3; ++k) {
        const std::int32_t u = t[k], v = t[(k + 1) % 3];
        const double hu = height(u), hv = height(v);
        if (hu != hv && hu * hv <= 0.0)
          points.push_back(mesh.vertices[u] +
                           hu / (hu - hv) * (mesh.vertices[v] - mesh.vertices[u]));
        for (const std::size_t next : of_vertex[u])
          if (seen.insert(next).second) open.push_back(next);
      }
    }
    constexpr int kDirections = 720;
    double sum = 0.0, nearest = 1e9;
    for (int k = 0; k < kDirections; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / kDirections;
      const Vec3 way = std::cos(angle) * a + std::sin(angle) * b;
      double support = -1e9;
      for (const Vec3& p : points) support = std::max(support, way.dot(p - at));
      sum += support * 2.0 * std::numbers::pi / kDirections;
    }
    Vec3 middle = Vec3::Zero();
    for (const Vec3& p : points) middle += p / static_cast<double>(points.size());
    nearest = (middle - at).norm();
    if (nearest > least) continue;
    least = nearest;
    best = sum;
  }
  return best;
}

TEST(Fit, ZonesLieWhereATailorMeasures) {
  for (const auto& [name, body] : bodies()) {
    const auto zones = fit_of(body);
    for (const char* zone : {"neck", "bust", "waist", "hip", "left thigh", "right thigh",
                             "left upper arm", "right upper arm"})
      EXPECT_TRUE(zones.contains(zone)) << name << " " << zone;
    if (zones.size() < 8) continue;
    const auto at = [&](const char* zone) -> const FitZone& { return zones.at(zone); };
    EXPECT_GT(at("neck").at.z(), at("bust").at.z()) << name;
    EXPECT_GT(at("bust").at.z(), at("waist").at.z()) << name;
    EXPECT_GT(at("waist").at.z(), at("hip").at.z()) << name;
    EXPECT_GT(at("hip").at.z(), at("left thigh").at.z()) << name;
    EXPECT_LT(at("waist").body, at("bust").body) << name;
    EXPECT_LT(at("waist").body, at("hip").body) << name;
    EXPECT_NEAR(at("left thigh").body, at("right thigh").body, 0.02) << name;
    EXPECT_NEAR(at("left upper arm").body, at("right upper arm").body, 0.02) << name;
    EXPECT_GT(at("left upper arm").at.x(), at("right upper arm").at.x()) << name;
    for (const auto& [zone, fit] : zones)
      EXPECT_NEAR(fit.body, tape_by_support(body, fit.at, fit.normal), 0.005)
          << name << " " << zone;
  }
}

/// A tube of cloth around the vertical line through `middle`; in the flat pattern it is `rest` as
/// wide as in space. Open: without one of its strips.
struct Tube {
  TriangleMesh worn, flat;
};
Tube tube(const Vec3& middle, double radius, double rest, bool is_open) {
  Tube made;
  constexpr int kAround = 96, kUp = 8;
  const double girth = rest * 2.0 * std::numbers::pi * radius;
  for (int k = 0; k <= kUp; ++k) {
    const double z = 0.02 * (k - kUp / 2) + 0.003;
    for (int i = 0; i < kAround; ++i) {
      const double a = 2.0 * std::numbers::pi * i / kAround;
      made.worn.vertices.push_back(middle + Vec3(radius * std::cos(a), radius * std::sin(a), z));
    }
    for (int i = 0; i <= kAround; ++i) made.flat.vertices.emplace_back(girth * i / kAround, z, 0.0);
  }
  for (int k = 0; k < kUp; ++k)
    for (int i = 0; i < kAround - (is_open ? 1 : 0); ++i) {
      const int a = k * kAround + i, b = k * kAround + (i + 1) % kAround;
      made.worn.triangles.push_back({a, b, b + kAround});
      made.worn.triangles.push_back({a, b + kAround, a + kAround});
      const int u = k * (kAround + 1) + i, v = u + kAround + 1;
      made.flat.triangles.push_back({u, u + 1, v + 1});
      made.flat.triangles.push_back({u, v + 1, v});
    }
  return made;
}

TEST(Fit, GirthsOfTheGarmentAreThoseOfItsPatternAndItsTape) {
  const TriangleMesh body = read_mesh(kRoot / "data/bodies/mannequin_arms_out.ply");
  const auto bare = fit_of(body);
  for (const char* name : {"waist", "hip", "bust"})
    for (const double rest : {0.8, 1.0, 1.3}) {
      const double radius = 0.25;
      const Tube cloth = tube(bare.at(name).at, radius, rest, false);
      const FitZone zone = fit_of(body, cloth.worn, cloth.flat).at(name);
      const double girth = 2.0 * std::numbers::pi * radius;
      EXPECT_TRUE(zone.is_closed) << name;
      EXPECT_NEAR(zone.worn, girth, 0.005) << name;
      EXPECT_NEAR(zone.worn, tape_by_support(cloth.worn, zone.at, zone.normal), 0.005) << name;
      EXPECT_NEAR(zone.cloth, rest * girth, 1e-9) << name;
      EXPECT_NEAR(zone.ease(), rest * girth - bare.at(name).body, 1e-9) << name;
      EXPECT_NEAR(zone.strain, std::max(0.0, 1.0 / rest - 1.0), 0.01) << name;
      EXPECT_FALSE(zone.triangles.empty()) << name;
    }
}

TEST(Fit, OpenClothHasNoEaseAndASkirtNoneAtTheThighs) {
  const TriangleMesh body = read_mesh(kRoot / "data/bodies/mannequin_arms_out.ply");
  const auto bare = fit_of(body);
  const Tube open = tube(bare.at("waist").at, 0.25, 1.0, true);
  const auto zones = fit_of(body, open.worn, open.flat);
  EXPECT_FALSE(zones.at("waist").is_closed);
  EXPECT_EQ(zones.at("waist").ease(), 0.0);
  EXPECT_GT(zones.at("waist").cloth, 1.4);
  EXPECT_EQ(zones.at("neck").cloth, 0.0) << "no cloth is there";
  const Vec3 between = 0.5 * (bare.at("left thigh").at + bare.at("right thigh").at);
  const Tube skirt = tube(between, 0.3, 1.0, false);
  EXPECT_EQ(fit_of(body, skirt.worn, skirt.flat).at("left thigh").cloth, 0.0);
  const Tube leg = tube(bare.at("left thigh").at, 0.12, 1.0, false);
  const auto trousers = fit_of(body, leg.worn, leg.flat);
  EXPECT_TRUE(trousers.at("left thigh").is_closed);
  EXPECT_EQ(trousers.at("right thigh").cloth, 0.0);
}

TEST(Fit, ThePageNamesEveryZoneWithItsGirths) {
  DressResult r;
  FitZone waist;
  waist.name = "waist";
  waist.body = 0.812;
  waist.cloth = 0.771;
  waist.is_closed = true;
  waist.triangles = {1};
  FitZone neck;
  neck.name = "neck";
  neck.body = 0.346;
  r.fit = {waist, neck};
  r.garment.triangles = {{0, 1, 2}, {0, 2, 3}};
  const std::string page = detail::fit_page("a<b", r);
  for (const char* text : {"a&lt;b", "81.2", "77.1", "-4.1 (-5 %)", "tight", "34.6", "no cloth",
                           "pictures/fit_front.png", "pictures/fit_back.png",
                           "pictures/fit_left.png", "pictures/fit_right.png"})
    EXPECT_NE(page.find(text), std::string::npos) << text;
  EXPECT_EQ(page.find("a<b"), std::string::npos);
  const std::vector<Vec3> colours = detail::fit_colours(r);
  ASSERT_EQ(colours.size(), 2u);
  EXPECT_NE(colours[0], colours[1]) << "the zone has a colour of its own";
}

}  // namespace
}  // namespace selvedge::fit_test
