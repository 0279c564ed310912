// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/inelastic_projection.h>
#include <selvedge/response/detail/zones_after.h>

namespace selvedge::detail {
namespace {

// Inelastic projection (inelastic_projection.h), then rigid impact zones (impact_zone.h) for the
// collisions that remain. Both keep the linear and angular momentum of free particles and never
// gain energy.
class ProjectionZones final : public detail::ZonesAfter {
 public:
  explicit ProjectionZones(int rounds) : ZonesAfter(rounds, "projection", "projection_rounds") {}

  ResponseTraits traits() const override {
    return {
        .promise =
            "keeps linear and angular momentum and gains no energy; the step ends without "
            "collisions, or is halved",
        .source =
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
}  // namespace selvedge::detail

namespace selvedge {

std::unique_ptr<FailSafe> make_projection_zones(const FailSafeRounds& rounds) {
  return std::make_unique<detail::ProjectionZones>(rounds.projection_rounds);
}

void register_projection_zones(FailSafeRegistry& registry) {
  registry.add("projection_zones", {},
               [](const MethodOptions&) { return make_projection_zones(); });
}

}  // namespace selvedge
