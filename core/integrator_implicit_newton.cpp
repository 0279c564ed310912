// SPDX-License-Identifier: MIT
//
// Implicit Euler, M (v⁺ - v) = h F(x + h v⁺, v⁺), iterated to convergence by Newton's method on v⁺,
// which the linearly implicit method [BaraffWitkin1998] makes one iteration of. The Jacobian is
// that of the forces without its indefinite part, so that every system is positive definite; where
// springs are compressed it converges linearly instead of quadratically. A step that does not
// lessen the residual is halved. Guarantee: first order, stable at any step; says in its report
// whether it converged.
#include <selvedge/core/detail/force_checks.h>
#include <selvedge/core/detail/implicit_system.h>
#include <selvedge/core/integrator.h>

#include <algorithm>
#include <cmath>

namespace selvedge {
namespace {

// Halvings of one Newton step; a direction that does not descend after these is taken as it is.
constexpr int kHalvings = 6;

class ImplicitNewton final : public Integrator {
 public:
  ImplicitNewton(std::vector<std::unique_ptr<Force>> forces, std::size_t n,
                 const IntegratorConfig& config)
      : Integrator(std::move(forces), n),
        system_(forces_.members(), n, config.solve),
        max_newton_(config.max_newton),
        x_(n),
        before_(n) {
    detail::require_number("max_newton", config.max_newton, false);
  }

  IntegratorTraits traits() const override {
    return {"stable at any step; the non-linear equations are solved, and it says how well",
            "backward Euler with Newton's method; survey eq. 30",
            1,
            true,
            true,
            true};
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
  // Assembles at u; returns how far u is from a solution, relative.
  double linearise(std::span<const ImplicitTerm> terms, std::span<const Vec3> u);

  detail::ImplicitSystem system_;
  int max_newton_;
  std::vector<Vec3> x_, before_;
  const Particles* start_ = nullptr;
  double time_ = 0.0, h_ = 0.0;
  double kept_ = -1.0;  // misfit of keeping the old velocities; < 0: not known yet
};

double ImplicitNewton::linearise(std::span<const ImplicitTerm> terms, std::span<const Vec3> u) {
  for (std::size_t i = 0; i < u.size(); ++i) x_[i] = start_->x[i] + h_ * u[i];
  system_.assemble({{x_, u, start_->mass, time_ + h_}, h_, start_->v, h_});
  system_.add_jacobian_times(u);
  const double misfit = system_.misfit(terms, u);
  if (kept_ < 0.0) kept_ = misfit;
  const double scale = std::max(kept_, system_.misfit_scale());
  return scale > 0.0 ? misfit / scale : 0.0;
}

SolveReport ImplicitNewton::solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) {
  const std::span<Vec3> u = end.mean;
  const double tolerance = looser * system_.config().tolerance;
  SolveReport report;
  report.residual = linearise(terms, u);
  for (int k = 0; k < max_newton_ && report.residual > tolerance; ++k) {
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
  }
  report.converged = report.residual <= tolerance;
  return report;
}

}  // namespace

std::unique_ptr<Integrator> make_implicit_newton(std::vector<std::unique_ptr<Force>> forces,
                                                 std::size_t particles,
                                                 const IntegratorConfig& config) {
  return std::make_unique<ImplicitNewton>(std::move(forces), particles, config);
}

}  // namespace selvedge
