// SPDX-License-Identifier: MIT
// A garment is sewn and drawn into place, and a seam is unpicked around an open pair.
#include <gtest/gtest.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/dressing.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>

#include "dress_shapes.h"

namespace selvedge::drawing_test {
namespace {

using namespace selvedge::dress_shapes;
constexpr double kNoNeck = std::numeric_limits<double>::infinity();

detail::Garment start_of(const SewingPattern& pattern) {
  return detail::start_garment(mesh_garment(pattern, {.edge_length = 0.04}));
}

/// A bodice, and a skirt that the pattern places `gap` below it.
SewingPattern bodice_and_skirt(double gap) {
  constexpr double kHeight = 0.3;
  SewingPattern pattern = tube(0.6, kHeight, 0.2);
  for (PatternPanel panel : tube(0.6, kHeight, 0.2).panels) {
    panel.name = "skirt_" + panel.name;
    panel.translation.z() -= kHeight + gap;
    pattern.panels.push_back(panel);
  }
  using Direction = PatternStitch::Direction;
  pattern.stitches.push_back({{2, 1}, {3, 3}, Direction::end_to_start});
  pattern.stitches.push_back({{2, 3}, {3, 1}, Direction::end_to_start});
  pattern.stitches.push_back({{0, 0}, {2, 2}, Direction::end_to_start});
  pattern.stitches.push_back({{1, 0}, {3, 2}, Direction::end_to_start});
  return pattern;
}

TEST(Drawing, PanelsThatAreDrawnApartBelongTogether) {
  for (const double gap : {0.01, 0.1, 0.15}) {
    const auto places = detail::panel_places(start_of(bodice_and_skirt(gap)), 4, kNoNeck);
    ASSERT_EQ(places.size(), 4u);
    for (const detail::PanelPlace& place : places)
      EXPECT_NEAR(std::abs(place.axis.z()), 1.0, 1e-9) << "along the side seams";
    for (const std::size_t bodice : {0u, 1u}) EXPECT_EQ(places[bodice].shift, Vec3::Zero());
    for (const std::size_t skirt : {2u, 3u}) {
      if (gap < 0.03)
        EXPECT_EQ(places[skirt].shift, Vec3::Zero()) << "less than a seam is worth";
      else
        EXPECT_LT((places[skirt].shift - Vec3(0.0, 0.0, gap)).norm(), 1e-6) << gap;
    }
  }
}

TEST(Drawing, AHoodDoesNotCarryTheGarment) {
  SewingPattern pattern = bodice_and_skirt(0.1);
  // The upper tube is now a hood above the neck: the lower one stays, and the hood comes down.
  const auto places = detail::panel_places(start_of(pattern), 4, 0.0);
  for (const std::size_t trunk : {2u, 3u}) EXPECT_EQ(places[trunk].shift, Vec3::Zero());
  for (const std::size_t hood : {0u, 1u}) EXPECT_NEAR(places[hood].shift.z(), -0.1, 1e-6);
}

DressResult empty_result(std::size_t stitches) {
  DressResult r;
  r.clean = true;
  r.panel_names = {"front", "back"};
  r.seams.resize(stitches);
  return r;
}

TEST(Drawing, AGarmentThatSlidUpIsDrawnDown) {
  const SewingPattern pattern = tube(0.6, 0.3, 0.32);
  const detail::Garment start = start_of(pattern);
  detail::Garment garment = start;
  for (Vec3& x : garment.surface.vertices) x.z() += 0.08;
  const TriangleMesh body = cone(0.1, 0.3);
  const Methods methods;
  DressConfig config;
  config.edge_length = 0.04;
  std::size_t crossings = 0, frames = 0;
  DressObserver observer;
  observer.accepted = [&](const Simulation& now, DressPhase phase) {
    EXPECT_EQ(phase, DressPhase::draw);
    crossings += find_crossings(now.positions(), now.cloth_triangles()).size();
    ++frames;
  };
  const detail::Deadline deadline(1e9);
  DressResult result = empty_result(pattern.stitches.size());
  detail::draw_into_place(garment, start, detail::panel_places(start, 2, kNoNeck),
                          {body, config, methods, observer, deadline}, result);
  EXPECT_GT(frames, 5u);
  EXPECT_EQ(crossings, 0u);
  EXPECT_TRUE(result.clean);
  double off = 0.0;
  for (std::size_t v = 0; v < start.surface.vertices.size(); ++v)
    off += std::abs(garment.surface.vertices[v].z() - start.surface.vertices[v].z());
  EXPECT_LT(off / static_cast<double>(start.surface.vertices.size()), 0.015);
}

/// Mean distance of the vertices from the mirror images of their images in x = 0, m.
double one_sided(const detail::Garment& garment) {
  double sum = 0.0;
  const std::vector<Vec3>& x = garment.surface.vertices;
  for (std::size_t v = 0; v < garment.image.size(); ++v) {
    const Vec3& image = x[garment.corner[garment.image[v]]];
    sum += (x[garment.corner[v]] - Vec3(-image.x(), image.y(), image.z())).norm();
  }
  return sum / static_cast<double>(garment.image.size());
}

TEST(Drawing, AGarmentThatLiesAskewIsPulledStraightOnAPerson) {
  const SewingPattern pattern = tube(0.6, 0.3, 0.32);
  const detail::Garment start = start_of(pattern);
  EXPECT_LT(one_sided(start), 1e-9);
  const TriangleMesh body = cone(0.1, 0.3);
  const Methods methods;
  DressConfig config;
  config.edge_length = 0.04;
  const DressObserver observer;
  const detail::Deadline deadline(1e9);
  for (const bool is_person : {true, false}) {
    detail::Garment garment = start;
    const double c = std::cos(0.15), s = std::sin(0.15);
    for (Vec3& x : garment.surface.vertices)
      x = Vec3(c * x.x() - s * x.y() + 0.02, s * x.x() + c * x.y(), x.z());
    const double before = one_sided(garment);
    EXPECT_GT(before, 0.04);
    DressResult result = empty_result(pattern.stitches.size());
    detail::draw_into_place(
        garment, start, detail::panel_places(start, 2, kNoNeck),
        {body, config, methods, observer, deadline, is_person ? std::optional(0.0) : std::nullopt},
        result);
    EXPECT_TRUE(result.clean);
    if (is_person)
      EXPECT_LT(one_sided(garment), 0.25 * before);
    else
      EXPECT_GT(one_sided(garment), 0.8 * before) << "a table has no left and right";
  }
}

/// The garment with all pairs of its stitches merged, but for pair `open` of the first one.
detail::Garment merged(const detail::Garment& start, std::size_t open) {
  detail::Garment garment = start;
  std::vector<std::int32_t> root = start.corner;
  for (std::size_t s = 0; s < start.stitches.size(); ++s)
    for (std::size_t i = 0; i < start.stitches[s].a.size(); ++i) {
      if (s == 0 && i == open) continue;
      const std::int32_t a = root[start.stitches[s].a[i]], b = root[start.stitches[s].b[i]];
      std::replace(root.begin(), root.end(), std::max(a, b), std::min(a, b));
    }
  std::map<std::int32_t, std::int32_t> number;
  std::vector<Vec3> sum;
  std::vector<double> count;
  for (std::size_t f = 0; f < root.size(); ++f) {
    const auto [at, is_new] = number.try_emplace(root[f], static_cast<std::int32_t>(sum.size()));
    if (is_new) {
      sum.push_back(Vec3::Zero());
      count.push_back(0.0);
    }
    garment.corner[f] = at->second;
    sum[at->second] += start.surface.vertices[f];
    count[at->second] += 1.0;
  }
  for (std::size_t v = 0; v < sum.size(); ++v) sum[v] /= count[v];
  garment.surface.vertices = sum;
  garment.velocity.assign(sum.size(), Vec3::Zero());
  for (std::size_t i = 0; i < garment.flat.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k)
      garment.surface.triangles[i][k] = garment.corner[garment.flat.triangles[i][k]];
  return garment;
}

TEST(Unpicking, OpensTheSeamAroundAnOpenPairAlone) {
  const detail::Garment start = start_of(tube(0.6, 0.6, 0.32));
  const std::size_t pairs = start.stitches[0].a.size();
  ASSERT_GT(pairs, 12u);
  detail::Garment garment = merged(start, pairs / 2);
  ASSERT_EQ(garment.open_pairs(), 1u);
  const TriangleMesh body = cone(0.05, 0.3);
  const Methods methods;
  const DressConfig config;
  const DressObserver observer;
  const detail::Deadline deadline(1e9);
  const detail::Dressing dressing{body, config, methods, observer, deadline};
  ASSERT_TRUE(detail::unpick(garment, dressing, 3));
  EXPECT_EQ(garment.open_pairs(), 7u) << "three on each side";
  EXPECT_EQ(garment.open_pairs(1), std::vector<Edge>{});
  for (const Edge& pair : garment.open_pairs(0)) {
    const double distance =
        (garment.surface.vertices[pair[0]] - garment.surface.vertices[pair[1]]).norm();
    EXPECT_GT(distance, 0.0);
  }
  EXPECT_TRUE(find_meetings(garment.surface.vertices, garment.surface.triangles).empty());
  EXPECT_EQ(garment.velocity.size(), garment.surface.vertices.size());
  // Nothing is open: nothing to unpick.
  detail::Garment closed = merged(start, pairs);
  EXPECT_FALSE(detail::unpick(closed, dressing, 3));
}

TEST(Unpicking, GoesRoundACornerWhereOtherSeamsEnd) {
  const detail::Garment start = start_of(bodice_and_skirt(0.01));
  const detail::Stitching& side = start.stitches[0];  // of the bodice, down to the waist
  const auto height = [&](std::int32_t v) { return start.surface.vertices[start.corner[v]].z(); };
  const std::size_t pairs = side.a.size();
  const bool is_down = height(side.a.back()) < height(side.a.front());
  detail::Garment garment = merged(start, is_down ? pairs - 2 : 1);
  const TriangleMesh body = cone(0.05, 0.3);
  const Methods methods;
  const DressConfig config;
  const DressObserver observer;
  const detail::Deadline deadline(1e9);
  ASSERT_TRUE(detail::unpick(garment, {body, config, methods, observer, deadline}, 3));
  EXPECT_EQ(garment.open_pairs(0).size(), 5u) << "to the waist, and three up";
  EXPECT_EQ(garment.open_pairs(1).size(), 0u);
  EXPECT_EQ(garment.open_pairs(2).size() + garment.open_pairs(3).size(), 2u) << "of the skirt";
  EXPECT_EQ(garment.open_pairs(4).size(), 2u) << "of the waist";
  EXPECT_EQ(garment.open_pairs(5).size(), 2u);
}

TEST(Unpicking, LeavesAPairThatCannotMoveAndOpensTheOthers) {
  const detail::Garment start = start_of(tube(0.6, 0.6, 0.32));
  const std::size_t open = start.stitches[0].a.size() / 2;
  detail::Garment garment = merged(start, open);
  const Vec3 x = garment.surface.vertices[garment.corner[start.stitches[0].a[open + 2]]];
  TriangleMesh body;  // a triangle on each side of that vertex, in the way of both panels
  for (const double side : {-1e-7, 1e-7}) {
    const auto first = static_cast<std::int32_t>(body.vertices.size());
    body.triangles.push_back({first, first + 1, first + 2});
    for (const Vec3& corner :
         {Vec3(-1e-3, side, -1e-3), Vec3(1e-3, side, -1e-3), Vec3(0, side, 2e-3)})
      body.vertices.push_back(x + corner);
  }
  const Methods methods;
  const DressConfig config;
  const DressObserver observer;
  const detail::Deadline deadline(1e9);
  ASSERT_TRUE(detail::unpick(garment, {body, config, methods, observer, deadline}, 3));
  EXPECT_GE(garment.open_pairs(), 4u);
  EXPECT_LT(garment.open_pairs(), 7u);
  EXPECT_EQ(garment.corner[start.stitches[0].a[open + 2]],
            garment.corner[start.stitches[0].b[open + 2]]);
}

TEST(Unpicking, SeesALayerBetweenTheSidesOfASeam) {
  detail::Garment garment;
  garment.surface.vertices = {{0, 0, -0.01},   {0, 0, 0.01}, {1, 0, -0.01}, {1, 0, 0.01},
                              {-0.1, -0.1, 0}, {0.2, 0, 0},  {0, 0.2, 0}};
  garment.surface.triangles = {{4, 5, 6}};
  EXPECT_TRUE(detail::has_layer_between(garment, std::vector<Edge>{{2, 3}, {0, 1}}));
  EXPECT_FALSE(detail::has_layer_between(garment, std::vector<Edge>{{2, 3}}));
}

TEST(Sewing, AStiffHoodOfOthersClosesAtOnce) {
  const std::filesystem::path shared =
      std::filesystem::path(SELVEDGE_SOURCE_DIR) / "../shared/data/garments";
  if (!std::filesystem::exists(shared)) GTEST_SKIP() << shared << " does not exist";
  LoadConfig file;
  file.up = UpAxis::y;
  const TriangleMesh body = load_mesh(shared / "bodies/f_smpl_average_A40.obj", file);
  const SewingPattern pattern = turned_upright(
      read_sewing_pattern(shared / "patterns/hoody_mean_specification.json"), UpAxis::y);
  GarmentMesh mesh = mesh_garment(pattern, {.edge_length = 0.02});
  find_free_start(mesh, body, 0.5);
  detail::Garment garment = detail::start_garment(mesh);
  const Methods methods;
  DressConfig config;
  config.edge_length = 0.02;
  const DressObserver observer;
  const detail::Deadline deadline(1e9);
  DressResult result = empty_result(pattern.stitches.size());
  using detail::SeamChoice;
  detail::sew(garment, {body, config, methods, observer, deadline}, DressPhase::sew,
              {.merge_share = 0.35,
               .stages = {SeamChoice::spanning, SeamChoice::gathered, SeamChoice::all},
               .is_stiff = true},
              result);
  EXPECT_TRUE(result.clean);
  EXPECT_EQ(garment.open_pairs(), 0u);
  EXPECT_LT(result.sew_time, 3.0) << "soft, it was not closed after 7 s";
}

}  // namespace
}  // namespace selvedge::drawing_test
