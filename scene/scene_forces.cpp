// SPDX-License-Identifier: MIT
#include <selvedge/core/strain_limiter.h>
#include <selvedge/scene/build.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>
#include <string>
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

std::int32_t first_vertex(const Scene& scene, const BuiltScene& built, const std::string& name) {
  const auto piece = std::find_if(scene.cloths.begin(), scene.cloths.end(),
                                  [&](const ClothSpec& c) { return c.name == name; });
  if (piece == scene.cloths.end())
    throw std::invalid_argument("seam: no piece of cloth is called \"" + name + "\"");
  return built.piece_begin[piece - scene.cloths.begin()];
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

}  // namespace

std::vector<std::unique_ptr<Force>> make_seams(const Scene& scene, const BuiltScene& built) {
  std::vector<std::unique_ptr<Force>> forces;
  for (const SeamSpec& seam : scene.seams) {
    const std::int32_t a = first_vertex(scene, built, seam.geometry[0]),
                       b = first_vertex(scene, built, seam.geometry[1]);
    std::vector<Edge> pairs;
    for (std::size_t i = 0; i < std::min(seam.vertices[0].size(), seam.vertices[1].size()); ++i)
      pairs.push_back({a + seam.vertices[0][i], b + seam.vertices[1][i]});
    forces.push_back(make_sewing_force(pairs, seam.sewing, built.cloth.surface.vertices.size()));
  }
  return forces;
}

std::vector<std::unique_ptr<Force>> make_forces(const Scene& scene, const BuiltScene& built,
                                                const Methods& methods) {
  const ClothMesh& cloth = built.cloth;
  const std::size_t n = cloth.surface.vertices.size();
  std::vector<std::unique_ptr<Force>> forces =
      make_internal_forces(cloth, methods.force_laws, scene.force_laws);
  if (scene.solver.strain_limiter) {
    const StrainLimiterRegistry& limiters = methods.strain_limiters;
    const auto limiter = limiters.find(scene.solver.limiter);
    if (limiter != limiters.end() && limiter->second.traits().kind == LimiterKind::force)
      forces.push_back(
          limiter->second(scene.solver.limiter_options, cloth.springs, cloth.strain_limit, n)
              .force);
  }
  for (auto& seam : make_seams(scene, built)) forces.push_back(std::move(seam));
  add_virtual_springs(built, forces);
  for (const BuiltVolume& v : built.volumes)
    forces.push_back(make_volume_force(v.stiffness, v.centre, v.triangles, cloth.surface.vertices));
  if (!scene.gravity.isZero(0.0)) forces.push_back(make_gravity(scene.gravity));
  if (scene.air.normal_drag > 0.0 || scene.air.viscous_drag > 0.0)
    forces.push_back(
        make_air_force(scene.air, cloth.surface.triangles, triangle_areas(cloth.surface), n));
  return forces;
}

}  // namespace selvedge
