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
  double volume() const;  ///< m³
};

/// A solid truncated cone between two parallel discs. It is oblique if the line through the middles
/// of the discs is not along `axis`.
struct TruncatedCone {
  Vec3 base = Vec3::Zero(), top = Vec3::Zero();  ///< m, middles of the discs
  Vec3 axis = Vec3::UnitZ();  ///< unit vector from base to top, perpendicular to both discs
  double base_radius = 0.0, top_radius = 0.0;  ///< m

  bool contains(const Vec3& x) const;
  double volume() const;  ///< m³
};

/// Columns and cones that together contain a surface over the whole step, inflated by its
/// thickness. Where no part of the surface lies, they have size zero.
struct Enclosure {
  std::vector<Column> columns;       ///< one per loop, along the axis
  std::vector<TruncatedCone> cones;  ///< cones[i] lies between columns[i] and columns[i + 1]

  bool contains(const Vec3& x) const;
  /// Sum over the primitives, m³; overlaps count twice.
  double volume() const;
};

/// Options of the minimal enclosure.
struct MinimalEnclosureConfig {
  /// Loops of the body, in [1, 4096]. More: a tighter enclosure, but more primitives to test and to
  /// fit.
  int loops = 16;
};

/// The enclosure of a surface. Throws std::invalid_argument for an invalid surface or
/// configuration.
Enclosure make_enclosure(const SurfaceView& surface, const MinimalEnclosureConfig& config = {});

/// Counts of the last call of a detector.
struct MinimalEnclosureCounts {
  std::size_t primitives = 0;       ///< of the body: 2 loops - 1
  std::size_t asked = 0;            ///< vertices, edges and triangles of the first surface
  std::size_t dropped = 0;          ///< of those, outside all primitives
  std::size_t enclosure_tests = 0;  ///< tests of one of them against a column or a cone
  std::size_t box_tests = 0;  ///< tests against a box of the body, or a box around a few of these
};

/// The minimal enclosure [Ji2006]: a body, the second surface, is cut into loops that columns and
/// truncated cones enclose. Primitives of the first surface outside all of them are dropped at
/// once; the others are tested against the boxes of the body's primitives in the same column or
/// cone. Reports the same pairs as brute force, bit for bit. Supports only two different surfaces:
/// find_self_pairs throws std::invalid_argument. The savings are relative to brute force; the tree
/// of boxes is faster (`bench enclosure`).
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
