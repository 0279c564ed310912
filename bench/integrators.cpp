// SPDX-License-Identifier: MIT
//
// Error against time of every integrator on a small cloth that swings from two corners without
// contacts. The error is that of positions after a quarter of a second, against Runge-Kutta 4 with
// a converged step length. The program also finds the longest stable step of each integrator by
// bisection on an undamped and a damped oscillator (survey section 5.5, claims on its Fig. 27 and
// Table VII). --work compares the explicit ones at the same number of force evaluations instead of
// the same step (claim C21): steps where each step costs the same, and for RKF45 the tolerance that
// costs as much.
//   bench integrators [--markdown] [--work 500,2000,8000]
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/solver/integrator.h>

#include <selvedge/apps/command_line.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "bench.h"
#include "table.h"

namespace selvedge {
namespace integrators_bench {
namespace {

constexpr double kTime = 0.25;  // s

struct Run {
  double seconds = 0.0;
  int evaluations = 0;  ///< of the forces
  std::vector<Vec3> x;
};

/// No force, but a count of how often it is asked.
class Count final : public Force {
 public:
  explicit Count(int& count) : count_(count) {}
  void add_force(const ForceState&, std::span<Vec3>) const override { ++count_; }
  double energy(const ForceState&) const override { return 0.0; }
  void add_links(std::vector<Edge>&) const override {}
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const ForceState&, double, BlockMatrix&) const override {}
  void add_stiffness_bound(const ForceState&, std::span<double>, std::span<double>) const override {
  }

 private:
  int& count_;
};

/// `error`: of an inner step of RKF45, m; 0: in step with the square of the step.
Run swing(const std::string& name, int steps, double error = 0.0) {
  Material soft;
  soft.stretch_stiffness = 20.0;
  soft.shear_stiffness = 5.0;
  soft.spring_damping = soft.bending_damping = 1e-3;
  const GridConfig grid{0.5, 0.5, 10, 10};
  const ClothMesh cloth = make_rectangular(grid, soft);
  const std::size_t n = cloth.mass.size();
  auto forces = make_internal_forces(cloth);
  forces.push_back(make_gravity({0.0, 0.0, -9.81}));
  Run run;
  forces.push_back(std::make_unique<Count>(run.evaluations));
  const IntegratorRegistry registry = integrators();
  const auto& entry = registry.at(name);
  if (error <= 0.0) error = 1e-3 / (static_cast<double>(steps) * steps);
  const MethodOptions options = known_options(entry.options(), {{"drag", 0.0}, {"error", error}});
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
  run.seconds = watch.seconds();
  run.x = std::move(p.x);
  return run;
}

/// The run whose evaluations of the forces come nearest to `work`.
Run with_work(const std::string& name, int work) {
  const int of_a_step = swing(name, 4).evaluations / 4;
  if (name != "rkf45") return swing(name, std::max(1, work / of_a_step));
  double low = 1e-16, high = 1.0;  // m
  for (int k = 0; k < 24; ++k) {
    const double middle = std::sqrt(low * high);
    (swing(name, 15, middle).evaluations > work ? low : high) = middle;
  }
  return swing(name, 15, high);
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

Table at_equal_work(const std::vector<int>& works, const std::vector<Vec3>& exact) {
  std::vector<std::string> head{"integrator", "order"};
  for (const int work : works) {
    head.push_back(fmt::format("mm after {} evaluations", work));
    head.emplace_back("evaluations");
    head.emplace_back("ms");
  }
  Table table(head);
  for (const auto& [name, factory] : integrators()) {
    const IntegratorTraits traits = factory({}, 0, {})->traits();
    if (traits.is_implicit) continue;
    std::vector<std::string> row{name, std::to_string(traits.order)};
    for (const int work : works) {
      const Run run = with_work(name, work);
      row.push_back(error(run, exact));
      row.push_back(std::to_string(run.evaluations));
      row.push_back(fmt::format("{:.1f}", 1e3 * run.seconds));
    }
    table.add(row);
  }
  return table;
}

}  // namespace
}  // namespace integrators_bench

int bench_integrators(int argc, char** argv) {
  using namespace integrators_bench;
  CommandLine app("Integrators: error against time, and their limits");
  bool markdown = false;
  std::vector<int> works;
  app.option("--work", works, "Numbers of evaluations at which to compare the explicit ones")
      .comma_separated();
  app.flag("--markdown", markdown, "Print the table in Markdown");
  if (const auto code = app.parse(argc, argv)) return *code;
  const ThreadLimit one(1);
  const std::vector<Vec3> exact = swing("runge_kutta_4", 16000).x;
  if (!works.empty()) {
    const Table table = at_equal_work(works, exact);
    fmt::print("{}", markdown ? table.markdown() : table.text());
    return 0;
  }
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

}  // namespace selvedge
