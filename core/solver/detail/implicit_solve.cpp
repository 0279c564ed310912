// SPDX-License-Identifier: MIT
//
// The solve of the system that implicit_system.cpp assembles.
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/solver/detail/implicit_system.h>
#include <selvedge/core/solver/detail/particle_ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace selvedge::detail {
namespace {

// The square of the residual falls by at most this factor before single precision is corrected, and
// must fall by this factor at least, or double precision takes over.
constexpr double kMostReduction = 1e-8, kLeastReduction = 0.25;
// In solves that only find contacts, it may fall by this factor before double precision corrects
// it.
constexpr double kLooseReduction = 1e-6;
// How much further it falls where a piece of cloth has not kept its momentum.
constexpr double kMomentumReduction = 0.1;
// Square of the error by rounding that is accepted, as a share of that of the residual or target.
constexpr double kDrift = 1e-4;

}  // namespace

SolveReport ImplicitSystem::solve(std::span<const ImplicitTerm> terms, std::span<Vec3> v,
                                  double tolerance) {
  SELVEDGE_ASSERT(v.size() == b_.size());
  terms_.reset(terms, b_.size(), followers_);
  bytes_ = 0;
  SolveReport report = refine(v, tolerance);
  report.bytes = bytes_;
  if (report.converged) {
    if (config_.exact_momentum) keep_momentum(v);
    return report;
  }
  if (std::isnan(report.residual)) {
    mark_non_finite(v);
    return report;
  }
  // The cycle is positive definite only if its eigenvalue estimates hold and single precision
  // suffices. If not, block Jacobi continues where it stopped.
  const int before = report.iterations;
  report = iterate(v, tolerance);
  if (config_.exact_momentum) keep_momentum(v);
  report.iterations += before;
  report.bytes = bytes_;
  return report;
}

/// Starts from v or, in the first solve of a step, from the old velocities if their residual is
/// smaller. Leaves the residual in r_ and lanes_.
///
/// `scale_`, the square of the reference for the residual, belongs to the first solve of the step.
/// It is the largest of three: the residual of the old velocities (unlike the right-hand side it
/// does not grow with the speed of the whole cloth), the impulse of the external forces alone, and
/// the rounding error of all forces. The magnitude of all forces would be too large: in taut cloth
/// it far exceeds the forces that move the cloth.
void ImplicitSystem::start(std::span<Vec3> v) {
  if (scaled_in_ == Norm::multilevel) {
    residual(v, r_, Accuracy::any);
    note_begin();
    load(r_, lanes_);
    largest_ = end_.exact ? lanes_.rz : std::max(largest_, lanes_.rz);
    return;
  }
  scaled_in_ = Norm::multilevel;
  set_old_velocities(v, p_);
  residual(p_, r_old_, Accuracy::exact);
  note_begin();
  load(r_old_, other_);
  const double kept = other_.rz;
  scale_ = has_heavy_ ? squared_above(0.0, for_scale(r_old_, r_), 1.0) : kept;
  scale_ = std::max(scale_, squared_above(scale_, for_scale(applied_, r_), 1.0));
  scale_ = std::max(scale_, squared_above(scale_, magnitude_, kRoundingShare));
  const bool keeps = std::equal(p_.begin(), p_.end(), v.begin());
  if (!keeps) {
    residual(v, r_, Accuracy::exact);
    load(r_, lanes_);
  }
  if (keeps || kept < lanes_.rz) {
    for_particles(v.size(), [&](std::size_t i) { v[i] = p_[i]; });
    std::swap(r_, r_old_);
    std::swap(lanes_, other_);
  } else {
    note_begin();
  }
  largest_ = lanes_.rz;
}

/// Square of share·x, or 0 if it is at most `least`. Uses lanes_.
double ImplicitSystem::squared_above(double least, std::span<const Vec3> x, double share) {
  // x·Px is at most 2 x·A⁻¹x, and A⁻¹ at most (share_·M)⁻¹.
  const double bound = sum_particles(x.size(), [&](std::size_t b, std::size_t e) {
    double sum = 0.0;
    for (std::size_t i = b; i < e; ++i) sum += x[i].squaredNorm() / (share_ * mass_[i]);
    return sum;
  });
  if (share * share * 2.0 * bound <= least) return 0.0;
  load(x, lanes_);
  return share * share * lanes_.rz;
}

/// Sets `out` for x, which is zero at held particles.
void ImplicitSystem::load(std::span<const Vec3> x, LaneResidual& out) {
  const double squares = dot(x, x);
  out.rz = 0.0;
  out.unit = 0.0;
  if (!(squares > 0.0) || !std::isfinite(squares)) {  // nothing to do, or nothing that can be done
    out.rz = squares;
    out.r.set_zero();
    out.z.set_zero();
    return;
  }
  // Entries near 1 stay away from the limits of single precision.
  int exponent = 0;
  std::frexp(squares / static_cast<double>(x.size()), &exponent);
  out.unit = std::ldexp(1.0, exponent / 2);
  const double by = 1.0 / out.unit;
  for_particles(x.size(), [&](std::size_t i) { out.r.set(i, by * x[i]); });
  out.rz = out.unit * out.unit * multilevel_.apply(out.r, out.z);
  bytes_ += multilevel_.cycle_bytes() + x.size() * sizeof(Vec3);
}

/// The old velocities at free particles, v at the others.
void ImplicitSystem::set_old_velocities(std::span<const Vec3> v, std::span<Vec3> out) const {
  for_particles(out.size(), [&](std::size_t i) { out[i] = free_[i] ? v_old_[i] : v[i]; });
}

double ImplicitSystem::dot_free(std::span<const Vec3> x, std::span<const Vec3> y) const {
  return sum_particles(x.size(), [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i)
      if (free_[i]) sum += x[i].dot(y[i]);
    return sum;
  });
}

/// Contacts can hide a residual, so with contacts each piece of cloth must also conserve its
/// momentum.
bool ImplicitSystem::is_enough(double rz, double target, std::span<const Vec3> v) {
  if (rz > target) return false;
  return terms_.empty() || rz <= kRoundingShare * target ||
         pieces_.kept({r_, v, v_old_, mass_, applied_, free_});
}

SolveReport ImplicitSystem::refine(std::span<Vec3> v, double tolerance) {
  multilevel_.set_terms(terms_.terms(), followers_);
  start(v);
  const double target = tolerance * tolerance * scale_;
  // What meets the tolerance of the scene has a residual in double precision. A looser solve, which
  // only finds the contacts, does without.
  const double final_target =
      std::min(tolerance * tolerance, config_.tolerance * config_.tolerance) * scale_;
  SolveReport report;
  while (report.iterations < config_.max_iterations) {
    if (is_enough(lanes_.rz, target, v)) {
      if (end_.exact || lanes_.rz > final_target) break;
      if (!verify(v, target)) break;
      continue;
    }
    const double before = lanes_.rz;
    const double goal =
        before > target ? std::max(target, kMostReduction * before) : kMomentumReduction * before;
    report.iterations += descend(goal, config_.max_iterations - report.iterations);
    const bool loose = target > final_target && lanes_.rz >= kLooseReduction * largest_;
    if (!take_correction(v, target, loose) || !(lanes_.rz < kLeastReduction * before)) break;
  }
  // Where the iterations ran out, a residual that meets the tolerance of the scene may be one that
  // only single precision has updated.
  if (!end_.exact && lanes_.rz <= final_target) verify(v, target);
  report_residual(lanes_.rz, target, report);
  return report;
}

/// Conjugate gradients in single precision from lanes_ until r·z is at most `goal`. Leaves the sum
/// of the steps in correction_; returns the number of iterations.
int ImplicitSystem::descend(double goal, int most) {
  const double square = lanes_.unit * lanes_.unit;
  LaneVector &r = lanes_.r, &z = lanes_.z, &p = direction_, &ap = image_;
  correction_.set_zero();
  p = z;
  double rz = lanes_.rz / square;
  int iterations = 0;
  while (iterations < most && rz * square > goal) {
    const double pap = multilevel_.multiply(p, ap);
    if (!(pap > 0.0)) break;  // NaN, or not positive definite
    const auto alpha = static_cast<float>(rz / pap);
    add_step(alpha, p, ap, correction_, r);
    const double next = multilevel_.apply(r, z);
    scale_and_add(static_cast<float>(next / rz), z, p);
    rz = next;
    ++iterations;
  }
  // Besides matrix and cycle, an iteration reads and writes 9 vectors.
  bytes_ += static_cast<std::size_t>(iterations) *
            (multilevel_.multiply_bytes() + multilevel_.cycle_bytes() + 9 * r.bytes());
  lanes_.rz = rz * square;
  return iterations;
}

/// Adds the correction to v. Returns false if the residual is not finite.
bool ImplicitSystem::take_correction(std::span<Vec3> v, double target, bool loose) {
  for_particles(b_.size(), [&](std::size_t i) {
    if (free_[i]) v[i] += lanes_.unit * correction_[i];
  });
  if (!loose) return verify(v, target);
  for_particles(b_.size(), [&](std::size_t i) { r_[i] = lanes_.unit * lanes_.r[i]; });
  set_product(v);
  return std::isfinite(lanes_.rz);
}

/// A v as the updated residual says: A v = b - T v - r.
void ImplicitSystem::set_product(std::span<const Vec3> v) {
  end_.exact = false;
  for_particles(b_.size(), [&](std::size_t i) {
    end_.v[i] = v[i];
    end_.av[i] = b_[i] - r_[i];
  });
  terms_.add_residual(v, end_.av);
}

/// Computes the residual in double precision. Where it differs from the one that the iteration has
/// updated by more than rounding that does not matter, it replaces that. Returns false if it is not
/// finite.
bool ImplicitSystem::verify(std::span<const Vec3> v, double target) {
  residual(v, r_, Accuracy::exact);
  const double unit = lanes_.unit;
  // A⁻¹ is at most (share·M)⁻¹, so this bounds the difference in the norm of the preconditioner.
  const double drift = sum_particles(v.size(), [&](std::size_t b, std::size_t e) {
    double sum = 0.0;
    for (std::size_t i = b; i < e; ++i)
      if (free_[i]) sum += (r_[i] - unit * lanes_.r[i]).squaredNorm() / (share_ * mass_[i]);
    return sum;
  });
  if (!(drift <= kDrift * std::max(target, lanes_.rz))) load(r_, lanes_);
  largest_ = lanes_.rz;
  return std::isfinite(drift);
}

/// As start(), in the norm of block Jacobi. Leaves the residual in r_, the preconditioned residual
/// in z_; returns their product.
double ImplicitSystem::start_in_double(std::span<Vec3> v) {
  const auto square = [&](std::span<const Vec3> x) {
    block_jacobi_.apply(x, z_);
    return dot(x, z_);
  };
  if (scaled_in_ != Norm::block_jacobi) {
    scaled_in_ = Norm::block_jacobi;
    set_old_velocities(v, p_);
    residual(p_, r_old_, Accuracy::exact);
    scale_ = std::max({kRoundingShare * kRoundingShare * square(magnitude_),
                       square(for_scale(applied_, r_)), square(for_scale(r_old_, r_))});
  }
  residual(v, r_, Accuracy::exact);
  return square(r_);
}

SolveReport ImplicitSystem::iterate(std::span<Vec3> v, double tolerance) {
  for (auto* vector : {&z_, &ap_}) vector->resize(v.size());
  block_jacobi_.set(a_, terms_, free_);
  double rz = start_in_double(v);
  const double target = tolerance * tolerance * scale_;
  SolveReport report;
  std::copy(z_.begin(), z_.end(), p_.begin());
  while (report.iterations < config_.max_iterations && !is_enough(rz, target, v)) {
    multiply(p_, ap_);
    const double pap = dot_free(p_, ap_);
    if (!(pap > 0.0)) break;  // NaN, or not positive definite
    const double alpha = rz / pap;
    parallel_for(r_.size(), even_grain(r_.size(), kParticles),
                 [&](std::size_t begin, std::size_t end) {
                   for (std::size_t i = begin; i < end; ++i) {
                     if (!free_[i]) continue;
                     v[i] += alpha * p_[i];
                     r_[i] -= alpha * ap_[i];
                   }
                 });
    block_jacobi_.apply(r_, z_);
    const double next = dot(r_, z_);
    const double beta = next / rz;
    rz = next;
    parallel_for(r_.size(), even_grain(r_.size(), kParticles),
                 [&](std::size_t begin, std::size_t end) {
                   for (std::size_t i = begin; i < end; ++i) p_[i] = z_[i] + beta * p_[i];
                 });
    ++report.iterations;
  }
  report_residual(rz, target, report);
  return report;
}

void ImplicitSystem::report_residual(double rz, double target, SolveReport& report) const {
  report.residual = scale_ > 0.0 ? std::sqrt(std::abs(rz) / scale_) : 0.0;
  if (!std::isfinite(rz) || !std::isfinite(scale_))
    report.residual = std::numeric_limits<double>::quiet_NaN();
  report.converged = rz >= 0.0 && rz <= target && !std::isnan(report.residual);
}

/// With non-finite forces there is no solution: sets NaN so that the guess is not taken for a
/// solution.
void ImplicitSystem::mark_non_finite(std::span<Vec3> v) const {
  for (std::size_t i = 0; i < v.size(); ++i)
    if (free_[i] && !r_[i].allFinite()) v[i].setConstant(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace selvedge::detail
