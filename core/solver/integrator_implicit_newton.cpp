// SPDX-License-Identifier: MIT
//
// Implicit Euler, M (v⁺ - v) = h F(x + h v⁺, v⁺), iterated to convergence by Newton's method on v⁺.
// The linearly implicit method [BaraffWitkin1998] is one such iteration. The Jacobian of the forces
// is used without its indefinite part, so every system is positive definite; with compressed
// springs the convergence is linear instead of quadratic. A Newton step that does not reduce the
// residual is halved. Iterations that no longer reduce the residual end the solve: elements that
// buckle or flip within a step can make Newton's method cycle, and its remaining iterations would
// cost time without effect. Guarantee: first order, stable for any step length; the report says
// whether it converged.
#include <selvedge/core/solver/detail/implicit_system.h>
#include <selvedge/core/solver/integrator.h>

#include <algorithm>
#include <cmath>

namespace selvedge {
namespace {

constexpr int kMostIterations = 20;  // of Newton's in one solve

// Maximum number of halvings of a Newton step. After these a direction that does not descend is
// accepted as it is.
constexpr int kHalvings = 6;

// A solve ends without convergence after this many iterations in a row without a new smallest
// residual.
constexpr int kStallIterations = 4;

class ImplicitNewton final : public Integrator {
 public:
  ImplicitNewton(ForceList forces, std::size_t n, const ImplicitConfig& config)
      : Integrator(std::move(forces), n),
        system_(forces_.members(), n, config),
        x_(n),
        before_(n) {}

  IntegratorTraits traits() const override {
    return {
        .promise = "stable at any step; solves the nonlinear equations and reports the residual",
        .source = "backward Euler with Newton's method; survey eq. 30",
        .any_step = true,
        .is_implicit = true,
        .ends_with_mean = true};
  }

  void begin(const StepStart& start, StepEnd) override {
    start_ = &start.particles;
    time_ = start.time;
    h_ = start.h;
    kept_ = -1.0;
    system_.hold(start.particles);
  }

  SolveReport solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) override;

 private:
  // Assembles at u; returns the relative residual at u.
  double linearise(std::span<const ImplicitTerm> terms, std::span<const Vec3> u);

  detail::ImplicitSystem system_;
  std::vector<Vec3> x_, before_;
  const Particles* start_ = nullptr;
  double time_ = 0.0, h_ = 0.0;
  double kept_ = -1.0;  // residual norm of keeping the old velocities; < 0: not computed yet
};

double ImplicitNewton::linearise(std::span<const ImplicitTerm> terms, std::span<const Vec3> u) {
  for (std::size_t i = 0; i < u.size(); ++i) x_[i] = start_->x[i] + h_ * u[i];
  system_.assemble({{x_, u, start_->mass, time_ + h_}, h_, start_->v, h_});
  system_.add_jacobian_times(u);
  const double residual = system_.residual_norm(terms, u);
  if (kept_ < 0.0) kept_ = residual;
  const double scale = std::max(kept_, system_.residual_scale());
  return scale > 0.0 ? residual / scale : 0.0;
}

SolveReport ImplicitNewton::solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) {
  const std::span<Vec3> u = end.mean;
  const double tolerance = looser * system_.config().tolerance;
  SolveReport report;
  report.residual = linearise(terms, u);
  double smallest = report.residual;
  int stalled = 0;
  for (int k = 0; k < kMostIterations && report.residual > tolerance; ++k) {
    std::copy(u.begin(), u.end(), before_.begin());
    const SolveReport linear = system_.solve(terms, u, system_.config().tolerance);
    report.iterations += linear.iterations;
    double residual = linearise(terms, u);
    for (int half = 0; half < kHalvings && residual > report.residual; ++half) {
      for (std::size_t i = 0; i < u.size(); ++i) u[i] = 0.5 * (u[i] + before_[i]);
      residual = linearise(terms, u);
    }
    report.residual = residual;
    if (!std::isfinite(residual)) break;
    if (residual < smallest) {
      smallest = residual;
      stalled = 0;
    } else if (++stalled == kStallIterations) {
      break;
    }
  }
  report.converged = report.residual <= tolerance;
  return report;
}

}  // namespace

void register_implicit_newton(IntegratorRegistry& registry) {
  registry.add("implicit_newton", {},
               [](const MethodOptions&, ForceList forces, std::size_t particles,
                  const ImplicitConfig& solve) {
                 return std::make_unique<ImplicitNewton>(std::move(forces), particles, solve);
               });
}

}  // namespace selvedge
