// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/detail/block_elements.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

constexpr std::size_t kSlotGrain = 4096;  // particles of elements per task

}  // namespace

BlockElements blocks_of(std::span<const std::int32_t> particle_of, std::size_t arity,
                        const BlockMatrix& matrix) {
  std::vector<std::int32_t> slots(arity * particle_of.size());  // per entry
  parallel_for(particle_of.size(), kSlotGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t c = first; c < last; ++c)
      for (std::size_t k = 0; k < arity; ++k)
        slots[arity * c + k] = matrix.slot(particle_of[c], particle_of[c / arity * arity + k]);
  });
  std::vector<std::uint32_t> next(matrix.values().size() + 1, 0);
  for (const std::int32_t slot : slots) ++next[static_cast<std::size_t>(slot) + 1];
  BlockElements all;
  const auto used = next.size() - static_cast<std::size_t>(std::count(next.begin(), next.end(), 0));
  all.begin.reserve(used + 1);
  all.slot.reserve(used);
  for (std::size_t b = 0; b + 1 < next.size(); ++b) {
    next[b + 1] += next[b];
    if (next[b + 1] == next[b]) continue;
    all.begin.push_back(next[b + 1]);
    all.slot.push_back(static_cast<std::int32_t>(b));
  }
  all.entry.resize(slots.size());
  for (std::size_t e = 0; e < slots.size(); ++e)
    all.entry[next[slots[e]]++] = static_cast<std::uint32_t>(e);
  return all;
}

}  // namespace selvedge::detail
