// SPDX-License-Identifier: MIT
//
// Impulses, which the survey prints after M. Tang, R. Tong, R. Narain, C. Meng, D. Manocha, "A
// GPU-based streaming algorithm for high-resolution cloth simulation", 2013 [Tang2013; survey eq.
// 52 to 54], with the weights and the friction of R. Bridson, R. Fedkiw, J. Anderson, "Robust
// treatment of collisions, contact and friction for cloth animation", SIGGRAPH 2002 [Bridson2002],
// in place of survey eq. 55. With barycentric weights w on four vertices
//   v_n < 0:  I = -m_eff (1 + e) v_n n,  v_i += w_i I / m_i,  1/m_eff = Σ w_i² / m_i;
//   friction: |ΔI_t| <= μ I_n, against the slip, at most as much as stops it: static and dynamic.
// Corrected: the survey's eq. 52 omits the sign of the impulse, and its eq. 55, F = μ V_N, is a
// velocity and never sticks. Deviations from Bridson: impulses are swept until they are consistent
// and may be taken back (contact_sweeps.h), so that friction on a slope is exact. The end position
// is the one after an impact at its own time within the step, so that the height of a bounce does
// not depend on where the step began.
//
// Guarantee: the momentum of free particles and anchors is kept to rounding. For e = 0 no kinetic
// energy is added. A violated gap grows back without adding velocity.
#include <selvedge/response/detail/contact_sweeps.h>
#include <selvedge/response/detail/response_options.h>

namespace selvedge::detail {
namespace {

class ImpulseResponse final : public Response {
 public:
  explicit ImpulseResponse(double restitution) : restitution_(restitution) {}

  void begin(const ResponseStep& step) override { answer_.begin(step); }
  void add(std::span<const ContactPoint> contacts) override { answer_.add(contacts); }
  void correct(std::span<Vec3> x_t1) override {
    answer_.take(x_t1, restitution_);
    answer_.sweep_velocity([&](const SweptContact& c) {
      return c.impact.meets ? c.impact.rebound : -c.way() / answer_.h();
    });
    answer_.keep_impulses(1.0);
    answer_.hold_gaps();
    answer_.recover_gaps();
    answer_.give(x_t1);
  }
  void finish(std::span<Vec3> v) const override { answer_.finish(v); }
  void impulses(std::span<const Vec3>, std::vector<ContactImpulse>& out) const override {
    answer_.impulses(out);
  }
  ResponseTraits traits() const override {
    return {
        .promise =
            "configurable restitution; static and dynamic Coulomb friction; momentum is kept",
        .source =
            "Tang et al. 2013, survey eq. 52 to 54 corrected; Bridson, Fedkiw, Anderson, Robust "
            "treatment of collisions, contact and friction for cloth animation, 2002",
        .keeps_momentum = true,
        .passive = true};
  }

 private:
  const double restitution_;
  ContactAnswer answer_;
};

}  // namespace
}  // namespace selvedge::detail

namespace selvedge {

void register_impulse(ResponseRegistry& registry) {
  registry.add("impulse", {detail::restitution_option()}, [](const MethodOptions& o) {
    return std::make_unique<detail::ImpulseResponse>(o["restitution"]);
  });
}

}  // namespace selvedge
