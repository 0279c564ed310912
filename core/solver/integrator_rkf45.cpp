// SPDX-License-Identifier: MIT
//
// E. Fehlberg, "Low-order classical Runge-Kutta formulas with stepsize control", NASA TR R-315,
// 1969: six stages that give a fifth-order method, which advances the solution, and a fourth-order
// one; their difference estimates the error of a step. Survey eq. 21-27 misprint two coefficients,
// as the row sums show: 7297/2197 for 7296/2197 (eq. 25), and -11/40 of the last row is missing
// (eq. 27). With the misprints the method is only of first order. The survey has neither an error
// estimate nor a step size controller; this one is the usual
//   h ← h · min(5, max(1/5, 0.9 (tolerance/error)^(1/5))).
// A step of the scene consists of as many inner steps as the tolerance requires; the length of the
// last one is remembered. A step that would need more than `kMostInnerSteps` returns NaN velocities
// and is rejected. Guarantee: the estimated error of each inner step is within the tolerance.
// Without damping the fifth-order weights alone are unstable at every step below hω = 2.05 (growth
// 9e-4 (hω)⁶); the tolerance keeps that growth as small as any other error.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/solver/detail/runge_kutta.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace selvedge {
namespace {

detail::Tableau fehlberg() {
  detail::Tableau t{6, {}, {}, {0.0, 1.0 / 4, 3.0 / 8, 12.0 / 13, 1.0, 1.0 / 2}};
  t.a[1] = {1.0 / 4};
  t.a[2] = {3.0 / 32, 9.0 / 32};
  t.a[3] = {1932.0 / 2197, -7200.0 / 2197, 7296.0 / 2197};
  t.a[4] = {439.0 / 216, -8.0, 3680.0 / 513, -845.0 / 4104};
  t.a[5] = {-8.0 / 27, 2.0, -3544.0 / 2565, 1859.0 / 4104, -11.0 / 40};
  t.b = {16.0 / 135, 0.0, 6656.0 / 12825, 28561.0 / 56430, -9.0 / 50, 2.0 / 55};
  return t;
}

// Fifth-order weights minus fourth-order ones.
constexpr std::array<double, 6> kError = {1.0 / 360,       0.0,      -128.0 / 4275,
                                          -2197.0 / 75240, 1.0 / 50, 2.0 / 55};

constexpr double kSafety = 0.9, kLeast = 0.2, kMost = 5.0;

// The last inner step covers the remaining time if that is at most this many times its length.
constexpr double kStretch = 1.0 + 1e-9;

// In one step.
constexpr int kMostInnerSteps = 100000;

// 1/s, allowed error of velocity over that of position.
constexpr double kErrorRate = 100.0;

class Fehlberg final : public Integrator {
 public:
  Fehlberg(ForceList forces, std::size_t n, const MethodOptions& options)
      : Integrator(std::move(forces), n),
        error_(options["error"]),
        stages_(fehlberg(), n),
        x_(n),
        v_(n),
        dx_(n),
        dv_(n) {}

  IntegratorTraits traits() const override {
    return {
        .promise =
            "keeps the error of each inner step within its tolerance by choosing the inner steps",
        .source = "Fehlberg, NASA TR R-315, 1969; survey eq. 21-27 corrected; Wang et al. 2009",
        .order = 5,
        .any_step = true};
  }

  void begin(const StepStart& start, StepEnd end) override;

 private:
  // True if the error is within the tolerance; sets the factor for the next inner step.
  bool within(const Particles& p, double h, double& factor);
  double largest_error(const Particles& p, double h) const;
  void advance(const Particles& p, double h);
  void remember(const ForceState&) override { h_ = next_h_; }
  void save_history(std::vector<double>& memory) const override { memory.push_back(h_); }
  std::span<const double> restore_history(std::span<const double> memory) override {
    detail::require_memory("rkf45", memory.size(), 1);
    h_ = next_h_ = memory[0];
    return memory.subspan(1);
  }

  const double error_;  // m
  detail::RungeKuttaStages stages_;
  std::vector<Vec3> x_, v_, dx_, dv_;
  double h_ = 0.0, next_h_ = 0.0;  // s, length of the last inner step that was not cut; 0: none yet
};

double Fehlberg::largest_error(const Particles& p, double h) const {
  double worst = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (p.inv_mass[i] <= 0.0) continue;
    const double x = h * dx_[i].norm() / error_;
    const double v = h * dv_[i].norm() / (error_ * kErrorRate);
    // Not std::max: a NaN must stay a NaN.
    if (!(x <= worst)) worst = x;
    if (!(v <= worst)) worst = v;
  }
  return worst;
}

bool Fehlberg::within(const Particles& p, double h, double& factor) {
  stages_.combine(kError, dx_, dv_);
  const double error = largest_error(p, h);
  factor = std::isfinite(error) ? kSafety * elementary::pow(error, -0.2) : kLeast;
  factor = std::clamp(factor, kLeast, kMost);
  return error <= 1.0;
}

void Fehlberg::advance(const Particles& p, double h) {
  stages_.combine(stages_.tableau().b, dx_, dv_);
  for (std::size_t i = 0; i < p.size(); ++i) {
    x_[i] += h * dx_[i];
    v_[i] += h * dv_[i];
  }
}

void Fehlberg::begin(const StepStart& start, StepEnd end) {
  const Particles& p = start.particles;
  std::copy(p.x.begin(), p.x.end(), x_.begin());
  for (std::size_t i = 0; i < p.size(); ++i) v_[i] = p.inv_mass[i] > 0.0 ? p.v[i] : end.mean[i];
  double done = 0.0, h = h_ > 0.0 ? h_ : start.h;
  int attempts = 0;
  while (done < start.h && attempts < kMostInnerSteps) {
    const double left = start.h - done;
    const bool last = left <= h * kStretch;
    const double step = last ? left : h;
    stages_.evaluate(forces_, p, x_, v_, start.time + done, step);
    double factor = 1.0;
    ++attempts;
    if (within(p, step, factor)) {
      advance(p, step);
      done = last ? start.h : done + step;
      if (!last || factor < 1.0) h = step * factor;
    } else {
      h = step * std::min(factor, kSafety);
    }
  }
  next_h_ = h;
  const bool lost = done < start.h;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (p.inv_mass[i] <= 0.0) continue;
    end.mean[i] = (x_[i] - p.x[i]) / start.h;
    end.v[i] = v_[i];
    if (lost) end.mean[i].setConstant(std::numeric_limits<double>::quiet_NaN());
  }
}

}  // namespace

void register_rkf45(IntegratorRegistry& registry) {
  registry.add(
      "rkf45",
      {{.name = "error",
        .initial = 1e-5,
        .unit = "m",
        .least = 0.0,
        .most = 1.0,
        .above_least = true,
        .meaning = "allowed error of position in an inner step; smaller: more inner "
                   "steps"}},
      [](const MethodOptions& o, ForceList forces, std::size_t particles, const ImplicitConfig&) {
        return std::make_unique<Fehlberg>(std::move(forces), particles, o);
      });
}

}  // namespace selvedge
