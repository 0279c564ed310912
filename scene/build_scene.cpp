// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/bodies/internal/mesh_groups.h>
#include <selvedge/bodies/internal/sequence_leap.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/bodies/mesh_report.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/detail/between_particles.h>
#include <selvedge/scene/detail/check_scene.h>
#include <selvedge/scene/detail/make_piece.h>
#include <selvedge/scene/detail/rest_gap.h>
#include <selvedge/scene/detail/solid.h>
#include <selvedge/scene/scene.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>
#include <utility>

namespace selvedge {

namespace {

using detail::rotate;
using detail::scale;
using detail::translate;

std::string at(const std::string& list, std::size_t index, const std::string& name) {
  return fmt::format("{}[{}] (\"{}\")", list, index, name);
}

void warn(const TriangleMesh& mesh, const std::string& place, std::vector<std::string>& warnings) {
  for (const std::string& sentence : report_mesh(mesh).sentences())
    warnings.push_back(place + ": " + sentence);
}

TriangleMesh load_body(const std::filesystem::path& file, const LoadConfig& config,
                       const TriangleMesh& given = {}) {
  if (file.empty() && !config.groups.empty())
    throw std::invalid_argument("a mesh in the scene file has no groups to choose");
  if (file.empty()) return prepare_mesh(given, config, detail::inline_mesh);
  TriangleMesh mesh = load_mesh(file, config);
  validate(mesh, file.string());
  if (mesh.triangles.empty())
    throw std::invalid_argument(file.string() + ": has no triangles; a body is a surface");
  return mesh;
}

/// Asks only where the scene says nothing about the size of the mesh.
void ask_about_unit(const TriangleMesh& mesh, const LoadConfig& load, bool stated,
                    const std::string& place, std::vector<std::string>& warnings) {
  if (load.unit.value_or(1.0) != 1.0 || stated) return;
  Vec3 low = mesh.vertices.front(), high = low;
  for (const Vec3& x : mesh.vertices) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  if (const std::string question = selvedge::ask_about_unit(high - low); !question.empty())
    warnings.push_back(fmt::format("{}: {} (key \"unit\")", place, question));
}

/// Joins the vertices of a body that are near enough, and says so.
void weld(TriangleMesh& mesh, double distance, const std::string& place,
          std::vector<std::string>& warnings) {
  if (distance == 0.0) return;
  const WeldReport report = weld_vertices(mesh, distance);
  warnings.push_back(
      report.joined == 0
          ? fmt::format("{}: no two vertices are within {:g} m; none were joined (key \"weld\")",
                        place, distance)
          : fmt::format("{}: {} of {} vertices were joined with others at most {:.3g} m away, and "
                        "{} faces vanished (key \"weld\")",
                        place, report.joined, report.vertices, report.farthest, report.collapsed));
  if (mesh.triangles.empty())
    throw std::invalid_argument(fmt::format(
        "{}: \"weld\" joins the corners of every face; name a shorter distance", place));
}

/// Makes a body from a mesh. Keyframes rotate it about its own origin, which its transformation
/// places.
std::unique_ptr<Body> make_rigid_body(TriangleMesh mesh, const BodySpec& spec) {
  rotate(mesh.vertices, spec.placement.rotation);
  if (spec.motion.empty()) {
    translate(mesh.vertices, spec.placement.translation);
    return make_static_body(std::move(mesh));
  }
  std::vector<Keyframe> keys = spec.motion;
  for (Keyframe& key : keys) key.translation += spec.placement.translation;
  return make_keyframed_body(std::move(mesh), std::move(keys));
}

/// The first two files between which the vertices leap.
void warn_of_leaps(const BodySequence& sequence, const std::vector<TriangleMesh>& frames,
                   const std::string& place, std::vector<std::string>& warnings) {
  if (frames.empty()) return;
  const std::vector<Edge> edges = unique_edges(frames.front().triangles);
  for (std::size_t k = 1; k < frames.size(); ++k) {
    const std::string leap = vertex_leap(frames[k - 1].vertices, frames[k].vertices, edges);
    if (leap.empty()) continue;
    warnings.push_back(fmt::format("{}: from {} to {} {}", place, sequence.files[k - 1].string(),
                                   sequence.files[k].string(), leap));
    return;
  }
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
    rotate(mesh.vertices, placement.rotation);
    translate(mesh.vertices, placement.translation);
    frames.push_back(std::move(mesh));
  }
  warn_of_leaps(sequence, frames, place, warnings);
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
  weld(mesh, file.weld_distance, place, warnings);
  warn(mesh, place, warnings);
  ask_about_unit(mesh, file.load, states_axes(file.file), place, warnings);
  return make_rigid_body(std::move(mesh), spec);
}

void append(TriangleMesh& all, const TriangleMesh& mesh) {
  const auto first = static_cast<std::int32_t>(all.vertices.size());
  all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
  for (const Triangle& t : mesh.triangles)
    all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

void add_virtual_springs(const ClothSpec& spec, const Material& material, const ClothMesh& piece,
                         std::int32_t begin, BuiltScene& built) {
  const VirtualSpec& springs = spec.virtual_springs;
  if (springs.stiffness == 0.0) return;
  BuiltVirtualSprings made{begin, {}, springs.follow};
  for (const double mass : piece.mass)
    made.stiffness.push_back(springs.stiffness * mass / material.density);
  built.virtual_springs.push_back(std::move(made));
}

void add_volume(const ClothSpec& spec, const ClothMesh& piece, std::int32_t begin,
                BuiltScene& built) {
  const auto* mesh = std::get_if<ClothFile>(&spec.shape);
  if (mesh == nullptr || !mesh->support) return;
  const auto last = static_cast<std::int32_t>(piece.surface.vertices.size()) - 1;
  BuiltVolume volume{mesh->support->stiffness, begin + last, piece.surface.triangles};
  for (Triangle& t : volume.triangles)
    for (std::int32_t& v : t) v += begin;
  built.volumes.push_back(std::move(volume));
}

void add_cloth(const Scene& scene, const ContactPairs& pairs, std::size_t index,
               const PieceMaker& make, BuiltScene& built) {
  const ClothSpec& spec = scene.cloths[index];
  const Material& material = scene.materials.at(spec.material);
  const std::string place = at("geometry", index, spec.name);
  try {
    const Piece made = make(index);
    const auto& [piece, rest] = made;
    const auto number = static_cast<std::int32_t>(index);
    for (const auto& sentences :
         {detail::plate_warnings(spec, material), detail::shear_warnings(spec, material),
          detail::arc_warnings(spec, material, made)})
      for (const std::string& sentence : sentences)
        built.warnings.push_back(place + ": " + sentence);
    if (solid_of(spec) == nullptr)
      detail::warn_of_rest_gap(piece, pairs.rest_gap(number, number), place, built.warnings);
    const std::int32_t begin = append(built.cloth, piece);
    built.piece_begin.push_back(begin);
    append(built.rest, rest);
    built.velocity.resize(built.cloth.surface.vertices.size(), spec.velocity);
    add_virtual_springs(spec, material, piece, begin, built);
    add_volume(spec, piece, begin, built);
    if (const SolidSpec* solid = solid_of(spec))
      built.solids.push_back(detail::built_solid(index, begin, *solid, built.cloth));
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(
        fmt::format("{}, {}: {}", scene.file.string(), place, error.what()));
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

std::int32_t first_vertex(const Scene& scene, const BuiltScene& built, const std::string& name) {
  const auto piece = std::find_if(scene.cloths.begin(), scene.cloths.end(),
                                  [&](const ClothSpec& c) { return c.name == name; });
  if (piece == scene.cloths.end())
    throw std::invalid_argument("seam: no piece of cloth is called \"" + name + "\"");
  return built.piece_begin[static_cast<std::size_t>(piece - scene.cloths.begin())];
}

void add_seams(const Scene& scene, BuiltScene& built) {
  for (const SeamSpec& seam : scene.seams) {
    const std::int32_t a = first_vertex(scene, built, seam.geometry[0]),
                       b = first_vertex(scene, built, seam.geometry[1]);
    std::vector<Edge>& pairs = built.seams.emplace_back();
    for (std::size_t i = 0; i < std::min(seam.vertices[0].size(), seam.vertices[1].size()); ++i)
      pairs.push_back({a + seam.vertices[0][i], b + seam.vertices[1][i]});
  }
}

/// Adds independent numbers in [-speed, speed) to the coordinates of all velocities.
void perturb(const PerturbationSpec& perturbation, std::vector<Vec3>& velocity) {
  if (perturbation.speed == 0.0) return;
  // std::uniform_real_distribution differs from one standard library to another.
  std::mt19937_64 random(perturbation.seed);
  const auto draw = [&] { return 0x1p-63 * static_cast<double>(random()) - 1.0; };
  for (Vec3& v : velocity)
    for (int k = 0; k < 3; ++k) v[k] += perturbation.speed * draw();
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

std::vector<detail::SurfaceGrain> grains_of(const BuiltScene& built) {
  std::vector<detail::SurfaceGrain> grains;
  const TriangleMesh& cloth = built.cloth.surface;
  auto end = cloth.triangles.begin();
  for (std::size_t p = 0; p + 1 < built.piece_begin.size(); ++p) {
    const auto begin = end;
    const std::int32_t next = built.piece_begin[p + 1];
    end =
        std::find_if(begin, cloth.triangles.end(), [&](const Triangle& t) { return t[0] >= next; });
    const auto from = static_cast<std::size_t>(begin - cloth.triangles.begin());
    const auto count = static_cast<std::size_t>(end - begin);
    grains.push_back(
        detail::grain_of(cloth.vertices, std::span(cloth.triangles).subspan(from, count)));
  }
  for (const auto& body : built.bodies) {
    std::vector<Vec3> x(body->vertex_count());
    body->positions(0.0, x);
    grains.push_back(detail::grain_of(x, body->triangles()));
  }
  return grains;
}

/// The search of the cloth against itself finds what bodies with a mass touch.
void refuse_solids_apart(const Scene& scene) {
  if (scene.contact.self) return;
  for (const ClothSpec& cloth : scene.cloths)
    if (solid_of(cloth) != nullptr)
      throw std::invalid_argument(fmt::format(
          "{}, contact.self: is false, but body \"{}\" has a mass, and only this search finds what "
          "it touches; set contact.self to true",
          scene.file.string(), cloth.name));
}

// Of every piece with itself, with the pieces after it and with the bodies.
void refuse_rest_gaps(const Scene& scene, const ContactPairs& pairs, const BuiltScene& built) {
  const std::vector<detail::SurfaceGrain> grains = grains_of(built);
  for (std::size_t p = 0; p < scene.cloths.size(); ++p)
    for (std::size_t s = p; s < grains.size(); ++s) {
      const auto piece = static_cast<std::int32_t>(p), other = static_cast<std::int32_t>(s);
      const bool of_cloth = s < scene.cloths.size();
      if (!pairs.collide(piece, other) || (of_cloth && !scene.contact.self)) continue;
      try {
        detail::refuse_rest_gap(grains[p], grains[s], p == s, pairs.rest_gap(piece, other));
      } catch (const std::invalid_argument& error) {
        throw std::invalid_argument(fmt::format("{}, {}: {}", scene.file.string(),
                                                at("geometry", p, scene.cloths[p].name),
                                                error.what()));
      }
    }
}

bool tests_particles_alone(const Scene& scene, const Methods& methods) {
  const BroadPhaseRegistry& known = methods.broad_phases;
  return known.contains(scene.contact.broad_phase) &&
         known.at(scene.contact.broad_phase)(scene.contact.broad_phase_options)->traits().particles;
}

}  // namespace

BuiltScene build_scene(const Scene& scene, const PieceMaker& make) {
  detail::check_numbers(scene);
  refuse_solids_apart(scene);
  const ContactPairs pairs(scene);
  BuiltScene built;
  for (std::size_t i = 0; i < scene.cloths.size(); ++i) add_cloth(scene, pairs, i, make, built);
  built.piece_begin.push_back(static_cast<std::int32_t>(built.cloth.surface.vertices.size()));
  add_weights(scene, built);
  perturb(scene.perturbation, built.velocity);
  add_seams(scene, built);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) add_body(scene, i, built);
  refuse_rest_gaps(scene, pairs, built);
  return built;
}

BuiltScene build_scene(const Scene& scene, const Methods& methods) {
  BuiltScene built = build_scene(scene, [&](std::size_t i) {
    const ClothSpec& cloth = scene.cloths[i];
    return make_piece(cloth, scene.materials.at(cloth.material), methods.patterns);
  });
  if (tests_particles_alone(scene, methods)) detail::warn_between_particles(scene, built);
  for (std::string& sentence : detail::turn_warnings(scene))
    built.warnings.push_back(std::move(sentence));
  return built;
}

}  // namespace selvedge
