// SPDX-License-Identifier: MIT
// The adapters to optional libraries, as far as this build has them.
#include <gtest/gtest.h>
#include <selvedge/broadphase/adapters.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/types.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/scene/methods.h>

#include <cmath>
#include <iostream>
#include <limits>
#include <random>

#include "broad_phase_trial.h"

namespace selvedge::adapters_test {
namespace {

using Surface = OwnedSurface;

void jiggle(Surface& s, Random& random, double amount) {
  for (std::size_t i = 0; i < s.x_t0.size(); ++i) s.x_t1[i] = s.x_t0[i] + random.vector(amount);
}

/// Folds a sheet into a small box: many layers, many pairs.
Surface crumpled(Random& random, int n, double box) {
  Surface s = flat_sheet(n, n, 1.0);
  for (Vec3& x : s.x_t0)
    for (int k = 0; k < 3; ++k) {
      const double turn = x[k] * (1.0 + 0.3 * k) + x[(k + 1) % 3];
      x[k] = std::abs(std::remainder(turn, 2 * box)) + random.uniform(0.0, 0.05 * box);
    }
  jiggle(s, random, 0.05 * box);
  return s;
}

/// Triangles, edges and points on random vertices, in no order, some edges twice, some from a
/// vertex to itself, some vertices and edges in no triangle.
Surface soup(Random& random) {
  Surface s;
  const int n = random.integer(3, 60);
  for (int i = 0; i < n; ++i) s.x_t0.push_back(random.vector(1.0));
  const auto any = [&] { return random.integer(0, n - 1); };
  for (int i = random.integer(0, 60); i > 0; --i) s.triangles.push_back({any(), any(), any()});
  for (int i = random.integer(0, 90); i > 0; --i) s.edges.push_back({any(), any()});
  s.x_t1 = s.x_t0;
  jiggle(s, random, random.uniform(0.0, 0.5));
  return s;
}

/// A random scene of one of several kinds, most of them nasty.
Surface make_scene(unsigned seed) {
  Random random(seed);
  const int n = random.integer(1, 12);
  Surface s = flat_sheet(n, n, 1.0);
  switch (seed % 10) {
    case 0:
    case 1:
      s = soup(random);
      break;
    case 2:
      s = crumpled(random, 12, 0.2);
      break;
    case 3:  // A spike.
      s.x_t1[0] += Vec3(random.uniform(-10, 10), 3, 1000 * random.uniform(0, 1));
      break;
    case 4:  // Everything in one point.
      for (Vec3& x : s.x_t0) x = Vec3(0.3, 0.1, -7.0);
      s.x_t1 = s.x_t0;
      break;
    case 5:  // Exact touches everywhere.
      s = soup(random);
      for (Vec3& x : s.x_t0) x = (3.0 * x).array().round();
      s.x_t1 = s.x_t0;
      return s;
    case 6:  // Far from the origin.
      s = crumpled(random, 10, 0.2);
      for (auto* xs : {&s.x_t0, &s.x_t1})
        for (Vec3& x : *xs) x += Vec3(1e6, -1e6, 1e6);
      break;
    case 7:  // Up to where squares overflow a double.
      s = soup(random);
      for (Vec3& x : s.x_t0) x *= std::pow(10.0, random.integer(-30, 200));
      s.x_t1 = s.x_t0;
      break;
    case 8:  // Few or no primitives.
      if (seed % 3 == 0) s = Surface{};
      s.triangles.resize(std::min<std::size_t>(s.triangles.size(), seed % 2));
      s.close();
      break;
    default:
      jiggle(s, random, 0.1);
      break;
  }
  s.thickness = random.integer(0, 2) * 0.01;
  return s;
}

std::string message_of(BroadPhase& detector, const Surface& a) {
  try {
    self_pairs_of(detector, a);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

template <class Registry>
std::vector<std::string> built(const Registry& registry) {
  std::vector<std::string> names;
  for (const auto& [name, entry] : registry)
    if (!entry.library().empty() && entry.library() != "OSMesa")  // has own tests
      names.push_back(name);
  for (const auto& [name, library] : registry.absent())
    std::cout << name << " is not in this build, which lacks " << library << "\n";
  return names;
}

/// With SELVEDGE_TESTS_CGAL the program has CGAL's detectors beside the methods of this build.
BroadPhaseRegistry broad_phases() {
  BroadPhaseRegistry registry = methods_of_this_build().broad_phases;
#ifdef SELVEDGE_TESTS_CGAL
  register_cgal(registry);
#endif
  return registry;
}

/// Each case runs on every broad-phase adapter of this program.
class BroadPhaseAdapters : public ::testing::Test {
 protected:
  void SetUp() override {
    if (names_.empty()) GTEST_SKIP() << "no library for a broad phase was found";
  }
  std::unique_ptr<BroadPhase> make(const std::string& name) const { return registry_.at(name)(); }

  const BroadPhaseRegistry registry_ = broad_phases();
  const std::vector<std::string> names_ = built(registry_);
  std::unique_ptr<BroadPhase> brute_ = make_brute_force();
};

}  // namespace

TEST_F(BroadPhaseAdapters, FindWhatBruteForceFindsOnRandomAndNastySurfaces) {
  std::size_t found = 0;
  for (const std::string& name : names_) {
    auto kept = make(name);
    for (unsigned seed = 0; seed < 400; ++seed) {
      const Surface a = make_scene(seed), b = make_scene(seed * 7 + 5);
      const CandidatePairs self = self_pairs_of(*brute_, a), pairs = pairs_of(*brute_, a, b);
      ASSERT_TRUE(same(self_pairs_of(*kept, a), self)) << name << " seed " << seed;
      ASSERT_TRUE(same(pairs_of(*kept, a, b), pairs)) << name << " seed " << seed;
      if (seed % 8 == 0) {
        auto fresh = make(name);
        ASSERT_TRUE(same(pairs_of(*fresh, a, b), pairs)) << name << " seed " << seed;
      }
      found += self.size() + pairs.size();
    }
  }
  EXPECT_GT(found, 300000u * names_.size());
}

TEST_F(BroadPhaseAdapters, FindTheSameWithAnyNumberOfThreads) {
  Random random(4);
  const Surface a = crumpled(random, 30, 0.2), b = crumpled(random, 25, 0.25);
  const CandidatePairs self = self_pairs_of(*brute_, a), pairs = pairs_of(*brute_, a, b);
  ASSERT_GT(self.size() + pairs.size(), 50000u);
  for (const std::string& name : names_)
    for (const int threads : {1, 2, 8}) {
      const ThreadLimit limit(threads);
      auto detector = make(name);
      for (int call = 0; call < 2; ++call) {
        EXPECT_TRUE(same(self_pairs_of(*detector, a), self)) << name << ", " << threads;
        EXPECT_TRUE(same(pairs_of(*detector, a, b), pairs)) << name << ", " << threads;
      }
    }
}

TEST_F(BroadPhaseAdapters, FollowASurfaceThatMovesSmoothlyThenWildly) {
  for (const std::string& name : names_) {
    Random random(5);
    Surface a = flat_sheet(20, 20, 1.0), b = flat_sheet(12, 12, 1.0);
    a.thickness = 0.004;
    auto kept = make(name);
    for (int step = 0; step < 30; ++step) {
      a.x_t0 = a.x_t1;
      jiggle(a, random, step < 15 ? 0.003 : 0.2);
      for (Vec3& x : b.x_t1) x.z() += 0.001;
      if (step == 25) a.x_t1[7] *= 1e4;
      ASSERT_TRUE(same(pairs_of(*kept, a, b), pairs_of(*brute_, a, b))) << name << " " << step;
      ASSERT_TRUE(same(self_pairs_of(*kept, a), self_pairs_of(*brute_, a))) << name << " " << step;
    }
  }
}

TEST_F(BroadPhaseAdapters, KeepAStaticSurfaceUntilItsIdOrThicknessChanges) {
  for (const std::string& name : names_) {
    Surface cloth = flat_sheet(30, 30, 1.0), body = flat_sheet(20, 20, 1.0);
    cloth.thickness = 0.0103;  // No box just touches another.
    body.static_id = 77;
    auto kept = make(name);
    const CandidatePairs first = pairs_of(*kept, cloth, body);
    EXPECT_TRUE(same(first, pairs_of(*brute_, cloth, body))) << name;
    for (auto* xs : {&body.x_t0, &body.x_t1})
      for (Vec3& x : *xs) x.z() += 10.0;
    EXPECT_TRUE(same(pairs_of(*kept, cloth, body), first)) << name << ": the promise is believed";
    body.static_id = 78;
    EXPECT_EQ(pairs_of(*kept, cloth, body).size(), 0u) << name;
    body.thickness = 10.0;
    EXPECT_TRUE(same(pairs_of(*kept, cloth, body), pairs_of(*brute_, cloth, body))) << name;
    body.static_id = 0;
    body.thickness = 0.0;
    for (auto* xs : {&body.x_t0, &body.x_t1})
      for (Vec3& x : *xs) x.z() -= 10.0;
    EXPECT_TRUE(same(pairs_of(*kept, cloth, body), first)) << name;
  }
}

TEST_F(BroadPhaseAdapters, NameTheVertexThatIsNotFinite) {
  for (const std::string& name : names_) {
    auto detector = make(name);
    Surface s = flat_sheet(20, 20, 1.0);
    self_pairs_of(*detector, s);
    s.x_t1[137].y() = std::nan("");
    EXPECT_NE(message_of(*detector, s).find("vertex 137"), std::string::npos) << name;
    s.x_t1[137].y() = 0.0;
    s.x_t0[440].x() = -std::numeric_limits<double>::infinity();
    EXPECT_NE(message_of(*detector, s).find("vertex 440"), std::string::npos) << name;
    const Surface good = flat_sheet(2, 2, 1.0);
    EXPECT_THROW(pairs_of(*detector, good, s), std::invalid_argument) << name;
    s.x_t0[440].x() = 1.0;
    EXPECT_TRUE(same(self_pairs_of(*detector, s), self_pairs_of(*brute_, s))) << name;
  }
}

TEST_F(BroadPhaseAdapters, StopAtTheBudgetAndCanBeUsedOn) {
  Random random(8);
  const Surface a = crumpled(random, 30, 0.15);
  const CandidatePairs all = self_pairs_of(*brute_, a);
  for (const std::string& name : names_)
    for (const int threads : {1, 2}) {
      const ThreadLimit limit(threads);
      auto detector = make(name);
      CandidatePairs out;
      detector->set_budget({.pairs = all.size() - 1});
      EXPECT_THROW(detector->find_self_pairs(a.view(), out), BudgetExceeded) << name;
      EXPECT_EQ(out.size(), 0u) << name;
      detector->set_budget({.pairs = all.size()});
      EXPECT_TRUE(same(self_pairs_of(*detector, a), all)) << name;
    }
}

namespace {

Query random_query(Random& random, ContactKind kind) {
  Query q{kind, {}, {}};
  for (int k = 0; k < 4; ++k) {
    q.x_t0[k] = random.vector(1.0);
    q.x_t1[k] = random.vector(1.0);
  }
  return q;
}

Query scaled(const Query& q, double factor, const Vec3& shift) {
  Query out = q;
  for (int k = 0; k < 4; ++k) {
    out.x_t0[k] = factor * q.x_t0[k] + shift;
    out.x_t1[k] = factor * q.x_t1[k] + shift;
  }
  return out;
}

/// A point, or an edge, that falls through the middle of a triangle, or across an edge.
Query falling(ContactKind kind, double from, double to) {
  Query q{kind, {}, {}};
  const auto stay = [&](int k, const Vec3& x) { q.x_t0[k] = q.x_t1[k] = x; };
  if (kind == ContactKind::point_triangle) {
    stay(1, {0, 0, 0});
    stay(2, {1, 0, 0});
    stay(3, {0, 1, 0});
    q.x_t0[0] = Vec3(0.25, 0.25, from);
    q.x_t1[0] = Vec3(0.25, 0.25, to);
  } else {
    stay(2, {-1, 0, 0});
    stay(3, {1, 0, 0});
    q.x_t0[0] = Vec3(0.1, -1, from);
    q.x_t0[1] = Vec3(0.1, 1, from);
    q.x_t1[0] = Vec3(0.1, -1, to);
    q.x_t1[1] = Vec3(0.1, 1, to);
  }
  return q;
}

constexpr ContactKind kKinds[] = {ContactKind::point_triangle, ContactKind::edge_edge};

class NarrowPhaseAdapters : public ::testing::Test {
 protected:
  void SetUp() override {
    if (names_.empty()) GTEST_SKIP() << "no library for a narrow phase was found";
  }
  std::unique_ptr<NarrowPhase> make(const std::string& name,
                                    const MethodOptions& options = {}) const {
    return registry_.at(name)(options);
  }

  const NarrowPhaseRegistry registry_ = methods_of_this_build().narrow_phases;
  const std::vector<std::string> names_ = built(registry_);
};

}  // namespace

TEST_F(NarrowPhaseAdapters, SeeAPlainHitWhenItHappensAndAPlainMiss) {
  for (const std::string& name : names_)
    for (const ContactKind kind : kKinds)
      for (const double size : {1e-6, 1e-3, 1.0, 1e3, 1e9}) {
        const auto method = make(name);
        double toi = -1.0;
        ASSERT_TRUE(method->collides(scaled(falling(kind, 0.3, -0.7), size, Vec3::Zero()), toi))
            << name << ", size " << size;
        EXPECT_NEAR(toi, 0.3, 2e-3) << name;
        EXPECT_FALSE(method->collides(scaled(falling(kind, 0.3, 0.01), size, Vec3::Zero()), toi))
            << name << ", size " << size;
        // Far motion of small primitives.
        ASSERT_TRUE(method->collides(scaled(falling(kind, 300, -700), size, Vec3::Zero()), toi))
            << name << ", size " << size;
        EXPECT_NEAR(toi, 0.3, 2e-3) << name;
      }
}

TEST_F(NarrowPhaseAdapters, ScaleAndPlaceChangeNoVerdict) {
  for (const std::string& name : names_) {
    const auto method = make(name);
    Random random(11);
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
      const Query query = random_query(random, kKinds[i % 2]);
      double toi = 0.0;
      const bool hit = method->collides(query, toi);
      hits += hit;
      // Powers of two change no digit.
      for (const double size : {0x1p-10, 0x1p10, 0x1p-300, 0x1p300})
        ASSERT_EQ(method->collides(scaled(query, size, Vec3::Zero()), toi), hit)
            << name << " query " << i << " scaled by " << size;
    }
    EXPECT_GT(hits, 100) << name;
  }
}

TEST_F(NarrowPhaseAdapters, AreWrongAsSeldomAsTheySay) {
  constexpr int queries = 20000;
  for (const std::string& name : names_) {
    const auto method = make(name), exact = make_ccd_exact();
    for (const double size : {1e-3, 1.0, 1e3}) {
      Random random(12);
      int hits = 0, misses = 0, alarms = 0, late = 0;
      for (int i = 0; i < queries; ++i) {
        const Query query = scaled(random_query(random, kKinds[i % 2]), size, random.vector(size));
        double toi = 0.0, true_toi = 0.0;
        const bool hit = method->collides(query, toi), truth = exact->collides(query, true_toi);
        hits += truth;
        misses += truth && !hit;
        alarms += hit && !truth;
        late += truth && hit && toi > true_toi + 2e-3;
      }
      std::cout << name << ", size " << size << ": " << misses << " misses of " << hits << " hits, "
                << alarms << " false alarms, " << late << " late by 0.002\n";
      EXPECT_GT(hits, queries / 50) << name;
      // A transversal hit between primitives of size one is seldom missed.
      EXPECT_LE(misses, hits / 100) << name << ", size " << size;
      EXPECT_LE(alarms, queries / 50) << name << ", size " << size;
      EXPECT_LE(late, hits / 50) << name << ", size " << size;
    }
  }
}

TEST_F(NarrowPhaseAdapters, EndOnNastyQueriesWithATimeInTheStep) {
  for (const std::string& name : names_) {
    const auto method = make(name);
    Random random(13);
    for (int i = 0; i < 4000; ++i) {
      Query query = random_query(random, kKinds[i % 2]);
      const int kind = i / 2 % 8;
      for (auto* x : {&query.x_t0, &query.x_t1})
        for (int k = 0; k < 4; ++k) {
          Vec3& v = (*x)[k];
          if (kind == 0) v.z() = 0.5;                                   // in one plane
          if (kind == 1) v = (2.0 * v).array().round();                 // touching
          if (kind == 2) v = query.x_t0[k];                             // at rest
          if (kind == 3 && k > 1) v = (*x)[1];                          // a point
          if (kind == 4) v *= std::pow(10.0, random.integer(-300, 0));  // tiny
          if (kind == 5) v *= 1e300;
          if (kind == 6) v = Vec3(v.x(), 0.0, 0.0);  // on one line
          if (kind == 7) v = (*x)[0];                // one point
        }
      double toi = 0.5;
      method->collides(query, toi);
      ASSERT_TRUE(toi >= 0.0 && toi <= 1.0) << name << " query " << i << ": " << toi;
    }
  }
}

TEST_F(NarrowPhaseAdapters, RefuseWhatIsNotFiniteAndWhatTheyCannotDo) {
  for (const std::string& name : names_) {
    Query query = falling(ContactKind::point_triangle, 1.0, -1.0);
    query.x_t1[2].y() = std::nan("");
    double toi = 0.0;
    EXPECT_THROW(make(name)->collides(query, toi), std::invalid_argument) << name;
    EXPECT_THROW(make(name, {{"min_separation", 0.01}}), std::invalid_argument) << name;
    EXPECT_FALSE(make(name)->traits().misses_nothing) << name;
    EXPECT_FALSE(make(name)->traits().limits.empty()) << name;
  }
}

}  // namespace selvedge::adapters_test
