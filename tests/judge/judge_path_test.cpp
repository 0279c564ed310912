// SPDX-License-Identifier: MIT
#include <selvedge/judge/judge.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "judge_shapes.h"

namespace selvedge::judge_path_test {
namespace {

bool touch_both_ways(PathKind kind, const std::array<Vec3, 8>& points) {
  const bool unfiltered = paths_touch_unfiltered(kind, points);
  EXPECT_EQ(paths_touch(kind, points), unfiltered);
  EXPECT_EQ(first_touch(kind, points).has_value(), unfiltered);
  return unfiltered;
}

// A point that falls from height `start` to `end` on the unit triangle.
std::optional<TouchTime> falling_point_time(double start, double end) {
  return first_touch(PathKind::point_triangle,
                     std::array<Vec3, 8>{Vec3(0.25, 0.25, start), unit[0], unit[1], unit[2],
                                         Vec3(0.25, 0.25, end), unit[0], unit[1], unit[2]});
}

// A point that falls from (x,y,1) to (x,y,end) on the unit triangle.
bool falling_point_touches(double x, double y, double end) {
  return touch_both_ways(PathKind::point_triangle, {Vec3(x, y, 1), unit[0], unit[1], unit[2],
                                                    Vec3(x, y, end), unit[0], unit[1], unit[2]});
}

TEST(JudgePath, FindsAPointThatPassesThroughATriangle) {
  EXPECT_TRUE(falling_point_touches(0.25, 0.25, -1.0));
  EXPECT_FALSE(falling_point_touches(0.75, 0.75, -1.0));
}

// Two triangles come together along a side, whose vertices become one; a third lies between them.
TEST(JudgePath, VerticesThatBecomeOneMayMeetButNothingMayLieBetweenThem) {
  TriangleMesh mesh{
      {{-1, 0.5, 0}, {-0.1, 0, 0}, {-0.1, 1, 0}, {1, 0.5, 0}, {0.1, 0, 0}, {0.1, 1, 0}},
      {{0, 1, 2}, {3, 5, 4}}};
  std::vector<Vec3> end = mesh.vertices;
  end[1] = end[4] = {0, 0, 0};
  end[2] = end[5] = {0, 1, 0};
  const std::vector<std::int32_t> one{0, 1, 2, 3, 1, 2};
  EXPECT_GT(judge_path(mesh, end, {}, {}).self_collisions, 0u);
  EXPECT_EQ(judge_path(mesh, end, {}, {}, one).self_collisions, 0u);
  const TriangleMesh between{{{0.05, 0.2, -1}, {0.05, 0.8, -1}, {0.05, 0.5, 1}}, {{0, 1, 2}}};
  EXPECT_GT(judge_path(mesh, end, between, between.vertices, one).body_collisions, 0u);
  EXPECT_THROW(judge_path(mesh, end, {}, {}, std::span(one).first(5)), std::invalid_argument);
}

TEST(JudgePath, CountsATouchAtTheLastInstantAndNotOneJustMissed) {
  EXPECT_TRUE(falling_point_touches(0.25, 0.25, 0.0));
  EXPECT_FALSE(falling_point_touches(0.25, 0.25, std::numeric_limits<double>::denorm_min()));
}

TEST(JudgePath, CountsTouchesOnEdgesAndCorners) {
  EXPECT_TRUE(falling_point_touches(0.5, 0.5, -1.0));
  EXPECT_TRUE(falling_point_touches(0.0, 0.0, -1.0));
  EXPECT_FALSE(falling_point_touches(0.5, std::nextafter(0.5, 1.0), -1.0));
  EXPECT_FALSE(falling_point_touches(-1e-320, 0.0, -1.0));
}

TEST(JudgePath, DecidesMotionWithinOnePlane) {
  const auto slide = [](const Vec3& from, const Vec3& to) {
    return touch_both_ways(PathKind::point_triangle,
                           {from, unit[0], unit[1], unit[2], to, unit[0], unit[1], unit[2]});
  };
  EXPECT_TRUE(slide(Vec3(-1, 0.5, 0), Vec3(2, 0.5, 0)));
  EXPECT_TRUE(slide(Vec3(-1, 1, 0), Vec3(2, 1, 0))) << "through the corner alone";
  EXPECT_FALSE(slide(Vec3(-1, std::nextafter(1.0, 2.0), 0), Vec3(2, std::nextafter(1.0, 2.0), 0)));
  EXPECT_TRUE(slide(Vec3(0.1, 0.1, 0), Vec3(0.1, 0.1, 0)));
  EXPECT_FALSE(slide(Vec3(1, 1, 0), Vec3(2, 1, 0)));
}

TEST(JudgePath, FindsEdgesThatCrossAndEdgesThatSlideAlongOneLine) {
  const auto fall = [](const Vec3& a0, const Vec3& a1, const Vec3& step) {
    const Vec3 b0(0, 0, 0), b1(1, 0, 0);
    return touch_both_ways(PathKind::edge_edge, {a0, a1, b0, b1, a0 + step, a1 + step, b0, b1});
  };
  EXPECT_TRUE(fall(Vec3(0.5, -1, 1), Vec3(0.5, 1, 1), Vec3(0, 0, -2)));
  EXPECT_FALSE(fall(Vec3(1.5, -1, 1), Vec3(1.5, 1, 1), Vec3(0, 0, -2)));
  EXPECT_TRUE(fall(Vec3(1.5, 0, 0), Vec3(2.5, 0, 0), Vec3(-0.5, 0, 0)));
  EXPECT_FALSE(fall(Vec3(1.5, 0, 0), Vec3(2.5, 0, 0), Vec3(-0.25, 0, 0)));
  EXPECT_TRUE(fall(Vec3(0.5, 0, 1), Vec3(0.7, 0, 1), Vec3(0, 0, -3)))
      << "parallel, onto each other";
  EXPECT_TRUE(fall(Vec3(0.5, 0, 1), Vec3(0.5, 0, 1), Vec3(0, 0, -1))) << "an edge of length 0";
}

TEST(JudgePath, DecidesTheSameForReversedTimeOtherOrderAndOtherUnits) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::size_t touching = 0;
  for (int i = 0; i < 400; ++i) {
    std::array<Vec3, 8> points;
    for (Vec3& x : points) x = Vec3(uniform(random), uniform(random), uniform(random));
    for (const PathKind kind : {PathKind::point_triangle, PathKind::edge_edge}) {
      const bool touches = touch_both_ways(kind, points);
      touching += touches;
      // Reversed time, other corners first, and an exact change of unit decide the same.
      std::array<Vec3, 8> other = points;
      std::swap_ranges(other.begin(), other.begin() + 4, other.begin() + 4);
      EXPECT_EQ(touch_both_ways(kind, other), touches);
      other = points;
      std::swap(other[2], other[3]);
      std::swap(other[6], other[7]);
      EXPECT_EQ(touch_both_ways(kind, other), touches);
      for (const double unit_size : {0x1p-1000, 0x1p1000}) {
        other = points;
        for (Vec3& x : other) x *= unit_size;
        EXPECT_EQ(touch_both_ways(kind, other), touches);
      }
    }
  }
  EXPECT_GT(touching, 20u);
}

TEST(JudgePath, FindsAGrazeAtATimeThatIsNoBinaryFraction) {
  // The coplanarity polynomial is u², u = 3t - 1: at t = 1/3 the point is at (0, y, 0), where the
  // triangle's edge from the origin to (0, 1, 0) is.
  const auto grazes = [](double y) {
    return touch_both_ways(PathKind::point_triangle,
                           {Vec3(0, y, -1), Vec3(0, 0, 0), Vec3(-1, 0, 1), Vec3(0, 1, 0),
                            Vec3(0, y, 2), Vec3(0, 0, 0), Vec3(2, 0, 1), Vec3(0, 1, 0)});
  };
  EXPECT_TRUE(grazes(0.25));
  EXPECT_TRUE(grazes(1.0));
  EXPECT_FALSE(grazes(std::nextafter(1.0, 2.0)));
}

TEST(JudgePath, EnclosesTheTimeByEqualOrNeighbouringDoubles) {
  const double tiny = std::numeric_limits<double>::denorm_min();
  struct Case {
    double start, end, lo, hi;
  };
  for (const Case& c : std::vector<Case>{{0, -1, 0, 0},
                                         {1, 0, 1, 1},
                                         {1, -1, 0.5, 0.5},
                                         {1, -2, 1.0 / 3.0, std::nextafter(1.0 / 3.0, 1.0)},
                                         {1, -4, std::nextafter(0.2, 0.0), 0.2},
                                         {1, -0x1p-54, std::nextafter(1.0, 0.0), 1},
                                         {1, -0x1p-1000, std::nextafter(1.0, 0.0), 1},
                                         {tiny, -1, 0, tiny},
                                         {2 * tiny, -1, tiny, 2 * tiny},
                                         {0x1p-1000, -1e300, 0, tiny}}) {
    const auto time = falling_point_time(c.start, c.end);
    ASSERT_TRUE(time.has_value());
    EXPECT_EQ(time->lo, c.lo) << c.start << " to " << c.end;
    EXPECT_EQ(time->hi, c.hi) << c.start << " to " << c.end;
  }
  EXPECT_FALSE(falling_point_time(1, tiny).has_value());
  EXPECT_FALSE(falling_point_time(-tiny, -1).has_value());
}

// In the plane z = 0 the point (2 t, 1) is on the line through the origin and (x, y t) when
// x = 2 y t²: at t = 1/2 for (4, 8 t), at the square root of 1/2 for (8, 8 t).
TEST(JudgePath, EnclosesTimesOfMotionInAPlane) {
  const auto time = [](double x, double y) {
    return first_touch(
        PathKind::edge_edge,
        std::array<Vec3, 8>{Vec3(0, 1, 0), Vec3(0, 9, 0), Vec3(0, 0, 0), Vec3(x, 0, 0),
                            Vec3(2, 1, 0), Vec3(2, 9, 0), Vec3(0, 0, 0), Vec3(x, y, 0)});
  };
  const auto half = time(4, 8), root = time(8, 8);
  ASSERT_TRUE(half && root);
  EXPECT_EQ(half->lo, 0.5);
  EXPECT_EQ(half->hi, 0.5);
  EXPECT_EQ(root->hi, std::nextafter(root->lo, 1.0));
  EXPECT_LT(root->lo, std::sqrt(0.5) + 1e-15);
  EXPECT_GT(root->hi, std::sqrt(0.5) - 1e-15);
}

// All four vertices but one come together at t = 1; the cubic has a double root there and a simple
// one less than an ulp before, in contact.
TEST(JudgePath, TellsARootNextToADoubleOneAtTheEnd) {
  const std::array<Vec3, 8> points{Vec3(-7, -4, 26),
                                   Vec3(0x1.4000000000001p+4, -19, 20),
                                   Vec3(11, -4, 0x1.1800000000001p+5),
                                   Vec3(5, -28, 14),
                                   Vec3(-20, 12, 0x1.8000000000001p+2),
                                   Vec3(-20, 12, 6),
                                   Vec3(-20, 12, 6),
                                   Vec3(-20, 12, 6)};
  const auto time = first_touch(PathKind::edge_edge, points);
  ASSERT_TRUE(time.has_value());
  EXPECT_EQ(time->lo, std::nextafter(1.0, 0.0));
  EXPECT_EQ(time->hi, 1.0);
}

// Counts by every pair of primitives, without boxes and filters.
class EveryPair {
 public:
  EveryPair(const TriangleMesh& mesh, std::span<const Vec3> end) : mesh_(mesh), end_(end) {
    for (const Triangle& t : mesh.triangles)
      for (int k = 0; k < 3; ++k) {
        points_[{t[k]}] = true;
        edges_[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}] = true;
      }
  }

  std::size_t point_triangle(const EveryPair& other) const {
    std::size_t count = 0;
    for (const auto& [point, used] : points_)
      for (const Triangle& t : other.mesh_.triangles)
        count += touch(PathKind::point_triangle, point, other, t);
    return count;
  }
  std::size_t edge_edge(const EveryPair& other) const {
    std::size_t count = 0;
    for (const auto& [a, used_a] : edges_)
      for (const auto& [b, used_b] : other.edges_)
        if (this != &other || a < b) count += touch(PathKind::edge_edge, a, other, b);
    return count;
  }

 private:
  template <class A, class B>
  bool touch(PathKind kind, const A& a, const EveryPair& other, const B& b) const {
    std::vector<Vec3> start, end;
    for (const std::int32_t v : a) {
      if (this == &other && std::find(b.begin(), b.end(), v) != b.end()) return false;
      start.push_back(mesh_.vertices[v]);
      end.push_back(end_[v]);
    }
    for (const std::int32_t v : b) {
      start.push_back(other.mesh_.vertices[v]);
      end.push_back(other.end_[v]);
    }
    start.insert(start.end(), end.begin(), end.end());
    return paths_touch_unfiltered(kind, std::span<const Vec3, 8>(start.data(), 8));
  }

  const TriangleMesh& mesh_;
  std::span<const Vec3> end_;
  std::map<std::array<std::int32_t, 1>, bool> points_;
  std::map<Edge, bool> edges_;
};

TEST(JudgePath, CountsTheSameAsEveryPairOfPrimitives) {
  std::mt19937 random(17);
  const auto number = [&random] { return static_cast<int>(random() % 9) / 4.0; };
  for (int round = 0; round < 6; ++round) {
    TriangleMesh mesh = sheet(3, [](double, double) { return 1.0; });
    TriangleMesh body = cube(Vec3(0.2, 0.2, 0.0), Vec3(1.1, 1.1, 0.5));
    std::vector<Vec3> mesh_end = mesh.vertices, body_end = body.vertices;
    for (Vec3& x : mesh_end) x += 0.5 * Vec3(number() - 1.0, number() - 1.0, -number());
    for (Vec3& x : body_end) x += 0.25 * Vec3(number() - 1.0, number() - 1.0, number());
    const EveryPair a(mesh, mesh_end), b(body, body_end);
    const PathVerdict verdict = judge_path(mesh, mesh_end, body, body_end);
    EXPECT_EQ(verdict.self_collisions, a.point_triangle(a) + a.edge_edge(a)) << round;
    EXPECT_EQ(verdict.body_collisions, a.point_triangle(b) + b.point_triangle(a) + a.edge_edge(b))
        << round;
    EXPECT_GT(verdict.self_collisions, 0u);
    EXPECT_GT(verdict.body_collisions, 0u);
  }
}

TEST(JudgePath, CountsOnlyASheetThatFallsThroughAPlate) {
  const TriangleMesh plate = cube(Vec3(0.2, 0.2, -0.005), Vec3(0.7, 0.7, 0.0));
  const TriangleMesh cloth = sheet(8, [](double, double) { return 0.5; });
  const auto moved = [&cloth](double step) {
    std::vector<Vec3> x = cloth.vertices;
    for (Vec3& v : x) v[2] += step;
    return x;
  };
  const PathVerdict through = judge_path(cloth, moved(-1.0), plate, plate.vertices);
  EXPECT_GT(through.body_collisions, 0u);
  EXPECT_EQ(through.self_collisions, 0u);
  EXPECT_GT(judge_path(cloth, moved(-0.5), plate, plate.vertices).body_collisions, 0u);
  const PathVerdict above = judge_path(cloth, moved(-0.499), plate, plate.vertices);
  EXPECT_EQ(above.body_collisions, 0u);
  EXPECT_GT(above.pairs, 0u);
  EXPECT_EQ(judge_path(cloth, moved(-1.0), {}, {}).body_collisions, 0u);
}

TEST(JudgePath, CountsTheCollisionsOfTwoLayersThatSwap) {
  TriangleMesh mesh;
  append(mesh, {{Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)}, {{0, 1, 2}}});
  append(mesh, {{Vec3(0.5, 0.5, 1), Vec3(1, 0.5, 1), Vec3(0.5, 1, 1)}, {{0, 1, 2}}});
  std::vector<Vec3> end = mesh.vertices;
  for (int i = 3; i < 6; ++i) end[i][2] = -1;
  // Three points of the small one meet the large one; no edges cross.
  EXPECT_EQ(judge_path(mesh, end, {}, {}).self_collisions, 3u);
}

TEST(JudgePath, RefusesStatesOfDifferentSize) {
  const TriangleMesh mesh{{unit[0], unit[1], unit[2]}, {{0, 1, 2}}};
  EXPECT_THROW(judge_path(mesh, std::vector<Vec3>(2, Vec3::Zero()), {}, {}), std::invalid_argument);
  EXPECT_THROW(judge_path(mesh, mesh.vertices, mesh, {}), std::invalid_argument);
  EXPECT_THROW(judge_path(mesh, std::vector<Vec3>(3, Vec3(0, INFINITY, 0)), {}, {}),
               std::invalid_argument);
}

// ---- The query collection with ground truth

std::filesystem::path shared_directory() {
  const char* given = std::getenv("SELVEDGE_SHARED");
  return given != nullptr ? std::filesystem::path(given)
                          : std::filesystem::path(SELVEDGE_SOURCE_DIR) / ".." / "shared";
}

struct Query {
  std::array<Vec3, 8> points;
  bool truth;
  std::optional<TouchTime> time{};
};

// Beside X.csv lies X.toi.csv: index,truth,toi_lo,toi_hi, the times empty without a contact.
void read_times(std::filesystem::path file, std::vector<Query>& queries) {
  std::ifstream in(file.replace_extension(".toi.csv"));
  for (std::string line; std::getline(in, line);) {
    std::stringstream fields(line);
    std::array<std::string, 4> field;
    for (std::string& f : field) std::getline(fields, f, ',');
    if (field[2].empty() || field[0] == "index") continue;
    queries.at(std::stoul(field[0])).time = {std::stod(field[2]), std::stod(field[3])};
  }
}

// x_num,x_den,y_num,y_den,z_num,z_den,truth; both parts are doubles, denominators powers of two.
std::vector<Query> read_queries(const std::filesystem::path& file) {
  std::vector<Query> queries;
  std::ifstream in(file);
  std::size_t row = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    if (row % 8 == 0) queries.emplace_back();
    std::array<double, 7> value{};
    std::stringstream fields(line);
    std::string field;
    for (double& v : value)
      if (std::getline(fields, field, ',')) v = std::strtod(field.c_str(), nullptr);
    queries.back().points[row++ % 8] =
        Vec3(value[0] / value[1], value[2] / value[3], value[4] / value[5]);
    queries.back().truth = value[6] != 0.0;
  }
  read_times(file, queries);
  return queries;
}

TEST(JudgePath, DecidesEveryQueryOfTheCollectionAndEnclosesItsTime) {
  const std::filesystem::path directory = shared_directory() / "data" / "ccd";
  if (!std::filesystem::is_directory(directory))
    GTEST_SKIP() << "the query collection is not at " << directory << "; set SELVEDGE_SHARED";
  std::size_t queries = 0, positives = 0, wrong = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(directory)) {
    const std::filesystem::path& file = entry.path();
    if (file.extension() != ".csv" || file.stem().extension() == ".toi") continue;
    const PathKind kind = file.string().find("edge-edge") != std::string::npos
                              ? PathKind::edge_edge
                              : PathKind::point_triangle;
    for (const Query& query : read_queries(file)) {
      ++queries;
      positives += query.truth;
      const bool right = paths_touch(kind, query.points) == query.truth &&
                         paths_touch_unfiltered(kind, query.points) == query.truth;
      const auto time = first_touch(kind, query.points);
      const bool same_time = time.has_value() == query.time.has_value() &&
                             (!time || (time->lo == query.time->lo && time->hi == query.time->hi));
      wrong += !right || !same_time;
      EXPECT_TRUE(right && same_time) << file << ", query " << queries;
    }
  }
  EXPECT_EQ(queries, 9702u);
  EXPECT_EQ(positives, 1652u);
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace selvedge::judge_path_test
