// SPDX-License-Identifier: MIT
#include <selvedge/scene/detail/scene_forces.h>

#include <Eigen/Geometry>

namespace selvedge::detail {
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

}  // namespace

std::vector<std::unique_ptr<Force>> make_forces(const Scene& scene, const BuiltScene& built) {
  const ClothMesh& cloth = built.cloth;
  const std::size_t n = cloth.surface.vertices.size();
  std::vector<std::unique_ptr<Force>> forces = make_internal_forces(cloth);
  if (!scene.gravity.isZero(0.0)) forces.push_back(make_gravity(scene.gravity));
  if (scene.air.normal_drag > 0.0 || scene.air.viscous_drag > 0.0)
    forces.push_back(
        make_air_force(scene.air, cloth.surface.triangles, triangle_areas(cloth.surface), n));
  return forces;
}

}  // namespace selvedge::detail
