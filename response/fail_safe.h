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
  /// step must be shortened; `trouble` then gives the reason.
  virtual bool resolve(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) = 0;
  /// Why the last `resolve` returned false, as one sentence.
  virtual const std::string& trouble() const = 0;
  /// Counts since construction. Names that begin with max_ are maxima, the others sums.
  virtual const std::map<std::string, double>& counters() const = 0;
  /// Properties of the fail-safe, the same at all times.
  virtual ResponseTraits traits() const = 0;
};

/// The fail-safes by name.
using FailSafeRegistry = Registry<std::unique_ptr<FailSafe>, ResponseTraits>;
/// All fail-safes; the default is "layered".
FailSafeRegistry fail_safes();

/// Passes of inelastic impulses (impulse.h), then rigid impact zones (impact_zone.h).
std::unique_ptr<FailSafe> make_impulse_zones();
/// Inelastic projection (inelastic_projection.h), then rigid impact zones.
std::unique_ptr<FailSafe> make_projection_zones();
/// Limits the displacement of each particle to a ball, whose radius follows from the distances to
/// everything it could meet.
std::unique_ptr<FailSafe> make_displacement_bound();
/// Keeps the two primitives of each pair on opposite sides of a plane (separating_planes.h).
std::unique_ptr<FailSafe> make_separating_planes();
/// Inelastic projection, then separating planes. The default.
std::unique_ptr<FailSafe> make_layered();

}  // namespace selvedge
