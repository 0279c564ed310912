// SPDX-License-Identifier: MIT
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/internal/json_value.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/pictures/picture_files.h>
#include <selvedge/pictures/result_pictures.h>
#include <selvedge/run/internal/part_colours.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/scene/scene.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace selvedge {
namespace {

constexpr int kThumbnail = 240;  // pixels

namespace fs = std::filesystem;
using Json = nlohmann::json;

// ---- parts of a mesh -----------------------------------------------------------------------

/// Directed edges with a triangle on one side only.
std::vector<Edge> open_edges(std::span<const Triangle> triangles) {
  struct Side {
    Edge sorted, directed;
    bool operator<(const Side& other) const { return sorted < other.sorted; }
  };
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Edge e = {t[k], t[(k + 1) % 3]};
      sides.push_back({{std::min(e[0], e[1]), std::max(e[0], e[1])}, e});
    }
  std::stable_sort(sides.begin(), sides.end());
  std::vector<Edge> open;
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].sorted == sides[i].sorted) ++end;
    if (end == i + 1) open.push_back(sides[i].directed);
    i = end;
  }
  return open;
}

struct Bounds {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  void add(const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  void add(const Bounds& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  double diagonal() const { return low.x() <= high.x() ? (high - low).norm() : 0.0; }
};

Bounds bounds_of(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  Bounds bounds;
  for (const Triangle& t : triangles)
    for (const std::int32_t v : t) bounds.add(x[static_cast<std::size_t>(v)]);
  return bounds;
}

/// Sum of the area vectors and of the areas, both doubled.
std::pair<Vec3, double> area_of(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  Vec3 vector = Vec3::Zero();
  double sum = 0.0;
  for (const Triangle& t : triangles) {
    const auto corner = [&](std::size_t i) { return x[static_cast<std::size_t>(t[i])]; };
    const Vec3 area = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    vector += area;
    sum += area.norm();
  }
  return {vector, sum};
}

/// A part is flat if the sum of its area vectors is shorter than its area by less than this share.
constexpr double kFlatness = 1e-4;

bool is_flat(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  const auto [vector, sum] = area_of(x, triangles);
  return sum > 0.0 && vector.norm() >= (1.0 - kFlatness) * sum;
}

/// Writes the in-plane coordinates of each vertex of a flat part. The origin is the first vertex of
/// the first open edge, and the first axis runs along that edge.
void flatten(std::span<const Vec3> x, std::span<const Triangle> part,
             std::vector<Eigen::Vector2d>& material) {
  const Vec3 normal = area_of(x, part).first.normalized();
  const auto open = open_edges(part);
  Vec3 along = normal.unitOrthogonal();
  Vec3 origin = x[static_cast<std::size_t>(part.front()[0])];
  if (!open.empty()) {
    origin = x[static_cast<std::size_t>(open.front()[0])];
    const Vec3 edge = x[static_cast<std::size_t>(open.front()[1])] - origin;
    const Vec3 in_plane = edge - edge.dot(normal) * normal;
    if (in_plane.norm() > 0.0) along = in_plane.normalized();
  }
  const Vec3 across = normal.cross(along);
  for (const Triangle& t : part)
    for (const std::int32_t v : t) {
      const Vec3 d = x[static_cast<std::size_t>(v)] - origin;
      material[static_cast<std::size_t>(v)] = {d.dot(along), d.dot(across)};
    }
}

// ---- looks ---------------------------------------------------------------------------------

constexpr double kClothSheen = 0.5;

RenderSurface cloth_surface(std::size_t piece) {
  const Dye& dye = piece_dye(piece);
  RenderSurface surface;
  surface.front = dye.front;
  surface.back = dye.back;
  surface.sheen = kClothSheen;
  return surface;
}

RenderSurface body_surface() {
  RenderSurface surface;
  surface.front = surface.back = body_colour();
  surface.crease = kBodyCrease;
  return surface;
}

/// About a twentieth of the cloth, rounded to 1, 2 or 5 times a power of ten.
double round_spacing(double cloth_size) {
  constexpr double lines = 20.0;
  if (!(cloth_size > 0.0)) return 0.0;
  const double wanted = cloth_size / lines;
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  for (const double step : {1.0, 2.0, 5.0})
    if (wanted <= step * decade * std::sqrt(2.0)) return step * decade;
  return 10.0 * decade;
}

// ---- files ---------------------------------------------------------------------------------

TriangleMesh read_checked(const fs::path& file) {
  TriangleMesh mesh = read_mesh(file);
  validate(mesh, file.string());
  return mesh;
}

[[noreturn]] void refuse(const fs::path& file, const std::string& fault) {
  throw std::invalid_argument(file.string() + ": " + fault);
}

const Json* member(const Json* object, const char* key) {
  if (object == nullptr || !object->is_object()) return nullptr;
  const auto it = object->find(key);
  return it == object->end() ? nullptr : &*it;
}

void take(const Json* value, std::optional<double>& out) {
  if (value != nullptr && value->is_number()) out = value->get<double>();
}

void take(const Json* value, std::optional<Vec3>& out) {
  if (value == nullptr || !value->is_array() || value->size() != 3) return;
  Vec3 point;
  for (int i = 0; i < 3; ++i) {
    const Json& coordinate = (*value)[static_cast<std::size_t>(i)];
    if (!coordinate.is_number()) return;
    point[i] = coordinate.get<double>();
  }
  out = point;
}

}  // namespace

std::vector<std::vector<Triangle>> connected_parts(std::size_t vertices,
                                                   std::span<const Triangle> triangles) {
  std::vector<std::int32_t> root(vertices);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](std::int32_t v) {
    while (root[static_cast<std::size_t>(v)] != v) {
      auto& parent = root[static_cast<std::size_t>(v)];
      parent = root[static_cast<std::size_t>(parent)];
      v = parent;
    }
    return v;
  };
  for (const Triangle& t : triangles)
    for (std::size_t k = 1; k < 3; ++k) {
      const std::int32_t a = find(t[0]), b = find(t[k]);
      root[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  // The root of a part is its lowest vertex.
  std::vector<std::size_t> count(vertices, 0);
  for (const Triangle& t : triangles) ++count[static_cast<std::size_t>(find(t[0]))];
  std::vector<std::size_t> part_of_root(vertices, 0);
  std::vector<std::vector<Triangle>> parts;
  for (std::size_t v = 0; v < vertices; ++v) {
    if (count[v] == 0) continue;
    part_of_root[v] = parts.size();
    parts.emplace_back().reserve(count[v]);
  }
  for (const Triangle& t : triangles)
    parts[part_of_root[static_cast<std::size_t>(find(t[0]))]].push_back(t);
  return parts;
}

ResultPictures::ResultPictures(fs::path result)
    : result_(std::move(result)),
      backdrop_size_(std::numeric_limits<double>::infinity()),
      ground_z_(std::numeric_limits<double>::quiet_NaN()) {
  std::error_code error;
  const auto status = fs::status(result_, error);
  if (!fs::exists(status)) refuse(result_, "no such result folder or mesh file");
  is_folder_ = fs::is_directory(status);
  if (is_folder_)
    prepare_folder();
  else
    frames_ = {0};
}

void ResultPictures::prepare_folder() {
  const fs::path folder = result_ / "frames";
  frames_ = numbers_of(folder, "cloth");
  body_frames_ = numbers_of(folder, "bodies");
  if (frames_.empty())
    refuse(result_, "holds no frames/cloth_*.ply; is it the folder of a finished run?");
  read_scene_file();

  const TriangleMesh first = cloth(frames_.front());
  const Bounds start = bounds_of(first.vertices, first.triangles);
  grid_ = round_spacing(start.diagonal());
  constexpr double backdrop_over_cloth = 3.0;
  backdrop_size_ = backdrop_over_cloth * start.diagonal();
  const auto parts = connected_parts(first.vertices.size(), first.triangles);
  if (std::all_of(parts.begin(), parts.end(),
                  [&](const auto& part) { return is_flat(first.vertices, part); })) {
    material_.assign(first.vertices.size(), Eigen::Vector2d::Zero());
    for (const auto& part : parts) flatten(first.vertices, part, material_);
  }

  // The ground is the level floor of the scene, else the lowest point of cloth and bodies in the
  // first and last frame.
  const TriangleMesh last = cloth(frames_.back());
  const TriangleMesh& body = bodies(frames_.back());
  Bounds all = start;
  all.add(bounds_of(last.vertices, last.triangles));
  double floor = std::numeric_limits<double>::quiet_NaN();
  for (const auto& part : connected_parts(body.vertices.size(), body.triangles)) {
    const Bounds part_bounds = bounds_of(body.vertices, part);
    if (part_bounds.diagonal() <= backdrop_size_)
      all.add(part_bounds);
    else if (part_bounds.low.z() == part_bounds.high.z())
      floor = part_bounds.low.z();
  }
  ground_z_ = std::isfinite(floor) ? floor : all.low.z();
}

/// scene.json, and camera and time in it, are optional; a damaged scene.json is refused.
void ResultPictures::read_scene_file() {
  const fs::path file = result_ / "scene.json";
  const std::string text = read_if_there(file);
  if (text.empty()) return;
  Json scene;
  try {
    scene = Json::parse(text, nullptr, true, true);
  } catch (const Json::exception& error) {
    refuse(file, "is not JSON: " + json_message(error.what()));
  }
  const Json* camera = member(member(&scene, "output"), "camera");
  take(member(camera, "eye"), scene_camera_.eye);
  take(member(camera, "target"), scene_camera_.target);
  take(member(camera, "field_of_view"), scene_camera_.field_of_view);
  // The place that a scene has by default is a direction of view alone.
  const CameraSpec by_default;
  if (scene_camera_.eye == by_default.eye && scene_camera_.target == by_default.target)
    scene_camera_.eye = scene_camera_.target = std::nullopt;
  std::optional<double> fps;
  take(member(member(&scene, "time"), "fps"), fps);
  if (fps && *fps > 0.0) fps_ = *fps;
}

TriangleMesh ResultPictures::cloth(int frame) const {
  if (!is_folder_) return read_checked(result_);
  if (!std::binary_search(frames_.begin(), frames_.end(), frame))
    refuse(result_, "has no frame " + std::to_string(frame) + "; its frames are " +
                        std::to_string(frames_.front()) + " to " + std::to_string(frames_.back()));
  return read_checked(numbered(result_ / "frames", "cloth", frame, kFrameFileDigits, ".ply"));
}

/// The bodies of the frame, or of the last earlier frame that has a file of bodies.
const TriangleMesh& ResultPictures::bodies(int frame) {
  const auto after = std::upper_bound(body_frames_.begin(), body_frames_.end(), frame);
  if (after == body_frames_.begin()) return bodies_;
  const int number = *std::prev(after);
  if (number != bodies_read_)
    bodies_ =
        read_checked(numbered(result_ / "frames", "bodies", number, kFrameFileDigits, ".ply"));
  bodies_read_ = number;
  return bodies_;
}

Camera ResultPictures::camera(const CameraChoice& choice, std::span<const int> shown) {
  Camera camera;
  camera.width = choice.width.value_or(camera.width);
  camera.height = choice.height.value_or(camera.height);
  camera.field_of_view =
      choice.field_of_view.value_or(scene_camera_.field_of_view.value_or(camera.field_of_view));
  const auto eye = choice.eye ? choice.eye : scene_camera_.eye;
  const auto target = choice.target ? choice.target : scene_camera_.target;
  Bounds seen;
  std::vector<Vec3> points;
  const auto see = [&](const std::vector<Vec3>& x, const std::vector<Triangle>& triangles) {
    seen.add(bounds_of(x, triangles));
    for (const Triangle& t : triangles)
      for (const std::int32_t v : t) points.push_back(x[static_cast<std::size_t>(v)]);
  };
  if (!eye || !target)
    for (const int frame : shown) {
      const TriangleMesh mesh = cloth(frame);
      see(mesh.vertices, mesh.triangles);
      const TriangleMesh& body = bodies(frame);
      for (const auto& part : connected_parts(body.vertices.size(), body.triangles))
        if (bounds_of(body.vertices, part).diagonal() <= backdrop_size_) see(body.vertices, part);
    }
  if (!(seen.low.x() <= seen.high.x())) seen.low = seen.high = Vec3::Zero();
  if (!eye && !target) return framed(camera, points);
  const Vec3 direction = camera.eye - camera.target;
  const double distance = std::max(2.0 * seen.diagonal(), 1e-3);
  camera.target = target.value_or(0.5 * (seen.low + seen.high));
  camera.eye = eye.value_or(camera.target + distance * direction.normalized());
  return camera;
}

/// Joins parts with the same look, so that a body of many parts is drawn at once.
void ResultPictures::add_parts(const TriangleMesh& mesh, bool is_body,
                               std::vector<Look>& looks) const {
  std::size_t cloths = 0;
  for (auto& part : connected_parts(mesh.vertices.size(), mesh.triangles)) {
    const bool closed = !is_folder_ && open_edges(part).empty();
    Look look;
    look.surface = is_body || closed ? body_surface() : cloth_surface(cloths++);
    look.surface.x = mesh.vertices;
    if (!is_body && grid_ > 0.0 && material_.size() == mesh.vertices.size()) {
      look.surface.material = material_;
      look.surface.grid = grid_;
    }
    if (is_body) {
      const Bounds bounds = bounds_of(mesh.vertices, part);
      look.surface.backdrop = bounds.diagonal() > backdrop_size_;
      // The ground of the picture replaces a level floor.
      if (look.surface.backdrop && bounds.low.z() == bounds.high.z()) continue;
    }
    const auto alike = std::find_if(looks.begin(), looks.end(), [&](const Look& other) {
      return other.surface.x.data() == look.surface.x.data() &&
             other.surface.front == look.surface.front &&
             other.surface.backdrop == look.surface.backdrop;
    });
    if (alike == looks.end())
      looks.push_back({look.surface, std::move(part)});
    else
      alike->triangles.insert(alike->triangles.end(), part.begin(), part.end());
  }
}

Image ResultPictures::picture(int frame, const Camera& camera) {
  const TriangleMesh mesh = cloth(frame);
  const TriangleMesh& body = bodies(frame);
  std::vector<Look> looks;
  add_parts(mesh, false, looks);
  add_parts(body, true, looks);
  std::vector<RenderSurface> surfaces;
  for (const Look& look : looks) {
    surfaces.push_back(look.surface);
    surfaces.back().triangles = look.triangles;
  }
  RenderConfig config;
  config.ground_z = ground_z_;
  if (camera.width <= kThumbnail) {  // too small to show soft shadows
    config.sky_directions = 12;
    config.shadow_resolution = 256;
  }
  return render(camera, surfaces, config);
}

void render_result_frame(const fs::path& result, int frame, const CameraChoice& choice,
                         const fs::path& picture) {
  ResultPictures pictures(result);
  const Camera camera = pictures.camera(choice, std::array{frame});
  if (picture.has_parent_path()) fs::create_directories(picture.parent_path());
  write_png(picture, pictures.picture(frame, camera));
}

}  // namespace selvedge
