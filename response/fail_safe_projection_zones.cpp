// SPDX-License-Identifier: MIT
#include <selvedge/response/fail_safe.h>
#include <selvedge/response/impact_zone.h>
#include <selvedge/response/inelastic_projection.h>

namespace selvedge {
namespace {

// Rounds of projection before rigid zones take over. A round undoes what collides and finds what
// collides instead; a stack of twelve sheets at 10 m/s settles in about that many.
constexpr int kProjectionRounds = 20;

// Inelastic projection (inelastic_projection.h), then rigid impact zones (impact_zone.h) for what
// still collides. Both keep linear and angular momentum of free particles and never gain energy.
class ProjectionZones final : public FailSafe {
 public:
  void begin(const ResponseStep& step, Clearances&) override {
    step_ = step;
    round_ = 0;
  }

  bool resolve(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) override {
    const int round = round_++;
    if (round == 0) projection_.begin(step_, x_t1);
    if (round < kProjectionRounds) {
      projection_.add(hits);
      projection_.apply(x_t1);
      counters_["projection_rounds"] += 1;
      return true;
    }
    if (round == kProjectionRounds) zones_.begin(step_.motion);
    if (round < kProjectionRounds + ImpactZones::rounds) return grow_zones(hits, x_t1);
    trouble_ = "projection and rigid zones do not part what collides";
    return false;
  }

  const std::string& trouble() const override { return trouble_; }
  const std::map<std::string, double>& counters() const override { return counters_; }
  ResponseTraits traits() const override {
    return {
        "keeps linear and angular momentum and gains no energy; ends a step free of "
        "collisions, or the step is halved",
        "Harmon, Vouga, Tamstorf, Grinspun, Robust treatment of simultaneous collisions, 2008; "
        "Provot, Collision and self-collision handling in cloth model dedicated to design "
        "garments, 1997"};
  }

 private:
  bool grow_zones(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) {
    if (zones_.grow(hits, step_.mass, x_t1, counters_)) return true;
    trouble_ = zones_.trouble();
    return false;
  }

  ResponseStep step_;
  InelasticProjection projection_;
  ImpactZones zones_;
  int round_ = 0;
  std::string trouble_;
  std::map<std::string, double> counters_;
};

}  // namespace

std::unique_ptr<FailSafe> make_projection_zones() { return std::make_unique<ProjectionZones>(); }

}  // namespace selvedge
