// SPDX-License-Identifier: MIT
// Garments that are put on: free start, sewing, settling, and the folder of the result.
#include "dress_shapes.h"

#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/dressing.h>
#include <selvedge/dress/dress_result.h>
#include <selvedge/garment/sewing_pattern.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

namespace selvedge::dress_test {
namespace {

namespace fs = std::filesystem;
using namespace selvedge::dress_shapes;

/// An upright prism around the z axis.
TriangleMesh prism(double radius, double low, double high, int segments = 24) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3(0.0, 0.0, low), Vec3(0.0, 0.0, high)};
  for (int i = 0; i < segments; ++i)
    for (const double z : {low, high}) {
      const double angle = 2.0 * std::numbers::pi * i / segments;
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
  for (int i = 0; i < segments; ++i) {
    const std::int32_t a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % segments);
    for (const Triangle& t :
         {Triangle{0, b, a}, {1, a + 1, b + 1}, {a, b, a + 1}, {b, b + 1, a + 1}})
      mesh.triangles.push_back(t);
  }
  return mesh;
}

DressConfig coarse() {
  DressConfig config;
  config.edge_length = 0.03;
  config.sewing_edge_length = 0.06;
  return config;
}

TEST(Dress, ATubeIsSewnAroundAConeAndRests) {
  const TriangleMesh body = cone(0.3, 0.6);
  std::vector<std::string> hashes;
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    int crossings = 0;
    DressObserver observer;
    observer.accepted = [&](const Simulation& now, DressPhase) {
      crossings += static_cast<int>(find_crossings(now.positions(), now.cloth_triangles()).size());
      crossings += static_cast<int>(
          find_crossings({now.positions(), now.cloth_triangles()}, {body.vertices, body.triangles})
              .size());
    };
    const DressResult r = dress(tube(0.6, 0.3, 0.32), body, coarse(), {}, observer);
    EXPECT_EQ(r.fault(), "");
    EXPECT_EQ(crossings, 0);
    EXPECT_GT(r.states, 10);
    for (const SeamReport& seam : r.seams) EXPECT_EQ(seam.merged, seam.pairs) << seam.name;
    EXPECT_EQ(r.largest_opening, 0.0);
    for (const Vec3& x : r.garment.vertices) EXPECT_GT(x.z(), -0.2);  // not fallen off
    ASSERT_EQ(r.panel_drop.size(), 2u);
    // Seams that close push it up the cone, from a mean height of 0.15 m. A stricter limit refuses
    // it.
    double height = 0.0;
    for (const Vec3& x : r.garment.vertices) height += x.z();
    height /= static_cast<double>(r.garment.vertices.size());
    EXPECT_NEAR(0.5 * (r.panel_drop[0] + r.panel_drop[1]), 0.15 - height, 0.02);
    // The body carries the garment: without friction, the normal forces would sum up to 2.2 times
    // its weight on this slope, with friction to at least its weight.
    ASSERT_EQ(r.pressure.size(), r.garment.vertices.size());
    const std::vector<double> area = vertex_areas(r.garment.vertices, r.garment.triangles);
    double force = 0.0;
    for (std::size_t v = 0; v < area.size(); ++v) force += r.pressure[v] * area[v];
    const double weight =
        9.81 * 0.2 * surface_area(r.flat.vertices, r.flat.triangles);  // N, coarse().fabric
    EXPECT_GT(force, 0.8 * weight);
    EXPECT_LT(force, 20.0 * weight);  // a tight tube also presses
    for (std::size_t v = 0; v < area.size(); ++v) EXPECT_GE(r.pressure[v], 0.0);
    DressResult strict = r;
    strict.largest_drop = std::abs(r.panel_drop[0]) - 0.01;
    EXPECT_NE(strict.reservation().find("than the pattern places it"), std::string::npos);
    hashes.push_back(r.state_hash);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

/// The cone on which the tube comes to rest, that moves sideways and leans over.
std::vector<TriangleMesh> leaning_poses(const TriangleMesh& body, int count) {
  std::vector<TriangleMesh> poses;
  for (int k = 1; k <= count; ++k) {
    const double share = static_cast<double>(k) / count;
    TriangleMesh pose = body;
    for (Vec3& x : pose.vertices) x.x() += share * (0.1 + 0.2 * x.z());
    poses.push_back(pose);
  }
  return poses;
}

TEST(Dress, AGarmentFollowsTheBodyThroughItsPosesWithoutACrossing) {
  const TriangleMesh body = cone(0.3, 0.6);
  DressConfig config = coarse();
  config.sewing_edge_length = config.edge_length = 0.06;
  config.motion.poses = leaning_poses(body, 8);
  config.motion.rate = 20.0;
  config.motion.lead = 0.1;  // the way to the first pose: two frames of the body
  std::vector<std::vector<Vec3>> ends;
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    std::size_t crossings = 0, moving_states = 0;
    std::vector<double> error;
    std::vector<Vec3> last;
    DressObserver observer;
    observer.accepted = [&](const Simulation& now, DressPhase phase) {
      if (phase != DressPhase::move) return;
      ++moving_states;
      crossings += find_crossings(now.positions(), now.cloth_triangles()).size();
      crossings += find_crossings({now.positions(), now.cloth_triangles()},
                                  {now.body_positions(), now.body_triangles()})
                       .size();
    };
    observer.pose = [&](const Simulation& now, std::size_t k) {
      double largest = 0.0;
      for (std::size_t v = 0; v < body.vertices.size(); ++v)
        largest = std::max(largest,
                           (now.body_positions()[v] - config.motion.poses[k].vertices[v]).norm());
      error.push_back(largest);
      last.assign(now.positions().begin(), now.positions().end());
    };
    const DressResult r = dress(tube(0.6, 0.3, 0.32), body, config, {}, observer);
    EXPECT_EQ(r.fault(), "");
    EXPECT_EQ(crossings, 0u);
    EXPECT_GT(moving_states, 20u);
    EXPECT_EQ(r.jams, 0);
    ASSERT_EQ(r.poses.size(), 8u);
    EXPECT_NEAR(r.poses.front().time, 0.1, 1e-9);
    EXPECT_NEAR(r.poses.back().time, 0.1 + 7 / 20.0, 1e-9);
    ASSERT_EQ(error.size(), 8u);
    for (const double e : error) EXPECT_LT(e, 1e-12);  // m, the body is where its pose puts it
    // The garment has come along, and the result still holds that of the dressing pose.
    Vec3 before = Vec3::Zero(), after = Vec3::Zero();
    for (const Vec3& x : r.garment.vertices) before += x / double(r.garment.vertices.size());
    for (const Vec3& x : last) after += x / double(last.size());
    EXPECT_NEAR(before.x(), 0.0, 0.02);
    EXPECT_GT(after.x() - before.x(), 0.08);
    ends.push_back(last);
    DressResult strict = r;
    strict.poses[3].drop = strict.largest_drop + 0.01;
    EXPECT_NE(strict.reservation().find("at pose 3"), std::string::npos) << strict.verdict();
  }
  EXPECT_EQ(ends[0], ends[1]);
}

TEST(Dress, APoseThatIsTheBodyNeedsNoLead) {
  const TriangleMesh body = cone(0.3, 0.6);
  DressConfig config = coarse();
  config.sewing_edge_length = config.edge_length = 0.06;
  config.motion.poses = {body, body};
  const DressResult r = dress(tube(0.6, 0.3, 0.32), body, config);
  ASSERT_EQ(r.poses.size(), 2u);
  EXPECT_EQ(r.poses[0].time, 0.0);
  EXPECT_NEAR(r.poses[1].time, 1.0 / 30.0, 1e-9);
}

TEST(Dress, APoseOfAnotherMeshIsRefused) {
  DressConfig config = coarse();
  config.motion.poses = {cone(0.3, 0.6, 12)};
  EXPECT_THROW(dress(tube(0.6, 0.3, 0.32), cone(0.3, 0.6), config), std::invalid_argument);
}

TEST(Dress, ASplitMovesNoPointAndBendsCurvedEdges) {
  SewingPattern pattern = tube(0.4, 0.3, 0.2);
  PatternCurve& hem = pattern.panels[0].edges[0].curve;
  hem.kind = PatternCurve::Kind::quadratic;
  hem.control[0] = {0.0, -0.05};
  PanelMeshConfig config;
  config.edge_length = 0.06;
  const GarmentMesh mesh = mesh_garment(pattern, config);
  detail::Garment garment = detail::start_garment(mesh);
  const std::vector<Vec3> before = garment.surface.vertices;
  const double area = surface_area(garment.surface.vertices, garment.surface.triangles),
               flat = surface_area(garment.flat.vertices, garment.flat.triangles);
  detail::split_garment(pattern, garment);
  EXPECT_EQ(garment.surface.triangles.size(), 4 * mesh.flat.triangles.size());
  EXPECT_TRUE(std::equal(before.begin(), before.end(), garment.surface.vertices.begin()));
  EXPECT_NEAR(surface_area(garment.surface.vertices, garment.surface.triangles), area,
              1e-12 * area);
  // The polygon of the hem comes nearer to its curve, which bulges outward.
  EXPECT_GT(surface_area(garment.flat.vertices, garment.flat.triangles), flat);
  for (const detail::DividedEdge& border : garment.borders) {
    const PatternPanel& panel = pattern.panels[static_cast<std::size_t>(border.panel)];
    const auto pieces = static_cast<std::int32_t>(border.vertices.size()) - 1;
    const std::vector<Vec2> curve = divide_edge(panel, border.edge, pieces);
    for (std::size_t i = 1; i < curve.size(); ++i)
      EXPECT_NEAR((garment.flat.vertices[border.vertices[i]] -
                   garment.flat.vertices[border.vertices[i - 1]])
                      .norm(),
                  (curve[i] - curve[i - 1]).norm(), 1e-7);  // the mesh has rounded coordinates
  }
}

TEST(Dress, SeamsThatAreFarOpenAtTheStartSpanTheBody) {
  PanelMeshConfig mesh;
  mesh.edge_length = 0.06;
  detail::Garment garment = detail::start_garment(mesh_garment(tube(0.4, 0.3, 0.2), mesh));
  ASSERT_EQ(garment.stitches.size(), 2u);
  for (std::size_t s = 0; s < 2; ++s) {
    EXPECT_NEAR(garment.stitches[s].span, 0.4, 1e-6);  // front and back are 0.2 m from the axis
    EXPECT_TRUE(garment.is_chosen(s, detail::SeamChoice::spanning));
  }
  garment.stitches[1].span = 0.1;
  EXPECT_TRUE(garment.is_chosen(0, detail::SeamChoice::spanning));
  EXPECT_FALSE(garment.is_chosen(1, detail::SeamChoice::spanning));
  // The others join the panels of the front with each other, and those of the back.
  EXPECT_FALSE(garment.is_chosen(0, detail::SeamChoice::halves));
  EXPECT_TRUE(garment.is_chosen(1, detail::SeamChoice::halves));
}

TEST(Dress, OnlyGatheredSeamsPullWhileTheyCloseFirst) {
  SewingPattern pattern = tube(0.4, 0.3, 0.2);
  // The left side of the front is half as long as the right side of the back, which it joins.
  pattern.panels[0].vertices[3].y() = 0.15;
  DressConfig config = coarse();
  PanelMeshConfig mesh;
  mesh.edge_length = 0.06;
  const detail::Garment garment = detail::start_garment(mesh_garment(pattern, mesh));
  ASSERT_EQ(garment.stitches.size(), 2u);
  EXPECT_FALSE(garment.stitches[0].is_gathered());
  EXPECT_TRUE(garment.stitches[1].is_gathered());
  EXPECT_NEAR(garment.stitches[1].ease, 1.0, 1e-9);
  for (const auto choice : {detail::SeamChoice::all, detail::SeamChoice::gathered}) {
    const detail::DressScene made = detail::make_dress_scene(
        garment, cone(0.05, 0.2), config, {.pull = 10.0, .merge = 0.35, .seams = choice});
    ASSERT_EQ(made.scene.seams.size(), choice == detail::SeamChoice::gathered ? 1u : 2u);
    EXPECT_EQ(made.scene.seams.back().vertices[0].size(), garment.open_pairs(1).size());
  }
}

/// A box with its faces outward.
TriangleMesh box(const Vec3& low, const Vec3& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.emplace_back((i & 1) != 0 ? high.x() : low.x(), (i & 2) != 0 ? high.y() : low.y(),
                               (i & 4) != 0 ? high.z() : low.z());
  mesh.triangles = {{0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}, {0, 1, 4}, {4, 1, 5},
                    {2, 6, 3}, {3, 6, 7}, {0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}};
  return mesh;
}

TEST(Dress, AVertexOfABlockedPairMovesToTheOtherOne) {
  constexpr double half = 0.003;  // m, of the distance of front and back
  PanelMeshConfig mesh;
  mesh.edge_length = 0.06;
  const detail::Garment start = detail::start_garment(mesh_garment(tube(0.4, 0.3, half), mesh));
  // A plate between the sides of the seam at +x; the other seam is free.
  const TriangleMesh plate = box({0.15, -0.0005, -0.1}, {0.3, 0.0005, 0.4});
  const DressConfig config = coarse();
  const Methods methods;
  const DressObserver observer;
  const detail::Deadline deadline(config.budget);
  const detail::Dressing dressing{plate, config, methods, observer, deadline};
  detail::DressScene made =
      detail::make_dress_scene(start, plate, config, {.pull = 10.0, .merge = 0.35});
  const auto owned = detail::start_simulation(made, dressing);
  const Simulation& simulation = *owned;
  detail::Garment garment = start;
  const std::size_t moved = detail::move_together(simulation, garment, dressing, 0.35);
  std::size_t nearer = 0;
  for (std::size_t s = 0; s < garment.stitches.size(); ++s)
    for (const Edge& pair : garment.open_pairs(s)) {
      const std::vector<Vec3>&from = start.surface.vertices, &to = garment.surface.vertices;
      if (from[pair[0]].x() > 0.0) {
        EXPECT_EQ(to[pair[0]], from[pair[0]]);
        EXPECT_EQ(to[pair[1]], from[pair[1]]);
        continue;
      }
      ++nearer;
      EXPECT_LT((to[pair[1]] - to[pair[0]]).norm(), 0.1 * half);
      EXPECT_TRUE(to[pair[0]] == from[pair[0]] || to[pair[1]] == from[pair[1]]);
    }
  EXPECT_GT(nearer, 3u);
  EXPECT_EQ(moved, nearer);
  EXPECT_TRUE(find_crossings(garment.surface.vertices, garment.surface.triangles).empty());
  EXPECT_TRUE(find_crossings({garment.surface.vertices, garment.surface.triangles},
                             {plate.vertices, plate.triangles})
                  .empty());
  // Nothing moves beyond the merge distance.
  detail::Garment far = start;
  EXPECT_EQ(detail::move_together(simulation, far, dressing, 0.01), 0u);
  EXPECT_EQ(far.surface.vertices, start.surface.vertices);
}

TEST(Dress, APanelThatCrossesTheBodyIsMovedOut) {
  const TriangleMesh body = cone(0.3, 0.6);
  GarmentMesh mesh = mesh_garment(tube(0.6, 0.3, 0.25), {});
  EXPECT_FALSE(
      find_crossings({mesh.placed, mesh.flat.triangles}, {body.vertices, body.triangles}).empty());
  const std::vector<MovedPanel> moved = find_free_start(mesh, body, 0.5);
  ASSERT_EQ(moved.size(), 2u);
  EXPECT_LT(moved[0].by.y(), 0.0);
  EXPECT_GT(moved[1].by.y(), 0.0);
  EXPECT_TRUE(
      find_crossings({mesh.placed, mesh.flat.triangles}, {body.vertices, body.triangles}).empty());
}

TEST(Dress, APanelWithoutAFreePlaceIsNamed) {
  GarmentMesh mesh = mesh_garment(tube(0.6, 0.3, 0.25), {});
  try {
    find_free_start(mesh, cone(0.3, 0.6), 0.01);
    FAIL() << "no free place was needed";
  } catch (const DressFailed& failure) {
    EXPECT_NE(std::string(failure.what()).find("panel \"front\""), std::string::npos)
        << failure.what();
  }
}

TEST(Dress, ASeamThatCannotCloseIsNamed) {
  DressConfig config = coarse();
  config.sewing_edge_length = config.edge_length;
  config.largest_pull = config.pull;  // far too weak for half of the girth
  config.sew_time = 0.2;  // later the panels may slide around the body and close beside it
  int restarts = 0;
  DressObserver observer;
  observer.restart = [&] { ++restarts; };
  try {
    dress(tube(0.3, 0.2, 0.32), prism(0.3, -1.0, 1.0), config, {}, observer);
    FAIL() << "the tube is much too small";
  } catch (const DressFailed& failure) {
    EXPECT_NE(std::string(failure.what()).find("does not close"), std::string::npos)
        << failure.what();
    EXPECT_NE(std::string(failure.what()).find("front"), std::string::npos) << failure.what();
  }
  EXPECT_EQ(restarts, 3);  // between four attempts
}

/// Two boxes in one mesh, `gap` apart along x.
TriangleMesh two_boxes(double gap) {
  TriangleMesh mesh;
  for (const double side : {-1.0, 1.0}) {
    const auto first = static_cast<std::int32_t>(mesh.vertices.size());
    for (int i = 0; i < 8; ++i) {
      const double x = (i & 1) != 0 ? 0.5 * gap : 0.5 * gap + 0.1;
      mesh.vertices.emplace_back(side * x, (i & 2) != 0 ? 0.05 : -0.05,
                                 (i & 4) != 0 ? 0.05 : -0.05);
    }
    const std::vector<Triangle> faces = {{0, 2, 4}, {2, 6, 4}, {1, 5, 3}, {3, 5, 7},
                                         {0, 4, 1}, {4, 5, 1}, {2, 3, 6}, {3, 7, 6},
                                         {0, 1, 2}, {1, 3, 2}, {4, 6, 5}, {5, 6, 7}};
    for (Triangle t : faces) {
      if (side < 0.0) std::swap(t[1], t[2]);
      mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  }
  return mesh;
}

TEST(Dress, TheVerdictNamesTheWidestOpenSeam) {
  DressResult r;
  r.clean = true;
  r.largest_opening = 0.004;
  r.seams = {{.name = "stitch 0", .opening_end = 0.001},
             {.name = "stitch 1", .opening_end = 0.004}};
  EXPECT_EQ(r.fault(), "stitch 1 is open by 4.00 mm");
}

TEST(Dress, ABodyThatNearlyTouchesItselfMakesRoom) {
  const BodyRoom wide = make_room(two_boxes(0.02), 0.01);
  EXPECT_EQ(wide.vertices, 0);
  const BodyRoom narrow = make_room(two_boxes(0.004), 0.01);
  EXPECT_GT(narrow.vertices, 0);
  EXPECT_GE(narrow.largest, 0.003 - 1e-12);
  double gap = 1.0;
  for (const Vec3& x : narrow.body.vertices) gap = std::min(gap, 2.0 * std::abs(x.x()));
  EXPECT_GT(gap, 0.004);
  EXPECT_EQ(make_room(two_boxes(0.004), 0.0).vertices, 0);
}

TEST(Dress, TheRoomDoesNotDependOnWhereTheBodyIs) {
  const Vec3 shift(10.0, -20.0, 30.0);
  TriangleMesh moved = two_boxes(0.004);
  for (Vec3& x : moved.vertices) x += shift;
  const BodyRoom here = make_room(two_boxes(0.004), 0.01), there = make_room(moved, 0.01);
  EXPECT_EQ(there.vertices, here.vertices);
  for (std::size_t v = 0; v < here.body.vertices.size(); ++v)
    EXPECT_LT((there.body.vertices[v] - shift - here.body.vertices[v]).norm(), 1e-12) << v;
}

TEST(Dress, OnlySidesThatFaceEachOtherMakeRoom) {
  // A plate, and the side of a wall that ends above it: the wall faces along the plate.
  TriangleMesh mesh;
  mesh.vertices = {{-0.1, -0.1, 0},  {0.1, -0.1, 0},  {0.1, 0.1, 0}, {-0.1, 0.1, 0}, {0, 0, 0},
                   {0, -0.2, 0.004}, {0, 0.2, 0.004}, {0, 0.2, 0.2}, {0, -0.2, 0.2}};
  mesh.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {5, 6, 7}, {5, 7, 8}};
  EXPECT_EQ(make_room(mesh, 0.01).vertices, 0);
}

TEST(Dress, FramesOfABodyThatRestsMakeTheRoomOfTheBody) {
  const BodyRoom still = make_room(two_boxes(0.004), 0.01);
  std::vector<TriangleMesh> frames(5, two_boxes(0.004));
  make_room(frames, 0.01);
  for (const TriangleMesh& frame : frames)
    for (std::size_t v = 0; v < frame.vertices.size(); ++v)
      EXPECT_LT((frame.vertices[v] - still.body.vertices[v]).norm(), 1e-12) << v;
}

TEST(Dress, NumbersOutOfRangeAreRefused) {
  DressConfig config = coarse();
  config.pull = 0.0;
  EXPECT_THROW(dress(tube(0.6, 0.3, 0.32), cone(0.3, 0.6), config), std::invalid_argument);
}

const fs::path kRoot = SELVEDGE_SOURCE_DIR;

TEST(Dress, AnOwnPatternHasTheSameBitsOnOneAndTwoThreads) {
  const SewingPattern pattern = read_sewing_pattern(kRoot / "data/patterns/flared_skirt.json");
  const TriangleMesh body = read_mesh(kRoot / "data/bodies/mannequin_arms_out.ply");
  DressConfig config;
  config.edge_length = config.sewing_edge_length = 0.05;
  std::vector<DressResult> results;
  for (const int threads : {1, 1, 2}) {
    const ThreadLimit limit(threads);
    results.push_back(dress(pattern, body, config));
    EXPECT_EQ(results.back().fault(), "");
  }
  for (const DressResult& r : results) {
    EXPECT_EQ(r.state_hash, results[0].state_hash);
    EXPECT_EQ(r.garment.vertices, results[0].garment.vertices);
    EXPECT_EQ(r.velocity, results[0].velocity);
  }
}

/// `dress`, and the crossings of the garment with itself and with the body in all frames.
DressResult dress_and_search(const SewingPattern& pattern, const TriangleMesh& body,
                             const DressConfig& config, std::size_t& crossings) {
  crossings = 0;
  const TriangleMesh skin = make_room(body, config.body_room).body;
  DressObserver observer;
  observer.frame = [&](const Simulation& now, DressPhase, double) {
    crossings += find_crossings(now.positions(), now.cloth_triangles()).size();
    crossings +=
        find_crossings({now.positions(), now.cloth_triangles()}, {skin.vertices, skin.triangles})
            .size();
  };
  return dress(pattern, body, config, {}, observer);
}

/// Hard pulls fold the sleeves into the armpits, where the last open pairs hold the folds. How far
/// they close then depends on every bit, so that one of two pulls must close, with soft panels or
/// with the stiff ones that follow. If no pair ever let go, both would stay open by 6 mm.
TEST(Dress, LastPairsThatHoldAFoldLetItGoAndClose) {
  const SewingPattern pattern = read_sewing_pattern(kRoot / "data/patterns/hooded_top.json");
  const TriangleMesh body = read_mesh(kRoot / "data/bodies/mannequin_arms_out.ply");
  DressConfig config;
  config.edge_length = config.sewing_edge_length = 0.05;
  config.settle_time = 0.1;
  int closed = 0;
  for (const double pull : {150.0, 160.0}) {
    config.pull = pull;
    std::size_t crossings = 0;
    const DressResult r = dress_and_search(pattern, body, config, crossings);
    EXPECT_TRUE(r.clean) << pull;
    EXPECT_EQ(crossings, 0u) << pull;
    if (r.attempts <= 2 && r.largest_opening < 0.001) ++closed;
  }
  EXPECT_GE(closed, 1);
}

/// Patterns and bodies that nobody here made, where they are: their folder is beside the project's.
const fs::path kShared = kRoot / "../shared/data/garments";

SewingPattern shared_pattern(const fs::path& file) {
  return turned_upright(read_sewing_pattern(file), UpAxis::y);
}

TriangleMesh shared_body(const char* name) {
  LoadConfig file;
  file.up = UpAxis::y;
  return load_mesh(kShared / "bodies" / name, file);
}

TEST(Dress, PatternsOfOthersHaveAFreeStart) {
  if (!fs::exists(kShared / "patterns")) GTEST_SKIP() << kShared << " does not exist";
  const TriangleMesh level = shared_body("f_smpl_template.obj"),
                     standing = shared_body("f_smpl_average_A40.obj");
  int patterns = 0;
  for (const auto& entry : fs::directory_iterator(kShared / "patterns")) {
    ++patterns;
    const bool stands = entry.path().stem().string().ends_with("_specification");
    const TriangleMesh& body = stands ? standing : level;
    GarmentMesh mesh = mesh_garment(shared_pattern(entry.path()), {.edge_length = 0.04});
    find_free_start(mesh, body, 0.5);
    EXPECT_TRUE(find_crossings(mesh.placed, mesh.flat.triangles).empty()) << entry.path();
    EXPECT_TRUE(
        find_crossings({mesh.placed, mesh.flat.triangles}, {body.vertices, body.triangles}).empty())
        << entry.path();
  }
  EXPECT_GE(patterns, 15);
}

TEST(Dress, ASkirtOfOthersIsSewnCleanlyOnItsBody) {
  if (!fs::exists(kShared / "patterns")) GTEST_SKIP() << kShared << " does not exist";
  const TriangleMesh body = shared_body("f_smpl_template.obj");
  DressConfig config;
  config.edge_length = config.sewing_edge_length = 0.05;
  for (const char* name : {"skirt_2_panels", "skirt_4_panels"}) {
    const SewingPattern pattern =
        shared_pattern(kShared / "patterns" / (std::string(name) + ".json"));
    std::size_t crossings = 0;
    const DressResult r = dress_and_search(pattern, body, config, crossings);
    EXPECT_EQ(r.fault(), "") << name;
    EXPECT_EQ(r.largest_opening, 0.0) << name;
    EXPECT_EQ(crossings, 0u) << name;
  }
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

TEST(DressFolder, TheTextOfAResultWithoutAGarmentHasTheShortestScales) {
  const std::string text = dress_result_text("tube", {}, "body");
  EXPECT_NE(text.find("\"strain_scale_top\": 0.01"), std::string::npos) << text;
  EXPECT_NE(text.find("\"pressure_scale_top_Pa\": 10.0"), std::string::npos) << text;
}

TEST(DressFolder, HoldsTheGarmentWithItsPatternAndTheVerdict) {
  const fs::path out = fs::temp_directory_path() / "selvedge_dress_test";
  fs::remove_all(out);
  DressFolderConfig folder;
  folder.out = out;
  folder.body_file.up = UpAxis::z;
  folder.body_name = "cone";
  const DressResult r = dress_into_folder(tube(0.6, 0.3, 0.32), cone(0.3, 0.6), coarse(), folder);
  const TriangleMesh garment = read_mesh(out / "garment.obj");
  EXPECT_EQ(garment.vertices, r.garment.vertices);
  EXPECT_EQ(garment.triangles, r.garment.triangles);
  EXPECT_EQ(read_pattern(out / "garment.obj").vertices, r.flat.vertices);
  EXPECT_NE(text_of(out / "garment.obj").find("g back"), std::string::npos);
  EXPECT_NE(text_of(out / "result.json").find("\"worn\": true"), std::string::npos);
  EXPECT_TRUE(fs::exists(out / "frames" / "cloth_00000.ply"));
  EXPECT_TRUE(fs::exists(out / "frames" / "bodies_00000.ply"));

  EXPECT_FALSE(fs::exists(out / "motion"));
  for (const char* picture : {"front", "back", "strain_front", "strain_back", "pressure_front",
                              "pressure_back", "fit_front", "fit_back", "fit_left", "fit_right"})
    EXPECT_GT(fs::file_size(out / "pictures" / (std::string(picture) + ".png")), 10000u) << picture;
  EXPECT_NE(text_of(out / "pictures" / "strain_front.png"),
            text_of(out / "pictures" / "pressure_front.png"));
  EXPECT_NE(text_of(out / "garment.ply").substr(0, 600).find("pressure"), std::string::npos);
  EXPECT_NE(text_of(out / "result.json").find("\"strain_scale_top\""), std::string::npos);

  std::ofstream(out / "result.json") << "{}";  // of something else
  EXPECT_THROW(dress_into_folder(tube(0.6, 0.3, 0.32), cone(0.3, 0.6), coarse(), folder),
               std::invalid_argument);
  fs::remove_all(out);
}

TEST(DressFolder, HoldsOnlyTheLastAttemptToCloseTheSeams) {
  const fs::path out = fs::temp_directory_path() / "selvedge_dress_attempts_test";
  fs::remove_all(out);
  DressConfig config = coarse();
  config.sewing_edge_length = config.edge_length;
  config.largest_pull = config.pull;
  config.sew_time = 0.2;  // later the panels may slide around the body and close beside it
  DressFolderConfig folder;
  folder.out = out;
  folder.pictures = false;
  EXPECT_THROW(dress_into_folder(tube(0.3, 0.2, 0.32), prism(0.3, -1.0, 1.0), config, folder),
               DressFailed);
  EXPECT_TRUE(fs::exists(out / "frames" / "cloth_00000.ply"));
  EXPECT_TRUE(fs::exists(out / "frames" / "bodies_00000.ply"));
  // 0.2 s are 12 frames, and three attempts would be 36.
  EXPECT_FALSE(fs::exists(out / "frames" / "cloth_00020.ply"));
  fs::remove_all(out);
}

TEST(DressFolder, HoldsTheGarmentAtEachPoseAndTheWayThere) {
  const fs::path out = fs::temp_directory_path() / "selvedge_dress_pose_test";
  fs::remove_all(out);
  const TriangleMesh body = cone(0.3, 0.6);
  DressConfig config = coarse();
  config.sewing_edge_length = config.edge_length = 0.06;
  config.motion.poses = leaning_poses(body, 3);
  config.motion.lead = 0.1;
  DressFolderConfig folder;
  folder.out = out;
  folder.pictures = false;
  folder.every_step = true;
  folder.body_file.up = UpAxis::z;
  folder.pose_names = {"first", "second"};
  folder.pose_formats = {"gltf", "nonesuch"};
  EXPECT_THROW(dress_into_folder(tube(0.6, 0.3, 0.32), body, config, folder),
               std::invalid_argument);
  folder.pose_formats = {"gltf", "usd", "pc2"};
  const DressResult r = dress_into_folder(tube(0.6, 0.3, 0.32), body, config, folder);
  EXPECT_EQ(r.fault(), "");
  for (const char* name : {"first.obj", "second.obj", "0002.obj"}) {
    const TriangleMesh garment = read_mesh(out / "poses" / name);
    EXPECT_EQ(garment.triangles, r.garment.triangles) << name;
    EXPECT_NE(garment.vertices, r.garment.vertices) << name;
    EXPECT_EQ(read_pattern(out / "poses" / name).vertices, r.flat.vertices) << name;
  }
  // The last frame of the motion: garment and body at the last pose.
  const auto count = [](const fs::path& of, const std::string& stem) {
    return std::count_if(fs::directory_iterator(of), fs::directory_iterator(), [&](const auto& e) {
      return e.path().filename().string().starts_with(stem);
    });
  };
  const auto frames = count(out / "motion" / "frames", "cloth_");
  EXPECT_EQ(frames, 1 + 2 * 5);  // two for each of the three frames of the lead and the two poses
  EXPECT_EQ(count(out / "motion" / "frames", "bodies_"), frames);
  EXPECT_EQ(count(out / "motion" / "steps", "bodies_"), count(out / "motion" / "steps", "cloth_"));
  EXPECT_GE(count(out / "motion" / "steps", "cloth_"), frames);
  const TriangleMesh last = read_mesh(out / "motion" / "frames" / "bodies_00010.ply");
  EXPECT_LT((last.vertices[0] - config.motion.poses.back().vertices[0]).norm(), 1e-12);
  EXPECT_EQ(count(out / "frames", "bodies_"), 1);
  EXPECT_NE(text_of(out / "result.json").find("\"motion\""), std::string::npos);
  // For other programs: pieces with normals, texture coordinates and colours.
  const std::string glb = text_of(out / "motion" / "result.glb"),
                    usd = text_of(out / "motion" / "result.usda");
  for (const char* word : {"\"garment\"", "\"body\"", "NORMAL", "TEXCOORD_0", "baseColorFactor"})
    EXPECT_NE(glb.find(word), std::string::npos) << word;
  for (const char* word : {"\"garment\"", "\"body\"", "normals", "primvars:st", "displayColor"})
    EXPECT_NE(usd.find(word), std::string::npos) << word;
  constexpr std::size_t head = 32, point = 12;  // bytes
  EXPECT_EQ(fs::file_size(out / "motion" / "cloth.pc2"),
            head + static_cast<std::size_t>(frames) * point * r.garment.vertices.size());
  fs::remove_all(out);
}

}  // namespace

}  // namespace selvedge::dress_test
