// SPDX-License-Identifier: MIT
//
// The mass-spring model against the rivals that the survey's abstract names: finite elements on the
// same mesh and a geometric drape (claim C27).
//   1. Strip: deflection of a cantilever in its plane, with an exact solution.
//   2. Drape: a cloth held by four corners. Error against finite elements on a mesh of four times
//   the
//      cells on a side, time until rest, and the time of one step.
//   bench rivals [--cells 16] [--repeats 3] [--markdown]
#include <selvedge/apps/command_line.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/solver/integrator.h>
#include <selvedge/lab/fabric_drape.h>
#include <selvedge/tests/cantilever.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "bench.h"
#include "table.h"

namespace selvedge {
namespace rivals_bench {
namespace {

const std::array<std::string, 3> kLaws{"hooke", "st_venant_kirchhoff", "corotated"};

std::string name_of(const std::string& law) { return law == "hooke" ? "springs" : law; }

// -- strip ----------------------------------------------------------------------------------------

/// Error of the deflection in percent.
double strip_error(const std::string& law, double poisson, std::int32_t rows) {
  testing::Cantilever strip;
  strip.poisson = poisson;
  Material material = strip.material(law);
  material.bending_stiffness = 0.0;
  const ClothMesh cloth =
      make_rectangular({strip.length, 2.0 * strip.half, 4 * rows, rows}, material);
  const ForceList forces = make_internal_forces(cloth);
  const auto u = strip.solve(cloth, *forces.front(), rows);
  const std::size_t row = cloth.mass.size() / (rows + 1);
  return 100.0 * (u[row * (rows / 2)].y() / strip.displacement(0.0, 0.0).y() - 1.0);
}

Table strip_table() {
  Table table({"model", "Poisson's ratio", "4 rows", "8 rows", "16 rows", "32 rows"});
  for (const double poisson : {0.0, 1.0 / 3.0, 0.45})
    for (const std::string law : {"hooke", "corotated"}) {
      std::vector<std::string> row{name_of(law), fmt::format("{:.2f}", poisson)};
      for (const std::int32_t rows : {4, 8, 16, 32})
        row.push_back(fmt::format("{:+.2f} %", strip_error(law, poisson, rows)));
      table.add(row);
    }
  return table;
}

// -- drape ----------------------------------------------------------------------------------------

constexpr double kSize = 1.0,
                 kSpan = 0.9;  // m, sides of the cloth and of the square of its corners

Material fabric(const std::string& law) {
  Material m;
  m.spring_damping = m.bending_damping = 0.05;
  m.bending_stiffness = 1e-4;
  m.stretch_law = law;
  return m;
}

std::vector<HeldVertex> corners(std::int32_t cells) {
  const double s = 0.5 * kSpan;
  const std::int32_t last = (cells + 1) * (cells + 1) - 1;
  return {{0, {-s, -s, 0}}, {cells, {s, -s, 0}}, {last - cells, {-s, s, 0}}, {last, {s, s, 0}}};
}

/// Of the processor, which other programs disturb less than those of the clock.
double seconds_since(std::clock_t start) {
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

struct Drape {
  std::vector<Vec3> x;
  double seconds = 0.0;
  int steps = 0;
};

Particles start(const ClothMesh& cloth, std::int32_t cells) {
  const std::size_t n = cloth.mass.size();
  Particles p{cloth.surface.vertices, std::vector<Vec3>(n, Vec3::Zero()), cloth.mass, {}};
  for (std::size_t i = 0; i < n; ++i) {
    p.inv_mass.push_back(1.0 / p.mass[i]);
    // A bowl, so that every model folds the same way.
    Vec3& x = p.x[i];
    const double bowl = (0.25 - x.x() * x.x()) + (0.25 - x.y() * x.y());
    x = Vec3(kSpan / kSize * x.x(), kSpan / kSize * x.y(), -0.4 * bowl);
  }
  for (const HeldVertex& h : corners(cells)) {
    p.x[h.vertex] = h.x;
    p.inv_mass[h.vertex] = 0.0;
  }
  return p;
}

/// Implicit steps with friction of the air until nothing moves.
Drape simulate(const std::string& law, std::int32_t cells) {
  const std::clock_t begin = std::clock();
  const ClothMesh cloth = make_rectangular({kSize, kSize, cells, cells}, fabric(law));
  ForceList forces = make_internal_forces(cloth);
  forces.push_back(make_gravity({0.0, 0.0, -9.81}));
  AirConfig air;
  air.viscous_drag = 1.0;
  const std::vector<double> areas(cloth.surface.triangles.size(),
                                  0.5 * kSize * kSize / cells / cells);
  forces.push_back(make_air_force(air, cloth.surface.triangles, areas, cloth.mass.size()));
  Particles p = start(cloth, cells);
  const auto integrator =
      integrators().at("implicit_euler")(std::move(forces), p.size(), ImplicitConfig{1e-5, 2000});
  constexpr double h = 1.0 / 60.0, at_rest = 1e-4;  // s, m/s
  constexpr int most = 1500, warm_up = 20;
  Drape drape;
  std::vector<Vec3> v;
  for (double speed = 1.0; drape.steps < most && (speed > at_rest || drape.steps < warm_up);) {
    const double time = drape.steps++ * h;
    integrator->begin({p, time, h}, {});
    v = p.v;
    integrator->solve({}, {v, {}}, 1.0);
    p.v = v;
    speed = 0.0;
    for (std::size_t i = 0; i < v.size(); ++i) {
      p.x[i] += h * v[i];
      speed = std::max(speed, v[i].norm());
    }
    integrator->accept({p.x, p.v, p.mass, time + h});
  }
  drape.x = std::move(p.x);
  drape.seconds = seconds_since(begin);
  return drape;
}

Drape hang(std::int32_t cells) {
  const std::clock_t begin = std::clock();
  const GeometricDrape drape =
      drape_geometrically({kSize, kSize, cells, cells}, corners(cells), {.tolerance = 1e-4});
  return {drape.shape.vertices, seconds_since(begin), drape.sweeps};
}

/// RMS distance of the vertices from those of a finer mesh, mm.
double distance(const std::vector<Vec3>& x, std::int32_t cells, const std::vector<Vec3>& fine,
                std::int32_t fine_cells) {
  const std::int32_t ratio = fine_cells / cells;
  double sum = 0.0;
  for (std::int32_t j = 0; j <= cells; ++j)
    for (std::int32_t i = 0; i <= cells; ++i)
      sum +=
          (x[j * (cells + 1) + i] - fine[j * ratio * (fine_cells + 1) + i * ratio]).squaredNorm();
  return 1e3 * std::sqrt(sum / static_cast<double>(x.size()));
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// A model with its times, which are taken in turns with those of the others.
struct Rival {
  std::string name;
  std::function<Drape()> make;
  Drape drape;
  std::vector<double> seconds;
};

std::vector<Rival> run_in_turns(std::int32_t cells, int repeats) {
  std::vector<Rival> rivals;
  for (const std::string& law : kLaws)
    rivals.push_back({name_of(law), [=] { return simulate(law, cells); }, {}, {}});
  rivals.push_back({"geometric", [=] { return hang(cells); }, {}, {}});
  for (int k = 0; k < repeats; ++k)
    for (Rival& rival : rivals) {
      rival.drape = rival.make();
      rival.seconds.push_back(rival.drape.seconds);
    }
  return rivals;
}

/// Median and range of the times of the springs over those of another model in the same turn.
std::string springs_over(const Rival& springs, const Rival& other) {
  std::vector<double> ratios;
  for (std::size_t k = 0; k < springs.seconds.size(); ++k)
    ratios.push_back(springs.seconds[k] / other.seconds[k]);
  const auto [least, most] = std::minmax_element(ratios.begin(), ratios.end());
  return fmt::format("{:.2f} ({:.2f} to {:.2f})", median(ratios), *least, *most);
}

Table drape_table(std::int32_t cells, int repeats) {
  constexpr std::int32_t finer = 4;
  Table table({"model", "cells", "error, mm", "time, s", "steps or sweeps", "ms per step",
               "springs' time over this"});
  const Drape reference = simulate("corotated", finer * cells);
  for (const std::int32_t n : {cells, 2 * cells}) {
    const std::vector<Rival> rivals = run_in_turns(n, repeats);
    for (const Rival& r : rivals) {
      const double seconds = median(r.seconds);
      table.add({r.name, std::to_string(n),
                 fmt::format("{:.1f}", distance(r.drape.x, n, reference.x, finer * cells)),
                 fmt::format("{:.3f}", seconds), std::to_string(r.drape.steps),
                 fmt::format("{:.2f}", 1e3 * seconds / std::max(1, r.drape.steps)),
                 springs_over(rivals.front(), r)});
    }
  }
  return table;
}

}  // namespace
}  // namespace rivals_bench

int bench_rivals(int argc, char** argv) {
  using namespace rivals_bench;
  CommandLine app("Springs, finite elements and a geometric drape");
  int cells = 16, repeats = 3;
  bool markdown = false;
  app.option("--cells", cells, "Cells on a side of the coarser mesh").range(4, 64);
  app.option("--repeats", repeats, "Repeats of each drape").range(1, 100);
  app.flag("--markdown", markdown, "Print tables for a page");
  if (const auto code = app.parse(argc, argv)) return *code;
  const ThreadLimit limit(1);
  for (const Table& table : {strip_table(), drape_table(cells, repeats)})
    fmt::print("{}\n", markdown ? table.markdown() : table.text());
  return 0;
}

}  // namespace selvedge
