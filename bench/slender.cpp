// SPDX-License-Identifier: MIT
//
// The tests of Romero et al. 2021 on strips: curves of theory beside those of the simulation.
//   bench slender [--cells 20,40] [--markdown]
#include <selvedge/apps/command_line.h>
#include <selvedge/tests/slender.h>

#include <algorithm>
#include <string>
#include <vector>

#include "bench.h"
#include "table.h"

namespace selvedge {
namespace slender_bench {
namespace {

using testing::SlenderStrips;

/// Measured, with its error in percent.
std::string beside(double measured, double exact) {
  return fmt::format("{:.4f} ({:+.2f} %)", measured, 100.0 * (measured / exact - 1.0));
}

std::vector<std::string> head(std::vector<std::string> names, const std::vector<int>& cells) {
  for (const int n : cells) names.push_back(fmt::format("{} cells", n));
  return names;
}

Table cantilevers(const std::vector<SlenderStrips>& strips, const std::vector<int>& cells) {
  Table table(head({"gamma", "curvature at rest", "theory"}, cells));
  for (const double natural : {0.0, 1.0, -1.0})
    for (const double gamma : {1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0}) {
      if (natural != 0.0 && gamma > 20.0) continue;
      const double exact = testing::cantilever_ratio(gamma, natural);
      std::vector<std::string> row{fmt::format("{}", gamma), fmt::format("{}", natural),
                                   fmt::format("{:.4f}", exact)};
      for (const SlenderStrips& s : strips)
        row.push_back(beside(s.cantilever(gamma, natural), exact));
      table.add(row);
    }
  return table;
}

/// `of`: drop or forward.
Table bend_twists(const std::vector<SlenderStrips>& strips, const std::vector<int>& cells,
                  double testing::BendTwist::*of) {
  Table table(head({"gamma", "curvature at rest", "theory"}, cells));
  for (const double natural : {0.5, 1.0, 2.0})
    for (const double gamma : {2.0, 5.0, 10.0, 15.0, 20.0}) {
      const auto exact = bent_and_twisted(SlenderStrips::bend_twist_load(gamma, natural));
      if (!exact) continue;
      std::vector<std::string> row{fmt::format("{}", gamma), fmt::format("{}", natural),
                                   fmt::format("{:.4f}", (*exact).*of)};
      for (const SlenderStrips& s : strips)
        row.push_back(beside(s.bend_twist(gamma, natural).*of, (*exact).*of));
      table.add(row);
    }
  return table;
}

Table buckling(const std::vector<SlenderStrips>& strips, const std::vector<int>& cells) {
  Table table(head({"breadth / length", "theory"}, cells));
  for (const double breadth : {0.05, 0.1, 0.2}) {
    const double exact = testing::lateral_buckling_gamma(breadth);
    std::vector<std::string> row{fmt::format("{}", breadth), fmt::format("{:.3f}", exact)};
    for (const SlenderStrips& s : strips) row.push_back(beside(s.buckling_gamma(breadth), exact));
    table.add(row);
  }
  return table;
}

Table fallen(const std::vector<SlenderStrips>& strips, const std::vector<int>& cells) {
  Table table(head({"gamma / critical gamma", "theory: falls over"}, cells));
  for (const double part : {0.8, 0.9, 1.1, 1.2, 1.5, 2.0, 3.0}) {
    std::vector<std::string> row{fmt::format("{}", part), part > 1.0 ? "yes" : "no"};
    for (const SlenderStrips& s : strips)
      row.push_back(
          fmt::format("{:.4f}", s.buckled(part * testing::lateral_buckling_gamma(2.0 / s.cells))));
    table.add(row);
  }
  return table;
}

Table pushes(const std::vector<SlenderStrips>& strips, const std::vector<int>& cells) {
  constexpr double sticks = 10.0;  // friction
  Table table(head({"descent / length", "theory"}, cells));
  std::vector<std::vector<testing::Pushed>> found;
  for (const SlenderStrips& s : strips) found.push_back(s.pushed(sticks));
  const auto states = testing::pushed_strip();
  for (std::size_t i = 3; i < states.size(); i += 8) {
    std::vector<std::string> row{fmt::format("{:.3f}", states[i].descent),
                                 fmt::format("{:.4f}", states[i].ratio)};
    for (const auto& pushed : found) {
      const auto at = std::find_if(pushed.begin(), pushed.end(), [&](const testing::Pushed& p) {
        return p.descent >= states[i].descent;
      });
      row.push_back(at == pushed.end() ? "-" : beside(at->ratio, states[i].ratio));
    }
    table.add(row);
  }
  return table;
}

Table slips(const std::vector<SlenderStrips>& strips, const std::vector<int>& cells) {
  Table table(head({"friction", "theory"}, cells));
  const auto states = testing::pushed_strip();
  for (const double friction : {0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.7}) {
    const auto exact = testing::slip_descent(states, friction);
    std::vector<std::string> row{fmt::format("{}", friction),
                                 exact ? fmt::format("{:.4f}", *exact) : "sticks"};
    for (const SlenderStrips& s : strips) {
      const auto found = s.slip(friction);
      row.push_back(!found  ? "sticks"
                    : exact ? beside(*found, *exact)
                            : fmt::format("{:.4f}", *found));
    }
    table.add(row);
  }
  return table;
}

}  // namespace
}  // namespace slender_bench

int bench_slender(int argc, char** argv) {
  using namespace slender_bench;
  CommandLine app("Slender strips against theory (Romero et al. 2021)");
  std::vector<int> cells{20, 40};
  bool markdown = false;
  app.option("--cells", cells, "Cells along a strip").comma_separated();
  app.flag("--markdown", markdown, "Print tables for a page");
  if (const auto code = app.parse(argc, argv)) return *code;
  std::vector<SlenderStrips> strips;
  for (const int n : cells) strips.push_back({SELVEDGE_SOURCE_DIR "/data/validation", n});
  const auto print = [&](const char* title, const Table& table) {
    fmt::print("{}\n{}\n", title, markdown ? table.markdown() : table.text());
    std::fflush(stdout);
  };
  print("Cantilever: height over width", cantilevers(strips, cells));
  print("Bend-twist: how far the tip drops, over the length",
        bend_twists(strips, cells, &testing::BendTwist::drop));
  print("Bend-twist: place of the tip along the clamp, over the length",
        bend_twists(strips, cells, &testing::BendTwist::forward));
  print("Lateral buckling: gamma at which the plane strip becomes unstable",
        buckling(strips, cells));
  print("Lateral buckling: how far the tip leans, over the length", fallen(strips, cells));
  print("Stick-slip: horizontal over vertical force, without slip", pushes(strips, cells));
  print("Stick-slip: descent over length at which the foot slips", slips(strips, cells));
  return 0;
}

}  // namespace selvedge
