// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/heartbeat.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/scene/fabric_file.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include <selvedge/lab/identify.h>

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;

struct IdentifyOptions {
  std::string fabric, method = "genetic", state, trial = "drape";
  std::vector<std::string> constants = {"bending"};
  std::vector<double> synthetic, finite_elements;
  double target = 0.0;
  int cells = 12, evaluations = 60;
  std::vector<int> sizes;  // of the genetic algorithm, as given
  GeneticConfig genetic;
  bool resume = false, json = false;
};

GeneticConfig with_sizes(GeneticConfig genetic, const std::vector<int>& sizes) {
  if (sizes.empty()) return genetic;
  constexpr int most = 100000, most_islands = 1024;
  if (sizes.size() != 3 || sizes[0] < 1 || sizes[0] > most || sizes[1] < 1 ||
      sizes[1] > most_islands || sizes[2] < 4 || sizes[2] > most || sizes[2] % 2 != 0)
    throw std::invalid_argument(fmt::format(
        "identify: --genetic takes 1 to {} generations, 1 to {} populations and their size, an "
        "even number from 4 to {}, such as --genetic {},{},{}",
        most, most_islands, most, genetic.generations, genetic.islands, genetic.population));
  genetic.generations = sizes[0];
  genetic.islands = sizes[1];
  genetic.population = sizes[2];
  return genetic;
}

DrapeSearch search_of(const IdentifyOptions& o) {
  DrapeSearch search;
  search.constants = identified_constants(o.constants);
  search.trial.cells = o.cells;
  search.fabric = o.fabric;
  if (!o.fabric.empty()) {
    const Fabric fabric = find_fabric(o.fabric, ".");
    search.base = fabric.material;
    if (fabric.constants.drape_coefficient)
      search.target.coefficient = *fabric.constants.drape_coefficient;
  }
  if (o.target > 0.0) search.target.coefficient = o.target;
  if (!o.synthetic.empty()) search.aim_at(o.synthetic, 1);
  if (!(search.target.coefficient > 0.0))
    throw std::invalid_argument(
        "identify: nothing to fit; give a fabric with a drape coefficient, --target or "
        "--synthetic");
  return search;
}

/// The result of one search and its cost.
struct Found {
  std::string method;
  SearchResult result;
  double seconds = 0.0;
};

void print_generation(const GeneticState& state, int generations, Heartbeat& heartbeat) {
  heartbeat.now(fmt::format("genetic, generation {} of {}", state.generation + 1, generations));
  double least = state.islands[0][0].residual;
  for (const auto& island : state.islands)
    for (const Candidate& c : island) least = std::min(least, c.residual);
  print_escaped(stderr, "generation {} of {}: residual {:.4f}\n", state.generation, generations,
                least);
}

Found run_genetic(const DrapeSearch& search, const IdentifyOptions& o, Heartbeat& heartbeat) {
  return {"genetic",
          resumable_genetic(search, o.genetic, {o.state, o.resume}, [&](const GeneticState& s) {
            print_generation(s, o.genetic.generations, heartbeat);
          })};
}

Found run_local(const DrapeSearch& search, const IdentifyOptions& o) {
  Found found{"nelder_mead", {}};
  NelderMeadConfig config;
  config.evaluations = o.evaluations;
  found.result.best = nelder_mead(search, search.middle(), config, found.result.evaluations);
  return found;
}

Json to_json(const DrapeSearch& search, const Found& found) {
  Json constants = Json::object();
  for (std::size_t k = 0; k < search.constants.size(); ++k) {
    const double value = std::pow(10.0, found.result.best.logs[k]);
    Json& j = constants[search.constants[k].name] = {{"found", value}};
    const double known = !search.synthetic.empty() ? search.synthetic[k]
                         : !search.fabric.empty()  ? search.base.*(search.constants[k].field)
                                                   : 0.0;
    if (known > 0.0) j[search.synthetic.empty() ? "measured" : "known"] = known;
    if (known > 0.0) j["ratio"] = value / known;
  }
  return {{"method", found.method},
          {"residual", found.result.best.residual},
          {"target", search.target.coefficient},
          {"evaluations", found.result.evaluations},
          {"seconds", found.seconds},
          {"constants", constants}};
}

void print_constants(const Json& j) {
  for (const auto& [name, c] : j["constants"].items()) {
    std::string beside;
    for (const char* key : {"known", "measured"})
      if (c.contains(key))
        beside = fmt::format("   {} {:.4g}, found/{} = {:.3f}", key, c[key].get<double>(), key,
                             c["ratio"].get<double>());
    print_escaped("  {:<8} {:.4g}{}\n", name, c["found"].get<double>(), beside);
  }
}

void print_report(const Json& j) {
  print_escaped("{}: residual {:.4f} for a drape coefficient of {:.2f} %, {} drapes in {:.1f} s\n",
                j["method"].get<std::string>(), j["residual"].get<double>(),
                j["target"].get<double>(), j["evaluations"].get<int>(), j["seconds"].get<double>());
  print_constants(j);
}

// -- nets -----------------------------------------------------------------------------------------

/// Constants of the springs that are not looked for.
constexpr NetKinds kNet = {{{100.0, 1.0, 0.5}, {30.0, 1.0, 0.5}, {5.0, 1.0, 0.5}}};

/// The target of a net comes from another integrator with shorter steps, another strain limiter, or
/// from finite elements on a finer mesh, so that a search cannot find its own errors again.
NetSearch net_search_of(const IdentifyOptions& o) {
  NetSearch search{.trial = o.trial == "pulled" ? NetTrial::pulled() : NetTrial{},
                   .base = kNet,
                   .unknowns = net_unknowns(o.constants),
                   .target = {}};
  if (!o.state.empty() || o.resume)
    throw std::invalid_argument("identify: --state and --resume are for --trial drape");
  if (o.finite_elements.empty() == o.synthetic.empty())
    throw std::invalid_argument(
        "identify: a net needs a target; give either --synthetic or --finite-elements");
  if (!o.finite_elements.empty()) {
    if (o.finite_elements.size() != 2)
      throw std::invalid_argument("identify: --finite-elements takes stretch and Poisson's ratio");
    constexpr std::int32_t finer = 4;
    search.target =
        finite_element_motion(search.trial, o.finite_elements[0], o.finite_elements[1], finer);
    return search;
  }
  if (o.synthetic.size() != search.unknowns.size())
    throw std::invalid_argument("identify: a synthetic target needs a value for each constant");
  std::vector<double> logs;
  for (const double value : o.synthetic) {
    if (!(value > 0.0))
      throw std::invalid_argument("identify: the values of a synthetic target must be positive");
    logs.push_back(std::log10(value));
  }
  search.target = net_motion(search.trial.of_target(), search.at(logs));
  return search;
}

Json to_json(const NetSearch& search, const IdentifyOptions& o, const Found& found) {
  Json constants = Json::object();
  for (std::size_t k = 0; k < search.unknowns.size(); ++k) {
    const double value = std::pow(10.0, found.result.best.logs[k]);
    Json& j = constants[search.unknowns[k].name] = {{"found", value}};
    if (o.synthetic.empty()) continue;
    j["known"] = o.synthetic[k];
    j["ratio"] = value / o.synthetic[k];
  }
  return {{"method", found.method},
          {"residual", found.result.best.residual},
          {"evaluations", found.result.evaluations},
          {"seconds", found.seconds},
          {"constants", constants}};
}

void print_net_report(const Json& j) {
  print_escaped("{}: residual {:.4f} % of the side, {} motions in {:.1f} s\n",
                j["method"].get<std::string>(), j["residual"].get<double>(),
                j["evaluations"].get<int>(), j["seconds"].get<double>());
  print_constants(j);
}

void identify_net(const IdentifyOptions& o) {
  const NetSearch search = net_search_of(o);
  const SearchSpace space = search.space();
  Json results = Json::array();
  Heartbeat heartbeat("identify");
  for (const std::string method : {"genetic", "nelder_mead"}) {
    if (o.method != method && o.method != "both") continue;
    heartbeat.now(method);
    const Stopwatch watch;
    Found found{method, {}};
    SearchResult& result = found.result;
    if (method == "genetic") {
      result.best = genetic(space, o.genetic, {}, {});
      result.evaluations = o.genetic.generations * o.genetic.islands * o.genetic.population;
    } else {
      NelderMeadConfig config;
      config.evaluations = o.evaluations;
      result.best = nelder_mead(space, space.middle(), config, result.evaluations);
    }
    found.seconds = watch.seconds();
    heartbeat.now("");
    results.push_back(to_json(search, o, found));
    if (!o.json) print_net_report(results.back());
  }
  if (o.json) print_document(Json{{"results", results}});
}

void run_command(const IdentifyOptions& o) {
  if (o.trial != "drape") return identify_net(o);
  Heartbeat heartbeat("identify");
  const DrapeSearch search = search_of(o);
  Json results = Json::array();
  for (const std::string method : {"genetic", "nelder_mead"}) {
    if (o.method != method && o.method != "both") continue;
    heartbeat.now(method);
    const Stopwatch watch;
    Found found = method == "genetic" ? run_genetic(search, o, heartbeat) : run_local(search, o);
    found.seconds = watch.seconds();
    heartbeat.now("");
    results.push_back(to_json(search, found));
    if (!o.json) print_report(results.back());
  }
  if (o.json) print_document(Json{{"results", results}});
}

void add_identify_options(const Command& command) {
  const auto o = std::make_shared<IdentifyOptions>();
  o->method = has_genetic() ? "genetic" : "nelder_mead";
  command.option("FABRIC", o->fabric,
                 "Fabric that gives the other constants and the measured drape coefficient");
  command.option("--target", o->target, "Drape coefficient to fit, %").range(1.0, 100.0);
  command
      .option("--constants", o->constants,
              "Constants to find: bending, shear, stretch; of a net: stretch, shear or bend "
              "with _stiffness (N/m), _length or _limit")
      .comma_separated();
  command
      .option("--trial", o->trial,
              "What is simulated: the drape of a fabric, a net that hangs by two corners "
              "(Louchet 1995), or one that is held by a side and pulled (Bianchi 2004)")
      .one_of({"drape", "hanging", "pulled"});
  command
      .option("--finite-elements", o->finite_elements,
              "Fit a net to finite elements of this stretch (N/m) and Poisson's ratio, on a finer "
              "mesh")
      .comma_separated();
  command
      .option("--synthetic", o->synthetic,
              "Fit the drape computed with these constants (SI), to test whether the "
              "search finds them")
      .comma_separated();
  command.option("--method", o->method, "genetic, nelder_mead or both")
      .one_of({"genetic", "nelder_mead", "both"});
  command.option("--cells", o->cells, "Cells from the centre to the rim").range(4, 1000);
  command
      .option("--genetic", o->sizes,
              "Of the genetic algorithm: generations, number of populations and the size of each, "
              "an even number")
      .comma_separated();
  command.option("--seed", o->genetic.seed, "Seed of the genetic algorithm");
  command
      .option("--evaluations", o->evaluations,
              "Drapes after which nelder_mead starts no further step")
      .range(2, 1000000);
  command.option("--state", o->state, "File that keeps the populations of each generation");
  command.flag("--resume", o->resume, "Continue from --state");
  command.flag("--json", o->json, "Print JSON");
  command.action([o] {
    o->genetic = with_sizes(o->genetic, o->sizes);
    run_command(*o);
    return 0;
  });
}

}  // namespace

selvedge::ProgramCommand identify_command() {
  return {.name = "identify",
          .purpose = "Find elastic constants of a fabric from its drape",
          .add_options = add_identify_options};
}
