// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/types.h>
#include <selvedge/core/cloth/detail/even_grain.h>

#include <cstddef>
#include <span>

namespace selvedge::detail {

/// Least number of particles per task: 5 µs of work.
inline constexpr std::size_t kParticles = 1024;

/// Sum of body(begin, end) over ranges of n particles.
template <class Body>
double sum_particles(std::size_t n, const Body& body) {
  return parallel_sum(n, even_grain(n, kParticles), body);
}

inline double dot(std::span<const Vec3> a, std::span<const Vec3> b) {
  return sum_particles(a.size(), [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) sum += a[i].dot(b[i]);
    return sum;
  });
}

/// Calls body(i) for each i < n, in parallel.
template <class Body>
void for_particles(std::size_t n, const Body& body) {
  parallel_for(n, even_grain(n, kParticles), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

}  // namespace selvedge::detail
