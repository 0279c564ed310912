// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/compare/compare_table.h>
#include <selvedge/compare/internal/ablation.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/methods.h>
#include <selvedge/simulation/internal/plan.h>
#include <selvedge/simulation/simulation.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include <selvedge/scene/methods.h>
#include "overrides.h"

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;

struct PlanOptions {
  std::string scene, write;
  std::vector<std::string> set, accept;
  int measure = 0, repeats = 3, seeds = 5;
  bool ablate = false, json = false;
  double tolerance = 0.01;
};

const char* word(PlanItem::Status status) {
  switch (status) {
    case PlanItem::Status::runs:
      return "runs";
    case PlanItem::Status::never:
      return "left out";
    case PlanItem::Status::when_needed:
      return "when needed";
  }
  return "";
}

// -- proofs ---------------------------------------------------------------------------------------

/// Interleaved, so that a disturbance of the machine affects both.
Json measure_proofs(const PlanOptions& o, const Methods& methods) {
  std::vector<Override> overrides = read_overrides(o.set);
  overrides.push_back({"time.frames", std::to_string(o.measure)});
  const Scene on = read_scene(o.scene, overrides, methods);
  overrides.push_back({"plan", "false"});
  const Scene off = read_scene(o.scene, overrides, methods);
  TimedRun with, without;
  std::vector<double> with_s, without_s, ratios;
  for (int repeat = 0; repeat < o.repeats; ++repeat) {
    with = run_timed(on, methods);
    without = run_timed(off, methods);
    with_s.push_back(with.seconds);
    without_s.push_back(without.seconds);
    ratios.push_back(without.seconds / with.seconds);
  }
  const Quartiles gain = quartiles(ratios);
  Json parts = Json::object();
  for (const auto& [part, p] : with.result.plan)
    parts[part] = {{"asked", p.asked}, {"left_out", p.left_out}, {"saved_s", p.saved_s}};
  const auto& phases = with.result.phase_s;
  const double spent = phases.contains("plan") ? phases.at("plan") : 0.0;
  return {{"frames", o.measure},
          {"steps", with.result.steps},
          {"same_bits", with.result.state_hash == without.result.state_hash},
          {"with_s", quartiles(with_s).median},
          {"without_s", quartiles(without_s).median},
          {"gain", {gain.median, gain.low, gain.high}},
          {"proving_share", spent / with.seconds},
          {"parts", parts}};
}

void print_measured(const Json& m) {
  print_escaped(
      "\n{}, {}: {:.3g} s with proofs, {:.3g} s without: {:.2f} times as fast "
      "({:.2f} to {:.2f}); {}\n",
      counted(m["frames"].get<int>(), "frame"), counted(m["steps"].get<int>(), "step"),
      m["with_s"].get<double>(), m["without_s"].get<double>(), m["gain"][0].get<double>(),
      m["gain"][1].get<double>(), m["gain"][2].get<double>(),
      m["same_bits"].get<bool>() ? "the same bits" : "OTHER BITS: please report it");
  print_escaped("proving took {:.1f} % of the steps\n", 100.0 * m["proving_share"].get<double>());
  for (const auto& [part, p] : m["parts"].items())
    print_escaped("{:<20} left out {} of {} times, saved {:.3g} s\n", part,
                  p["left_out"].get<int>(), p["asked"].get<int>(), p["saved_s"].get<double>());
}

// -- parts to switch off --------------------------------------------------------------------------

Json to_json(const AblationRow& row) {
  return {{"part", row.part},
          {"verdict", row.verdict()},
          {"clean", row.clean},
          {"crossings", row.crossings},
          {"same_bits", row.same_bits},
          {"why", row.why},
          {"worst_measure", row.worst},
          {"difference", row.equivalence.mean},
          {"interval", {row.equivalence.low, row.equivalence.high}},
          {"distance", row.distance},
          {"spread_of_seeds", row.spread},
          {"time_ratio", {row.time_ratio.median, row.time_ratio.low, row.time_ratio.high}}};
}

Json to_json(const std::vector<AblationRow>& rows) {
  Json list = Json::array();
  for (const AblationRow& row : rows) list.push_back(to_json(row));
  return list;
}

void print_ablation(const PlanOptions& o, const std::vector<AblationRow>& rows) {
  print_escaped(
      "\nSwitched off by hand, over the whole scene, {} seeds each. A part could go if the shape "
      "(mean position, widths, strain, angles)\ndiffers by less than {:.3g} with 95 % confidence "
      "(two one-sided tests); distances are over the cloth's extent.\n",
      o.seeds, o.tolerance);
  for (const AblationRow& row : rows) {
    if (!row.clean) {
      print_escaped("{:<16} needed: {}{}\n", row.part, row.why,
                    row.crossings == 0
                        ? std::string()
                        : fmt::format("; {} crossings, particles by {:.2e}, {:.2f} "
                                      "of the time",
                                      row.crossings, row.distance, row.time_ratio.median));
      continue;
    }
    print_escaped(
        "{:<16} {}: {} differs by {:.2e} to {:.2e}; particles by {:.2e}, those of other seeds by "
        "{:.2e}; {:.2f} of the time ({:.2f} to {:.2f})\n",
        row.part, row.verdict(), row.worst, row.equivalence.low, row.equivalence.high, row.distance,
        row.spread, row.time_ratio.median, row.time_ratio.low, row.time_ratio.high);
  }
}

std::string refusal(const PlanOptions& o, const AblationRow& row) {
  if (!row.clean) return fmt::format("--accept {}: it is needed: {}", row.part, row.why);
  return fmt::format(
      "--accept {}: {} of {} seeds differs by {:.2e} to {:.2e}, which is not shown to be within "
      "{:.3g}; take more --seeds, or raise --tolerance to accept that",
      row.part, row.worst, o.seeds, row.equivalence.low, row.equivalence.high, o.tolerance);
}

/// The scene without the accepted parts. Throws std::invalid_argument for a part that the scene
/// does not have, or that is not shown to be equivalent within the tolerance.
Scene accepted(const PlanOptions& o, const std::vector<AblationRow>& rows, const Methods& methods) {
  auto overrides = read_overrides(o.set);
  const auto parts = optional_parts(read_scene(o.scene, overrides, methods));
  for (const std::string& name : o.accept) {
    const auto part =
        std::find_if(parts.begin(), parts.end(), [&](const auto& p) { return p.part == name; });
    const auto row =
        std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.part == name; });
    if (part == parts.end() || row == rows.end())
      throw std::invalid_argument("--accept " + name + ": the scene does not use such a part");
    if (row->only_measured)
      throw std::invalid_argument("--accept " + name + ": no scene can leave it out");
    if (!row->could_go()) throw std::invalid_argument(refusal(o, *row));
    overrides.insert(overrides.end(), part->overrides.begin(), part->overrides.end());
  }
  return read_scene(o.scene, overrides, methods);
}

void write_scene(const std::string& file, const Scene& scene) {
  AtomicFile out(file);
  out.write(scene.json + "\n");
  out.commit();
}

// -- the command ----------------------------------------------------------------------------------

void print_plan(const std::vector<PlanItem>& items) {
  for (const PlanItem& item : items)
    print_escaped("{:<26}{:<13}{}\n", item.part, word(item.status), item.why);
}

Json plan_json(const std::vector<PlanItem>& items) {
  Json list = Json::array();
  for (const PlanItem& item : items)
    list.push_back({{"part", item.part}, {"verdict", word(item.status)}, {"why", item.why}});
  return list;
}

int run_command(const PlanOptions& o) {
  const Methods methods = methods_of_this_build();
  if (!o.accept.empty() && o.write.empty())
    throw std::invalid_argument("--accept needs --write FILE for the scene without these parts");
  const Scene scene = read_scene(o.scene, read_overrides(o.set), methods);
  const ThreadLimit limit(1);
  const auto items = plan_scene(scene, build_scene(scene, methods), methods);
  Json all = {{"scene", scene.name}, {"plan", plan_json(items)}};
  if (!o.json) print_plan(items);
  if (o.measure > 0) {
    all["measured"] = measure_proofs(o, methods);
    if (!o.json) print_measured(all["measured"]);
  }
  if (o.ablate || !o.accept.empty()) {
    const auto rows = ablate(o.scene, read_overrides(o.set), methods, {o.seeds, o.tolerance});
    all["ablation"] = to_json(rows);
    if (!o.json) print_ablation(o, rows);
    if (!o.accept.empty()) write_scene(o.write, accepted(o, rows, methods));
  }
  if (o.json) print_document(all);
  return o.measure > 0 && !all["measured"]["same_bits"].get<bool>() ? 1 : 0;
}

void add_options(const Command& command, PlanOptions& o) {
  command.option("scene", o.scene, "Scene file (JSON)").required();
  command.option("--set", o.set, "path=value replaces a value of the scene file").one_word();
  command
      .option("--measure", o.measure,
              "Run this many frames with and without proofs: compare the bits and the "
              "time")
      .range(1, 1'000'000);
  command.option("--repeats", o.repeats, "Repeats of --measure, interleaved (default 3)")
      .range(1, 1000);
  command.flag("--ablate", o.ablate,
               "Run the scene without each optional part: difference and time");
  command.option("--seeds", o.seeds, "Runs of each scene for --ablate (default 5)").range(2, 1000);
  command
      .option("--tolerance", o.tolerance,
              "Largest difference of shape that a part may make, relative to the "
              "extent of the cloth (default 0.01)")
      .positive();
  command
      .option("--accept", o.accept,
              "Parts to switch off permanently, if the difference is within the "
              "tolerance")
      .comma_separated()
      .one_word();
  command.option("--write", o.write, "File for the scene without the accepted parts");
  command.flag("--json", o.json, "Print JSON");
  command.footer(
      "The program leaves out parts that are proved to have no effect; the result has the\n"
      "same bits (plan=false in a scene, or `run --plan off`, computes them all).\n"
      "Parts whose absence changes the result are switched off only by --accept.\n"
      "Exit code: 0 done, 1 proofs changed the result, 2 bad input.");
}

void add_plan_options(const Command& command) {
  const auto o = std::make_shared<PlanOptions>();
  add_options(command, *o);
  command.action([o] { return run_command(*o); });
}

}  // namespace

selvedge::ProgramCommand plan_command() {
  return {.name = "plan",
          .purpose = "Show which parts a scene needs, which are left out, and why",
          .add_options = add_plan_options};
}
