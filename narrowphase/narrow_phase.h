// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>

#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// What a method promises; the registry carries it.
struct NarrowPhaseTraits {
  bool misses_nothing = false;  ///< no false negative, on any input of finite doubles
  bool no_false_alarm = false;
  /// Tells when: its toi is an estimate of the true one, not only 0 for "somewhere in the step".
  bool gives_time = true;
  std::string source{};  ///< author, title, year
  std::string limits{};  ///< one sentence: what it does not answer, or where it fails; may be empty
};

/// The straight paths of four vertices over t in [0,1], in the order of Contact::vertex.
struct Query {
  ContactKind kind;  ///< point_triangle or edge_edge
  std::array<Vec3, 4> x_t0, x_t1;
};

/// The toi of a query without collision.
inline constexpr double kNoCollision = std::numeric_limits<double>::infinity();

/// Decides which candidate pairs collide during the step: whether the closed point and closed
/// triangle (or two closed edges) share a point at some t in [0,1] while every vertex moves on
/// the straight line x_t0 -> x_t1. Touching counts; degenerate primitives are legal.
///
/// Coordinates that are not finite are refused by std::invalid_argument, which names the vertex.
class NarrowPhase {
 public:
  virtual ~NarrowPhase() = default;

  /// The first time of contact of each query, or kNoCollision; toi is as long as queries. Works on
  /// the calling thread.
  virtual void find_times(std::span<const Query> queries, std::span<double> toi) const = 0;
  /// Contacts among `pairs`, in the order of the pair lists; clears `out` first. For self pairs
  /// pass the same view twice. Threads over batches of find_times.
  virtual void find_contacts(const SurfaceView& a, const SurfaceView& b,
                             const CandidatePairs& pairs, std::vector<Contact>& out) const;
  virtual NarrowPhaseTraits traits() const = 0;

  /// One query. True if the primitives collide; then toi is set.
  bool collides(const Query& query, double& toi) const;
};

/// What a method may be told; each header says what it makes of it.
struct NarrowPhaseConfig {
  /// Tolerance of a method that has one, in the unit its header gives; negative: its own default.
  double tolerance = -1.0;
  /// Metres, >= 0: primitives nearer than this count as colliding. Methods that cannot do this
  /// refuse it by std::invalid_argument.
  double min_separation = 0.0;
};

using NarrowPhaseRegistry =
    std::map<std::string, std::function<std::unique_ptr<NarrowPhase>(const NarrowPhaseConfig&)>>;

/// The methods that need no optional library; the default is "ccd_exact".
NarrowPhaseRegistry narrow_phases();

}  // namespace selvedge
