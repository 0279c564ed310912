// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>
#include <selvedge/core/base/registry.h>

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// Properties of a method. The registry reports them.
struct NarrowPhaseTraits {
  bool misses_nothing = false;  ///< no false negative, for any finite doubles
  bool no_false_alarm = false;  ///< no false positive, for any finite doubles
  /// True: toi is an estimate of the true time. False: toi is 0, "somewhere in the step".
  bool gives_time = true;
  std::string source{};  ///< author, title, year
  std::string limits{};  ///< one sentence: pairs that it does not handle, or where it fails; may be
                         ///< empty
};

/// The straight paths of four vertices over t in [0,1], metres, in the order of Contact::vertex.
struct Query {
  ContactKind kind;  ///< point_triangle or edge_edge
  std::array<Vec3, 4> x_t0, x_t1;
};

/// The toi of a query without a collision.
inline constexpr double kNoCollision = std::numeric_limits<double>::infinity();

/// Decides which candidate pairs collide during a step: whether a closed point and a closed
/// triangle (or two closed edges) share a point at some t in [0,1] while every vertex moves on the
/// straight line x_t0 -> x_t1. Touching counts as a collision; degenerate primitives are allowed.
///
/// Both find functions throw std::invalid_argument that names the vertex if a coordinate is not
/// finite.
class NarrowPhase {
 public:
  virtual ~NarrowPhase() = default;

  /// Writes the first time of contact of each query, in [0,1], or kNoCollision, to `toi`, which
  /// must have the length of `queries`. Runs on the calling thread.
  virtual void find_times(std::span<const Query> queries, std::span<double> toi) const = 0;
  /// Clears `out` and writes the pairs among `pairs` that collide during the step to it, in the
  /// order of the pair lists (find_contacts of `detection` reports pairs that are near). For self
  /// pairs pass the same view twice. Runs batches of find_times on all threads.
  virtual void find_contacts(const SurfaceView& a, const SurfaceView& b,
                             const CandidatePairs& pairs, std::vector<Contact>& out) const;
  /// Properties of the method, the same at all times.
  virtual NarrowPhaseTraits traits() const = 0;

  /// Decides one query. If the primitives collide, sets toi and returns true.
  bool collides(const Query& query, double& toi) const;
};

/// Options of the methods. Each method's header documents how it uses them.
struct NarrowPhaseConfig {
  /// Tolerance of a method that has one, in the unit that its header gives. Negative: the method's
  /// default.
  double tolerance = -1.0;
  /// Metres, >= 0: primitives that are at most this far apart count as colliding. Methods without
  /// this option throw std::invalid_argument for a value other than 0.
  double min_separation = 0.0;
};

/// The guarantee of a method with these traits, and its limits, as one sentence.
std::string promise_of(const NarrowPhaseTraits& traits);

/// The methods by name.
using NarrowPhaseRegistry = Registry<std::unique_ptr<NarrowPhase>, NarrowPhaseTraits>;

/// The methods that need no optional library; the names of the others are noted as absent. The
/// default is "ccd_exact".
NarrowPhaseRegistry narrow_phases();

}  // namespace selvedge
