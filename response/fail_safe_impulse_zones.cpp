// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/impulse.h>
#include <selvedge/response/detail/zones_after.h>

namespace selvedge {
namespace {

// Number of impulse passes before rigid zones take over.
constexpr int kImpulsePasses = 8;

class ImpulseZones final : public detail::ZonesAfter {
 public:
  ImpulseZones() : ZonesAfter(kImpulsePasses, "impulses", "impulse_passes") {}

  ResponseTraits traits() const override {
    return {"the step ends without collisions, or is halved",
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

std::unique_ptr<FailSafe> make_impulse_zones() { return std::make_unique<ImpulseZones>(); }

void register_impulse_zones(FailSafeRegistry& registry) {
  registry.add("impulse_zones", {}, [](const Options&) { return make_impulse_zones(); });
}

}  // namespace selvedge
