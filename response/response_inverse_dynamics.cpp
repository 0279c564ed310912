// SPDX-License-Identifier: MIT
//
// M. Carignan, Y. Yang, N. Magnenat-Thalmann, D. Thalmann, "Dressing animated synthetic actors with
// complex deformable clothes", SIGGRAPH 1992 [Carignan1992], as described in the survey, eq. 44 to
// 47 (which names [Provot1995] as a user of it, table X): the force that gives two bodies in
// contact their common velocity,
//   V⁺ = (m1 V1 + m2 V2 + (F1 + F2) h) / (m1 + m2),
//   F_c1 = m_eff ((V2 - V1)/h + F2/m2 - F1/m1),  F_c2 = -F_c1,  1/m_eff = 1/m1 + 1/m2.
// Corrected: the survey's eq. 47 adds -F_i to each side, so that F_c1 + F_c2 = -(F1 + F2), which
// breaks Newton's third law and cancels gravity; its "i stands for 0 and 1" should read 1 and 2. V
// + h F/m is the velocity of the step without contacts, so the force removes the difference of
// these velocities: here their normal part, with `sticking` all of it. A contact with some distance
// left keeps the speed that closes this distance within the step. If a particle has several
// contacts, each sees the effect of the others (contact_sweeps.h): forces that are all computed
// from one state would be too large together.
//
// Guarantee: the forces are equal and opposite; momentum is kept and no kinetic energy is added.
// There is no friction. A violated gap is not restored.
#include <selvedge/response/detail/contact_sweeps.h>

#include <limits>

namespace selvedge::detail {
namespace {

class InverseDynamics final : public Response {
 public:
  explicit InverseDynamics(bool sticking) : sticking_(sticking) {}

  void begin(const ResponseStep& step) override { answer_.begin(step); }
  void add(std::span<const ContactPoint> contacts) override { answer_.add(contacts); }
  void correct(std::span<Vec3> x_t1) override {
    answer_.take(x_t1, 0.0);
    const double friction = sticking_ ? std::numeric_limits<double>::infinity() : 0.0;
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
    return {.promise = "equal and opposite forces remove the approach; no friction unless sticking",
            .source =
                "Carignan, Yang, Magnenat-Thalmann, Thalmann, Dressing animated synthetic actors "
                "with complex deformable clothes, 1992; survey eq. 44 to 47 corrected",
            .keeps_momentum = true,
            .passive = true};
  }

 private:
  const bool sticking_;
  ContactAnswer answer_;
};

}  // namespace
}  // namespace selvedge::detail

namespace selvedge {

void register_inverse_dynamics(ResponseRegistry& registry) {
  registry.add("inverse_dynamics",
               {{.name = "sticking",
                 .kind = OptionKind::boolean,
                 .meaning = "removes the whole relative velocity, as in the paper, instead of its "
                            "normal part"}},
               [](const MethodOptions& o) {
                 return std::make_unique<detail::InverseDynamics>(o.flag("sticking"));
               });
}

}  // namespace selvedge
