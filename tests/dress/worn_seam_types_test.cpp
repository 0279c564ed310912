// SPDX-License-Identifier: MIT
// Elastics, zips, buttons, folds, pleats, pockets and fabrics of single panels on a body.
#include "dress_shapes.h"

#include <gtest/gtest.h>
#include <selvedge/core/cloth/detail/dihedral.h>
#include <selvedge/dress/detail/dressing.h>
#include <selvedge/dress/dress.h>
#include <selvedge/garment/internal/drawn_pattern.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>

namespace selvedge::worn_seam_types_test {
namespace {

using namespace selvedge::dress_shapes;
constexpr double kDegree = std::numbers::pi / 180.0;

DressConfig coarse(double edge_length = 0.03) {
  DressConfig config;
  config.edge_length = config.sewing_edge_length = edge_length;
  return config;
}

TriangleMesh hill() { return cone(0.3, 0.6); }
SewingPattern plain_tube() { return tube(0.6, 0.3, 0.32); }

TEST(WornSeamTypes, AnElasticDrawsItsEdgeToItsRestLength) {
  SewingPattern pattern = plain_tube();
  for (PatternPanel& panel : pattern.panels) panel.edges[2].elastic.ratio = 0.7;
  DressConfig config = coarse();
  config.sewing_edge_length = 0.06;  // the refined mesh has it as well
  config.body_friction = 0.02;       // which would hold it up where it is wider
  const DressResult r = dress(pattern, hill(), config);
  EXPECT_EQ(r.fault(), "");
  ASSERT_EQ(r.elastics.size(), 2u);
  for (const ElasticReport& elastic : r.elastics) {
    EXPECT_NEAR(elastic.length, 0.6, 1e-6) << elastic.name;
    EXPECT_NEAR(elastic.rest, 0.42, 1e-6);
    EXPECT_NEAR(elastic.worn, elastic.rest, 0.05 * elastic.rest) << elastic.name;
  }
  // Gathered cloth is not stretched, whatever the elastic does.
  EXPECT_LT(r.max_stretch, 0.3);
}

/// Vertices of the cloth in the last state of a phase.
struct LastStates {
  std::map<DressPhase, std::size_t> vertices;
  DressObserver observer() {
    DressObserver observer;
    observer.accepted = [this](const Simulation& now, DressPhase phase) {
      vertices[phase] = now.positions().size();
    };
    return observer;
  }
};

TEST(WornSeamTypes, AZipIsOpenUntilAllSeamsAreClosed) {
  SewingPattern pattern = plain_tube();
  pattern.stitches[1].closure = PatternStitch::Closure::zip;
  LastStates states;
  const DressResult r = dress(pattern, hill(), coarse(), {}, states.observer());
  EXPECT_EQ(r.fault(), "");
  const std::size_t all = r.flat.vertices.size(), pairs = r.seams[0].pairs;
  EXPECT_EQ(r.seams[1].pairs, pairs);
  EXPECT_EQ(states.vertices.at(DressPhase::sew), all - pairs);
  EXPECT_EQ(states.vertices.at(DressPhase::settle), all - 2 * pairs);
  EXPECT_EQ(r.seams[1].merged, pairs);
  EXPECT_EQ(r.seams[1].opening_end, 0.0);
}

TEST(WornSeamTypes, ButtonsJoinTheirPairsAndNoOthers) {
  SewingPattern pattern = plain_tube();
  pattern.stitches[1].closure = PatternStitch::Closure::buttons;
  pattern.stitches[1].buttons = {0.0, 0.4, 0.8};
  LastStates states;
  DressConfig config = coarse();
  config.sewing_edge_length = 0.06;
  const DressResult r = dress(pattern, hill(), config, {}, states.observer());
  EXPECT_EQ(r.fault(), "");
  EXPECT_EQ(r.seams[1].pairs, 3u);
  EXPECT_EQ(r.seams[1].merged, 3u);
  EXPECT_EQ(r.garment.vertices.size(), r.flat.vertices.size() - r.seams[0].pairs - 3);
}

/// Moves cloth for some seconds of its own, without weight unless `gravity`; the body is far away.
/// Vertices of `held` stay.
detail::Garment moved(const SewingPattern& pattern, const DressConfig& config, double seconds,
                      const Vec3& gravity, const std::vector<std::int32_t>& held) {
  GarmentMesh mesh =
      mesh_garment(pattern, {.edge_length = config.edge_length, .limits = {.places = false}});
  detail::Garment garment = detail::start_garment(mesh);
  TriangleMesh body = cone(0.1, 0.1);
  for (Vec3& x : body.vertices) x.z() -= 10.0;
  const Methods methods;
  const DressObserver observer;
  const detail::Deadline deadline(1e9);
  const detail::Dressing dressing{body, config, methods, observer, deadline};
  const detail::PhaseSettings settings{.gravity = gravity, .drag = 0.5, .limit_strain = false};
  detail::DressScene scene = detail::make_dress_scene(garment, body, config, settings);
  const auto simulation = detail::start_simulation(scene, dressing);
  std::vector<Vec3> places;
  for (const std::int32_t v : held) places.push_back(garment.surface.vertices[v]);
  if (!held.empty()) simulation->hold(held, places);
  simulation->advance_to_frame(static_cast<int>(std::lround(seconds * config.fps)), [](double) {});
  detail::take_state(*simulation, garment);
  return garment;
}

PatternPanel rectangle(const char* name, double width, double height) {
  PatternPanel panel;
  panel.name = name;
  panel.vertices = {{0.0, 0.0}, {width, 0.0}, {width, height}, {0.0, height}};
  for (std::int32_t i = 0; i < 4; ++i) panel.edges.push_back({{i, (i + 1) % 4}, {}, ""});
  return panel;
}

/// Angle by which the cloth is folded along a row of vertices, rad: > 0 where the inner sides come
/// together.
double fold_angle(const detail::Garment& garment, const std::vector<std::int32_t>& row) {
  const std::vector<Vec3>& x = garment.surface.vertices;
  double sum = 0.0;
  for (std::size_t i = 1; i < row.size(); ++i) {
    std::array<std::int32_t, 2> side = {-1, -1};
    for (const Triangle& t : garment.surface.triangles)
      for (int k = 0; k < 3; ++k) {
        if (t[k] == row[i - 1] && t[(k + 1) % 3] == row[i]) side[0] = t[(k + 2) % 3];
        if (t[k] == row[i] && t[(k + 1) % 3] == row[i - 1]) side[1] = t[(k + 2) % 3];
      }
    const Vec3 e = (x[row[i]] - x[row[i - 1]]).normalized();
    const auto across = [&](std::int32_t v) {
      const Vec3 way = x[v] - x[row[i]];
      return Vec3((way - way.dot(e) * e).normalized());
    };
    const Vec3 normal = e.cross(across(side[0]));  // of the first triangle, outward
    const double turn =
        std::numbers::pi - std::acos(std::clamp(across(side[0]).dot(across(side[1])), -1.0, 1.0));
    sum += across(side[1]).dot(normal) < 0.0 ? turn : -turn;
  }
  return sum / static_cast<double>(row.size() - 1);
}

TEST(WornSeamTypes, AFoldLineRestsAtItsAngle) {
  for (const double degrees : {60.0, -60.0, 120.0})
    for (const bool is_clockwise : {false, true}) {
      SewingPattern pattern;
      pattern.name = "fold";
      pattern.panels = {rectangle("a", 0.2, 0.1)};
      PatternPanel& panel = pattern.panels[0];
      panel.vertices = {{0, 0}, {0.1, 0}, {0.2, 0}, {0.2, 0.1}, {0.1, 0.1}, {0, 0.1}};
      panel.edges.clear();
      for (std::int32_t i = 0; i < 6; ++i) panel.edges.push_back({{i, (i + 1) % 6}, {}, ""});
      if (is_clockwise) {
        std::reverse(panel.edges.begin(), panel.edges.end());
        for (PatternEdge& e : panel.edges) std::swap(e.endpoints[0], e.endpoints[1]);
      }
      panel.lines.push_back({.endpoints = {1, 4}, .angle = degrees * kDegree});
      const DressConfig config = coarse(0.02);
      const GarmentMesh mesh =
          mesh_garment(pattern, {.edge_length = 0.02, .limits = {.places = false}});
      const detail::Garment garment = moved(pattern, config, 2.0, Vec3::Zero(), {});
      EXPECT_NEAR(fold_angle(garment, mesh.line_vertices[0][0]) / kDegree, degrees, 3.0)
          << is_clockwise;
    }
}

/// Lowest point of a panel that hangs by its upper edge, below where it was, m.
double sag(const detail::Garment& garment, const GarmentMesh& mesh, std::size_t panel) {
  double low = 0.0;
  for (std::int32_t v = mesh.first_vertex[panel]; v < mesh.first_vertex[panel + 1]; ++v)
    low = std::max(low, mesh.placed[v].z() - garment.surface.vertices[v].z());
  return low;
}

/// Two upright panels, 0.1 by 0.4 m, of which the upper edges are held.
struct Hanging {
  SewingPattern pattern;
  DressConfig config = coarse(0.02);

  std::vector<double> sags() {
    pattern.name = "hanging";
    for (std::size_t p = 0; p < pattern.panels.size(); ++p) {
      PatternPanel& panel = pattern.panels[p];
      Mat3 upright;
      upright << 1, 0, 0, 0, 0, -1, 0, 1, 0;
      panel.rotation = upright * panel.rotation;
      panel.translation = Vec3(0.3 * static_cast<double>(p), 0.0, 0.0);
    }
    const GarmentMesh mesh =
        mesh_garment(pattern, {.edge_length = 0.02, .limits = {.places = false}});
    double top = 0.0;
    for (const Vec3& x : mesh.placed) top = std::max(top, x.z());
    std::vector<std::int32_t> held;
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(mesh.placed.size()); ++v)
      if (mesh.placed[v].z() > top - 1e-6) held.push_back(v);
    const detail::Garment garment = moved(pattern, config, 4.0, Vec3(0.0, 0.0, -9.81), held);
    std::vector<double> list;
    for (std::size_t p = 0; p < pattern.panels.size(); ++p) list.push_back(sag(garment, mesh, p));
    return list;
  }
};

/// A strip under its own weight becomes longer by density·g·length²/(2·stiffness).
double wanted_sag(double stiffness) { return 0.2 * 9.81 * 0.4 * 0.4 / (2.0 * stiffness); }

TEST(WornSeamTypes, EachPanelHasItsFabric) {
  Hanging hanging;
  hanging.pattern.panels = {rectangle("a", 0.1, 0.4), rectangle("b", 0.1, 0.4)};
  hanging.pattern.panels[1].fabric = "soft";
  hanging.pattern.stitches = {{{0, 1}, {1, 3}}};
  hanging.config.fabric.stretch_stiffness = 40.0;
  hanging.config.fabrics["soft"] = hanging.config.fabric;
  hanging.config.fabrics["soft"].stretch_stiffness = 10.0;
  for (Material* m : {&hanging.config.fabric, &hanging.config.fabrics["soft"]})
    m->shear_stiffness = 0.3 * m->stretch_stiffness;
  const std::vector<double> sags = hanging.sags();
  EXPECT_NEAR(sags[0], wanted_sag(40.0), 0.15 * wanted_sag(40.0));
  EXPECT_NEAR(sags[1] / sags[0], 4.0, 0.4);
  hanging.pattern.panels[1].fabric = "unknown";
  EXPECT_THROW(dress(hanging.pattern, hill(), coarse()), std::invalid_argument);
}

/// N·m, of each panel: the sum of the stiffness of its hinges.
std::vector<double> bending_of_panels(const SewingPattern& pattern, const DressConfig& config,
                                      double least) {
  const GarmentMesh mesh =
      mesh_garment(pattern, {.edge_length = config.edge_length, .limits = {.places = false}});
  const detail::DressScene made = detail::make_dress_scene(detail::start_garment(mesh), hill(),
                                                           config, {.least_bending = least});
  std::vector<double> sum(pattern.panels.size(), 0.0);
  for (const Hinge& hinge : made.built.cloth.hinges)
    for (std::size_t p = 0; p < sum.size(); ++p)
      if (hinge.v[0] >= mesh.first_vertex[p] && hinge.v[0] < mesh.first_vertex[p + 1])
        sum[p] += hinge.stiffness;
  return sum;
}

TEST(WornSeamTypes, OnlyFabricsSofterThanCardAreStiffened) {
  SewingPattern pattern;
  pattern.name = "fabrics";
  DressConfig config = coarse();
  constexpr double kLeast = 3e-3;
  for (const double own : {1e-5, 1e-4, kLeast, 0.1}) {
    const std::string name = own == 1e-5 ? "" : std::to_string(own);
    pattern.panels.push_back(rectangle("", 0.1, 0.4));
    pattern.panels.back().name = "panel" + name;
    pattern.panels.back().fabric = name;
    pattern.panels.back().translation.x() = 0.3 * static_cast<double>(pattern.panels.size());
    Material& fabric = name.empty() ? config.fabric : config.fabrics[name];
    fabric = coarse().fabric;
    fabric.bending_stiffness = own;
  }
  for (std::int32_t p = 1; p < 4; ++p) pattern.stitches.push_back({{p - 1, 1}, {p, 3}});
  const std::vector<double> as_is = bending_of_panels(pattern, config, 0.0),
                            stiff = bending_of_panels(pattern, config, kLeast);
  EXPECT_NEAR(as_is[1] / as_is[0], 10.0, 1e-6);
  EXPECT_NEAR(stiff[0] / as_is[0], kLeast / 1e-5, 1e-6);
  EXPECT_NEAR(stiff[1], stiff[0], 1e-9 * stiff[0]);
  EXPECT_EQ(stiff[2], as_is[2]);
  EXPECT_EQ(stiff[3], as_is[3]);
}

/// The warp is the grain: a panel that is cut across it hangs by its weft.
TEST(WornSeamTypes, AGrainTurnedByARightAngleSwapsWarpAndWeft) {
  DrawnPattern drawn;
  drawn.name = "grain";
  drawn.panels = {{.panel = rectangle("along", 0.1, 0.4)},
                  {.panel = rectangle("across", 0.1, 0.4), .grain = Vec2(1.0, 0.0)}};
  drawn.stitches.push_back({{{0, {1}, false}}, {{1, {3}, false}}, false});
  const auto sags = [&](double warp, double weft) {
    Hanging hanging;
    hanging.pattern = as_sewn(drawn);
    hanging.config.fabric.stretch_stiffness = warp;
    hanging.config.fabric.stretch_weft = weft;
    hanging.config.fabric.shear_stiffness = 12.0;
    return hanging.sags();
  };
  const std::vector<double> stiff = sags(40.0, 20.0), soft = sags(20.0, 40.0);
  EXPECT_LT(stiff[0], 0.7 * stiff[1]);
  EXPECT_LT(soft[1], 0.7 * soft[0]);
  // The meshes of both panels run across each other.
  EXPECT_NEAR(soft[1], stiff[0], 0.3 * stiff[0]);
  EXPECT_NEAR(soft[0], stiff[1], 0.3 * stiff[1]);
}

/// The front of a tube with a vertex of its own at each corner of a pocket.
SewingPattern with_pocket() {
  SewingPattern pattern = plain_tube();
  PatternPanel& front = pattern.panels[0];
  front.vertices.insert(front.vertices.end(),
                        {{-0.06, 0.2}, {-0.06, 0.08}, {0.06, 0.08}, {0.06, 0.2}});
  for (std::int32_t i = 4; i < 7; ++i) front.lines.push_back({.endpoints = {i, i + 1}});
  PatternPanel pocket = front;
  pocket.name = "pocket";
  pocket.vertices.assign(front.vertices.begin() + 4, front.vertices.end());
  pocket.lines.clear();
  pocket.translation += 0.02 * pocket.rotation.col(2);
  pattern.panels.push_back(pocket);
  for (std::int32_t i = 0; i < 3; ++i) pattern.stitches.push_back({{2, i}, {0, 4 + i}});
  return pattern;
}

TEST(WornSeamTypes, APocketIsSewnOntoTheFront) {
  const SewingPattern pattern = with_pocket();
  for (const SeamDirection& d : seam_directions(pattern))
    EXPECT_EQ(d.start_to_start, d.reason == SeamDirection::Reason::placement);
  const DressResult r = dress(pattern, hill(), coarse());
  EXPECT_EQ(r.fault(), "");
  EXPECT_EQ(r.open_pairs(), 0u);
  EXPECT_LT(r.max_stretch, 0.4);
  // It lies outside of the front: farther from the axis of the cone at the same height.
  double pocket = 0.0, front = 0.0;
  int of_pocket = 0, of_front = 0;
  for (std::size_t i = 0; i < r.garment.triangles.size(); ++i) {
    const auto& u = r.flat.vertices;
    const Triangle &t = r.garment.triangles[i], &f = r.flat.triangles[i];
    const Vec3 at =
        (r.garment.vertices[t[0]] + r.garment.vertices[t[1]] + r.garment.vertices[t[2]]) / 3.0;
    const double off = std::hypot(at.x(), at.y()) - 0.3 * (1.0 - at.z() / 0.6);
    const Vec3 flat = (u[f[0]] + u[f[1]] + u[f[2]]) / 3.0;
    const bool behind = std::abs(flat.x() - 0.3) < 0.05 && flat.y() > 0.09 && flat.y() < 0.18;
    if (r.panel_of_triangle[i] == 2) pocket += off, ++of_pocket;
    if (r.panel_of_triangle[i] == 0 && behind) front += off, ++of_front;
  }
  ASSERT_GT(of_front, 4);
  EXPECT_GT(pocket / of_pocket, front / of_front + 5e-4);
}

/// Mean distance from the cone of the parts of a panel whose places in its plane `counts` chooses,
/// m.
template <class Counts>
double off_the_hill(const DressResult& r, const SewingPattern& pattern, std::int32_t panel,
                    Counts&& counts) {
  double sum = 0.0, low = 1e9;
  int count = 0;
  const auto& u = r.flat.vertices;
  for (std::size_t i = 0; i < r.flat.triangles.size(); ++i)
    if (r.panel_of_triangle[i] == panel)
      for (const std::int32_t v : r.flat.triangles[i]) low = std::min(low, u[v].x());
  double left = 1e9;
  for (const Vec2& v : pattern.panels[panel].vertices) left = std::min(left, v.x());
  for (std::size_t i = 0; i < r.garment.triangles.size(); ++i) {
    if (r.panel_of_triangle[i] != panel) continue;
    const Triangle &t = r.garment.triangles[i], &f = r.flat.triangles[i];
    const Vec3 flat = (u[f[0]] + u[f[1]] + u[f[2]]) / 3.0;
    if (!counts(Vec2(flat.x() - low + left, flat.y()))) continue;
    const Vec3 at =
        (r.garment.vertices[t[0]] + r.garment.vertices[t[1]] + r.garment.vertices[t[2]]) / 3.0;
    sum += std::hypot(at.x(), at.y()) - 0.3 * (1.0 - at.z() / 0.6);
    ++count;
  }
  EXPECT_GT(count, 4) << panel;
  return sum / count;
}

TEST(WornSeamTypes, AFacingLiesInsideOfTheEdgeToWhichItIsSewn) {
  SewingPattern pattern = plain_tube();
  for (std::int32_t p = 0; p < 2; ++p) {
    PatternPanel facing = pattern.panels[p];
    facing.name = "facing_" + facing.name;
    facing.vertices[0].y() = facing.vertices[1].y() = 0.21;
    facing.translation -= 0.02 * facing.rotation.col(2);
    pattern.panels.push_back(facing);
  }
  using Direction = PatternStitch::Direction;
  for (std::int32_t p = 0; p < 2; ++p)
    pattern.stitches.push_back({{p, 2}, {p + 2, 2}, Direction::start_to_start});
  pattern.stitches.push_back({{2, 1}, {3, 3}, Direction::end_to_start});
  pattern.stitches.push_back({{2, 3}, {3, 1}, Direction::end_to_start});
  const DressResult r = dress(pattern, hill(), coarse());
  EXPECT_EQ(r.fault(), "");
  EXPECT_EQ(r.open_pairs(), 0u);
  EXPECT_LT(r.max_stretch, 0.4);
  for (std::int32_t p = 0; p < 2; ++p) {
    const double facing =
        off_the_hill(r, pattern, p + 2, [](const Vec2& at) { return at.y() < 0.06; });
    const double panel =
        off_the_hill(r, pattern, p, [](const Vec2& at) { return at.y() > 0.21 && at.y() < 0.27; });
    EXPECT_GT(panel, facing + 5e-4) << p;
  }
}

TEST(WornSeamTypes, AButtonedFrontOverlapsItsOtherHalf) {
  constexpr double kStand = 0.06;
  const SewingPattern plain = plain_tube();
  SewingPattern pattern = plain;
  const auto half = [&](const char* name, double from, double to, double out) {
    PatternPanel panel = plain.panels[0];
    panel.name = name;
    panel.vertices = {{from, 0.0}, {0.0, 0.0}, {to, 0.0}, {to, 0.3}, {0.0, 0.3}, {from, 0.3}};
    panel.edges.clear();
    for (std::int32_t i = 0; i < 6; ++i) panel.edges.push_back({{i, (i + 1) % 6}, {}, ""});
    panel.lines.push_back({.endpoints = {1, 4}});
    panel.translation += out * panel.rotation.col(2);
    return panel;
  };
  pattern.panels = {half("left", -kStand, 0.3, 0.03), plain.panels[1],
                    half("right", -0.3, kStand, 0.0)};
  using Direction = PatternStitch::Direction;
  pattern.stitches = {{{0, 2}, {1, 3}, Direction::end_to_start},
                      {{2, 5}, {1, 1}, Direction::end_to_start},
                      {{0, 6}, {2, 6}}};
  pattern.stitches[2].closure = PatternStitch::Closure::buttons;
  pattern.stitches[2].buttons = {0.1, 0.5, 0.9};
  const DressResult r = dress(pattern, hill(), coarse());
  EXPECT_EQ(r.fault(), "");
  EXPECT_EQ(r.seams[2].pairs, 3u);
  EXPECT_EQ(r.seams[2].merged, 3u);
  const auto on_stand = [](const Vec2& at) { return std::abs(at.x()) < kStand - 0.01; };
  EXPECT_GT(off_the_hill(r, pattern, 0, on_stand), off_the_hill(r, pattern, 2, on_stand) + 5e-4);
}

/// A tube of which the front has a pleat in its upper edge.
TEST(WornSeamTypes, APleatLiesBehindItsEdgeWithItsDepth) {
  const SewingPattern plain = tube(0.7, 0.3, 0.36);
  DrawnPattern drawn;
  drawn.name = "pleat";
  for (const PatternPanel& panel : plain.panels) drawn.panels.push_back({.panel = panel});
  drawn.panels[0].pleats = {{.edge = 2, .at = 0.5, .depth = 0.06, .length = 0.15}};
  drawn.stitches = {{{{0, {1}, false}}, {{1, {3}, false}}, false},
                    {{{0, {3}, false}}, {{1, {1}, false}}, false}};
  const SewingPattern sewn = as_sewn(drawn);
  const GarmentMesh mesh = mesh_garment(sewn, {.edge_length = 0.03});
  const DressResult r = dress(sewn, hill(), coarse());
  EXPECT_EQ(r.fault(), "");
  EXPECT_EQ(r.open_pairs(), 0u);
  std::vector<std::int32_t> corner(r.flat.vertices.size());
  for (std::size_t i = 0; i < r.flat.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) corner[r.flat.triangles[i][k]] = r.garment.triangles[i][k];
  const auto at = [&](std::int32_t v) { return r.garment.vertices[corner[v]]; };
  const std::vector<std::int32_t>&side = mesh.line_vertices[0][0],
        &middle = mesh.line_vertices[0][1];
  EXPECT_NEAR((at(side[0]) - at(middle[0])).norm(), 0.06, 0.012);
  // At its end, the fold lies behind the cloth beside it, not before it.
  const auto off = [&](std::int32_t v) {
    const Vec3 x = at(v);
    return std::hypot(x.x(), x.y()) - 0.3 * (1.0 - x.z() / 0.6);
  };
  EXPECT_LT(off(middle[1]), off(side[1]));
}

}  // namespace
}  // namespace selvedge::worn_seam_types_test
