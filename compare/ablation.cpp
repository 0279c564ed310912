// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/compare/detail/compare_error.h>
#include <selvedge/compare/internal/ablation.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

double rms_strain(const ClothEnds& cloth) {
  double squares = 0.0;
  const std::vector<Edge> edges = unique_edges(cloth.triangles);
  for (const Edge& e : edges) {
    const double before = (cloth.start[e[1]] - cloth.start[e[0]]).norm();
    const double strain = (cloth.end[e[1]] - cloth.end[e[0]]).norm() / before - 1.0;
    squares += strain * strain;
  }
  return edges.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(edges.size()));
}

Vec3 unit_normal(const Triangle& t, const std::vector<Vec3>& x) {
  return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).normalized();
}

/// Mean angle between triangles that share an edge, rad. The triangles must be consistently
/// oriented.
double mean_angle(const ClothEnds& cloth) {
  std::map<Edge, std::int32_t> first;
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < cloth.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = cloth.triangles[i][k], b = cloth.triangles[i][(k + 1) % 3];
      const auto [other, is_new] =
          first.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<std::int32_t>(i));
      if (is_new) continue;
      const Vec3 m = unit_normal(cloth.triangles[i], cloth.end);
      const Vec3 n = unit_normal(cloth.triangles[other->second], cloth.end);
      sum += std::atan2(m.cross(n).norm(), m.dot(n));
      count += 1.0;
    }
  return count == 0.0 ? 0.0 : sum / count;
}

using Measures = std::map<std::string, double>;

/// s; runs of milliseconds may take longer than `patience` allows.
constexpr double kLeastPatience = 0.2;

/// The measure whose interval reaches farthest from zero.
void judge_shapes(const std::vector<Measures>& whole, const std::vector<Measures>& without,
                  double tolerance, AblationRow& row) {
  const auto reach = [](const Equivalence& e) { return std::max(-e.low, e.high); };
  for (const auto& [name, value] : whole.front()) {
    std::vector<double> differences;
    for (std::size_t s = 0; s < without.size(); ++s)
      differences.push_back(without[s].at(name) - whole[s].at(name));
    const Equivalence e = test_equivalence(differences, tolerance);
    const auto rank = [](const Equivalence& of) {  // a proven difference ranks worst
      return of.verdict == EquivalenceVerdict::different ? 1 : 0;
    };
    if (row.worst.empty() ||
        std::pair(rank(e), reach(e)) > std::pair(rank(row.equivalence), reach(row.equivalence))) {
      row.worst = name;
      row.equivalence = e;
    }
  }
}

double mean_distance(const std::vector<ClothEnds>& a, const std::vector<ClothEnds>& b,
                     std::size_t shift) {
  double sum = 0.0;
  const std::size_t count = std::min(a.size(), b.size());
  for (std::size_t s = 0; s < count; ++s) sum += detail::distance(a[s], b[(s + shift) % count]);
  return count == 0 ? 0.0 : sum / static_cast<double>(count);
}

/// The runs of all seeds of one scene.
struct Ensemble {
  std::vector<ClothEnds> cloths;
  std::vector<Measures> measures;
  std::vector<double> seconds;

  void add(TimedRun run) {
    measures.push_back(shape_measures(run.cloth));
    cloths.push_back(std::move(run.cloth));
    seconds.push_back(run.seconds);
  }
};

/// Name of the response that does nothing; no scene file can select it.
constexpr const char* kNoResponse = "none";

/// Leaves every contact to the fail-safe.
class NoResponse final : public Response {
 public:
  void begin(const ResponseStep&) override {}
  void add(std::span<const ContactPoint>) override {}
  ResponseTraits traits() const override { return {.promise = "does nothing", .source = ""}; }
};

Methods with_no_response(Methods methods) {
  methods.responses.add(kNoResponse, {},
                        [](const MethodOptions&) { return std::make_unique<NoResponse>(); });
  return methods;
}

/// A scene without one part, over the seeds.
struct Variant {
  OptionalPart part{};
  Ensemble runs{};
  std::string fault{};  ///< of the first seed that has one, which is the last to run
  int crossings = 0;
  bool same_bits = true;

  void add(TimedRun run, const RunResult& whole) {
    fault = run.fault;
    if (!run.fault.empty()) return;
    if (!run.result.clean) fault = "cloth passes through something";
    crossings = std::max(
        {crossings, run.result.worst_self_intersections, run.result.worst_body_intersections});
    same_bits = same_bits && run.result.state_hash == whole.state_hash;
    runs.add(std::move(run));
  }
};

Scene scene_without(const OptionalPart& part, const std::filesystem::path& file,
                    std::vector<Override> overrides, const Methods& methods) {
  overrides.insert(overrides.end(), part.overrides.begin(), part.overrides.end());
  Scene scene = read_scene(file, overrides, methods);
  if (part.part != "response") return scene;
  scene.contact.response = kNoResponse;
  scene.contact.response_options = {};
  return scene;
}

double seconds_since(std::clock_t begin) {
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

/// Steps to the end of the scene; returns why it stopped before, or "".
std::string advance(Simulation& simulation, int frames, const TimedRunConfig& config,
                    std::clock_t begin) {
  try {
    while (simulation.step_towards(frames)) {
      if (config.check_frames && simulation.is_at_frame()) simulation.verify_frame();
      if (seconds_since(begin) > config.longest)
        return fmt::format("stopped at {:.3g} s after {:.3g} s of the processor", simulation.time(),
                           config.longest);
    }
  } catch (const SimulationFailed& error) {
    return error.what();
  }
  return {};
}

AblationRow judge(const Variant& variant, const Ensemble& whole, const AblationConfig& config) {
  const Ensemble& without = variant.runs;
  AblationRow row;
  row.part = variant.part.part;
  row.only_measured = variant.part.only_measured;
  row.clean = variant.fault.empty();
  row.why = variant.fault;
  if (without.cloths.empty()) return row;
  row.crossings = variant.crossings;
  row.same_bits = variant.same_bits;
  judge_shapes(whole.measures, without.measures, config.tolerance, row);
  row.distance = mean_distance(without.cloths, whole.cloths, 0);
  row.spread = mean_distance(whole.cloths, whole.cloths, 1);
  std::vector<double> ratios;
  for (std::size_t s = 0; s < without.seconds.size(); ++s)
    ratios.push_back(without.seconds[s] / whole.seconds[s]);
  row.time_ratio = quartiles(ratios);
  return row;
}

}  // namespace

TimedRun run_timed(Scene scene, const Methods& methods, const TimedRunConfig& config) {
  if (config.seed > 0) scene.perturbation = {kSeedSpeed, config.seed};
  Simulation simulation(scene, build_scene(scene), methods);
  TimedRun run;
  const std::clock_t begin = std::clock();
  run.fault = advance(simulation, scene.time.frames, config, begin);
  run.seconds = seconds_since(begin);
  if (!config.check_frames && run.fault.empty()) simulation.verify_frame();
  run.result = simulation.result();
  const auto triangles = simulation.cloth_triangles();
  run.cloth = {simulation.built().cloth.surface.vertices,
               simulation.state().x,
               {triangles.begin(), triangles.end()}};
  return run;
}

std::map<std::string, double> shape_measures(const ClothEnds& cloth) {
  const double extent = cloth.extent();
  Vec3 low = cloth.end.front(), high = low, mean = Vec3::Zero();
  for (const Vec3& x : cloth.end) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
    mean += x / static_cast<double>(cloth.end.size());
  }
  Measures m;
  constexpr std::array<const char*, 3> axes = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) {
    m[std::string("mean ") + axes[k]] = mean[k] / extent;
    m[std::string("width along ") + axes[k]] = (high - low)[k] / extent;
  }
  m["rms strain"] = rms_strain(cloth);
  m["mean angle"] = mean_angle(cloth) / std::numbers::pi;
  return m;
}

bool AblationRow::saves_time() const {
  return 1.0 - time_ratio.median > 2.0 * (time_ratio.high - time_ratio.low);
}

std::string AblationRow::verdict() const {
  if (could_go()) return saves_time() ? "could go" : "could go, and saves nothing that shows";
  if (!clean || equivalence.verdict == EquivalenceVerdict::different) return "needed";
  return "not decided";
}

std::vector<AblationRow> ablate(const std::filesystem::path& scene,
                                const std::vector<Override>& overrides, const Methods& methods,
                                const AblationConfig& config) {
  const Methods known = with_no_response(methods);
  const Scene as_it_is = read_scene(scene, overrides, known);
  std::vector<Variant> variants;
  for (OptionalPart& part : optional_parts(as_it_is)) variants.push_back({std::move(part)});
  Ensemble whole;
  for (int s = 1; s <= config.seeds; ++s) {  // interleaved: a disturbance affects all variants
    const auto seed = static_cast<std::uint32_t>(s);
    TimedRun run = run_timed(as_it_is, known, {.seed = seed});
    if (!run.fault.empty())
      throw std::runtime_error("the scene as it is does not come to its end: " + run.fault);
    const double longest = config.patience * run.seconds + kLeastPatience;
    for (Variant& v : variants) {
      if (!v.fault.empty()) continue;
      try {
        v.add(run_timed(scene_without(v.part, scene, overrides, known), known,
                        {seed, v.part.part != "frame_check", longest}),
              run.result);
      } catch (const std::invalid_argument& refusal) {
        v.fault = std::string("refused without it: ") + refusal.what();
      }
    }
    whole.add(std::move(run));
  }
  std::vector<AblationRow> rows;
  for (const Variant& v : variants) rows.push_back(judge(v, whole, config));
  return rows;
}

}  // namespace selvedge
