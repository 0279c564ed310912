// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/core/patterns/internal/make_plate.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/scene/detail/make_piece.h>
#include <selvedge/scene/detail/solid.h>
#include <selvedge/scene/detail/strip_path.h>
#include <selvedge/scene/internal/adaptive_cloth.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace selvedge {
namespace detail {

void scale(TriangleMesh& mesh, double factor) {
  if (factor == 1.0) return;  // keep the file's bits
  for (Vec3& x : mesh.vertices) x *= factor;
}

void rotate(std::vector<Vec3>& points, const Eigen::Quaterniond& rotation) {
  if (rotation.coeffs() == Eigen::Quaterniond::Identity().coeffs()) return;
  const Mat3 matrix = rotation.toRotationMatrix();
  for (Vec3& x : points) x = matrix * x;
}

void translate(std::vector<Vec3>& points, const Vec3& translation) {
  for (Vec3& x : points) x += translation;
}

}  // namespace detail

namespace {

// -- grids ----------------------------------------------------------------------------------------

// The thickness h of a plate follows from its stretch stiffness E h and its bending rigidity B:
// h² = 12 (1-ν²) B/(E h).
PlateConstants plate_of(double poisson, const Material& m) {
  if (!(m.bending_stiffness > 0.0))
    throw std::invalid_argument("the material of a plate must have a positive bending_stiffness");
  const double squared =
      12.0 * (1.0 - poisson * poisson) * m.bending_stiffness / m.stretch_stiffness;
  return {m.stretch_stiffness, poisson, std::sqrt(std::max(squared, 0.0))};
}

ClothMesh make_pattern(const ClothGrid& grid, const GridConfig& config, const Material& material,
                       const ClothPatternRegistry& patterns) {
  ClothMesh cloth =
      make_method(patterns, grid.pattern, "pattern", grid.pattern_options, config, material);
  if (grid.plate && !patterns.at(grid.pattern).traits().fits_plate)
    throw std::invalid_argument("a plate is fitted to triangles; take pattern \"triangular\"");
  if (!grid.plate) return cloth;
  return make_plate(cloth.surface, plate_of(*grid.plate, material), material).cloth;
}

GridConfig scaled(const ClothGrid& grid, double factor) {
  GridConfig config = grid.grid;
  config.size_x *= factor;
  config.size_y *= factor;
  return config;
}

/// The pattern whose cells are those of AdaptiveGrid.
constexpr const char* kQuadtreePattern = "rectangular";

void refuse_unsuited_angles(const RefineSpec& refine) {
  if (refine.join_deg > 0.0 && refine.when != RefineSpec::When::curved)
    throw std::invalid_argument(
        "\"join_deg\" joins cells where the cloth has become flat; it needs \"when\": \"curved\"");
  if (refine.join_deg > 0.0 && !(refine.join_deg < refine.angle_deg))
    throw std::invalid_argument(
        "\"join_deg\" must be less than \"angle_deg\", or cells would be joined and split in turn");
}

void refuse_unsuited_refinement(const ClothGrid& grid, const ClothPatternRegistry& patterns) {
  if (!patterns.at(grid.pattern).traits().splits)
    throw std::invalid_argument(
        "\"refine\" splits cells or triangles; take pattern \"rectangular\" or \"triangular\"");
  refuse_unsuited_angles(grid.refine);
}

Piece make_grid(const ClothSpec& spec, const ClothGrid& grid, const Material& material,
                const ClothPatternRegistry& patterns) {
  const double factor = spec.scale;
  const GridConfig config = scaled(grid, factor);
  Piece piece{grid.refine.when == RefineSpec::When::never
                  ? make_pattern(grid, config, material, patterns)
                  : make_adaptive_cloth(spec, material, patterns).cloth(),
              {}};
  ClothMesh& cloth = piece.cloth;
  piece.rest = cloth.surface;
  if (grid.path.points.empty()) return piece;
  StripPath path = grid.path;
  for (Vec3& point : path.points) point *= factor;
  cloth.surface.vertices = detail::lay_along(path, config.size_x, cloth.surface.vertices);
  return piece;
}

// -- meshes ---------------------------------------------------------------------------------------

// Coincident vertices touch from the first step on, and no contact can separate them.
void refuse_doubled(const TriangleMesh& mesh, const std::string& name) {
  const std::vector<Vec3>& x = mesh.vertices;
  std::vector<std::size_t> order(x.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    if (x[a] == x[b]) return a < b;
    return std::lexicographical_compare(x[a].begin(), x[a].end(), x[b].begin(), x[b].end());
  });
  for (std::size_t i = 1; i < order.size(); ++i)
    if (x[order[i]] == x[order[i - 1]])
      throw std::invalid_argument(fmt::format(
          "{}: vertices {} and {} are at the same place, so the cloth touches itself at the start; "
          "weld them",
          name, order[i - 1], order[i]));
}

TriangleMesh load_surface(const ClothFile& cloth, const std::string& name, double factor) {
  TriangleMesh surface = cloth.file.empty() ? cloth.mesh : read_mesh(cloth.file);
  validate(surface, name);
  if (surface.triangles.empty())
    throw std::invalid_argument(name + ": has no triangles; cloth is a surface");
  refuse_doubled(surface, name);
  detail::scale(surface, factor);
  return surface;
}

TriangleMesh load_rest(const ClothFile& cloth, const std::string& name, const TriangleMesh& surface,
                       double factor) {
  if (cloth.file.empty() && !cloth.rest_mesh.triangles.empty()) {
    TriangleMesh rest = cloth.rest_mesh;
    validate(rest, "rest_mesh");
    if (rest.vertices.size() != surface.vertices.size() || rest.triangles != surface.triangles)
      throw std::invalid_argument("rest_mesh must have the vertices and triangles of mesh");
    detail::scale(rest, factor);
    return rest;
  }
  if (cloth.rest_file.empty()) return surface;
  TriangleMesh rest = read_mesh(cloth.rest_file);
  validate(rest, cloth.rest_file.string());
  if (rest.vertices.size() != surface.vertices.size() || rest.triangles != surface.triangles)
    throw std::invalid_argument(fmt::format(
        "{}: the rest mesh must have the same vertices and triangles as {}, in the same order",
        cloth.rest_file.string(), name));
  detail::scale(rest, factor);
  return rest;
}

/// The flat pieces in the texture coordinates.
TriangleMesh load_pattern(const ClothFile& cloth, double factor) {
  return read_pattern(cloth.file, factor * cloth.texture_unit);
}

void refuse_unsuited_refinement(const ClothFile& cloth) {
  const char* fault = nullptr;
  if (cloth.support) fault = "\"support\" holds the vertices that there are";
  if (cloth.plate) fault = "\"plate\" fits springs to one mesh";
  if (fault != nullptr)
    throw std::invalid_argument(fmt::format("\"refine\" splits triangles, but {}", fault));
  refuse_unsuited_angles(cloth.refine);
}

std::string name_of(const ClothFile& cloth) {
  return cloth.file.empty() ? detail::inline_mesh : cloth.file.string();
}

Piece load_cloth(const ClothFile& cloth, double factor, const Material& material) {
  if (cloth.refine.when != RefineSpec::When::never) refuse_unsuited_refinement(cloth);
  const std::string name = name_of(cloth);
  const TriangleMesh surface = load_surface(cloth, name, factor);
  if (cloth.solid) {
    ClothMesh solid = detail::make_solid(surface, *cloth.solid);
    TriangleMesh rest = solid.surface;
    return {std::move(solid), std::move(rest)};
  }
  const bool has_rest = !cloth.rest_file.empty() || cloth.texture_unit > 0.0;
  if (cloth.support && (cloth.plate || has_rest))
    throw std::invalid_argument(
        "\"support\" keeps the shape of the mesh; it cannot be combined with \"plate\" or a rest "
        "shape");
  if (cloth.support) {
    ClothMesh body = make_supported(surface, *cloth.support, material);
    return {body, body.surface};
  }
  if (cloth.texture_unit > 0.0) {
    if (cloth.plate)
      throw std::invalid_argument("\"plate\" cannot be combined with \"rest_mesh\": \"texture\"");
    TriangleMesh pattern = load_pattern(cloth, factor);
    return {make_from_pattern(surface, pattern, material), std::move(pattern)};
  }
  TriangleMesh rest = load_rest(cloth, name, surface, factor);
  if (!cloth.plate) return {make_from_mesh(surface, rest, material), std::move(rest)};
  ClothMesh plate = make_plate(rest, plate_of(*cloth.plate, material), material).cloth;
  plate.surface.vertices = surface.vertices;
  return {std::move(plate), std::move(rest)};
}

std::optional<double> plate_in(const ClothSpec& cloth) {
  return std::visit([](const auto& shape) { return shape.plate; }, cloth.shape);
}

/// Refuses what is made of springs that the material does not give.
void refuse_springs_of_their_own(const ClothSpec& cloth, const Material& material) {
  const auto* file = std::get_if<ClothFile>(&cloth.shape);
  const bool angle = shear_law_of(material).by_triangles;
  if (plate_in(cloth))
    throw std::invalid_argument(
        angle
            ? "\"plate\" fits springs to a plate, which have a shear stiffness of their own; take "
              "shear_law \"springs\""
            : "\"plate\" fits springs to a plate; finite elements are one, so leave it out and "
              "give the material's \"poisson\"");
  if (file != nullptr && file->support)
    throw std::invalid_argument(
        angle ? "\"support\" is made of springs, which have a shear stiffness of their own; take "
                "shear_law \"springs\""
              : "\"support\" is made of springs; finite elements cannot replace them, use "
                "stretch_law \"hooke\"");
}

}  // namespace

const RefineSpec* refine_of(const ClothSpec& cloth) {
  const RefineSpec& refine =
      std::visit([](const auto& shape) -> const RefineSpec& { return shape.refine; }, cloth.shape);
  return refine.when != RefineSpec::When::never ? &refine : nullptr;
}

AdaptiveGrid make_adaptive_grid(const ClothSpec& cloth, const Material& material,
                                const ClothPatternRegistry& patterns) {
  const auto& grid = std::get<ClothGrid>(cloth.shape);
  refuse_unsuited_refinement(grid, patterns);
  return {scaled(grid, cloth.scale), material, grid.refine.levels};
}

AdaptiveCloth make_adaptive_cloth(const ClothSpec& cloth, const Material& material,
                                  const ClothPatternRegistry& patterns) {
  if (const auto* file = std::get_if<ClothFile>(&cloth.shape)) {
    refuse_unsuited_refinement(*file);
    const double factor = cloth.scale;
    const std::string name = name_of(*file);
    TriangleMesh surface = load_surface(*file, name, factor);
    if (file->texture_unit > 0.0)
      return AdaptiveTriangles(std::move(surface), load_pattern(*file, factor), material,
                               file->refine.levels);
    return AdaptiveTriangles(load_rest(*file, name, surface, factor), material,
                             file->refine.levels);
  }
  const auto& grid = std::get<ClothGrid>(cloth.shape);
  if (grid.pattern == kQuadtreePattern) return make_adaptive_grid(cloth, material, patterns);
  refuse_unsuited_refinement(grid, patterns);
  if (grid.plate)
    throw std::invalid_argument(
        "\"plate\" fits springs to one mesh, which \"refine\" changes; leave one of them out");
  const GridConfig config = scaled(grid, cloth.scale);
  ClothMesh mesh =
      make_method(patterns, grid.pattern, "pattern", grid.pattern_options, config, material);
  return AdaptiveTriangles(std::move(mesh.surface), material, grid.refine.levels);
}

Piece make_piece(const ClothSpec& cloth, const Material& material,
                 const ClothPatternRegistry& patterns) {
  if (stretch_law_of(material).add_to_triangles != nullptr || shear_law_of(material).by_triangles)
    refuse_springs_of_their_own(cloth, material);
  const Placement& placement = cloth.placement;
  const auto* grid = std::get_if<ClothGrid>(&cloth.shape);
  Piece piece = grid != nullptr
                    ? make_grid(cloth, *grid, material, patterns)
                    : load_cloth(std::get<ClothFile>(cloth.shape), cloth.scale, material);
  detail::rotate(piece.cloth.surface.vertices, placement.rotation);
  detail::translate(piece.cloth.surface.vertices, placement.translation);
  return piece;
}

std::vector<std::string> detail::plate_warnings(const ClothSpec& cloth, const Material& material) {
  const std::optional<double> poisson = plate_in(cloth);
  if (!poisson) return {};
  constexpr double rounding = 1e-9;
  const double residual = cauchy_residual(plate_constants(material.stretch_stiffness, *poisson));
  if (residual <= rounding) return {};
  return {fmt::format(
      "springs reproduce only a Poisson's ratio of 1/3; with {:g} the best fit deviates "
      "from the plate by {:.1f} % of its constants",
      *poisson, 100.0 * residual)};
}

// A material with the default shear stiffness says nothing about it: the reader completes defaults,
// and the scene.json of a result has them all.
std::vector<std::string> detail::shear_warnings(const ClothSpec& cloth, const Material& material) {
  if (!shear_law_of(material).by_springs || stretch_law_of(material).add_to_triangles != nullptr ||
      material.shear_stiffness == Material{}.shear_stiffness || plate_in(cloth))
    return {};
  const auto* grid = std::get_if<ClothGrid>(&cloth.shape);
  if (grid != nullptr ? grid->pattern != "triangular"
                      : std::get<ClothFile>(cloth.shape).support.has_value())
    return {};
  return {fmt::format(
      "shear_stiffness {:g} N/m has no effect on the springs of triangles, which resist shear by "
      "3/8 of the stretch stiffness; take shear_law \"angle\" or stretch_law \"corotated\"",
      material.shear_stiffness)};
}

std::vector<std::string> detail::arc_warnings(const ClothSpec& cloth, const Material& material,
                                              const Piece& piece) {
  constexpr double served = 0.1;  // share of a stiffness by which a mesh may miss it
  const auto* grid = std::get_if<ClothGrid>(&cloth.shape);
  if (grid == nullptr || grid->pattern != "arc" || !shear_law_of(material).by_springs ||
      stretch_law_of(material).add_to_triangles != nullptr)
    return {};
  const std::vector<Vec3>& rest = piece.rest.vertices;
  const std::vector<double> areas = vertex_areas(rest, piece.rest.triangles);
  const ContinuumConstants c =
      continuum_constants(piece.cloth, rest, std::accumulate(areas.begin(), areas.end(), 0.0));
  const double warp = material.stretch_stiffness, weft = stretch_along_weft(material);
  const double shear = material.shear_stiffness;
  if (warp == weft && std::abs(c.c33 - shear) <= served * shear) return {};
  return {fmt::format(
      "the springs of an arc mesh lie along rings and spokes, not along warp and weft: on the "
      "whole "
      "it resists shear by {:.3g} N/m (asked: {:g}) and stretch by {:.3g} N/m in every direction "
      "(asked: {:g} along the warp, {:g} along the weft); take shear_law "
      "\"angle\" or stretch_law \"corotated\"",
      c.c33, shear, strip_modulus(c), warp, weft)};
}

}  // namespace selvedge
