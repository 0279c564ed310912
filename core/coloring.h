// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/parallel.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge {

/// Elements (springs, hinges, triangles) in chunks of neighbours, the chunks sorted so that within
/// one colour no two share a particle: the chunks of a colour may be worked on at the same time,
/// each by itself in order, and the result does not depend on who works on which. Chunks, not
/// single elements, are coloured, so that memory is walked through in order.
struct Coloring {
  std::vector<std::int32_t> order;       ///< element indices, colour by colour, ascending within
  std::vector<std::size_t> color_begin;  ///< colours + 1 offsets into `order`
};

/// Elements per chunk; only the last chunk of all may be shorter.
inline constexpr std::size_t color_chunk = 512;

/// First-fit colouring of the chunks of elements of `arity` particles each, given one after the
/// other in `particle_of`. Deterministic. Few colours where the elements of a chunk lie together.
Coloring color_elements(std::span<const std::int32_t> particle_of, std::size_t arity,
                        std::size_t particles);

/// Calls body(begin, end) on the chunks of the sorted elements, one colour after the other, the
/// chunks of one colour in parallel.
void for_each_color(std::span<const std::size_t> color_begin,
                    FunctionRef<void(std::size_t begin, std::size_t end)> body);

}  // namespace selvedge
