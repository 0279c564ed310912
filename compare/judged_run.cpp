// SPDX-License-Identifier: MIT
#include <selvedge/compare/detail/trial.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/simulation_state.h>

#include <selvedge/bodies/mesh_file.h>
#include <selvedge/judge/judge.h>
#include <selvedge/run/result_folder.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <limits>
#include <stdexcept>

namespace selvedge::detail {
namespace {

/// Stops a run that takes too long.
class TooLong : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

bool all_finite(std::span<const Vec3> x) {
  return std::all_of(x.begin(), x.end(), [](const Vec3& p) { return p.allFinite(); });
}

/// Input of the energy computation; potential energy is relative to z = 0 along gravity.
double energy_of(const JudgedRun& run, std::span<const Vec3> x, std::span<const Vec3> v) {
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i)
    sum += run.cloth.mass[i] * (0.5 * v[i].squaredNorm() - run.scene.gravity.dot(x[i]));
  for (const Spring& s : run.cloth.springs) {
    const double longer = (x[s.b] - x[s.a]).norm() - s.rest_length;
    sum += 0.5 * s.stiffness * longer * longer;
  }
  return sum;
}

double height_energy(const JudgedRun& run, std::span<const Vec3> x) {
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) sum -= run.cloth.mass[i] * run.scene.gravity.dot(x[i]);
  return sum;
}

bool is_closed_system(const Scene& scene) {
  const auto moves = [](const auto& thing) { return !thing.motion.empty(); };
  const bool driven = std::any_of(scene.bodies.begin(), scene.bodies.end(), [&](const auto& b) {
    return moves(b) || std::holds_alternative<BodySequence>(b.shape);
  });
  return !driven && std::none_of(scene.handles.begin(), scene.handles.end(), moves) &&
         scene.air.wind.isZero(0.0);
}

/// Follows a simulation, keeps its frames and judges them.
class Watch {
 public:
  Watch(JudgedRun& run, const JudgedRunConfig& config, Simulation& simulation)
      : run_(run), config_(config), simulation_(simulation) {
    triangles_.assign(simulation.cloth_triangles().begin(), simulation.cloth_triangles().end());
    body_triangles_.assign(simulation.body_triangles().begin(), simulation.body_triangles().end());
    last_ = mesh();
    last_body_ = body();
    start_energy_ = energy_of(run_, simulation.state().x, simulation.state().v);
    most_energy_ = start_energy_;
    least_height_ = height_energy(run_, simulation.state().x);
  }

  void step() {
    const SimulationState& state = simulation_.state();
    run_.finite = run_.finite && all_finite(state.x) && all_finite(state.v);
    if (!run_.finite) throw std::runtime_error("a position or velocity is not finite");
    for (const Vec3& v : state.v) run_.worst_speed = std::max(run_.worst_speed, v.norm());
    most_energy_ = std::max(most_energy_, energy_of(run_, state.x, state.v));
    least_height_ = std::min(least_height_, height_energy(run_, state.x));
    if (config_.judge_paths) judge_step();
    const double seconds = static_cast<double>(std::clock() - begin_) / CLOCKS_PER_SEC;
    if (seconds > config_.limit)
      throw TooLong(fmt::format("{:.3g} of {:.3g} s after {:g} s of the processor", state.time,
                                run_.scene.time.frames / run_.scene.time.fps, config_.limit));
  }

  void frame() {
    run_.times.push_back(simulation_.state().time);
    run_.frames.push_back(simulation_.state().x);
    run_.bodies.push_back(simulation_.body_positions());
    const Verdict verdict = judge(mesh(), body(), {});
    run_.intersections =
        std::max(run_.intersections,
                 verdict.self_intersections + verdict.body_intersections + verdict.inside_vertices);
    if (!config_.out.empty()) write_frame();
  }

  void finish() {
    const SimulationState& state = simulation_.state();
    run_.x = state.x;
    run_.v = state.v;
    run_.time = state.time;
    run_.result = simulation_.result();
    double sum = 0.0;
    for (const Vec3& v : state.v) sum += v.squaredNorm();
    run_.rms_speed = std::sqrt(sum / static_cast<double>(state.v.size()));
    const double start = start_energy_ - least_height_;
    run_.energy_ratio = is_closed_system(run_.scene) && start > 0.0
                            ? (most_energy_ - least_height_) / start
                            : std::numeric_limits<double>::quiet_NaN();
  }

 private:
  TriangleMesh mesh() const { return {simulation_.state().x, triangles_}; }
  TriangleMesh body() const { return {simulation_.body_positions(), body_triangles_}; }

  void judge_step() {
    TriangleMesh now = mesh(), now_body = body();
    const PathVerdict path = judge_path(last_, now.vertices, last_body_, now_body.vertices);
    run_.path_collisions += path.self_collisions + path.body_collisions;
    last_ = std::move(now);
    last_body_ = std::move(now_body);
  }

  void write_frame() const {
    const int number = static_cast<int>(run_.frames.size()) - 1;
    const auto folder = config_.out / "frames";
    std::filesystem::create_directories(folder);
    constexpr int digits = 5;
    write_ply(numbered(folder, "cloth", number, digits, ".ply"), simulation_.state().x, triangles_);
    if (!body_triangles_.empty() && (number == 0 || simulation_.bodies_move()))
      write_ply(numbered(folder, "bodies", number, digits, ".ply"), simulation_.body_positions(),
                body_triangles_);
  }

  JudgedRun& run_;
  const JudgedRunConfig& config_;
  Simulation& simulation_;
  std::vector<Triangle> triangles_, body_triangles_;
  TriangleMesh last_, last_body_;
  double start_energy_ = 0.0, most_energy_ = 0.0, least_height_ = 0.0;
  std::clock_t begin_ = std::clock();
};

void simulate(JudgedRun& run, const JudgedRunConfig& config, const Methods& methods) {
  BuiltScene built = build_scene(run.scene, methods);
  run.cloth = built.cloth;
  run.piece_begin = built.piece_begin;
  run.warnings = built.warnings;
  Simulation simulation(run.scene, std::move(built), methods);
  Watch watch(run, config, simulation);
  watch.frame();
  try {
    for (int frame = 1; frame <= run.scene.time.frames; ++frame) {
      simulation.advance_to_frame(frame, [&](double) { watch.step(); });
      watch.frame();
    }
  } catch (const TooLong& late) {
    run.in_time = false;
    run.stopped = late.what();
  } catch (const std::runtime_error& error) {
    run.stopped = error.what();
  }
  watch.finish();
}

}  // namespace

namespace {

void take(const TriedMethod& method, const Methods& methods, Scene& scene) {
  if (method.name.empty()) return;
  if (method.key == "contact.response") {
    scene.contact.response = method.name;
    scene.contact.response_options = {};
  } else if (method.key == "solver.integrator") {
    scene.solver.integrator = method.name;
    scene.solver.integrator_options = {};
  } else {
    scene.solver.limiter = method.name;
    scene.solver.limiter_options = {};
    scene.solver.strain_limiter =
        methods.strain_limiters.at(method.name).traits().kind != LimiterKind::none;
  }
}

}  // namespace

std::span<const Vec3> JudgedRun::piece(std::size_t frame, std::size_t piece) const {
  const auto first = static_cast<std::size_t>(piece_begin[piece]);
  return std::span(frames.at(frame))
      .subspan(first, static_cast<std::size_t>(piece_begin[piece + 1]) - first);
}

JudgedRun run_judged(const Scene& scene, const JudgedRunConfig& config, const Methods& methods) {
  JudgedRun run;
  run.scene = scene;
  take(config.method, methods, run.scene);
  try {
    simulate(run, config, methods);
  } catch (const std::invalid_argument& error) {
    run.refused = error.what();
  }
  return run;
}

JudgedRun run_judged(const std::filesystem::path& file, const JudgedRunConfig& config,
                     const Methods& methods) {
  try {
    const Scene scene = read_scene(file, config.overrides, methods);
    JudgedRun run = run_judged(scene, config, methods);
    if (!config.out.empty()) {
      std::filesystem::create_directories(config.out);
      std::filesystem::remove(config.out / "scene.json");
      std::ofstream(config.out / "scene.json") << scene.json;
    }
    return run;
  } catch (const std::invalid_argument& error) {
    JudgedRun run;
    run.refused = error.what();
    return run;
  }
}

}  // namespace selvedge::detail
