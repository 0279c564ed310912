// SPDX-License-Identifier: MIT
#include <selvedge/core/check.h>
#include <selvedge/core/detail/force_checks.h>
#include <selvedge/core/detail/implicit_system.h>
#include <selvedge/core/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace selvedge::detail {
namespace {

constexpr std::size_t kParticleGrain = 2048;

// Fraction of the single forces below which their sum is rounding error: 1e-16 of a length, and the
// strain is about a hundredth of a length.
constexpr double kRoundingShare = 1e-12;

double dot(std::span<const Vec3> a, std::span<const Vec3> b) {
  return parallel_sum(a.size(), kParticleGrain, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) sum += a[i].dot(b[i]);
    return sum;
  });
}

}  // namespace

ImplicitSystem::ImplicitSystem(std::span<const std::unique_ptr<Force>> forces, std::size_t n,
                               const ImplicitConfig& config)
    : forces_(forces),
      config_(config),
      b_(n),
      applied_(n),
      magnitude_(n),
      v_old_(n),
      zeros_(n, Vec3::Zero()),
      mass_(n),
      free_(n, 1) {
  for (auto* vector : {&r_, &z_, &p_, &ap_, &r_old_, &z_old_}) vector->resize(n);
  std::vector<Edge> links;
  for (const auto& force : forces) {
    const std::size_t before = links.size();
    force->add_links(links);
    outside_.push_back(links.size() == before);
  }
  pieces_ = PieceMomentum(links, n);
  a_ = BlockMatrix(n, std::move(links));
  for (const auto& force : forces) force->bind(a_);
}

void ImplicitSystem::add_forces(const ForceState& state, double h) {
  for (auto* vector : {&applied_, &magnitude_})
    std::fill(vector->begin(), vector->end(), Vec3::Zero());
  std::vector<Vec3>& f = r_;
  for (std::size_t k = 0; k < forces_.size(); ++k) {
    std::fill(f.begin(), f.end(), Vec3::Zero());
    forces_[k]->add_force(state, f);
    parallel_for(f.size(), kParticleGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        b_[i] += h * f[i];
        if (!free_[i]) continue;
        magnitude_[i] += h * f[i].cwiseAbs();
        if (outside_[k]) applied_[i] += h * f[i].cwiseAbs();
      }
    });
  }
}

void ImplicitSystem::hold(const Particles& particles) {
  SELVEDGE_ASSERT(particles.size() == b_.size());
  std::copy(particles.v.begin(), particles.v.end(), v_old_.begin());
  std::copy(particles.mass.begin(), particles.mass.end(), mass_.begin());
  for (std::size_t i = 0; i < b_.size(); ++i) free_[i] = particles.inv_mass[i] > 0.0;
}

void ImplicitSystem::assemble(const SystemAt& system) {
  require_number("step", system.h, false);
  share_ = system.share;
  a_.set_zero();
  for (std::size_t i = 0; i < b_.size(); ++i) {
    b_[i] = mass_[i] * system.momentum[i];
    a_.diagonal(i).diagonal().setConstant(share_ / system.gain * mass_[i]);
  }
  for (const auto& force : forces_) force->add_jacobian(system.at, system.tau, a_);
  if (system.gain != 1.0)
    for (Mat3& block : a_.values()) block *= system.gain;
  add_forces(system.at, system.h);
  preconditioner_->set_matrix(a_, free_);
  scaled_by_ = nullptr;
}

void ImplicitSystem::add_jacobian_times(std::span<const Vec3> v) {
  a_.multiply(v, ap_);
  for (std::size_t i = 0; i < b_.size(); ++i) b_[i] += ap_[i] - (share_ * mass_[i]) * v[i];
}

double ImplicitSystem::residual_norm(std::span<const ImplicitTerm> terms, std::span<const Vec3> v) {
  terms_.reset(terms, b_.size());
  residual(v, r_);
  double sum = 0.0;
  for (std::size_t i = 0; i < r_.size(); ++i) sum += r_[i].squaredNorm() / mass_[i];
  return std::sqrt(sum);
}

double ImplicitSystem::residual_scale() const {
  double from_outside = 0.0, all = 0.0;
  for (std::size_t i = 0; i < applied_.size(); ++i) {
    from_outside += applied_[i].squaredNorm() / mass_[i];
    all += magnitude_[i].squaredNorm() / mass_[i];
  }
  return std::sqrt(std::max(from_outside, kRoundingShare * kRoundingShare * all));
}

SolveReport ImplicitSystem::solve(std::span<const ImplicitTerm> terms, std::span<Vec3> v,
                                  double tolerance) {
  SELVEDGE_ASSERT(v.size() == b_.size());
  terms_.reset(terms, b_.size());
  return solve(v, tolerance);
}

void ImplicitSystem::multiply(std::span<const Vec3> x, std::span<Vec3> y) {
  a_.multiply(x, y);
  if (!terms_.empty()) terms_.add_multiply(x, y);
}

/// out = b − (A + T) v on the free particles, 0 on the held ones.
void ImplicitSystem::residual(std::span<const Vec3> v, std::span<Vec3> out) {
  multiply(v, ap_);
  for (std::size_t i = 0; i < b_.size(); ++i) out[i] = b_[i] - ap_[i];
  terms_.add_rhs(out);
  for (std::size_t i = 0; i < b_.size(); ++i)
    if (!free_[i]) out[i].setZero();
}

/// Starts from v or, in the first solve of a step, from the old velocities if their residual is
/// smaller. Leaves the residual in r_, the preconditioned residual in z_ and their product in rz.
///
/// `scale_`, the square of the reference for the residual, belongs to the first solve of the step.
/// It is the largest of three: the residual of the old velocities (unlike the right-hand side it
/// does not grow with the speed of the whole cloth), the impulse of the external forces alone, and
/// the rounding error of all forces. The magnitude of all forces would be too large: in taut cloth
/// it far exceeds the forces that move the cloth.
void ImplicitSystem::start(Preconditioner& by, std::span<Vec3> v, double& rz) {
  residual(v, r_);
  rz = squared(by, r_, z_);
  if (scaled_by_ == &by) return;
  scaled_by_ = &by;
  const double rounded = kRoundingShare * kRoundingShare * squared(by, magnitude_, p_);
  const double from_outside = squared(by, applied_, p_);
  double kept = rz;
  if (!keeps_velocities(v)) {
    for (std::size_t i = 0; i < p_.size(); ++i) p_[i] = free_[i] ? v_old_[i] : v[i];
    residual(p_, r_old_);
    kept = squared(by, r_old_, z_old_);
  }
  scale_ = std::max({rounded, from_outside, kept});
  if (kept < rz) {
    std::copy(p_.begin(), p_.end(), v.begin());
    std::swap(r_, r_old_);
    std::swap(z_, z_old_);
    rz = kept;
  }
}

/// True if the free particles have their old velocities in v.
bool ImplicitSystem::keeps_velocities(std::span<const Vec3> v) const {
  for (std::size_t i = 0; i < v.size(); ++i)
    if (free_[i] && v[i] != v_old_[i]) return false;
  return true;
}

/// x·Px, with Px in `scratch`.
double ImplicitSystem::squared(Preconditioner& by, std::span<const Vec3> x,
                               std::span<Vec3> scratch) {
  by.apply(x, scratch);
  return dot(x, scratch);
}

double ImplicitSystem::dot_free(std::span<const Vec3> x, std::span<const Vec3> y) const {
  return parallel_sum(x.size(), kParticleGrain, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i)
      if (free_[i]) sum += x[i].dot(y[i]);
    return sum;
  });
}

SolveReport ImplicitSystem::solve(std::span<Vec3> v, double tolerance) {
  SolveReport report = iterate(*preconditioner_, v, tolerance);
  if (report.converged) return report;
  if (std::isnan(report.residual)) {
    mark_non_finite(v);
    return report;
  }
  // The cycle is positive definite only if its eigenvalue estimates hold. If they do not, block
  // Jacobi continues where it stopped.
  if (!fallback_) fallback_ = make_block_jacobi();
  fallback_->set_matrix(a_, free_);
  const int before = report.iterations;
  report = iterate(*fallback_, v, tolerance);
  report.iterations += before;
  return report;
}

/// Contacts can hide a residual, so with contacts each piece of cloth must also conserve its
/// momentum.
bool ImplicitSystem::is_enough(double rz, double target, std::span<const Vec3> v) {
  if (rz > target) return false;
  return terms_.empty() || rz <= kRoundingShare * target ||
         pieces_.kept({r_, v, v_old_, mass_, applied_, free_});
}

SolveReport ImplicitSystem::iterate(Preconditioner& by, std::span<Vec3> v, double tolerance) {
  by.set_terms(terms_);
  double rz = 0.0;
  start(by, v, rz);
  const double target = tolerance * tolerance * scale_;
  SolveReport report;
  std::copy(z_.begin(), z_.end(), p_.begin());
  while (report.iterations < config_.max_iterations && !is_enough(rz, target, v)) {
    multiply(p_, ap_);
    const double pap = dot_free(p_, ap_);
    if (!(pap > 0.0)) break;  // NaN, or not positive definite
    const double alpha = rz / pap;
    parallel_for(r_.size(), kParticleGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        if (!free_[i]) continue;
        v[i] += alpha * p_[i];
        r_[i] -= alpha * ap_[i];
      }
    });
    by.apply(r_, z_);
    const double next = dot(r_, z_);
    const double beta = next / rz;
    rz = next;
    parallel_for(r_.size(), kParticleGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) p_[i] = z_[i] + beta * p_[i];
    });
    ++report.iterations;
  }
  report.residual = scale_ > 0.0 ? std::sqrt(std::abs(rz) / scale_) : 0.0;
  if (!std::isfinite(rz) || !std::isfinite(scale_))
    report.residual = std::numeric_limits<double>::quiet_NaN();
  report.converged = rz >= 0.0 && rz <= target && !std::isnan(report.residual);
  return report;
}

/// With non-finite forces there is no solution: sets NaN so that the guess is not taken for a
/// solution.
void ImplicitSystem::mark_non_finite(std::span<Vec3> v) const {
  for (std::size_t i = 0; i < v.size(); ++i)
    if (free_[i] && !r_[i].allFinite()) v[i].setConstant(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace selvedge::detail
