// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/parallel.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Elements (springs, hinges, triangles) grouped into chunks of neighbours, sorted by colour such
/// that two chunks of one colour share no particle. The chunks of a colour can therefore run in
/// parallel, each in its own order, and the result does not depend on the scheduling. Chunks rather
/// than single elements are coloured so that memory is accessed in order.
struct Coloring {
  std::vector<std::int32_t> order;  ///< element indices, sorted by colour, ascending within a chunk
  std::vector<std::size_t> color_begin;  ///< offsets into `order`, number of colours + 1
};

/// Elements per chunk. Only the last chunk may be shorter.
inline constexpr std::size_t kColorChunk = 512;

/// First-fit colouring of the chunks. `particle_of` lists the particles of the elements one after
/// the other, `arity` for each. Deterministic. Needs few colours if the elements of a chunk are
/// close together.
Coloring color_elements(std::span<const std::int32_t> particle_of, std::size_t arity,
                        std::size_t particles);

/// Calls body(begin, end) on the chunks of the sorted elements: colours run one after the other,
/// the chunks of one colour in parallel.
void for_each_color(std::span<const std::size_t> color_begin,
                    FunctionRef<void(std::size_t begin, std::size_t end)> body);

}  // namespace selvedge::detail
