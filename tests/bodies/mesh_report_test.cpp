// SPDX-License-Identifier: MIT
#include <selvedge/bodies/body.h>
#include <selvedge/bodies/detail/triangle_crossing.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/bodies/mesh_report.h>
#include <selvedge/core/base/internal/orientation.h>
#include <selvedge/core/base/parallel.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <random>
#include <string>

namespace selvedge::mesh_report_test {
namespace {

namespace fs = std::filesystem;

TriangleMesh tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
}

TEST(MeshReport, ACleanMeshHasNoSentence) {
  const MeshReport report = report_mesh(tetrahedron());
  EXPECT_TRUE(report.closed());
  EXPECT_TRUE(report.sentences().empty());
  EXPECT_EQ(report.components, 1u);
  EXPECT_NEAR(report.volume, 1.0 / 6.0, 1e-15);
}

TEST(MeshReport, TheBoundsEncloseAllVertices) {
  TriangleMesh mesh = tetrahedron();
  for (Vec3& x : mesh.vertices) x -= Vec3(0.25, 0.5, 2.0);
  const MeshReport report = report_mesh(mesh);
  EXPECT_EQ(report.lower, Vec3(-0.25, -0.5, -2.0));
  EXPECT_EQ(report.upper, Vec3(0.75, 0.5, -1.0));
}

TEST(MeshReport, EveryFaultIsCounted) {
  TriangleMesh mesh = tetrahedron();
  mesh.triangles.pop_back();
  EXPECT_EQ(report_mesh(mesh).boundary_edges, 3u);
  mesh = tetrahedron();
  std::swap(mesh.triangles[2][0], mesh.triangles[2][1]);
  EXPECT_EQ(report_mesh(mesh).inconsistent_edges, 3u);
  mesh = tetrahedron();
  mesh.triangles.push_back({1, 0, 2});
  EXPECT_EQ(report_mesh(mesh).duplicate_faces, 1u);
  EXPECT_EQ(report_mesh(mesh).non_manifold_edges, 3u);
  mesh = tetrahedron();
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_EQ(report_mesh(mesh).inward_components, 1u);
  mesh = tetrahedron();
  mesh.vertices.push_back({1, 0, 0});
  mesh.triangles.push_back({0, 0, 1});
  EXPECT_EQ(report_mesh(mesh).duplicate_vertices, 1u);
  EXPECT_EQ(report_mesh(mesh).unused_vertices, 1u);
  EXPECT_EQ(report_mesh(mesh).zero_area_faces, 1u);
  EXPECT_EQ(report_mesh(mesh).components, 1u);
  EXPECT_EQ(report_mesh(mesh).sentences().size(), 3u);
  EXPECT_THROW(report_mesh({{{0, 0, 0}}, {{0, 0, 7}}}), std::invalid_argument);
  EXPECT_THROW(report_mesh({{{NAN, 0, 0}}, {}}), std::invalid_argument);
}

TriangleMesh two_triangles(const std::array<Vec3, 6>& x) {
  return {{x.begin(), x.end()}, {{0, 1, 2}, {3, 4, 5}}};
}

std::size_t crossings(const std::array<Vec3, 6>& x) {
  return report_mesh(two_triangles(x)).self_intersections;
}

TEST(MeshReport, PairsOfTrianglesAreJudgedExactly) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  const double e = std::numeric_limits<double>::epsilon();
  // Through the middle, beside it, touching with a tip, and missing by the last bit.
  EXPECT_EQ(crossings({a, b, c, {0.2, 0.2, -1}, {0.2, 0.2, 1}, {0.3, 0.3, 1}}), 1u);
  EXPECT_EQ(crossings({a, b, c, {0.8, 0.8, -1}, {0.8, 0.8, 1}, {0.9, 0.9, 1}}), 0u);
  EXPECT_EQ(crossings({a, b, c, {0.25, 0.25, 0}, {0.2, 0.2, 1}, {0.3, 0.3, 1}}), 1u);
  EXPECT_EQ(crossings({a, b, c, {0.25, 0.25, 5e-324}, {0.2, 0.2, 1}, {0.3, 0.3, 1}}), 0u);
  EXPECT_EQ(crossings({a, b, c, {0.5, 0.5, 0}, {1, 1, 1}, {1, 1, 0}}), 1u);
  EXPECT_EQ(crossings({a, b, c, {0.5 + e, 0.5, 0}, {1, 1, 1}, {1, 1, 0}}), 0u);
  // In one plane: overlapping, one inside the other, apart.
  EXPECT_EQ(crossings({a, b, c, {0.4, 0.4, 0}, {1.4, 0.4, 0}, {0.4, 1.4, 0}}), 1u);
  EXPECT_EQ(crossings({a, b, c, {0.1, 0.1, 0}, {0.2, 0.1, 0}, {0.1, 0.2, 0}}), 1u);
  EXPECT_EQ(crossings({a, b, c, {0.6, 0.6, 0}, {1.6, 0.6, 0}, {0.6, 1.6, 0}}), 0u);
  // Without area: judged by its edge; sharing a position: a neighbour.
  EXPECT_EQ(crossings({a, b, c, {0.2, 0.2, -1}, {0.2, 0.2, 0.5}, {0.2, 0.2, 1}}), 1u);
  EXPECT_EQ(crossings({a, b, c, a, {0.2, 0.2, 1}, {0.3, 0.3, 1}}), 0u);
}

__extension__ using Int128 = __int128;

int sign_of(Int128 value) { return (value > 0) - (value < 0); }

// Integer points in one plane, or off it by 1, so far out that double arithmetic cannot tell: the
// terms of the determinant reach 2^92 and differ by 2^37. 128-bit integers can.
TEST(ExactOrientation, SignsAreRightWhereDoublesCannotTell) {
  std::mt19937_64 random(3);
  const auto below = [&](int bits) {
    return static_cast<std::int64_t>(random() >> (63 - bits)) - (std::int64_t{1} << bits);
  };
  int zeros = 0;
  for (int round = 0; round < 3000; ++round) {
    std::array<std::int64_t, 3> u, v, w, d;
    const std::int64_t i = below(18), j = below(18);
    for (int k = 0; k < 3; ++k) {
      u[k] = below(18), v[k] = below(18), d[k] = below(30);
      w[k] = i * u[k] + j * v[k];
    }
    w[round % 3] += round % 5 - 2;
    const auto minor = [&](int a, int b) { return Int128(v[a]) * w[b] - Int128(v[b]) * w[a]; };
    const int expected = sign_of(u[0] * minor(1, 2) + u[1] * minor(2, 0) + u[2] * minor(0, 1));
    Vec3 p[4];
    for (int k = 0; k < 3; ++k) {
      p[0][k] = static_cast<double>(u[k] + d[k]);
      p[1][k] = static_cast<double>(v[k] + d[k]);
      p[2][k] = static_cast<double>(w[k] + d[k]);
      p[3][k] = static_cast<double>(d[k]);
    }
    ASSERT_EQ(orientation(p[0], p[1], p[2], p[3]), expected) << "round " << round;
    ASSERT_EQ(orientation(p[1], p[0], p[2], p[3]), -expected) << "round " << round;
    zeros += expected == 0;
    // In the plane: (n, n+1) × (nm + s, (n+1)m + s) = -s, a difference of terms near 2^76.
    const std::int64_t n = below(25), m = below(25), s = round % 3 - 1;
    const Vec3 q[2] = {{0.0, static_cast<double>(n), static_cast<double>(n + 1)},
                       {0.0, static_cast<double>(n * m + s), static_cast<double>((n + 1) * m + s)}};
    ASSERT_EQ(orientation(q[0], q[1], Vec3::Zero(), 0), -s) << "round " << round;
  }
  EXPECT_GT(zeros, 300);
}

// Coordinates on a coarse lattice make every degenerate case common; the judgement must not change
// when the corners are permuted or the axes are turned.
TEST(MeshReport, DegeneratePairsAreJudgedTheSameInEveryOrder) {
  std::mt19937 random(11);
  std::size_t met = 0;
  for (int round = 0; round < 4000; ++round) {
    std::array<Vec3, 6> x;
    for (Vec3& p : x)
      p = Vec3(static_cast<int>(random() % 4), static_cast<int>(random() % 4),
               static_cast<int>(random() % 4));
    const std::size_t expected = crossings(x);
    met += expected;
    ASSERT_EQ(expected, crossings({x[4], x[3], x[5], x[1], x[2], x[0]})) << "round " << round;
    for (Vec3& p : x) p = Vec3(p.y(), p.z(), p.x()) * 0.25 + Vec3(0.5, 0.25, 0.125);
    ASSERT_EQ(expected, crossings(x)) << "round " << round;
  }
  EXPECT_GT(met, 400u);
}

// The second corner of the one lies on a side of the other, or beyond it: a plane that had both on
// different sides would be rounding error.
TEST(MeshReport, TrianglesThatTouchBeyondTheirCommonCornerAreNeverCalledApart) {
  std::mt19937 random(15);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::uniform_int_distribution<int> exponent(-20, 20);
  const auto vector = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  for (int round = 0; round < 20000; ++round) {
    const Vec3 scale(std::exp2(exponent(random)), 1.0, std::exp2(exponent(random)));
    const Vec3 shared = scale.cwiseProduct(vector());
    const detail::Corners a{Vec3::Zero(), shared, scale.cwiseProduct(vector())};
    const detail::Corners b{Vec3::Zero(), std::exp2(exponent(random)) * shared,
                            scale.cwiseProduct(vector())};
    ASSERT_TRUE(detail::wedges_meet(a, b)) << "round " << round;
    ASSERT_TRUE(detail::wedges_meet(b, a)) << "round " << round;
  }
}

TEST(MeshReport, TwoLinkedTubesThatPassThroughEachOtherAreFound) {
  TriangleMesh mesh = tessellate(Torus{0.3, 0.05}, 32);
  EXPECT_EQ(report_mesh(mesh).self_intersections, 0u);
  TriangleMesh second = mesh;
  const auto n = static_cast<std::int32_t>(mesh.vertices.size());
  for (const Vec3& x : second.vertices)
    mesh.vertices.push_back(Vec3(x.x(), x.z(), x.y()) + Vec3(0.3, 0, 0));
  for (const Triangle& t : second.triangles)
    mesh.triangles.push_back({t[0] + n, t[2] + n, t[1] + n});
  EXPECT_EQ(report_mesh(mesh).self_intersections, 0u);  // linked, not touching
  EXPECT_EQ(report_mesh(mesh).components, 2u);
  for (std::size_t i = n; i < mesh.vertices.size(); ++i) mesh.vertices[i].x() += 0.3;
  const std::size_t found = report_mesh(mesh).self_intersections;
  EXPECT_GT(found, 20u);
  const ThreadLimit one(1);
  EXPECT_EQ(report_mesh(mesh).self_intersections, found);
}

fs::path fetched(const std::string& name) {
  return fs::path(SELVEDGE_SOURCE_DIR) / "data" / "fetched" / name;
}

TEST(MeshReport, DebiansHomerIsClean) {
  if (!fs::exists(fetched("homer.off"))) GTEST_SKIP() << "run scripts/fetch_bodies.sh first";
  const MeshReport report = report_mesh(read_mesh(fetched("homer.off")));
  EXPECT_EQ(report.triangles, 9856u);
  EXPECT_TRUE(report.sentences().empty());
}

TEST(MeshReport, DebiansManCrossesItself) {
  if (!fs::exists(fetched("man.off"))) GTEST_SKIP() << "run scripts/fetch_bodies.sh first";
  const MeshReport report = report_mesh(read_mesh(fetched("man.off")));
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.self_intersections, 788u);
  EXPECT_EQ(report.folded_neighbours, 60u);  // together CGAL's count of 848
}

}  // namespace
}  // namespace selvedge::mesh_report_test
