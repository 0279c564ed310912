// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/response.h>

#include <span>
#include <vector>

namespace selvedge {

struct ContactForceConfig {
  /// Normal stiffness over m_eff/h², dimensionless. A contact that carries q times the weight of
  /// its own particles yields by q·g·h²/normal_ratio; more makes the linear system stiffer.
  double normal_ratio = 1000.0;
  /// Viscosity of a sticking contact over m_eff/h. Its creep is (load/m_eff)·h/stick_ratio, 1e-8
  /// m/s under its own weight at h = 1/120 s, and its conditioning is the preconditioner's business
  /// where a single particle touches a body.
  double stick_ratio = 1e7;
  /// The same for contacts that couple several particles, where it does cost iterations.
  double coupled_stick_ratio = 1e4;
  /// A gap below the rest gap recovers by at most this share of the rest gap in a step, so that
  /// cloth that starts too near is not shot away.
  double recovery = 0.2;
  /// Relative slip below which a contact is first tried as sticking, m/s.
  double stick_speed = 1e-5;
  /// Share of the whole load by which the contact forces may still change when no further solve is
  /// asked for. More is faster and lets single contacts pull or friction miss by that much in a
  /// step.
  double load_tolerance = 0.1;
};

/// Contact and Coulomb friction as forces inside the implicit step [after the active-set view of
/// penalty contact, Wriggers 2006, ch. 5]. Each contact pushes with λ = k (rest - gap⁺)₊ along its
/// normal, where gap⁺ is the linearised gap at the end of the step. Its friction is a stiff
/// viscosity while it sticks, the force μλ against the slip while it slides, and the viscosity
/// μλ/|slip| when that could stop it within the step. `update` after each solve finds which
/// contacts carry and which stick; the caller solves again until it says that nothing changed.
class ContactForce final : public Response {
 public:
  explicit ContactForce(const ContactForceConfig& config = {}) : config_(config) {}

  void begin(const ResponseStep& step) override;
  void add(std::span<const ContactPoint> contacts) override;
  std::span<const ImplicitTerm> terms() override;
  /// Takes the solved velocities; true if the contact forces that follow from them differ from
  /// those of the solve by so much that another solve is due.
  bool update(std::span<const Vec3> v) override;

  /// An explicit step has no solve to enter: impulses answer (make_impulse, without restitution).
  void correct(std::span<Vec3> x_t1) override;
  /// Takes out of the end-of-step velocities what the contacts gave to gaps that were too small:
  /// the cloth has moved out, it does not fly on. Linear momentum of free particles is kept.
  void finish(std::span<Vec3> v) const override;
  void impulses(std::span<const Vec3> v, std::vector<ContactImpulse>& out) const override;
  ResponseTraits traits() const override;

 private:
  enum class Slip : std::uint8_t { stick, slide };
  struct Entry {
    ContactPoint point;
    Vec3 body_motion;          // Σ weight·displacement of the body vertices, m
    double target;             // gap aimed at for the end of the step, m
    double stiffness;          // N/m
    double stick;              // kg/s
    double load = 0.0;         // N, last estimate of λ
    double viscosity = 0.0;    // kg/s, of friction
    Vec3 push = Vec3::Zero();  // N, friction as a given force
    double m_eff = 0.0;        // kg, inertia against an impulse at the contact
    Slip slip = Slip::stick;
    bool at_limit = false;  // turned back by a push in this step
  };

  Vec3 motion_of(const Entry& e, std::span<const Vec3> v) const;
  bool coupled(const ContactPoint& c) const;
  void set_friction(Entry& e, const Vec3& slip) const;
  double update(Entry& e, std::span<const Vec3> v) const;

  ContactForceConfig config_;
  ContactMotion motion_;
  std::vector<Vec3> body_displacement_, v_start_, v_predicted_;
  std::vector<Entry> entries_;
  std::vector<ImplicitTerm> terms_;
  std::vector<std::size_t> term_entry_;  // entry of each term
  std::unique_ptr<Response> explicit_;   // answers steps without a solve; made when first needed
};

}  // namespace selvedge
