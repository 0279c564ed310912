// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/bodies/mesh_report.h>
#include <selvedge/scene/check_scene.h>
#include <selvedge/scene/contact_pairs.h>
#include <selvedge/scene/detail/scene_json.h>
#include <selvedge/scene/detail/strip_path.h>
#include <selvedge/scene/scene.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace selvedge {

namespace {

std::string at(const std::string& list, std::size_t index, const std::string& name) {
  return fmt::format("{}[{}] (\"{}\")", list, index, name);
}

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

ClothMesh make_disc(const GridConfig& config, const Material& material) {
  if (config.size_x != config.size_y)
    throw std::invalid_argument(fmt::format(
        "pattern \"arc\" is a disc, whose size must be its diameter twice, not {:g} and {:g}",
        config.size_x, config.size_y));
  return make_arc({0.5 * config.size_x, config.cells_y, config.cells_x}, material);
}

ClothMesh make_pattern(ClothPattern pattern, const GridConfig& config, const Material& material) {
  switch (pattern) {
    case ClothPattern::rectangular:
      return make_rectangular(config, material);
    case ClothPattern::triangular:
      return make_triangular(config, material);
    case ClothPattern::simplified:
      return make_simplified(config, material, false);
    case ClothPattern::checkerboard:
      return make_simplified(config, material, true);
    case ClothPattern::responsive:
      return make_responsive(config, material);
    case ClothPattern::arc:
      return make_disc(config, material);
  }
  throw std::invalid_argument("a grid has no pattern");
}

ClothMesh make_grid(const ClothGrid& grid, double factor, const Material& material) {
  GridConfig config = grid.grid;
  config.size_x *= factor;
  config.size_y *= factor;
  ClothMesh cloth = make_pattern(grid.pattern, config, material);
  if (grid.path.points.empty()) return cloth;
  StripPath path = grid.path;
  for (Vec3& point : path.points) point *= factor;
  cloth.surface.vertices = detail::lay_along(path, config.size_x, cloth.surface.vertices);
  return cloth;
}

constexpr const char* inline_mesh = "mesh";  // how a mesh that stands in the scene is named

// Vertices at the same place touch from the first step on: no contact could part them.
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
          "{}: vertices {} and {} are at the same place, where cloth would collide with "
          "itself; weld them",
          name, order[i - 1], order[i]));
}

ClothMesh load_cloth(const ClothFile& cloth, double factor, const Material& material) {
  const std::string name = cloth.file.empty() ? inline_mesh : cloth.file.string();
  TriangleMesh surface = cloth.file.empty() ? cloth.mesh : read_mesh(cloth.file);
  validate(surface, name);
  if (surface.triangles.empty())
    throw std::invalid_argument(name + ": has no triangles; cloth is a surface");
  refuse_doubled(surface, name);
  scale(surface, factor);
  if (cloth.rest_file.empty()) return make_from_mesh(surface, surface, material);
  TriangleMesh rest = read_mesh(cloth.rest_file);
  validate(rest, cloth.rest_file.string());
  if (rest.vertices.size() != surface.vertices.size() || rest.triangles != surface.triangles)
    throw std::invalid_argument(fmt::format(
        "{}: the rest mesh must have the same vertices and triangles as {}, in the same order",
        cloth.rest_file.string(), name));
  scale(rest, factor);
  return make_from_mesh(surface, rest, material);
}

void warn(const TriangleMesh& mesh, const std::string& place, std::vector<std::string>& warnings) {
  for (const std::string& sentence : report_mesh(mesh).sentences())
    warnings.push_back(place + ": " + sentence);
}

TriangleMesh load_body(const std::filesystem::path& file, const LoadConfig& config,
                       const TriangleMesh& given = {}) {
  if (file.empty()) return prepare_mesh(given, config, inline_mesh);
  TriangleMesh mesh = load_mesh(file, config);
  validate(mesh, file.string());
  if (mesh.triangles.empty())
    throw std::invalid_argument(file.string() + ": has no triangles; a body is a surface");
  return mesh;
}

/// A mesh turned into a body: keyframes turn it about its own origin, which is where its
/// transformation puts it.
std::unique_ptr<Body> make_rigid_body(TriangleMesh mesh, const BodySpec& spec) {
  scale(mesh, spec.placement.scale);
  rotate(mesh.vertices, spec.placement.rotation);
  if (spec.motion.empty()) {
    translate(mesh.vertices, spec.placement.translation);
    return make_static_body(std::move(mesh));
  }
  std::vector<Keyframe> keys = spec.motion;
  for (Keyframe& key : keys) key.translation += spec.placement.translation;
  return make_keyframed_body(std::move(mesh), std::move(keys));
}

std::unique_ptr<Body> make_sequence(const BodySequence& sequence, const Placement& placement,
                                    const std::string& place, std::vector<std::string>& warnings) {
  std::vector<TriangleMesh> frames;
  frames.reserve(sequence.files.size());
  for (const auto& file : sequence.files) {
    TriangleMesh mesh = load_body(file, sequence.load);
    if (!frames.empty() && (mesh.vertices.size() != frames.front().vertices.size() ||
                            mesh.triangles != frames.front().triangles))
      throw std::invalid_argument(
          fmt::format("{}: must have the same vertices and triangles as {}, in the same order",
                      file.string(), sequence.files.front().string()));
    if (frames.empty()) warn(mesh, place, warnings);
    scale(mesh, placement.scale);
    rotate(mesh.vertices, placement.rotation);
    translate(mesh.vertices, placement.translation);
    frames.push_back(std::move(mesh));
  }
  return make_sequence_body(std::move(frames), sequence.fps, sequence.start);
}

std::unique_ptr<Body> make_body(const BodySpec& spec, const std::string& place,
                                std::vector<std::string>& warnings) {
  if (const auto* shape = std::get_if<BodyShape>(&spec.shape))
    return make_rigid_body(tessellate(shape->shape, shape->resolution), spec);
  if (const auto* sequence = std::get_if<BodySequence>(&spec.shape))
    return make_sequence(*sequence, spec.placement, place, warnings);
  const auto& file = std::get<BodyFile>(spec.shape);
  TriangleMesh mesh = load_body(file.file, file.load, file.mesh);
  warn(mesh, place, warnings);
  return make_rigid_body(std::move(mesh), spec);
}

// Neighbours along an edge that is shorter than the thickness are always nearer than they may come.
// Such pairs then keep a part of the distance at which they start, and the cloth cannot fold as
// sharply as its mesh would let it.
void warn_of_thickness(const ClothMesh& piece, double thickness, const std::string& place,
                       std::vector<std::string>& warnings) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const Edge& e : piece.edges)
    shortest =
        std::min(shortest, (piece.surface.vertices[e[0]] - piece.surface.vertices[e[1]]).norm());
  if (shortest >= thickness) return;
  warnings.push_back(fmt::format(
      "{}: contact.thickness (or that of contact.pairs) is {:g} m, but the shortest edge is {:g} "
      "m, so that parts of the same "
      "fold count as too near each other and the cloth becomes stiffer than it is; take a "
      "thickness "
      "of at most {:g} m or larger cells",
      place, thickness, shortest, shortest));
}

void add_cloth(const Scene& scene, const ContactPairs& pairs, std::size_t index,
               BuiltScene& built) {
  const ClothSpec& spec = scene.cloths[index];
  const Material& material = scene.materials.at(spec.material);
  try {
    const ClothMesh piece = detail::make_piece(spec, material);
    const auto number = static_cast<std::int32_t>(index);
    warn_of_thickness(piece, pairs.thickness(number, number), at("geometry", index, spec.name),
                      built.warnings);
    built.piece_begin.push_back(append(built.cloth, piece));
    built.velocity.resize(built.cloth.surface.vertices.size(), spec.velocity);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}, {}: {}", scene.file.string(),
                                            at("geometry", index, spec.name), error.what()));
  }
}

void add_weights(const Scene& scene, BuiltScene& built) {
  for (const WeightSpec& weight : scene.weights) {
    const auto piece = std::find_if(scene.cloths.begin(), scene.cloths.end(),
                                    [&](const ClothSpec& c) { return c.name == weight.geometry; });
    if (piece == scene.cloths.end())
      throw std::invalid_argument(fmt::format("weight \"{}\": no piece of cloth is called \"{}\"",
                                              weight.name, weight.geometry));
    const std::int32_t first =
        built.piece_begin[static_cast<std::size_t>(piece - scene.cloths.begin())];
    for (const std::int32_t v : weight.vertices) built.cloth.mass.at(first + v) += weight.mass;
  }
}

void add_body(const Scene& scene, std::size_t index, BuiltScene& built) {
  const BodySpec& spec = scene.bodies[index];
  const std::string place = at("obstacles", index, spec.name);
  try {
    built.bodies.push_back(make_body(spec, place, built.warnings));
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(
        fmt::format("{}, {}: {}", scene.file.string(), place, error.what()));
  }
}

}  // namespace

ClothMesh detail::make_piece(const ClothSpec& cloth, const Material& material) {
  const Placement& placement = cloth.placement;
  const auto* grid = std::get_if<ClothGrid>(&cloth.shape);
  ClothMesh piece = grid != nullptr
                        ? make_grid(*grid, placement.scale, material)
                        : load_cloth(std::get<ClothFile>(cloth.shape), placement.scale, material);
  rotate(piece.surface.vertices, placement.rotation);
  translate(piece.surface.vertices, placement.translation);
  return piece;
}

BuiltScene build_scene(const Scene& scene) {
  check_numbers(scene);
  const ContactPairs pairs(scene);
  BuiltScene built;
  for (std::size_t i = 0; i < scene.cloths.size(); ++i) add_cloth(scene, pairs, i, built);
  built.piece_begin.push_back(static_cast<std::int32_t>(built.cloth.surface.vertices.size()));
  add_weights(scene, built);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) add_body(scene, i, built);
  return built;
}

}  // namespace selvedge
