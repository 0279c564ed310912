// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <cstdint>

namespace selvedge::narrowphase_detail {

/// Queries of one kind side by side: coordinate i of vertex k at [3 k + i], one column per query.
struct QueryBlock {
  static constexpr int kSize = 8;
  alignas(64) double x_t0[12][kSize];
  alignas(64) double x_t1[12][kSize];
};

/// Masks of the block's columns, bit j for column j.
struct FilterVerdict {
  std::uint32_t separated = 0;       ///< stage A: no collision
  std::uint32_t never_coplanar = 0;  ///< stage B: no collision; asked only where A did not decide
};

/// Stages A and B on all columns of the block.
FilterVerdict filter(const QueryBlock& block, bool edges);

enum class Verdict : std::uint8_t { no, yes, open };

/// The times [k, k + 1] / 2^m.
struct TimeBox {
  std::int64_t k = 0;
  int m = 0;
  bool monotonic = false;  ///< the coplanarity cubic is strictly so there: it has one root
};

/// Stage C. With `yes` the first contact is at the first root of the coplanarity cubic in `box`.
Verdict isolate(const Query& query, TimeBox& box);

}  // namespace selvedge::narrowphase_detail
