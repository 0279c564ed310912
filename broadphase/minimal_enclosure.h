// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace selvedge {

/// A solid right cylinder.
struct Column {
  Vec3 base = Vec3::Zero();           ///< m, middle of one end
  Vec3 axis = Vec3::UnitZ();          ///< unit vector towards the other end
  double height = 0.0, radius = 0.0;  ///< m

  bool contains(const Vec3& x) const;
  /// Distance from x to the cylinder, metres; 0 inside.
  double distance(const Vec3& x) const;
  double volume() const;  ///< m³
};

/// A solid truncated cone between two parallel discs. It is oblique if the line through the middles
/// of the discs is not along `axis`.
struct TruncatedCone {
  Vec3 base = Vec3::Zero(), top = Vec3::Zero();  ///< m, middles of the discs
  Vec3 axis = Vec3::UnitZ();  ///< unit vector from base to top, perpendicular to both discs
  double base_radius = 0.0, top_radius = 0.0;  ///< m

  bool contains(const Vec3& x) const;
  /// Lower bound of the distance from x, metres: the distance to the plane of a disc or to one
  /// along the wall, whichever is larger. 0 inside.
  double distance(const Vec3& x) const;
  double volume() const;  ///< m³
};

/// One limb, cut into loops: a column around each loop, and a cone between neighbouring loops.
struct EnclosedLimb {
  std::vector<Column> columns;       ///< one per loop, along the limb
  std::vector<TruncatedCone> cones;  ///< cones[i] lies between columns[i] and columns[i + 1]
};

/// Columns and cones that together contain a surface over the whole step, inflated by its
/// thickness.
struct Enclosure {
  std::vector<EnclosedLimb> limbs;

  /// 2l - 1 for each limb of l loops. An empty slab of a limb has a primitive of size zero.
  std::size_t primitive_count() const;
  bool contains(const Vec3& x) const;
  /// Lower bound of the distance from x to the enclosure, metres; 0 inside. Infinity if the
  /// enclosure is empty.
  double distance(const Vec3& x) const;
  /// Sum over the primitives, m³; overlaps count twice.
  double volume() const;
  /// Tightness of the enclosure: the mean over all vertices, at the start of the step, of the
  /// distance (metres, perpendicular to the axis) to the wall of the primitive that contains the
  /// vertex; of several, the nearest wall.
  double mean_gap(const SurfaceView& surface) const;
};

/// Options of the minimal enclosure.
struct MinimalEnclosureConfig {
  /// Loops per limb, in [1, 4096]. More: a tighter enclosure, but more primitives to test and to
  /// fit.
  int loops = 16;
  /// First cut the body into limbs (legs, arms, trunk); off: the whole body is one limb.
  bool find_limbs = true;
  /// Direction perpendicular to the cuts; zero: the longest extent of each limb.
  Vec3 axis = Vec3::Zero();
  /// A moving body keeps its limbs and slabs, and the primitives are refitted, until their volume
  /// exceeds this multiple of that just after the cut; then the body is cut again. > 1
  double recut_volume = 1.5;
};

/// The enclosure of a surface. Throws std::invalid_argument for an invalid surface or
/// configuration.
Enclosure make_enclosure(const SurfaceView& surface, const MinimalEnclosureConfig& config = {});

/// Counts of the last call of a detector.
struct MinimalEnclosureCounts {
  std::size_t limbs = 0, primitives = 0;  ///< of the body
  std::size_t asked = 0;                  ///< vertices, edges and triangles of the first surface
  std::size_t dropped = 0;                ///< of those, outside all primitives
  std::size_t enclosure_tests = 0;        ///< tests of one of them against a column or a cone
  std::size_t box_tests = 0;  ///< tests against a box of the body, or a box around a few of these
};

/// The minimal enclosure [Ji2006]: a body, the second surface, is cut into loops that columns and
/// truncated cones enclose. Primitives of the first surface outside all of them are dropped at
/// once; the others are tested against the boxes of the body's primitives in the same slab. Reports
/// the same pairs as brute force, bit for bit. Supports only two different surfaces:
/// find_self_pairs throws std::invalid_argument. The savings are relative to brute force. The tree
/// of boxes is faster near a body and where the body moves, and as fast far from a body at rest
/// (`bench enclosure`).
class MinimalEnclosure : public BroadPhase {
 public:
  /// Counts of the last call of find_pairs.
  virtual MinimalEnclosureCounts last_counts() const = 0;
  /// The enclosure of the body in the last call of find_pairs.
  virtual Enclosure last_enclosure() const = 0;
};

/// Throws std::invalid_argument for an option out of its range.
std::unique_ptr<MinimalEnclosure> make_minimal_enclosure(const MinimalEnclosureConfig& config = {});

}  // namespace selvedge
