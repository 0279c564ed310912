// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/scene/detail/checkpoint.h>
#include <selvedge/scene/detail/result_folder.h>
#include <selvedge/scene/failure_bundle.h>
#include <selvedge/scene/measures.h>
#include <selvedge/scene/refinement.h>
#include <selvedge/scene/run.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

namespace selvedge {

namespace {

using namespace detail;
using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::size_t peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  constexpr std::size_t unit = 1024;  // Linux counts in KiB
  return static_cast<std::size_t>(usage.ru_maxrss) * unit;
}

// -- the run --------------------------------------------------------------------------------------

class Run {
 public:
  Run(const Scene& scene, const RunConfig& config) : scene_(scene), config_(config) {}

  RunResult execute() {
    check_folder(scene_, config_.out);
    BuiltScene built = build_scene(scene_);
    if (config_.warning)
      for (const std::string& sentence : built.warnings) config_.warning(sentence);
    refinement_.emplace(scene_, built);
    simulation_ = std::make_unique<Simulation>(scene_, std::move(built), config_.methods);
    if (config_.resume)
      resume();
    else
      start();
    try {
      advance();
    } catch (const SimulationFailed& failure) {
      stop(failure);
      if (failure.kind != FailureKind::out_of_budget) throw;
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
    remove_failure_bundle(bundle());
  }

  fs::path bundle() const { return config_.out / "failure"; }

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
    // the state that belongs to checkpoint.json in its frame, or in the bundle of the stop.
    auto state = read_state(config_.out / "checkpoint.ply", hash);
    if (!state) state = read_state(frame_file("cloth", frame_, ".ply"), hash);
    if (!state) state = read_state(bundle() / "state.ply", hash);
    if (!state)
      throw std::invalid_argument(fmt::format(
          "{}: neither it nor frame {} holds the state of checkpoint.json; run without --resume",
          (config_.out / "checkpoint.ply").string(), frame_));
    state->step = checkpoint.at("step").get<std::int64_t>();
    state->time = checkpoint.at("time").get<double>();
    if (checkpoint.contains("control")) state->control = control_from(checkpoint["control"]);
    if (checkpoint.contains("tangles")) state->tangles = tangles_from(checkpoint["tangles"]);
    if (checkpoint.contains("memory")) state->memory = memory_from(checkpoint["memory"]);
    if (checkpoint.contains("splits")) state->splits = splits_from(checkpoint["splits"]);
    if (!state->splits.empty()) {
      refinement_->split(state->splits);
      simulation_ = refined_simulation(*refinement_);
    }
    before_ = result_from(checkpoint.at("result"));
    simulation_->restore(std::move(*state));
  }

  void advance() {
    first_step_ = step_ = simulation_->state().step;
    if (resumed_) {
      resume_series();
    } else {
      if (config_.every_step) write_step();
      write_frame();
    }
    while (frame_ < scene_.time.frames && !stop_requested()) {
      refine();
      while (!simulation_->reached(frame_ + 1)) make_step();
      simulation_->verify_frame();
      ++frame_;
      write_frame();
    }
    if (frame_ < scene_.time.frames)
      stopped_ = fmt::format("stopped on request after frame {} of {}", frame_, scene_.time.frames);
  }

  std::unique_ptr<Simulation> refined_simulation(const Refinement& refinement) const {
    return std::make_unique<Simulation>(refinement.scene(), refinement.build(), config_.methods);
  }

  /// Splits what is due at a frame, unless a state with the new cells would cross something. The
  /// exchange of the surface counts as a step, so that every state of steps/ has one surface.
  void refine() {
    const SimulationState& state = simulation_->state();
    // A run out of budget is resumed within a frame, where this was decided before.
    const double steps = state.time * scene_.time.fps * scene_.time.steps_per_frame;
    const bool at_frame = state.control.h == 0.0 &&
                          std::llround(steps) == std::int64_t{frame_} * scene_.time.steps_per_frame;
    if (!refinement_->active() || !at_frame) return;
    auto next = split_due(*refinement_, *simulation_, config_.methods);
    if (!next) return;
    if (!next->simulation->result().clean) {
      before_.counters["refinements_postponed"] += 1;
      return;
    }
    RunResult r = simulation_->result();
    carry_on(before_, r);
    before_ = std::move(r);
    before_.counters["refinements"] += 1;
    refinement_.emplace(std::move(next->refinement));
    simulation_ = std::move(next->simulation);
    ++step_;
    if (config_.every_step) write_step();
  }

  void make_step() {
    check_budget();
    const int halvings = simulation_->state().control.halvings;
    if (small_steps_ + 1 == config_.stall_steps) before_stall_ = simulation_->state();
    simulation_->step_towards(frame_ + 1);
    ++step_;
    if (config_.every_step) write_step();
    const int tries = static_cast<int>(simulation_->tried().size());
    const bool small = is_near_smallest(halvings + tries - 1, scene_.time.max_halvings);
    small_steps_ = small ? small_steps_ + 1 : 0;
    if (small && small_steps_ == config_.stall_steps) stall();
  }

  void check_budget() const {
    const SimulationState& state = simulation_->state();
    const double wall = seconds_since(begin_);
    const bool steps_left = config_.max_steps <= 0 || step_ - first_step_ < config_.max_steps;
    if (step_ == first_step_ || (wall <= config_.budget_s && steps_left)) return;
    const std::string grant = steps_left ? fmt::format("{} s of wall time", config_.budget_s)
                                         : fmt::format("{} accepted steps", config_.max_steps);
    throw SimulationFailed(FailureKind::out_of_budget,
                           fmt::format("out of budget at {} s of {} s: granted were {}", state.time,
                                       scene_.time.frames / scene_.time.fps, grant));
  }

  /// Keeps the state before the last step, so that its replay shows what holds the run up.
  void stall() {
    simulation_->restore(std::move(before_stall_));
    const SimulationState& state = simulation_->state();
    const FailedTry& failed = simulation_->failed_try();
    std::string cause = fmt::format(
        "stalled at {} s: each of the last {} steps was accepted only after {} or more halvings, "
        "the last one with {} s; before that: {}",
        state.time, config_.stall_steps, scene_.time.max_halvings - 1, simulation_->tried().back(),
        failed.trouble);
    if (!failed.pairs.empty()) cause += ", first " + simulation_->names().pair(failed.pairs[0]);
    throw SimulationFailed(FailureKind::stalled, cause);
  }

  bool stop_requested() const { return config_.stop != nullptr && config_.stop->load(); }

  fs::path frame_file(const std::string& stem, int frame, const std::string& extension) const {
    return numbered(config_.out / "frames", stem, frame, frame_file_digits, extension);
  }

  bool bodies_due(bool first) const {
    return !simulation_->body_positions().empty() && (first || simulation_->bodies_move());
  }

  void write_frame() {
    const auto begin = Clock::now();
    const SimulationState& state = simulation_->state();
    write_ply(frame_file("cloth", frame_, ".ply"), state.x, simulation_->cloth_triangles(),
              frame_values(*simulation_));
    if (bodies_due(frame_ == 0))
      write_ply(frame_file("bodies", frame_, ".ply"), simulation_->body_positions(),
                simulation_->body_triangles());
    if (scene_.output.vtk) write_vtk_frame();
    if (scene_.output.pc2) write_pc2_frame();
    write_checkpoint();
    output_s_ += seconds_since(begin);
    written_ = frame_ + 1;
    if (config_.progress) config_.progress(frame_, seconds_since(begin_));
  }

  void write_checkpoint() {
    const SimulationState& state = simulation_->state();
    write_ply(config_.out / "checkpoint.ply", state.x, simulation_->cloth_triangles(),
              state_values(state));
    // JSON numbers are written with as many digits as give back the same double.
    const Json checkpoint = {{"frame", frame_},
                             {"step", state.step},
                             {"time", state.time},
                             {"control", to_json(state.control)},
                             {"tangles", to_json(state.tangles)},
                             {"memory", memory_text(state.memory)},
                             {"splits", to_json(state.splits)},
                             {"state_hash", state_hash(state)},
                             {"result", to_json(result())}};
    write_text(config_.out / "checkpoint.json", checkpoint.dump(2) + "\n");
    if (resumed_ && stopped_.empty()) remove_failure_bundle(bundle());  // the run has got beyond it
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
    write_ply(numbered(folder, "cloth", number, step_file_digits, ".ply"), state.x,
              simulation_->cloth_triangles(), frame_values(*simulation_));
    if (bodies_due(number == 0))
      write_ply(numbered(folder, "bodies", number, step_file_digits, ".ply"),
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
    const SimulationState& state = simulation_->state();
    r.measures = final_measures(scene_, simulation_->built(),
                                {state.x, state.v, simulation_->mass(), state.time});
    write_result(config_.out / "result.json", r);
    return r;
  }

  /// Keeps what was the matter. A file that cannot be written does not hide why the run stopped.
  void stop(const SimulationFailed& failure) {
    keep_what_there_is(failure.what());
    try {
      if (failure.kind == FailureKind::out_of_budget) write_checkpoint();
      write_failure_bundle(bundle(), scene_, *simulation_, failure);
    } catch (const std::exception& error) {
      if (config_.warning)
        config_.warning(std::string("what was the matter could not be kept: ") + error.what());
    }
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
  std::unique_ptr<Simulation> simulation_;
  std::optional<Refinement> refinement_;
  std::optional<Pc2Writer> pc2_;
  RunResult before_;              // of the parts of this run before it was resumed
  int frame_ = 0;                 // last one done
  int written_ = 0;               // number of frames in the folder
  std::int64_t step_ = 0;         // accepted steps, counted here for the names of files
  std::int64_t first_step_ = 0;   // accepted before this call
  int small_steps_ = 0;           // accepted in a row near the smallest size
  SimulationState before_stall_;  // before the step that makes it a stall
  double output_s_ = 0.0;
  bool resumed_ = false;
  std::string stopped_;
};

}  // namespace

RunResult run_scene(const Scene& scene, const RunConfig& config) {
  return Run(scene, config).execute();
}

}  // namespace selvedge
