// SPDX-License-Identifier: MIT
//
// The momentum of a solved step: which forces gave it, and that of the residual.
#include <selvedge/core/solver/detail/implicit_system.h>

#include <algorithm>
#include <numeric>

namespace selvedge::detail {

void ImplicitSystem::net_impulses(std::span<const Vec3> v, std::vector<Vec3>& out) {
  const std::size_t n = b_.size();
  find_product(v, Accuracy::exact);
  out.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    out[i] = b_[i] - end_.av[i] + mass_[i] * (share_ * v[i] - v_old_[i]);
}

void ImplicitSystem::force_impulses(std::span<const Vec3> v, std::span<const Vec3> from,
                                    ForceImpulses& out) {
  const std::size_t n = b_.size();
  net_impulses(v, out.all);
  out.external.assign(n, Vec3::Zero());
  const SystemAt& s = assembled_;
  BlockMatrix jacobian = a_;  // the pattern to which the forces are bound
  jacobian.set_zero();
  std::vector<Vec3> relative(n), damped(n);
  for (std::size_t k = 0; k < forces_.size(); ++k) {
    if (!forces_[k]->is_external()) continue;
    forces_[k]->add_force(s.at, out.external);
    forces_[k]->add_jacobian(s.at, s.tau, jacobian);
  }
  for (std::size_t i = 0; i < n; ++i) relative[i] = v[i] - from[i];
  jacobian.multiply(relative, damped);
  for (std::size_t i = 0; i < n; ++i) out.external[i] = s.h * out.external[i] - s.gain * damped[i];
}

/// For each particle the group of pieces that contacts join, if nothing in it is held or tied to a
/// place and no contact of it is with something outside; else -1.
std::vector<std::int32_t> ImplicitSystem::closed_groups() {
  const std::span<const std::int32_t> piece = pieces_.of_particles();
  std::vector<std::int32_t> group(pieces_.count());
  std::iota(group.begin(), group.end(), 0);
  std::vector<char> open(group.size(), 0);
  const auto root = [&](std::int32_t p) {
    while (group[p] != p) p = group[p] = group[group[p]];
    return p;
  };
  for (const ImplicitTerm& term : terms_.terms()) {
    std::int32_t first = -1;
    for (int k = 0; k < 4; ++k)
      for_each_row(term, k, followers_, [&](std::int32_t i, double) {
        const std::int32_t own = root(piece[i]);
        if (first < 0)
          first = own;
        else
          group[std::max(root(first), own)] = std::min(root(first), own);
      });
    for (int k = 0; k < 4; ++k)
      if (first >= 0 && term.particle[k] < 0 && term.weight[k] != 0.0) open[first] = 1;
  }
  std::vector<double> ties(piece.size(), 0.0);
  for (const auto& force : forces_) force->add_ties(assembled_.at, ties);
  std::vector<std::int32_t> of(piece.size());
  for (std::size_t p = 0; p < group.size(); ++p)
    if (open[p] != 0) open[root(static_cast<std::int32_t>(p))] = 1;
  for (std::size_t i = 0; i < of.size(); ++i) {
    of[i] = root(piece[i]);
    if (free_[i] == 0 || ties[i] > 0.0) open[of[i]] = 1;
  }
  for (std::int32_t& g : of)
    if (open[g] != 0) g = -1;
  return of;
}

void ImplicitSystem::keep_momentum(std::span<Vec3> v) {
  residual(v, r_, Accuracy::exact);
  const std::vector<std::int32_t> group = closed_groups();
  std::vector<Vec3> left(pieces_.count(), Vec3::Zero());
  std::vector<double> mass(left.size(), 0.0);
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (group[i] < 0) continue;
    left[group[i]] += r_[i];
    mass[group[i]] += share_ * mass_[i];
  }
  for (std::size_t i = 0; i < v.size(); ++i)
    if (group[i] >= 0) v[i] += left[group[i]] / mass[group[i]];
}

}  // namespace selvedge::detail
