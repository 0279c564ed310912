// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/run/internal/replay.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/methods.h>
#include <selvedge/simulation/internal/explain_step.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include <selvedge/scene/methods.h>

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct ReplayOptions {
  std::string first, second;
  bool explain = false, json = false;
};

void print_json(const Json& json) { print_document(json); }

// -- a repeated step ------------------------------------------------------------------------------

/// The folder itself, or the bundle in it if it is a result folder.
fs::path bundle_of(const fs::path& folder) {
  std::error_code error;
  const fs::path inner = folder / "failure";
  return fs::exists(inner / "failure.json", error) ? inner : folder;
}

const char* outcome(const StepReplay& replay, const FailureBundle& bundle) {
  if (!replay.failure)
    return bundle.kind == FailureKind::out_of_budget
               ? "the step passes, as expected: the run was only out of budget"
               : "the step passes now";
  if (replay.as_recorded) return "fails again: same cause, same attempts";
  return replay.failure == bundle.kind ? "fails again, but with another message or other attempts"
                                       : "fails in another way";
}

Json vector_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

Json culprit_json(const Culprit& c, const VertexNames& names) {
  Json loads = Json::array();
  for (const Load& l : c.loads) loads.push_back({{"name", l.name}, {"force_n", l.force}});
  return {{"kind", c.kind},       {"sentence", c.sentence},
          {"names", c.names},     {"vertex", c.vertex < 0 ? Json() : Json(names.vertex(c.vertex))},
          {"motion_m", c.motion}, {"room_m", c.room},
          {"loads", loads}};
}

Json pair_json(const PairExplanation& p) {
  Json stages = Json::array();
  for (const PairStage& s : p.stages)
    stages.push_back(
        {{"stage", s.stage}, {"gap_m", s.gap}, {"collides", s.collides}, {"moved_m", s.moved}});
  return {{"pair", p.name},
          {"gap_t0_m", p.pair.gap},
          {"rest_gap_m", p.pair.rest_gap},
          {"normal", vector_json(p.pair.normal)},
          {"brought_by", p.brought_by},
          {"stages", stages}};
}

Json explanation_json(const Explanation& explanation, const VertexNames& names) {
  Json culprits = Json::array(), pairs = Json::array();
  for (const Culprit& c : explanation.culprits) culprits.push_back(culprit_json(c, names));
  for (const PairExplanation& p : explanation.pairs) pairs.push_back(pair_json(p));
  return {{"try_s", explanation.h},
          {"colliding_pairs", explanation.colliding_pairs},
          {"culprits", culprits},
          {"pairs", pairs}};
}

bool does_something(const PairStage& s) {
  return std::any_of(s.moved.begin(), s.moved.end(), [](double m) { return m != 0.0; });
}

void print_pair(const PairExplanation& p) {
  constexpr double micro = 1e6;
  print_escaped("\n{}\n  {:.4g} um apart at the start of the step; {}\n", p.name,
                micro * p.pair.gap,
                p.brought_by.empty() ? "no single stage causes the collision"
                                     : "it collides since: " + p.brought_by);
  print_escaped("  {:<26} {:>12} {:>9}   {}\n", "stage", "end gap um", "collides",
                "moved by the stage, um");
  for (const PairStage& s : p.stages)
    if (does_something(s))
      print_escaped("  {:<26} {:>12.4g} {:>9}   {:.4g}, {:.4g}, {:.4g}, {:.4g}\n", s.stage,
                    micro * s.gap, s.collides ? "yes" : "no", micro * s.moved[0],
                    micro * s.moved[1], micro * s.moved[2], micro * s.moved[3]);
}

void print_culprit(const Culprit& c) {
  print_escaped("- {}.\n", c.sentence);
  if (c.loads.empty()) return;
  print_escaped("  On that vertex:");
  for (std::size_t i = 0; i < c.loads.size(); ++i)
    print_escaped("{} {} with {:.3g} N", i == 0 ? "" : ",", c.loads[i].name, c.loads[i].force);
  print_escaped(".\n");
}

void print_explanation(const Explanation& explanation) {
  constexpr std::size_t printed_pairs = 3;  // --json has more
  print_escaped("\nCauses, in an attempt of {:.4g} ms:\n", 1e3 * explanation.h);
  for (const Culprit& c : explanation.culprits) print_culprit(c);
  const std::size_t shown = std::min(printed_pairs, explanation.pairs.size());
  for (std::size_t i = 0; i < shown; ++i) print_pair(explanation.pairs[i]);
  if (const auto more = explanation.colliding_pairs - shown; more > 0)
    print_escaped("\n{} more pairs collide; queries/ and frames/ of the bundle have all of them\n",
                  more);
}

int replay_bundle(const ReplayOptions& options) {
  const FailureBundle bundle = read_failure_bundle(bundle_of(options.first));
  if (!bundle.scene_from_file)
    throw std::invalid_argument(
        bundle.folder.string() +
        ": its scene was made in code; call replay_step in the program that made it");
  const Methods methods = methods_of_this_build();
  const Scene scene = read_scene(bundle.folder / "scene.json", {}, methods);
  Simulation simulation(scene, build_scene(scene, methods), bundle.state, methods);
  StepRecording recording;
  if (options.explain) simulation.set_trace(&recording.trace());
  const StepReplay replay = replay_step(simulation, scene, bundle);
  std::optional<Explanation> explanation;
  if (options.explain && replay.failure)
    explanation = explain_step(
        scene, simulation,
        replay.failure == FailureKind::stalled ? recording.last_but_one() : recording.last());
  const std::string hash = state_hash(bundle.state);
  if (options.json) {
    Json json = {{"bundle", bundle.folder.string()},
                 {"recorded", {{"kind", failure_name(bundle.kind)}, {"cause", bundle.cause}}},
                 {"time", bundle.state.time},
                 {"step", bundle.state.step},
                 {"state_hash", hash},
                 {"attempts_s", replay.attempts},
                 {"passes", !replay.failure},
                 {"kind", replay.failure ? failure_name(*replay.failure) : ""},
                 {"cause", replay.cause},
                 {"as_recorded", replay.as_recorded}};
    if (explanation) json["explanation"] = explanation_json(*explanation, simulation.names());
    print_json(json);
  } else {
    print_escaped("recorded  {}\n", bundle.cause);
    print_escaped("state     after step {}, at {} s, hash {}, restored exactly\n",
                  bundle.state.step, bundle.state.time, hash);
    print_escaped("attempts  {}, from {} s to {} s\n", replay.attempts.size(),
                  replay.attempts.front(), replay.attempts.back());
    if (replay.failure && !replay.as_recorded) print_escaped("now       {}\n", replay.cause);
    print_escaped("outcome   {}\n", outcome(replay, bundle));
    if (explanation) print_explanation(*explanation);
  }
  return replay.failure ? 1 : 0;
}

// -- two runs -------------------------------------------------------------------------------------

/// The name of the vertex if the scene of the run can still be read, else its index.
std::string vertex_name(const RunDifference& d, const fs::path& result) {
  const std::string plain = fmt::format("vertex {} of the {}", d.vertex, d.surface);
  try {
    const Scene scene = read_scene(result / "scene.json", {}, methods_of_this_build());
    const BuiltScene built = build_scene(scene);
    const std::int32_t first = d.surface == "cloth" ? 0 : built.piece_begin.back();
    return VertexNames(scene, built).vertex(first + d.vertex);
  } catch (const std::invalid_argument&) {  // made in code, or its meshes are gone
    return plain;
  }
}

std::string difference_sentence(const RunDifference& d, const std::string& name) {
  const char* state = d.every_step ? "step" : "frame";
  if (d.differ && !d.structure.empty())
    return fmt::format("they differ from {} {} on: {}", state, d.number, d.structure);
  if (d.differ)
    return fmt::format(
        "they differ from {} {} on, first at {}: ({}, {}, {}) m and ({}, {}, {}) m; {} vertices "
        "differ, by up to {:.3g} m and {:.3g} m/s",
        state, d.number, name, d.x_a.x(), d.x_a.y(), d.x_a.z(), d.x_b.x(), d.x_b.y(), d.x_b.z(),
        d.vertices, d.distance, d.speed);
  if (d.states_a != d.states_b)
    return fmt::format(
        "one run is longer, otherwise they agree: {} and {} {}s, of which {} are the same to the "
        "bit",
        d.states_a, d.states_b, state, d.compared);
  return fmt::format("the same to the bit: {} {}s", d.compared, state);
}

int compare_runs(const ReplayOptions& options) {
  const RunDifference d = find_difference(options.first, options.second);
  const std::string name =
      d.differ && d.vertex >= 0 ? vertex_name(d, options.first) : std::string();
  const bool same = !d.differ && d.states_a == d.states_b;
  if (!options.json) {
    print_escaped("{}\n", difference_sentence(d, name));
    if (!d.every_step && d.differ) print_escaped("run both with --every-step to find the step\n");
    return same ? 0 : 1;
  }
  Json json = {{"same", same},
               {"states", d.every_step ? "steps" : "frames"},
               {"states_a", d.states_a},
               {"states_b", d.states_b},
               {"compared", d.compared}};
  if (d.differ) {
    json["first"] = {{"number", d.number}, {"surface", d.surface}, {"structure", d.structure}};
    if (d.vertex >= 0)
      json["first"].update({{"vertex", d.vertex},
                            {"name", name},
                            {"x_a", vector_json(d.x_a)},
                            {"x_b", vector_json(d.x_b)},
                            {"vertices", d.vertices},
                            {"distance_m", d.distance},
                            {"speed_m_s", d.speed}});
  }
  print_json(json);
  return same ? 0 : 1;
}

void add_replay_options(const Command& command) {
  const auto options = std::make_shared<ReplayOptions>();
  command
      .option("result", options->first,
              "Failure bundle, or the result folder of a run that left one")
      .required();
  const Command::Option second =
      command.option("other", options->second,
                     "A second result folder, to find the first step at which the two differ");
  command
      .flag("--explain", options->explain,
            "Explain which forces and stages of the step caused the collisions")
      .excludes(second);
  command.flag("--json", options->json, "Print JSON");
  command.action([options] {
    return options->second.empty() ? replay_bundle(*options) : compare_runs(*options);
  });
}

}  // namespace

selvedge::ProgramCommand replay_command() {
  return {
      .name = "replay",
      .purpose = "Repeat the step at which a run stopped, or find the first difference of two runs",
      .add_options = add_replay_options};
}
