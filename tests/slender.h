// SPDX-License-Identifier: MIT
//
// Slender strips after V. Romero et al. [Romero2021], "Physical validation of simulators in
// computer graphics: a new framework dedicated to slender elastic structures and frictional
// contact", 2021: the curves that theory gives, by integration of the differential equations, and
// the strips of data/validation in simulation. Used by slender_test and by bench/slender.
#pragma once

#include <filesystem>
#include <numbers>
#include <optional>
#include <vector>

namespace selvedge::testing {

// -- theory: strips of breadth 0 that do not stretch, of length 1, with Poisson's ratio 0 ---------

/// Height by which the tip is below the clamp, over its horizontal distance, of a heavy strip that
/// is clamped horizontally. gamma = ρ g L³/B; `natural`: its curvature at rest times L, positive
/// downwards.
double cantilever_ratio(double gamma, double natural = 0.0);

/// The least gamma = ρ g L³/B at which a strip that is clamped with its breadth upright falls over,
/// to first order in its breadth over its length.
double lateral_buckling_gamma(double breadth = 0.0);

/// A heavy strip that is curved at rest and clamped with its breadth upright, so that at rest it
/// lies along an arc in the horizontal plane. Its weight twists it and bends it out of that plane.
struct BendTwist {
  double drop = 0.0;     ///< of the tip below the clamp, over the length
  double forward = 0.0;  ///< of the tip, along the clamp, over the length
};
struct StripLoad {
  double gamma = 1.0;      ///< ρ g L³/B, up to 40
  double natural = 0.0;    ///< curvature at rest times L
  double breadth = 0.0;    ///< over L; to first order, as in lateral_buckling_gamma
  double in_plane = 1e12;  ///< stiffness of bending in the plane of the strip, over that across it
};
/// nullopt where no state is found.
std::optional<BendTwist> bent_and_twisted(const StripLoad& load);
/// Whether a strip that is clamped at its top, points downwards there and hangs in its vertical
/// plane, curved at rest as above, is stable against motion out of this plane. `twist`: its
/// stiffness of twist over that of bending. nullopt where no state in the plane is found.
std::optional<bool> hangs_in_its_plane(double gamma, double natural, double twist = 2.0);

/// A weightless strip that leans from the vertical, is clamped at its upper end and stands on the
/// ground with its lower one, which does not move. The clamp moves sideways and then descends.
struct PushPath {
  double lean = 10.0 * std::numbers::pi / 180.0;
  double sideways = 0.02;            ///< of the clamp, towards the side to which the strip leans
  double first = 0.005, last = 0.3;  ///< descents
};
struct Pushed {
  double descent = 0.0;  ///< of the clamp
  double ratio = 0.0;    ///< horizontal over vertical force of the ground
  double foot = 0.0;     ///< its place
};
/// States from the first descent to the last one, or until the strip touches the ground beyond its
/// foot.
std::vector<Pushed> pushed_strip(const PushPath& path = {});
/// The descent at which the foot slips first; nullopt if it does not.
std::optional<double> slip_descent(const std::vector<Pushed>& states, double friction);

// -- simulation -----------------------------------------------------------------------------------

/// The strips; `folder` has the scenes.
struct SlenderStrips {
  std::filesystem::path folder;
  int cells = 20;  ///< along the free length

  /// cantilever_ratio of data/validation/cantilever.json; `natural` as above, by a curved rest
  /// shape.
  double cantilever(double gamma, double natural = 0.0) const;
  /// bent_and_twisted, for a breadth of a twentieth of the length; `in_plane` follows from it.
  BendTwist bend_twist(double gamma, double natural) const;
  static StripLoad bend_twist_load(double gamma, double natural);
  /// How far the tip of a strip as in hangs_in_its_plane is from this plane at rest, over the
  /// length, if it is turned out of it by `turn` (rad) about the vertical at the tip to begin with.
  double out_of_plane(double gamma, double natural, double turn) const;
  /// The gamma at which the least eigenvalue of the stiffness against motion out of its plane is 0,
  /// for a strip of this breadth over its length.
  double buckling_gamma(double breadth) const;
  /// How far the tip of data/validation/lateral_buckling.json leans at rest, over the length.
  double buckled(double gamma) const;
  /// States of data/validation/stick_slip.json, and the descent at which its foot slips.
  std::vector<Pushed> pushed(double friction) const;
  std::optional<double> slip(double friction) const;
};

}  // namespace selvedge::testing
