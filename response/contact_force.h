// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/response.h>

#include <span>
#include <vector>

namespace selvedge {

struct ContactForceConfig {
  /// Normal stiffness over m_eff/h², dimensionless. A contact that carries q times the weight of
  /// its own particles yields by q·g·h²/normal_ratio, 2.3 µm·q at h = 1/120 s; more makes the
  /// linear system stiffer, and from 1000 on stacks need many more solves to find which contacts
  /// carry.
  double normal_ratio = 300.0;
  /// Viscosity of a sticking contact over m_eff/h. Its creep is (load/m_eff)·h/stick_ratio, 1e-8
  /// m/s under its own weight at h = 1/120 s, and its conditioning is the preconditioner's business
  /// where a single particle touches a body.
  double stick_ratio = 1e7;
  /// The same for contacts that couple several particles, where it does cost iterations.
  double coupled_stick_ratio = 1e4;
  /// A gap below the rest gap recovers by at most this share of the rest gap in a step, so that
  /// cloth that starts too near is not shot away.
  double recovery = 0.2;
  /// Slip over a step, as a share of the rest gap, below which a contact is first tried as
  /// sticking: 3e-4 m/s for 2 mm at 1/120 s.
  double stick_slip = 1.25e-3;
  /// Share of the whole load by which the contact forces may still change when no further solve is
  /// asked for, and of all μλ by which friction may. More is faster and lets single contacts pull
  /// or friction miss by that much in a step.
  double load_tolerance = 0.1;
};

/// Contact and Coulomb friction as forces inside the implicit step [after the active-set view of
/// penalty contact, Wriggers 2006, ch. 5]. Each contact pushes with λ = k (rest - gap⁺)₊ along its
/// normal, where gap⁺ is the linearised gap at the end of the step. Its friction against the slip s
/// is f(s) = min(c|s|, μλ) s/|s|, c so large that what it lets creep is not seen. Both are solved
/// by semismooth Newton iterations: `update` after each solve finds which contacts carry and which
/// stick; the caller solves again until it says that nothing changed. Nothing is kept from step to
/// step: what the contacts carried at the end of the last one can be read off gap and velocity.
class ContactForce final : public Response {
 public:
  explicit ContactForce(const ContactForceConfig& config = {}) : config_(config) {}

  void begin(const ResponseStep& step) override;
  void add(std::span<const ContactPoint> contacts) override;
  std::span<const ImplicitTerm> terms() override;
  /// Takes the solved velocities, pulls them back to where the way from those of the solve before
  /// has its least energy, and returns true if the contact forces that follow from them differ from
  /// those of the solve by so much that another solve is due.
  bool update(std::span<Vec3> v) override;

  /// An explicit step has no solve to enter: impulses answer (make_impulse, without restitution).
  void correct(std::span<Vec3> x_t1) override;
  /// Takes out of the end-of-step velocities what the contacts gave to gaps that were too small:
  /// the cloth has moved out, it does not fly on. Linear momentum of free particles is kept.
  void finish(std::span<Vec3> v) const override;
  void impulses(std::span<const Vec3> v, std::vector<ContactImpulse>& out) const override;
  ResponseTraits traits() const override;

 private:
  /// How friction enters the next solve.
  enum class Slip : std::uint8_t {
    stick,  ///< viscosity c
    slide,  ///< the force μλ against the slip, and viscosity μλ/|s| across it (Newton)
  };
  struct Entry {
    ContactPoint point;
    Vec3 body_motion;        // Σ weight·displacement of the body vertices, m
    double target = 0.0;     // gap aimed at for the end of the step, m
    double stiffness = 0.0;  // N/m
    double stick = 0.0;      // c, kg/s
    double m_eff = 0.0;      // kg, inertia against an impulse at the contact
    double load = 0.0;       // N, last estimate of λ
    Slip slip = Slip::stick;
    Vec3 along = Vec3::Zero();     // unit, of the slip that slides
    double push = 0.0;             // N, friction as a given force against `along`
    double viscosity = 0.0;        // kg/s, of friction: in all directions, or across `along`
    double friction_change = 0.0;  // N, asked for by the last update
    double limit = 0.0;            // N, μλ that friction was set for
    Vec3 applied = Vec3::Zero();   // N·s, what holds the cloth at the present velocities
    Vec3 solved = Vec3::Zero();    // N·s, of the last solve
  };
  /// A contact on the way from the velocities of one solve to those of the next.
  struct Way {
    const Entry* entry;
    Vec3 turn;            // change of the relative velocity over the whole way, m/s
    double lack, closes;  // m, target less gap at its beginning, and by how much it changes
    Vec3 slip, slips;     // m/s, at its beginning, and change
  };

  Vec3 motion_of(const Entry& e, std::span<const Vec3> v) const;
  double stick_speed(const ContactPoint& c) const;
  bool coupled(const ContactPoint& c) const;
  double first_load(const Entry& e) const;
  void set_friction(Entry& e, Slip slip, const Vec3& s) const;
  Vec3 friction_used(const Entry& e, const Vec3& s) const;
  double update(Entry& e, std::span<const Vec3> v) const;
  double update_friction(Entry& e, const Vec3& s, bool carried) const;
  void note_solved(std::span<const Vec3> v);
  void find_ways(std::span<const Vec3> v);
  double slope(double share) const;
  double least_energy() const;
  void pull_back(std::span<Vec3> v);

  ContactForceConfig config_;
  ContactMotion motion_;
  std::vector<Vec3> body_displacement_, v_start_, v_predicted_;
  std::vector<Entry> entries_;
  std::vector<ImplicitTerm> terms_;
  std::vector<std::size_t> term_entry_;  // entry of each term
  std::unique_ptr<Response> explicit_;   // answers steps without a solve; made when first needed
  int friction_updates_ = 0;             // in this step that friction alone has asked for
  double room_ = 0.0, approach_ = 0.0;  // Σ m_eff·rest gap, Σ m_eff·predicted lack of it, kg·m
  std::vector<Vec3> v_last_;            // after the last update; empty: none in this step
  std::vector<Way> ways_;
};

}  // namespace selvedge
