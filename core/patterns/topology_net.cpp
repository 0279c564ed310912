// SPDX-License-Identifier: MIT
//
// The grid meshes as their authors print them, for comparisons: X. Provot 1995 (rectangular),
// W. Huang et al. 2014 (simplified), K.-J. Choi and H.-S. Ko 2002 (responsive; here with Hooke
// springs for its type 2), and A. Selle et al. 2009 (triangular, as the survey prints it in section
// 2.6: a spring on every edge and one between the two vertices opposite to every interior edge, on
// the rows of equilateral triangles of topology_triangular.cpp). Springs of N × N particles:
// structural 2N(N-1), shear 2(N-1)² or half of that, flexion 2N(N-2), and 2(N-2)² more along the
// diagonals in the responsive mesh. For N = 50: 14 502, 12 101 and 19 110; the survey's order of
// run times "triangular < simplified < rectangular" does not follow from counts, as the triangular
// mesh has 7301 edges and 7105 links.
//
// Square cells: C11 = C22 = ks + kd + 4 kb, C12 = C33 = kd with two diagonals, C12 = C33 = C13 =
// C23 = kd/2 with one. Hooke springs across two cells have no stiffness at zero curvature (energy ∝
// κ⁴) and add 4 kb to the stretch stiffness, so these meshes cannot converge to a plate.
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/detail/grid_mesh.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

void validate_constants(const NetConstants& c) {
  const auto number = [](const char* name, double value) {
    require(std::isfinite(value) && value >= 0.0, name, value, "at least 0 and finite");
  };
  number("structural", c.structural);
  number("shear", c.shear);
  number("flexion", c.flexion);
}

class FlexionSprings {
 public:
  FlexionSprings(ClothMesh& cloth, const GridConfig& grid, const NetConstants& constants,
                 const Material& material)
      : cloth_(cloth), grid_(grid), constants_(constants), material_(material) {}

  void add(bool diagonals) {
    if (constants_.flexion <= 0.0) return;
    const std::int32_t nx = grid_.cells_x, ny = grid_.cells_y, up = nx + 1;
    for (std::int32_t j = 0; j <= ny; ++j)
      for (std::int32_t i = 0; i <= nx; ++i) {
        const std::int32_t p = j * up + i;
        const bool right = i + 2 <= nx, above = j + 2 <= ny, below = j >= 2;
        if (right) add_spring(p, p + 2, share(j, ny));
        if (above) add_spring(p, p + 2 * up, share(i, nx));
        if (!diagonals || !right) continue;
        if (above) add_spring(p, p + 2 * up + 2, 1.0);
        if (below) add_spring(p, p - 2 * up + 2, 1.0);
      }
  }

 private:
  double share(std::int32_t line, std::int32_t last) const {
    return constants_.half_border && (line == 0 || line == last) ? 0.5 : 1.0;
  }

  void add_spring(std::int32_t a, std::int32_t b, double share) {
    const std::vector<Vec3>& x = cloth_.surface.vertices;
    cloth_.springs.push_back(
        {a, b, (x[b] - x[a]).norm(), share * constants_.flexion, material_.spring_damping});
    cloth_.strain_limit.push_back(material_.strain_limit);
  }

  ClothMesh& cloth_;
  const GridConfig& grid_;
  const NetConstants& constants_;
  const Material& material_;
};

/// The constants that the printed nets take from a material.
Material printed_material(const Material& material) {
  Material plain;
  plain.density = material.density;
  plain.spring_damping = material.spring_damping;
  plain.strain_limit = material.strain_limit;
  return plain;
}

ClothMesh make_triangular_net(const GridConfig& grid, const NetConstants& constants,
                              const Material& material) {
  detail::validate_material(material);
  validate_constants(constants);
  ClothMesh cloth = make_triangular(grid, printed_material(material));
  const std::vector<Vec3>& x = cloth.surface.vertices;
  cloth.hinges.clear();
  cloth.couples.clear();
  cloth.springs.clear();
  cloth.strain_limit.clear();
  const auto add = [&](std::int32_t a, std::int32_t b, double stiffness) {
    if (stiffness <= 0.0) return;
    cloth.springs.push_back({a, b, (x[b] - x[a]).norm(), stiffness, material.spring_damping});
    cloth.strain_limit.push_back(material.strain_limit);
  };
  for (const Edge& e : cloth.edges) add(e[0], e[1], constants.structural);
  for (const detail::InteriorEdge& e : detail::interior_edges(cloth.surface.triangles))
    add(e.v[0], e.v[1], constants.flexion);
  return cloth;
}

detail::Diagonals diagonals_of(SpringNet net) {
  if (net == SpringNet::simplified) return detail::Diagonals::same;
  if (net == SpringNet::alternating) return detail::Diagonals::alternating;
  return detail::Diagonals::both;
}

}  // namespace

ClothMesh make_spring_net(SpringNet net, const GridConfig& grid, const NetConstants& constants,
                          const Material& material) {
  detail::validate_grid(grid);
  detail::validate_material(material);
  validate_constants(constants);
  detail::CellConstants c = detail::cell_sides(grid);
  c.spring_x = c.spring_y = constants.structural;
  c.spring_diagonal = constants.shear;
  if (!constants.half_border) c.border_share = 1.0;
  ClothMesh cloth = detail::make_grid_net(grid, material, c, diagonals_of(net));
  FlexionSprings(cloth, grid, constants, material).add(net == SpringNet::responsive);
  return cloth;
}

namespace {

/// The same constant for every kind of spring, as the survey's comparisons have it.
constexpr double kEqualConstant = 100.0;  // N/m

MethodOption net_option(const char* name, const char* springs) {
  return {.name = name,
          .initial = kEqualConstant,
          .unit = "N/m",
          .least = 0.0,
          .most = 1e9,
          .meaning = std::string("constant of each spring ") + springs};
}

std::vector<MethodOption> grid_net_options() {
  return {net_option("structural", "between neighbours in a row or column"),
          net_option("shear", "along a diagonal of a cell"),
          net_option("flexion", "across two cells")};
}

void refuse_other_laws(const std::string& pattern, const Material& m) {
  if (m.stretch_law == "hooke" && m.shear_law == "springs" && m.bending_friction == 0.0 &&
      m.shear_friction == 0.0)
    return;
  throw std::invalid_argument(
      "cloth: " + pattern +
      " has Hooke springs only; take stretch_law \"hooke\", shear_law \"springs\" and no friction "
      "of shear or bending, or a pattern with the fabric's constants");
}

void add_grid_net(ClothPatternRegistry& registry, const std::string& name, SpringNet net,
                  const ClothPatternTraits& traits) {
  registry.add(
      name, grid_net_options(),
      [name, net](const MethodOptions& o, const GridConfig& grid, const Material& m) {
        refuse_other_laws(name, m);
        return make_spring_net(net, grid,
                               {.structural = o["structural"],
                                .shear = o["shear"],
                                .flexion = o["flexion"],
                                .half_border = false},
                               m);
      },
      traits);
}

}  // namespace

void register_nets(ClothPatternRegistry& registry) {
  add_grid_net(registry, "rectangular_net", SpringNet::rectangular,
               {.promise = "structural, shear and flexion springs as printed, of equal constants; "
                           "of the material only density, spring damping and strain limit",
                .source = "Provot, Deformation constraints in a mass-spring model, 1995"});
  add_grid_net(registry, "simplified_net", SpringNet::simplified,
               {.promise = "rectangular_net with one shear spring in each cell",
                .source = "Huang et al. 2014, as the survey prints it"});
  add_grid_net(registry, "responsive_net", SpringNet::responsive,
               {.promise = "rectangular_net with flexion springs along both diagonals, too",
                .source = "Choi, Ko, Stable but responsive cloth, 2002"});
  registry.add("triangular_net",
               {net_option("structural", "on an edge of a triangle"),
                net_option("flexion", "between the vertices opposite to an interior edge")},
               [](const MethodOptions& o, const GridConfig& grid, const Material& m) {
                 refuse_other_laws("triangular_net", m);
                 return make_triangular_net(
                     grid, {.structural = o["structural"], .flexion = o["flexion"]}, m);
               },
               {.promise = "edges and bend springs across interior edges as printed, of equal "
                           "constants; of the material as rectangular_net",
                .source = "Selle et al., Robust high-resolution cloth, 2009"});
}

}  // namespace selvedge
