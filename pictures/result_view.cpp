// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/narrowphase/query_file.h>
#include <selvedge/pictures/detail/view_fields.h>
#include <selvedge/pictures/internal/result_view.h>
#include <selvedge/run/internal/replay.h>
#include <selvedge/run/result_folder.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// Frames that show the straight paths of the step of a failure bundle.
constexpr int kPathFrames = 21;

// Largest number of colliding pairs that a page holds.
constexpr std::size_t kMostPairs = 500;

/// null if there is no such JSON file.
Json json_of(const fs::path& file) {
  Json json = Json::parse(read_if_there(file), nullptr, false);
  return json.is_object() ? json : Json();
}

std::string string_of(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : "";
}

double fps_of(const Json& scene) {
  constexpr double by_default = 30.0;
  const auto time = scene.find("time");
  if (time == scene.end() || !time->is_object()) return by_default;
  const auto fps = time->find("fps");
  return fps != time->end() && fps->is_number() && fps->get<double>() > 0.0 ? fps->get<double>()
                                                                            : by_default;
}

std::string folder_name(const fs::path& folder) {
  const fs::path whole = fs::absolute(folder).lexically_normal();
  return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
}

fs::path frame_file(const fs::path& result, const char* stem, int number) {
  return numbered(result / "frames", stem, number, kFrameFileDigits, ".ply");
}

TriangleMesh read_valid(const fs::path& file, std::vector<NamedValues>* values = nullptr) {
  std::vector<NamedValues> ignored;
  TriangleMesh mesh = file.extension() == ".ply"
                          ? read_ply(file, values != nullptr ? *values : ignored)
                          : read_mesh(file);
  validate(mesh, file.string());
  return mesh;
}

/// Builds a view frame by frame.
class ViewBuilder {
 public:
  explicit ViewBuilder(ResultView& view) : view_(view) {}

  void add_frame(int number, double time, TriangleMesh cloth) {
    const int triangles = index_of(std::move(cloth.triangles));
    view_.frames.push_back({number, time, {std::move(cloth.vertices), triangles}, bodies_});
  }
  /// The bodies of this frame and all later ones.
  void set_bodies(TriangleMesh bodies) {
    const int triangles = index_of(std::move(bodies.triangles));
    view_.bodies.push_back({std::move(bodies.vertices), triangles});
    bodies_ = static_cast<int>(view_.bodies.size()) - 1;
  }

 private:
  /// Index of these triangles, which most frames share.
  int index_of(std::vector<Triangle> triangles) {
    for (std::size_t i = view_.triangles.size(); i-- > 0;)
      if (view_.triangles[i] == triangles) return static_cast<int>(i);
    view_.triangles.push_back(std::move(triangles));
    return static_cast<int>(view_.triangles.size()) - 1;
  }

  ResultView& view_;
  int bodies_ = -1;
};

// -- a result folder ------------------------------------------------------------------------------

std::unique_ptr<detail::SceneOfView> build_scene_of(const fs::path& result,
                                                    const ViewConfig& config, ResultView& view) {
  const fs::path file = result / "scene.json";
  if (!fs::exists(file)) return nullptr;
  try {
    Scene scene = read_scene(file, {}, config.methods);
    BuiltScene built = build_scene(scene, config.methods);
    return std::make_unique<detail::SceneOfView>(
        detail::SceneOfView{std::move(scene), std::move(built)});
  } catch (const std::invalid_argument& error) {
    view.notes.push_back(std::string("No strains, because the scene cannot be built: ") +
                         error.what());
    return nullptr;
  }
}

void note_end(const fs::path& result, ResultView& view) {
  const std::string stopped = string_of(json_of(result / "result.json"), "stopped");
  if (!stopped.empty()) view.notes.push_back("This run stopped: " + stopped);
  if (fs::exists(result / "failure" / "failure.json"))
    view.notes.push_back("selvedge view " + shell_quoted((result / "failure").string()) +
                         " shows the step at which it stopped.");
}

void check_frames(const std::vector<int>& chosen, const std::vector<int>& all,
                  const fs::path& result) {
  for (const int number : chosen)
    if (!std::binary_search(all.begin(), all.end(), number))
      throw std::invalid_argument(fmt::format("{}: has no frame {}; the frames are {} to {}",
                                              result.string(), number, all.front(), all.back()));
}

void name_pieces(const detail::SceneOfView& scene, ResultView& view) {
  const std::size_t vertices = scene.built.cloth.surface.vertices.size();
  if (std::ranges::any_of(view.frames,
                          [&](const ViewFrame& f) { return f.cloth.x.size() != vertices; }))
    return;
  for (std::size_t p = 0; p < scene.scene.cloths.size(); ++p) {
    const std::string& name = scene.scene.cloths[p].name;
    view.pieces.emplace_back(static_cast<std::size_t>(scene.built.piece_begin[p]),
                             name.empty() ? fmt::format("cloth {}", p) : name);
  }
}

void read_frames(const fs::path& result, const ViewConfig& config, ResultView& view) {
  const std::vector<int> all = view_frames(result);
  check_frames(config.frames, all, result);
  const std::vector<int>& chosen = config.frames.empty() ? all : config.frames;
  const auto scene = build_scene_of(result, config, view);
  const std::vector<int> body_frames = numbers_of(result / "frames", "bodies");
  detail::FieldMaker fields(scene.get(), config.shortfall);
  ViewBuilder builder(view);
  TriangleMesh bodies;
  int bodies_read = -1;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (config.progress) config.progress(i);
    const int number = chosen[i];
    const auto after = std::upper_bound(body_frames.begin(), body_frames.end(), number);
    if (after != body_frames.begin() && *std::prev(after) != bodies_read) {
      bodies_read = *std::prev(after);
      bodies = read_valid(frame_file(result, "bodies", bodies_read));
      builder.set_bodies(bodies);
    }
    std::vector<NamedValues> values;
    TriangleMesh cloth = read_valid(frame_file(result, "cloth", number), &values);
    fields.add(cloth, values, bodies_read >= 0 ? &bodies : nullptr);
    builder.add_frame(number, number / view.fps, std::move(cloth));
  }
  view.fields = fields.fields();
  if (scene) name_pieces(*scene, view);
  note_end(result, view);
}

// -- a failure bundle -----------------------------------------------------------------------------

bool is_bundle(const fs::path& result) { return fs::exists(result / "failure.json"); }

void read_pairs(const fs::path& bundle, ResultView& view) {
  std::size_t left_out = 0;
  for (const ContactKind kind : {ContactKind::point_triangle, ContactKind::edge_edge}) {
    const fs::path file = bundle / "queries" / (std::string(query_kind_name(kind)) + ".csv");
    if (!fs::exists(file)) continue;
    const QuerySet set = read_queries(file, kind);
    for (std::size_t i = 0; i < set.queries.size(); ++i) {
      if (set.truth[i] == 0) continue;
      if (view.pairs.size() == kMostPairs) {
        ++left_out;
        continue;
      }
      const Query& q = set.queries[i];
      view.pairs.push_back(
          {kind == ContactKind::edge_edge, set.toi.empty() ? 0.0 : set.toi[i].lo, q.x_t0, q.x_t1});
    }
  }
  if (left_out > 0)
    view.notes.push_back(
        fmt::format("{} more pairs collide, which this page leaves out.", left_out));
}

TriangleMesh between(const TriangleMesh& a, const TriangleMesh& b, double t) {
  TriangleMesh mesh = a;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    mesh.vertices[i] = (1.0 - t) * a.vertices[i] + t * b.vertices[i];
  return mesh;
}

/// The surface at the start and the end of the attempt; empty where the bundle has none.
std::vector<TriangleMesh> ends_of(const fs::path& bundle, const char* stem) {
  std::vector<TriangleMesh> ends;
  for (const int number : {0, 1}) {
    const fs::path file = frame_file(bundle, stem, number);
    if (fs::exists(file)) ends.push_back(read_valid(file));
  }
  if (ends.size() != 2 || ends[0].vertices.size() != ends[1].vertices.size()) ends.clear();
  return ends;
}

void read_bundle(const fs::path& bundle, ResultView& view) {
  const FailureBundle failure = read_failure_bundle(bundle);
  view.notes.push_back("This run stopped: " + failure.cause);
  const std::vector<TriangleMesh> cloth = ends_of(bundle, "cloth"),
                                  bodies = ends_of(bundle, "bodies");
  ViewBuilder builder(view);
  if (cloth.empty()) {
    view.notes.push_back("The failure has no colliding pairs; this is the last good state.");
    builder.add_frame(0, 0.0, read_valid(bundle / "state.ply"));
    return;
  }
  view.notes.push_back(
      "These are the colliding triangles of the last attempt at the step and the triangles around "
      "them. Time runs from 0 at the start of the attempt to 1 at its end.");
  view.fps = kPathFrames - 1;
  for (int i = 0; i < kPathFrames; ++i) {
    const double t = i / (kPathFrames - 1.0);
    if (!bodies.empty()) builder.set_bodies(between(bodies[0], bodies[1], t));
    builder.add_frame(i, t, between(cloth[0], cloth[1], t));
  }
  read_pairs(bundle, view);
}

// -- distances ------------------------------------------------------------------------------------

void keep_common(ResultView& view, const ResultView& other) {
  const auto common = [&](int number) {
    return std::any_of(other.frames.begin(), other.frames.end(),
                       [&](const ViewFrame& frame) { return frame.number == number; });
  };
  for (std::size_t i = view.frames.size(); i-- > 0;) {
    if (common(view.frames[i].number)) continue;
    const auto at = static_cast<std::ptrdiff_t>(i);
    view.frames.erase(view.frames.begin() + at);
    for (ViewField& field : view.fields) field.frames.erase(field.frames.begin() + at);
  }
}

/// Distances in millimetres; nullopt where the vertices do not correspond.
std::optional<std::vector<std::vector<float>>> distances(const ResultView& a, const ResultView& b) {
  constexpr double millimetres = 1000.0;
  std::vector<std::vector<float>> list;
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    const auto &x = a.frames[i].cloth.x, &y = b.frames[i].cloth.x;
    if (x.size() != y.size()) return std::nullopt;
    std::vector<float>& frame = list.emplace_back();
    for (std::size_t v = 0; v < x.size(); ++v)
      frame.push_back(static_cast<float>(millimetres * (x[v] - y[v]).norm()));
  }
  return list;
}

}  // namespace

std::vector<int> view_frames(const std::filesystem::path& result) {
  std::error_code error;
  const auto status = fs::status(result, error);
  if (!fs::exists(status))
    throw std::invalid_argument(result.string() + ": no such result folder or mesh file");
  if (!fs::is_directory(status)) return {0};
  if (is_bundle(result)) {
    std::vector<int> numbers;
    for (int i = 0; i < kPathFrames; ++i) numbers.push_back(i);
    return numbers;
  }
  std::vector<int> numbers = numbers_of(result / "frames", "cloth");
  if (numbers.empty())
    throw std::invalid_argument(result.string() +
                                ": holds no frames/cloth_*.ply; is it the folder of a run?");
  return numbers;
}

ResultView read_view(const std::filesystem::path& result, const ViewConfig& config) {
  view_frames(result);
  ResultView view;
  if (!fs::is_directory(result)) {
    view.name = result.filename().string();
    ViewBuilder(view).add_frame(0, 0.0, read_valid(result));
    return view;
  }
  const Json scene = json_of(result / "scene.json");
  view.fps = fps_of(scene);
  view.name = string_of(scene, "name");
  if (view.name.empty()) view.name = folder_name(result);
  if (is_bundle(result))
    read_bundle(result, view);
  else
    read_frames(result, config, view);
  return view;
}

void add_distance(ResultView& a, ResultView& b) {
  keep_common(a, b);
  keep_common(b, a);
  if (a.frames.empty()) throw std::invalid_argument("the two results have no frame in common");
  const auto values = distances(a, b);
  if (!values) {
    a.notes.push_back("No distances: the two results have different numbers of vertices.");
    return;
  }
  const double full = detail::quantile_of(*values, 1.0);
  if (full == 0.0) {
    a.notes.push_back("The two results have the same positions in every frame.");
    return;
  }
  const ViewField field =
      detail::make_field({.name = "distance",
                          .meaning = "distance of a vertex from the same vertex of the other run",
                          .unit = "mm",
                          .scale = ViewScale::sequential,
                          .full = full},
                         *values);
  for (ResultView* view : {&a, &b}) view->fields.insert(view->fields.begin(), field);
}

}  // namespace selvedge
