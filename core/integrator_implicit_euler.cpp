// SPDX-License-Identifier: MIT
//
// D. Baraff, A. Witkin, "Large steps in cloth simulation", SIGGRAPH 1998, solved for v⁺ instead of
// Δv: because forces are linear in v, F(x, v⁺) ≈ F(x, 0) + h ∂F/∂x v⁺ + ∂F/∂v v⁺ has no further
// approximation in the damping.
#include <selvedge/core/check.h>
#include <selvedge/core/detail/force_checks.h>
#include <selvedge/core/detail/implicit_terms.h>
#include <selvedge/core/detail/preconditioner.h>
#include <selvedge/core/integrator.h>
#include <selvedge/core/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace selvedge {
namespace {

constexpr std::size_t particle_grain = 2048;

// Share of the single forces below which their sum is rounding: 1e-16 of lengths, of which strain
// is the hundredth part.
constexpr double rounding_share = 1e-12;

double dot(std::span<const Vec3> a, std::span<const Vec3> b) {
  return parallel_sum(a.size(), particle_grain, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) sum += a[i].dot(b[i]);
    return sum;
  });
}

}  // namespace

struct ImplicitEuler::System {
  std::vector<std::unique_ptr<Force>> forces;
  ImplicitConfig config;
  BlockMatrix a;                // M − h ∂F/∂v − h² ∂F/∂x
  std::vector<Vec3> b;          // M v + h F(x, 0)
  std::vector<Vec3> applied;    // h Σ |F_k| of the forces from outside, per coordinate
  std::vector<Vec3> magnitude;  // the same of all forces: what is rounded
  std::vector<char> outside;    // of each force: it couples no particles
  std::vector<Vec3> v_old;
  std::vector<char> free;  // 0: held
  detail::TermOperator terms;
  std::unique_ptr<detail::Preconditioner> preconditioner = detail::make_multilevel();
  std::unique_ptr<detail::Preconditioner> fallback;   // made when first needed
  const detail::Preconditioner* scaled_by = nullptr;  // whose norm `scale` is in; null: not yet
  double scale = 0.0;
  std::vector<Vec3> r, z, p, ap, r_old, z_old;  // scratch of the conjugate gradients

  System(std::vector<std::unique_ptr<Force>> owned, std::size_t n, const ImplicitConfig& c)
      : forces(std::move(owned)), config(c), b(n), applied(n), magnitude(n), v_old(n), free(n, 1) {
    for (auto* vector : {&r, &z, &p, &ap, &r_old, &z_old}) vector->resize(n);
    std::vector<Edge> links;
    for (const auto& force : forces) {
      const std::size_t before = links.size();
      force->add_links(links);
      outside.push_back(links.size() == before);
    }
    a = BlockMatrix(n, std::move(links));
    for (const auto& force : forces) force->bind(a);
  }

  void assemble(const Particles& particles, double time, double h);
  void add_forces(const ForceState& state, double h);
  SolveReport solve(std::span<Vec3> v, double tolerance);
  void residual(std::span<const Vec3> v, std::span<Vec3> out);
  void lose_what_is_not_finite(std::span<Vec3> v) const;
  SolveReport iterate(detail::Preconditioner& by, std::span<Vec3> v, double tolerance);
  void start(detail::Preconditioner& by, std::span<Vec3> v, double& rz);
  double squared(detail::Preconditioner& by, std::span<const Vec3> x, std::span<Vec3> scratch);
  double dot_free(std::span<const Vec3> x, std::span<const Vec3> y) const;
  void multiply(std::span<const Vec3> x, std::span<Vec3> y);
};

void ImplicitEuler::System::add_forces(const ForceState& state, double h) {
  for (auto* vector : {&applied, &magnitude})
    std::fill(vector->begin(), vector->end(), Vec3::Zero());
  std::vector<Vec3>& f = r;
  for (std::size_t k = 0; k < forces.size(); ++k) {
    std::fill(f.begin(), f.end(), Vec3::Zero());
    forces[k]->add_force(state, f);
    parallel_for(f.size(), particle_grain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        b[i] += h * f[i];
        if (!free[i]) continue;
        magnitude[i] += h * f[i].cwiseAbs();
        if (outside[k]) applied[i] += h * f[i].cwiseAbs();
      }
    });
  }
}

void ImplicitEuler::System::assemble(const Particles& particles, double time, double h) {
  SELVEDGE_ASSERT(particles.size() == b.size());
  detail::require_number("step", h, false);
  a.set_zero();
  v_old = particles.v;
  for (std::size_t i = 0; i < b.size(); ++i) {
    free[i] = particles.inv_mass[i] > 0.0;
    b[i] = particles.mass[i] * particles.v[i];
    a.diagonal(i).diagonal().setConstant(particles.mass[i]);
  }
  std::fill(z.begin(), z.end(), Vec3::Zero());
  const ForceState at_rest{particles.x, z, particles.mass, time};
  add_forces(at_rest, h);
  for (const auto& force : forces) force->add_jacobian(at_rest, h, a);
  preconditioner->set_matrix(a, free);
  scaled_by = nullptr;
}

void ImplicitEuler::System::multiply(std::span<const Vec3> x, std::span<Vec3> y) {
  a.multiply(x, y);
  if (!terms.empty()) terms.add_multiply(x, y);
}

/// out = b − (A + T) v on the free particles, 0 on the held ones.
void ImplicitEuler::System::residual(std::span<const Vec3> v, std::span<Vec3> out) {
  multiply(v, ap);
  for (std::size_t i = 0; i < b.size(); ++i) out[i] = b[i] - ap[i];
  terms.add_rhs(out);
  for (std::size_t i = 0; i < b.size(); ++i)
    if (!free[i]) out[i].setZero();
}

/// Starts from v, or at the first solve of a step from the old velocities if these leave less: with
/// its residual in r, the preconditioned one in z and their product.
///
/// `scale`, what the residual is measured against, squared, is that of the first solve: the
/// residual of keeping the old velocities (it does not grow with the speed of the whole, as the
/// right-hand side would), or what the forces from outside would do alone. Not the sizes of all
/// forces: in taut cloth these are far larger than what moves it. They count with the share of them
/// that rounding leaves.
void ImplicitEuler::System::start(detail::Preconditioner& by, std::span<Vec3> v, double& rz) {
  residual(v, r);
  rz = squared(by, r, z);
  if (scaled_by == &by) return;
  scaled_by = &by;
  const double rounded = rounding_share * rounding_share * squared(by, magnitude, p);
  const double from_outside = squared(by, applied, p);
  for (std::size_t i = 0; i < p.size(); ++i) p[i] = free[i] ? v_old[i] : v[i];
  residual(p, r_old);
  const double kept = squared(by, r_old, z_old);
  scale = std::max({rounded, from_outside, kept});
  if (kept <= rz) {
    std::copy(p.begin(), p.end(), v.begin());
    std::swap(r, r_old);
    std::swap(z, z_old);
    rz = kept;
  }
}

/// x·Px, with Px in `scratch`.
double ImplicitEuler::System::squared(detail::Preconditioner& by, std::span<const Vec3> x,
                                      std::span<Vec3> scratch) {
  by.apply(x, scratch);
  return dot(x, scratch);
}

double ImplicitEuler::System::dot_free(std::span<const Vec3> x, std::span<const Vec3> y) const {
  return parallel_sum(x.size(), particle_grain, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i)
      if (free[i]) sum += x[i].dot(y[i]);
    return sum;
  });
}

SolveReport ImplicitEuler::System::solve(std::span<Vec3> v, double tolerance) {
  SolveReport report = iterate(*preconditioner, v, tolerance);
  if (report.converged) return report;
  if (std::isnan(report.residual)) {
    lose_what_is_not_finite(v);
    return report;
  }
  // The cycle is positive definite only as far as its eigenvalue estimates hold. Where they fail,
  // the diagonal takes over from where it stopped.
  if (!fallback) fallback = detail::make_block_jacobi();
  fallback->set_matrix(a, free);
  const int before = report.iterations;
  report = iterate(*fallback, v, tolerance);
  report.iterations += before;
  return report;
}

SolveReport ImplicitEuler::System::iterate(detail::Preconditioner& by, std::span<Vec3> v,
                                           double tolerance) {
  by.set_terms(terms);
  double rz = 0.0;
  start(by, v, rz);
  const double target = tolerance * tolerance * scale;
  SolveReport report;
  std::copy(z.begin(), z.end(), p.begin());
  while (rz > target && report.iterations < config.max_iterations) {
    multiply(p, ap);
    const double pap = dot_free(p, ap);
    if (!(pap > 0.0)) break;  // not a number, or not positive definite
    const double alpha = rz / pap;
    parallel_for(r.size(), particle_grain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        if (!free[i]) continue;
        v[i] += alpha * p[i];
        r[i] -= alpha * ap[i];
      }
    });
    by.apply(r, z);
    const double next = dot(r, z);
    const double beta = next / rz;
    rz = next;
    parallel_for(r.size(), particle_grain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) p[i] = z[i] + beta * p[i];
    });
    ++report.iterations;
  }
  report.residual = scale > 0.0 ? std::sqrt(std::abs(rz) / scale) : 0.0;
  if (!std::isfinite(rz) || !std::isfinite(scale))
    report.residual = std::numeric_limits<double>::quiet_NaN();
  report.converged = rz >= 0.0 && rz <= target && !std::isnan(report.residual);
  return report;
}

/// Forces that are not finite have no solution; whoever asked must not take the guess for one.
void ImplicitEuler::System::lose_what_is_not_finite(std::span<Vec3> v) const {
  for (std::size_t i = 0; i < v.size(); ++i)
    if (free[i] && !r[i].allFinite()) v[i].setConstant(std::numeric_limits<double>::quiet_NaN());
}

ImplicitEuler::ImplicitEuler(std::vector<std::unique_ptr<Force>> forces, std::size_t particles,
                             const ImplicitConfig& config)
    : system_(std::make_unique<System>(std::move(forces), particles, config)) {}

ImplicitEuler::~ImplicitEuler() = default;
ImplicitEuler::ImplicitEuler(ImplicitEuler&&) noexcept = default;

void ImplicitEuler::assemble(const Particles& particles, double time, double h) {
  system_->assemble(particles, time, h);
}

SolveReport ImplicitEuler::solve(std::span<const ImplicitTerm> terms, std::span<Vec3> v,
                                 double looser) {
  SELVEDGE_ASSERT(v.size() == system_->b.size() && looser >= 1.0);
  system_->terms.reset(terms, system_->b.size());
  return system_->solve(v, looser * system_->config.tolerance);
}

void ImplicitEuler::accept(const ForceState& state) {
  for (const auto& force : system_->forces) force->accept(state);
}

}  // namespace selvedge
