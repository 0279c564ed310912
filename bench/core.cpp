// SPDX-License-Identifier: MIT
//
// Spring-force evaluations a second on one thread, for grids from the size of a cache to far beyond
// it: what a Hooke spring costs, and whether memory or arithmetic bounds it.
//   bench_core [--repeats 9]
#include <fmt/format.h>
#include <selvedge/core/force.h>
#include <selvedge/core/parallel.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>

namespace {

using selvedge::Vec3;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Least seconds of one call.
template <class Call>
double least_seconds(int repeats, int calls, const Call& call) {
  double least = 1e300;
  for (int r = 0; r < repeats; ++r) {
    const auto start = std::chrono::steady_clock::now();
    for (int c = 0; c < calls; ++c) call();
    least = std::min(least, seconds_since(start) / calls);
  }
  return least;
}

/// Bytes of springs and particles that one evaluation of all forces walks through.
double bytes_walked(const selvedge::ClothMesh& cloth) {
  return static_cast<double>(cloth.springs.size() * sizeof(selvedge::Spring) +
                             cloth.mass.size() * 3 * sizeof(Vec3));
}

void measure(int cells, int repeats) {
  const selvedge::ClothMesh cloth =
      selvedge::make_rectangular({1.0, 1.0, cells, cells}, selvedge::Material{});
  const std::size_t n = cloth.mass.size();
  std::vector<Vec3> x = cloth.surface.vertices, v(n, Vec3(0.1, 0.2, 0.3)), f(n, Vec3::Zero());
  for (std::size_t i = 0; i < n; ++i) x[i].z() = 0.05 * std::sin(20.0 * x[i].x());
  const auto forces = selvedge::make_internal_forces(cloth);
  constexpr double evaluations = 2e6;  // a repeat: long against the clock's grain
  const auto springs = static_cast<double>(cloth.springs.size());
  const int calls = std::max(1, static_cast<int>(evaluations / springs));
  const double hooke = least_seconds(repeats, calls, [&] {
    forces[0]->add_force({x, v, cloth.mass, 0.0}, f);
  });
  const double bending = least_seconds(repeats, calls, [&] {
    forces[1]->add_force({x, v, cloth.mass, 0.0}, f);
  });
  fmt::print("{:>9} {:>9} {:>12.1f} {:>10.2f} {:>9.1f} {:>12.1f}\n", n, cloth.springs.size(),
             1e-6 * springs / hooke, 1e9 * hooke / springs, 1e-9 * bytes_walked(cloth) / hooke,
             1e-6 * static_cast<double>(cloth.hinges.size()) / bending);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Spring forces a second, one thread"};
  int repeats = 9;
  app.add_option("--repeats", repeats, "Timings of which the least is taken")
      ->check(CLI::Range(1, 1000));
  CLI11_PARSE(app, argc, argv);
  const selvedge::ThreadLimit one(1);
  fmt::print("{:>9} {:>9} {:>12} {:>10} {:>9} {:>12}\n", "particles", "springs", "M springs/s",
             "ns/spring", "GB/s", "M hinges/s");
  for (const int cells : {20, 50, 100, 300, 1000}) measure(cells, repeats);
}
