// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/impulse.h>
#include <selvedge/response/detail/zones_after.h>

namespace selvedge::detail {
namespace {

class ImpulseZones final : public detail::ZonesAfter {
 public:
  explicit ImpulseZones(int passes) : ZonesAfter(passes, "impulses", "impulse_passes") {}

  ResponseTraits traits() const override {
    return {
        .promise = "the step ends without collisions, or is halved",
        .source =
            "Bridson, Fedkiw, Anderson, Robust treatment of collisions, contact and friction for "
            "cloth animation, 2002; Provot, Collision and self-collision handling in cloth model "
            "dedicated to design garments, 1997"};
  }

 private:
  void pass(const ResponseStep& step, bool, std::span<const ContactPoint> hits,
            std::span<Vec3> x_t1) override {
    // Impulses only stop the approach and never widen a gap, so they add no energy.
    apply_impulses(step.motion, hits, {.recovery = 0.0}, x_t1);
  }
};

}  // namespace
}  // namespace selvedge::detail

namespace selvedge {

std::unique_ptr<FailSafe> make_impulse_zones(const FailSafeRounds& rounds) {
  return std::make_unique<detail::ImpulseZones>(rounds.impulse_passes);
}

void register_impulse_zones(FailSafeRegistry& registry) {
  registry.add("impulse_zones", {}, [](const MethodOptions&) { return make_impulse_zones(); });
}

}  // namespace selvedge
