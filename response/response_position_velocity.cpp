// SPDX-License-Identifier: MIT
//
// Position and velocity, survey section 6.3: the position is corrected as by `position_correction`
// (eq. 50 and 51, Coulomb friction on the path), the velocity reflected as by `reflection` (eq. 49,
// restitution and a retained share of the tangential part). Errata as there.
//
// Guarantee: momentum is kept; no energy is given for a restitution of 0.
#include <selvedge/response/contact_sweeps.h>

namespace selvedge {
namespace {

class PositionVelocity final : public Response {
 public:
  explicit PositionVelocity(const ResponseConfig& config) : config_(config) { validate(config); }

  void begin(const ResponseStep& step) override { answer_.begin(step); }
  void add(std::span<const ContactPoint> contacts) override { answer_.add(contacts); }
  void correct(std::span<Vec3> x_t1) override {
    answer_.take(x_t1, config_.restitution);
    answer_.hold_gaps();
    answer_.recover_gaps();
    answer_.reflect(config_.retention, [&](const SweptContact& c) {
      return c.impact.meets ? c.impact.rebound : -c.way() / answer_.h();
    });
    answer_.keep_impulses(1.0);
    answer_.give(x_t1);
  }
  void finish(std::span<Vec3> v) const override { answer_.finish(v); }
  void impulses(std::span<const Vec3>, std::vector<ContactImpulse>& out) const override {
    answer_.impulses(out);
  }
  ResponseTraits traits() const override {
    return {
        "particles end on the surface offset; restitution as set; a share of the tangential "
        "velocity is lost in a step; momentum is kept",
        "survey of Mozafary and Payvandy, 2016, section 6.3; Vassilev, Spanlang, Chrysanthou, "
        "Fast cloth animation on walking avatars, 2001",
        true, true, true};
  }

 private:
  ResponseConfig config_;
  ContactAnswer answer_;
};

}  // namespace

std::unique_ptr<Response> make_position_velocity(const ResponseConfig& config) {
  return std::make_unique<PositionVelocity>(config);
}

}  // namespace selvedge
