// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/internal/repair_garment.h>

#include <algorithm>
#include <cmath>
#include <map>
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

}  // namespace
}  // namespace selvedge::repair_garment_test
