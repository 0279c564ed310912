// SPDX-License-Identifier: MIT
// The uniform grid of the survey [MozafaryPayvandy2016], after Shou et al. 2013: the side of a cell
// is the typical edge length, cells hold the triangles, and a primitive that moves through a cell
// is tested against its contents. Conservative: reports the same pairs as brute force.
//
// Deviations from the survey. The side is the median instead of the mean of the swept edges of both
// surfaces, because a few vertices that move far would change the mean. A primitive is stored only
// in the cell of its lower corner, and queries also search the cells around (see GridLevel), so no
// pair is found twice. Primitives of less than half a cell or more than two cells are kept in finer
// and coarser grids. The table repeats in space, with at most four slots per primitive; the
// survey's table covers the body's box. Memory and time thus stay bounded however far one vertex
// moves.
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/grid_engine.h>

namespace selvedge {
namespace {

using detail::Cell;

/// A table of cells that repeats along each axis after a power of two cells. A row along x is
/// contiguous. Cells that share a slot are at least eight cells apart, farther than a search
/// reaches, so that comparing coordinates distinguishes them.
class RepeatingTable {
 public:
  static constexpr double kStretch = 1.5;  // the fastest of 0.75, 1, 1.5 and 2 on two scenes
  static constexpr bool kTagged = false;

  std::size_t fit(const Cell& min, const Cell& max, std::size_t most_slots) {
    constexpr int least_bits = 3;
    std::array<int, 3> bits;
    for (int k = 0; k < 3; ++k)
      bits[k] = static_cast<int>(
          std::bit_width(static_cast<std::uint32_t>(max[k]) - static_cast<std::uint32_t>(min[k])));
    const auto slots = [&] { return std::size_t{1} << (bits[0] + bits[1] + bits[2]); };
    const auto longest = [&] { return std::max_element(bits.begin(), bits.end()); };
    // Two bits at once would be too many for a size_t only where one axis has 31.
    while (*longest() > least_bits && (bits[0] + bits[1] + bits[2] > 60 || slots() > most_slots))
      --*longest();
    for (int k = 0; k < 3; ++k) mask_[k] = (1u << bits[k]) - 1;
    shift_y_ = bits[0];
    shift_z_ = bits[0] + bits[1];
    return slots();
  }

  std::uint32_t slot(const Cell& c) const {
    return row(c) | (static_cast<std::uint32_t>(c[0]) & mask_[0]);
  }
  std::uint32_t tag(const Cell&) const { return 0; }

  template <class Visit>
  void each_run(const Cell& min, const Cell& max, Visit visit) const {
    if (min[0] > max[0]) return;
    const std::uint32_t base = row(min);
    const std::uint32_t first = static_cast<std::uint32_t>(min[0]) & mask_[0];
    const std::uint32_t last = static_cast<std::uint32_t>(max[0]) & mask_[0];
    if (first <= last) return visit(base | first, base | last, 0);
    visit(base | first, base | mask_[0], 0);
    visit(base, base | last, 0);
  }

 private:
  std::uint32_t row(const Cell& c) const {
    return (static_cast<std::uint32_t>(c[1]) & mask_[1]) << shift_y_ |
           (static_cast<std::uint32_t>(c[2]) & mask_[2]) << shift_z_;
  }

  std::array<std::uint32_t, 3> mask_{};
  int shift_y_ = 0, shift_z_ = 0;
};

}  // namespace

std::unique_ptr<BroadPhase> make_uniform_grid(const CellGridConfig& config) {
  return std::make_unique<detail::BoxPairDetector<detail::GridEngine<RepeatingTable>>>(
      BroadPhaseTraits{.source = "cells of the size of a typical edge, coarser ones for larger "
                                 "primitives; Shou et al. 2013"},
      detail::GridEngine<RepeatingTable>(detail::checked_cell(config.cell, "uniform_grid")));
}

void register_uniform_grid(BroadPhaseRegistry& registry) {
  registry.add("uniform_grid", {detail::cell_option()},
               [](const MethodOptions& o) { return make_uniform_grid({.cell = o["cell"]}); });
}

}  // namespace selvedge
