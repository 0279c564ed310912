// SPDX-License-Identifier: MIT
//
// The C++ call that bench/python_overhead.py compares with the call from Python: reads a step of
// a cloth and a body from a file, and prints the milliseconds of each call of find_collisions.
//
// The file holds int64 n, m, b, k, then x0 and x1 (n,3) and the body (b,3) as doubles, then the
// triangles (m,3) and those of the body (k,3) as int32.
#include <selvedge/detection/find.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "bench.h"

namespace selvedge {
namespace find_collisions_bench {
namespace {

template <class T>
std::vector<T> read(std::ifstream& in, std::int64_t count) {
  if (count < 0) throw std::invalid_argument("the file has a negative count");
  std::vector<T> values(static_cast<std::size_t>(count));
  in.read(reinterpret_cast<char*>(values.data()),
          static_cast<std::streamsize>(values.size() * sizeof(T)));
  if (!in) throw std::invalid_argument("the file is too short");
  return values;
}

void print_times(const char* file, int calls) {
  std::ifstream in(file, std::ios::binary);
  const auto count = read<std::int64_t>(in, 4);
  const auto x0 = read<selvedge::Vec3>(in, count[0]), x1 = read<selvedge::Vec3>(in, count[0]);
  const auto body = read<selvedge::Vec3>(in, count[2]);
  const auto triangles = read<selvedge::Triangle>(in, count[1]);
  const auto body_triangles = read<selvedge::Triangle>(in, count[3]);
  std::size_t found = 0;
  for (int call = 0; call < calls; ++call) {
    const auto begin = std::chrono::steady_clock::now();
    const std::clock_t used = std::clock();
    found = selvedge::find_collisions({x0, x1, triangles}, {body, body, body_triangles}).size();
    const double processor = 1e3 * static_cast<double>(std::clock() - used) / CLOCKS_PER_SEC;
    const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - begin;
    std::printf("%.6f %.6f\n", ms.count(), processor);
  }
  std::printf("%zu\n", found);
}

}  // namespace
}  // namespace find_collisions_bench

int bench_find_collisions(int argc, char** argv) {
  using namespace find_collisions_bench;
  if (argc != 3) {
    std::fprintf(stderr, "bench find_collisions FILE CALLS\n");
    return 2;
  }
  print_times(argv[1], std::max(1, std::atoi(argv[2])));
  return 0;
}

}  // namespace selvedge
