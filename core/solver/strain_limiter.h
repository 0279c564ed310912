// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/registry.h>
#include <selvedge/core/cloth/cloth_elements.h>
#include <selvedge/core/cloth/force.h>

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace selvedge {

/// Outcome of a strain limiter.
struct StrainReport {
  double max_strain = 0.0;  ///< largest remaining (L-L0)/L0
  /// Largest remaining excess over a spring's limit; at most the tolerance if the limiter
  /// converged.
  double residual = 0.0;
  int sweeps = 0;
  /// Largest difference of strain and limit; negative if all springs are within their limits. Set
  /// by `measure`; -infinity without springs.
  double excess = -std::numeric_limits<double>::infinity();
  /// The same of compression, which a spring may have as much of as of stretch: largest difference
  /// of -(L-L0)/L0 and limit.
  double compression_excess = -std::numeric_limits<double>::infinity();
};

/// The springs that a method changes. It leaves an end alone at which no spring has such a strain.
enum class LimitedStrain : std::uint8_t {
  any,                      ///< it may change every end; none is left out
  stretch,                  ///< springs longer than (1 + limit) L0
  stretch_and_compression,  ///< these, and springs shorter than (1 - limit) L0
};

/// Position correction [Provot1995; survey 4.1] by mass-weighted Gauss-Seidel sweeps over a fixed
/// colouring. It stops when no spring exceeds its limit by more than `tolerance` (in strain), or
/// after `max_sweeps` sweeps. Particles with inv_mass 0 do not move; the momentum of the free
/// particles is conserved.
class StrainLimiter {
 public:
  StrainLimiter(std::span<const Spring> springs, std::span<const double> limits,
                std::size_t particles, LimitedStrain limited = LimitedStrain::stretch);

  /// Strains at the positions x; changes nothing.
  StrainReport measure(std::span<const Vec3> x) const;
  /// Springs and limits, sorted by colour.
  std::span<const Spring> springs() const { return springs_; }
  std::span<const double> limits() const { return limits_; }
  std::span<const std::size_t> color_begin() const { return color_begin_; }
  LimitedStrain limited() const { return limited_; }
  bool limits_compression() const { return limited_ == LimitedStrain::stretch_and_compression; }
  /// The length, m, nearest to `length` that spring s may have.
  double allowed_length(std::size_t s, double length) const;
  /// Whether spring s is beyond its limit with a length whose square is `squared`, m². A spring
  /// without length has no direction and is not.
  bool is_beyond(std::size_t s, double squared) const;
  /// Moves the particles at x, m, until the limits hold.
  StrainReport apply(std::span<const double> inv_mass, double tolerance, int max_sweeps,
                     std::span<Vec3> x) const;

 private:
  std::vector<Spring> springs_;  // sorted by colour
  std::vector<double> limits_;
  std::vector<std::size_t> color_begin_;
  LimitedStrain limited_;
};

/// Input of a limiter for one step.
struct LimitStep {
  std::span<const Vec3> x_t0;        ///< m
  std::span<const double> inv_mass;  ///< 1/kg, 0: held
  double h = 0.0;                    ///< s, length of the step
  double tolerance = 1e-3;           ///< strain that may remain above the limit
  int max_sweeps = 200;
};

/// How a limiter acts.
enum class LimiterKind : std::uint8_t {
  none,           ///< does nothing
  method,         ///< changes the ends of steps
  force,          ///< adds a force on the springs
  critical_step,  ///< limits nothing; reports the critical step of the cloth (critical_step)
  stiffens,       ///< stiffens the cloth and shortens the steps before the run (chittaro_policy)
};

/// Properties of a limiter.
struct LimiterTraits {
  std::string_view promise, source;
  bool bounds_strain = true;    ///< iterates until the limits hold, if the held particles permit it
  bool of_springs = true;       ///< it bounds the strain of each spring, not of triangles
  bool keeps_momentum = true;   ///< conserves the momentum of free particles to rounding
  bool keeps_velocity = false;  ///< moving a particle does not change its velocity
  LimiterKind kind = LimiterKind::method;
  bool adds_force = false;                    ///< a method that also has a force on the springs
  LimitedStrain limits = LimitedStrain::any;  ///< of a method
};

/// A strain and its limit.
struct LimitedValue {
  double strain = 0.0, limit = 0.0;
};

/// A strain at its limit, as a constraint that the limiter upholds: it may pull its particles with
/// any force λ pull[k] on v[k], λ >= 0, which sum to 0. Those beyond `count` are not looked at.
struct HeldStrain {
  std::array<std::int32_t, 3> v;
  std::array<Vec3, 3> pull;
  int count = 2;
};

/// A method that keeps springs within their strain limits (super-elasticity, survey section 4) by
/// changing the end of a step.
class StrainLimitMethod {
 public:
  virtual ~StrainLimitMethod() = default;
  virtual LimiterTraits traits() const = 0;
  /// Measures the strains of the springs of the method, so that nobody keeps them twice. Null: it
  /// does not keep them.
  virtual const StrainLimiter* limiter() const { return nullptr; }
  /// Tells the directions of the fabric before the first step: the triangles of the cloth, and in
  /// the same order those of the rest shape, which has warp along x and weft along y if it is flat.
  /// A method of single springs has no use for them.
  virtual void set_directions(std::span<const Triangle> triangles, const TriangleMesh& rest);
  /// Moves the end positions of the particles, m. Held particles stay.
  virtual StrainReport limit_ends(const LimitStep& step, std::span<Vec3> x_t1) = 0;
  /// The strain at x, m, that exceeds its limit most, if the method does not limit that of springs;
  /// none: it does.
  virtual std::optional<LimitedValue> worst(std::span<const Vec3> x) const;
  /// Appends the strains that at x, m, are at a limit or within `tolerance` of it. By default those
  /// of the springs of `limiter()`.
  virtual void find_held(std::span<const Vec3> x, double tolerance,
                         std::vector<HeldStrain>& out) const;
  /// Changes the velocities (m/s) of the accepted step that ended at `x`. By default it does
  /// nothing.
  virtual void limit_velocities(const LimitStep& step, std::span<const Vec3> x, std::span<Vec3> v);
};

/// A limiter in use: a method, a force on the same springs, both, or neither.
struct StrainLimit {
  std::unique_ptr<StrainLimitMethod> method;
  std::unique_ptr<Force> force;
  int max_sweeps = LimitStep{}.max_sweeps;  ///< of a method, for LimitStep
};
/// The limiters by name. Arguments: the springs, their limits and the number of particles.
using StrainLimiterRegistry = Registry<StrainLimit, LimiterTraits, std::span<const Spring>,
                                       std::span<const double>, std::size_t>;
StrainLimiterRegistry strain_limiters();

// Members that change the end of a step; each file cites its paper.
std::unique_ptr<StrainLimitMethod> make_position_limiter(
    std::span<const Spring>, std::span<const double> limits, std::size_t particles,
    bool with_velocity, LimitedStrain limited = LimitedStrain::stretch);
/// Corrects the worst springs first, sorted into buckets. `priority`: each further correction of a
/// particle in one sweep is smaller.
struct OrderedConfig {
  bool priority = false;
  bool with_velocity = false;  ///< springs at their limit stop stretching
};
std::unique_ptr<StrainLimitMethod> make_ordered_limiter(
    std::span<const Spring>, std::span<const double> limits, std::size_t particles,
    const OrderedConfig& config, LimitedStrain limited = LimitedStrain::stretch);
std::unique_ptr<StrainLimitMethod> make_velocity_limiter(
    std::span<const Spring>, std::span<const double> limits, std::size_t particles, bool as_printed,
    LimitedStrain limited = LimitedStrain::stretch);
std::unique_ptr<StrainLimitMethod> make_position_velocity_limiter(
    std::span<const Spring>, std::span<const double> limits, std::size_t particles,
    LimitedStrain limited = LimitedStrain::stretch);

/// How springs become stiffer near their limit.
enum class StiffeningLaw {
  bayraktar,          ///< K L/l_allowed beyond l_allowed [survey eq. 12, continuous]
  bayraktar_printed,  ///< K L/L0 beyond l_allowed: jumps there
  tangent,            ///< K times a tangent that diverges at the limit [survey eq. 13 inverted]
  tangent_printed,    ///< eq. 13 as printed: an arc tangent, which softens
};
/// The force that such a law adds to Hooke's force on the same springs.
std::unique_ptr<Force> make_stiffening_force(std::span<const Spring>,
                                             std::span<const double> limits, std::size_t particles,
                                             StiffeningLaw law);

/// Critical step of a cloth [Provot1995; survey eq. 11 corrected].
struct CriticalStep {
  double provot_stiffness = 0.0;  ///< N/m, π² m/h² of the lightest particle, as usually quoted
  double mass_stiffness = 0.0;    ///< N/m, 4 m/h²: exact for one mass on one spring
  double longest_step = 0.0;      ///< s, 2/sqrt(λ_max), by power iteration
  double safe_step = 0.0;         ///< s, lower bound of longest_step by Gershgorin's bound
  /// Factor by which all stiffnesses may grow such that a step of h remains stable.
  double stiffening = 0.0;
};
/// For explicit steps of h (s) from rest at x. Throws std::invalid_argument unless h > 0.
CriticalStep critical_step(ForceSum& forces, const Particles& particles, double h);

/// Chittaro's policy [survey 4]: a cloth that is stiff enough is left unchanged; a softer one gets
/// larger stiffnesses and the shorter step that they need.
struct StiffnessPolicy {
  double strain = 0.0;     ///< of the cloth under its own weight, hung by one side
  double stiffness = 1.0;  ///< factor, >= 1
  double step = 1.0;       ///< factor, 1/sqrt(stiffness)
};
/// `weight`: weight of the longest strip that may hang, N per metre of width; `stretch_stiffness`:
/// N/m; `limit`: allowed strain.
StiffnessPolicy chittaro_policy(double weight, double stretch_stiffness, double limit);

}  // namespace selvedge
