// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/inelastic_projection.h>
#include <selvedge/response/detail/zones_after.h>

namespace selvedge {
namespace {

// Maximum number of projection rounds before rigid zones take over. A round resolves the known
// collisions and reveals new ones; a stack of twelve sheets at 10 m/s settles in about this many.
constexpr int kProjectionRounds = 20;

// Inelastic projection (inelastic_projection.h), then rigid impact zones (impact_zone.h) for the
// collisions that remain. Both keep the linear and angular momentum of free particles and never
// gain energy.
class ProjectionZones final : public detail::ZonesAfter {
 public:
  ProjectionZones() : ZonesAfter(kProjectionRounds, "projection", "projection_rounds") {}

  ResponseTraits traits() const override {
    return {
        "keeps linear and angular momentum and gains no energy; the step ends without "
        "collisions, or is halved",
        "Harmon, Vouga, Tamstorf, Grinspun, Robust treatment of simultaneous collisions, 2008; "
        "Provot, Collision and self-collision handling in cloth model dedicated to design "
        "garments, 1997"};
  }

 private:
  void pass(const ResponseStep& step, bool first, std::span<const ContactPoint> hits,
            std::span<Vec3> x_t1) override {
    if (first) projection_.begin(step, x_t1);
    projection_.add(hits);
    projection_.apply(x_t1);
  }

  InelasticProjection projection_;
};

}  // namespace

std::unique_ptr<FailSafe> make_projection_zones() { return std::make_unique<ProjectionZones>(); }

void register_projection_zones(FailSafeRegistry& registry) {
  registry.add("projection_zones", {}, [](const Options&) { return make_projection_zones(); });
}

}  // namespace selvedge
