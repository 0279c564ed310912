// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/solver/integrator.h>
#include <selvedge/detection/internal/contours.h>
#include <selvedge/simulation/contacts/detail/excluded_pairs.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation_state.h>

#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

struct UntangleConfig {
  /// Largest speed at which two sheets move through each other, m/s. A larger one is faster but
  /// shakes the cloth around the tangle.
  double speed = 1.0;
  /// Largest displacement in a step, as a share of the mean length of the edges that cross. The
  /// contours are found again after each step.
  double edge_share = 0.3;
  /// Strength of the drive, relative to inertia. A larger one holds the speed against taut cloth.
  double drive_ratio = 100.0;
  /// The same where cloth is led out of a body that has pinched it: what hangs from it pulls it
  /// tightly around the rim.
  double out_ratio = 1000.0;
  /// How far the regions extend beyond the contours, in mean lengths of the edges that cross. With
  /// 4, sheets that slid while they parted met pairs that were protected again, in 4 of 200
  /// generated tangles; with 6 and more in none of them. A larger one leaves more of the cloth
  /// unprotected.
  double reach = 8.0;
  /// Accepted steps without a new minimum of crossings after which the method changes.
  int patience = 30;
  /// Rounds through all methods before the tangle is given up.
  int rounds = 2;
};

/// Number of methods to move a tangle, which are used one after another.
inline constexpr int kUntangleWays = 4;

/// Undoes crossings that a scene starts with, or that bodies make which leave the cloth no room, by
/// global intersection analysis: contours, the
/// regions that they cut off, and a motion that brings the regions back [BaraffWitkin2003].
/// Deviation: the motion is not the paper's attraction but that of the contour. At each of its
/// points the first sheet moves against the second by
///   u = (c_B − c_A)/|c_B − c_A|,
/// where c_A and c_B are unit vectors in each sheet, across the contour, into the region that has
/// to come back. This moves the contour into both regions and so shrinks it, as
/// [VolinoThalmann2006] do by the gradient of its length. If a contour divides one sheet only, u is
/// the normal of the other sheet; if it divides no sheet, u leads along the contour from the border
/// of one sheet to that of the other, or along the normal of the other sheet if it ends at a common
/// corner. A region follows its contour by the mean of its neighbours.
/// Terms of the implicit step drive the cloth at u, at a bounded speed that is removed from the
/// velocities afterwards.
///
/// Meanwhile the collision test ignores pairs of primitives from region to region, and no others.
/// The tangle of a jam is never given up, because it ends when the bodies part.
/// Regions only shrink: after every step each is intersected with those of the remaining contours.
/// A tangle without crossings is over, and its pairs are protected from then on.
class Untangler {
 public:
  Untangler(JointSurface surface, const UntangleConfig& config);

  /// Finds the tangles of the start from the positions of the joint surface, m, and its crossings.
  void start(std::span<const Vec3> x, std::span<const EdgeCrossing> crossings);
  /// Continues with the regions of an interrupted run.
  void resume(Tangles tangles, std::span<const Vec3> x, std::span<const EdgeCrossing> crossings);
  /// Exempts pairs of the cloth with one body that leaves it no room: that of the earliest pair of
  /// `hits` with a body. They are a tangle until the body no longer crosses the cloth there. x: of
  /// the joint surface at the start of the step, m. Returns false if no pair has a body.
  bool carry_jam(std::span<const ContactPoint> hits, std::span<const Vec3> x);
  /// The pinched vertices of the next step. They and what hangs on them are not driven, and while
  /// they are carried, the bodies that hold them may cross the triangles around them.
  void set_pinches(std::span<const Pinch> pinches);
  /// Lets the bodies that pinch cloth cross the triangles around it, from now on until they part.
  /// Returns false if no pair of `hits` has a pinched vertex.
  bool carry_pinches(std::span<const ContactPoint> hits, std::span<const Pinch> pinches);
  /// After an accepted step: shrinks the regions and finds the next motion.
  void update(std::span<const Vec3> x, std::span<const EdgeCrossing> crossings, double time);

  /// Whether bodies may cross the triangles around pinched vertices.
  bool carries_pinches() const;
  bool active() const { return !excluded_.empty() || carries_pinches(); }
  const ExcludedPairs& excluded() const { return excluded_; }
  const Tangles& tangles() const { return tangles_; }
  const TangleReport& report() const { return report_; }

  /// Sets the velocities of the driven vertices for a step of h seconds, from the predicted
  /// velocities of the cloth, m/s, and the displacements of the bodies, m.
  void begin(std::span<const Vec3> v, std::span<const Vec3> body_step, double h);
  /// The terms of a step together with those of the drive; mass in kg, of the cloth.
  std::span<const ImplicitTerm> with_drive(std::span<const ImplicitTerm> terms,
                                           std::span<const double> mass);
  /// The same for an explicit step: sets the velocities of driven particles that are free.
  void set_velocities(std::span<const double> inv_mass, std::span<Vec3> v) const;
  /// Removes the drive from the velocities of an accepted step.
  void finish(std::span<Vec3> v);

 private:
  /// A driven vertex: direction, at most of length 1, relative to the velocity of the sheets.
  struct Driven {
    std::int32_t particle;
    Vec3 direction;
    std::int32_t contour;  // whose velocity it shares
    double ratio;          // strength of the drive
  };
  struct Motion;  // sums of directions while they are found

  void exclude_tangles();
  bool ways_are_exhausted() const;
  void set_reach(std::span<const Vec3> x, std::span<const EdgeCrossing> crossings);
  Tangle around(std::size_t contour, const CutRegions& regions, std::span<const Vec3> x) const;
  std::vector<std::int32_t> grow(std::vector<std::int32_t> seeds, std::span<const Vec3> x) const;
  void merge(std::vector<Tangle> found);
  std::vector<Tangle> surroundings(const CutRegions& regions, std::span<const Vec3> x,
                                   std::vector<int>& crossings) const;
  void shrink(const CutRegions& regions, std::span<const Vec3> x);
  bool crosses(const Contour& contour) const;
  void add_pinches(Tangle& tangle) const;
  std::vector<std::int32_t> triangles_of_parts(std::vector<std::int32_t> parts) const;
  Tangle crossing(std::size_t contour) const;
  bool is_pinched(const Contour& contour) const;
  int tangle_of(const Contour& contour, bool& flipped) const;
  void turn_around(int tangle);
  int count_pairs(std::span<const EdgeCrossing> crossings, int& elsewhere) const;
  void find_motion(const CutRegions& regions, std::span<const Vec3> x);
  void move_contour(std::size_t c, const CutRegions& regions, std::span<const Vec3> x, int way,
                    Motion& motion) const;
  Vec3 outward(const EdgeCrossing& node, std::span<const Vec3> x) const;
  bool move_out(std::size_t c, std::span<const Vec3> x, int way, Motion& motion) const;
  bool cuts_off_inside(std::size_t c, const CutRegions& regions, std::span<const Vec3> x) const;
  Vec3 along(const Contour& contour, std::span<const Vec3> x) const;
  Vec3 out_of_triangle(const EdgeCrossing& node, int side, std::span<const Vec3> x) const;
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
  std::vector<Pinch> pinches_;  // of the present step
  // What still crosses of the tangle of pinched cloth: all of it once its vertices are free.
  std::array<std::vector<std::int32_t>, 2> crossing_;
  double edge_length_ = 0.0, reach_ = 0.0;  // m
  std::vector<Driven> driven_;
  std::vector<ImplicitTerm> terms_;
  std::vector<Vec3> base_;  // m/s, common velocity of the sheets of each contour
  double speed_ = 0.0;      // m/s, of this step
};

}  // namespace selvedge::detail
