// SPDX-License-Identifier: MIT
//
// Shared parts of the detector tests: random numbers, the pairs of a detector, and the comparison
// of two results.
#pragma once

#include <gtest/gtest.h>

#include <random>

#include "owned_surface.h"

namespace selvedge {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(engine_);
  }
  int integer(int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(engine_); }
  int below(std::size_t n) { return integer(0, static_cast<int>(n) - 1); }
  Vec3 vector(double r) { return {uniform(-r, r), uniform(-r, r), uniform(-r, r)}; }

 private:
  std::mt19937 engine_;
};

inline CandidatePairs pairs_of(BroadPhase& detector, const OwnedSurface& a, const OwnedSurface& b) {
  CandidatePairs out;
  detector.find_pairs(a.view(), b.view(), out);
  return out;
}

inline CandidatePairs self_pairs_of(BroadPhase& detector, const OwnedSurface& a) {
  CandidatePairs out;
  detector.find_self_pairs(a.view(), out);
  return out;
}

inline ::testing::AssertionResult same(const CandidatePairs& a, const CandidatePairs& b) {
  if (a.point_triangle == b.point_triangle && a.triangle_point == b.triangle_point &&
      a.edge_edge == b.edge_edge)
    return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << a.point_triangle.size() << "/" << a.triangle_point.size() << "/" << a.edge_edge.size()
         << " pairs against " << b.point_triangle.size() << "/" << b.triangle_point.size() << "/"
         << b.edge_edge.size();
}

}  // namespace selvedge
