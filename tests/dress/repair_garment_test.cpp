// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/bodies/body.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/internal/repair_garment.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

namespace selvedge::repair_garment_test {
namespace {

TriangleMesh mannequin() {
  return read_mesh(std::string(SELVEDGE_SOURCE_DIR) + "/data/bodies/mannequin_arms_out.ply");
}

/// The skin of a body between two heights, `gap` m outside of it: a shirt that fits tightly.
TriangleMesh shirt(const TriangleMesh& body, double low, double high, double gap) {
  const std::vector<Vec3> normals = vertex_normals(body.vertices, body.triangles);
  TriangleMesh mesh;
  std::map<std::int32_t, std::int32_t> number;
  for (const Triangle& t : body.triangles) {
    const auto is_within = [&](std::int32_t v) {
      return body.vertices[v].z() > low && body.vertices[v].z() < high &&
             std::abs(body.vertices[v].x()) < 0.4;
    };
    if (!std::all_of(t.begin(), t.end(), is_within)) continue;
    Triangle made{};
    for (int k = 0; k < 3; ++k) {
      const auto [place, is_new] =
          number.try_emplace(t[k], static_cast<std::int32_t>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back(body.vertices[t[k]] + gap * normals[t[k]]);
      made[k] = place->second;
    }
    mesh.triangles.push_back(made);
  }
  return mesh;
}

/// One vertex of a hundred is up to 10 mm inside the body.
std::size_t push_in(TriangleMesh& mesh, double gap, std::mt19937& random) {
  const std::vector<Vec3> normals = vertex_normals(mesh.vertices, mesh.triangles);
  std::uniform_real_distribution<double> depth(0.001, 0.01);
  const std::size_t count = mesh.vertices.size() / 100;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t v = random() % mesh.vertices.size();
    mesh.vertices[v] -= (gap + depth(random)) * normals[v];
  }
  return count;
}

TEST(RepairGarment, AHundredShirtsAreCleanAndTheRestKeepsItsBits) {
  const TriangleMesh body = mannequin();
  std::mt19937 random(12);
  int clean = 0;
  for (int seed = 0; seed < 100; ++seed) {
    const double gap = std::uniform_real_distribution<double>(0.0015, 0.004)(random);
    const TriangleMesh whole = shirt(body, 0.85, 1.5, gap);
    ASSERT_GT(whole.vertices.size(), 500u);
    TriangleMesh pushed = whole;
    push_in(pushed, gap, random);
    const RepairResult r = repair_garment(pushed, body);
    EXPECT_GT(r.body_before, 0);
    EXPECT_LT(r.median_motion, 5e-4) << seed;
    EXPECT_EQ(r.clean(),
              find_meetings({r.x, pushed.triangles}, {body.vertices, body.triangles}).empty() &&
                  find_meetings(r.x, pushed.triangles).empty())
        << seed;
    EXPECT_EQ(r.clean(), r.left.empty()) << seed;
    clean += static_cast<int>(r.clean());
  }
  EXPECT_GE(clean, 98);
}

TEST(RepairGarment, ACleanGarmentKeepsItsBits) {
  const TriangleMesh body = mannequin(), whole = shirt(body, 0.9, 1.4, 0.002);
  const RepairResult r = repair_garment(whole, body);
  EXPECT_EQ(r.body_before, 0);
  EXPECT_EQ(r.moved, 0);
  EXPECT_EQ(r.x, whole.vertices);
}

TEST(RepairGarment, VerticesAtOnePositionStayTogether) {
  const TriangleMesh body = mannequin();
  std::mt19937 random(5);
  TriangleMesh mesh = shirt(body, 0.85, 1.5, 0.002), apart;
  push_in(mesh, 0.002, random);
  // Every triangle has vertices of its own, as in a file of separate panels.
  for (const Triangle& t : mesh.triangles) {
    const auto first = static_cast<std::int32_t>(apart.vertices.size());
    for (const std::int32_t v : t) apart.vertices.push_back(mesh.vertices[v]);
    apart.triangles.push_back({first, first + 1, first + 2});
  }
  const RepairResult joined = repair_garment(mesh, body), separate = repair_garment(apart, body);
  EXPECT_EQ(joined.body_after, separate.body_after);
  std::map<std::array<double, 3>, Vec3> place;
  for (std::size_t v = 0; v < apart.vertices.size(); ++v) {
    const Vec3& x = apart.vertices[v];
    const auto [found, is_new] = place.try_emplace({x.x(), x.y(), x.z()}, separate.x[v]);
    EXPECT_EQ(found->second, separate.x[v]);
  }
}

TEST(RepairGarment, WhatCannotBeRepairedIsNamed) {
  const TriangleMesh body = mannequin();
  TriangleMesh sheet;  // through the middle of the body, from side to side
  for (int i = 0; i <= 20; ++i)
    for (int k = 0; k <= 20; ++k)
      sheet.vertices.emplace_back(-0.5 + 0.05 * i, -0.5 + 0.05 * k, 1.2);
  for (int i = 0; i < 20; ++i)
    for (int k = 0; k < 20; ++k) {
      const int a = 21 * i + k;
      sheet.triangles.push_back({a, a + 21, a + 22});
      sheet.triangles.push_back({a, a + 22, a + 1});
    }
  const RepairResult r = repair_garment(sheet, body, {.rounds = 2});
  EXPECT_EQ(r.clean(), r.left.empty());
  EXPECT_THROW(repair_garment({}, body), std::invalid_argument);
  EXPECT_THROW(repair_garment(sheet, body, {.clearance = 0.0}), std::invalid_argument);
}

// ---- a shirt of two layers with folds

constexpr int kAround = 64, kRows = 40;
constexpr double kHeight = 0.6;  // m

/// A torso: an oval tube with lids, of `width` at angle a.
double torso_radius(double a, double grown) { return 0.15 + 0.02 * std::cos(2.0 * a) + grown; }

Vec3 on_tube(double radius, double a, double z) {
  return {radius * std::cos(a), radius * std::sin(a), z};
}

void add_rows(TriangleMesh& mesh, std::int32_t first, int rows) {
  for (int i = 0; i + 1 < rows; ++i)
    for (int k = 0; k < kAround; ++k) {
      const std::int32_t a = first + i * kAround + k, b = first + i * kAround + (k + 1) % kAround;
      mesh.triangles.push_back({a, b, b + kAround});
      mesh.triangles.push_back({a, b + kAround, a + kAround});
    }
}

TriangleMesh torso(double grown = 0.0) {
  TriangleMesh mesh;
  for (int i = 0; i < kRows; ++i)
    for (int k = 0; k < kAround; ++k) {
      const double a = 2.0 * std::numbers::pi * (k + 0.5) / kAround;
      mesh.vertices.push_back(
          on_tube(torso_radius(a, grown), a, -0.1 + (kHeight + 0.2) * i / (kRows - 1)));
    }
  add_rows(mesh, 0, kRows);
  mesh.vertices.emplace_back(0.0, 0.0, -0.1);
  mesh.vertices.emplace_back(0.0, 0.0, kHeight + 0.1);
  const auto low = static_cast<std::int32_t>(mesh.vertices.size()) - 2;
  for (std::int32_t k = 0; k < kAround; ++k) {
    const std::int32_t next = (k + 1) % kAround, top = (kRows - 1) * kAround;
    mesh.triangles.push_back({low, next, k});
    mesh.triangles.push_back({low + 1, top + k, top + next});
  }
  return mesh;
}

/// A shirt around it with folds, of which some lie on the skin, and a second layer at its hem.
TriangleMesh shirt(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double folds = std::floor(3.0 + 6.0 * unit(random)), depth = 0.005 + 0.02 * unit(random),
               turn = 6.0 * unit(random), lean = 8.0 * unit(random);
  TriangleMesh mesh;
  const auto add = [&](double gap, int rows) {
    const auto first = static_cast<std::int32_t>(mesh.vertices.size());
    for (int i = 0; i < rows; ++i)
      for (int k = 0; k < kAround; ++k) {
        const double a = 2.0 * std::numbers::pi * k / kAround, z = kHeight * i / (kRows - 1);
        const double fold = depth * (1.0 + std::cos(folds * a + turn + lean * z));
        mesh.vertices.push_back(on_tube(torso_radius(a, 0.0) + gap + fold, a, z));
      }
    add_rows(mesh, first, rows);
  };
  add(0.003, kRows);
  add(0.006, kRows / 4);
  return mesh;
}

bool is_free(const TriangleMesh& garment, const std::vector<Vec3>& x, const TriangleMesh& body,
             double grown = 0.0) {
  for (const Vec3& p : x)
    if (std::hypot(p.x(), p.y()) < torso_radius(std::atan2(p.y(), p.x()), grown) - 0.001)
      return false;
  return find_meetings(x, garment.triangles).empty() &&
         find_meetings({x, garment.triangles}, {body.vertices, body.triangles}).empty();
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

TEST(RepairGarment, VerticesPushedThroughALayerComeOut) {
  const TriangleMesh body = torso();
  for (unsigned seed = 1; seed <= 12; ++seed) {
    std::mt19937 random(seed);
    const TriangleMesh whole = shirt(random);
    ASSERT_TRUE(is_free(whole, whole.vertices, body)) << seed;
    TriangleMesh damaged = whole;
    std::vector<char> is_pushed(whole.vertices.size(), 0);
    std::uniform_int_distribution<std::size_t> any(0, whole.vertices.size() - 1);
    std::uniform_real_distribution<double> depth(0.001, 0.010);
    for (std::size_t k = 0; k < whole.vertices.size() / 100; ++k) {
      const std::size_t v = any(random);
      const Vec3& p = whole.vertices[v];
      const double a = std::atan2(p.y(), p.x());
      damaged.vertices[v] = on_tube(torso_radius(a, 0.0) - depth(random), a, p.z());
      is_pushed[v] = 1;
    }
    const RepairResult result = repair_garment(damaged, body);
    EXPECT_GT(result.body_before, 0) << seed;
    EXPECT_GT(result.inside, 0) << seed;
    EXPECT_TRUE(result.clean()) << seed;
    EXPECT_TRUE(is_free(damaged, result.x, body)) << seed;
    std::vector<double> motion;
    for (std::size_t v = 0; v < is_pushed.size(); ++v)
      if (!is_pushed[v]) motion.push_back((result.x[v] - whole.vertices[v]).norm());
    EXPECT_LT(median(motion), 0.0005) << seed;
    EXPECT_LT(*std::max_element(motion.begin(), motion.end()), 0.02) << seed;
  }
}

TEST(RepairGarment, GoesWithABodyThatGrowsAndKeepsItsFolds) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    std::mt19937 random(seed);
    const TriangleMesh garment = shirt(random);
    const double grown = std::uniform_real_distribution<double>(0.004, 0.010)(random);
    const TriangleMesh body = torso(grown);
    const RepairResult result = repair_garment(garment, body);
    EXPECT_GT(result.inside, 0) << seed;
    EXPECT_TRUE(result.clean()) << seed;
    EXPECT_TRUE(is_free(garment, result.x, body, grown)) << seed;
    EXPECT_LT(result.largest_motion, grown + 0.002) << seed;
  }
}

TEST(RepairGarment, TakesOutCrossingsOfItsLayersAwayFromTheBody) {
  const TriangleMesh body = torso();
  for (unsigned seed = 1; seed <= 12; ++seed) {
    std::mt19937 random(seed);
    TriangleMesh garment = shirt(random);
    std::uniform_int_distribution<std::size_t> any(0, kAround * kRows / 4 - 1);
    std::uniform_real_distribution<double> depth(0.004, 0.015);
    for (int k = 0; k < 12; ++k) {  // of the inner layer, through the outer one
      Vec3& p = garment.vertices[any(random)];
      p += depth(random) * Vec3(p.x(), p.y(), 0.0).normalized();
    }
    const RepairResult result = repair_garment(garment, body);
    EXPECT_EQ(result.inside, 0) << seed;
    EXPECT_GT(result.self_before, 0) << seed;
    EXPECT_TRUE(result.clean()) << seed;
    EXPECT_TRUE(is_free(garment, result.x, body)) << seed;
    EXPECT_LT(result.median_motion, 5e-4) << seed;
  }
}

// ---- garments that lie half in a body

double mean_edge(const TriangleMesh& mesh) {
  double sum = 0.0;
  const std::vector<Edge> edges = unique_edges(mesh.triangles);
  for (const auto& [a, b] : edges) sum += (mesh.vertices[a] - mesh.vertices[b]).norm();
  return sum / static_cast<double>(edges.size());
}

/// A grid of rows and columns, closed in a ring or not, at places of (row, column) in [0, 1].
template <class Place>
TriangleMesh grid(int rows, int columns, bool is_ring, const Place& place) {
  TriangleMesh mesh;
  const int wide = is_ring ? columns : columns + 1;
  for (int i = 0; i <= rows; ++i)
    for (int k = 0; k < wide; ++k)
      mesh.vertices.push_back(place(i / double(rows), k / double(columns)));
  for (int i = 0; i < rows; ++i)
    for (int k = 0; k < columns; ++k) {
      const int a = i * wide + k, b = i * wide + (k + 1) % wide;
      mesh.triangles.push_back({a, b, b + wide});
      mesh.triangles.push_back({a, b + wide, a + wide});
    }
  return mesh;
}

/// A tube, a shirt that is wide at its hem, or a sheet.
TriangleMesh thrown_garment(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const int kind = static_cast<int>(random() % 3), rows = 4 + static_cast<int>(random() % 3);
  const double radius = 0.08 + 0.06 * unit(random), wide = kind == 0 ? 0.0 : unit(random);
  const double size = 0.2 + 0.2 * unit(random);
  if (kind == 2)
    return grid(rows, rows + 2, false,
                [&](double i, double k) { return Vec3(size * (i - 0.5), size * (k - 0.5), 0.0); });
  return grid(rows, 12, true, [&](double i, double k) {
    return on_tube(radius * (1.0 + wide * (1.0 - i)), 2.0 * std::numbers::pi * k, size * (i - 0.5));
  });
}

AnalyticShape thrown_over(std::mt19937& random) {
  std::uniform_real_distribution<double> size(0.06, 0.12);
  const double a = size(random), b = size(random), c = size(random);
  switch (random() % 3) {
    case 0:
      return Cylinder{.radius = a, .height = 4.0 * b};
    case 1:
      return Box{.size = 2.0 * Vec3(a, b, c)};
    default:
      return Sphere{.radius = a};
  }
}

TEST(RepairGarment, NoVertexIsThrownAndTheStretchIsSaid) {
  constexpr double kFar = 5.0;  // mean edges
  int clean = 0, moved = 0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    TriangleMesh garment = thrown_garment(random);
    const AnalyticShape shape = thrown_over(random);
    const Vec3 axis = Vec3(unit(random), unit(random), unit(random)).normalized();
    const Eigen::AngleAxisd turn(unit(random) * (random() % 2 ? 0.4 : std::numbers::pi), axis);
    const Vec3 shift = 0.15 * Vec3(unit(random), unit(random), unit(random));
    double deepest = 0.0;
    for (Vec3& p : garment.vertices) {
      p = turn * p + shift;
      deepest = std::max(deepest, -signed_distance(shape, p));
    }
    const TriangleMesh body = tessellate(shape, 10);
    const RepairResult r = repair_garment(garment, body);
    clean += r.clean() ? 1 : 0;
    moved += r.moved > 0 ? 1 : 0;
    EXPECT_LT(r.largest_motion, deepest + kFar * mean_edge(garment)) << seed;
    double stretch = 0.0;
    for (const auto& [a, b] : unique_edges(garment.triangles))
      stretch = std::max(
          stretch,
          (r.x[a] - r.x[b]).norm() / (garment.vertices[a] - garment.vertices[b]).norm() - 1.0);
    EXPECT_NEAR(r.max_stretch, stretch, 1e-9) << seed;
    EXPECT_EQ(r.good(), r.clean() && stretch <= 0.3) << seed;
    EXPECT_EQ(r.stretched.empty() ? 0.0 : r.stretched[0].stretch,
              stretch > 0.3 ? r.max_stretch : 0.0)
        << seed;
  }
  EXPECT_GE(moved, 50);
  EXPECT_GE(clean, 95);
}

}  // namespace
}  // namespace selvedge::repair_garment_test
