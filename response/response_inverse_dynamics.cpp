// SPDX-License-Identifier: MIT
//
// X. Provot, "Deformation constraints in a mass-spring model to describe rigid cloth behavior",
// Graphics Interface 1995, as told by the survey, eq. 44 to 47: the force that gives two bodies in
// contact their common velocity,
//   V⁺ = (m1 V1 + m2 V2 + (F1 + F2) h) / (m1 + m2),
//   F_c1 = m_eff ((V2 - V1)/h + F2/m2 - F1/m1),  F_c2 = -F_c1,  1/m_eff = 1/m1 + 1/m2.
// Mended: the survey's eq. 47 adds -F_i to each side, so that F_c1 + F_c2 = -(F1 + F2), which
// breaks Newton's third law and cancels gravity; its "i stands for 0 and 1" is 1 and 2. V + h F/m
// is the velocity of the step without contacts, so that the force is the one that takes the
// difference of those: here of its normal part, and with `sticking` of all of it. A contact that
// has yet a way to go keeps what closes that within the step. Of several contacts of one particle
// each sees what the others did (contact_sweeps.h): forces that are all computed from one state are
// too much together.
//
// Guarantee: equal and opposite; momentum is kept, no energy is given. No friction. A gap that has
// been lost stays lost.
#include <selvedge/response/contact_sweeps.h>

#include <limits>

namespace selvedge {
namespace {

class InverseDynamics final : public Response {
 public:
  explicit InverseDynamics(const ResponseConfig& config) : config_(config) { validate(config); }

  void begin(const ResponseStep& step) override { answer_.begin(step); }
  void add(std::span<const ContactPoint> contacts) override { answer_.add(contacts); }
  void correct(std::span<Vec3> x_t1) override {
    answer_.take(x_t1, 0.0);
    const double friction = config_.sticking ? std::numeric_limits<double>::infinity() : 0.0;
    for (SweptContact& c : answer_.contacts()) c.friction = friction;
    answer_.sweep_velocity([&](const SweptContact& c) { return -c.way() / answer_.h(); });
    answer_.keep_impulses(1.0);
    answer_.move_by_velocity();
    answer_.give(x_t1);
  }
  void impulses(std::span<const Vec3>, std::vector<ContactImpulse>& out) const override {
    answer_.impulses(out);
  }
  ResponseTraits traits() const override {
    return {"forces are equal and opposite and take the approach; no friction unless sticking",
            "Provot, Deformation constraints in a mass-spring model to describe rigid cloth "
            "behavior, 1995",
            true, true, false};
  }

 private:
  ResponseConfig config_;
  ContactAnswer answer_;
};

}  // namespace

std::unique_ptr<Response> make_inverse_dynamics(const ResponseConfig& config) {
  return std::make_unique<InverseDynamics>(config);
}

}  // namespace selvedge
