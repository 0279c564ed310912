// SPDX-License-Identifier: MIT
//
// The discrete bending energies on five surfaces against their closed forms: error in percent for
// each mesh, and the order of convergence that the last two meshes show.
//   bench bending [--cells 8,16,32,64] [--markdown]
#include <selvedge/apps/command_line.h>
#include <selvedge/tests/bent_surfaces.h>

#include <cmath>
#include <string>
#include <vector>

#include "bench.h"
#include "table.h"

namespace selvedge {
namespace bending_bench {
namespace {

using namespace selvedge::testing;

const char* name_of_pattern(Pattern pattern) {
  if (pattern == Pattern::one_way) return "one way";
  return pattern == Pattern::alternating ? "alternating" : "irregular";
}

/// The order of the last two errors whose cells halve; "-" if they do not shrink by a fifth.
std::string order(double before, double last) {
  const double ratio = std::abs(before) / std::abs(last);
  return ratio < 1.2 ? "-" : fmt::format("{:.1f}", std::log2(ratio));
}

Table errors(bool whole, const std::vector<int>& cells) {
  std::vector<std::string> head{"surface", "energy", "mesh"};
  for (const int n : cells) head.push_back(fmt::format("{} cells, %", n));
  head.emplace_back("order");
  Table table(head);
  for (const BentSurface& surface : bent_surfaces())
    for (const BendingModel model : {BendingModel::hinge, BendingModel::bridson,
                                     BendingModel::shape_operator, BendingModel::morley})
      for (const Pattern pattern : {Pattern::one_way, Pattern::alternating, Pattern::irregular}) {
        std::vector<std::string> row{surface.name, name_of(model), name_of_pattern(pattern)};
        double before = 0.0, last = 0.0;
        for (const int n : cells) {
          const EnergyRatio ratio = energy_ratio(surface, divide(surface, pattern, n), model);
          before = last;
          last = 100.0 * ((whole ? ratio.whole : ratio.inner) - 1.0);
          row.push_back(fmt::format("{:+.3f}", last));
        }
        row.push_back(order(before, last));
        table.add(row);
      }
  return table;
}

}  // namespace
}  // namespace bending_bench

int bench_bending(int argc, char** argv) {
  using namespace bending_bench;
  CommandLine app("Discrete bending energies against closed forms");
  std::vector<int> cells{8, 16, 32, 64};
  bool markdown = false;
  app.option("--cells", cells, "Cells along the shorter side, ascending").comma_separated();
  app.flag("--markdown", markdown, "Print tables for a page");
  if (const auto code = app.parse(argc, argv)) return *code;
  for (const bool whole : {false, true}) {
    fmt::print("{}\n", whole ? "Whole sheet:" : "Away from the border:");
    const Table table = errors(whole, cells);
    fmt::print("{}\n", markdown ? table.markdown() : table.text());
  }
  return 0;
}

}  // namespace selvedge
