// SPDX-License-Identifier: MIT
//
// Position correction after [Provot1995]: a spring longer than its limit is shortened to the limit.
// Deviations: both ends move in inverse proportion to their masses, which conserves momentum, and
// sweeps continue until the worst excess is below the tolerance.
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/cloth/detail/coloring.h>
#include <selvedge/core/solver/detail/register_limiter.h>
#include <selvedge/core/solver/strain_limiter.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace selvedge {
namespace {

constexpr std::size_t kSpringGrain = 4096;

double strain_of(const Spring& s, std::span<const Vec3> x) {
  return (x[s.b] - x[s.a]).norm() / s.rest_length - 1.0;
}

void validate_limit(const Spring& s, double limit, std::size_t particles) {
  const auto n = static_cast<std::int32_t>(particles);
  if (s.a >= 0 && s.a < n && s.b >= 0 && s.b < n && s.a != s.b && s.rest_length > 0.0 &&
      limit >= 0.0)
    return;
  std::ostringstream text;
  text << "strain limit " << limit << " of the spring from particle " << s.a << " to " << s.b
       << " with rest_length " << s.rest_length << ": limits must be at least 0, lengths positive, "
       << "particles different and below " << particles;
  throw std::invalid_argument(text.str());
}

}  // namespace

StrainLimiter::StrainLimiter(std::span<const Spring> springs, std::span<const double> limits,
                             std::size_t particles, LimitedStrain limited)
    : limited_(limited) {
  if (springs.size() != limits.size())
    throw std::invalid_argument("strain limiter: " + std::to_string(limits.size()) +
                                " limits for " + std::to_string(springs.size()) + " springs");
  std::vector<std::int32_t> ends;
  ends.reserve(2 * springs.size());
  for (std::size_t i = 0; i < springs.size(); ++i) {
    validate_limit(springs[i], limits[i], particles);
    ends.push_back(springs[i].a);
    ends.push_back(springs[i].b);
  }
  detail::Coloring coloring = detail::color_elements(ends, 2, particles);
  springs_.reserve(springs.size());
  limits_.reserve(limits.size());
  for (const std::int32_t i : coloring.order) {
    springs_.push_back(springs[i]);
    limits_.push_back(limits[i]);
  }
  color_begin_ = std::move(coloring.color_begin);
}

StrainReport StrainLimiter::measure(std::span<const Vec3> x) const {
  const std::size_t ranges = (springs_.size() + kSpringGrain - 1) / kSpringGrain;
  std::vector<StrainReport> partial(ranges);
  parallel_for(springs_.size(), kSpringGrain, [&](std::size_t begin, std::size_t end) {
    StrainReport& worst = partial[begin / kSpringGrain];
    for (std::size_t i = begin; i < end; ++i) {
      const double strain = strain_of(springs_[i], x);
      worst.max_strain = std::max(worst.max_strain, strain);
      worst.excess = std::max(worst.excess, strain - limits_[i]);
      worst.compression_excess = std::max(worst.compression_excess, -strain - limits_[i]);
    }
  });
  StrainReport report;
  for (const StrainReport& p : partial) {
    report.max_strain = std::max(report.max_strain, p.max_strain);
    report.excess = std::max(report.excess, p.excess);
    report.compression_excess = std::max(report.compression_excess, p.compression_excess);
  }
  report.residual = std::max(report.residual, report.excess);
  if (limits_compression()) report.residual = std::max(report.residual, report.compression_excess);
  return report;
}

double StrainLimiter::allowed_length(std::size_t s, double length) const {
  const double rest = springs_[s].rest_length;
  const double shortest = limits_compression() ? std::max(0.0, 1.0 - limits_[s]) * rest : 0.0;
  return std::clamp(length, shortest, (1.0 + limits_[s]) * rest);
}

bool StrainLimiter::is_beyond(std::size_t s, double squared) const {
  const double rest = springs_[s].rest_length, longest = (1.0 + limits_[s]) * rest;
  if (!(squared <= longest * longest)) return true;
  if (!limits_compression() || squared <= 0.0) return false;
  const double shortest = (1.0 - limits_[s]) * rest;
  return shortest > 0.0 && squared < shortest * shortest;
}

StrainReport StrainLimiter::apply(std::span<const double> inv_mass, double tolerance,
                                  int max_sweeps, std::span<Vec3> x) const {
  SELVEDGE_ASSERT(inv_mass.size() == x.size());
  StrainReport report = measure(x);
  const auto is_above = [&](std::size_t s) {
    const double strain = strain_of(springs_[s], x);
    return strain - limits_[s] > tolerance ||
           (limits_compression() && -strain - limits_[s] > tolerance);
  };
  int sweeps = 0;
  std::size_t open = 0;  // one that was above at the last measure: while it is, none is needed
  while (report.residual > tolerance && sweeps < max_sweeps) {
    detail::for_each_color(color_begin_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Spring& s = springs_[i];
        const Vec3 d = x[s.b] - x[s.a];
        const double squared = d.squaredNorm(), mobility = inv_mass[s.a] + inv_mass[s.b];
        if (mobility <= 0.0 || !is_beyond(i, squared)) continue;
        const double length = std::sqrt(squared);
        const Vec3 move = ((1.0 - allowed_length(i, length) / length) / mobility) * d;
        x[s.a] += inv_mass[s.a] * move;
        x[s.b] -= inv_mass[s.b] * move;
      }
    });
    ++sweeps;
    if (sweeps < max_sweeps && is_above(open)) continue;
    report = measure(x);
    if (report.residual > tolerance)
      while (!is_above(open)) open = (open + 1) % springs_.size();
  }
  report.sweeps = sweeps;
  return report;
}

void StrainLimitMethod::find_held(std::span<const Vec3> x, double tolerance,
                                  std::vector<HeldStrain>& out) const {
  if (limiter() == nullptr) return;
  const std::span<const Spring> springs = limiter()->springs();
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const Spring& s = springs[i];
    const Vec3 d = x[s.b] - x[s.a];
    const double length = d.norm(), strain = length / s.rest_length - 1.0;
    const double limit = limiter()->limits()[i];
    if (!(length > 0.0)) continue;  // without a direction
    const Vec3 to_b = d / length;
    if (strain > limit - tolerance) out.push_back({{s.a, s.b, -1}, {to_b, -to_b, Vec3::Zero()}, 2});
    if (limiter()->limits_compression() && -strain > limit - tolerance)
      out.push_back({{s.a, s.b, -1}, {-to_b, to_b, Vec3::Zero()}, 2});
  }
}

void register_no_limiter(StrainLimiterRegistry& registry) {
  detail::register_policy(registry, "none",
                          {.promise = "no limit: springs stretch by their law alone",
                           .source = "",
                           .kind = LimiterKind::none});
}

}  // namespace selvedge
