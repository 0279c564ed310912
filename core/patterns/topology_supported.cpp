// SPDX-License-Identifier: MIT
//
// Mesh with support springs after L. Zhengdong, S. Shuyuan 2011 (survey section 2.9): a closed
// surface whose edges are tension springs, and a spring from every vertex to the centre of the
// body. The centre is an additional particle at the mean of all vertices. n vertices and e edges
// give e + n springs (Euler: e = 3n - 6). See force_volume.cpp for eq. 3. Deviation: the survey
// does not give the mass of the centre; here it is the mean mass of a vertex.
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <cmath>
#include <limits>

namespace selvedge {

ClothMesh make_supported(const TriangleMesh& closed, const SupportConstants& support,
                         const Material& material) {
  require(std::isfinite(support.stiffness) && support.stiffness > 0.0, "stiffness",
          support.stiffness, "positive and finite");
  require(support.share > 0.0 && support.share < 1.0, "share", support.share, "between 0 and 1");
  ClothMesh cloth = make_from_mesh(closed, closed, material);
  const std::size_t n = closed.vertices.size();
  Vec3 centre = Vec3::Zero();
  double mass = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    centre += closed.vertices[i] / static_cast<double>(n);
    mass += cloth.mass[i] / static_cast<double>(n);
  }
  cloth.surface.vertices.push_back(centre);
  cloth.mass.push_back(mass);
  for (std::size_t i = 0; i < n; ++i) {
    const double length = (closed.vertices[i] - centre).norm();
    require(length > 0.0, "distance of a vertex from the centre", length, "positive");
    cloth.springs.push_back({static_cast<std::int32_t>(i), static_cast<std::int32_t>(n), length,
                             support.stiffness * support.share, material.spring_damping});
    // A support spring runs inside the body, so the strain limit of the cloth does not apply to it.
    cloth.strain_limit.push_back(std::numeric_limits<double>::max());
    if (!cloth.curve_of_spring.empty()) cloth.curve_of_spring.push_back(-1);
  }
  return cloth;
}

void register_support(ClothPatternRegistry& registry) {
  registry.add_keyed(
      "support", "geometry.*.support",
      {.promise = "a closed surface and its centre; survey eq. 3 corrected",
       .source = "Zhengdong, Shuyuan, A mass-spring model for real time cloth deformation, 2011"});
}

}  // namespace selvedge
