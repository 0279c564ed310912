// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/compare/compare_table.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include <selvedge/scene/methods.h>

namespace {

using namespace selvedge;
namespace fs = std::filesystem;

struct AdviseOptions {
  std::string where;
  double error = -1.0;
  bool json = false;
};

/// The folder itself, or where `compare` puts that of the scene.
fs::path folder_of(const std::string& where) {
  if (fs::is_directory(where)) return where;
  const Scene scene = read_scene(where, {}, methods_of_this_build());
  const fs::path folder = fs::path("out") / ("compare_" + scene.name);
  if (!fs::exists(folder / "plan.json"))
    throw std::invalid_argument(fmt::format(
        "{}: there are no measurements of this scene in {}; run `selvedge compare` first", where,
        folder.string()));
  return folder;
}

/// What a user may rely on: not less than the reference's own uncertainty, nor than the interval.
double reliable_error(const CompareTable& table, const CompareRow& row) {
  return std::max({row.error.value_or(0.0), table.uncertainty, row.error_half});
}

std::vector<const CompareRow*> fitting(const CompareTable& table, const AdviseOptions& o) {
  std::vector<const CompareRow*> rows;
  for (const CompareRow& row : table.rows) {
    const bool sound = row.status == RunStatus::ok && row.failure.empty() && row.run.result.clean;
    const bool near = o.error < 0.0 || (row.error && reliable_error(table, row) <= o.error);
    if (sound && near) rows.push_back(&row);
  }
  std::stable_sort(rows.begin(), rows.end(), [](const CompareRow* a, const CompareRow* b) {
    return a->run_s.median < b->run_s.median;
  });
  return rows;
}

/// Whether their times differ by more than their quartiles overlap.
bool clearly_quicker(const CompareRow& a, const CompareRow& b) {
  return a.run_s.high < b.run_s.low;
}

void print_advice(const CompareTable& table, const std::vector<const CompareRow*>& rows) {
  const CompareRow& best = *rows[0];
  print_escaped("{}: {:.4g} s per run", best.label, best.run_s.median);
  if (best.error) print_escaped(", error {:.2e} {}", reliable_error(table, best), table.error_unit);
  print_escaped("\n{}\n", best.command);
  if (rows.size() < 2) return;
  const CompareRow& next = *rows[1];
  print_escaped(
      "next: {}, {:.2f} times as long{}\n", next.label, next.run_s.median / best.run_s.median,
      clearly_quicker(best, next) ? "" : ", a difference within the spread of these repeats");
}

nlohmann::ordered_json to_json(const CompareTable& table, const CompareRow& row) {
  nlohmann::ordered_json j = {{"cell", row.id},
                              {"label", row.label},
                              {"command", row.command},
                              {"run_s", row.run_s.median}};
  j["error"] = row.error ? nlohmann::ordered_json(reliable_error(table, row)) : nullptr;
  return j;
}

int run_command(const AdviseOptions& o) {
  const fs::path folder = folder_of(o.where);
  const CompareTable table = make_table(folder, read_plan(folder), methods_of_this_build());
  const bool any_error = std::any_of(table.rows.begin(), table.rows.end(),
                                     [](const CompareRow& row) { return row.error.has_value(); });
  if (o.error >= 0.0 && !any_error)
    throw std::invalid_argument(folder.string() +
                                ": no errors were measured; omit --error to get the fastest cell");
  const auto rows = fitting(table, o);
  if (rows.empty()) {
    print_escaped(
        stderr,
        "selvedge: no cell is within these limits; the errors have an uncertainty of {:.2g}\n",
        table.uncertainty);
    return 1;
  }
  if (o.json)
    print_document(to_json(table, *rows[0]));
  else
    print_advice(table, rows);
  return 0;
}

void add_advise_options(const Command& command) {
  const auto o = std::make_shared<AdviseOptions>();
  command.option("where", o->where, "Folder of a comparison, or the scene that was compared")
      .required();
  command
      .option("--error", o->error,
              "Largest error, in the unit of the comparison: by default relative to the extent of "
              "the cloth")
      .positive();
  command.flag("--json", o->json, "Print JSON");
  command.footer("Exit code: 0 found, 1 no cell is within the limits, 2 bad input.");
  command.action([o] { return run_command(*o); });
}

}  // namespace

selvedge::ProgramCommand advise_command() {
  return {.name = "advise",
          .purpose = "Find the fastest cell of a comparison within an error",
          .add_options = add_advise_options};
}
