// SPDX-License-Identifier: MIT
// A particle against analytic bodies: times against the signed distance traced along the path.
#include <gtest/gtest.h>
#include <selvedge/narrowphase/internal/particle_body.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include "hard_queries.h"

namespace selvedge::particle_body_test {
namespace {

using namespace hard_queries;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

Vec3 vector(Random& r, double size) {
  return {real(r, -size, size), real(r, -size, size), real(r, -size, size)};
}

const std::vector<AnalyticShape>& shapes() {
  static const std::vector<AnalyticShape> all = {
      Plane{},         Box{{0.5, 1.0, 2.0}}, Sphere{0.5},     Capsule{0.3, 1.0},
      Cylinder{},      Cylinder{0.1, 3.0},   Cone{0.5, 1.0},  Cone{1.0, 0.1},
      Cone{0.05, 2.0}, Torus{0.3, 0.05},     Torus{0.5, 0.3}, Torus{0.2, 0.3}};
  return all;
}

double accuracy(const AnalyticShape& shape, const Vec3& a, const Vec3& b) {
  double largest = std::max({3.0, a.norm(), b.norm()});
  if (const auto* torus = std::get_if<Torus>(&shape)) largest *= largest / torus->tube;
  return kParticleAccuracy * largest;
}

/// The signed distance falls by at most the way: from t no contact can come before
/// t + distance / way. First time at which it is below `near`, or kNoCollision.
double traced_time(const AnalyticShape& shape, const Vec3& a, const Vec3& b, double near) {
  const double way = (b - a).norm();
  for (double t = 0.0; t <= 1.0;) {
    const double distance = signed_distance(shape, a + t * (b - a));
    if (distance <= near) return t;
    t += distance / way;
  }
  return kNoCollision;
}

TEST(ParticleBody, IsWhereTheSignedDistanceFirstIsZero) {
  constexpr double kNear = 1e-7;
  for (std::size_t which = 0; which < shapes().size(); ++which) {
    const AnalyticShape& shape = shapes()[which];
    Random r(100 + which);
    int hits = 0, starts = 0, passes = 0, grazes = 0;
    for (int i = 0; i < 4000; ++i) {
      const Vec3 a = vector(r, 1.5), b = i % 3 == 0 ? vector(r, 0.5) : vector(r, 1.5);
      const ShapeContact c = particle_body_contact(shape, a, b);
      ASSERT_EQ(c.distance_t0, signed_distance(shape, a));
      ASSERT_EQ(c.distance_t1, signed_distance(shape, b));
      const double traced = traced_time(shape, a, b, kNear);
      if (c.toi == kNoCollision) {
        ++passes;
        // Where the trace stops without a contact, the path must leave again without one.
        if (traced == kNoCollision) continue;
        ++grazes;
        for (int k = 0; k <= 1000; ++k)
          ASSERT_GE(signed_distance(shape, a + (k / 1000.0) * (b - a)), -accuracy(shape, a, b));
        continue;
      }
      ASSERT_TRUE(c.toi >= 0.0 && c.toi <= 1.0);
      ASSERT_NEAR(c.normal.norm(), 1.0, 1e-14);
      if (c.distance_t0 <= 0.0) {
        ++starts;
        ASSERT_EQ(c.toi, 0.0);
        ASSERT_EQ(c.point, a);
        continue;
      }
      ++hits;
      const double distance = signed_distance(shape, c.point);
      ASSERT_LE(std::abs(distance), accuracy(shape, a, b)) << "shape " << which << " path " << i;
      ASSERT_NEAR((c.point - (a + c.toi * (b - a))).norm(), 0.0, 1e-14);
      // Not before the trace, and so near behind it that nothing was overlooked.
      ASSERT_LE(traced, c.toi) << "shape " << which << " path " << i;
      for (int k = 0; k <= 20; ++k) {
        const double t = traced * k / 20.0;
        ASSERT_GT(signed_distance(shape, a + t * (b - a)), 0.0);
      }
      for (int k = 0; k <= 20; ++k) {
        const double t = traced + (c.toi - traced) * k / 20.0;
        ASSERT_GE(signed_distance(shape, a + t * (b - a)), -accuracy(shape, a, b));
      }
    }
    std::cout << "shape " << which << ": " << hits << " hits, " << starts << " start inside, "
              << passes << " pass, of which " << grazes << " within " << kNear << "\n";
    EXPECT_GT(hits, 50);
    EXPECT_GT(passes, 100);
  }
}

TEST(ParticleBody, TheNormalIsTheGradientOfTheSignedDistance) {
  constexpr double kStep = 1e-6;
  for (std::size_t which = 0; which < shapes().size(); ++which) {
    const AnalyticShape& shape = shapes()[which];
    Random r(200 + which);
    int off = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 x = vector(r, 1.5);
      Vec3 gradient;
      for (int k = 0; k < 3; ++k)
        gradient[k] = (signed_distance(shape, x + kStep * Vec3::Unit(k)) -
                       signed_distance(shape, x - kStep * Vec3::Unit(k))) /
                      (2.0 * kStep);
      off += (outward_normal(shape, x) - gradient).norm() > 1e-4;
    }
    EXPECT_LE(off, 4) << "shape " << which;  // on a ridge there is no gradient
  }
}

void expect_contact(const AnalyticShape& shape, const Vec3& a, const Vec3& b, double toi,
                    const Vec3& normal) {
  const ShapeContact c = particle_body_contact(shape, a, b);
  ASSERT_NEAR(c.toi, toi, 1e-12) << "shape " << shape.index();
  EXPECT_NEAR((c.point - (a + toi * (b - a))).norm(), 0.0, 1e-12) << "shape " << shape.index();
  EXPECT_NEAR((c.normal - normal).norm(), 0.0, 1e-6) << "shape " << shape.index();
}

TEST(ParticleBody, HasTheTimesThatCanBeWorkedOutByHand) {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  expect_contact(Plane{}, {5, 5, 3}, {7, 7, -1}, 0.75, z);
  expect_contact(Box{{2, 2, 2}}, {-3, 0.5, 0.5}, {5, 0.5, 0.5}, 0.25, -x);
  expect_contact(Box{{2, 2, 2}}, {0, 0, 2}, {0, 0, 1}, 1.0, z);  // touches with the last instant
  expect_contact(Sphere{1.0}, {0, -3, 0}, {0, 5, 0}, 0.25, -y);
  expect_contact(Sphere{1.0}, {-2, 0.6, 0}, {2, 0.6, 0}, 0.3, {-0.8, 0.6, 0});
  expect_contact(Capsule{0.5, 2.0}, {2, 0, 0.5}, {-2, 0, 0.5}, 0.375, x);
  expect_contact(Capsule{0.5, 2.0}, {0, 0, 3.5}, {0, 0, -0.5}, 0.5, z);
  expect_contact(Cylinder{0.5, 2.0}, {2, 0, 0.5}, {-2, 0, 0.5}, 0.375, x);
  expect_contact(Cylinder{0.5, 2.0}, {0.2, 0, 3}, {0.2, 0, -1}, 0.5, z);
  const Vec3 slant = Vec3(2, 0, 1).normalized();  // radius 1, height 2
  expect_contact(Cone{1.0, 2.0}, {2, 0, 0}, {-2, 0, 0}, 0.375, slant);
  expect_contact(Cone{1.0, 2.0}, {0.25, 0, -3}, {0.25, 0, 1}, 0.5, -z);
  expect_contact(Cone{1.0, 2.0}, {0, 0, 2}, {0, 0, 0}, 0.5, Vec3(2, 0, 1).normalized());  // the tip
  expect_contact(Torus{1.0, 0.25}, {2.25, 0, 0}, {-1.75, 0, 0}, 0.25, x);
  expect_contact(Torus{1.0, 0.25}, {0, 0, 0}, {2, 0, 0}, 0.375, -x);  // from within the hole
  expect_contact(Torus{1.0, 0.25}, {1, 0, 1}, {1, 0, 0}, 0.75, z);
}

TEST(ParticleBody, TouchingCountsAndAHoleIsAHole) {
  expect_contact(Sphere{1.0}, {-2, 1, 0}, {2, 1, 0}, 0.5, Vec3::UnitY());
  expect_contact(Cylinder{1.0, 2.0}, {-2, 1, 0.5}, {2, 1, 0.5}, 0.5, Vec3::UnitY());
  expect_contact(Capsule{1.0, 2.0}, {-2, 1, 0.5}, {2, 1, 0.5}, 0.5, Vec3::UnitY());
  expect_contact(Plane{}, {0, 0, 1}, {0, 0, 0}, 1.0, Vec3::UnitZ());
  EXPECT_EQ(particle_body_contact(Torus{1.0, 0.25}, {0, 0, 3}, {0.1, 0, -3}).toi, kNoCollision);
  EXPECT_EQ(particle_body_contact(Sphere{1.0}, {-2, 1.001, 0}, {2, 1.001, 0}).toi, kNoCollision);
  EXPECT_EQ(particle_body_contact(Cone{1.0, 2.0}, {-1, 0, 1.001}, {1, 0, 1.001}).toi, kNoCollision);
  // The upper half of the double cone is no part of the body.
  EXPECT_EQ(particle_body_contact(Cone{1.0, 2.0}, {-3, 0, 2}, {3, 0, 2}).toi, kNoCollision);
}

TEST(ParticleBody, ThePlanesVerdictIsExact) {
  EXPECT_EQ(particle_body_contact(Plane{}, {0, 0, 1}, {0, 0, 1e-30}).toi, kNoCollision);
  EXPECT_EQ(particle_body_contact(Plane{}, {0, 0, 1e-30}, {0, 0, 5e-324}).toi, kNoCollision);
  EXPECT_EQ(particle_body_contact(Plane{}, {0, 0, 1}, {0, 0, -1e-30}).toi, 1.0);
}

/// Paths along a tangent plane, moved in or out by a little more than the accuracy.
TEST(ParticleBody, GrazingPathsAreDecidedToTheStatedAccuracy) {
  constexpr double kAside = 1e-11;
  for (std::size_t which = 0; which < shapes().size(); ++which) {
    const AnalyticShape& shape = shapes()[which];
    const bool convex = !std::holds_alternative<Torus>(shape);
    Random r(300 + which);
    int inside = 0, outside = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 from = vector(r, 1.5);
      const Vec3 n = outward_normal(shape, from);
      const Vec3 x = from - signed_distance(shape, from) * n;
      if (std::abs(signed_distance(shape, x)) > 1e-15) continue;  // a ridge
      const Vec3 along = n.cross(vector(r, 1.0)).normalized();
      const Vec3 in = x - kAside * n, out = x + kAside * n;
      if (signed_distance(shape, in) < -0.5 * kAside) {
        ++inside;
        ASSERT_NE(particle_body_contact(shape, in - along, in + along).toi, kNoCollision)
            << "shape " << which << " path " << i;
      }
      if (convex && signed_distance(shape, out) > 0.5 * kAside) {
        ++outside;
        ASSERT_EQ(particle_body_contact(shape, out - along, out + along).toi, kNoCollision)
            << "shape " << which << " path " << i;
      }
    }
    EXPECT_GT(inside, 100) << "shape " << which;
    EXPECT_TRUE(!convex || outside > 100) << "shape " << which;
  }
}

TEST(ParticleBody, AParticleAtRestTouchesOnlyWhatItIsIn) {
  for (const AnalyticShape& shape : shapes()) {
    const Vec3 out(0, 0, 3), in(0.0, 0.0, -3.0);
    EXPECT_EQ(particle_body_contact(shape, out, out).toi, kNoCollision);
    if (shape.index() == 0) {
      EXPECT_EQ(particle_body_contact(shape, in, in).toi, 0.0);
    }
  }
  EXPECT_EQ(particle_body_contact(Sphere{1.0}, {0, 0, 0}, {9, 0, 0}).toi, 0.0);
  EXPECT_EQ(particle_body_contact(Box{}, {0.1, 0, 0}, {0.1, 0, 0}).toi, 0.0);
}

TEST(ParticleBody, AnEndInsideIsAlwaysAContact) {
  Random r(9);
  for (const AnalyticShape& shape : shapes()) {
    for (int i = 0; i < 2000; ++i) {
      // Onto the surface, as near as rounding lets.
      const Vec3 a = vector(r, 2.0), x = vector(r, 1.0);
      const Vec3 b = x - signed_distance(shape, x) * outward_normal(shape, x);
      const ShapeContact c = particle_body_contact(shape, a, b);
      if (c.distance_t1 <= 0.0 || c.distance_t0 <= 0.0) {
        ASSERT_NE(c.toi, kNoCollision) << shape.index();
      }
    }
  }
}

TEST(ParticleBody, ComesFromFarAway) {
  for (const double far : {1e3, 1e6, 1e9}) {
    const ShapeContact c = particle_body_contact(Torus{1.0, 0.25}, {far, 0, 0}, {-far, 0, 0});
    ASSERT_NE(c.toi, kNoCollision);
    EXPECT_NEAR(c.point.x(), 1.25, 8.0 * kParticleAccuracy * far);
    const ShapeContact s = particle_body_contact(Sphere{1.0}, {0.6, far, 0}, {0.6, -far, 0});
    ASSERT_NE(s.toi, kNoCollision);
    EXPECT_NEAR(s.point.y(), 0.8, 8.0 * kParticleAccuracy * far);
  }
}

/// The shape with all sizes times k.
AnalyticShape scaled(const AnalyticShape& shape, double k) {
  AnalyticShape s = shape;
  if (auto* p = std::get_if<Plane>(&s)) p->size *= k;
  if (auto* p = std::get_if<Box>(&s)) p->size *= k;
  if (auto* p = std::get_if<Sphere>(&s)) p->radius *= k;
  if (auto* p = std::get_if<Capsule>(&s)) p->radius *= k, p->length *= k;
  if (auto* p = std::get_if<Cylinder>(&s)) p->radius *= k, p->height *= k;
  if (auto* p = std::get_if<Cone>(&s)) p->radius *= k, p->height *= k;
  if (auto* p = std::get_if<Torus>(&s)) p->radius *= k, p->tube *= k;
  return s;
}

TEST(ParticleBody, ScalingByAPowerOfTwoNeverChangesTheTime) {
  Random r(10);
  for (const AnalyticShape& shape : shapes()) {
    for (int i = 0; i < 500; ++i) {
      const Vec3 a = vector(r, 1.5), b = vector(r, 1.5);
      const double k = std::ldexp(1.0, integer(r, -900, 900));
      const ShapeContact c = particle_body_contact(shape, a, b);
      const ShapeContact s = particle_body_contact(scaled(shape, k), k * a, k * b);
      ASSERT_EQ(s.toi, c.toi) << "shape " << shape.index() << " times " << k;
      ASSERT_EQ(s.point, Vec3(k * c.point));
      ASSERT_EQ(s.distance_t0, k * c.distance_t0);
    }
  }
}

TEST(ParticleBody, ReturnsATimeOrNoCollisionWhateverTheInput) {
  Random r(12);
  for (const AnalyticShape& shape : shapes()) {
    for (int i = 0; i < 4000; ++i) {
      Vec3 a = vector(r, 1.0), b = i % 3 == 0 ? a : vector(r, 1.0);
      for (int k = 0; k < 3; ++k) {
        a[k] *= std::ldexp(1.0, integer(r, -498, 498));
        b[k] *= integer(r, 0, 3) == 0 ? 0.0 : std::ldexp(1.0, integer(r, -498, 498));
      }
      const AnalyticShape s = scaled(shape, std::ldexp(1.0, integer(r, -498, 498)));
      const ShapeContact c = particle_body_contact(s, a, b);
      if (c.toi == kNoCollision) continue;
      ASSERT_TRUE(c.toi >= 0.0 && c.toi <= 1.0) << "shape " << shape.index() << ": " << c.toi;
      ASSERT_TRUE(c.point.allFinite());
      ASSERT_NEAR(c.normal.norm(), 1.0, 1e-12) << "shape " << shape.index();
    }
  }
}

TEST(ParticleBody, RefusesWhatIsNoBodyAndNoPlace) {
  EXPECT_THROW(particle_body_contact(Sphere{0.0}, {0, 0, 0}, {1, 0, 0}), std::invalid_argument);
  EXPECT_THROW(particle_body_contact(Cone{1.0, -1.0}, {0, 0, 0}, {1, 0, 0}), std::invalid_argument);
  EXPECT_THROW(particle_body_contact(Box{{1, kNan, 1}}, {0, 0, 0}, {1, 0, 0}),
               std::invalid_argument);
  EXPECT_THROW(particle_body_contact(Plane{}, {0, 0, kInf}, {1, 0, 0}), std::invalid_argument);
  EXPECT_THROW(particle_body_contact(Plane{}, {0, 0, 1}, {kNan, 0, 0}), std::invalid_argument);
}

}  // namespace
}  // namespace selvedge::particle_body_test
