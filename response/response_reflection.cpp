// SPDX-License-Identifier: MIT
//
// T. Vassilev, "Dressing virtual people", SCI 2000 [Vassilev2000; survey eq. 48], on bodies that
// move as in F. Durupinar, "A 3D garment design and simulation system", 2004 [Durupinar2004; survey
// eq. 49]. With the velocity relative to the body,
//   v_r = V - V_body,  v_r·n < 0:  V' = C_fric v_rt - C_refl v_rn + V_body.
// Corrected: the survey's eq. 49 reflects the parts of the absolute velocity and adds the body's
// velocity, which counts it twice: the same scene in a moving frame behaves differently. C_fric is
// the share that is retained (`retention`) in every step of contact; Coulomb's coefficient is not
// used. C_refl is the restitution. Two free primitives change their relative velocity in the same
// way, by impulses that sum to zero.
//
// Guarantee: momentum is kept; no kinetic energy is added for C_refl = 0. A violated gap is not
// restored.
#include <selvedge/response/detail/contact_sweeps.h>
#include <selvedge/response/detail/response_options.h>

namespace selvedge::detail {
namespace {

class Reflection final : public Response {
 public:
  explicit Reflection(const MethodOptions& options)
      : restitution_(options["restitution"]), retention_(options["retention"]) {}

  void begin(const ResponseStep& step) override { answer_.begin(step); }
  void add(std::span<const ContactPoint> contacts) override { answer_.add(contacts); }
  void correct(std::span<Vec3> x_t1) override {
    answer_.take(x_t1, restitution_);
    answer_.reflect(retention_, [&](const SweptContact& c) {
      return c.impact.rebound > 0.0 ? c.impact.rebound : -c.way() / answer_.h();
    });
    answer_.keep_impulses(1.0);
    answer_.move_by_velocity();
    answer_.give(x_t1);
  }
  void impulses(std::span<const Vec3>, std::vector<ContactImpulse>& out) const override {
    answer_.impulses(out);
  }
  ResponseTraits traits() const override {
    return {.promise =
                "configurable restitution; each step of contact removes a share of the tangential "
                "velocity, whatever the load; momentum is kept",
            .source =
                "Vassilev, Dressing virtual people, 2000; Durupinar, A 3D garment design and "
                "simulation system, 2004; survey eq. 48 and 49 corrected",
            .keeps_momentum = true,
            .passive = true};
  }

 private:
  const double restitution_, retention_;
  ContactAnswer answer_;
};

}  // namespace
}  // namespace selvedge::detail

namespace selvedge {

void register_reflection(ResponseRegistry& registry) {
  registry.add("reflection", {detail::restitution_option(), detail::retention_option()},
               [](const MethodOptions& o) { return std::make_unique<detail::Reflection>(o); });
}

}  // namespace selvedge
