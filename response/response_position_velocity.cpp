// SPDX-License-Identifier: MIT
//
// Position and velocity, the second method of survey section 6.3, which credits no paper. Section
// 6.2.2 gives both parts for the system of F. Durupinar and U. Gudukbay [Durupinar2004] (eq. 49)
// [DurupinarGudukbay2007] (eq. 50): corrects the position as `position_correction` does (eq. 50 and
// 51, Coulomb friction on the path) and reflects the velocity as `reflection` does (eq. 49,
// restitution and a retained share of the tangential part). The errata of those two files apply.
//
// Guarantee: momentum is kept; no kinetic energy is added for a restitution of 0.
#include <selvedge/response/detail/contact_sweeps.h>
#include <selvedge/response/detail/response_options.h>

namespace selvedge::detail {
namespace {

class PositionVelocity final : public Response {
 public:
  explicit PositionVelocity(const MethodOptions& options)
      : restitution_(options["restitution"]), retention_(options["retention"]) {}

  void begin(const ResponseStep& step) override { answer_.begin(step); }
  void add(std::span<const ContactPoint> contacts) override { answer_.add(contacts); }
  void correct(std::span<Vec3> x_t1) override {
    answer_.take(x_t1, restitution_);
    answer_.hold_gaps();
    answer_.recover_gaps();
    answer_.reflect(retention_, [&](const SweptContact& c) {
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
        .promise =
            "particles end on the surface offset; configurable restitution; each step of contact "
            "removes a share of the tangential velocity; momentum is kept",
        .source =
            "Durupinar, Gudukbay, A virtual garment design and simulation system, 2007; survey "
            "section 6.3, eq. 49 to 51 corrected",
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

void register_position_velocity(ResponseRegistry& registry) {
  registry.add(
      "position_velocity", {detail::restitution_option(), detail::retention_option()},
      [](const MethodOptions& o) { return std::make_unique<detail::PositionVelocity>(o); });
}

}  // namespace selvedge
