// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/heartbeat.h>
#include <selvedge/apps/detail/method_choice.h>
#include <selvedge/apps/detail/output_file.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/compare/compare_plan.h>
#include <selvedge/compare/internal/stability.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/solver/strain_limiter.h>
#include <selvedge/core/system/internal/files.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include <selvedge/scene/methods.h>
#include "command_stability_cases.h"
#include "overrides.h"

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;

struct StabilityOptions {
  std::string scene, map;
  std::vector<std::string> set, integrator{"all"};
  std::string stiffness = "0", mass_ratio = "1", damping = "-1";
  StabilityConfig config;
  int threads = 1;
  bool json = false;
  CaseOptions cases;
};

constexpr const char* kMapSteps = "1e-5..0.1:9log";  // s

constexpr const char* kOfScene = "For a scene: the largest stable steps of its cloth";
constexpr const char* kOfFolder = "For a folder: how each scene ends, judged exactly";

/// Lists and ranges as --vary has them.
std::vector<double> numbers(const std::string& option, const std::string& text) {
  std::vector<double> values;
  const std::vector<CompareAxis> axes = read_axes({"dt=" + text}, Methods{});
  for (const std::string& value : axes.at(0).values) {
    char* end = nullptr;
    values.push_back(std::strtod(value.c_str(), &end));
    if (*end != 0 || !std::isfinite(values.back()))
      throw std::invalid_argument(option + " " + text + ": " + value + " is not a number");
  }
  return values;
}

std::vector<StabilityRow> measure(const StabilityOptions& o, const Scene& scene,
                                  const std::vector<std::string>& names) {
  std::vector<StabilityRow> rows;
  Heartbeat heartbeat("stability");
  for (const double stiffness : numbers("--stiffness", o.stiffness))
    for (const double ratio : numbers("--mass-ratio", o.mass_ratio))
      for (const double damping : numbers("--damping", o.damping)) {
        const StabilitySubject subject(scene, stiffness, ratio, damping);
        for (const std::string& name : names) {
          heartbeat.now(fmt::format("row {}, {}", rows.size() + 1, name));
          rows.push_back(largest_stable_step(name, subject, o.config));
          rows.back().stiffness = stiffness;
          rows.back().mass_ratio = ratio;
          rows.back().damping = damping;
        }
      }
  return rows;
}

/// Whether the step that the program would take was stable in the trial.
const char* verdict(const StabilityRow& row, bool swings) {
  if (swings) return "swings";
  if (row.bound == 0.0) return "no step is safe for ever";
  if (row.rejects_longer) return "divides longer steps";
  return row.measured >= row.bound * (1.0 - 0.01) ? "bound holds" : "BOUND BROKEN";
}

void print_rows(const std::vector<StabilityRow>& rows, double longest, bool swings) {
  print_escaped("{:<30}{:>10}{:>8}{:>9}{:>12}{:>12}{:>12}{:>8}{:>9}  \n", "", "N/m", "mass",
                "damping", "kept s", "predicted s", "measured s", "meas/pr", "energy");
  const auto step = [&](double h) { return h >= longest ? "any" : fmt::format("{:.3e}", h); };
  const auto own = [](double value, double none) {
    return value == none ? std::string("scene") : fmt::format("{:g}", value);
  };
  for (const StabilityRow& r : rows)
    print_escaped("{:<30}{:>10}{:>8g}{:>9}{:>12}{:>12}{:>12}{:>8}{:>9.2g}  {}\n", r.integrator,
                  own(r.stiffness, 0.0), r.mass_ratio, own(r.damping, -1.0), step(r.bound),
                  step(r.predicted), step(r.measured),
                  r.predicted > 0.0 ? fmt::format("{:.3f}", r.measured / r.predicted) : "-",
                  r.energy_ratio, verdict(r, swings));
}

Json to_json(const std::vector<StabilityRow>& rows, bool swings) {
  Json list = Json::array();
  for (const StabilityRow& r : rows)
    list.push_back({{"integrator", r.integrator},
                    {"stiffness", r.stiffness},
                    {"mass_ratio", r.mass_ratio},
                    {"damping", r.damping},
                    {"any_step", r.any_step},
                    {"bound_s", r.bound},
                    {"predicted_s", r.predicted},
                    {"measured_s", r.measured},
                    {"energy_ratio", r.energy_ratio},
                    {"verdict", verdict(r, swings)}});
  return {{"results", list}};
}

void write_maps(const StabilityOptions& o, const Scene& scene,
                const std::vector<std::string>& names) {
  const auto stiffness = numbers("--stiffness", o.stiffness);
  const auto steps = numbers("--map", kMapSteps);
  std::vector<StabilityMap> maps;
  Heartbeat heartbeat("stability");
  for (const std::string& name : names) {
    heartbeat.now("map of " + name);
    maps.push_back(map_stability(name, scene, stiffness, steps, o.config));
  }
  AtomicFile file(o.map);
  file.write(draw_maps(maps));
  file.commit();
}

int run_command(const StabilityOptions& o) {
  if (!o.map.empty()) refuse_other_kind(o.map, kSvgPicture, "--map");
  const Scene scene = read_scene(o.scene, read_overrides(o.set), methods_of_this_build());
  const auto names = choose_methods(o.integrator, integrators(), "--integrator").names;
  if (!o.config.limiter.empty() &&
      choose_methods({o.config.limiter}, strain_limiters(), "--strain-limiter").all)
    throw std::invalid_argument("--strain-limiter all: takes one name");
  const ThreadLimit limit(o.threads);
  const auto rows = measure(o, scene, names);
  const bool swings = !o.config.limiter.empty();
  if (o.json)
    print_document(to_json(rows, swings));
  else
    print_rows(rows, o.config.longest, swings);
  if (!o.map.empty()) write_maps(o, scene, names);
  for (const StabilityRow& row : rows)
    if (std::string(verdict(row, swings)) == "BOUND BROKEN") return 1;
  return 0;
}

struct OptionGroups {
  Command of_scene, of_folder;
};

/// Options of the other kind of run are a mistake.
void refuse_options(const Command& group, const std::string& why) {
  for (const Command::Option& option : group.options())
    if (option.given()) throw std::invalid_argument(option.name() + ": " + why);
}

int run_folder_or_scene(const OptionGroups& groups, StabilityOptions& o) {
  if (!std::filesystem::is_directory(o.scene)) {
    refuse_options(groups.of_folder, o.scene + " is not a folder of scenes");
    o.threads = groups.of_scene.threads().value_or(1);
    return run_command(o);
  }
  refuse_options(groups.of_scene, o.scene + " is a folder; name a scene file for this option");
  o.cases.data = o.scene;
  o.cases.json = o.json;
  o.cases.threads = groups.of_folder.threads().value_or(0);
  return run_cases(o.cases);
}

OptionGroups add_options(const Command& command, StabilityOptions& o) {
  command
      .option("scene", o.scene,
              "Scene file (JSON), of which the cloth and its handles are used; or a "
              "folder of scenes, such as data/extreme")
      .required();
  const Command of_scene = command.group(kOfScene), of_folder = command.group(kOfFolder);
  of_scene.option("--integrator", o.integrator, "Names, separated by commas, or all (the default)")
      .comma_separated()
      .one_word();
  of_scene.option("--stiffness", o.stiffness,
                  "N/m of the stiffest spring: a,b or \"lo..hi:n log\"; 0: as in the scene");
  of_scene.option("--mass-ratio", o.mass_ratio,
                  "Mass of one particle over that of the others: a list or range as for "
                  "--stiffness");
  of_scene.option("--damping", o.damping,
                  "Damping of the springs, s: a list or range; -1: as in the scene");
  of_scene.option("--map", o.map, "Draw a map of stability, stiffness by step, into this SVG file");
  of_scene.option("--steps", o.config.steps, "Largest number of steps of a trial (default 2000)")
      .range(10, 100'000'000);
  of_scene
      .option("--seconds", o.config.seconds, "Longest simulated time of a trial, s (default 10)")
      .positive();
  of_scene.option("--strain-limiter", o.config.limiter,
                  "The cloth swings under gravity with this limiter, or with \"none\", instead "
                  "of starting at small velocities");
  of_scene
      .option("--sweeps", o.config.max_sweeps,
              "Largest number of sweeps of the limiter in a step (default 50)")
      .range(1, 100'000);
  of_scene
      .option("--precision", o.config.precision,
              "Relative precision of the measured step (default 0.01)")
      .range(1e-4, 1.0);
  of_scene.option("--set", o.set, "path=value replaces a value of the scene file").one_word();
  command.flag("--json", o.json, "Print JSON");
  add_case_options(of_folder, o.cases);
  command.footer(
      "Small initial velocities excite every mode of the cloth, without gravity, contact or\n"
      "strain limit. A step is stable if the energy stays within ten times the initial\n"
      "energy. With --strain-limiter the cloth swings under gravity: a step is stable if\n"
      "the energy stays within ten times that of a fall through the diagonal of the cloth,\n"
      "and the bound is not checked.\n"
      "kept: the step that a run would use, by Gershgorin's bound; predicted: by the\n"
      "largest eigenvalue; measured: by bisection.\n"
      "A scene of a folder ends as correct (finished, no crossing in any frame or on any\n"
      "path, within its limits), refused with a reason, degraded with a flag, FAILED, or\n"
      "unfinished: clean until its time ran out.\n"
      "Exit code: 0 every bound holds and no scene FAILED, 1 otherwise, 2 bad input.");
  return {of_scene, of_folder};
}

void add_stability_options(const Command& command) {
  const auto o = std::make_shared<StabilityOptions>();
  const OptionGroups groups = add_options(command, *o);
  command.action([o, groups] { return run_folder_or_scene(groups, *o); });
}

}  // namespace

selvedge::ProgramCommand stability_command() {
  return {
      .name = "stability",
      .purpose =
          "Find the largest stable step of each integrator; judge how the scenes of a folder end",
      .add_options = add_stability_options};
}
