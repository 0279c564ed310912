// SPDX-License-Identifier: MIT
#include "command_stability_cases.h"

#include <fmt/core.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/compare/internal/stability.h>
#include <selvedge/scene/methods.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace selvedge;
using nlohmann::json;

/// The methods of one list of names; "all" stands for all of the family.
template <class R>
std::vector<TriedMethod> chosen(const char* option, const char* key, const R& known,
                                const std::vector<std::string>& names) {
  std::vector<TriedMethod> methods;
  for (const std::string& name : names) {
    if (name == "all") {
      for (const std::string& each : known.names()) methods.push_back({key, each});
      continue;
    }
    const std::string fault = known.fault(name);
    if (!fault.empty()) throw std::invalid_argument(std::string(option) + ": " + fault);
    methods.push_back({key, name});
  }
  return methods;
}

/// One method without a name if each scene keeps its own. Throws std::invalid_argument for methods
/// of two families.
std::vector<TriedMethod> chosen_methods(const CaseOptions& options, const Methods& known) {
  std::vector<TriedMethod> all =
      chosen("--responses", "contact.response", known.responses, options.responses);
  for (auto& more :
       {chosen("--integrators", "solver.integrator", known.integrators, options.integrators),
        chosen("--limiters", "solver.strain_limiter", known.strain_limiters, options.limiters)}) {
    if (!all.empty() && !more.empty())
      throw std::invalid_argument(
          "give only one of --responses, --integrators and --limiters: each is tried alone");
    all.insert(all.end(), more.begin(), more.end());
  }
  if (all.empty()) all.emplace_back();
  return all;
}

SettleConfig config_of(const CaseOptions& o, const TriedMethod& method) {
  return {.folder = o.data,
          .scenes = o.cases,
          .method = method,
          .out = o.out.empty() ? "" : o.out / (method.name.empty() ? "default" : method.name),
          .threads = o.threads,
          .limit = o.limit};
}

json number(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

json to_json(const SettledScene& r) {
  json result = {{"case", r.name},
                 {"method", r.method},
                 {"answer", to_string(r.answer)},
                 {"note", r.note},
                 {"wall_s", r.wall_s}};
  if (!r.measures) return result;
  result["max_stretch"] = number(r.measures->max_stretch);
  result["crossings"] = r.measures->crossings;
  result["worst_speed"] = number(r.measures->worst_speed);
  result["energy_ratio"] = number(r.measures->energy_ratio);
  result["given_J"] = r.measures->given;
  return result;
}

/// "" for a number that is not finite.
std::string shown(double value, const char* format) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "";
}

/// Kinetic energy that each stage of the step added, mJ; without stages that added none.
std::string ledger(const SceneMeasures& measures) {
  std::string text;
  for (const auto& [stage, energy] : measures.given)
    if (energy != 0.0)
      text += fmt::format("{}{} {:+.3g}", text.empty() ? "" : ", ", stage, 1e3 * energy);
  return text;
}

std::string measures_of(const SettledScene& r) {
  if (!r.measures) return " |  |  |  | ";
  const SceneMeasures& m = *r.measures;
  return fmt::format("{} | {} | {} | {} | {}", shown(100.0 * m.max_stretch, "{:.3g}"), m.crossings,
                     shown(m.worst_speed, "{:.3g}"), shown(m.energy_ratio, "{:.4f}"), ledger(m));
}

void print_row(const SettledScene& r, bool several) {
  std::string note = r.note;
  std::replace(note.begin(), note.end(), '|', '/');
  std::replace(note.begin(), note.end(), '\n', ' ');
  print_escaped("| `{}` | {}{} | {} | {} | {:.1f} |\n", r.name, several ? r.method + " | " : "",
                to_string(r.answer), note, measures_of(r), r.wall_s);
  std::fflush(stdout);
}

void print_head(bool several) {
  print_escaped(
      "| case | {}answer | number, reason or flag | stretch, % | crossings | worst speed, m/s | "
      "energy ratio | given by, mJ | wall, s |\n| --- | {}--- | --- | --: | --: | --: | --: | --- "
      "| "
      "--: |\n",
      several ? "method | " : "", several ? "--- | " : "");
}

}  // namespace

void add_case_options(const Command& group, CaseOptions& options) {
  group.option("--cases", options.cases, "Names of scenes, or how they begin (default: all)")
      .comma_separated()
      .one_word();
  group
      .option("--responses", options.responses,
              "Names of responses, or all: every scene with each (default: each keeps its own)")
      .comma_separated()
      .one_word();
  group.option("--integrators", options.integrators, "The same for integrators")
      .comma_separated()
      .one_word();
  group.option("--limiters", options.limiters, "The same for strain limiters")
      .comma_separated()
      .one_word();
  group.option("--out", options.out,
               "Folder for frames, which `selvedge render` draws and `selvedge view` shows");
  group
      .option("--limit", options.limit,
              "Seconds of the processor after which a scene ends as unfinished (default 120)")
      .positive();
}

int run_cases(const CaseOptions& options) {
  const Methods known = methods_of_this_build();
  const std::vector<TriedMethod> methods = chosen_methods(options, known);
  const bool several = methods.size() > 1;
  json results = json::array();
  std::map<Answer, int> count;
  bool head = !options.json;
  for (const TriedMethod& method : methods)
    settle_scenes(config_of(options, method), known, [&](const SettledScene& r) {
      if (std::exchange(head, false)) print_head(several);
      ++count[r.answer];
      if (options.json)
        results.push_back(to_json(r));
      else
        print_row(r, several);
    });
  if (options.json)
    print_document(json{{"results", results}});
  else
    print_escaped("\n{} correct, {} degraded, {} refused, {} unfinished, {} FAILED\n",
                  count[Answer::correct], count[Answer::degraded], count[Answer::refused],
                  count[Answer::unfinished], count[Answer::failed]);
  return count[Answer::failed] > 0 ? 1 : 0;
}
