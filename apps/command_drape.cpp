// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/parallel.h>
#include <selvedge/lab/fabric_drape.h>
#include <selvedge/scene/fabric_file.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "command_identify.h"

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;

struct DrapeOptions {
  std::vector<std::string> names;
  int seeds = 5, cells = 32, levels = 2, threads = 0;
  double diameter = 0.30;
  bool woven = false, json = false;
  std::string stretch_law;  // empty: the fabric's
};

/// The results of one fabric.
struct DrapeRow {
  std::string name;
  std::optional<double> measured;
  DrapeStatistics computed;
};

DrapeRow compute(const Fabric& fabric, const DrapeOptions& o) {
  DrapeSeries series{.trial = {}, .seeds = o.seeds, .levels = o.levels};
  series.trial.specimen = 0.5 * o.diameter;
  series.trial.cells = o.cells;
  series.trial.polar = !o.woven;
  Material material = fabric.material;
  if (o.stretch_law == "hooke") material.stretch_law = StretchLaw::hooke;
  if (o.stretch_law == "corotated") material.stretch_law = StretchLaw::corotated;
  if (o.stretch_law == "st_venant_kirchhoff")
    material.stretch_law = StretchLaw::st_venant_kirchhoff;
  return {fabric.name, fabric.constants.drape_coefficient, drape_series(material, series)};
}

std::string joined(const std::vector<std::int32_t>& numbers) {
  return fmt::format("{}", fmt::join(numbers, " "));
}

void print_row(const DrapeRow& row) {
  const DrapeStatistics& c = row.computed;
  const auto limit = c.limit();
  fmt::print("{:<32}{:>9}{:>10.1f}{:>8.1f}{:>8}{:>7}{:>8}{:>8.1f}{:>9}  {}{}\n", row.name,
             row.measured ? fmt::format("{:.1f}", *row.measured) : "-", c.mean(), c.spread(),
             limit ? fmt::format("{:.1f}", limit->value) : "-",
             limit ? fmt::format("{:.1f}", limit->uncertainty) : "-",
             row.measured ? fmt::format("{:+.1f}", c.value() - *row.measured) : "-", c.strips,
             c.unsettled, joined(c.folds),
             limit
                 ? " (finer: " + joined({c.refined_folds.begin() + 1, c.refined_folds.end()}) + ")"
                 : "");
  std::fflush(stdout);
}

Json to_json(const DrapeRow& row) {
  const DrapeStatistics& c = row.computed;
  Json json = {{"name", row.name},        {"computed", c.coefficient}, {"mean", c.mean()},
               {"spread", c.spread()},    {"folds", c.folds},          {"strips", c.strips},
               {"unsettled", c.unsettled}};
  if (row.measured) json["measured"] = *row.measured;
  if (const auto limit = c.limit()) {
    json["refined"] = c.refined;
    json["refined_folds"] = c.refined_folds;
    json["limit"] = limit->value;
    json["limit_uncertainty"] = limit->uncertainty;
    json["order"] = limit->order;
  }
  return json;
}

void run_command(const DrapeOptions& o) {
  const ThreadLimit limit(o.threads);
  std::vector<Fabric> fabrics;
  if (o.names.empty())
    for (int i = 1; i <= 6; ++i)
      fabrics.push_back(find_fabric("petrak_2025/M" + std::to_string(i), "."));
  for (const std::string& name : o.names) fabrics.push_back(find_fabric(name, "."));
  if (!o.json)
    fmt::print(
        "drape coefficient, %; {} cm on 18 cm, held on the support, {} mesh, {} cells, {} "
        "seeds\n{:<32}{:>9}{:>10}{:>8}{:>8}{:>7}{:>8}{:>8}{:>9}  {}\n",
        100.0 * o.diameter, o.woven ? "woven" : "polar", o.cells, o.seeds, "fabric", "measured",
        "computed", "spread", "limit", "+-", "error", "strips", "unsettled", "folds");
  Json rows = Json::array();
  for (const Fabric& fabric : fabrics) {
    const DrapeRow row = compute(fabric, o);
    if (o.json)
      rows.push_back(to_json(row));
    else
      print_row(row);
  }
  if (o.json) fmt::print("{}\n", Json{{"results", rows}}.dump(2));
}

}  // namespace

void add_command_drape(const Command& app) {
  const auto o = std::make_shared<DrapeOptions>();
  const Command command = app.subcommand(
      "drape", "Compute drape coefficients of fabrics and compare them with measurements");
  command.option("FABRIC", o->names, "Fabric names or files (default: the six of petrak_2025)");
  command.option("--seeds", o->seeds, "Number of drapes of each fabric, each with its own seed")
      .range(1, 1000);
  command.option("--cells", o->cells, "Cells from the centre to the rim, of the size at the rim")
      .range(4, 1000);
  command.option("--diameter", o->diameter, "Diameter of the cloth, m").range(0.2, 1.0);
  command.flag("--woven", o->woven,
               "Use a woven disc instead of a polar mesh, --cells across it; converges "
               "slowly");
  command
      .option("--stretch-law", o->stretch_law,
              "Springs (hooke) or finite elements instead of the fabric's own law")
      .one_of({"hooke", "st_venant_kirchhoff", "corotated"});
  command
      .option("--levels", o->levels,
              "Meshes for the first seed, each with twice the cells of the one before, "
              "from which the limit and its uncertainty are extrapolated; 1: no "
              "extrapolation")
      .range(1, 6);
  command.option("--threads", o->threads, "Threads; 0: all (the answer is the same)")
      .range(0, 1024);
  command.flag("--json", o->json, "Print JSON");
  command.action([o] {
    run_command(*o);
    return 0;
  });
}
