// SPDX-License-Identifier: MIT
//
// Causes of the difference between computed and measured drape coefficients. One cause at a time
// changes the drape test of selvedge drape; the same seed gives the same folds to begin with, and
// the program prints the mean change in points.
//   bench drape_split [FABRIC...] [--cells 24] [--seeds 2] [--causes NAME,...] [--markdown]
#include <selvedge/apps/command_line.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/lab/fabric_drape.h>
#include <selvedge/scene/fabric_file.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "bench.h"
#include "table.h"

namespace selvedge {
namespace drape_split_bench {
namespace {

struct Test {
  Material material;
  DrapeTrial trial;
};

/// A change of the test. `from`: the cause that it is compared with; empty: the test as it is.
struct Cause {
  std::string name, from;
  std::function<void(Test&)> change;
};

/// The bending hysteresis HB that leaves this curvature (1/m) to a strip without moment.
void keep_curvature(Test& t, double curvature) {
  t.material.bending_friction =
      curvature * 0.5 * (t.material.bending_stiffness + bending_along_weft(t.material));
}

void scale_bending(Test& t, double by) {
  t.material.bending_weft = by * bending_along_weft(t.material);
  t.material.bending_stiffness *= by;
}

void scale_stretch(Test& t, double by) {
  t.material.stretch_weft = by * stretch_along_weft(t.material);
  t.material.stretch_stiffness *= by;
}

void use_angle(Test& t) { t.material.shear_law = "angle"; }

/// Smallest and largest residual curvature of matsudaira_2015, 1/m.
constexpr double kLeastResidual = 18.4, kMostResidual = 52.5;
/// 2HG of a wool suiting of the usual size (usual_kes), 1.2 gf/cm.
constexpr double kShearLoop = 1.2 * kNewtonPerMetreOfGfPerCm;

std::vector<Cause> all_causes() {
  return {
      {"net: finite elements", "", [](Test& t) { t.material.stretch_law = "corotated"; }},
      {"net: warp and weft, C12 = 0", "", use_angle},
      {"mesh: twice the cells", "", [](Test& t) { t.trial.cells *= 2; }},
      {"net: finite elements, twice the cells", "mesh: twice the cells",
       [](Test& t) {
         t.trial.cells *= 2;
         t.material.stretch_law = "corotated";
       }},
      {"friction: bending loop 18.4 1/m", "", [](Test& t) { keep_curvature(t, kLeastResidual); }},
      {"friction: bending loop 52.5 1/m", "", [](Test& t) { keep_curvature(t, kMostResidual); }},
      {"friction: shear loop 1.2 gf/cm", "net: warp and weft, C12 = 0",
       [](Test& t) {
         use_angle(t);
         t.material.shear_friction = 0.5 * kShearLoop;
       }},
      {"support: one disc, laid", "", [](Test& t) { t.trial.hold = DrapeHold::laid; }},
      {"measurement: bending + 25 %", "", [](Test& t) { scale_bending(t, 1.25); }},
      {"measurement: shear + 25 %", "", [](Test& t) { t.material.shear_stiffness *= 1.25; }},
      {"measurement: stretch + 25 %", "", [](Test& t) { scale_stretch(t, 1.25); }},
      {"measurement: density - 5 %", "", [](Test& t) { t.material.density *= 0.95; }},
      {"measurement: specimen of 24 cm", "", [](Test& t) { t.trial.specimen = 0.12; }},
      {"measurement: specimen of 36 cm", "", [](Test& t) { t.trial.specimen = 0.18; }},
  };
}

/// Drape coefficients of the seeds, %; NaN where the cloth did not come to rest.
std::vector<double> coefficients(const Test& test, int seeds) {
  std::vector<double> c(seeds);
  parallel_for(seeds, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      DrapeTrial trial = test.trial;
      trial.seed = static_cast<std::uint32_t>(s + 1);
      const DrapeOutcome outcome = drape(test.material, trial);
      c[s] = outcome.settled ? outcome.coefficient : NAN;
    }
  });
  return c;
}

/// Mean change of the seeds that came to rest in both, and how far it is from the seeds' changes.
std::string change(const std::vector<double>& from, const std::vector<double>& to) {
  std::vector<double> d;
  for (std::size_t s = 0; s < from.size(); ++s)
    if (std::isfinite(to[s] - from[s])) d.push_back(to[s] - from[s]);
  if (d.empty()) return "not at rest";
  const auto [low, high] = std::minmax_element(d.begin(), d.end());
  double sum = 0.0;
  for (const double x : d) sum += x;
  const double mean = sum / static_cast<double>(d.size());
  return fmt::format("{:+.1f} ± {:.1f}", mean, 0.5 * (*high - *low));
}

double mean_of(const std::vector<double>& c) {
  double sum = 0.0;
  int n = 0;
  for (const double x : c)
    if (std::isfinite(x)) {
      sum += x;
      ++n;
    }
  return n > 0 ? sum / n : NAN;
}

using Row = std::vector<std::string>;

Row split(const std::string& name, int cells, int seeds, const std::vector<Cause>& causes) {
  const Fabric fabric = find_fabric(name, ".");
  Test test{fabric.material, {}};
  test.trial.cells = cells;
  std::vector<std::vector<double>> found;
  const std::vector<double> plain = coefficients(test, seeds);
  const double measured = fabric.constants.drape_coefficient.value_or(NAN);
  Row column{name.substr(name.find('/') + 1), fmt::format("{:.1f}", measured),
             fmt::format("{:.1f}", mean_of(plain)),
             fmt::format("{:+.1f}", mean_of(plain) - measured)};
  for (const Cause& cause : causes) {
    Test changed = test;
    cause.change(changed);
    found.push_back(coefficients(changed, seeds));
    const auto from = std::find_if(causes.begin(), causes.end(),
                                   [&](const Cause& c) { return c.name == cause.from; });
    const std::size_t at = static_cast<std::size_t>(from - causes.begin());
    column.push_back(change(at < found.size() - 1 ? found[at] : plain, found.back()));
  }
  return column;
}

/// Causes down, fabrics across.
Table table_of(const std::vector<Row>& columns, const std::vector<Cause>& causes) {
  Row names{"cause", "measured, %", "computed, %", "difference"};
  for (const Cause& cause : causes) names.push_back(cause.name);
  const auto row = [&](std::size_t r) {
    Row cells{names[r]};
    for (const Row& column : columns) cells.push_back(column[r]);
    return cells;
  };
  Table table(row(0));
  for (std::size_t r = 1; r < names.size(); ++r) table.add(row(r));
  return table;
}

}  // namespace
}  // namespace drape_split_bench

int bench_drape_split(int argc, char** argv) {
  using namespace drape_split_bench;
  CommandLine app("The difference of computed and measured drape coefficients, split by causes");
  std::vector<std::string> names, wanted;
  int cells = 24, seeds = 2;
  bool markdown = false;
  app.option("fabrics", names, "Fabrics; the six of Petrak if none is given");
  app.option("--cells", cells, "Cells from centre to rim").range(4, 128);
  app.option("--seeds", seeds, "Drapes of each fabric").range(1, 100);
  app.option("--causes", wanted, "Only causes that begin with one of these words")
      .comma_separated();
  app.flag("--markdown", markdown, "Print a table for a page");
  if (const auto code = app.parse(argc, argv)) return *code;
  if (names.empty())
    for (const char* fabric : {"M1", "M2", "M3", "M4", "M5", "M6"})
      names.push_back(std::string("petrak_2025/") + fabric);
  std::vector<Cause> causes = all_causes();
  std::erase_if(causes, [&](const Cause& cause) {
    return !wanted.empty() && std::none_of(wanted.begin(), wanted.end(), [&](const auto& word) {
      return cause.name.starts_with(word);
    });
  });
  std::vector<Row> columns;
  for (const std::string& name : names) {
    columns.push_back(split(name, cells, seeds, causes));
    fmt::print(stderr, "{}\n", fmt::join(columns.back(), "; "));
  }
  const Table table = table_of(columns, causes);
  fmt::print("{}\n", markdown ? table.markdown() : table.text());
  return 0;
}

}  // namespace selvedge
