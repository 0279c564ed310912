// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace selvedge {

struct NarrowPhaseTraits {
  bool misses_nothing = false;  ///< no false negative, on any input of finite doubles
  bool no_false_alarm = false;
  std::string source;  ///< author, title, year
};

/// The straight paths of four vertices over t in [0,1], in the order of Contact::vertex.
struct Query {
  ContactKind kind;  ///< point_triangle or edge_edge
  std::array<Vec3, 4> x_t0, x_t1;
};

/// Decides which candidate pairs collide during the step: whether the closed point and closed
/// triangle (or two closed edges) share a point at some t in [0,1] while every vertex moves on
/// the straight line x_t0 -> x_t1. Touching counts; degenerate primitives are legal.
class NarrowPhase {
 public:
  virtual ~NarrowPhase() = default;

  /// Contacts among `pairs`, in the order of the pair lists, appended to nothing: clears `out`.
  /// For self pairs pass the same view twice.
  virtual void find_contacts(const SurfaceView& a, const SurfaceView& b,
                             const CandidatePairs& pairs, std::vector<Contact>& out) const = 0;
  /// One query. True if the primitives collide; then toi is set, never later than the true one.
  virtual bool collides(const Query& query, double& toi) const = 0;
  virtual NarrowPhaseTraits traits() const = 0;
};

using NarrowPhaseRegistry = std::map<std::string, std::function<std::unique_ptr<NarrowPhase>()>>;

/// The methods that need no optional library; the default is "ccd_exact".
NarrowPhaseRegistry narrow_phases();

}  // namespace selvedge
