// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/parallel.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge {

/// Elements (springs, hinges, triangles) sorted so that within one colour no two share a particle:
/// the elements of a colour may be worked on at the same time, and the result does not depend on
/// who works on which.
struct Coloring {
  std::vector<std::int32_t> order;       ///< element indices, colour by colour, ascending within
  std::vector<std::size_t> color_begin;  ///< colours + 1 offsets into `order`
};

/// First-fit colouring of elements of `arity` particles each, given one after the other in
/// `particle_of`. Deterministic; at most one colour more than the largest number of neighbours.
Coloring color_elements(std::span<const std::int32_t> particle_of, std::size_t arity,
                        std::size_t particles);

/// Calls body(begin, end) on ranges of the sorted elements, one colour after the other, the ranges
/// of one colour in parallel.
void for_each_color(std::span<const std::size_t> color_begin,
                    FunctionRef<void(std::size_t begin, std::size_t end)> body);

}  // namespace selvedge
