// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/dress/detail/winding_number.h>
#include <selvedge/dress/dress.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

namespace selvedge::body_room_test {
namespace {

/// A bumpy ball; `shift` moves it.
TriangleMesh ball(int rings, const Vec3& shift, std::mt19937& random) {
  std::uniform_real_distribution<double> bump(0.9, 1.1);
  TriangleMesh mesh;
  mesh.vertices = {Vec3(0, 0, 0.5) + shift, Vec3(0, 0, -0.5) + shift};
  for (int i = 1; i < rings; ++i)
    for (int k = 0; k < 2 * rings; ++k) {
      const double a = std::numbers::pi * i / rings, b = std::numbers::pi * k / rings;
      mesh.vertices.push_back(
          0.5 * bump(random) *
              Vec3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)) +
          shift);
    }
  const auto at = [&](int i, int k) { return 2 + (i - 1) * 2 * rings + k % (2 * rings); };
  for (int k = 0; k < 2 * rings; ++k) {
    mesh.triangles.push_back({0, at(1, k), at(1, k + 1)});
    mesh.triangles.push_back({1, at(rings - 1, k + 1), at(rings - 1, k)});
    for (int i = 1; i + 1 < rings; ++i) {
      mesh.triangles.push_back({at(i, k), at(i + 1, k), at(i + 1, k + 1)});
      mesh.triangles.push_back({at(i, k), at(i + 1, k + 1), at(i, k + 1)});
    }
  }
  return mesh;
}

/// By the sum over all triangles [A. Van Oosterom, J. Strackee, 1983].
double summed(const TriangleMesh& body, const Vec3& point) {
  double sum = 0.0;
  for (const Triangle& t : body.triangles) {
    const Vec3 a = body.vertices[t[0]] - point, b = body.vertices[t[1]] - point,
               c = body.vertices[t[2]] - point;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2.0 * elementary::atan2(a.dot(b.cross(c)),
                                   la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (4.0 * std::numbers::pi);
}

TEST(WindingNumber, OfTheTreeIsThatOfTheSum) {
  std::mt19937 random(7);
  std::normal_distribution<double> spread(0.0, 0.6);
  for (int shape = 0; shape < 6; ++shape) {
    // Two balls that overlap, so that the numbers are 0, 1 and 2.
    TriangleMesh body = ball(6 + 4 * shape, Vec3::Zero(), random);
    const TriangleMesh second = ball(8, Vec3(0.4, 0.1, 0.0), random);
    const auto first = static_cast<std::int32_t>(body.vertices.size());
    body.vertices.insert(body.vertices.end(), second.vertices.begin(), second.vertices.end());
    for (Triangle t : second.triangles) {
      for (std::int32_t& v : t) v += first;
      body.triangles.push_back(t);
    }
    const detail::WindingNumber winding(body);
    for (int i = 0; i < 300; ++i) {
      Vec3 p(spread(random), spread(random), spread(random));
      if (i % 3 == 0)
        p = 1.0002 * body.vertices[static_cast<std::size_t>(i) % body.vertices.size()];
      EXPECT_NEAR(winding.at(p), summed(body, p), 0.02) << shape << " " << p.transpose();
    }
  }
}

TEST(WindingNumber, OfNothingIsZero) {
  const TriangleMesh nothing;
  EXPECT_EQ(detail::WindingNumber(nothing).at(Vec3::Zero()), 0.0);
}

}  // namespace
}  // namespace selvedge::body_room_test
