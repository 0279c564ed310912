// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/response.h>

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// Answers a fail-safe's questions about the distance of pairs at t = 0. In each answer, `weight`
/// holds the weights of the closest points at t = 0, and `normal` and `gap` describe a separating
/// slab: normal·(x - y) >= gap for every point x of the first primitive and y of the second. `gap`
/// (metres) is rounded down, so it never exceeds the distance; 0 means that no slab was found.
class Clearances {
 public:
  virtual ~Clearances() = default;

  /// Writes the same pairs as `hits`, in the same order, to `out`. Prefers the slab across a hit's
  /// own normal.
  virtual void at_start(std::span<const ContactPoint> hits, std::vector<ContactPoint>& out) = 0;
  /// Writes to `out` at least every pair that can meet while each particle ends anywhere on the
  /// line from x_t0 + shift to its current x_t1. `shift`: metres.
  virtual void all(const Vec3& shift, std::vector<ContactPoint>& out) = 0;
};

/// Makes the paths of a step free of collisions, or reports that it cannot. After `begin`, the
/// caller detects the collisions of the current paths and passes them to `resolve`, earliest first,
/// until none are left. A fail-safe never moves body vertices or held particles.
class FailSafe {
 public:
  virtual ~FailSafe() = default;

  /// Starts a step. Both arguments must stay alive until the next begin.
  virtual void begin(const ResponseStep& step, Clearances& clearances) = 0;
  /// One round: changes the end positions `x_t1` of the particles, metres. Returns false if the
  /// step must be shortened; `failure_reason` then gives the reason.
  virtual bool resolve(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) = 0;
  /// Why the last `resolve` returned false, as one sentence.
  virtual const std::string& failure_reason() const = 0;
  /// Counts since construction. Names that begin with max_ are maxima, the others sums.
  virtual const std::map<std::string, double>& counters() const = 0;
  /// Properties of the fail-safe, the same at all times.
  virtual ResponseTraits traits() const = 0;
};

/// The fail-safes by name.
using FailSafeRegistry = Registry<std::unique_ptr<FailSafe>, ResponseTraits>;
/// All fail-safes; the default is "layered".
FailSafeRegistry fail_safes();

/// Rounds of the fail-safes. Each field names the fail-safes that use it. Scenes take the defaults.
struct FailSafeRounds {
  /// `impulse_zones`: passes of impulses before rigid zones take over, >= 0.
  int impulse_passes = 8;
  /// `projection_zones`, `layered`: rounds of projection before the second layer takes over, >= 0.
  /// A round resolves the known collisions and reveals new ones: a stack of twelve sheets at 10 m/s
  /// settles in about twenty.
  int projection_rounds = 20;
  /// `separating_planes`, `layered`: rounds that add planes only for the pairs that collide; the
  /// next one adds planes for all pairs that could, >= 0. Most steps settle in three.
  int plane_rounds = 40;
};
/// The defaults of `layered`: its second layer is exact, so the projection is short.
inline constexpr FailSafeRounds kLayeredRounds{.projection_rounds = 8};

/// Passes of inelastic impulses (impulse.h), then rigid impact zones (impact_zone.h).
std::unique_ptr<FailSafe> make_impulse_zones(const FailSafeRounds& rounds = {});
/// Inelastic projection (inelastic_projection.h), then rigid impact zones.
std::unique_ptr<FailSafe> make_projection_zones(const FailSafeRounds& rounds = {});
/// Limits the displacement of each particle to a ball, whose radius follows from the distances to
/// everything it could meet.
std::unique_ptr<FailSafe> make_displacement_bound();
/// Keeps the two primitives of each pair on opposite sides of a plane (separating_planes.h).
std::unique_ptr<FailSafe> make_separating_planes(const FailSafeRounds& rounds = {});
/// Inelastic projection, then separating planes. The default. Stops the projection early if it
/// makes no progress.
std::unique_ptr<FailSafe> make_layered(const FailSafeRounds& rounds = kLayeredRounds);

}  // namespace selvedge
