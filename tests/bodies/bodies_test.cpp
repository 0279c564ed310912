// SPDX-License-Identifier: MIT
#include <selvedge/bodies/body.h>
#include <selvedge/bodies/internal/sequence_leap.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/bodies/mesh_report.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/data/makers/mannequin.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace selvedge::bodies_test {
namespace {

namespace fs = std::filesystem;
using std::numbers::pi;

// The sentence that `read` throws; empty if it throws none.
template <class Read>
std::string fault(Read&& read) {
  try {
    read();
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

#define EXPECT_SAYS(sentence, part) \
  EXPECT_NE((sentence).find(part), std::string::npos) << "the sentence is: " << (sentence)

bool same_bits(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0;
}

TriangleMesh tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
}

// ---------------------------------------------------------------- analytic shapes

struct NamedShape {
  const char* name;
  AnalyticShape shape;
  double volume;
};

std::vector<NamedShape> closed_shapes() {
  return {{"box", Box{{1.0, 2.0, 0.5}}, 1.0},
          {"sphere", Sphere{0.7}, 4.0 / 3.0 * pi * 0.343},
          {"capsule", Capsule{0.3, 1.1}, pi * 0.09 * 1.1 + 4.0 / 3.0 * pi * 0.027},
          {"cylinder", Cylinder{0.4, 1.5}, pi * 0.16 * 1.5},
          {"flat cylinder", Cylinder{0.6, 0.02}, pi * 0.36 * 0.02},
          {"cone", Cone{0.5, 1.2}, pi * 0.25 * 1.2 / 3.0},
          {"torus", Torus{0.3, 0.08}, 2.0 * pi * pi * 0.3 * 0.0064}};
}

TEST(AnalyticBody, TessellationsAreClosedOutwardAndClean) {
  for (const NamedShape& s : closed_shapes())
    for (const int resolution : {3, 4, 5, 7, 8, 16, 33, 64}) {
      const MeshReport report = report_mesh(tessellate(s.shape, resolution));
      EXPECT_TRUE(report.sentences().empty())
          << s.name << " at " << resolution << ": " << report.sentences()[0];
      EXPECT_EQ(report.components, 1u) << s.name;
    }
}

// Radius over height (or tube over radius) from a thread to a disc. The rings of a thin cone once
// shrank without end, and the side of a long cylinder had as many rows as fit into the memory.
TEST(AnalyticBody, ExtremeRatiosGiveABoundedClosedMesh) {
  constexpr std::size_t most_faces = 4'200'000;  // of the side, with caps and tip
  for (const double ratio : {1e-12, 1e-3, 0.01, 0.1, 0.15, 0.17, 1e3, 1e12})
    for (const AnalyticShape& shape :
         {AnalyticShape{Cone{0.3 * ratio, 0.3}}, AnalyticShape{Cylinder{0.3 * ratio, 0.3}},
          AnalyticShape{Capsule{0.3 * ratio, 0.3}},
          AnalyticShape{Torus{0.3, 0.3 * std::min(ratio, 0.99)}}})
      for (const int resolution : {3, 48}) {
        const TriangleMesh mesh = tessellate(shape, resolution);
        const auto faces = mesh.triangles.size();
        EXPECT_LE(faces, most_faces) << shape.index() << ", ratio " << ratio;
        const std::size_t holes = std::holds_alternative<Torus>(shape) ? 1 : 0;
        EXPECT_EQ(faces + 4, 2 * mesh.vertices.size() + 4 * holes)  // Euler, of a closed surface
            << shape.index() << ", ratio " << ratio;
      }
}

TEST(AnalyticBody, AThinConeEndsInASmallestRing) {
  for (const double ratio : {0.01, 1.0 / 30.0, 0.1, 0.14})
    for (const int resolution : {3, 8, 24, 64}) {
      const MeshReport report = report_mesh(tessellate(Cone{0.3 * ratio, 0.3}, resolution));
      EXPECT_TRUE(report.sentences().empty())
          << ratio << " at " << resolution << ": " << report.sentences()[0];
    }
}

TEST(AnalyticBody, VerticesLieOnTheShapeAndFacesWithinTheStatedDistance) {
  for (const NamedShape& s : closed_shapes())
    for (const int resolution : {3, 8, 24, 48}) {
      const TriangleMesh mesh = tessellate(s.shape, resolution);
      for (const Vec3& x : mesh.vertices)
        ASSERT_NEAR(signed_distance(s.shape, x), 0.0, 1e-15) << s.name;
      if (std::holds_alternative<Torus>(s.shape)) continue;  // curved both ways
      const double radius = s.shape.index() == 2 ? 0.7 : 0.6;
      const double allowed = radius * (1.0 - std::cos(pi / resolution)) + 1e-15;
      for (const Triangle& t : mesh.triangles) {
        const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        for (int i = 0; i <= 6; ++i)
          for (int j = 0; i + j <= 6; ++j) {
            const double d = signed_distance(s.shape, ((6 - i - j) * a + i * b + j * c) / 6.0);
            ASSERT_LE(d, 1e-15) << s.name << " at " << resolution;
            ASSERT_GE(d, -allowed) << s.name << " at " << resolution;
          }
      }
    }
}

TEST(AnalyticBody, VolumesConvergeWithTheSquareOfTheResolution) {
  for (const NamedShape& s : closed_shapes()) {
    const double coarse = s.volume - report_mesh(tessellate(s.shape, 24)).volume;
    const double fine = s.volume - report_mesh(tessellate(s.shape, 96)).volume;
    if (std::holds_alternative<Box>(s.shape)) {
      EXPECT_NEAR(coarse, 0.0, 1e-14);
      continue;
    }
    EXPECT_GT(fine, 0.0) << s.name;
    EXPECT_LT(fine, 0.005 * s.volume) << s.name;
    EXPECT_NEAR(std::log2(coarse / fine) / 2.0, 2.0, 0.25) << s.name;
  }
}

// Distance to a mesh by brute force, signed by the winding number.
double mesh_distance(const TriangleMesh& mesh, const Vec3& p) {
  double square = std::numeric_limits<double>::infinity(), angle = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - p, b = mesh.vertices[t[1]] - p,
               c = mesh.vertices[t[2]] - p;
    const Vec3 n = (b - a).cross(c - a);
    const double u = n.dot(b.cross(c)), v = n.dot(c.cross(a)), w = n.dot(a.cross(b));
    if (u >= 0.0 && v >= 0.0 && w >= 0.0)
      square = std::min(square, std::pow(a.dot(n), 2) / n.squaredNorm());
    for (const auto& [x, y] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
      const double s = std::clamp(-x.dot(y - x) / (y - x).squaredNorm(), 0.0, 1.0);
      square = std::min(square, (x + s * (y - x)).squaredNorm());
    }
    // [VanOosterom1983] solid angle of a triangle.
    angle +=
        2.0 * std::atan2(a.dot(b.cross(c)), a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                                                b.dot(c) * a.norm() + c.dot(a) * b.norm());
  }
  return angle > 2.0 * pi ? -std::sqrt(square) : std::sqrt(square);
}

TEST(AnalyticBody, SignedDistancesAgreeWithTheTessellation) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-1.2, 1.2);
  for (const NamedShape& s : closed_shapes()) {
    const TriangleMesh mesh = tessellate(s.shape, 64);
    for (int i = 0; i < 60; ++i) {
      const Vec3 p(coordinate(random), coordinate(random), coordinate(random));
      EXPECT_NEAR(signed_distance(s.shape, p), mesh_distance(mesh, p), 2e-3)
          << s.name << " at " << p.transpose();
    }
  }
}

TEST(AnalyticBody, SpecialPointsHaveTheirExactDistances) {
  EXPECT_EQ(signed_distance(Plane{}, {3, 4, -2}), -2.0);
  EXPECT_EQ(signed_distance(Box{{2, 2, 2}}, {0, 0, 0}), -1.0);
  EXPECT_EQ(signed_distance(Box{{2, 2, 2}}, {4, 5, 0}), 5.0);
  EXPECT_EQ(signed_distance(Capsule{0.5, 2.0}, {0, 0, 3}), 1.5);
  EXPECT_EQ(signed_distance(Cylinder{1.0, 2.0}, {0, 0, 0}), -1.0);
  EXPECT_EQ(signed_distance(Cone{1.0, 1.0}, {0, 0, 2}), 1.5);
  EXPECT_EQ(signed_distance(Cone{1.0, 1.0}, {0, 0, -2}), 1.5);
  EXPECT_EQ(signed_distance(Cone{1.0, 1.0}, {3, 0, -0.5}), 2.0);
  EXPECT_EQ(signed_distance(Torus{1.0, 0.25}, {0, 0, 0}), 0.75);
  EXPECT_EQ(signed_distance(Torus{1.0, 0.25}, {0, 1, 0}), -0.25);
}

TEST(AnalyticBody, TrianglesAreWellShaped) {
  for (const NamedShape& s : closed_shapes()) {
    if (std::holds_alternative<Box>(s.shape)) continue;
    const TriangleMesh mesh = tessellate(s.shape, 48);
    double least = 1.0;
    for (const Triangle& t : mesh.triangles) {
      const Vec3 e0 = mesh.vertices[t[1]] - mesh.vertices[t[0]];
      const Vec3 e1 = mesh.vertices[t[2]] - mesh.vertices[t[1]];
      const Vec3 e2 = mesh.vertices[t[0]] - mesh.vertices[t[2]];
      const double edges = e0.squaredNorm() + e1.squaredNorm() + e2.squaredNorm();
      least = std::min(least, 2.0 * std::sqrt(3.0) * e0.cross(e1).norm() / edges);
    }
    EXPECT_GT(least, 0.3) << s.name;  // 1: equilateral; 0.4: right-angled, four times as long
  }
}

TEST(AnalyticBody, ImpossibleSizesAreRefused) {
  EXPECT_SAYS(fault([] { tessellate(Sphere{0.0}, 16); }), "radius of a sphere");
  EXPECT_SAYS(fault([] { tessellate(Box{{1, -1, 1}}, 16); }), "size of a box");
  EXPECT_SAYS(fault([] { tessellate(Cone{0.5, NAN}, 16); }), "height of a cone");
  EXPECT_SAYS(fault([] { tessellate(Torus{0.1, 0.2}, 16); }), "smaller than its radius");
  EXPECT_SAYS(fault([] { tessellate(Sphere{}, 2); }), "resolution");
  EXPECT_SAYS(fault([] { tessellate(Sphere{}, 1000000); }), "resolution");
}

// ---------------------------------------------------------------- moving bodies

std::vector<Vec3> positions(const Body& body, double time) {
  std::vector<Vec3> x(body.vertex_count());
  body.positions(time, x);
  return x;
}

TEST(MovingBody, AStaticBodyStays) {
  const auto body = make_static_body(tetrahedron());
  EXPECT_TRUE(same_bits(positions(*body, 7.0), tetrahedron().vertices));
  EXPECT_TRUE(body->is_static(-1e9, 1e9));
  EXPECT_EQ(body->triangles(), tetrahedron().triangles);
}

Eigen::Quaterniond about_z(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
}

TEST(MovingBody, KeyframesTurnEvenlyAndHoldAtTheEnds) {
  const auto body = make_keyframed_body(
      tetrahedron(), {{1.0, {0, 0, 0}, about_z(0.0)}, {3.0, {0, 0, 4}, about_z(pi / 2)}});
  EXPECT_TRUE(same_bits(positions(*body, 0.0), tetrahedron().vertices));
  EXPECT_TRUE(
      positions(*body, 1.5)[1].isApprox(Vec3(std::cos(pi / 8), std::sin(pi / 8), 1.0), 1e-14));
  EXPECT_TRUE(positions(*body, 99.0)[1].isApprox(Vec3(0, 1, 4), 1e-14));
  EXPECT_TRUE(body->is_static(-5.0, 1.0));
  EXPECT_TRUE(body->is_static(3.0, 5.0));
  EXPECT_FALSE(body->is_static(0.9, 1.1));
}

TEST(MovingBody, EqualKeyframesAreStaticToTheBit) {
  Eigen::Quaterniond turned = about_z(0.7), negative = turned;
  negative.coeffs() *= -1.0;
  const Vec3 place(0.1, 0.2, 0.3);
  const auto body = make_keyframed_body(
      tetrahedron(), {{0.0, place, turned}, {1.0, place, negative}, {2.0, Vec3::Zero(), turned}});
  EXPECT_TRUE(body->is_static(0.0, 1.0));
  EXPECT_FALSE(body->is_static(0.5, 1.5));
  for (const double time : {0.1, 0.37, 1.0})
    EXPECT_TRUE(same_bits(positions(*body, time), positions(*body, 0.0)));
}

TEST(MovingBody, ASequenceIsLinearBetweenItsFrames) {
  std::vector<TriangleMesh> frames(4, tetrahedron());
  for (Vec3& x : frames[2].vertices) x.z() += 1.0;
  frames[3] = frames[2];
  const auto body = make_sequence_body(frames, 10.0, 5.0);
  EXPECT_TRUE(same_bits(positions(*body, 0.0), frames[0].vertices));
  EXPECT_TRUE(same_bits(positions(*body, 5.05), frames[0].vertices));
  EXPECT_NEAR(positions(*body, 5.125)[3].z(), 1.25, 1e-12);
  EXPECT_TRUE(same_bits(positions(*body, 99.0), frames[3].vertices));
  EXPECT_TRUE(body->is_static(0.0, 5.1));
  EXPECT_FALSE(body->is_static(5.05, 5.15));
  EXPECT_TRUE(body->is_static(5.2, 9.0));
  EXPECT_TRUE(body->is_static(5.3, 5.3));
}

/// A bumpy ball, so that no two of its vertices are alike.
TriangleMesh bumpy_ball(std::mt19937_64& random, int resolution) {
  TriangleMesh mesh = tessellate(Sphere{0.5}, resolution);
  std::uniform_real_distribution<double> bump(0.8, 1.2);
  for (Vec3& x : mesh.vertices) x *= bump(random);
  return mesh;
}

TEST(MovingBody, VerticesThatChangePlacesAreToldFromMotion) {
  std::mt19937_64 random(41);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  for (int draw = 0; draw < 100; ++draw) {
    const TriangleMesh mesh = bumpy_ball(random, 6 + draw % 12);
    const std::vector<Edge> edges = unique_edges(mesh.triangles);
    const auto draw_vector = [&] { return Vec3(share(random), share(random), share(random)); };
    std::vector<Vec3> moved = mesh.vertices;
    const Mat3 turn = Eigen::AngleAxisd(share(random), draw_vector().normalized()).matrix();
    const Vec3 shift = 3.0 * draw_vector();
    for (Vec3& x : moved) x = turn * x + shift + 0.01 * draw_vector();
    EXPECT_EQ(vertex_leap(mesh.vertices, moved, edges), "") << "draw " << draw;
    std::vector<Vec3> shuffled = moved;
    std::shuffle(shuffled.begin(), shuffled.end(), random);
    EXPECT_NE(vertex_leap(mesh.vertices, shuffled, edges), "") << "draw " << draw;
  }
}

TEST(MovingBody, TwoVerticesThatChangePlacesAreSeen) {
  std::mt19937_64 random(41);
  const TriangleMesh mesh = tessellate(Sphere{0.5}, 32);
  const std::vector<Edge> edges = unique_edges(mesh.triangles);
  for (int draw = 0; draw < 20; ++draw) {
    std::vector<Vec3> swapped = mesh.vertices;
    std::size_t a = 0, b = 0;
    while ((swapped[a] - swapped[b]).norm() < 0.5) {
      a = random() % swapped.size();
      b = random() % swapped.size();
    }
    std::swap(swapped[a], swapped[b]);
    EXPECT_NE(vertex_leap(mesh.vertices, swapped, edges).find("2 of "), std::string::npos);
  }
}

TEST(MovingBody, ImpossibleMotionsAreRefused) {
  EXPECT_SAYS(fault([] { make_keyframed_body(tetrahedron(), {}); }), "at least one keyframe");
  EXPECT_SAYS(fault([] { make_keyframed_body(tetrahedron(), {{1.0}, {1.0}}); }), "keyframe 1");
  EXPECT_SAYS(fault([] { make_keyframed_body(tetrahedron(), {{NAN}}); }), "not finite");
  EXPECT_SAYS(
      fault([] {
        make_keyframed_body(tetrahedron(), {{0.0, Vec3::Zero(), Eigen::Quaterniond(0, 0, 0, 0)}});
      }),
      "rotation quaternion of length 0");
  EXPECT_SAYS(fault([] { make_sequence_body({}, 10.0, 0.0); }), "at least one frame");
  EXPECT_SAYS(fault([] { make_sequence_body({tetrahedron()}, 0.0, 0.0); }), "frames per second");
  TriangleMesh other = tetrahedron();
  std::swap(other.triangles[0], other.triangles[1]);
  EXPECT_SAYS(fault([&] { make_sequence_body({tetrahedron(), other}, 1.0, 0.0); }), "frame 1");
  TriangleMesh bad = tetrahedron();
  bad.triangles[2] = {0, 0, 1};
  EXPECT_SAYS(fault([&] { make_static_body(bad); }), "triangle 2");
}

// ---------------------------------------------------------------- mannequin

TEST(Mannequin, IsClosedCleanAndOfAdultSize) {
  const TriangleMesh mesh = make_mannequin();
  const MeshReport report = report_mesh(mesh);
  EXPECT_TRUE(report.sentences().empty());
  EXPECT_EQ(report.components, 1u);
  EXPECT_EQ(static_cast<int>(report.vertices) - static_cast<int>(report.triangles) / 2, 2);
  EXPECT_NEAR(static_cast<double>(report.triangles), 10000.0, 2.0);
  EXPECT_EQ(report.lower.z(), 0.0);
  EXPECT_NEAR(report.upper.z(), 1.7, 0.01);
  EXPECT_GT(report.volume, 0.045);  // an adult of this height has 50 to 75 litres
  EXPECT_LT(report.volume, 0.08);

  // The file in the repository. Sines and cosines of other C libraries may differ in the last bit,
  // so the shape is compared.
  const TriangleMesh file =
      read_mesh(fs::path(SELVEDGE_SOURCE_DIR) / "data" / "bodies" / "mannequin.ply");
  EXPECT_TRUE(report_mesh(file).sentences().empty());
  EXPECT_EQ(file.triangles.size(), mesh.triangles.size());
  EXPECT_NEAR(report_mesh(file).volume, report.volume, 1e-6);
}

TEST(Mannequin, FacesHeightAndPoseAreSettable) {
  MannequinConfig config;
  config.faces = 5000;
  config.height = 0.85;
  config.left = {.shoulder_swing = -0.4, .elbow = 0.4, .hip_swing = 0.5, .knee = 0.3};
  config.right = {.shoulder_swing = 0.5, .elbow = 0.7, .hip_swing = -0.35, .knee = 0.4};
  const MeshReport report = report_mesh(make_mannequin(config));
  EXPECT_TRUE(report.sentences().empty());
  EXPECT_NEAR(static_cast<double>(report.triangles), 5000.0, 2.0);
  EXPECT_EQ(report.lower.z(), 0.0);
  EXPECT_LT(report.upper.z(), 0.86);
}

TEST(Mannequin, TheSameConfigurationGivesTheSameBits) {
  MannequinConfig config;
  config.faces = 5000;
  const TriangleMesh many = make_mannequin(config);
  const ThreadLimit one(1);
  const TriangleMesh single = make_mannequin(config);
  EXPECT_TRUE(same_bits(many.vertices, single.vertices));
  EXPECT_EQ(many.triangles, single.triangles);
}

TEST(Mannequin, PosesOutsideTheirRangesAreRefused) {
  EXPECT_SAYS(fault([] { make_mannequin({.faces = 100}); }), "faces");
  EXPECT_SAYS(fault([] { make_mannequin({.height = NAN}); }), "height");
  MannequinConfig config;
  config.left.knee = -1.0;
  EXPECT_SAYS(fault([&] { make_mannequin(config); }), "knee");
}

}  // namespace
}  // namespace selvedge::bodies_test
