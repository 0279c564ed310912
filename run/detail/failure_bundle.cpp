// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/run/detail/checkpoint.h>
#include <selvedge/run/detail/failure_bundle.h>
#include <selvedge/run/detail/offenders.h>
#include <selvedge/run/detail/run_folder.h>
#include <selvedge/simulation/step_report.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <system_error>

namespace selvedge {
namespace detail {
namespace {

namespace fs = std::filesystem;

// Format 1 has "what" for "kind" and "tried_s" for "attempts_s".
constexpr int kFormat = 2;

// The meshes of the scene are copied into the bundle unless they are larger than this together;
// then scene.json keeps their absolute paths.
constexpr std::uintmax_t kCarriedBytes = 64'000'000;

// Largest number of pairs in failure.json; queries/ has all of them.
constexpr std::size_t kListedPairs = 1000;

std::string bodies_hash(const Simulation& simulation) {
  SimulationState bodies;
  bodies.x = simulation.body_positions();
  return state_hash(bodies);
}

// -- the scene with its meshes --------------------------------------------------------------------

/// Whether files of this format refer to no other files.
bool is_self_contained(const fs::path& file) {
  const std::string extension = file.extension().string();
  for (const char* known : {".ply", ".obj", ".off", ".stl"})
    if (extension == known) return true;
  return false;
}

fs::path copy_name(std::size_t number, const fs::path& file) {
  return fs::path("meshes") / fmt::format("{:05}{}", number, file.extension().string());
}

bool is_copy(const fs::path& file) {
  const std::string stem = file.stem().string();
  return is_self_contained(file) && stem.size() >= 5 &&
         std::all_of(stem.begin(), stem.end(), [](char c) { return c >= '0' && c <= '9'; });
}

/// All strings of a scene that name mesh files.
std::vector<Json*> file_names(Json& scene) {
  std::vector<Json*> places;
  const auto note = [&](Json& object, const char* key) {
    if (const auto at = object.find(key);
        at != object.end() && at->is_string() && *at != "" && *at != "texture")
      places.push_back(&*at);
  };
  for (const char* list : {"geometry", "obstacles"}) {
    if (!scene.contains(list)) continue;
    for (Json& entry : scene[list]) {
      note(entry, "mesh");
      note(entry, "rest_mesh");
      if (entry.contains("sequence"))
        for (Json& file : entry["sequence"]["files"]) places.push_back(&file);
    }
  }
  return places;
}

/// Copies the meshes of the scene into the bundle and replaces their names by those of the copies.
void carry_meshes(Json& scene, const fs::path& folder) {
  const std::vector<Json*> places = file_names(scene);
  std::uintmax_t bytes = 0;
  std::error_code error;
  for (const Json* place : places) bytes += fs::file_size(place->get<std::string>(), error);
  if (places.empty() || error || bytes > kCarriedBytes) return;
  make_folder(folder / "meshes");
  for (std::size_t i = 0; i < places.size(); ++i) {
    const fs::path file = places[i]->get<std::string>();
    if (!is_self_contained(file)) continue;
    const fs::path name = copy_name(i, file);
    fs::copy_file(file, folder / name, fs::copy_options::overwrite_existing, error);
    if (!error) *places[i] = name.string();
  }
}

void write_bundled_scene(const fs::path& folder, const Scene& scene) {
  Json json = scene.json.empty() ? Json{{"name", scene.name}} : Json::parse(scene.json);
  if (json.contains("output")) json["output"].erase("camera");  // pictures show the colliding parts
  carry_meshes(json, folder);
  write_text(folder / "scene.json", json.dump(2) + "\n");
}

// -- failure.json ---------------------------------------------------------------------------------

const char* kind_name(ContactKind kind) {
  return kind == ContactKind::edge_edge ? "edge_edge" : "point_triangle";
}

Json listed_pairs(const RejectedAttempt& failed, const VertexNames& names) {
  Json list = Json::array();
  for (const ContactPoint& c : failed.pairs) {
    if (list.size() == kListedPairs) break;
    list.push_back({{"kind", kind_name(c.kind)},
                    {"pair", names.pair(c)},
                    {"vertices", c.vertex},
                    {"gap_m", c.gap},
                    {"rest_gap_m", c.rest_gap}});
  }
  return list;
}

Json failure_json(const Scene& scene, const Simulation& simulation,
                  const SimulationFailed& failure) {
  const SimulationState& state = simulation.state();
  const RejectedAttempt& failed = simulation.last_step().rejected;
  Json json = {{"format", kFormat},
               {"kind", failure_name(failure.kind)},
               {"cause", failure.what()},
               {"scene_from_file", !scene.json.empty()},
               {"state_hash", state_hash(state)},
               {"bodies_hash", bodies_hash(simulation)},
               {"particles", state.x.size()},
               {"attempts_s", simulation.last_step().lengths},
               {"colliding_pairs", failed.pairs.size()},
               {"pairs", listed_pairs(failed, simulation.names())}};
  write_state_fields(state, json);
  if (failed.not_finite >= 0) json["not_finite"] = simulation.names().vertex(failed.not_finite);
  return json;
}

[[noreturn]] void refuse(const fs::path& file, const std::string& fault) {
  throw std::invalid_argument(
      fmt::format("{}: {}; give the folder failure/ of a run that stopped, or run the scene again",
                  file.string(), fault));
}

FailureKind kind_from(const Value& json, const fs::path& folder) {
  try {
    return failure_kind(json.text());
  } catch (const std::invalid_argument& fault) {
    refuse(folder / "failure.json", fault.what());
  }
}

FailureBundle bundle_from(const Value& json, const fs::path& folder) {
  const int format = json["format"].whole<int>();
  if (format < 1 || format > kFormat)
    refuse(folder / "failure.json", "has a format that this program does not read");
  FailureBundle bundle;
  bundle.folder = folder;
  bundle.scene_from_file = json["scene_from_file"].flag();
  bundle.kind = kind_from(json[format == 1 ? "what" : "kind"], folder);
  bundle.cause = json["cause"].text();
  bundle.bodies_hash = json["bodies_hash"].text();
  bundle.attempts = json[format == 1 ? "tried_s" : "attempts_s"].numbers();
  const std::string hash = json["state_hash"].text();
  auto state = read_state(folder / "state.ply", hash);
  if (!state)
    refuse(folder / "state.ply", "is missing or damaged: it is not the state of failure.json");
  bundle.state = std::move(*state);
  for (const char* required : {"control", "tangles"}) json[required];
  read_state_fields(json, bundle.state);
  if (!std::isfinite(bundle.state.time) || bundle.state.time < 0.0)
    refuse(folder / "failure.json", "holds an impossible time");
  return bundle;
}

// -- files ----------------------------------------------------------------------------------------

constexpr std::array kFiles = {"failure.json",
                               "cause.txt",
                               "state.ply",
                               "scene.json",
                               "frames/cloth_00000.ply",
                               "frames/cloth_00001.ply",
                               "frames/bodies_00000.ply",
                               "frames/bodies_00001.ply",
                               "queries/point_triangle.csv",
                               "queries/point_triangle.toi.csv",
                               "queries/edge_edge.csv",
                               "queries/edge_edge.toi.csv"};

}  // namespace

void write_failure_bundle(const fs::path& folder, const Scene& scene, const Simulation& simulation,
                          const SimulationFailed& failure) {
  remove_failure_bundle(folder);
  make_folder(folder);
  write_bundled_scene(folder, scene);
  const SimulationState& state = simulation.state();
  write_ply(folder / "state.ply", state.x, simulation.cloth_triangles(), state_values(state));
  if (failure.kind != FailureKind::out_of_budget && failure.kind != FailureKind::unstable_step)
    write_offenders(folder, simulation);
  write_text(folder / "cause.txt", std::string(failure.what()) + "\n");
  write_text(
      folder / "failure.json",
      failure_json(scene, simulation, failure).dump(2, ' ', false, Json::error_handler_t::replace) +
          "\n");
}

void remove_failure_bundle(const fs::path& folder) {
  std::error_code ignored;  // a file that cannot be removed fails with its name when it is written
  for (const char* name : kFiles) fs::remove(folder / name, ignored);
  std::vector<fs::path> copies;
  for (const auto& entry : fs::directory_iterator(folder / "meshes", ignored))
    if (is_copy(entry.path())) copies.push_back(entry.path());
  for (const fs::path& copy : copies) fs::remove(copy, ignored);
  for (const char* name : {"frames", "queries", "meshes", ""}) fs::remove(folder / name, ignored);
}

}  // namespace detail

FailureBundle read_failure_bundle(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "failure.json";
  const auto json = detail::read_json(file);
  if (!json) detail::refuse(file, "is missing or damaged");
  try {
    return detail::bundle_from(detail::Value(*json), folder);
  } catch (const JsonFault& fault) {
    detail::refuse(file, std::string("is damaged: ") + fault.what());
  }
}

}  // namespace selvedge
