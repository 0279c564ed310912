// SPDX-License-Identifier: MIT
//
// Cone of normals after X. Provot, Collision and self-collision handling in cloth model dedicated
// to design garments, 1997 [Provot1997; survey 6.1.3, Figure 40]: a zone of the surface whose
// normals all lie in a cone with an angle below π at its vertex is taken not to meet itself. That
// is necessary and not sufficient: a ramp that winds twice about an axis has all normals in a
// narrow cone and meets itself. curvature_cone.cpp adds what is missing. Deviation: the normals are
// those at both ends of the step, and a zone is one connected piece.
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/patch_cull.h>

#include <Eigen/Geometry>
#include <span>

namespace selvedge {
namespace {

using detail::Patches;

class NormalCone final : public detail::PatchCull {
 public:
  BroadPhaseTraits traits() const override {
    return {.guarantee = Guarantee::approximate,
            .pairs = PairSet::culled,
            .source =
                "X. Provot, Collision and self-collision handling in cloth model dedicated "
                "to design garments, 1997"};
  }

 private:
  void begin(const SurfaceView&) override {}

  bool cannot_meet_itself(const SurfaceView& surface, const Patches::Patch& patch) const override {
    return patch.is_disc_like && fits_in_cone(surface.x_t0, surface, patch) &&
           fits_in_cone(surface.x_t1, surface, patch);
  }

  /// Whether all normals are less than a right angle away from their sum. A triangle without area
  /// has no normal, so the zone is kept.
  bool fits_in_cone(std::span<const Vec3> x, const SurfaceView& surface,
                    const Patches::Patch& patch) const {
    const auto order = patches().order().subspan(patch.begin, patch.end - patch.begin);
    const auto normal = [&](std::int32_t triangle) {
      const Triangle& t = surface.triangles[triangle];
      return Vec3((x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).normalized());
    };
    Vec3 axis = Vec3::Zero();
    for (const std::int32_t t : order) axis += normal(t);
    for (const std::int32_t t : order)
      if (!(normal(t).dot(axis) > 0.0)) return false;
    return true;
  }
};

}  // namespace

std::unique_ptr<BroadPhase> make_normal_cone(const BvhConfig& config) {
  return detail::make_bvh_aabb(config, std::make_unique<NormalCone>());
}

void register_normal_cone(BroadPhaseRegistry& registry) {
  registry.add("normal_cone", {}, [](const MethodOptions&) { return make_normal_cone(); });
}

}  // namespace selvedge
