// SPDX-License-Identifier: MIT
#include <selvedge/core/solver/strain_limiter.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/detail/solid.h>
#include <selvedge/scene/detail/solid_force.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

namespace selvedge {
namespace {

std::vector<double> triangle_areas(const TriangleMesh& mesh) {
  std::vector<double> areas;
  areas.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles)
    areas.push_back(0.5 * (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                              .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])
                              .norm());
  return areas;
}

void add_virtual_springs(const BuiltScene& built, std::vector<std::unique_ptr<Force>>& forces) {
  const std::vector<Vec3>& start = built.cloth.surface.vertices;
  for (const BuiltVirtualSprings& springs : built.virtual_springs) {
    std::vector<double> stiffness(start.size(), 0.0);
    std::copy(springs.stiffness.begin(), springs.stiffness.end(),
              stiffness.begin() + springs.begin);
    forces.push_back(make_virtual_springs(start, stiffness, springs.follow));
  }
}

// The springs that keep the leaders of rigid bodies apart.
std::vector<detail::Rod> rods_of(const BuiltScene& built) {
  const std::vector<Vec3>& start = built.cloth.surface.vertices;
  std::vector<detail::Rod> rods;
  for (const BuiltSolid& solid : built.solids)
    for (std::int32_t a = solid.leader; a < solid.leader + solid.leaders; ++a)
      for (std::int32_t b = a + 1; b < solid.leader + solid.leaders; ++b)
        rods.push_back(
            {a, b, (start[b] - start[a]).norm(),
             solid.mass / solid.leaders * detail::kSolidFrequency * detail::kSolidFrequency});
  return rods;
}

// What guides a body that slides, and the constant forces on bodies.
std::vector<Guide> guides_of(const Scene& scene, const BuiltScene& built) {
  std::vector<Guide> guides;
  for (const BuiltSolid& solid : built.solids) {
    const SolidSpec& spec = *solid_of(scene.cloths[solid.piece]);
    Guide guide{.push = spec.force / solid.leaders};
    if (spec.slides()) {
      const Vec3 along = spec.slide.normalized();
      guide.stiffness = solid.mass / solid.leaders * detail::kSolidFrequency *
                        detail::kSolidFrequency * (Mat3::Identity() - along * along.transpose());
    }
    for (int k = 0; k < solid.leaders; ++k) {
      guide.particle = solid.leader + k;
      guide.place = built.cloth.surface.vertices[guide.particle];
      guides.push_back(guide);
    }
  }
  return guides;
}

// What holds the axes of bodies on hinges and damps these and those that slide.
void add_joints(const Scene& scene, const BuiltScene& built,
                std::vector<std::unique_ptr<Force>>& forces) {
  std::vector<detail::Pin> pins;
  std::vector<detail::Damper> dampers;
  for (const BuiltSolid& solid : built.solids) {
    const SolidSpec& spec = *solid_of(scene.cloths[solid.piece]);
    if (spec.turns())
      for (const BuiltSolid::Point& pin : solid.pins)
        pins.push_back({solid.leader, pin.weight, pin.start,
                        solid.mass / 2.0 * detail::kSolidFrequency * detail::kSolidFrequency});
    if (spec.damping == 0.0) continue;
    // The leaders have equal masses: damped alike, they turn as if the hinge had the moment.
    const double arm = spec.turns() ? solid.lever : 1.0;
    for (int k = 0; k < solid.leaders; ++k)
      dampers.push_back({solid.leader + k, spec.damping / (solid.leaders * arm * arm)});
  }
  if (!pins.empty() || !dampers.empty())
    forces.push_back(detail::make_joints(std::move(pins), std::move(dampers)));
}

}  // namespace

std::vector<double> start_areas(const BuiltScene& built) {
  return built.merged_areas.empty() ? triangle_areas(built.cloth.surface) : built.merged_areas;
}

std::vector<std::unique_ptr<Force>> make_seams(const Scene& scene, const BuiltScene& built) {
  std::vector<std::unique_ptr<Force>> forces;
  for (std::size_t i = 0; i < scene.seams.size(); ++i)
    if (!built.seams[i].empty())
      forces.push_back(make_sewing_force(built.seams[i], scene.seams[i].sewing,
                                         built.cloth.mass.size(), built.cloth.mass));
  return forces;
}

std::vector<std::unique_ptr<Force>> make_forces(const Scene& scene, const BuiltScene& built,
                                                const Methods& methods) {
  return make_forces(scene, built, built.cloth, methods);
}

std::vector<std::unique_ptr<Force>> make_forces(const Scene& scene, const BuiltScene& built,
                                                const ClothMesh& cloth, const Methods& methods) {
  const std::size_t n = cloth.surface.vertices.size();
  std::vector<std::unique_ptr<Force>> forces =
      make_internal_forces(cloth, methods.force_laws, scene.force_laws);
  if (scene.solver.strain_limiter) {
    const StrainLimiterRegistry& limiters = methods.strain_limiters;
    const auto limiter = limiters.find(scene.solver.limiter);
    if (limiter != limiters.end() && (limiter->second.traits().kind == LimiterKind::force ||
                                      limiter->second.traits().adds_force))
      if (auto force =
              limiter->second(scene.solver.limiter_options, cloth.springs, cloth.strain_limit, n)
                  .force)
        forces.push_back(std::move(force));
  }
  for (auto& seam : make_seams(scene, built)) forces.push_back(std::move(seam));
  add_virtual_springs(built, forces);
  if (!built.solids.empty()) {
    forces.push_back(detail::make_rods(rods_of(built)));
    forces.push_back(make_guides(guides_of(scene, built)));
    add_joints(scene, built, forces);
  }
  for (const BuiltVolume& v : built.volumes)
    forces.push_back(make_volume_force(v.stiffness, v.centre, v.triangles, cloth.surface.vertices));
  if (!scene.gravity.isZero(0.0)) forces.push_back(make_gravity(scene.gravity));
  if (scene.air.normal_drag > 0.0 || scene.air.viscous_drag > 0.0)
    forces.push_back(make_air_force(scene.air, cloth.surface.triangles, start_areas(built), n));
  return forces;
}

}  // namespace selvedge
