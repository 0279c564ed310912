// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/response.h>

#include <algorithm>
#include <span>
#include <vector>

namespace selvedge {

/// When and how fast a contact meets the gap that it keeps: its rest gap, or the gap of now where
/// that is less.
struct Impact {
  bool meets = false;    ///< within the step
  double time = 0.0;     ///< share of the step before
  double speed = 0.0;    ///< m/s, of approach then, >= 0
  double rebound = 0.0;  ///< m/s, of parting at the end of the step, with restitution
};

/// A contact while it is swept: relative(point, u)·normal shall be at least `target`.
struct SweptContact {
  ContactPoint point;
  double m_eff = 0.0;              ///< kg, inertia against an impulse at the contact
  double target = 0.0;             ///< in the unit of u
  double friction = 0.0;           ///< Coulomb coefficient; infinity: what carries does not slip
  double normal = 0.0;             ///< impulse so far, >= 0, kg times the unit of u
  Vec3 tangential = Vec3::Zero();  ///< the same of friction
  double work_normal = 0.0, work_friction = 0.0;  ///< Σ impulse·(mean relative u), kg times unit²
  Impact impact;                                  ///< without any answer

  /// m from the gap at the start to the one that is kept.
  double way() const { return std::max(0.0, point.gap - point.rest_gap); }
  void clear();  ///< impulses and works to zero
};

struct SweepConfig {
  /// Most sweeps over all contacts. More carry an impulse through a deeper stack.
  int sweeps = 50;
  /// Sweeping ends when no contact changes its relative u by more than this share of the largest
  /// change of the first sweep.
  double tolerance = 1e-9;
};

/// Projected Gauss-Seidel over contacts with Coulomb friction: impulses normal >= 0 and
/// |tangential|
/// <= friction·normal, taken back where a later contact makes them needless, until every contact
/// keeps its target. `u` are velocities (or displacements) of all vertices, those of inv_mass 0 are
/// never changed. The sum of the impulses of a contact is zero. With targets <= 0 and no friction
/// no sweep raises Σ ½ m u², because each minimises it along its own contact [Jean1999, section 4;
/// impulses as in Bridson2002, section 7, survey eq. 52-55 mended]. The order is the caller's.
/// Returns the number of sweeps.
int sweep_contacts(std::span<const double> inv_mass, std::span<SweptContact> contacts,
                   const SweepConfig& config, std::span<Vec3> u);

/// What responses have in common that answer contacts after the solve: the contacts of the step,
/// its velocities, and the difference between displacement over time and the velocity with which
/// the cloth goes on.
class ContactAnswer {
 public:
  void begin(const ResponseStep& step);
  void add(std::span<const ContactPoint> contacts);
  /// Takes the ends of the step before any answer. To be called first by correct.
  void take(std::span<const Vec3> x_t1, double restitution);

  double h() const { return step_.motion.h; }
  std::span<const double> inv_mass() const { return step_.motion.inv_mass; }
  std::span<SweptContact> contacts() { return contacts_; }
  std::span<Vec3> velocity() { return velocity_; }          ///< m/s at the end, all vertices
  std::span<Vec3> displacement() { return displacement_; }  ///< m over the step, all vertices

  /// Sweeps the velocities so that no contact parts by less than `target(contact)`.
  template <class Target>
  void sweep_velocity(Target target) {
    for (SweptContact& c : contacts_) {
      c.clear();
      c.target = target(c);
    }
    sweep_contacts(inv_mass(), contacts_, {}, velocity_);
  }
  /// The same without friction, but contacts that carry keep only a share of their slip.
  template <class Target>
  void reflect(double retention, Target target) {
    for (SweptContact& c : contacts_) c.friction = 0.0;
    sweep_velocity(target);
    retain_slip(retention);
  }
  /// Sweeps the displacements so that no gap ends below its rest gap or, if less, below what it was
  /// (Coulomb friction); rebounds are added.
  void hold_gaps();
  /// Sweeps on, so that gaps that were too small grow by a share of the rest gap. No friction.
  void recover_gaps();

  void move_by_velocity();     ///< displacement = h·velocity
  void follow_displacement();  ///< velocity = displacement/h

  /// x_t1 = x_t0 + displacement; the cloth goes on with velocity().
  void give(std::span<Vec3> x_t1);
  /// Adds what give has left over to velocities that come as displacement over time.
  void finish(std::span<Vec3> v) const;
  /// Keeps the impulses of the last sweep as those of the step: impulse/unit, work/unit².
  void keep_impulses(double unit);
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

}  // namespace selvedge
