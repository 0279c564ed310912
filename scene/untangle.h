// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/integrator.h>
#include <selvedge/scene/contours.h>
#include <selvedge/scene/excluded_pairs.h>
#include <selvedge/scene/tangle_report.h>

#include <span>
#include <string>
#include <vector>

namespace selvedge {

struct UntangleConfig {
  /// Largest speed at which two sheets are moved through one another, m/s. More is quicker and
  /// shakes the cloth around the tangle.
  double speed = 1.0;
  /// They move by at most this share of the mean length of the edges that cross, in a step: the
  /// contours are found anew after each.
  double edge_share = 0.3;
  /// How strongly the cloth is driven, over its inertia: more holds the speed against taut cloth.
  double drive_ratio = 100.0;
  /// How far the regions reach beyond the contours, in mean lengths of the edges that cross. With
  /// 4, sheets that slide while they part ran into pairs that were protected already, in 4 of 200
  /// generated tangles; with 6 and more in none. More leaves more of the cloth unprotected.
  double reach = 8.0;
  /// Accepted steps without fewer crossings than ever before after which another way is tried.
  int patience = 30;
  /// Rounds through all ways before it is given up.
  int rounds = 2;
};

/// Undoes crossings that a scene starts with, by global intersection analysis: contours, the
/// regions that they cut off, and a motion that brings these back [BaraffWitkin2003]. The motion
/// is not the paper's attraction but that of the contour: at each of its points the first sheet is
/// moved against the second by
///   u = (c_B − c_A)/|c_B − c_A|,
/// with c_A, c_B the unit vectors in each sheet, across the contour, into the region that is to
/// come back. It moves the contour into both regions and so shrinks it, as [VolinoThalmann2006]
/// do by the gradient of its length. Where a contour divides one sheet alone, u is the normal of
/// the other sheet; where none, it leads along the contour from the border of one sheet to that of
/// the other. A region follows its contour by the mean of its neighbours. Cloth is driven at u by
/// terms of the implicit step, at a bounded speed that is taken out of the velocities afterwards.
///
/// Pairs of primitives from region to region are left out of the collision test meanwhile, and no
/// others. Regions only shrink: cut with those of the contours that are left after every step. A
/// tangle without crossings is over, and its pairs are protected for good.
class Untangler {
 public:
  Untangler(JointSurface surface, const UntangleConfig& config);

  /// The tangles of the start: positions of the joint surface, its crossings.
  void start(std::span<const Vec3> x, std::span<const EdgeCrossing> crossings);
  /// Goes on with regions of an interrupted run.
  void resume(Tangles tangles, std::span<const Vec3> x, std::span<const EdgeCrossing> crossings);
  /// After an accepted step: shrinks the regions and finds the next motion.
  void update(std::span<const Vec3> x, std::span<const EdgeCrossing> crossings, double time);

  /// The first cloth vertex of a part that lies wholly inside a closed body; -1: there is none.
  std::int32_t enclosed(std::span<const Vec3> x, std::span<const EdgeCrossing> crossings) const;

  bool active() const { return !excluded_.empty(); }
  const ExcludedPairs& excluded() const { return excluded_; }
  const Tangles& tangles() const { return tangles_; }
  const TangleReport& report() const { return report_; }

  /// The motion of a step of h seconds: velocities of the vertices that are driven, from those
  /// predicted for the cloth and the displacement of the bodies.
  void begin(std::span<const Vec3> v, std::span<const Vec3> body_step, double h);
  /// The terms of a step and the drive as forces beside them; mass in kg, of the cloth.
  std::span<const ImplicitTerm> with_drive(std::span<const ImplicitTerm> terms,
                                           std::span<const double> mass);
  /// The same for an explicit step: sets the velocities of driven particles that are free.
  void set_velocities(std::span<const double> inv_mass, std::span<Vec3> v) const;
  /// Takes the drive out of the velocities of an accepted step.
  void finish(std::span<Vec3> v);

 private:
  /// One vertex that is moved: direction, at most of length 1, against the velocity of the sheets.
  struct Driven {
    std::int32_t particle;
    Vec3 direction;
    std::int32_t contour;  // whose velocity it shares
  };
  struct Motion;  // sums of directions while they are found

  bool ways_are_exhausted() const;
  void set_reach(std::span<const Vec3> x, std::span<const EdgeCrossing> crossings);
  Tangle around(std::size_t contour, const CutRegions& regions, std::span<const Vec3> x) const;
  std::vector<std::int32_t> grow(std::vector<std::int32_t> seeds, std::span<const Vec3> x) const;
  void merge(std::vector<Tangle> found);
  void shrink(const CutRegions& regions, std::span<const Vec3> x);
  bool crosses(const Contour& contour) const;
  int tangle_of(const Contour& contour, bool& flipped) const;
  void turn_around(int tangle);
  int count_pairs(std::span<const EdgeCrossing> crossings, int& elsewhere) const;
  void find_motion(const CutRegions& regions, std::span<const Vec3> x);
  void move_contour(std::size_t c, const CutRegions& regions, std::span<const Vec3> x, int way,
                    Motion& motion) const;
  Vec3 along(const Contour& contour, std::span<const Vec3> x) const;
  Vec3 node_direction(std::size_t c, std::size_t i, const CutRegions& regions,
                      std::span<const Vec3> x, bool along_normals) const;
  void fill_regions(std::size_t c, const CutRegions& regions, Motion& motion) const;
  Vec3 velocity(const Driven& driven) const;

  JointSurface surface_;
  UntangleConfig config_;
  std::vector<Contour> contours_;
  Tangles tangles_;
  ExcludedPairs excluded_;
  TangleReport report_;
  double edge_length_ = 0.0, reach_ = 0.0;  // m
  std::vector<Driven> driven_;
  std::vector<ImplicitTerm> terms_;
  std::vector<Vec3> base_;  // m/s, what the sheets of each contour do together
  double speed_ = 0.0;      // m/s, of this step
};

}  // namespace selvedge
