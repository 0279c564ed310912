// SPDX-License-Identifier: MIT
// Surfaces with parts of very different sizes: floats about one origin do not tell the small part's
// boxes apart, the maps by quantiles do.
#include <gtest/gtest.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/resolution.h>
#include <selvedge/core/base/types.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "owned_surface.h"

namespace selvedge::resolution_test {
using detail::QuantileMap;

namespace {

using Surface = OwnedSurface;

/// Two sheets of n x n cells, crumpled and moving, the second so many times smaller and inside the
/// first.
Surface with_a_small_part(int n, double times, unsigned seed) {
  std::mt19937 engine(seed);
  const auto random = [&](double r) {
    std::uniform_real_distribution<double> u(-r, r);
    const double x = u(engine), y = u(engine), z = u(engine);
    return Vec3(x, y, z);
  };
  Surface s;
  for (const double scale : {1.0, 1.0 / times}) {
    const auto first = static_cast<std::int32_t>(s.x_t0.size());
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const Vec3 x(std::remainder(2.3 * i / n, 1.0), std::remainder(1.7 * j / n, 1.0), 0.4);
        s.x_t0.push_back(Vec3(0.3, 0.2, 0.1) + scale * (x + random(0.3 / n)));
        s.x_t1.push_back(s.x_t0.back() + scale * random(0.1 / n));
      }
    const auto at = [&](int i, int j) { return first + j * (n + 1) + i; };
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        s.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
        s.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      }
  }
  s.edges = unique_edges(s.triangles);
  s.thickness = 1e-3 / times;
  return s;
}

TEST(QuantileMap, IsMonotoneWhateverItsSamples) {
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int round = 0; round < 200; ++round) {
    std::vector<double> samples(static_cast<std::size_t>(round) * 3);
    const double scale = std::pow(10.0, 12.0 * unit(engine));
    for (double& s : samples)
      s = unit(engine) < 0.0 ? scale * unit(engine) : 1.0 + 1e-9 * scale * unit(engine);
    const QuantileMap map(samples);
    std::vector<double> asked = samples;
    for (const double s : samples) {
      asked.push_back(std::nextafter(s, 1e300));
      asked.push_back(std::nextafter(s, -1e300));
      asked.push_back(3.0 * s);
    }
    for (const double s : {0.0, 1e300, -1e300, 5e-324}) asked.push_back(s);
    std::sort(asked.begin(), asked.end());
    for (std::size_t i = 1; i < asked.size(); ++i)
      ASSERT_LE(map(asked[i - 1]), map(asked[i])) << asked[i - 1] << " and " << asked[i];
  }
}

TEST(QuantileMap, GivesASmallPartTheRangeThatItsShareDeserves) {
  std::vector<double> samples;
  for (int i = 0; i <= 1000; ++i) {
    samples.push_back(1e-3 * i);
    samples.push_back(0.7 + 1e-12 * i);
  }
  const QuantileMap map(samples);
  const double whole = map(1.0) - map(0.0), part = map(0.7 + 1e-9) - map(0.7);
  EXPECT_GT(part, 0.45 * whole);
  EXPECT_LT(part, 0.55 * whole);
}

TEST(Resolution, OfASmallPartIsInTheMapsAlone) {
  const Surface s = with_a_small_part(40, 1e7, 3);
  const std::vector<detail::DoubleBox> sample = detail::sample_boxes(s.view());
  const auto shifted = [](int k, double x) { return x - (k == 0 ? -1.0 : 0.5); };
  EXPECT_GE(detail::count_unresolved(sample, shifted), static_cast<int>(sample.size()) / 2 - 1);
  constexpr std::array<std::array<int, 3>, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const std::vector<QuantileMap> maps = detail::quantile_maps(axes, s.x_t0, {});
  const auto mapped = [&](int k, double x) { return maps[k](x); };
  EXPECT_LT(detail::count_unresolved(sample, mapped), detail::kWorthAnotherMap);
}

TEST(Resolution, EveryDetectorFindsTheSamePairsInPartsOfAnySize) {
  for (const double times : {1e2, 1e5, 1e8, 1e11}) {
    const Surface s = with_a_small_part(12, times, 7);
    CandidatePairs expected;
    broad_phases().at("brute_force")()->find_self_pairs(s.view(), expected);
    ASSERT_GT(expected.edge_edge.size(), 2000u);
    for (const auto& [name, make] : broad_phases()) {
      const auto detector = make();
      const BroadPhaseTraits traits = detector->traits();
      if (traits.pairs != PairSet::boxes || !traits.self) continue;
      for (int repeat = 0; repeat < 2; ++repeat) {  // the second time with what was kept
        CandidatePairs found;
        detector->find_self_pairs(s.view(), found);
        EXPECT_EQ(found.point_triangle, expected.point_triangle) << name << ", " << times;
        EXPECT_EQ(found.edge_edge, expected.edge_edge) << name << ", " << times;
      }
    }
  }
}

// Without maps the small part's triangles are all compared with each other: hundreds of times as
// much.
TEST(Resolution, ASmallPartCostsLittleMoreThanALargeOne) {
  constexpr int n = 60;
  constexpr double most = 12.0;  // as it is about twice, much is left to noise
  const Surface alike = with_a_small_part(n, 1.0, 4), small = with_a_small_part(n, 1e9, 4);
  for (const char* name : {"bvh_aabb", "bvh_kdop14", "hash_grid", "uniform_grid", "voxel"}) {
    const auto detector = broad_phases().at(name)();
    const auto seconds = [&](const Surface& s) {
      double least = std::numeric_limits<double>::max();
      CandidatePairs out;
      for (int repeat = 0; repeat < 3; ++repeat) {
        detector->find_self_pairs(s.view(), out);
        const BroadPhaseCost cost = detector->last_cost();
        least = std::min(least, cost.build_s + cost.refit_s + cost.query_s);
      }
      return least;
    };
    const double usual = seconds(alike), mixed = seconds(small);
    EXPECT_LT(mixed, most * usual) << name;
  }
}

}  // namespace

}  // namespace selvedge::resolution_test
