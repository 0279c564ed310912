// SPDX-License-Identifier: MIT
//
// Springs that stiffen near their limit, as a force in addition to Hooke's law on the same springs.
// K: stiffness, L0: rest length, l = (1 + τ) L0: allowed length.
// - bayraktar [Bayraktar2007; survey eq. 12]: K' = K L/L0 for L >= l, which jumps by the factor
//   l/L0 there. The continuous version is K' = K L/l. Both grow only linearly and cannot bound the
//   strain.
// - tangent: survey eq. 13 [ZhibinZhanli2006] prints F = (L0/5π) atan(5π ΔL/L0), without K. As a
//   force it softens: it saturates at 0.1 K L0 instead of becoming stiff. It maps elongations to
//   elongations below the limit. Its inverse, F = K (L0/5π) tan(5π ΔL/L0), has the slope K at rest
//   and diverges at 10 %; for any τ, F = K (2 τ L0/π) tan(π ΔL/(2 τ L0)). Beyond 0.9 τ the force
//   continues straight with its slope there, 41 K: a step may exceed the limit, and explicit steps
//   must be stable for that slope.
//
// Guarantee: minus the gradient of an energy; the laws as printed are available beside the
// corrected ones.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/element_force.h>
#include <selvedge/core/solver/strain_limiter.h>

#include <numbers>

namespace selvedge {
namespace {

using detail::Tension;

// Fraction of the limit up to which the tangent is used.
constexpr double kFollowed = 0.9;

/// K' ΔL - K ΔL with K' = K L/reference for L beyond l.
Tension grow_by_length(double k, double l0, double l, double reference, double length) {
  if (length < l) return {};
  const double d = length - l0;
  // ∫ K (y/r - 1)(y - l0) dy from l to L
  const auto integral = [&](double y) {
    return k * (y * y * y / (3.0 * reference) - 0.5 * y * y * (1.0 + l0 / reference) + l0 * y);
  };
  const double extra = length / reference - 1.0;
  return {integral(length) - integral(l), k * extra * d, k * (extra + d / reference)};
}

/// The tangent law minus K ΔL, and the arc tangent minus K ΔL.
Tension tangent(double k, double l0, double limit, double length) {
  const double d = length - l0, scale = 2.0 * limit * l0 / std::numbers::pi;
  if (d <= 0.0) return {};
  const double most = kFollowed * limit * l0, followed = std::min(d, most);
  const double t = elementary::tan(followed / scale), slope = k * (1.0 + t * t);
  const double beyond = d - followed, force = k * scale * t;
  const double energy = -k * scale * scale * elementary::log(elementary::cos(followed / scale)) +
                        beyond * (force + 0.5 * slope * beyond);
  return {energy - 0.5 * k * d * d, force + slope * beyond - k * d, slope - k};
}

Tension arc_tangent(double k, double l0, double limit, double length) {
  const double d = length - l0, scale = 2.0 * limit * l0 / std::numbers::pi, q = d / scale;
  if (d <= 0.0) return {};
  const double energy =
      k * scale * scale * (q * elementary::atan(q) - 0.5 * elementary::log1p(q * q));
  return {energy - 0.5 * k * d * d, k * scale * elementary::atan(q) - k * d, k / (1.0 + q * q) - k};
}

class StiffeningSprings {
 public:
  static constexpr int arity = 2;
  static constexpr const char* name = "stiffening spring";

  StiffeningSprings(std::span<const Spring> springs, std::span<const double> limits,
                    StiffeningLaw law)
      : law_(law) {
    if (springs.size() != limits.size())
      throw std::invalid_argument("stiffening springs: " + std::to_string(limits.size()) +
                                  " limits for " + std::to_string(springs.size()) + " springs");
    for (std::size_t i = 0; i < springs.size(); ++i) {
      detail::require_number_of("rest_length", name, i, springs[i].rest_length, false);
      detail::require_number_of("stiffness", name, i, springs[i].stiffness, false);
      detail::require_number_of("limit", name, i, limits[i], false);
      springs_.push_back({springs[i], limits[i]});
    }
  }

  std::size_t size() const { return springs_.size(); }
  std::int32_t particle(std::size_t e, int k) const {
    return k == 0 ? springs_[e].spring.a : springs_[e].spring.b;
  }
  void reorder(std::span<const std::int32_t> order) { detail::reorder(springs_, order); }

  detail::ElementSample<2> sample(std::size_t e, std::span<const Vec3> x) const {
    const Spring& s = springs_[e].spring;
    const double limit = springs_[e].limit;
    const double k = s.stiffness, l0 = s.rest_length, l = (1.0 + limit) * l0;
    return detail::sample_link(x[s.a], x[s.b], 0.0, [&](double length) {
      switch (law_) {
        case StiffeningLaw::bayraktar:
          return grow_by_length(k, l0, l, l, length);
        case StiffeningLaw::bayraktar_printed:
          return grow_by_length(k, l0, l, l0, length);
        case StiffeningLaw::tangent:
          return tangent(k, l0, limit, length);
        case StiffeningLaw::tangent_printed:
          return arc_tangent(k, l0, limit, length);
      }
      return Tension{};
    });
  }

 private:
  struct Limited {
    Spring spring;
    double limit;
  };
  StiffeningLaw law_;
  std::vector<Limited> springs_;
};

}  // namespace

std::unique_ptr<Force> make_stiffening_force(std::span<const Spring> springs,
                                             std::span<const double> limits, std::size_t particles,
                                             StiffeningLaw law) {
  return std::make_unique<detail::ElementForce<StiffeningSprings>>(
      StiffeningSprings(springs, limits, law), particles);
}

void register_stiffening_forces(StrainLimiterRegistry& registry) {
  const auto add = [&](const char* name, StiffeningLaw law, const char* promise,
                       const char* source) {
    const LimiterTraits traits{
        .promise = promise, .source = source, .bounds_strain = false, .kind = LimiterKind::force};
    const auto make = [law](const MethodOptions&, std::span<const Spring> s,
                            std::span<const double> l, std::size_t n) {
      return StrainLimit{.method = nullptr, .force = make_stiffening_force(s, l, n, law)};
    };
    registry.add(name, {}, make, traits);
  };
  add("bayraktar", StiffeningLaw::bayraktar, "stiffer beyond the limit, continuous; bounds nothing",
      "Bayraktar et al. 2007; survey eq. 12 corrected");
  add("bayraktar_as_printed", StiffeningLaw::bayraktar_printed,
      "stiffer beyond the limit, where the force jumps; bounds nothing",
      "Bayraktar et al. 2007; survey eq. 12");
  add("zhibin", StiffeningLaw::tangent, "41 times as stiff near the limit; slope of Hooke at rest",
      "Zhibin, Zhanli 2006; survey eq. 13 inverted");
  add("zhibin_as_printed", StiffeningLaw::tangent_printed,
      "softens: its force is at most 10 % of K L0", "Zhibin, Zhanli 2006; survey eq. 13");
  registry.add_keyed("biphasic", "materials.*.stretch_law",
                     {.promise = "stiffer above a strain, continuous; a law of the springs",
                      .source = "Chen, Zhu, Kaufman, Physically based animation, 1998",
                      .bounds_strain = false,
                      .kind = LimiterKind::force});
}

}  // namespace selvedge
