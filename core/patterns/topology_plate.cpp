// SPDX-License-Identifier: MIT
//
// Springs from plate theory after X. Wang, V. Devarajan, "Improved 2D mass-spring-damper model with
// unstructured triangular meshes", The Visual Computer 2008 (survey 3.1; the rows of its table III
// are shifted by one). Each triangle gets the three non-negative stiffnesses that are nearest to
// the plate's constants, by least squares over the in-plane tensor; an edge has the sum of its two
// triangles. Bending: hinges of the plate rigidity D = E h³/(12 (1 - ν²)). Deviation: in the
// survey, springs fit any E and ν. That is impossible: a net has C12 = C33, so an isotropic net has
// ν = 1/3; the residual is returned. Equilateral triangles with ν = 1/3 have no residual, with k =
// √3/2 E h on inner edges.
#include <selvedge/core/cloth/cloth_elements.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/core/patterns/internal/make_plate.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace selvedge {
namespace {

void validate_plate(const PlateConstants& plate) {
  const auto positive = [](const char* name, double value) {
    require(std::isfinite(value) && value > 0.0, name, value, "positive and finite");
  };
  positive("stretch", plate.stretch);
  positive("thickness", plate.thickness);
  require(std::abs(plate.poisson) < 1.0, "poisson", plate.poisson, "between -1 and 1");
}

void validate_flat(const TriangleMesh& rest) {
  for (std::size_t i = 0; i < rest.vertices.size(); ++i)
    if (rest.vertices[i].z() != rest.vertices[0].z())
      throw std::invalid_argument("plate: vertex " + std::to_string(i) +
                                  " of the rest mesh is not in one plane of constant z with vertex "
                                  "0; flatten the mesh");
}

}  // namespace

PlateMesh make_plate(const TriangleMesh& rest, const PlateConstants& plate,
                     const Material& material) {
  validate_plate(plate);
  validate(rest, "plate");
  validate_flat(rest);
  Material m = material;
  m.stretch_weft = m.bending_weft = std::nullopt;
  m.stretch_stiffness = plate.stretch;
  m.bending_stiffness = plate.stretch * plate.thickness * plate.thickness /
                        (12.0 * (1.0 - plate.poisson * plate.poisson));
  PlateMesh out{make_from_mesh(rest, rest, m), 0.0, 0.0};
  std::vector<Spring>& springs = out.cloth.springs;
  for (Spring& s : springs) s.stiffness = 0.0;
  const ContinuumConstants wanted = plate_constants(plate.stretch, plate.poisson);
  double area = 0.0, squares = 0.0;
  for (const Triangle& t : rest.triangles) {
    const detail::SpringFit f = detail::fit_springs(rest.vertices, t, wanted);
    area += f.area;
    squares += f.area * f.residual * f.residual;
    out.worst = std::max(out.worst, f.residual);
    for (int k = 0; k < 3; ++k) {
      const Edge key{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])};
      const auto& edges = out.cloth.edges;
      springs[std::lower_bound(edges.begin(), edges.end(), key) - edges.begin()].stiffness +=
          f.stiffness[k];
    }
  }
  out.residual = std::sqrt(squares / area);
  std::erase_if(springs, [](const Spring& s) { return s.stiffness <= 0.0; });
  out.cloth.strain_limit.assign(springs.size(), m.strain_limit);
  if (!out.cloth.curve_of_spring.empty()) out.cloth.curve_of_spring.assign(springs.size(), 0);
  return out;
}

}  // namespace selvedge
