// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>
#include <selvedge/core/force_sum.h>

#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace selvedge {

struct StrainReport {
  double max_strain = 0.0;  ///< largest (L-L0)/L0 left
  double residual =
      0.0;  ///< largest excess over its limit left: at most the tolerance when it converged
  int sweeps = 0;
  /// Largest strain less its limit, below 0 where all springs are within theirs; set by measure,
  /// -infinity without springs.
  double excess = -std::numeric_limits<double>::infinity();
};

/// Position correction [Provot1995], survey section 4.1, as mass-weighted Gauss-Seidel over a fixed
/// colouring until no spring exceeds its limit by more than `tolerance` (in strain), at most
/// `max_sweeps` sweeps. Particles with inv_mass 0 do not move. Momentum of the free ones is kept.
class StrainLimiter {
 public:
  StrainLimiter(std::span<const Spring> springs, std::span<const double> limits,
                std::size_t particles);

  StrainReport measure(std::span<const Vec3> x) const;
  /// Springs and limits, sorted by colour.
  std::span<const Spring> springs() const { return springs_; }
  std::span<const double> limits() const { return limits_; }
  std::span<const std::size_t> color_begin() const { return color_begin_; }
  StrainReport apply(std::span<const double> inv_mass, double tolerance, int max_sweeps,
                     std::span<Vec3> x) const;

 private:
  std::vector<Spring> springs_;  // sorted by colour
  std::vector<double> limits_;
  std::vector<std::size_t> color_begin_;
};

/// What a limiter may know of a step.
struct LimitStep {
  std::span<const Vec3> x_t0;        ///< m
  std::span<const double> inv_mass;  ///< 1/kg, 0: held
  double h = 0.0;                    ///< s
  double tolerance = 1e-3;           ///< strain above the limit that may be left
  int max_sweeps = 200;
};

/// What a limiter says of itself.
struct LimiterTraits {
  std::string_view promise, source;
  bool bounds_strain = true;    ///< goes on until the limits hold, if the pins allow it
  bool keeps_momentum = true;   ///< of free particles, to rounding
  bool keeps_velocity = false;  ///< what it moves does not change velocities
};

/// A way to keep springs within their strain limits (the super-elasticity of the survey, section
/// 4) that acts on the end of a step.
class StrainLimitMethod {
 public:
  virtual ~StrainLimitMethod() = default;
  virtual LimiterTraits traits() const = 0;
  /// Changes where particles end, m. Held ones stay.
  virtual StrainReport limit_ends(const LimitStep& step, std::span<Vec3> x_t1) = 0;
  /// Changes the velocities of the accepted step, m/s, that ended at `x`. Most do not.
  virtual void limit_velocities(const LimitStep& step, std::span<const Vec3> x, std::span<Vec3> v);
};

/// A limiter by name: a method, a force on the same springs, or neither.
struct StrainLimiterEntry {
  std::string_view promise, source;
  std::function<std::unique_ptr<StrainLimitMethod>(
      std::span<const Spring>, std::span<const double> limits, std::size_t particles)>
      make;
  std::function<std::unique_ptr<Force>(std::span<const Spring>, std::span<const double> limits,
                                       std::size_t particles)>
      make_force;
};
using StrainLimiterRegistry = std::map<std::string, StrainLimiterEntry>;
StrainLimiterRegistry strain_limiters();

// Members that act on the end of a step; each file names its paper.
std::unique_ptr<StrainLimitMethod> make_position_limiter(std::span<const Spring>,
                                                         std::span<const double> limits,
                                                         std::size_t particles, bool with_velocity);
/// The worst springs first, by buckets; `priority`: a particle that was moved once moves less.
struct OrderedConfig {
  bool priority = false;
  bool with_velocity = false;  ///< springs at their limit do not go on stretching
};
std::unique_ptr<StrainLimitMethod> make_ordered_limiter(std::span<const Spring>,
                                                        std::span<const double> limits,
                                                        std::size_t particles,
                                                        const OrderedConfig& config);
std::unique_ptr<StrainLimitMethod> make_velocity_limiter(std::span<const Spring>,
                                                         std::span<const double> limits,
                                                         std::size_t particles, bool as_printed);
std::unique_ptr<StrainLimitMethod> make_position_velocity_limiter(std::span<const Spring>,
                                                                  std::span<const double> limits,
                                                                  std::size_t particles);

/// How springs get stiffer near their limit.
enum class StiffeningLaw {
  bayraktar,          ///< K L/l_allowed beyond l_allowed [survey eq. 12, continuous]
  bayraktar_printed,  ///< K L/L0 beyond l_allowed: jumps there
  tangent,            ///< K times a tangent that diverges at the limit [survey eq. 13 inverted]
  tangent_printed,    ///< eq. 13 as printed: an arc tangent, which softens
};
/// What such a law adds to Hooke's on the same springs.
std::unique_ptr<Force> make_stiffening_force(std::span<const Spring>,
                                             std::span<const double> limits, std::size_t particles,
                                             StiffeningLaw law);

/// What Provot's critical step is for a cloth [survey eq. 11 mended].
struct CriticalStep {
  double provot_stiffness = 0.0;  ///< N/m, π² m/h² of the lightest particle, as usually quoted
  double mass_stiffness = 0.0;    ///< N/m, 4 m/h²: exact for one mass on one spring
  double longest_step = 0.0;      ///< s, 2/sqrt(λ_max), by power iteration
  double safe_step = 0.0;         ///< s, the same by Gershgorin's bound, never longer
  double stiffening = 0.0;        ///< factor on all stiffnesses that a step of h would still bear
};
/// For explicit steps of h from rest at x. Throws std::invalid_argument unless h > 0.
CriticalStep critical_step(ForceSum& forces, const Particles& particles, double h);

/// Chittaro's policy [survey 4]: leave a cloth that is stiff enough as it is, make one that is not
/// stiffer, and its step shorter to bear that.
struct StiffnessPolicy {
  double strain = 0.0;     ///< that the weight of the cloth, hung by one side, gives it
  double stiffness = 1.0;  ///< factor, >= 1
  double step = 1.0;       ///< factor, 1/sqrt(stiffness)
};
/// `weight`: N per metre of width of the longest strip that may hang; `stretch_stiffness`: N/m.
StiffnessPolicy chittaro_policy(double weight, double stretch_stiffness, double limit);

}  // namespace selvedge
