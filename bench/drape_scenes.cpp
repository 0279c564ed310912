// SPDX-License-Identifier: MIT
#include "drape_scenes.h"

#include <selvedge/data/makers/mannequin.h>
#include "garments.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace selvedge::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kBallRadius = 0.25;   // m
constexpr int kBallResolution = 64;    // segments
constexpr double kHeightAbove = 0.02;  // m, of the sheet above the highest point of the body
constexpr double kFriction = 0.3;
/// Within it the pull of a seam is constant, m: more than the panels are apart.
constexpr double kSeamReach = 0.3;
constexpr double kDensity = 0.2;  // kg/m²

json vector_of(const Vec3& x) { return {x.x(), x.y(), x.z()}; }

/// OBJ with the flat pattern as texture coordinates.
void write_garment_obj(const fs::path& file, const GarmentPiece& piece) {
  std::ofstream out(file);
  for (const Vec3& x : piece.surface.vertices)
    out << fmt::format("v {:.17g} {:.17g} {:.17g}\n", x.x(), x.y(), x.z());
  for (const Vec3& x : piece.pattern.vertices)
    out << fmt::format("vt {:.17g} {:.17g}\n", x.x(), x.y());
  for (std::size_t i = 0; i < piece.surface.triangles.size(); ++i) {
    const Triangle &s = piece.surface.triangles[i], &p = piece.pattern.triangles[i];
    out << fmt::format("f {}/{} {}/{} {}/{}\n", s[0] + 1, p[0] + 1, s[1] + 1, p[1] + 1, s[2] + 1,
                       p[2] + 1);
  }
  if (!out.flush()) throw std::runtime_error(file.string() + " could not be written");
}

json piece_json(const fs::path& folder, const GarmentPiece& piece) {
  const std::string file = piece.name + ".obj";
  json out = {{"name", piece.name}, {"mesh", file}};
  if (piece.pattern.triangles.empty()) {
    write_obj(folder / file, piece.surface.vertices, piece.surface.triangles);
  } else {
    write_garment_obj(folder / file, piece);
    out["rest_mesh"] = "texture";
  }
  return out;
}

json side_json(const std::string& piece, const std::vector<std::int32_t>& row) {
  return {{"geometry", piece}, {"select", row}};
}

TriangleMesh mannequin_mesh(bool arms_level) {
  if (!arms_level) return read_mesh(SELVEDGE_SOURCE_DIR "/data/bodies/mannequin.ply");
  constexpr LimbPose level{.shoulder_out = 1.5};
  return make_mannequin({.left = level, .right = level});
}

json body_json(const fs::path& folder, TriangleMesh mesh, int subdivisions) {
  for (int i = 0; i < subdivisions; ++i) mesh = subdivided(mesh);
  write_ply(folder / "body.ply", mesh.vertices, mesh.triangles);
  return {{"name", "body"}, {"mesh", "body.ply"}, {"friction", kFriction}};
}

void add_garment(const fs::path& folder, const Garment& garment, int subdivisions, json& scene) {
  for (const GarmentPiece& piece : garment.pieces)
    scene["geometry"].push_back(piece_json(folder, piece));
  for (const GarmentSeam& seam : garment.seams) {
    scene["seams"].push_back(
        {{"sides", json::array({side_json(seam.piece_a, seam.a), side_json(seam.piece_b, seam.b)})},
         {"tolerance", kSeamReach},
         {"pull", garment.pull / kSeamReach}});
  }
  if (!garment.held.empty()) scene["handles"].push_back({{"select", garment.held}});
  scene["obstacles"].push_back(body_json(folder, mannequin_mesh(garment.arms_level), subdivisions));
}

void add_sheet(const fs::path& folder, const DrapeScene& config, int side, json& scene) {
  Vec3 top(0.0, 0.0, kBallRadius);
  if (config.body == "ball") {
    scene["obstacles"].push_back(
        {{"name", "ball"},
         {"shape", {{"type", "sphere"}, {"radius", kBallRadius}, {"resolution", kBallResolution}}},
         {"friction", kFriction}});
  } else {
    TriangleMesh mesh =
        config.body == "mannequin" ? mannequin_mesh(false) : load_mesh(config.body, config.load);
    top = *std::max_element(mesh.vertices.begin(), mesh.vertices.end(),
                            [](const Vec3& a, const Vec3& b) { return a.z() < b.z(); });
    scene["obstacles"].push_back(body_json(folder, std::move(mesh), config.subdivisions));
  }
  top.z() += kHeightAbove;
  scene["geometry"].push_back({{"name", "sheet"},
                               {"size", {1.0, 1.0}},
                               {"cells", {side - 1, side - 1}},
                               {"transformation", {{"translation", vector_of(top)}}}});
}

}  // namespace

std::string DrapeScene::name() const {
  return !garment.empty() ? garment : fs::path(body).stem().string();
}

TriangleMesh subdivided(const TriangleMesh& mesh) {
  TriangleMesh out{mesh.vertices, {}};
  std::map<Edge, std::int32_t> middles;
  const auto middle = [&](std::int32_t a, std::int32_t b) {
    const auto [known, is_new] = middles.try_emplace(
        {std::min(a, b), std::max(a, b)}, static_cast<std::int32_t>(out.vertices.size()));
    if (is_new) out.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
    return known->second;
  };
  out.triangles.reserve(4 * mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const Triangle& t : {Triangle{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
      out.triangles.push_back(t);
  }
  return out;
}

fs::path write_drape_scene(const fs::path& folder, const DrapeScene& config, int side) {
  fs::create_directories(folder);
  json scene = {{"name", config.name()},
                {"materials", {{"default", {{"density", kDensity}}}}},
                {"time", {{"frames", config.frames}, {"fps", 60}}}};
  if (config.garment.empty()) {
    add_sheet(folder, config, side, scene);
  } else {
    add_garment(folder, make_garment(config.garment, side), config.subdivisions, scene);
  }
  const fs::path file = folder / "scene.json";
  std::ofstream out(file);
  out << scene.dump(1) << "\n";
  if (!out.flush()) throw std::runtime_error(file.string() + " could not be written");
  return file;
}

}  // namespace selvedge::bench
