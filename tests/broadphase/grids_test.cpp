// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/box_pairs.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/types.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <random>
#include <stdexcept>

#include "broad_phase_trial.h"

namespace selvedge::grids_test {
namespace {

using Surface = OwnedSurface;

Surface any_sheet(Random& random) {
  const int n = random.integer(1, 9);
  return flat_sheet(n, n, 1.0);
}

/// Folds a surface into a box, then moves every vertex a little.
Surface crumpled(Surface s, Random& random, double box, double motion) {
  for (std::size_t i = 0; i < s.x_t0.size(); ++i) {
    Vec3& x = s.x_t0[i];
    for (int k = 0; k < 3; ++k)
      x[k] = std::abs(std::remainder(x[k] * (1.0 + 0.3 * k) + x[(k + 1) % 3], 2 * box)) +
             random.uniform(0.0, 0.05 * box);
    s.x_t1[i] = x + random.vector(motion);
  }
  return s;
}

/// Any triangles on any points, in steps of very different size.
Surface soup(Random& random, int vertices, int triangles) {
  Surface s;
  for (int i = 0; i < vertices; ++i) s.x_t0.push_back(random.vector(1.0));
  s.x_t1 = s.x_t0;
  for (Vec3& x : s.x_t1) x += random.vector(std::pow(10.0, random.integer(-8, 0)));
  const auto any = [&] { return random.integer(0, vertices - 1); };
  for (int i = 0; i < triangles && vertices > 0; ++i) s.triangles.push_back({any(), any(), any()});
  for (int i = 0; i < triangles && vertices > 0; ++i) s.edges.push_back({any(), any()});
  return s;
}

void transform(Surface& s, double scale, const Vec3& shift) {
  for (auto* xs : {&s.x_t0, &s.x_t1})
    for (Vec3& x : *xs) x = scale * x + shift;
}

/// Scenes that grids find hard.
Surface hard_scene(int kind, unsigned seed) {
  Random random(seed);
  Surface s = crumpled(flat_sheet(11, 11, 1.0), random, 0.3, 0.01);
  switch (kind) {
    case 0:
      return soup(random, random.integer(0, 40), random.integer(0, 60));
    case 1:  // Spikes of many sizes.
      for (int i = 0; i < 6; ++i)
        s.x_t1[random.integer(0, 143)] += random.vector(std::pow(10.0, random.integer(-1, 6)));
      break;
    case 2:  // One vertex is far away all the time.
      s.x_t0[77] = s.x_t1[77] = Vec3(1e9, -1e12, 3e200);
      break;
    case 3:
      transform(s, 1.0, Vec3(1e6, -1e6, 1e6));
      break;
    case 4:  // All in a plane.
      s = flat_sheet(12, 12, 1.0);
      break;
    case 5:  // All in a point.
      transform(s, 0.0, Vec3(0.25, -3, 1e4));
      break;
    case 6:  // Beside it one of a hundred thousandth of its size.
    {
      Surface small = s;
      transform(small, 1e-5, Vec3(0.1, 0.1, 0.1));
      const auto n = static_cast<std::int32_t>(s.x_t0.size());
      s.x_t0.insert(s.x_t0.end(), small.x_t0.begin(), small.x_t0.end());
      s.x_t1.insert(s.x_t1.end(), small.x_t1.begin(), small.x_t1.end());
      for (const Triangle& t : small.triangles)
        s.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
      s.edges = unique_edges(s.triangles);
      break;
    }
    case 7:  // Integers: boxes that just touch, and boxes without volume.
      s = soup(random, 40, 60);
      for (Vec3& x : s.x_t0) x = (3.0 * x).array().round();
      s.x_t1 = s.x_t0;
      return s;
    case 8:  // Sizes over many orders of magnitude, up to where floats overflow.
      for (Vec3& x : s.x_t0) x *= std::pow(10.0, random.integer(-30, 200));
      s.x_t1 = s.x_t0;
      break;
    case 9:  // A triangle, or a part of one.
      s = flat_sheet(1, 1, 1.0);
      s.triangles.resize(1);
      s.edges.resize(random.integer(0, 3));
      break;
    case 10:  // Far below a float.
      transform(s, 1e-60, Vec3::Zero());
      break;
    default:
      break;
  }
  s.thickness = random.integer(0, 2) * 0.01;
  return s;
}
constexpr int kHardScenes = 12;

/// How much longer a call on a nasty scene may take than one on a plain scene. Without the levels
/// it would be thousands; measured alone it is at most three, but tests run beside others.
constexpr double kMostSlowdown = 10.0;

/// The detectors that this file is about, by name and setting.
std::map<std::string, std::unique_ptr<BroadPhase>> detectors(const std::vector<double>& cells) {
  std::map<std::string, std::unique_ptr<BroadPhase>> all;
  for (const double cell : cells) {
    all["uniform_grid " + std::to_string(cell)] = make_uniform_grid({.cell = cell});
    all["hash_grid " + std::to_string(cell)] = make_hash_grid({.cell = cell});
    all["voxel " + std::to_string(cell)] = make_voxel({.voxel = 1.7 * cell});
    all["sweep_and_prune " + std::to_string(cell)] = make_sweep_and_prune({.column = 4.0 * cell});
  }
  all["sweep_and_prune along one axis"] = make_sweep_and_prune({.column = 0.0});
  return all;
}

/// The plainest engine: it shows what the frame asks for, and counts the structures it makes.
struct AllPairsEngine {
  using DoubleBox = detail::DoubleBox;
  struct Structure {
    const std::vector<DoubleBox>* boxes = nullptr;
    std::size_t bytes() const { return 0; }
  };

  int* builds;
  bool keeps = true;

  bool prepare(const detail::SurfaceBoxes&, const detail::SurfaceBoxes*) { return keeps; }
  void build(const std::vector<DoubleBox>& boxes, Structure& out) {
    ++*builds;
    out.boxes = &boxes;
  }
  void find_pairs(Structure& a, Structure& b, detail::PairParts& out) {
    find(*a.boxes, *b.boxes, false, out);
  }
  void find_self_pairs(Structure& a, detail::PairParts& out) {
    find(*a.boxes, *a.boxes, true, out);
  }
  std::size_t bytes() const { return 0; }

  /// Backwards and spread over the parts: the frame must sort.
  static void find(const std::vector<DoubleBox>& a, const std::vector<DoubleBox>& b, bool self,
                   detail::PairParts& out) {
    for (std::size_t i = a.size(); i-- > 0;)
      for (std::size_t j = b.size(); j-- > 0;)
        if ((!self || j < i) && detail::overlap(a[i], b[j]))
          out.add((i + j) % detail::kBoxPairParts, static_cast<std::int32_t>(i),
                  static_cast<std::int32_t>(j));
  }
};

}  // namespace

TEST(BoxPairDetector, MakesBruteForceOfAnyExactEngine) {
  Random random(1);
  auto brute = make_brute_force();
  int builds = 0;
  detail::BoxPairDetector detector({}, AllPairsEngine{&builds});
  for (int scene = 0; scene < 20; ++scene) {
    Surface a = crumpled(any_sheet(random), random, 0.3, 0.02);
    Surface b = crumpled(any_sheet(random), random, 0.3, 0.02);
    a.thickness = 0.01 * random.integer(0, 2);
    ASSERT_TRUE(same(self_pairs_of(detector, a), self_pairs_of(*brute, a)));
    ASSERT_TRUE(same(pairs_of(detector, a, b), pairs_of(*brute, a, b)));
  }
}

TEST(BoxPairDetector, KeepsTheStructuresOfAStaticSurface) {
  Random random(2);
  Surface cloth = flat_sheet(6, 6, 1.0), body = flat_sheet(5, 5, 1.0);
  body.static_id = 7;
  for (const bool keeps : {true, false}) {
    int builds = 0;
    detail::BoxPairDetector detector({}, AllPairsEngine{&builds, keeps});
    const CandidatePairs first = pairs_of(detector, cloth, body);
    EXPECT_EQ(builds, 6);
    self_pairs_of(detector, cloth);
    pairs_of(detector, cloth, body);
    EXPECT_EQ(builds, keeps ? 12 : 15);
    for (Vec3& x : body.x_t1) x.z() += 5.0;  // The promise is believed.
    for (Vec3& x : body.x_t0) x.z() += 5.0;
    EXPECT_TRUE(same(pairs_of(detector, cloth, body), first));
    body.thickness = 6.0;
    EXPECT_GT(pairs_of(detector, cloth, body).size(), first.size());
    body.static_id = 8;
    body.thickness = 0.0;
    EXPECT_EQ(pairs_of(detector, cloth, body).size(), 0u);
    for (Vec3& x : body.x_t1) x.z() -= 5.0;
    for (Vec3& x : body.x_t0) x.z() -= 5.0;
  }
}

TEST(Grids, FindWhatBruteForceFindsOnHardScenes) {
  auto brute = make_brute_force();
  const auto all = detectors({1e-3, 1.0, 3.0, 1e4});
  std::size_t found = 0;
  for (unsigned seed = 0; seed < 48; ++seed) {
    const Surface a = hard_scene(seed % kHardScenes, seed);
    const Surface b =
        hard_scene(static_cast<int>(seed * 7 / kHardScenes) % kHardScenes, seed + 1000);
    const CandidatePairs self = self_pairs_of(*brute, a), pairs = pairs_of(*brute, a, b);
    for (const auto& [name, detector] : all) {
      ASSERT_TRUE(same(self_pairs_of(*detector, a), self)) << name << ", seed " << seed;
      ASSERT_TRUE(same(pairs_of(*detector, a, b), pairs)) << name << ", seed " << seed;
    }
    found += self.size() + pairs.size();
  }
  EXPECT_GT(found, 100000u);
}

TEST(Grids, FindTheSameWithAnyNumberOfThreads) {
  Random random(3);
  const Surface a = crumpled(flat_sheet(24, 24, 1.0), random, 0.2, 0.01);
  const Surface b = crumpled(flat_sheet(20, 20, 1.0), random, 0.25, 0.01);
  auto brute = make_brute_force();
  const CandidatePairs self = self_pairs_of(*brute, a), pairs = pairs_of(*brute, a, b);
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    for (const auto& [name, detector] : detectors({1.0}))
      for (int call = 0; call < 2; ++call) {
        EXPECT_TRUE(same(self_pairs_of(*detector, a), self)) << name << ", " << threads;
        EXPECT_TRUE(same(pairs_of(*detector, a, b), pairs)) << name << ", " << threads;
      }
  }
}

TEST(Grids, SpikesCostLittleTimeAndNoMemory) {
  Random random(4);
  const Surface calm = crumpled(flat_sheet(50, 50, 1.0), random, 0.3, 0.001);
  for (const auto& [name, detector] : detectors({1.0})) {
    CandidatePairs out;
    const auto cost_of = [&](const Surface& s) {
      BroadPhaseCost least{.query_s = std::numeric_limits<double>::max()};
      for (int repeat = 0; repeat < 3; ++repeat) {
        detector->find_self_pairs(s.view(), out);
        const BroadPhaseCost cost = detector->last_cost();
        if (cost.build_s + cost.query_s < least.build_s + least.query_s) least = cost;
      }
      return least;
    };
    const BroadPhaseCost normal = cost_of(calm);
    const std::size_t normal_pairs = out.size();
    for (const double far : {1.0, 10.0, 1000.0, 1e6}) {
      Surface s = calm;
      s.x_t1[1275] += far * Vec3(0.6, 0.48, 0.64);
      const BroadPhaseCost cost = cost_of(s);
      // A spike's pairs are real: its six triangles cover a part of the cloth.
      const double more = static_cast<double>(out.size()) / static_cast<double>(normal_pairs);
      EXPECT_LT(cost.build_s + cost.query_s,
                kMostSlowdown * std::max(1.0, more) * (normal.build_s + normal.query_s))
          << name << ", " << far << " m";
      EXPECT_LT(cost.bytes, 2 * normal.bytes) << name << ", " << far << " m";
    }
  }
}

TEST(Grids, TwoMeshesOfVeryDifferentSizeCostLittleMoreThanTwoAlike) {
  Random random(5);
  const Surface large = crumpled(flat_sheet(40, 40, 1.0), random, 0.3, 0.001);
  Surface small = large;
  transform(small, 1e-5, Vec3(0.1, 0.1, 0.05));
  for (const auto& [name, detector] : detectors({1.0})) {
    CandidatePairs out;
    const auto seconds = [&](const Surface& a, const Surface& b) {
      double least = std::numeric_limits<double>::max();
      for (int repeat = 0; repeat < 3; ++repeat) {
        detector->find_pairs(a.view(), b.view(), out);
        least = std::min(least, detector->last_cost().build_s + detector->last_cost().query_s);
      }
      return least;
    };
    const double alike = seconds(large, large);
    EXPECT_LT(seconds(large, small), kMostSlowdown * alike) << name;
    EXPECT_LT(seconds(small, large), kMostSlowdown * alike) << name;
  }
}

TEST(Grids, RefuseACellThatIsNoLength) {
  for (const double cell : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(make_uniform_grid({.cell = cell}), std::invalid_argument);
    EXPECT_THROW(make_hash_grid({.cell = cell}), std::invalid_argument);
  }
  for (const double column : {-1.0, std::nan("")})
    EXPECT_THROW(make_sweep_and_prune({.column = column}), std::invalid_argument);
  EXPECT_THROW(make_voxel({.voxel = -1.0}), std::invalid_argument);
}

TEST(Voxel, TheSearchDoesNotPreferTheSmallest) {
  // Measured alone, the smallest takes twice as long as the best.
  Surface s = flat_sheet(80, 80, 1.0);
  Random random(6);
  for (Vec3& x : s.x_t1) x += random.vector(0.004);
  const std::vector<VoxelTrial> trials = search_voxel(s.view());
  ASSERT_EQ(trials.size(), 10u);
  for (const VoxelTrial& trial : trials)
    std::printf("voxel of %.1f typical extents: %6.2f ms, %5.1f MB\n", trial.voxel,
                1e3 * trial.seconds, 1e-6 * static_cast<double>(trial.bytes));
  EXPECT_TRUE(std::is_sorted(trials.begin(), trials.end(),
                             [](auto& x, auto& y) { return x.seconds < y.seconds; }));
  EXPECT_GT(trials.front().voxel, 0.5);
}

}  // namespace selvedge::grids_test
