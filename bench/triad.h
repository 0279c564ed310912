// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/parallel.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <memory>

/// Bandwidth of the memory, B/s, on the threads that the library uses: the best of ten passes of
/// a = b + s c over arrays of 128 MB. As in STREAM (McCalpin, Memory bandwidth and machine balance
/// in current high performance computers, 1995), a pass counts 24 bytes per element; the read of
/// `a` before it is written does not count.
inline double triad_bandwidth() {
  constexpr std::size_t n = std::size_t{1} << 24, grain = std::size_t{1} << 16;
  constexpr int passes = 10;
  // Without initial values, so that the threads that use a page also touch it first.
  const std::unique_ptr<double[]> a(new double[n]), b(new double[n]), c(new double[n]);
  selvedge::parallel_for(n, grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      a[i] = 0.0;
      b[i] = 1.0;
      c[i] = 2.0;
    }
  });
  double best = 0.0;
  for (int pass = 0; pass < passes; ++pass) {
    const auto start = std::chrono::steady_clock::now();
    selvedge::parallel_for(n, grain, [&, s = 3.0 + pass](std::size_t begin, std::size_t end) {
      double* const to = a.get();
      const double *const x = b.get(), *const y = c.get();
      for (std::size_t i = begin; i < end; ++i) to[i] = x[i] + s * y[i];
    });
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    best = std::max(best, 3.0 * sizeof(double) * static_cast<double>(n) / time.count());
  }
  return best;
}
