// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/zones_after.h>
#include <selvedge/response/impulse.h>

namespace selvedge {
namespace {

// Passes of impulses before rigid zones take over.
constexpr int kImpulsePasses = 8;

class ImpulseZones final : public detail::ZonesAfter {
 public:
  ImpulseZones() : ZonesAfter(kImpulsePasses, "impulses", "impulse_passes") {}

  ResponseTraits traits() const override {
    return {"ends a step free of collisions, or the step is halved",
            "Bridson, Fedkiw, Anderson, Robust treatment of collisions, contact and friction for "
            "cloth animation, 2002; Provot, Collision and self-collision handling in cloth model "
            "dedicated to design garments, 1997"};
  }

 private:
  void pass(const ResponseStep& step, bool, std::span<const ContactPoint> hits,
            std::span<Vec3> x_t1) override {
    // Nothing is pushed farther apart than it was: no energy comes in.
    apply_impulses(step.motion, hits, {.recovery = 0.0}, x_t1);
  }
};

}  // namespace

std::unique_ptr<FailSafe> make_impulse_zones() { return std::make_unique<ImpulseZones>(); }

}  // namespace selvedge
