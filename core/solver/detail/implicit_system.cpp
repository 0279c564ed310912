// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/detail/even_grain.h>
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/solver/detail/implicit_system.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace selvedge::detail {
namespace {

// Least number of particles per task: 5 µs of work.
constexpr std::size_t kParticles = 1024;
// Rows of the matrix that are summed together: 200 kB of a sheet's.
constexpr std::size_t kMatrixGrain = 128;
// Blocks that are scaled together.
constexpr std::size_t kScaleGrain = 2048;

// Fraction of the single forces below which their sum is rounding error: 1e-16 of a length, and the
// strain is about a hundredth of a length.
constexpr double kRoundingShare = 1e-12;

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
// Rounding of a point on a line and of its share of the way, by its greatest coordinate.
constexpr double kOnLine = 1e-14;

// A particle is heavy if it has more than this multiple of the harmonic mean of the masses. What
// hangs from light cloth, or lies on it, must not set the accuracy of the cloth: with heavy
// particles, each counts for the scale of the residual with at most that mean.
constexpr double kHeavy = 16.0;

/// Sum of body(begin, end) over ranges of n particles.
template <class Body>
double sum_particles(std::size_t n, const Body& body) {
  return parallel_sum(n, even_grain(n, kParticles), body);
}

double dot(std::span<const Vec3> a, std::span<const Vec3> b) {
  return sum_particles(a.size(), [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) sum += a[i].dot(b[i]);
    return sum;
  });
}

// Ranges of particles whose results fit on the stack.
constexpr std::size_t kMostRanges = 64;

double greatest_coordinate(std::span<const Vec3> x) {
  std::array<double, kMostRanges> greatest{};
  const std::size_t grain = even_grain(x.size(), std::max(kParticles, x.size() / kMostRanges + 1));
  parallel_for(x.size(), grain, [&](std::size_t begin, std::size_t end) {
    double& own = greatest[begin / grain];
    for (std::size_t i = begin; i < end; ++i) own = std::max(own, x[i].cwiseAbs().maxCoeff());
  });
  return *std::max_element(greatest.begin(), greatest.end());
}

/// Calls body(i) for each i < n, in parallel.
template <class Body>
void for_particles(std::size_t n, const Body& body) {
  parallel_for(n, even_grain(n, kParticles), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
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
  for (auto* vector : {&r_, &p_, &r_old_}) vector->resize(n);
  for (auto* vector :
       {&lanes_.r, &lanes_.z, &other_.r, &other_.z, &direction_, &image_, &correction_})
    vector->resize(n);
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
  std::vector<Vec3>& f = r_;  // of one force; zero before the next
  for_particles(f.size(), [&](std::size_t i) {
    for (auto* vector : {&applied_, &magnitude_, &f}) (*vector)[i].setZero();
  });
  for (std::size_t k = 0; k < forces_.size(); ++k) {
    forces_[k]->add_force(state, f);
    for_particles(f.size(), [&](std::size_t i) {
      const Vec3 impulse = h * f[i];
      f[i].setZero();
      b_[i] += impulse;
      if (!free_[i]) return;
      magnitude_[i] += impulse.cwiseAbs();
      if (outside_[k]) applied_[i] += impulse.cwiseAbs();
    });
  }
}

void ImplicitSystem::hold(const Particles& particles) {
  SELVEDGE_ASSERT(particles.size() == b_.size());
  followers_ = particles.followers;
  for_particles(b_.size(), [&](std::size_t i) {
    v_old_[i] = particles.v[i];
    mass_[i] = particles.mass[i];
    free_[i] = particles.inv_mass[i] > 0.0;
  });
  find_heavy(particles);
}

void ImplicitSystem::find_heavy(const Particles& particles) {
  double free = 0.0, inverse = 0.0, heaviest = 0.0;
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    if (!(particles.inv_mass[i] > 0.0)) continue;
    free += 1.0;
    inverse += 1.0 / mass_[i];
    heaviest = std::max(heaviest, mass_[i]);
  }
  light_ = free / inverse;
  has_heavy_ = heaviest > kHeavy * light_;
}

/// Impulses as they count for the scale of the residual: x itself or, with heavy particles, `out`.
std::span<const Vec3> ImplicitSystem::for_scale(std::span<const Vec3> x,
                                                std::span<Vec3> out) const {
  if (!has_heavy_) return x;
  for_particles(x.size(), [&](std::size_t i) {
    out[i] = std::sqrt(std::min(1.0, light_ / mass_[i])) * x[i];
  });
  return out;
}

/// share·M + gain·J(tau).
void ImplicitSystem::set_matrix(const SystemAt& system, double tau, double share, double gain) {
  by_rows_.clear();
  for (const auto& force : forces_) {
    const JacobianRows* rows = force->jacobian_rows(system.at, tau);
    if (rows == nullptr) break;
    by_rows_.push_back(rows);
  }
  const bool whole = by_rows_.size() == forces_.size();
  parallel_for(b_.size(), kMatrixGrain, [&](std::size_t first, std::size_t last) {
    a_.set_zero(first, last);
    for (std::size_t i = first; i < last; ++i)
      a_.diagonal(i).diagonal().setConstant(share / gain * mass_[i]);
    for (const JacobianRows* rows : by_rows_) rows->add_rows(first, last, a_);
    if (whole && gain != 1.0) {  // while they are in the cache
      const auto begin = static_cast<std::size_t>(a_.row_begin()[first]);
      const auto end = static_cast<std::size_t>(a_.row_begin()[last]);
      for (Mat3& block : a_.values().subspan(begin, end - begin)) block *= gain;
    }
  });
  for (std::size_t k = by_rows_.size(); k < forces_.size(); ++k)
    forces_[k]->add_jacobian(system.at, tau, a_);
  if (whole || gain == 1.0) return;
  const std::span<Mat3> blocks = a_.values();
  parallel_for(blocks.size(), kScaleGrain, [&](std::size_t first, std::size_t last) {
    for (Mat3& block : blocks.subspan(first, last - first)) block *= gain;
  });
}

void ImplicitSystem::assemble(const SystemAt& system) {
  require_number("step", system.h, false);
  share_ = system.plain.empty() ? system.share : std::min(system.share, 1.0);  // of any particle
  for_particles(b_.size(), [&](std::size_t i) { b_[i] = mass_[i] * system.momentum[i]; });
  set_matrix(system, system.tau, system.share, system.gain);
  if (!system.plain.empty()) {
    // No block connects two pieces, so the rows of one come from one matrix.
    other_values_.assign(a_.values().begin(), a_.values().end());
    set_matrix(system, system.h, 1.0, 1.0);
    const std::span<const std::int32_t> row = a_.row_begin();
    for (std::size_t i = 0; i < b_.size(); ++i)
      if (!system.plain[i])
        std::copy(other_values_.begin() + row[i], other_values_.begin() + row[i + 1],
                  a_.values().begin() + row[i]);
  }
  add_forces(system.at, system.h);
  assembled_ = system;
  set_changed_matrix();
}

void ImplicitSystem::add_jacobian_times(std::span<const Vec3> v) {
  find_product(v, Accuracy::exact);
  for_particles(b_.size(),
                [&](std::size_t i) { b_[i] += end_.av[i] - (share_ * mass_[i]) * v[i]; });
}

void ImplicitSystem::set_mass(std::span<const std::int32_t> particles, std::span<const double> mass,
                              std::span<const Vec3> momentum) {
  for (const std::int32_t i : particles) {
    const double change = mass[i] - mass_[i];
    a_.diagonal(i).diagonal().array() += share_ * change;
    b_[i] += change * momentum[i];
    mass_[i] = mass[i];
  }
  set_changed_matrix();
}

/// Call when A has changed.
void ImplicitSystem::set_changed_matrix() {
  multilevel_.set_matrix(a_, free_, assembled_.at.x);
  scaled_in_ = Norm::none;
  begin_.v.clear();
  end_.v.clear();
}

std::span<const Vec3> ImplicitSystem::unbalanced(std::span<const Vec3> v) {
  set_old_velocities(v, p_);
  return unbalanced_at(p_);
}

std::span<const Vec3> ImplicitSystem::unbalanced_at(std::span<const Vec3> v) {
  terms_.reset({}, b_.size(), followers_);
  residual(v, r_old_, Accuracy::exact);
  return r_old_;
}

double ImplicitSystem::residual_norm(std::span<const ImplicitTerm> terms, std::span<const Vec3> v) {
  terms_.reset(terms, b_.size(), followers_);
  residual(v, r_, Accuracy::exact);
  double sum = 0.0;
  for (std::size_t i = 0; i < r_.size(); ++i) sum += r_[i].squaredNorm() / mass_[i];
  return std::sqrt(sum);
}

double ImplicitSystem::residual_scale() {
  const std::span<const Vec3> applied = for_scale(applied_, p_);
  double from_outside = 0.0, all = 0.0;
  for (std::size_t i = 0; i < applied_.size(); ++i) {
    from_outside += applied[i].squaredNorm() / mass_[i];
    all += magnitude_[i].squaredNorm() / mass_[i];
  }
  return std::sqrt(std::max(from_outside, kRoundingShare * kRoundingShare * all));
}

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

void ImplicitSystem::multiply(std::span<const Vec3> x, std::span<Vec3> y) {
  a_.multiply(x, y);
  if (!terms_.empty()) terms_.add_multiply(x, y);
}

/// out = b − (A + T) v on the free particles, 0 on the held ones.
void ImplicitSystem::residual(std::span<const Vec3> v, std::span<Vec3> out, Accuracy accuracy) {
  find_product(v, accuracy);
  for_particles(b_.size(), [&](std::size_t i) { out[i] = b_[i] - end_.av[i]; });
  terms_.add_residual(v, out);
  for_particles(b_.size(), [&](std::size_t i) {
    if (!free_[i]) out[i].setZero();
  });
}

/// Sets end_ to v and A v. With Accuracy::any, it reuses the products of the last solve where it
/// can.
void ImplicitSystem::find_product(std::span<const Vec3> v, Accuracy accuracy) {
  const bool known = std::equal(end_.v.begin(), end_.v.end(), v.begin(), v.end());
  if (known && (end_.exact || accuracy == Accuracy::any)) return;
  if (accuracy == Accuracy::any && interpolate_product(v)) return;
  end_.v.resize(v.size());
  end_.av.resize(v.size());
  for_particles(v.size(), [&](std::size_t i) { end_.v[i] = v[i]; });
  end_.exact = true;
  a_.multiply(v, end_.av);
  bytes_ +=
      a_.values().size() * (sizeof(Mat3) + sizeof(std::int32_t)) + 2 * v.size() * sizeof(Vec3);
}

/// A response may pull the velocities back on the line from where the last solve began to where it
/// ended. There A v follows from the products at both ends. Returns false elsewhere.
bool ImplicitSystem::interpolate_product(std::span<const Vec3> v) {
  if (begin_.v.size() != v.size() || end_.v.size() != v.size()) return false;
  const auto sum = [&](const auto& of) {
    return sum_particles(v.size(), [&](std::size_t begin, std::size_t end) {
      double all = 0.0;
      for (std::size_t i = begin; i < end; ++i) all += of(i, end_.v[i] - begin_.v[i]);
      return all;
    });
  };
  const double length = sum([](std::size_t, const Vec3& way) { return way.squaredNorm(); });
  if (!(length > 0.0)) return false;
  const double share =
      sum([&](std::size_t i, const Vec3& way) { return way.dot(v[i] - begin_.v[i]); }) / length;
  const double size = std::max(greatest_coordinate(begin_.v), greatest_coordinate(end_.v));
  const double off = sum_particles(v.size(), [&](std::size_t b, std::size_t e) {
    double count = 0.0;
    for (std::size_t i = b; i < e; ++i) {
      const Vec3 on_line = begin_.v[i] + share * (end_.v[i] - begin_.v[i]);
      if (!((v[i] - on_line).cwiseAbs().maxCoeff() <= kOnLine * size)) count += 1.0;
    }
    return count;
  });
  if (off > 0.0) return false;
  end_.exact = end_.exact && begin_.exact;
  for_particles(v.size(), [&](std::size_t i) {
    end_.av[i] = begin_.av[i] + share * (end_.av[i] - begin_.av[i]);
    end_.v[i] = v[i];
  });
  return true;
}

/// Stores where the solve begins: at end_.
void ImplicitSystem::note_begin() {
  begin_.v.resize(end_.v.size());
  begin_.av.resize(end_.av.size());
  begin_.exact = end_.exact;
  for_particles(end_.v.size(), [&](std::size_t i) {
    begin_.v[i] = end_.v[i];
    begin_.av[i] = end_.av[i];
  });
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
