// SPDX-License-Identifier: MIT
#include <selvedge/core/detail/block_elements.h>

namespace selvedge::detail {

BlockElements blocks_of(std::span<const std::int32_t> particle_of, std::size_t arity,
                        const BlockMatrix& matrix) {
  std::vector<std::int32_t> slots;  // per entry
  slots.reserve(arity * particle_of.size());
  for (std::size_t c = 0; c < particle_of.size(); ++c)
    for (std::size_t k = 0; k < arity; ++k)
      slots.push_back(matrix.slot(particle_of[c], particle_of[c / arity * arity + k]));
  std::vector<std::uint32_t> next(matrix.values().size() + 1, 0);
  for (const std::int32_t slot : slots) ++next[static_cast<std::size_t>(slot) + 1];
  BlockElements all;
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
