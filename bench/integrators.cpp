// SPDX-License-Identifier: MIT
//
// Error against time of every integrator on a small cloth that swings from two corners without
// contacts. The error is that of positions after a quarter of a second, against Runge-Kutta 4 with
// a converged step length. The program also finds the longest stable step of each integrator by
// bisection on an undamped and a damped oscillator (survey section 5.5, claims on its Fig. 27 and
// Table VII).
//   bench integrators [--markdown]
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/solver/integrator.h>

#include <selvedge/apps/command_line.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <cmath>
#include <limits>

#include "bench.h"
#include "table.h"

namespace {

using namespace selvedge;

constexpr double kTime = 0.25;  // s

struct Run {
  double seconds = 0.0;
  std::vector<Vec3> x;
};

Run swing(const std::string& name, int steps) {
  Material soft;
  soft.stretch_stiffness = 20.0;
  soft.shear_stiffness = 5.0;
  soft.spring_damping = soft.bending_damping = 1e-3;
  const GridConfig grid{0.5, 0.5, 10, 10};
  const ClothMesh cloth = make_rectangular(grid, soft);
  const std::size_t n = cloth.mass.size();
  auto forces = make_internal_forces(cloth);
  forces.push_back(make_gravity({0.0, 0.0, -9.81}));
  const IntegratorRegistry registry = integrators();
  const auto& entry = registry.at(name);
  const MethodOptions options = known_options(
      entry.options(), {{"drag", 0.0}, {"error", 1e-3 / (static_cast<double>(steps) * steps)}});
  const auto method =
      entry(options, std::move(forces), n, {.tolerance = 1e-8, .max_iterations = 2000});
  Particles p{cloth.surface.vertices, std::vector<Vec3>(n, Vec3::Zero()), cloth.mass, {}};
  for (const double m : p.mass) p.inv_mass.push_back(1.0 / m);
  p.inv_mass[110] = p.inv_mass[120] = 0.0;
  std::vector<Vec3> mean(n, Vec3::Zero()), v(n);
  const double h = kTime / steps;
  const Stopwatch watch;
  for (int i = 0; i < steps; ++i) {
    method->begin({p, i * h, h}, {mean, v});
    method->solve({}, {mean, v}, 1.0);
    for (std::size_t k = 0; k < n; ++k) p.x[k] += h * mean[k];
    p.v = method->traits().ends_with_mean ? mean : v;
    for (std::size_t k = 0; k < n; ++k)
      if (p.inv_mass[k] <= 0.0) p.v[k] = mean[k] = Vec3::Zero();
    method->accept({p.x, p.v, p.mass, (i + 1) * h});
  }
  const double seconds = watch.seconds();
  return {seconds, p.x};
}

double rms(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

std::string limit(const std::string& name, double zeta) {
  constexpr double omega = 100.0, forever = std::numeric_limits<double>::infinity();
  const auto method = integrators().at(name)({}, 0, {});
  const double h = method->stable_step(ModeBound{omega, 2.0 * zeta * omega}, forever);
  if (name == "rkf45") return "adaptive";
  return std::isinf(h) ? "any" : fmt::format("{:.3f}", omega * h);
}

std::string error(const Run& run, const std::vector<Vec3>& exact) {
  const double off = rms(run.x, exact);
  return off < 1.0 ? fmt::format("{:.2g}", 1e3 * off) : "grows";
}

}  // namespace

int bench_integrators(int argc, char** argv) {
  CommandLine app("Integrators: error against time, and their limits");
  bool markdown = false;
  app.flag("--markdown", markdown, "Print the table in Markdown");
  if (const auto code = app.parse(argc, argv)) return *code;
  const ThreadLimit one(1);
  const std::vector<Vec3> exact = swing("runge_kutta_4", 16000).x;
  const std::vector<int> steps{15, 60, 250, 1000, 4000};
  std::vector<std::string> head{"integrator", "order"};
  for (const int n : steps) head.push_back(fmt::format("mm at {:.3g} ms", 1e3 * kTime / n));
  head.insert(head.end(), {"us/step", "limit, undamped", "zeta 0.1"});
  Table table(head);
  for (const auto& [name, factory] : integrators()) {
    std::vector<std::string> row{name, std::to_string(factory({}, 0, {})->traits().order)};
    Run last;
    for (const int n : steps) row.push_back(error(last = swing(name, n), exact));
    row.push_back(fmt::format("{:.0f}", 1e6 * last.seconds / steps.back()));
    row.push_back(limit(name, 0.0));
    row.push_back(limit(name, 0.1));
    table.add(row);
  }
  fmt::print("{}", markdown ? table.markdown() : table.text());
  return 0;
}
