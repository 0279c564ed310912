// SPDX-License-Identifier: MIT
//
// Pinched cloth that is held so fast that it would exceed its strain limit slips.
#include <selvedge/simulation/detail/pinches.h>
#include <selvedge/simulation/detail/step.h>
#include <selvedge/simulation/detail/strain_guard.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace selvedge::detail {
namespace {

/// Times that an attempt begins again because pinched cloth slips.
constexpr int kMostSlips = 8;

/// Sweeps over the springs of the cloth that find how far it slips.
constexpr int kSlipSweeps = 100;

/// Share of the rest gap that a slip has to exceed.
constexpr double kLeastSlip = 1e-3;

}  // namespace

void Pinches::begin_attempt() {
  slips_.clear();
  group_.clear();
  slipped_ = 0;
}

const Vec3* Pinches::slip_of(std::int32_t vertex) const {
  const auto at = std::lower_bound(slips_.begin(), slips_.end(), vertex,
                                   [](const Slip& s, std::int32_t v) { return s.vertex < v; });
  return at != slips_.end() && at->vertex == vertex ? &at->way : nullptr;
}

// Whether a spring at a held pinch is far above its limit.
bool Pinches::strains_far(const StrainLimiter& measures, std::span<const Vec3> x) const {
  for (std::size_t s = 0; s < measures.springs().size(); ++s) {
    const Spring& spring = measures.springs()[s];
    if (across_[spring.a].isZero() && across_[spring.b].isZero()) continue;
    const double strain = (x[spring.b] - x[spring.a]).norm() / spring.rest_length - 1.0;
    if (StrainGuard::is_far(strain / (measures.limits()[s] + kStrainTolerance) - 1.0)) return true;
  }
  return false;
}

// Moves the ends of springs above their limits: free particles anywhere, held pinches along the
// surfaces. Returns false once no spring is.
bool Pinches::slip_once(const StrainLimiter& measures, std::span<const double> inv_mass,
                        std::span<Vec3> x) const {
  bool moved = false;
  for (std::size_t s = 0; s < measures.springs().size(); ++s) {
    const Spring& spring = measures.springs()[s];
    const Vec3 d = x[spring.b] - x[spring.a];
    const double length = d.norm(), longest = (1.0 + measures.limits()[s]) * spring.rest_length;
    if (!(length > longest * (1.0 + kStrainTolerance))) continue;
    const Vec3 u = d / length;
    const auto along = [&](std::int32_t i) {
      const Vec3& n = across_[i];
      return n.isZero() ? Vec3(inv_mass[i] > 0.0 ? u : Vec3(Vec3::Zero())) : Vec3(u - n.dot(u) * n);
    };
    const Vec3 a = along(spring.a), b = along(spring.b);
    const double yielding = a.dot(u) + b.dot(u);
    if (!(yielding > 0.0)) continue;
    const double by = std::min((length - longest) / yielding, length - longest);
    x[spring.a] += by * a;
    x[spring.b] -= by * b;
    moved = true;
  }
  return moved;
}

// Held pinches end at `x`, m, from now on, and those of one group all move alike. Returns whether
// any has to.
bool Pinches::slip_to(std::span<const Vec3> x, const StepInput& in, std::span<const Vec3> x_t1) {
  std::map<std::int32_t, std::pair<Vec3, int>> motion;  // its sum, and the vertices, of each group
  for (const Held& held : held_) {
    auto& [sum, count] = motion.try_emplace(group_of(held.vertex), Vec3::Zero(), 0).first->second;
    sum += x[held.vertex] - in.x_t0[held.vertex];
    ++count;
  }
  bool moved = false;
  std::vector<Slip> slips;
  for (const Held& held : held_) {
    const auto& [sum, count] = motion.at(group_of(held.vertex));
    const Vec3 more = sum / count - (x_t1[held.vertex] - in.x_t0[held.vertex]);
    const Vec3* before = slip_of(held.vertex);
    moved = moved || more.norm() > kLeastSlip * held.rest_gap;
    slips.push_back({held.vertex, before != nullptr ? Vec3(*before + more) : more});
  }
  slips_ = std::move(slips);
  ++slipped_;
  return moved;
}

bool Pinches::slip(const StrainLimiter& measures, const StepInput& in, std::span<const Vec3> x_t1) {
  if (held_.empty() || slipped_ >= kMostSlips) return false;
  across_.assign(in.n(), Vec3::Zero());
  for (const Held& held : held_) across_[held.vertex] = held.across;
  const std::span<const Vec3> ends = x_t1.first(in.n());
  if (!strains_far(measures, ends)) return false;
  std::vector<Vec3> x(ends.begin(), ends.end());
  for (int sweep = 0; sweep < kSlipSweeps; ++sweep)
    if (!slip_once(measures, in.inv_mass, x)) break;
  return slip_to(x, in, ends);
}

std::int32_t Pinches::group_of(std::int32_t vertex) const {
  return group_.empty() ? vertex : group_[vertex];
}

// Particles that collide with each other belong to one group.
void Pinches::unite(std::span<const ContactPoint> collisions, std::size_t n) {
  if (group_.empty()) {
    group_.resize(n);
    std::iota(group_.begin(), group_.end(), 0);
  }
  const auto first = [&](std::int32_t i) {
    while (group_[i] != i) i = group_[i] = group_[group_[i]];
    return i;
  };
  for (const ContactPoint& c : collisions) {
    const std::int32_t a = *std::min_element(c.vertex.begin(), c.vertex.end());
    for (const std::int32_t v : c.vertex) {
      if (static_cast<std::size_t>(v) >= n) continue;
      const auto [low, high] = std::minmax({first(a), first(v)});
      group_[high] = low;
    }
  }
  for (std::size_t i = 0; i < n; ++i) group_[i] = first(static_cast<std::int32_t>(i));
}

bool Pinches::join(std::span<const ContactPoint> collisions, const StepInput& in,
                   std::span<const Vec3> x_t1) {
  if (held_.size() < 2 || slipped_ >= kMostSlips) return false;
  unite(collisions, in.n());
  return slip_to(x_t1, in, x_t1);
}

}  // namespace selvedge::detail
