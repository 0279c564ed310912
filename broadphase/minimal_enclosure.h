// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace selvedge {

/// A right cylinder with its inside.
struct Column {
  Vec3 base = Vec3::Zero();           ///< m, middle of one end
  Vec3 axis = Vec3::UnitZ();          ///< unit, to the other end
  double height = 0.0, radius = 0.0;  ///< m

  bool contains(const Vec3& x) const;
  /// Metres from x to it, 0 inside.
  double distance(const Vec3& x) const;
  double volume() const;  ///< m³
};

/// Two parallel discs and all that is between them: a truncated cone, oblique where the line
/// through the middles of the discs is not along `axis`.
struct TruncatedCone {
  Vec3 base = Vec3::Zero(), top = Vec3::Zero();  ///< m, middles of the discs
  Vec3 axis = Vec3::UnitZ();                     ///< unit, across both discs, from base to top
  double base_radius = 0.0, top_radius = 0.0;    ///< m

  bool contains(const Vec3& x) const;
  /// Metres, at most those from x to it: to the plane of a disc or one along the wall, whichever is
  /// further. 0 inside.
  double distance(const Vec3& x) const;
  double volume() const;  ///< m³
};

/// One limb, cut in loops: a column around each, a cone between each two.
struct EnclosedLimb {
  std::vector<Column> columns;       ///< one for each loop, along the limb
  std::vector<TruncatedCone> cones;  ///< cones[i] lies between columns[i] and columns[i + 1]
};

/// Everything of a surface, over the step and inflated by its thickness, is inside one of these.
struct Enclosure {
  std::vector<EnclosedLimb> limbs;

  /// 2l - 1 for each limb of l loops. A slab of a limb in which there is nothing has one of no
  /// size.
  std::size_t primitive_count() const;
  bool contains(const Vec3& x) const;
  /// Metres, at most those from x to the enclosure; 0 inside. Infinity if there is none.
  double distance(const Vec3& x) const;
  /// Sum over the primitives, m³: what two of them share counts twice.
  double volume() const;
  /// How loose it is: the mean over all vertices, at the start of the step, of the metres to the
  /// wall of the primitive that holds the vertex, across its axis; of several the nearest wall.
  double mean_gap(const SurfaceView& surface) const;
};

struct MinimalEnclosureConfig {
  /// Loops of each limb. More: tighter, and more primitives to look at and to fit. In [1, 4096]
  int loops = 16;
  /// Cut the body into limbs first (legs, arms, trunk); off: the whole is one limb.
  bool find_limbs = true;
  /// Cut across this; zero: across the longest extent of each limb.
  Vec3 axis = Vec3::Zero();
  /// A moved body keeps its limbs and slabs, and the primitives are fitted to them anew, until
  /// their volume is this many times that just after the cut; then it is cut anew. > 1
  double recut_volume = 1.5;
};

/// The enclosure of a surface. Throws std::invalid_argument for a surface or a configuration that
/// is none.
Enclosure make_enclosure(const SurfaceView& surface, const MinimalEnclosureConfig& config = {});

/// What the last call of a detector looked at.
struct MinimalEnclosureCounts {
  std::size_t limbs = 0, primitives = 0;  ///< of the body
  std::size_t asked = 0;                  ///< vertices, edges and triangles of the first surface
  std::size_t dropped = 0;                ///< of those, outside all primitives
  std::size_t enclosure_tests = 0;        ///< of one of them against a column or a cone
  std::size_t box_tests = 0;  ///< against a box of the body's, or one around a few of these
};

/// The minimal enclosure [Ji2006]: a body, the second surface, is cut in loops which columns and
/// truncated cones enclose. What of the first surface is outside all of them is dropped at once;
/// what is inside is tested against the mesh itself, the boxes of its primitive's slab. Reports the
/// same pairs as brute force, bit for bit. Between two surfaces only: find_self_pairs throws
/// std::invalid_argument. What it saves is counted against brute force; the tree of boxes is
/// quicker near a body and where the body moves, and as quick far from one at rest
/// (bench_enclosure).
class MinimalEnclosure : public BroadPhase {
 public:
  virtual MinimalEnclosureCounts last_counts() const = 0;
  /// Of the body of the last call of find_pairs.
  virtual Enclosure last_enclosure() const = 0;
};

std::unique_ptr<MinimalEnclosure> make_minimal_enclosure(const MinimalEnclosureConfig& config = {});

}  // namespace selvedge
