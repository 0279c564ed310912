// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/fabric_drape.h>
#include <selvedge/core/parallel.h>
#include <selvedge/scene/fabric_file.h>

#include <CLI/CLI.hpp>
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
  int seeds = 5, cells = 20, threads = 0;
  double diameter = 0.30;
  bool woven = false, json = false, no_convergence = false;
};

/// All that was computed of one fabric.
struct DrapeRow {
  std::string name;
  std::optional<double> measured;
  double strips = 0.0;
  std::vector<double> coefficient;  ///< one per seed
  std::vector<int> folds;
  double finer = 0.0;  ///< the first seed's with cells of half the size
  bool finer_known = false;
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
  row.coefficient.resize(o.seeds);
  row.folds.resize(o.seeds);
  std::vector<int> unsettled(o.seeds, 0);
  parallel_for(o.seeds, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      DrapeTrial own = trial;
      own.seed = static_cast<std::uint32_t>(s + 1);
      const DrapeOutcome outcome = drape(fabric.material, own);
      row.coefficient[s] = outcome.coefficient;
      row.folds[s] = outcome.rim.folds;
      unsettled[s] = outcome.settled ? 0 : 1;
    }
  });
  for (const int u : unsettled) row.unsettled += u;
  if (o.no_convergence) return row;
  trial.cells *= 2;
  const DrapeOutcome fine = drape(fabric.material, trial);
  row.finer = fine.coefficient;
  row.finer_known = true;
  row.unsettled += fine.settled ? 0 : 1;
  return row;
}

void print_row(const DrapeRow& row) {
  std::string folds;
  for (const int f : row.folds) folds += fmt::format("{}{}", folds.empty() ? "" : " ", f);
  fmt::print(
      "{:<32}{:>9}{:>10.1f}{:>8.1f}{:>8}{:>8.1f}{:>9}{:>9}  {}\n", row.name,
      row.measured ? fmt::format("{:.1f}", *row.measured) : "-", row.mean(), row.spread(),
      row.measured ? fmt::format("{:+.1f}", row.mean() - *row.measured) : "-", row.strips,
      row.finer_known ? fmt::format("{:.1f}", std::abs(row.finer - row.coefficient[0])) : "-",
      row.unsettled, folds);
  std::fflush(stdout);
}

Json to_json(const DrapeRow& row) {
  Json json = {{"name", row.name},          {"computed", row.coefficient}, {"mean", row.mean()},
               {"spread", row.spread()},    {"folds", row.folds},          {"strips", row.strips},
               {"unsettled", row.unsettled}};
  if (row.measured) json["measured"] = *row.measured;
  if (row.finer_known) json["half_cells"] = row.finer;
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
        "seeds\n{:<32}{:>9}{:>10}{:>8}{:>8}{:>8}{:>9}{:>9}  {}\n",
        100.0 * o.diameter, o.woven ? "woven" : "polar", o.cells, o.seeds, "fabric", "measured",
        "computed", "spread", "off", "strips", "|h-h/2|", "restless", "folds");
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

void add_command_drape(CLI::App& app, int& exit_code) {
  const auto o = std::make_shared<DrapeOptions>();
  CLI::App* command = app.add_subcommand(
      "drape", "Drape coefficients of fabrics, computed beside the measured ones");
  command->add_option("FABRIC", o->names,
                      "Fabric names or files (default: the six of petrak_2025)");
  command->add_option("--seeds", o->seeds, "Drapes of each fabric")->check(CLI::Range(1, 1000));
  command->add_option("--cells", o->cells, "Cells from the centre to the rim")
      ->check(CLI::Range(4, 1000));
  command->add_option("--diameter", o->diameter, "Of the cloth, m")->check(CLI::Range(0.2, 1.0));
  command->add_flag("--woven", o->woven,
                    "A woven disc instead of an arc mesh, cells across it: converges slowly");
  command->add_flag("--no-convergence", o->no_convergence,
                    "Without the drape of half the cell size");
  command->add_option("--threads", o->threads, "Threads; 0: all (the answer is the same)")
      ->check(CLI::Range(0, 1024));
  command->add_flag("--json", o->json, "Print JSON");
  command->callback([o, &exit_code] {
    run_command(*o);
    exit_code = 0;
  });
}
