// SPDX-License-Identifier: MIT
//
// R. Bridson, R. Fedkiw, J. Anderson, "Robust treatment of collisions, contact and friction for
// cloth animation", SIGGRAPH 2002; survey eq. 52 to 55. With barycentric weights w on four vertices
//   v_n < 0:  I = -m_eff (1 + e) v_n n,  v_i += w_i I / m_i,  1/m_eff = Σ w_i² / m_i;
//   friction: |ΔI_t| <= μ I_n, against the slip, and no more than stops it: static and dynamic.
// Mended: the survey's eq. 52 lacks the sign of the impulse, and its eq. 55, F = μ V_N, is a
// velocity and never sticks. Done otherwise than by Bridson: impulses are swept until they agree,
// and may be taken back (contact_sweeps.h), so that friction on a slope is exact; the position at
// the end is that after an impact at its own time within the step, so that heights after a bounce
// do not depend on where the step began.
//
// Guarantee: momentum of free particles and anchors is kept to rounding; for e = 0 no energy is
// given; a gap that has been lost grows back without velocity.
#include <selvedge/response/contact_sweeps.h>

namespace selvedge {
namespace {

class ImpulseResponse final : public Response {
 public:
  explicit ImpulseResponse(const ResponseConfig& config) : config_(config) { validate(config); }

  void begin(const ResponseStep& step) override { answer_.begin(step); }
  void add(std::span<const ContactPoint> contacts) override { answer_.add(contacts); }
  void correct(std::span<Vec3> x_t1) override {
    answer_.take(x_t1, config_.restitution);
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
    return {"restitution as set; Coulomb friction, static and dynamic; momentum is kept",
            "Bridson, Fedkiw, Anderson, Robust treatment of collisions, contact and friction for "
            "cloth animation, 2002",
            true, true, true};
  }

 private:
  ResponseConfig config_;
  ContactAnswer answer_;
};

}  // namespace

std::unique_ptr<Response> make_impulse(const ResponseConfig& config) {
  return std::make_unique<ImpulseResponse>(config);
}

}  // namespace selvedge
