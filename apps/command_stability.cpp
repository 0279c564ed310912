// SPDX-License-Identifier: MIT
#include "command_stability.h"

#include <fmt/format.h>
#include <selvedge/apps/compare_axes.h>
#include <selvedge/apps/detail/method_choice.h>
#include <selvedge/apps/stability.h>
#include <selvedge/core/atomic_file.h>
#include <selvedge/core/parallel.h>
#include <selvedge/core/strain_limiter.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "command_stability_cases.h"
#include "methods.h"
#include "overrides.h"

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;

struct StabilityOptions {
  std::string scene, map;
  std::vector<std::string> set, integrator{"all"};
  std::string stiffness = "0", mass_ratio = "1", damping = "-1", step = "1e-5..0.1:9log";
  StabilityConfig config;
  int threads = 1;
  bool json = false;
  CaseOptions cases;
};

constexpr const char* kOfScene = "For a scene: the largest stable steps of its cloth";
constexpr const char* kOfFolder = "For a folder: cases that are judged";

/// Lists and ranges as --vary has them.
std::vector<double> numbers(const std::string& option, const std::string& text) {
  std::vector<double> values;
  const std::vector<CompareAxis> axes = read_axes({"dt=" + text}, Methods{});
  for (const std::string& value : axes.at(0).values) {
    char* end = nullptr;
    values.push_back(std::strtod(value.c_str(), &end));
    if (*end != 0 || !std::isfinite(values.back()))
      throw std::invalid_argument(option + " " + text + ": " + value + " is no number");
  }
  return values;
}

std::vector<StabilityRow> measure(const StabilityOptions& o, const Scene& scene,
                                  const std::vector<std::string>& names) {
  std::vector<StabilityRow> rows;
  for (const double stiffness : numbers("--stiffness", o.stiffness))
    for (const double ratio : numbers("--mass-ratio", o.mass_ratio))
      for (const double damping : numbers("--damping", o.damping)) {
        const StabilitySubject subject(scene, stiffness, ratio, damping);
        for (const std::string& name : names) {
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
  return row.measured >= row.bound * (1.0 - 0.01) ? "bound holds" : "BOUND BROKEN";
}

void print_rows(const std::vector<StabilityRow>& rows, double longest, bool swings) {
  fmt::print("{:<30}{:>10}{:>8}{:>9}{:>12}{:>12}{:>12}{:>8}{:>9}  \n", "", "N/m", "mass", "damping",
             "kept s", "predicted s", "measured s", "meas/pr", "energy");
  const auto step = [&](double h) { return h >= longest ? "any" : fmt::format("{:.3e}", h); };
  const auto own = [](double value, double none) {
    return value == none ? std::string("scene") : fmt::format("{:g}", value);
  };
  for (const StabilityRow& r : rows)
    fmt::print("{:<30}{:>10}{:>8g}{:>9}{:>12}{:>12}{:>12}{:>8}{:>9.2g}  {}\n", r.integrator,
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
  const auto stiffness = numbers("--stiffness", o.stiffness), step = numbers("--step", o.step);
  std::vector<StabilityMap> maps;
  for (const std::string& name : names)
    maps.push_back(map_stability(name, scene, stiffness, step, o.config));
  AtomicFile file(o.map);
  file.write(draw_maps(maps));
  file.commit();
}

int run_command(const StabilityOptions& o) {
  const Scene scene = read_scene(o.scene, read_overrides(o.set), methods_of_this_build());
  const auto names = choose_methods(o.integrator, integrators(), "--integrator").names;
  if (!o.config.limiter.empty() &&
      choose_methods({o.config.limiter}, strain_limiters(), "--strain-limiter").all)
    throw std::invalid_argument("--strain-limiter all: takes one name");
  const ThreadLimit limit(o.threads);
  const auto rows = measure(o, scene, names);
  const bool swings = !o.config.limiter.empty();
  if (o.json)
    fmt::print("{}\n", to_json(rows, swings).dump(2));
  else
    print_rows(rows, o.config.longest, swings);
  if (!o.map.empty()) write_maps(o, scene, names);
  for (const StabilityRow& row : rows)
    if (std::string(verdict(row, swings)) == "BOUND BROKEN") return 1;
  return 0;
}

/// Options of the other kind of run are a mistake.
void refuse_options(const CLI::App& command, const char* group, const std::string& why) {
  for (const CLI::Option* option : command.get_option_group(group)->get_options())
    if (option->count() > 0) throw std::invalid_argument(option->get_name() + ": " + why);
}

int run_folder_or_scene(const CLI::App& command, StabilityOptions& o) {
  if (!std::filesystem::is_directory(o.scene)) {
    refuse_options(command, kOfFolder, o.scene + " is no folder of cases, such as data/extreme");
    return run_command(o);
  }
  refuse_options(command, kOfScene, o.scene + " is a folder; name a scene file for this option");
  o.cases.data = o.scene;
  o.cases.json = o.json;
  if (command.count("--threads") > 0) o.cases.threads = o.threads;
  return run_cases(o.cases);
}

void add_options(CLI::App& command, StabilityOptions& o) {
  command
      .add_option("scene", o.scene,
                  "Scene file (JSON), whose cloth and handles are taken; or the folder of the "
                  "extreme cases, data/extreme")
      ->required();
  CLI::App& of_scene = *command.add_option_group(kOfScene);
  of_scene
      .add_option("--integrator", o.integrator, "Names, parted by commas, or all (the default)")
      ->delimiter(',')
      ->allow_extra_args(false);
  of_scene.add_option("--stiffness", o.stiffness,
                      "N/m of the stiffest spring: a,b or \"lo..hi:n log\"; 0: as in the scene");
  of_scene.add_option("--mass-ratio", o.mass_ratio, "Of one particle to the others, the same way");
  of_scene.add_option("--damping", o.damping, "Of the springs, s; -1: as in the scene");
  of_scene.add_option("--map", o.map, "Draws a map, stiffness by step, into this SVG file");
  of_scene.add_option("--step", o.step, "Steps of the map, s (default 1e-5..0.1:9log)");
  of_scene.add_option("--steps", o.config.steps, "Steps of a trial at most (default 2000)")
      ->check(CLI::Range(10, 100'000'000));
  of_scene.add_option("--seconds", o.config.seconds, "Simulated seconds at most (default 10)")
      ->check(CLI::PositiveNumber);
  of_scene.add_option("--strain-limiter", o.config.limiter,
                      "The cloth swings under gravity with this limiter, or with \"none\", instead "
                      "of being kicked");
  of_scene.add_option("--sweeps", o.config.max_sweeps, "Of the limiter in a step (default 50)")
      ->check(CLI::Range(1, 100'000));
  of_scene
      .add_option("--precision", o.config.precision,
                  "Relative, of the measured step (default 0.01)")
      ->check(CLI::Range(1e-4, 1.0));
  of_scene.add_option("--set", o.set, "path=value replaces a value of the scene file")
      ->allow_extra_args(false);
  command.add_option("--threads", o.threads, "Threads (default 1; of cases, no limit); 0: all")
      ->check(CLI::Range(0, 1024));
  command.add_flag("--json", o.json, "Print JSON");
  add_case_options(*command.add_option_group(kOfFolder), o.cases);
  command.footer(
      "The cloth alone is kicked and left to itself: no gravity, contact or strain limit. Stable: "
      "its\n"
      "energy stays within ten times that of the kick; with --strain-limiter, of a fall through "
      "its\n"
      "own diagonal, and then the bound is not judged. kept: the step that a run keeps to, by\n"
      "Gershgorin's bound; predicted: by the largest eigenvalue; measured: by bisection.\n"
      "A case ends as correct, refused with the reason, degraded with the flag, or FAILED.\n"
      "Exit code: 0 every bound holds, every case ends as it should; 1 not so; 2 bad input.");
}

}  // namespace

void add_command_stability(CLI::App& app, int& exit_code) {
  const auto o = std::make_shared<StabilityOptions>();
  CLI::App* command = app.add_subcommand(
      "stability", "Largest stable step of each integrator on a scene's cloth; the extreme cases");
  add_options(*command, *o);
  command->callback([o, command, &exit_code] { exit_code = run_folder_or_scene(*command, *o); });
}
