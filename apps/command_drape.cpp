// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/parallel.h>
#include <selvedge/lab/fabric_drape.h>
#include <selvedge/scene/fabric_file.h>

#include <algorithm>
#include <cmath>
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
};

/// The results of one fabric.
struct DrapeRow {
  std::string name;
  std::optional<double> measured;
  double strips = 0.0;
  std::vector<double> coefficient;  ///< one per seed
  std::vector<int> folds;
  std::vector<double> refined;  ///< the first seed's, by mesh
  std::vector<int> refined_folds;
  int unsettled = 0;

  double mean() const {
    double sum = 0.0;
    for (const double c : coefficient) sum += c;
    return sum / static_cast<double>(coefficient.size());
  }
  double spread() const {
    const auto [low, high] = std::minmax_element(coefficient.begin(), coefficient.end());
    return *high - *low;
  }
  /// The limit of the mean for finer meshes: all seeds get the correction of the first one.
  std::optional<MeshLimit> limit() const {
    if (refined.size() < 2) return {};
    MeshLimit limit = mesh_limit(refined);
    limit.value += mean() - refined.front();
    return limit;
  }
  /// The limit if known, else the mean.
  double value() const {
    const auto known = limit();
    return known ? known->value : mean();
  }
};

DrapeRow compute(const Fabric& fabric, const DrapeOptions& o) {
  DrapeTrial trial;
  trial.specimen = 0.5 * o.diameter;
  trial.cells = o.cells;
  trial.polar = !o.woven;
  DrapeRow row;
  row.name = fabric.name;
  row.measured = fabric.constants.drape_coefficient;
  const Material& m = fabric.material;
  row.strips = strip_drape_coefficient(
      bending_length(0.5 * (m.bending_stiffness + bending_along_weft(m)), m.density));
  std::vector<std::vector<DrapeOutcome>> outcomes(o.seeds);
  parallel_for(o.seeds, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      DrapeTrial own = trial;
      own.seed = static_cast<std::uint32_t>(s + 1);
      if (s == 0 && trial.polar)
        outcomes[s] = drape_refined(fabric.material, own, o.levels);
      else
        outcomes[s].push_back(drape(fabric.material, own));
    }
  });
  for (const auto& meshes : outcomes) {
    row.coefficient.push_back(meshes.front().coefficient);
    row.folds.push_back(meshes.front().rim.folds);
    for (const DrapeOutcome& outcome : meshes) row.unsettled += outcome.settled ? 0 : 1;
  }
  for (const DrapeOutcome& outcome : outcomes.front()) {
    row.refined.push_back(outcome.coefficient);
    row.refined_folds.push_back(outcome.rim.folds);
  }
  return row;
}

std::string joined(const std::vector<int>& numbers) {
  return fmt::format("{}", fmt::join(numbers, " "));
}

void print_row(const DrapeRow& row) {
  const auto limit = row.limit();
  fmt::print(
      "{:<32}{:>9}{:>10.1f}{:>8.1f}{:>8}{:>7}{:>8}{:>8.1f}{:>9}  {}{}\n", row.name,
      row.measured ? fmt::format("{:.1f}", *row.measured) : "-", row.mean(), row.spread(),
      limit ? fmt::format("{:.1f}", limit->value) : "-",
      limit ? fmt::format("{:.1f}", limit->uncertainty) : "-",
      row.measured ? fmt::format("{:+.1f}", row.value() - *row.measured) : "-", row.strips,
      row.unsettled, joined(row.folds),
      limit ? " (finer: " + joined({row.refined_folds.begin() + 1, row.refined_folds.end()}) + ")"
            : "");
  std::fflush(stdout);
}

Json to_json(const DrapeRow& row) {
  Json json = {{"name", row.name},          {"computed", row.coefficient}, {"mean", row.mean()},
               {"spread", row.spread()},    {"folds", row.folds},          {"strips", row.strips},
               {"unsettled", row.unsettled}};
  if (row.measured) json["measured"] = *row.measured;
  if (const auto limit = row.limit()) {
    json["refined"] = row.refined;
    json["refined_folds"] = row.refined_folds;
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
        "computed", "spread", "limit", "+-", "off", "strips", "restless", "folds");
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
