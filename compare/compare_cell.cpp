// SPDX-License-Identifier: MIT
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/compare/compare_plan.h>
#include <selvedge/compare/detectors/compare_detectors.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/internal/whole_number.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/core/system/internal/memory.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <algorithm>
#include <ctime>
#include <limits>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Below this number of box tests, brute force takes some milliseconds and provides the reference.
constexpr double kFewTests = 2e6;

/// Springs stretched to ten times their length no longer represent cloth. An unstable explicit
/// method exceeds this limit some steps before its numbers overflow.
constexpr double kUnstableStretch = 10.0;

/// The motion on which detectors are judged continues for this many steps without any response, so
/// that collisions occur.
constexpr double kFlightSteps = 4.0;

const std::map<RunStatus, const char*>& words() {
  static const std::map<RunStatus, const char*> all = {
      {RunStatus::ok, "ok"},         {RunStatus::unstable, "unstable"},
      {RunStatus::failed, "failed"}, {RunStatus::refused, "refused"},
      {RunStatus::budget, "budget"}, {RunStatus::crashed, "crashed"}};
  return all;
}

/// The complete state at the end of a frame.
struct Sample {
  std::vector<Vec3> x, v, bodies;
  std::vector<Triangle> triangles;
};

// -- detectors ------------------------------------------------------------------------------------

void judge_case(const Scene& scene, const Methods& methods, const DetectionCase& c,
                PairJudgement& judgement) {
  const ReferencePairs reference = reference_pairs(c, kFewTests, scene.contact.broad_phase);
  judgement.colliding += reference.colliding.size();
  const auto fail = [&](const std::string& method, const std::string& what) {
    if (judgement.failure.empty()) judgement.failure = method + " " + what;
  };
  const auto& broad = methods.broad_phases.at(scene.contact.broad_phase);
  const auto make_broad = [&] { return broad(scene.contact.broad_phase_options); };
  if (why_not(broad.traits(), c).empty()) {
    DetectorTrial trial(make_broad, c, reference);
    trial.measure();
    const DetectorScore score = trial.score();
    judgement.broad_missed += score.missed;
    if (!score.failure.empty()) fail(scene.contact.broad_phase, score.failure);
  }
  const auto narrow =
      methods.narrow_phases.at(scene.contact.narrow_phase)(scene.contact.narrow_phase_options);
  const ContactScore contacts = score_contacts(*narrow, c, reference, 1);
  judgement.narrow_missed += contacts.missed;
  judgement.narrow_false += contacts.false_alarms;
  if (narrow->traits().misses_nothing && contacts.missed > 0)
    fail(scene.contact.narrow_phase,
         "is to miss nothing, and missed " + std::to_string(contacts.missed));
  if (narrow->traits().no_false_alarm && contacts.false_alarms > 0)
    fail(scene.contact.narrow_phase,
         "is to raise no false alarm, and raised " + std::to_string(contacts.false_alarms));
}

/// Judges the detectors that the scene names on the motion that continues from the sample for `tau`
/// seconds without any response.
void judge_motion(const Scene& scene, const Methods& methods, const Simulation& simulation,
                  const Sample& sample, double tau, PairJudgement& judgement) {
  std::vector<Vec3> flown;
  flown.reserve(sample.x.size());
  for (std::size_t i = 0; i < sample.x.size(); ++i)
    flown.push_back(sample.x[i] + tau * (sample.v[i] + tau * scene.gravity));
  const std::vector<Triangle>& cloth_triangles = sample.triangles;
  const auto body_triangles = simulation.body_triangles();
  const std::vector<Edge> cloth_edges = unique_edges(cloth_triangles);
  const std::vector<Edge> body_edges = unique_edges(body_triangles);
  const double half = 0.5 * scene.contact.rest_gap;
  const SurfaceView cloth{sample.x, flown, cloth_edges, cloth_triangles, half};
  const std::vector<Vec3>& at = sample.bodies;
  ++judgement.motions;
  if (scene.contact.self) judge_case(scene, methods, {cloth, cloth, true}, judgement);
  if (!at.empty())
    judge_case(scene, methods, {cloth, {at, at, body_edges, body_triangles, half}, false},
               judgement);
  const auto missed = static_cast<double>(judgement.broad_missed + judgement.narrow_missed);
  const auto all = static_cast<double>(judgement.colliding);
  judgement.recall = all == 0.0 ? 1.0 : std::max(0.0, (all - missed) / all);
}

// -- one run --------------------------------------------------------------------------------------

class CellRunner {
 public:
  CellRunner(fs::path folder, int repeat, const CellLimits& limits, const Methods& methods)
      : folder_(std::move(folder)), repeat_(repeat), limits_(limits), methods_(methods) {}

  CellRun execute() {
    try {
      beside("reading",
             [&] { scene_ = read_scene(folder_ / "scene.json", seed_overrides(), methods_); });
      run_.dt = nominal_step(scene_);
      beside("warming_up", [&] { warm_up(); });
      simulate();
    } catch (const std::invalid_argument& error) {
      end(RunStatus::refused, error.what());
    } catch (const SimulationFailed& error) {
      const bool unstable =
          error.kind == FailureKind::not_finite || error.kind == FailureKind::unstable_step;
      end(unstable ? RunStatus::unstable : RunStatus::failed, error.what());
    } catch (const std::system_error&) {  // a failed write is not the fault of the cell
      throw;
    } catch (const std::bad_alloc&) {
      end(RunStatus::failed, "out of memory");
    } catch (const std::runtime_error& error) {  // such as too many pairs
      end(RunStatus::failed, error.what());
    }
    if (simulation_) beside("writing", [&] { note_end(); });
    beside("judging", [&] {  // after all timed work
      for (const Sample& sample : samples_) judge(sample);
    });
    return run_;
  }

 private:
  template <class Work>
  void beside(const char* what, const Work& work) {
    const Stopwatch watch;
    work();
    run_.beside_s[what] += watch.seconds();
  }

  void end(RunStatus status, const std::string& why) {
    run_.status = status;
    run_.why = why;
  }

  /// Runs one step of a temporary simulation to warm pages, caches and threads.
  void warm_up() {
    Simulation other(scene_, build_scene(scene_, methods_), methods_);
    try {
      other.step_towards(1);
    } catch (const SimulationFailed&) {  // the real run will report it
    }
  }

  void simulate() {
    const Stopwatch watch;
    simulation_.emplace(scene_, build_scene(scene_, methods_), methods_);
    run_.build_s = watch.seconds();
    start_bodies_ = simulation_->body_positions();
    for (int frame = 1; frame <= scene_.time.frames && run_.status == RunStatus::ok; ++frame) {
      advance(frame);
      if (run_.status != RunStatus::ok) return;
      beside("checking", [&] { simulation_->verify_frame(); });
      if (is_judged(frame)) sample();
    }
  }

  void sample() {
    const Simulation& now = *simulation_;
    const auto triangles = now.cloth_triangles();
    samples_.push_back(
        {now.state().x, now.state().v, now.body_positions(), {triangles.begin(), triangles.end()}});
  }

  void judge(const Sample& sample) {
    try {
      judge_motion(scene_, methods_, *simulation_, sample, kFlightSteps * run_.dt, run_.pairs);
    } catch (const std::exception& error) {  // a detector failed; the run itself remains valid
      if (run_.pairs.failure.empty()) run_.pairs.failure = error.what();
    }
  }

  void advance(int frame) {
    const Stopwatch watch;
    const std::clock_t begin = std::clock();
    const auto note_time = [&] {
      run_.clock_s += watch.seconds();
      run_.run_s += limits_.threads == 1
                        ? static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC
                        : watch.seconds();
    };
    try {
      while (run_.status == RunStatus::ok && simulation_->step_towards(frame))
        if (run_.clock_s + watch.seconds() > limits_.budget_s)
          end(RunStatus::budget, "took longer than granted");
    } catch (...) {
      note_time();
      throw;
    }
    note_time();
    const double stretch = simulation_->result().max_stretch;
    if (!(stretch < kUnstableStretch))
      end(RunStatus::unstable, "springs were stretched to more than eleven times their length");
  }

  bool is_judged(int frame) const {
    if (repeat_ != 0 || limits_.judged_motions <= 0) return false;
    const int every = std::max(1, scene_.time.frames / limits_.judged_motions);
    return frame % every == 0;
  }

  void note_end() {
    run_.result = simulation_->result();
    run_.end_s = simulation_->state().time;
    run_.particles = simulation_->state().x.size();
    run_.peak_bytes = peak_bytes();
    const Simulation& now = *simulation_;
    run_.result.measures =
        final_measures(scene_, now.built(), {now.state().x, now.state().v, now.mass(), run_.end_s},
                       methods_.force_laws);
    if (repeat_ != 0 && !limits_.seeds) return;
    // Cells may have been split, so the start frame uses the surface of the end.
    if (repeat_ == 0) write_frame(0, now.built().cloth.surface.vertices, start_bodies_);
    write_frame(kEndFrame + repeat_, now.state().x, now.body_positions());
  }

  std::vector<Override> seed_overrides() const {
    if (!limits_.seeds) return {};
    return {{"perturbation.seed", std::to_string(repeat_ + 1)}};
  }

  void write_frame(int frame, const std::vector<Vec3>& x, const std::vector<Vec3>& bodies) const {
    const fs::path frames = folder_ / "frames";
    fs::create_directories(frames);
    const auto file = [&](const char* stem) {
      return numbered(frames, stem, frame, kFrameFileDigits, ".ply");
    };
    write_ply(file("cloth"), x, simulation_->cloth_triangles());
    if (!bodies.empty()) write_ply(file("bodies"), bodies, simulation_->body_triangles());
  }

  fs::path folder_;
  int repeat_;
  const CellLimits& limits_;
  const Methods& methods_;
  Scene scene_;
  std::optional<Simulation> simulation_;
  std::vector<Vec3> start_bodies_;
  std::vector<Sample> samples_;
  CellRun run_;
};

// -- its file -------------------------------------------------------------------------------------

fs::path run_file(const fs::path& folder, int repeat) {
  return folder / ("run_" + std::to_string(repeat) + ".json");
}

Json to_json(const CellRun& run) {
  const PairJudgement& p = run.pairs;
  return {{"status", status_word(run.status)},
          {"why", run.why},
          {"build_s", run.build_s},
          {"run_s", run.run_s},
          {"clock_s", run.clock_s},
          {"beside_s", run.beside_s},
          {"end_s", run.end_s},
          {"dt", run.dt},
          {"particles", run.particles},
          {"peak_bytes", run.peak_bytes},
          {"result", Json::parse(result_text(run.result))},
          {"pairs",
           {{"motions", p.motions},
            {"colliding", p.colliding},
            {"broad_missed", p.broad_missed},
            {"narrow_missed", p.narrow_missed},
            {"narrow_false", p.narrow_false},
            {"recall", p.recall},
            {"failure", p.failure}}}};
}

/// JSON cannot represent non-finite numbers; they were written as null.
double real(const Json& j) {
  return j.is_number() ? j.get<double>() : std::numeric_limits<double>::infinity();
}

std::size_t count(const Json& j) {
  if (const auto number = whole_number<std::size_t>(j)) return *number;
  throw std::invalid_argument("not a count: " + j.dump());
}

CellRun from_json(const Json& j) {
  CellRun run;
  run.status = status_of(j.at("status").get<std::string>());
  run.why = j.at("why").get<std::string>();
  run.build_s = real(j.at("build_s"));
  run.run_s = real(j.at("run_s"));
  run.clock_s = real(j.at("clock_s"));
  run.beside_s = j.at("beside_s").get<std::map<std::string, double>>();
  run.end_s = real(j.at("end_s"));
  run.dt = real(j.at("dt"));
  run.particles = count(j.at("particles"));
  run.peak_bytes = count(j.at("peak_bytes"));
  run.result = result_from_text(j.at("result").dump());
  const Json& pairs = j.at("pairs");
  run.pairs = {count(pairs.at("motions")),
               count(pairs.at("colliding")),
               count(pairs.at("broad_missed")),
               count(pairs.at("narrow_missed")),
               count(pairs.at("narrow_false")),
               pairs.at("recall").get<double>(),
               pairs.at("failure").get<std::string>()};
  return run;
}

}  // namespace

const char* status_word(RunStatus status) { return words().at(status); }

RunStatus status_of(const std::string& word) {
  for (const auto& [status, known] : words())
    if (word == known) return status;
  throw std::invalid_argument("there is no status \"" + word + "\" of a run");
}

void note_run(const fs::path& folder, int repeat, const CellRun& run) {
  AtomicFile file(run_file(folder, repeat));
  file.write(to_json(run).dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
  file.commit();
}

std::optional<CellRun> read_cell_run(const fs::path& folder, int repeat) {
  const Json j = Json::parse(read_if_there(run_file(folder, repeat)), nullptr, false);
  if (!j.is_object()) return std::nullopt;
  try {
    return from_json(j);
  } catch (const std::exception&) {  // damaged or from another version; the run is repeated
    return std::nullopt;
  }
}

CellRun run_cell(const fs::path& folder, int repeat, const CellLimits& limits,
                 const Methods& methods) {
  const ThreadLimit threads(limits.threads);
  CellRun run = CellRunner(folder, repeat, limits, methods).execute();
  note_run(folder, repeat, run);
  return run;
}

}  // namespace selvedge
