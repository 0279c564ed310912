// SPDX-License-Identifier: MIT
//
// Critical step [Provot1995; survey eq. 11, printed upside down]. K_c = π² m/h² is usually quoted
// as the largest stiffness for which explicit steps of h are stable. One mass on one spring is
// stable up to 4 m/h² with symplectic Euler or Verlet. A net of springs is stable only up to a much
// smaller stiffness, because each particle has many springs: 0.395 m/h² if Provot's three kinds of
// springs have the same constant. The critical step of a cloth is h = 2/sqrt(λ_max(M⁻¹K)), found
// here by power iteration on differences of the forces. Chittaro's policy (L. Chittaro, D.
// Corvaglia, "3D virtual clothing", 2003; survey 4) leaves a coarse mesh unchanged and gives a fine
// one larger constants and the shorter step that they need. The survey says neither how coarse nor
// how much larger. Here the factor is the one that keeps a strip hanging under its own weight
// within its limit.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/solver/detail/register_limiter.h>
#include <selvedge/core/solver/strain_limiter.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace selvedge {
namespace {

constexpr int kIterations = 300;
constexpr double kSettled = 1e-6;  // relative change of the frequency between two iterations

// Relative displacement, in units of the size of the cloth, for force differences: the square root
// of the relative rounding error.
constexpr double kDifference = 1e-8;

/// A displacement that excites every mode, the same in every run.
Vec3 scattered(std::size_t i) {
  const auto k = static_cast<double>(i);
  return {elementary::sin(1.7 * k * k), elementary::cos(2.3 * k), elementary::sin(0.9 * k + 1.0)};
}

double size_of(std::span<const Vec3> x) {
  Vec3 low = x[0], high = x[0];
  for (const Vec3& p : x) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

/// Largest λ of -M⁻¹ ∂F/∂x.
double largest_eigenvalue(const ForceSum& forces, const Particles& p) {
  const std::size_t n = p.size();
  const double tiny = kDifference * std::max(size_of(p.x), kDifference);
  std::vector<Vec3> d(n), x(n), a(n), a0(n), still(n, Vec3::Zero());
  for (std::size_t i = 0; i < n; ++i)
    d[i] = p.inv_mass[i] > 0.0 ? scattered(i) : Vec3(Vec3::Zero());
  forces.accelerate({p.x, still, p.mass, 0.0}, p.inv_mass, a0);
  double lambda = 0.0;
  for (int k = 0; k < kIterations; ++k) {
    double norm = 0.0;
    for (const Vec3& u : d) norm += u.squaredNorm();
    if (!(norm > 0.0)) return 0.0;
    for (Vec3& u : d) u /= std::sqrt(norm);
    const double scale = tiny * std::sqrt(static_cast<double>(n));
    for (std::size_t i = 0; i < n; ++i) x[i] = p.x[i] + scale * d[i];
    forces.accelerate({x, still, p.mass, 0.0}, p.inv_mass, a);
    double image = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      d[i] = (a0[i] - a[i]) / scale;
      image += d[i].squaredNorm();
    }
    const double next = std::sqrt(image);
    const bool settled = std::abs(next - lambda) <= kSettled * next;
    lambda = next;
    if (settled) break;
  }
  return lambda;
}

}  // namespace

CriticalStep critical_step(ForceSum& forces, const Particles& p, double h) {
  detail::require_number("step", h, false);
  CriticalStep step;
  double lightest = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) lightest = std::max(lightest, p.inv_mass[i]);
  if (!(lightest > 0.0)) return step;
  step.mass_stiffness = 4.0 / (lightest * h * h);
  step.provot_stiffness = std::numbers::pi * std::numbers::pi / (lightest * h * h);
  const double lambda = largest_eigenvalue(forces, p);
  const double bound = forces.bound(p, 0.0).omega;
  const double forever = std::numeric_limits<double>::infinity();
  step.longest_step = lambda > 0.0 ? 2.0 / std::sqrt(lambda) : forever;
  step.safe_step = bound > 0.0 ? 2.0 / bound : forever;
  step.stiffening = (step.longest_step / h) * (step.longest_step / h);
  return step;
}

StiffnessPolicy chittaro_policy(double weight, double stretch_stiffness, double limit) {
  detail::require_number("weight", weight);
  detail::require_number("stretch_stiffness", stretch_stiffness, false);
  detail::require_number("limit", limit, false);
  StiffnessPolicy policy;
  policy.strain = weight / stretch_stiffness;
  policy.stiffness = std::max(1.0, policy.strain / limit);
  policy.step = 1.0 / std::sqrt(policy.stiffness);
  return policy;
}

void register_step_policies(StrainLimiterRegistry& registry) {
  detail::register_policy(
      registry, "critical_step",
      {.promise = "limits nothing; reports the stable explicit step and stiffness",
       .source = "Provot 1995; survey eq. 11 corrected",
       .bounds_strain = false,
       .kind = LimiterKind::critical_step});
  detail::register_policy(
      registry, "chittaro",
      {.promise = "larger constants and shorter steps if the weight of the cloth requires them",
       .source = "Chittaro, Corvaglia, 3D virtual clothing, 2003; survey 4",
       .bounds_strain = false,
       .kind = LimiterKind::stiffens});
}

}  // namespace selvedge
