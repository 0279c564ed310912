// SPDX-License-Identifier: MIT
//
// Spring-force evaluations per second on one thread, for grids from cache size to far beyond it.
// They show the cost of a Hooke spring, and whether memory or arithmetic limits it. Also the cost
// of a step: explicit (symplectic Euler, one thread) with hinges and with Provot's springs only,
// and linearly implicit to a residual of 1e-3 on two threads. --bending: cost of bending by hinges
// and by the shape operator on triangle meshes.
//   bench core [--repeats 9] [--steps | --bending]
#include <fmt/format.h>
#include <selvedge/apps/command_line.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/core/solver/integrator.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>

#include "bench.h"

namespace selvedge {
namespace core_bench {
namespace {

using selvedge::seconds_since;
using selvedge::Vec3;

/// Shortest time of one call, s.
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

/// Bytes of springs and particles that one evaluation of all forces reads and writes.
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
  constexpr double evaluations = 2e6;  // per repeat; long compared with the clock resolution
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

/// A cloth that hangs by one side and swings, advanced by one method.
class Swing {
 public:
  Swing(const std::string& method, const selvedge::ClothMesh& cloth, double h) : h_(h) {
    const std::size_t n = cloth.mass.size();
    auto forces = selvedge::make_internal_forces(cloth);
    forces.push_back(selvedge::make_gravity({0.0, 0.0, -9.81}));
    const selvedge::ImplicitConfig solve{.tolerance = 1e-3};
    integrator_ = selvedge::integrators().at(method)(std::move(forces), n, solve);
    p_ = {cloth.surface.vertices, std::vector<Vec3>(n, Vec3::Zero()), cloth.mass, {}};
    for (std::size_t i = 0; i < n; ++i)
      p_.inv_mass.push_back(p_.x[i].y() > 0.4999 ? 0.0 : 1.0 / p_.mass[i]);
    mean_.assign(n, Vec3::Zero());
    v_ = mean_;
  }

  void begin() { integrator_->begin({p_, 0.0, h_}, {mean_, v_}); }
  int solve(double looser = 1.0) { return integrator_->solve({}, {mean_, v_}, looser).iterations; }
  void go_on() {
    for (std::size_t i = 0; i < p_.size(); ++i) p_.x[i] += h_ * mean_[i];
    p_.v.swap(mean_);
    mean_ = p_.v;
  }
  void step() {
    begin();
    solve();
    go_on();
  }
  /// Discards the warm start of the solver.
  void forget() { mean_ = p_.v; }

 private:
  double h_;
  std::unique_ptr<selvedge::Integrator> integrator_;
  selvedge::Particles p_;
  std::vector<Vec3> mean_, v_;
};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

template <class Call>
double seconds_of(const Call& call) {
  const auto start = std::chrono::steady_clock::now();
  call();
  return seconds_since(start);
}

/// Shortest time of one explicit step, s.
double explicit_seconds(const selvedge::ClothMesh& cloth, int repeats) {
  Swing swing("symplectic_euler", cloth, 1e-6);
  swing.step();
  return least_seconds(repeats, 1, [&] { swing.step(); });
}

/// Cost of the parts of a linearly implicit step to a relative residual of 1e-3, s.
struct ImplicitCost {
  double least = 0.0, median = 0.0;  // whole step
  double least_system = 0.0;
  double system = 0.0;     // forces, Jacobian and preconditioner, before the first iteration
  double iteration = 0.0;  // one conjugate-gradient iteration with its multigrid cycle
  int iterations = 0;      // in the last step
};

ImplicitCost implicit_cost(const selvedge::ClothMesh& cloth, int repeats) {
  constexpr double any_answer = 1e12;  // a tolerance so loose that the solver makes no iteration
  Swing swing("implicit_euler", cloth, 1.0 / 120.0);
  for (int i = 0; i < 2; ++i) swing.step();
  std::vector<double> steps, systems, iterations;
  ImplicitCost cost;
  for (int r = 0; r < repeats; ++r) {
    const double system = seconds_of([&] {
      swing.begin();
      swing.solve(any_answer);
    });
    swing.forget();
    const double step = seconds_of([&] {
      swing.begin();
      cost.iterations = swing.solve();
    });
    swing.go_on();
    steps.push_back(step);
    systems.push_back(system);
    iterations.push_back((step - system) / std::max(1, cost.iterations));
  }
  cost.least = *std::min_element(steps.begin(), steps.end());
  cost.median = median(steps);
  cost.least_system = *std::min_element(systems.begin(), systems.end());
  cost.system = median(systems);
  cost.iteration = median(iterations);
  return cost;
}

/// Memory bandwidth, bytes per second: a + s·b on `threads` threads, far beyond the caches.
double streamed_bytes_a_second(int repeats) {
  constexpr std::size_t n = 16u << 20, grain = 1u << 16;
  std::vector<double> a(n, 1.0), b(n, 2.0), c(n, 3.0);
  const double seconds = least_seconds(repeats, 1, [&] {
    selvedge::parallel_for(n, grain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) c[i] = a[i] + 0.5 * b[i];
    });
  });
  return 3.0 * sizeof(double) * n / seconds;
}

/// Bytes of the matrix that an iteration reads: once in double, twice in single precision.
double matrix_bytes(const selvedge::ClothMesh& cloth) {
  std::vector<selvedge::Edge> links;
  for (const auto& force : selvedge::make_internal_forces(cloth)) force->add_links(links);
  const selvedge::BlockMatrix matrix(cloth.mass.size(), std::move(links));
  constexpr double of_block = sizeof(selvedge::Mat3) + 2 * 9 * sizeof(float) + 3 * 4;
  return of_block * static_cast<double>(matrix.columns().size());
}

void print_explicit(int cells, int repeats) {
  const selvedge::GridConfig grid{1.0, 1.0, cells, cells};
  const selvedge::ClothMesh sheet = selvedge::make_rectangular(grid, selvedge::Material{});
  const selvedge::ClothMesh net = selvedge::make_spring_net(
      selvedge::SpringNet::rectangular, grid, {500.0, 500.0, 50.0}, selvedge::Material{});
  const double n = static_cast<double>(sheet.mass.size());
  const double with_hinges = explicit_seconds(sheet, repeats);
  const double springs = explicit_seconds(net, repeats);
  fmt::print("{:>9.0f} {:>12.3f} {:>12.3f} {:>12.1f} {:>12.1f}\n", n, 1e3 * with_hinges,
             1e3 * springs, 1e9 * with_hinges / n, 1e9 * springs / n);
  std::fflush(stdout);
}

void print_implicit(int cells, int repeats) {
  constexpr int fixed = 10;
  const selvedge::ClothMesh sheet =
      selvedge::make_rectangular({1.0, 1.0, cells, cells}, selvedge::Material{});
  const double n = static_cast<double>(sheet.mass.size());
  const ImplicitCost cost = implicit_cost(sheet, repeats);
  fmt::print(
      "{:>9.0f} {:>10.2f} {:>10.2f} {:>5} {:>12.0f} {:>12.0f} {:>12.1f} {:>12.0f} {:>8.1f}\n", n,
      1e3 * cost.least, 1e3 * cost.median, cost.iterations, 1e9 * cost.median / n,
      1e9 * cost.system / n, 1e9 * cost.iteration / n,
      1e9 * (cost.system + fixed * cost.iteration) / n,
      1e-9 * matrix_bytes(sheet) / cost.iteration);
  std::fflush(stdout);
}

void measure_steps(const std::vector<int>& cells, int repeats) {
  const auto often = [&](int c) { return c > 500 ? std::min(repeats, 3) : repeats; };
  {
    const selvedge::ThreadLimit one(1);
    fmt::print("\nExplicit (symplectic Euler), one thread; memory streams {:.1f} GB/s\n",
               1e-9 * streamed_bytes_a_second(3));
    fmt::print("{:>9} {:>12} {:>12} {:>12} {:>12}\n", "particles", "hinges ms", "net ms",
               "ns/particle", "net ns/p.");
    for (const int c : cells) print_explicit(c, often(c));
  }
  const selvedge::ThreadLimit two(2);
  fmt::print("\nLinearly implicit to a residual of 1e-3, two threads; memory streams {:.1f} GB/s\n",
             1e-9 * streamed_bytes_a_second(3));
  fmt::print("{:>9} {:>10} {:>10} {:>5} {:>12} {:>12} {:>12} {:>12} {:>8}\n", "particles", "min ms",
             "median ms", "iter.", "ns/particle", "system ns/p.", "iter. ns/p.", "10 it. ns/p.",
             "GB/s");
  for (const int c : cells) print_implicit(c, often(c));
}

/// A 1 m sheet of squares. The diagonals have one direction, alternate, or are random. "moved":
/// random diagonals, and inner vertices displaced by up to a fifth of a cell.
selvedge::TriangleMesh triangles_of(int cells, const std::string& diagonals) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> off(-0.2 / cells, 0.2 / cells);
  selvedge::TriangleMesh mesh;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i)
      mesh.vertices.emplace_back(double(i) / cells - 0.5, double(j) / cells - 0.5, 0.0);
  if (diagonals == "moved")
    for (Vec3& p : mesh.vertices)
      if (std::max(std::abs(p.x()), std::abs(p.y())) < 0.5 - 0.5 / cells)
        p += Vec3(off(random), off(random), 0.0);
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = j * (cells + 1) + i, b = a + 1, d = a + cells + 1, c = d + 1;
      const bool rises = diagonals == "one way" ||
                         (diagonals == "alternating" ? (i + j) % 2 == 0 : random() % 2 == 0);
      mesh.triangles.push_back(rises ? selvedge::Triangle{a, b, c} : selvedge::Triangle{a, b, d});
      mesh.triangles.push_back(rises ? selvedge::Triangle{a, c, d} : selvedge::Triangle{b, c, d});
    }
  return mesh;
}

/// Shortest times of the force, the energy and the Jacobian of all hinges, s.
std::array<double, 3> bending_seconds(const selvedge::ClothMesh& cloth, int repeats) {
  const std::size_t n = cloth.mass.size();
  std::vector<Vec3> x = cloth.surface.vertices, v(n, Vec3(0.1, 0.2, 0.3)), f(n, Vec3::Zero());
  for (Vec3& p : x) p.z() = 0.05 * std::sin(20.0 * p.x());
  const auto forces = selvedge::make_internal_forces(cloth);
  const selvedge::ForceState state{x, v, cloth.mass, 0.0};
  selvedge::Force& bending = *forces.at(1);
  std::vector<selvedge::Edge> links;
  bending.add_links(links);
  selvedge::BlockMatrix matrix(n, std::move(links));
  bending.bind(matrix);
  double energy = 0.0;
  return {least_seconds(repeats, 20, [&] { bending.add_force(state, f); }),
          least_seconds(repeats, 20, [&] { energy += bending.energy(state); }),
          least_seconds(repeats, 5, [&] { bending.add_jacobian(state, 0.01, matrix); })};
}

/// One thread; the minimum over all repeats.
void measure_bending(int cells, int repeats) {
  const selvedge::ThreadLimit one(1);
  fmt::print("{:>12} {:>15} {:>9} {:>12} {:>10} {:>11} {:>11} {:>12} {:>12} {:>12} {:>6}\n",
             "diagonals", "law", "hinges", "couples/h.", "ns/hinge", "energy ns", "jacob. ms",
             "explicit ms", "system ms", "implicit ms", "iter.");
  for (const std::string diagonals : {"one way", "alternating", "random", "moved"})
    for (const bool plate : {false, true}) {
      selvedge::Material material;
      material.bending_law = plate ? "shape_operator" : "hinge";
      const selvedge::TriangleMesh mesh = triangles_of(cells, diagonals);
      const selvedge::ClothMesh cloth = selvedge::make_from_mesh(mesh, mesh, material);
      const auto hinges = static_cast<double>(cloth.hinges.size());
      const auto [force, energy, jacobian] = bending_seconds(cloth, repeats);
      const double step = explicit_seconds(cloth, 5 * repeats);
      const ImplicitCost cost = implicit_cost(cloth, repeats);
      fmt::print(
          "{:>12} {:>15} {:>9} {:>12.1f} {:>10.1f} {:>11.1f} {:>11.2f} {:>12.3f} {:>12.2f} "
          "{:>12.2f} {:>6}\n",
          diagonals, plate ? "shape_operator" : "hinge", cloth.hinges.size(),
          2.0 * static_cast<double>(cloth.couples.size()) / hinges, 1e9 * force / hinges,
          1e9 * energy / hinges, 1e3 * jacobian, 1e3 * step, 1e3 * cost.least_system,
          1e3 * cost.least, cost.iterations);
      std::fflush(stdout);
    }
}

}  // namespace
}  // namespace core_bench

int bench_core(int argc, char** argv) {
  using namespace core_bench;
  selvedge::CommandLine app("Spring forces per second, one thread");
  int repeats = 9;
  app.option("--repeats", repeats, "Repeats; the minimum is taken").range(1, 1000);
  bool steps_only = false;
  app.flag("--steps", steps_only, "Measure only steps");
  std::vector<int> cells{99, 316, 999};
  app.option("--cells", cells, "Cells per side of the cloth for steps").range(1, 3000);
  bool bending_only = false;
  app.flag("--bending", bending_only, "Measure only bending of triangles, at the first size");
  if (const auto code = app.parse(argc, argv)) return *code;
  if (bending_only) {
    measure_bending(cells.front(), repeats);
    return 0;
  }
  if (!steps_only) {
    const selvedge::ThreadLimit one(1);
    fmt::print("{:>9} {:>9} {:>12} {:>10} {:>9} {:>12}\n", "particles", "springs", "M springs/s",
               "ns/spring", "GB/s", "M hinges/s");
    for (const int cells : {20, 50, 100, 300, 1000}) measure(cells, repeats);
  }
  measure_steps(cells, repeats);
  return 0;
}

}  // namespace selvedge
