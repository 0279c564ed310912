// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/response.h>

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

namespace selvedge::detail {

/// When and how fast a contact reaches the gap that it keeps: its rest gap, or the current gap if
/// that is smaller.
struct Impact {
  bool meets = false;    ///< true if it does within the step
  double time = 0.0;     ///< share of the step before the impact
  double speed = 0.0;    ///< m/s, approach speed at the impact, >= 0
  double rebound = 0.0;  ///< m/s, separation speed at the end of the step, with restitution
};

/// Any slip is allowed.
inline constexpr double kAnySlip = std::numeric_limits<double>::infinity();

/// A contact during the sweeps, which enforce relative(point, u)·normal >= target.
struct SweptContact {
  ContactPoint point;
  double m_eff = 0.0;     ///< kg, effective inertia of the contact against an impulse
  double target = 0.0;    ///< in the unit of u
  double friction = 0.0;  ///< Coulomb coefficient; infinity: a contact that carries load does not
                          ///< slip
  double most_slip = kAnySlip;     ///< largest slip that it keeps, in the unit of u
  double normal = 0.0;             ///< accumulated normal impulse, >= 0, kg times the unit of u
  Vec3 tangential = Vec3::Zero();  ///< accumulated friction impulse, the same unit
  double work_normal = 0.0, work_friction = 0.0;  ///< Σ impulse·(mean relative u), kg times unit²
  Impact impact;  ///< the impact as it would be without any response

  /// Distance from the gap at the start to the gap that the contact keeps, m.
  double way() const { return std::max(0.0, point.gap - point.rest_gap); }
  void clear();  ///< sets impulses and works to zero
};

/// Options of sweep_contacts.
struct SweepConfig {
  /// Maximum number of sweeps over all contacts. More sweeps carry an impulse through a deeper
  /// stack.
  int sweeps = 50;
  /// Sweeping ends when no contact changes its relative u by more than this share of the largest
  /// change in the first sweep.
  double tolerance = 1e-9;
};

/// Projected Gauss-Seidel over contacts with Coulomb friction. Accumulates impulses normal >= 0 and
/// |tangential| <= friction·normal, and takes them back where a later contact makes them
/// unnecessary, until every contact keeps its target. `u` holds velocities (or displacements) of
/// all vertices; those with inv_mass 0 never change. The impulses of a contact sum to zero. With
/// targets <= 0 and no friction, no sweep raises Σ ½ m u², because each minimises it along its own
/// contact [Jean1999, section 4; impulses as in Bridson2002, section 7, survey eq. 52-55
/// corrected]. Contacts are processed in the given order. Returns the number of sweeps.
int sweep_contacts(std::span<const double> inv_mass, std::span<SweptContact> contacts,
                   const SweepConfig& config, std::span<Vec3> u);

/// Shared state of the responses that act after the solve: the contacts of the step, its
/// velocities, and the difference between displacement over time and the velocity with which the
/// cloth continues.
class ContactAnswer {
 public:
  /// As Response::begin and Response::add.
  void begin(const ResponseStep& step);
  void add(std::span<const ContactPoint> contacts);
  /// Takes the end positions of the step before any response. `correct` must call this first.
  void take(std::span<const Vec3> x_t1, double restitution);

  double h() const { return step_.motion.h; }
  std::span<const double> inv_mass() const { return step_.motion.inv_mass; }
  std::span<SweptContact> contacts() { return contacts_; }
  std::span<Vec3> velocity() { return velocity_; }          ///< m/s at the end, all vertices
  std::span<Vec3> displacement() { return displacement_; }  ///< m over the step, all vertices

  /// Sweeps the velocities until every contact separates at least at the speed `target(contact)`,
  /// m/s.
  template <class Target>
  void sweep_velocity(Target target) {
    for (SweptContact& c : contacts_) {
      c.clear();
      c.target = target(c);
    }
    sweep_contacts(inv_mass(), contacts_, {}, velocity_);
  }
  /// The same without friction; contacts that carry load keep only the share `retention` of their
  /// slip.
  template <class Target>
  void reflect(double retention, Target target) {
    for (SweptContact& c : contacts_) c.friction = 0.0;
    sweep_velocity(target);
    retain_slip(retention);
  }
  /// Sweeps the displacements, with Coulomb friction, so that no gap ends below its rest gap or, if
  /// smaller, below its value at the start. Adds rebounds.
  void hold_gaps();
  /// Sweeps further so that gaps below their rest gap grow by a share of it. Without friction.
  void recover_gaps();

  void move_by_velocity();     ///< displacement = h·velocity
  void follow_displacement();  ///< velocity = displacement/h

  /// Writes x_t1 = x_t0 + displacement; the cloth continues with velocity().
  void give(std::span<Vec3> x_t1);
  /// Adds the difference that `give` left to velocities computed as displacement over time.
  void finish(std::span<Vec3> v) const;
  /// Stores the impulses of the last sweep as those of the step: impulse/unit, work/unit².
  void keep_impulses(double unit);
  /// Appends the impulses that keep_impulses stored.
  void impulses(std::vector<ContactImpulse>& out) const;

 private:
  Impact impact(const SweptContact& c, double restitution) const;
  void retain_slip(double retention);

  ResponseStep step_;
  std::vector<SweptContact> contacts_;
  std::vector<Vec3> velocity_, displacement_, start_;  // of all vertices
  std::vector<Vec3> leftover_;                         // of the particles, m/s
  std::vector<ContactImpulse> impulses_;
};

}  // namespace selvedge::detail
