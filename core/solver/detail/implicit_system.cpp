// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/solver/detail/implicit_system.h>
#include <selvedge/core/solver/detail/particle_ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace selvedge::detail {
namespace {

// Rows of the matrix that are summed together: 200 kB of a sheet's.
constexpr std::size_t kMatrixGrain = 128;
// Blocks that are scaled together.
constexpr std::size_t kScaleGrain = 2048;

// Rounding of a point on a line and of its share of the way, by its greatest coordinate.
constexpr double kOnLine = 1e-14;

// A particle is heavy if it has more than this multiple of the harmonic mean of the masses. What
// hangs from light cloth, or lies on it, must not set the accuracy of the cloth: with heavy
// particles, each counts for the scale of the residual with at most that mean.
constexpr double kHeavy = 16.0;

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

}  // namespace selvedge::detail
