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

namespace selvedge {
namespace {

constexpr std::size_t particle_grain = 2048;

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
  std::vector<Vec3> magnitude;  // h Σ |F_k|, per coordinate: the scale of the forces
  std::vector<Vec3> v_old;
  std::vector<char> free;  // 0: held
  detail::TermOperator terms;
  std::unique_ptr<detail::Preconditioner> preconditioner = detail::make_multilevel();
  std::unique_ptr<detail::Preconditioner> fallback;  // made when first needed
  std::vector<Vec3> r, z, p, ap;                     // scratch of the conjugate gradients

  System(std::vector<std::unique_ptr<Force>> owned, std::size_t n, const ImplicitConfig& c)
      : forces(std::move(owned)), config(c), b(n), magnitude(n), v_old(n), free(n, 1) {
    for (auto* vector : {&r, &z, &p, &ap}) vector->resize(n);
    std::vector<Edge> links;
    for (const auto& force : forces) force->add_links(links);
    a = BlockMatrix(n, std::move(links));
    for (const auto& force : forces) force->bind(a);
  }

  void assemble(const Particles& particles, double time, double h);
  void add_forces(const ForceState& state, double h);
  SolveReport solve(std::span<Vec3> v);
  void residual(std::span<const Vec3> v, std::span<Vec3> out);
  SolveReport iterate(detail::Preconditioner& by, std::span<Vec3> v);
  double reference(detail::Preconditioner& by, std::span<const Vec3> v);
  double dot_free(std::span<const Vec3> x, std::span<const Vec3> y) const;
  void multiply(std::span<const Vec3> x, std::span<Vec3> y);
};

void ImplicitEuler::System::add_forces(const ForceState& state, double h) {
  std::fill(magnitude.begin(), magnitude.end(), Vec3::Zero());
  std::vector<Vec3>& f = r;
  for (const auto& force : forces) {
    std::fill(f.begin(), f.end(), Vec3::Zero());
    force->add_force(state, f);
    parallel_for(f.size(), particle_grain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        b[i] += h * f[i];
        if (free[i]) magnitude[i] += h * f[i].cwiseAbs();
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

/// What the residual is measured against, squared: the residual of keeping the old velocities (it
/// does not grow with the speed of the whole, as the right-hand side would), or the sizes of the
/// single forces where they cancel, at rest.
double ImplicitEuler::System::reference(detail::Preconditioner& by, std::span<const Vec3> v) {
  by.apply(magnitude, z);
  const double forces_squared = dot(magnitude, z);
  for (std::size_t i = 0; i < p.size(); ++i) p[i] = free[i] ? v_old[i] : v[i];
  residual(p, r);
  by.apply(r, z);
  return std::max(forces_squared, dot(r, z));
}

double ImplicitEuler::System::dot_free(std::span<const Vec3> x, std::span<const Vec3> y) const {
  return parallel_sum(x.size(), particle_grain, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i)
      if (free[i]) sum += x[i].dot(y[i]);
    return sum;
  });
}

SolveReport ImplicitEuler::System::solve(std::span<Vec3> v) {
  SolveReport report = iterate(*preconditioner, v);
  if (report.converged) return report;
  // The cycle is positive definite only as far as its eigenvalue estimates hold. Where they fail,
  // the diagonal takes over from where it stopped.
  if (!fallback) fallback = detail::make_block_jacobi();
  fallback->set_matrix(a, free);
  const int before = report.iterations;
  report = iterate(*fallback, v);
  report.iterations += before;
  return report;
}

SolveReport ImplicitEuler::System::iterate(detail::Preconditioner& by, std::span<Vec3> v) {
  by.set_terms(terms);
  const double scale = reference(by, v);
  residual(v, r);
  by.apply(r, z);
  double rz = dot(r, z);
  const double target = config.tolerance * config.tolerance * scale;
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
  report.converged = rz >= 0.0 && rz <= target;
  return report;
}

ImplicitEuler::ImplicitEuler(std::vector<std::unique_ptr<Force>> forces, std::size_t particles,
                             const ImplicitConfig& config)
    : system_(std::make_unique<System>(std::move(forces), particles, config)) {}

ImplicitEuler::~ImplicitEuler() = default;
ImplicitEuler::ImplicitEuler(ImplicitEuler&&) noexcept = default;

void ImplicitEuler::assemble(const Particles& particles, double time, double h) {
  system_->assemble(particles, time, h);
}

SolveReport ImplicitEuler::solve(std::span<const ImplicitTerm> terms, std::span<Vec3> v) {
  SELVEDGE_ASSERT(v.size() == system_->b.size());
  system_->terms.reset(terms, system_->b.size());
  return system_->solve(v);
}

}  // namespace selvedge
