// SPDX-License-Identifier: MIT
#include <selvedge/response/fail_safe.h>
#include <selvedge/response/impact_zone.h>
#include <selvedge/response/impulse.h>

namespace selvedge {
namespace {

// Passes of impulses before rigid zones take over.
constexpr int kImpulsePasses = 8;

class ImpulseZones final : public FailSafe {
 public:
  void begin(const ResponseStep& step, Clearances&) override {
    step_ = step;
    round_ = 0;
  }

  bool resolve(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) override {
    const int round = round_++;
    if (round < kImpulsePasses) {
      // Nothing is pushed farther apart than it was: no energy comes in.
      apply_impulses(step_.motion, hits, {.recovery = 0.0}, x_t1);
      counters_["impulse_passes"] += 1;
      return true;
    }
    if (round == kImpulsePasses) zones_.begin(step_.motion);
    if (round < kImpulsePasses + ImpactZones::rounds) return grow_zones(hits, x_t1);
    trouble_ = "impulses and rigid zones do not part what collides";
    return false;
  }

  const std::string& trouble() const override { return trouble_; }
  const std::map<std::string, double>& counters() const override { return counters_; }
  ResponseTraits traits() const override {
    return {"ends a step free of collisions, or the step is halved",
            "Bridson, Fedkiw, Anderson, Robust treatment of collisions, contact and friction for "
            "cloth animation, 2002; Provot, Collision and self-collision handling in cloth model "
            "dedicated to design garments, 1997"};
  }

 private:
  bool grow_zones(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) {
    if (zones_.grow(hits, step_.mass, x_t1, counters_)) return true;
    trouble_ = zones_.trouble();
    return false;
  }

  ResponseStep step_;
  ImpactZones zones_;
  int round_ = 0;
  std::string trouble_;
  std::map<std::string, double> counters_;
};

}  // namespace

std::unique_ptr<FailSafe> make_impulse_zones() { return std::make_unique<ImpulseZones>(); }

}  // namespace selvedge
