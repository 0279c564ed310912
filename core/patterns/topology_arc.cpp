// SPDX-License-Identifier: MIT
//
// Arc mesh after J. Rusinko, H. Swan, "Agent-based fabric modeling using differential equations",
// CODEE Journal 2012 (survey section 2.10): n equally spaced particles on each of R concentric
// rings around one in the centre. It has 1 + nR particles, nR ring springs, nR radial springs and
// 2n(R-1) diagonals (the survey does not say whether the paper has diagonals; without them the mesh
// has no shear stiffness). n is the same on each ring, so the inner cells are slender and the
// innermost ring (side 2π r/n) limits the explicit step.
//
// Fabric: a cell of a (radial) by b (along the mean arc) gets the constants of a rectangular cell;
// each side spring gets half of its constant from each adjacent cell. If a cell is so slender that
// its diagonals alone would be stiffer than the cloth, its shear stiffness is reduced until
// `kLeastShare` of the stretch stiffness remains. The triangles at the centre are Van Gelder's.
// Warp and weft are thus radial and circumferential: the material is polar, unlike a woven one, and
// uses the mean of both. continuum_constants gives the resulting constants. Bending follows x and y
// (see shape_operator).
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/detail/grid_mesh.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <sstream>
#include <stdexcept>

namespace selvedge {
namespace {

constexpr double kLeastShare = 0.1;

void validate_disc(const DiscConfig& disc) {
  require(std::isfinite(disc.radius) && disc.radius > 0.0, "radius", disc.radius,
          "positive and finite");
  require(disc.rings >= 1, "rings", disc.rings, "at least 1");
  require(disc.spokes >= 3, "spokes", disc.spokes, "at least 3");
  constexpr double most_vertices = 1.3e8;  // as in grids: blocks are numbered by 32-bit integers
  require(double(disc.rings) * disc.spokes < most_vertices, "rings * spokes",
          double(disc.rings) * disc.spokes, "below 130 million");
}

class ArcMesh {
 public:
  ArcMesh(const std::vector<double>& radii, std::int32_t spokes, const Material& material)
      : radii_(radii),
        spokes_(spokes),
        rings_(static_cast<std::int32_t>(radii.size())),
        material_(material),
        stretch_(0.5 * (material.stretch_stiffness + stretch_along_weft(material))) {}

  ClothMesh build() {
    add_vertices();
    add_triangles();
    for (std::int32_t j = 1; j < rings_; ++j)
      for (std::int32_t k = 0; k < spokes_; ++k) add_cell(j, k);
    for (std::int32_t k = 0; k < spokes_; ++k) add_centre_triangle(k);
    for (const auto& [ends, stiffness] : stiffness_) add_spring(ends, stiffness);
    cloth_.mass = vertex_areas(cloth_.surface.vertices, cloth_.surface.triangles);
    for (double& m : cloth_.mass) m *= material_.density;
    detail::add_hinges(cloth_, cloth_.surface.vertices, material_);
    detail::set_stretch_law(cloth_, cloth_.surface.vertices, material_);
    return std::move(cloth_);
  }

 private:
  std::int32_t index(std::int32_t ring, std::int32_t k) const {
    return ring == 0 ? 0 : 1 + (ring - 1) * spokes_ + k % spokes_;
  }

  double distance(std::int32_t a, std::int32_t b) const {
    return (cloth_.surface.vertices[b] - cloth_.surface.vertices[a]).norm();
  }

  void add_vertices() {
    cloth_.surface.vertices.emplace_back(Vec3::Zero());
    for (std::int32_t j = 1; j <= rings_; ++j)
      for (std::int32_t k = 0; k < spokes_; ++k) {
        const double r = radii_[j - 1];
        const double angle = 2.0 * std::numbers::pi * k / spokes_;
        cloth_.surface.vertices.emplace_back(r * elementary::cos(angle), r * elementary::sin(angle),
                                             0.0);
      }
  }

  void add_triangles() {
    for (std::int32_t k = 0; k < spokes_; ++k)
      cloth_.surface.triangles.push_back({0, index(1, k), index(1, k + 1)});
    for (std::int32_t j = 1; j < rings_; ++j)
      for (std::int32_t k = 0; k < spokes_; ++k) {
        const std::int32_t v00 = index(j, k), v10 = index(j + 1, k);
        const std::int32_t v01 = index(j, k + 1), v11 = index(j + 1, k + 1);
        if ((j + k) % 2 == 0) {
          cloth_.surface.triangles.push_back({v00, v10, v11});
          cloth_.surface.triangles.push_back({v00, v11, v01});
        } else {
          cloth_.surface.triangles.push_back({v00, v10, v01});
          cloth_.surface.triangles.push_back({v10, v11, v01});
        }
      }
    cloth_.edges = unique_edges(cloth_.surface.triangles);
  }

  void add_stiffness(std::int32_t a, std::int32_t b, double stiffness) {
    stiffness_[{std::min(a, b), std::max(a, b)}] += stiffness;
  }

  void add_cell(std::int32_t j, std::int32_t k) {
    const std::int32_t v00 = index(j, k), v10 = index(j + 1, k);
    const std::int32_t v01 = index(j, k + 1), v11 = index(j + 1, k + 1);
    const double a = distance(v00, v10), inner = distance(v00, v01), outer = distance(v10, v11);
    const double b = 0.5 * (inner + outer), ratio = a / b, square = ratio * ratio;
    const double c11 =
        detail::stretch_constants(stretch_, stretch_, material_.shear_stiffness).warp;
    const double g = std::min(material_.shear_stiffness,
                              (1.0 - kLeastShare) * c11 / std::max(square, 1.0 / square));
    // A spring gets half of its stiffness from each side; a border spring has one side only.
    const double radial = 0.5 * (c11 - g * square) / ratio;
    const double ring = 0.5 * (c11 - g / square) * ratio;
    add_stiffness(v00, v10, radial);
    add_stiffness(v01, v11, radial);
    add_stiffness(v00, v01, ring);
    add_stiffness(v10, v11, ring);
    const double l = distance(v00, v11), diagonal = g * l * l / (2.0 * a * b);
    add_stiffness(v00, v11, diagonal);
    add_stiffness(v10, v01, diagonal);
  }

  void add_centre_triangle(std::int32_t k) {
    const std::array<std::int32_t, 3> v{0, index(1, k), index(1, k + 1)};
    const auto& x = cloth_.surface.vertices;
    const double area = 0.5 * (x[v[1]] - x[v[0]]).cross(x[v[2]] - x[v[0]]).norm();
    for (int e = 0; e < 3; ++e) {
      const double l = distance(v[e], v[(e + 1) % 3]);
      add_stiffness(v[e], v[(e + 1) % 3], stretch_ * area / (l * l));
    }
  }

  void add_spring(const Edge& ends, double stiffness) {
    if (stiffness <= 0.0) return;
    cloth_.springs.push_back(
        {ends[0], ends[1], distance(ends[0], ends[1]), stiffness, material_.spring_damping});
    cloth_.strain_limit.push_back(material_.strain_limit);
  }

  const std::vector<double>& radii_;
  std::int32_t spokes_, rings_;
  Material material_;
  double stretch_;  // N/m, the mean of warp and weft
  ClothMesh cloth_;
  std::map<Edge, double> stiffness_;
};

}  // namespace

ClothMesh make_rings(const std::vector<double>& radii, std::int32_t spokes,
                     const Material& material) {
  detail::validate_material(material);
  detail::require_hinges(material, "the arc mesh");
  return ArcMesh(radii, spokes, material).build();
}

ClothMesh make_arc(const DiscConfig& disc, const Material& material) {
  validate_disc(disc);
  std::vector<double> radii;
  for (std::int32_t j = 1; j <= disc.rings; ++j) radii.push_back(disc.radius * j / disc.rings);
  return make_rings(radii, disc.spokes, material);
}

void register_arc(ClothPatternRegistry& registry) {
  registry.add(
      "arc", {},
      [](const MethodOptions&, const GridConfig& grid, const Material& material) {
        if (grid.size_x != grid.size_y) {
          std::ostringstream text;
          text << "pattern \"arc\" is a disc: both sizes must be its diameter, not " << grid.size_x
               << " and " << grid.size_y;
          throw std::invalid_argument(text.str());
        }
        return make_arc({0.5 * grid.size_x, grid.cells_y, grid.cells_x}, material);
      },
      {.promise = "a disc of rings and spokes: polar, not woven",
       .source = "Rusinko, Swan, Agent-based fabric modeling using differential equations, 2012"});
}

}  // namespace selvedge
