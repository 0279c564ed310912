// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/core/system/internal/memory.h>
#include <selvedge/run/detail/background_task.h>
#include <selvedge/run/detail/checkpoint.h>
#include <selvedge/run/detail/coming_events.h>
#include <selvedge/run/detail/failure_bundle.h>
#include <selvedge/run/detail/frame_output.h>
#include <selvedge/run/detail/named_wrenches.h>
#include <selvedge/run/detail/run_folder.h>
#include <selvedge/run/detail/run_limits.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/run/run.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/internal/mesh_change.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

namespace selvedge {

namespace {

namespace fs = std::filesystem;

constexpr double kCheckpointSeconds = 1.0;  // between two checkpoints, unless frames take longer

/// The last frame and the result up to it.
struct LastFrame {
  detail::StateCopy copy;
  RunResult result;
};

class Run {
 public:
  Run(const Scene& scene, const RunConfig& config) : scene_(scene), config_(config) {}

  RunResult execute() {
    prepare();
    if (config_.resume)
      resume();
    else
      start();
    try {
      advance_and_settle();
    } catch (const SimulationFailed& failure) {
      stop(failure);
      if (failure.kind != FailureKind::out_of_budget) throw;
    } catch (const std::exception& error) {
      write_stopped_result(error.what());
      throw;
    }
    return finish();
  }

 private:
  // -- the start ----------------------------------------------------------------------------------

  /// Refuses what cannot run before it changes anything in the folder.
  void prepare() {
    detail::check_folder(scene_, config_.out);
    if (folder_exists()) lock_folder();  // before the build, which may take long
    BuiltScene built = build_scene(scene_, config_.methods);
    if (config_.warning)
      for (const std::string& sentence : built.warnings) config_.warning(sentence);
    output_.emplace(scene_, config_.formats, config_.out, !mesh_change(scene_).empty());
    simulation_.emplace(scene_, std::move(built), config_.methods);
    if (detail::wants_wrenches(scene_)) simulation_->measure_wrenches(true);
  }

  bool folder_exists() const {
    std::error_code ignored;  // if the name cannot be looked up, lock_folder reports the fault
    return fs::exists(config_.out, ignored);
  }

  /// Keeps other runs out of the folder from now on.
  void lock_folder() {
    if (lock_) return;
    detail::make_folder(config_.out);
    lock_.emplace(config_.out, "run");
    detail::check_folder(scene_, config_.out);  // again: another run may have used it meanwhile
    if (!config_.resume && !config_.overwrite) detail::refuse_results(config_.out);
    if (config_.warning && !lock_->warning().empty()) config_.warning(lock_->warning());
  }

  void make_folders() const {
    detail::make_folder(config_.out / "frames");
    if (config_.every_step) detail::make_folder(config_.out / "steps");
  }

  void start() {
    lock_folder();
    detail::write_scene(config_.out, scene_);  // first, since it marks the folder as a result
    make_folders();
    detail::remove_former_run(config_.out, config_.formats);
    detail::remove_failure_bundle(bundle());
  }

  void resume() {
    if (folder_exists()) lock_folder();
    detail::Checkpoint checkpoint = detail::read_checkpoint(config_.out);
    detail::check_same_scene(config_.out, scene_, config_.methods);
    frame_ = checkpoint.frame;
    check_missing_frames();
    make_folders();
    written_ = frame_ + 1;
    simulation_->resume(std::move(checkpoint.state), std::move(checkpoint.result));
    detail::write_scene(config_.out, scene_);
    detail::remove_leftovers(config_.out);
    detail::remove_beyond(config_.out, config_.formats, frame_, simulation_->state().step);
    resumed_ = true;
  }

  /// The state comes from the checkpoint, so the run can continue without its earlier frames,
  /// unless files of all frames are to be written.
  void check_missing_frames() const {
    const std::vector<int> missing = output_->missing_frames(*simulation_, frame_);
    if (missing.empty()) return;
    const std::string fault = fmt::format(
        "{}: {} of the {} frames before the checkpoint {} missing, the first is frame {}; ",
        (config_.out / "frames").string(), missing.size(), frame_ + 1,
        missing.size() == 1 ? "is" : "are", missing.front());
    if (output_->needs_former_frames())
      throw std::invalid_argument(
          fault +
          "files of other formats are written anew from all frames: leave out output.formats, or "
          "run without --resume");
    if (config_.warning) config_.warning(fault + "the run continues, but its result has a gap");
  }

  // -- frames and steps ---------------------------------------------------------------------------

  /// Before an error leaves, the last frame is whole. If that frame cannot be written, this is the
  /// earlier error, and it replaces the other one.
  void advance_and_settle() {
    try {
      advance();
    } catch (const std::exception&) {
      settle_frame();
      write_last_checkpoint();
      throw;
    }
    settle_frame();
    write_last_checkpoint();
  }

  void advance() {
    limits_.emplace(scene_, config_, simulation_->state().step);
    if (resumed_) {
      output_->resume(*simulation_, frame_);
    } else {
      write_step();
      write_frame();
    }
    while (frame_ < scene_.time.frames && !stop_requested() && !ends_at_rest()) {
      while (!simulation_->reached(frame_ + 1)) make_step();
      simulation_->verify_frame();
      ++frame_;
      write_frame();
    }
    if (frame_ < scene_.time.frames && !rests_)
      stopped_ = fmt::format("stopped on request after frame {} of {}", frame_, scene_.time.frames);
  }

  /// Whether the scene asks for no more than the equilibrium after all that it prescribes, and
  /// steps of this run ended there.
  bool ends_at_rest() {
    rests_ = scene_.time.until_rest && simulation_->last_step().accepted &&
             !detail::events_come(scene_, simulation_->built(), simulation_->time()) &&
             simulation_->is_at_rest();
    return rests_;
  }

  bool stop_requested() const { return config_.stop != nullptr && config_.stop->load(); }

  void make_step() {
    limits_->before_step(*simulation_, clock_.seconds());
    const std::int64_t before = simulation_->state().step;
    simulation_->step_towards(frame_ + 1);
    if (writing_.is_pending() && writing_.is_done()) settle_frame();
    if (simulation_->state().step == before) return;  // the cloth sleeps
    write_step();
    limits_->after_step(*simulation_);
  }

  void write_step() {
    if (!config_.every_step) return;
    const Stopwatch watch;
    output_->write_step(*simulation_, static_cast<int>(simulation_->state().step));
    output_s_ += watch.seconds();
  }

  /// Copies the frame and the result so far. A task writes them while the next steps are computed,
  /// one frame after the other and a checkpoint after its frame, so that at any moment the
  /// checkpoint names a frame that is whole. File systems write a replaced file to the disk at
  /// once, which takes longer than a frame of a small cloth, so frames in quick succession share
  /// one.
  void write_frame() {
    settle_frame();
    const Stopwatch watch;
    written_ = frame_;
    last_ = std::make_shared<const LastFrame>(
        LastFrame{output_->copy_frame(*simulation_, frame_), result()});
    const bool due = !since_checkpoint_ || since_checkpoint_->seconds() >= kCheckpointSeconds;
    writing_.start([this, last = last_, due] {
      output_->write_frame(last->copy);
      if (due) write_checkpoint(*last);
    });
    if (due) {
      since_checkpoint_.emplace();
      last_.reset();
    }
    output_s_ += watch.seconds();
    if (writing_.is_done()) settle_frame();
  }

  /// Waits for the frame that is being written; throws if it cannot be written. `written_` is its
  /// number until then.
  void settle_frame() {
    if (!writing_.is_pending()) return;
    const Stopwatch watch;
    try {
      writing_.finish();
    } catch (const std::exception&) {
      last_.reset();  // no checkpoint of a frame that is not whole
      throw;
    }
    // A resumed run has now passed the step at which it had stopped.
    if (resumed_) detail::remove_failure_bundle(bundle());
    output_s_ += watch.seconds();
    const int frame = written_++;
    if (config_.progress) config_.progress(frame, clock_.seconds());
  }

  /// The checkpoint of the last frame, if write_frame has left it out.
  void write_last_checkpoint() {
    if (last_) write_checkpoint(*last_);
    last_.reset();
  }

  void write_checkpoint(const LastFrame& last) const {
    detail::write_checkpoint(config_.out, last.copy.number, last.copy, last.result);
  }

  void write_checkpoint() {
    detail::write_checkpoint(config_.out, frame_, output_->copy_frame(*simulation_, frame_),
                             result());
  }

  // -- the end ------------------------------------------------------------------------------------

  fs::path bundle() const { return config_.out / "failure"; }

  /// So far, including the parts of the run before a resume.
  RunResult result() const {
    RunResult r = simulation_->result();
    r.wall_s += clock_.seconds();
    r.phase_s["output"] += output_s_;
    r.peak_bytes = std::max(r.peak_bytes, peak_bytes());
    r.frames = written_;
    r.stopped = stopped_;
    return r;
  }

  RunResult finish() {
    output_->finish();
    RunResult r = result();
    r.rest = simulation_->rest();
    std::map<std::string, double> felt;
    if (simulation_->measures_wrenches()) felt = detail::wrench_measures(scene_, *simulation_);
    // The measures build the forces once more, so the solver goes first.
    const FinalState end = std::move(*simulation_).end();
    r.measures =
        final_measures(scene_, end.built, {end.state.x, end.state.v, end.mass, end.state.time},
                       config_.methods.force_laws);
    r.measures.merge(felt);
    write_result(config_.out / "result.json", r);
    return r;
  }

  /// Leaves result, checkpoint and failure bundle. A file that cannot be written must not hide the
  /// cause of the stop.
  void stop(const SimulationFailed& failure) {
    write_stopped_result(failure.what());
    try {
      if (failure.kind == FailureKind::out_of_budget)
        write_checkpoint();
      else
        output_->finish();  // else the run ends as one without a failure does
      detail::write_failure_bundle(bundle(), scene_, *simulation_, failure);
    } catch (const std::exception& error) {
      if (config_.warning)
        config_.warning(std::string("the failure could not be recorded: ") + error.what());
    }
  }

  /// The frames are written; the result says how many there are and why there are no more.
  void write_stopped_result(const std::string& why) {
    stopped_ = why;
    try {
      RunResult r = result();
      if (simulation_->last_step().accepted) r.rest = simulation_->rest();
      write_result(config_.out / "result.json", r);
    } catch (const std::runtime_error&) {  // such as a full disk; the caller reports `why`
    }
  }

  const Scene& scene_;
  const RunConfig& config_;
  Stopwatch clock_;
  std::optional<FolderLock> lock_;
  std::optional<Simulation> simulation_;
  std::optional<detail::FrameOutput> output_;
  std::optional<detail::RunLimits> limits_;
  int frame_ = 0;    // last complete one
  int written_ = 0;  // number of frames in the folder
  double output_s_ = 0.0;
  std::optional<Stopwatch> since_checkpoint_;
  std::shared_ptr<const LastFrame> last_;  // whose checkpoint is not written; null: it is
  bool resumed_ = false;
  bool rests_ = false;  // ended because the cloth is at rest
  std::string stopped_;
  detail::BackgroundTask writing_;  // the last frame; last member, since it refers to the others
};

}  // namespace

RunResult run_scene(const Scene& scene, const RunConfig& config) {
  return Run(scene, config).execute();
}

}  // namespace selvedge
