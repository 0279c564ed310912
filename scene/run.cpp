// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/atomic_file.h>
#include <selvedge/scene/run.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace selvedge {

namespace {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

constexpr int frame_digits = 5, step_digits = 6;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::size_t peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  constexpr std::size_t unit = 1024;  // Linux counts in KiB
  return static_cast<std::size_t>(usage.ru_maxrss) * unit;
}

// -- the result folder ----------------------------------------------------------------------------

std::optional<Json> read_json(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return std::nullopt;
  Json json = Json::parse(in, nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded() || !json.is_object()) return std::nullopt;
  return json;
}

/// The number in the name of a file that a run writes, such as cloth_00042.ply; none of others.
std::optional<std::int64_t> number_of(const fs::path& file, const std::vector<std::string>& stems,
                                      const std::vector<std::string>& extensions) {
  std::string name = file.filename().string();
  if (name.ends_with(".partial")) name.erase(name.size() - std::string(".partial").size());
  const auto extension = fs::path(name).extension().string();
  if (std::find(extensions.begin(), extensions.end(), extension) == extensions.end()) return {};
  name.erase(name.size() - extension.size());
  for (const std::string& stem : stems) {
    if (!name.starts_with(stem + "_")) continue;
    const char *begin = name.data() + stem.size() + 1, *end = name.data() + name.size();
    std::int64_t number = 0;
    const auto parsed = std::from_chars(begin, end, number);
    if (parsed.ec == std::errc{} && parsed.ptr == end && begin != end && *begin != '-')
      return number;
  }
  return {};
}

/// Removes the numbered files of a run whose number is above `last`, and nothing else.
void remove_numbered(const fs::path& folder, const std::vector<std::string>& stems,
                     const std::vector<std::string>& extensions, std::int64_t last) {
  std::error_code error;
  std::vector<fs::path> doomed;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (const auto number = number_of(entry.path(), stems, extensions); number && *number > last)
      doomed.push_back(entry.path());
  for (const auto& file : doomed)
    if (!fs::remove(file, error) && error)
      throw std::invalid_argument(fmt::format("{}: a file of an earlier run cannot be removed: {}",
                                              file.string(), error.message()));
}

void remove_beyond(const fs::path& out, std::int64_t frame, std::int64_t step) {
  remove_numbered(out / "frames", {"cloth", "bodies"}, {".ply", ".vtp"}, frame);
  remove_numbered(out / "steps", {"cloth", "bodies"}, {".ply"}, step);
  remove_numbered(out / "pictures", {"frame"}, {".png"}, frame);
}

void remove_former_run(const fs::path& out) {
  remove_beyond(out, -1, -1);
  std::error_code ignored;  // what cannot be removed cannot be overwritten either, and then says so
  for (const char* name : {"result.json", "checkpoint.ply", "checkpoint.json", "cloth.pvd",
                           "bodies.pvd", "cloth.pc2", "cloth_base.ply"})
    if (fs::is_regular_file(out / name, ignored)) fs::remove(out / name, ignored);
}

/// Refuses a folder in which this run would mix with something else.
void check_folder(const Scene& scene, const RunConfig& config) {
  const std::string out = config.out.string();
  if (out.empty())
    throw std::invalid_argument("the result folder has no name; give one with --out");
  std::error_code error;
  const auto status = fs::status(config.out, error);
  if (!fs::exists(status)) return;
  if (!fs::is_directory(status))
    throw std::invalid_argument(out + ": is a file and not a folder; name another result folder");
  const auto begin = fs::directory_iterator(config.out, error);
  if (error) throw std::invalid_argument(out + ": cannot be read: " + error.message());
  if (begin == fs::directory_iterator()) return;
  const auto former = read_json(config.out / "scene.json");
  if (!former)
    throw std::invalid_argument(
        out + ": holds files but no run of selvedge; name an empty or a new result folder");
  const std::string name = former->value("name", std::string());
  if (name != scene.name)
    throw std::invalid_argument(fmt::format(
        "{}: holds results of the scene \"{}\", this one is \"{}\"; name another result folder or "
        "empty this one",
        out, name, scene.name));
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw std::invalid_argument(
        fmt::format("{}: the result folder cannot be made: {}", folder.string(), error.message()));
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    throw std::invalid_argument(folder.string() +
                                ": the result folder cannot be written; check its permissions");
}

void write_text(const fs::path& file, const std::string& text) {
  AtomicFile out(file);
  out.write(text);
  out.commit();
}

// -- the state in files
// -----------------------------------------------------------------------------

std::vector<NamedValues> velocity_values(std::span<const Vec3> v) {
  std::vector<NamedValues> values = {{"vx", {}}, {"vy", {}}, {"vz", {}}};
  for (int axis = 0; axis < 3; ++axis) {
    values[axis].values.reserve(v.size());
    for (const Vec3& velocity : v) values[axis].values.push_back(velocity[axis]);
  }
  return values;
}

std::vector<Vec3> velocities(const std::vector<NamedValues>& values, const fs::path& file) {
  std::vector<Vec3> v;
  const std::string names[3] = {"vx", "vy", "vz"};
  for (int axis = 0; axis < 3; ++axis) {
    const auto found = std::find_if(values.begin(), values.end(),
                                    [&](const NamedValues& n) { return n.name == names[axis]; });
    if (found == values.end())
      throw std::invalid_argument(file.string() + ": has no velocities; it is no frame of a run");
    v.resize(found->values.size());
    for (std::size_t i = 0; i < v.size(); ++i) v[i][axis] = found->values[i];
  }
  return v;
}

/// Positions and velocities of a frame or checkpoint if they are the ones with this hash.
std::optional<SimulationState> read_state(const fs::path& file, const std::string& hash) {
  try {
    std::vector<NamedValues> values;
    SimulationState state;
    state.x = read_ply(file, values).vertices;
    state.v = velocities(values, file);
    if (state.v.size() == state.x.size() && state_hash(state) == hash) return state;
  } catch (const std::invalid_argument&) {  // damaged: the caller has another file to try
  }
  return std::nullopt;
}

// -- checkpoint.json ----------------------------------------------------------------------------

Json to_json(const RunResult& r) {
  return {{"clean", r.clean},
          {"halvings", r.halvings},
          {"retried_steps", r.retried_steps},
          {"wall_s", r.wall_s},
          {"phase_s", r.phase_s},
          {"worst_self_intersections", r.worst_self_intersections},
          {"worst_body_intersections", r.worst_body_intersections},
          {"max_penetration_m", r.max_penetration_m},
          {"max_stretch", r.max_stretch},
          {"strain_residual", r.strain_residual},
          {"peak_bytes", r.peak_bytes},
          {"counters", r.counters}};
}

RunResult result_from(const Json& j) {
  RunResult r;
  r.clean = j.at("clean").get<bool>();
  r.halvings = j.at("halvings").get<int>();
  r.retried_steps = j.at("retried_steps").get<int>();
  r.wall_s = j.at("wall_s").get<double>();
  r.phase_s = j.at("phase_s").get<std::map<std::string, double>>();
  r.worst_self_intersections = j.at("worst_self_intersections").get<int>();
  r.worst_body_intersections = j.at("worst_body_intersections").get<int>();
  r.max_penetration_m = j.at("max_penetration_m").get<double>();
  r.max_stretch = j.at("max_stretch").get<double>();
  r.strain_residual = j.at("strain_residual").get<double>();
  r.peak_bytes = j.at("peak_bytes").get<std::size_t>();
  r.counters = j.at("counters").get<std::map<std::string, double>>();
  return r;
}

bool is_maximum(const std::string& counter) {
  return counter.starts_with("max_") || counter.starts_with("worst_");
}

/// Adds what an earlier part of the same run counted and measured.
void carry_on(const RunResult& before, RunResult& r) {
  r.clean = r.clean && before.clean;
  r.halvings += before.halvings;
  r.retried_steps += before.retried_steps;
  r.wall_s += before.wall_s;
  for (const auto& [phase, seconds] : before.phase_s) r.phase_s[phase] += seconds;
  r.worst_self_intersections =
      std::max(r.worst_self_intersections, before.worst_self_intersections);
  r.worst_body_intersections =
      std::max(r.worst_body_intersections, before.worst_body_intersections);
  r.max_penetration_m = std::max(r.max_penetration_m, before.max_penetration_m);
  r.max_stretch = std::max(r.max_stretch, before.max_stretch);
  r.strain_residual = std::max(r.strain_residual, before.strain_residual);
  r.peak_bytes = std::max(r.peak_bytes, before.peak_bytes);
  for (const auto& [name, value] : before.counters)
    r.counters[name] =
        is_maximum(name) ? std::max(r.counters[name], value) : r.counters[name] + value;
}

/// What must be the same when a run goes on: everything but its length and what it writes.
Json what_decides(Json scene) {
  if (scene.contains("time")) scene["time"].erase("frames");
  for (const char* key : {"output", "description", "$schema"}) scene.erase(key);
  return scene;
}

// -- the run --------------------------------------------------------------------------------------

class Run {
 public:
  Run(const Scene& scene, const RunConfig& config) : scene_(scene), config_(config) {}

  RunResult execute() {
    check_folder(scene_, config_);
    BuiltScene built = build_scene(scene_);
    if (config_.warning)
      for (const std::string& sentence : built.warnings) config_.warning(sentence);
    simulation_.emplace(scene_, std::move(built), config_.methods);
    if (config_.resume)
      resume();
    else
      start();
    try {
      advance();
    } catch (const std::exception& error) {
      keep_what_there_is(error.what());
      throw;
    }
    return finish();
  }

 private:
  void start() {
    make_folder(config_.out);
    write_scene();  // first of all: from now on the folder is known as ours
    for (const fs::path& folder : folders()) make_folder(folder);
    remove_former_run(config_.out);
  }

  /// A scene that was made in code has no text; its name is enough to know the folder again.
  void write_scene() const {
    const std::string text =
        scene_.json.empty() ? Json{{"name", scene_.name}}.dump(2) : scene_.json;
    write_text(config_.out / "scene.json", text + "\n");
  }

  std::vector<fs::path> folders() const {
    std::vector<fs::path> all = {config_.out, config_.out / "frames"};
    if (config_.every_step) all.push_back(config_.out / "steps");
    return all;
  }

  void resume() {
    const fs::path file = config_.out / "checkpoint.json";
    const auto checkpoint = read_json(file);
    if (!checkpoint)
      throw std::invalid_argument(fmt::format(
          "{}: there is no checkpoint to go on from; run without --resume", file.string()));
    check_same_scene();
    for (const fs::path& folder : folders()) make_folder(folder);
    try {
      restore(*checkpoint);
    } catch (const Json::exception& error) {
      throw std::invalid_argument(
          fmt::format("{}: is damaged ({}); run without --resume", file.string(), error.what()));
    }
    write_scene();
    remove_beyond(config_.out, frame_, simulation_->state().step);
    resumed_ = true;
  }

  void check_same_scene() const {
    if (scene_.json.empty())
      throw std::invalid_argument(
          config_.out.string() +
          ": a scene that was made in code cannot be compared with the one that was run; only a "
          "scene read from a file can be resumed");
    const auto former = read_json(config_.out / "scene.json");
    if (!former || what_decides(*former) != what_decides(Json::parse(scene_.json)))
      throw std::invalid_argument(
          fmt::format("{}: differs from the scene that is to be resumed; only time.frames and "
                      "output may change",
                      (config_.out / "scene.json").string()));
  }

  void restore(const Json& checkpoint) {
    frame_ = checkpoint.at("frame").get<int>();
    const auto hash = checkpoint.at("state_hash").get<std::string>();
    // checkpoint.ply is written just before checkpoint.json. A run that was killed in between left
    // the state that belongs to checkpoint.json in its frame.
    auto state = read_state(config_.out / "checkpoint.ply", hash);
    if (!state) state = read_state(frame_file("cloth", frame_, ".ply"), hash);
    if (!state)
      throw std::invalid_argument(fmt::format(
          "{}: neither it nor frame {} holds the state of checkpoint.json; run without --resume",
          (config_.out / "checkpoint.ply").string(), frame_));
    state->step = checkpoint.at("step").get<std::int64_t>();
    state->time = checkpoint.at("time").get<double>();
    before_ = result_from(checkpoint.at("result"));
    simulation_->restore(std::move(*state));
  }

  void advance() {
    step_ = simulation_->state().step;
    if (resumed_) {
      resume_series();
    } else {
      if (config_.every_step) write_step();
      write_frame();
    }
    while (frame_ < scene_.time.frames && !stop_requested()) {
      simulation_->advance_to_frame(frame_ + 1, [this](double) {
        ++step_;
        if (config_.every_step) write_step();
      });
      ++frame_;
      write_frame();
    }
    if (frame_ < scene_.time.frames)
      stopped_ = fmt::format("stopped on request after frame {} of {}", frame_, scene_.time.frames);
  }

  bool stop_requested() const { return config_.stop != nullptr && config_.stop->load(); }

  fs::path frame_file(const std::string& stem, int frame, const std::string& extension) const {
    return numbered(config_.out / "frames", stem, frame, frame_digits, extension);
  }

  bool bodies_due(bool first) const {
    return !simulation_->body_positions().empty() && (first || simulation_->bodies_move());
  }

  void write_frame() {
    const auto begin = Clock::now();
    const SimulationState& state = simulation_->state();
    const auto velocity = velocity_values(state.v);
    write_ply(frame_file("cloth", frame_, ".ply"), state.x, simulation_->cloth_triangles(),
              velocity);
    if (bodies_due(frame_ == 0))
      write_ply(frame_file("bodies", frame_, ".ply"), simulation_->body_positions(),
                simulation_->body_triangles());
    if (scene_.output.vtk) write_vtk_frame();
    if (scene_.output.pc2) write_pc2_frame();
    write_checkpoint(velocity);
    output_s_ += seconds_since(begin);
    written_ = frame_ + 1;
    if (config_.progress) config_.progress(frame_, seconds_since(begin_));
  }

  void write_checkpoint(const std::vector<NamedValues>& velocity) {
    const SimulationState& state = simulation_->state();
    write_ply(config_.out / "checkpoint.ply", state.x, simulation_->cloth_triangles(), velocity);
    // JSON numbers are written with as many digits as give back the same double.
    const Json checkpoint = {{"frame", frame_},
                             {"step", state.step},
                             {"time", state.time},
                             {"state_hash", state_hash(state)},
                             {"result", to_json(result())}};
    write_text(config_.out / "checkpoint.json", checkpoint.dump(2) + "\n");
  }

  void write_vtk_frame() {
    const SimulationState& state = simulation_->state();
    write_vtp(frame_file("cloth", frame_, ".vtp"), state.x, state.v,
              simulation_->cloth_triangles());
    if (bodies_due(frame_ == 0))
      write_vtp(frame_file("bodies", frame_, ".vtp"), simulation_->body_positions(), {},
                simulation_->body_triangles());
    write_series("cloth", frame_ + 1);
    if (!simulation_->body_positions().empty())
      write_series("bodies", simulation_->bodies_move() ? frame_ + 1 : 1);
  }

  void write_series(const std::string& stem, int count) {
    std::vector<fs::path> pieces;
    std::vector<double> times;
    for (int frame = 0; frame < count; ++frame) {
      pieces.push_back(frame_file(stem, frame, ".vtp"));
      times.push_back(frame / scene_.time.fps);
    }
    write_pvd(config_.out / (stem + ".pvd"), pieces, times);
  }

  void write_pc2_frame() {
    const SimulationState& state = simulation_->state();
    if (!pc2_) {
      write_ply(config_.out / "cloth_base.ply", state.x, simulation_->cloth_triangles());
      pc2_.emplace(config_.out / "cloth.pc2", state.x.size());
    }
    pc2_->append(state.x);
  }

  /// A resumed run makes the series whole from the frames, whether or not they were asked for
  /// before.
  void resume_series() {
    if (!scene_.output.vtk && !scene_.output.pc2) return;
    for (int frame = 0; frame <= frame_; ++frame) {
      std::vector<NamedValues> values;
      const fs::path file = frame_file("cloth", frame, ".ply");
      const TriangleMesh mesh = read_ply(file, values);
      if (scene_.output.vtk)
        write_vtp(frame_file("cloth", frame, ".vtp"), mesh.vertices, velocities(values, file),
                  mesh.triangles);
      if (scene_.output.pc2) append_former(mesh);
    }
    if (scene_.output.vtk) resume_body_series();
  }

  void append_former(const TriangleMesh& mesh) {
    if (!pc2_) {
      write_ply(config_.out / "cloth_base.ply", mesh.vertices, mesh.triangles);
      pc2_.emplace(config_.out / "cloth.pc2", mesh.vertices.size());
    }
    pc2_->append(mesh.vertices);
  }

  void resume_body_series() {
    write_series("cloth", frame_ + 1);
    if (simulation_->body_positions().empty()) return;
    const int count = simulation_->bodies_move() ? frame_ + 1 : 1;
    for (int frame = 0; frame < count; ++frame) {
      const TriangleMesh mesh = read_mesh(frame_file("bodies", frame, ".ply"));
      write_vtp(frame_file("bodies", frame, ".vtp"), mesh.vertices, {}, mesh.triangles);
    }
    write_series("bodies", count);
  }

  void write_step() {
    const auto begin = Clock::now();
    const SimulationState& state = simulation_->state();
    const int number = static_cast<int>(step_);
    const fs::path folder = config_.out / "steps";
    write_ply(numbered(folder, "cloth", number, step_digits, ".ply"), state.x,
              simulation_->cloth_triangles(), velocity_values(state.v));
    if (bodies_due(number == 0))
      write_ply(numbered(folder, "bodies", number, step_digits, ".ply"),
                simulation_->body_positions(), simulation_->body_triangles());
    output_s_ += seconds_since(begin);
  }

  /// So far, with what was carried on from before a resume.
  RunResult result() const {
    RunResult r = simulation_->result();
    r.wall_s = seconds_since(begin_);
    r.phase_s["output"] += output_s_;
    r.peak_bytes = peak_bytes();
    carry_on(before_, r);
    r.steps = static_cast<int>(simulation_->state().step);
    r.frames = written_;
    r.state_hash = state_hash(simulation_->state());
    r.stopped = stopped_;
    return r;
  }

  RunResult finish() {
    if (resumed_ && written_ == 0) written_ = frame_ + 1;  // it was complete already
    RunResult r = result();
    write_result(config_.out / "result.json", r);
    return r;
  }

  /// After a failure: the frames are there, and the result says how far they go and why.
  void keep_what_there_is(const std::string& why) {
    stopped_ = why;
    if (resumed_) written_ = std::max(written_, frame_ + 1);
    try {
      write_result(config_.out / "result.json", result());
    } catch (const std::runtime_error&) {  // the disk is still full; `why` is what matters
    }
  }

  const Scene& scene_;
  const RunConfig& config_;
  Clock::time_point begin_ = Clock::now();
  std::optional<Simulation> simulation_;
  std::optional<Pc2Writer> pc2_;
  RunResult before_;       // of the parts of this run before it was resumed
  int frame_ = 0;          // last one done
  int written_ = 0;        // number of frames in the folder
  std::int64_t step_ = 0;  // accepted steps, counted here for the names of files
  double output_s_ = 0.0;
  bool resumed_ = false;
  std::string stopped_;
};

}  // namespace

RunResult run_scene(const Scene& scene, const RunConfig& config) {
  return Run(scene, config).execute();
}

}  // namespace selvedge
