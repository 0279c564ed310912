// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/clearances.h>
#include <selvedge/response/response.h>

#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>

namespace selvedge {

/// Ends a step without collisions, or says that it cannot. After begin, `resolve` is called with
/// the pairs that collide on the present paths, earliest first, until there are none. Body vertices
/// and held particles are never moved.
class FailSafe {
 public:
  virtual ~FailSafe() = default;

  /// Both must stay alive until the next begin.
  virtual void begin(const ResponseStep& step, Clearances& clearances) = 0;
  /// One round: changes where the particles end, m. False: this step has to be shorter, and
  /// `trouble` says why.
  virtual bool resolve(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) = 0;
  virtual const std::string& trouble() const = 0;
  /// What it has done since it was made; names that begin with max_ are maxima, the others sums.
  virtual const std::map<std::string, double>& counters() const = 0;
  virtual ResponseTraits traits() const = 0;
};

/// Names and factories of the fail-safes.
using FailSafeRegistry = std::map<std::string, std::function<std::unique_ptr<FailSafe>()>>;
FailSafeRegistry fail_safes();

/// Passes of inelastic impulses (impulse.h), then rigid impact zones (impact_zone.h).
std::unique_ptr<FailSafe> make_impulse_zones();
/// Inelastic projection (inelastic_projection.h), then rigid impact zones.
std::unique_ptr<FailSafe> make_projection_zones();
/// A ball for each particle, by its distance from all it could meet.
std::unique_ptr<FailSafe> make_displacement_bound();
/// A plane between the two primitives of each pair (separating_planes.h).
std::unique_ptr<FailSafe> make_separating_planes();
/// Inelastic projection, then planes. The default.
std::unique_ptr<FailSafe> make_layered();

}  // namespace selvedge
