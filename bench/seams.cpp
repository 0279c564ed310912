// SPDX-License-Identifier: MIT
//
// Cloth slides over surfaces that are one by their geometry but not by their vertices, and over the
// same surfaces with common vertices: how far it comes, for each speed, friction and response.
//   bench seams [--seed 1] [--responses contact_force,impulse] [--only boxes] [--starts 1]
//               [--markdown]
#include <selvedge/apps/command_line.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "bench.h"
#include "seam_scenes.h"
#include "table.h"

namespace selvedge {
namespace seams_bench {
namespace {

using namespace selvedge::bench;

/// Share of the distance by which a seam may change it.
constexpr double kAllowed = 0.02;

constexpr double kSpeeds[] = {0.1, 0.3, 1.0};
constexpr double kFrictions[] = {0.0, 0.1};

struct Options {
  std::uint64_t seed = 1;
  std::string responses, only;
  int starts = 1;
  bool markdown = false;
};

std::vector<std::string> chosen_responses(const std::string& list) {
  std::vector<std::string> names;
  for (const auto& [name, entry] : responses())
    if (list.empty() || ("," + list + ",").find("," + name + ",") != std::string::npos)
      names.push_back(name);
  return names;
}

std::string percent(double part, double whole) {
  return fmt::format("{:.2f}", 100.0 * (part / whole - 1.0));
}

std::string distance_of(const SlideEnd& end) {
  return end.scatter > 0.0 ? fmt::format("{:.4f} ± {:.4f}", end.distance, end.scatter)
                           : fmt::format("{:.4f}", end.distance);
}

/// One row for each motion; gives the number of seams that change it by more than allowed.
int add_rows(const Seam& seam, const std::string& response, int starts, Table& table) {
  int misses = 0;
  for (const double speed : kSpeeds)
    for (const double friction : kFrictions) {
      const Slide slide{.speed = speed, .friction = friction, .response = response};
      const SlideEnd whole = mean_slide(seam, seam.welded, slide, starts);
      const SlideEnd parts = mean_slide(seam, seam.parts, slide, starts);
      const bool same = parts.stopped.empty() &&
                        std::abs(parts.distance - whole.distance) <= kAllowed * whole.distance;
      misses += same || seam.is_obstacle ? 0 : 1;
      table.add({seam.name, response, fmt::format("{:g}", speed), fmt::format("{:g}", friction),
                 distance_of(whole), distance_of(parts), percent(parts.distance, whole.distance),
                 !parts.stopped.empty() ? parts.stopped
                 : seam.is_obstacle     ? "obstacle"
                 : same                 ? "yes"
                                        : "NO"});
    }
  return misses;
}

int print_table(const Options& options) {
  Table table(
      {"seam", "response", "m/s", "mu", "welded m", "in parts m", "change %", "within 2 %"});
  std::vector<Seam> all = seams(options.seed);
  for (Seam& seam : obstacles()) all.push_back(std::move(seam));
  int misses = 0, rows = 0;
  for (const std::string& response : chosen_responses(options.responses))
    for (const Seam& seam : all) {
      if (seam.name.find(options.only) == std::string::npos) continue;
      misses += add_rows(seam, response, options.starts, table);
      rows += seam.is_obstacle ? 0 : static_cast<int>(std::size(kSpeeds) * std::size(kFrictions));
    }
  fmt::print("{}", options.markdown ? table.markdown() : table.text());
  fmt::print("seed {}: {} of {} slides within {:g} %\n", options.seed, rows - misses, rows,
             100.0 * kAllowed);
  return misses == 0 ? 0 : 1;
}

}  // namespace
}  // namespace seams_bench

int bench_seams(int argc, char** argv) {
  using namespace seams_bench;
  CommandLine app("Cloth that slides over seams of bodies");
  Options options;
  app.option("--seed", options.seed, "Draws where the parts lie and how far apart they are");
  app.option("--responses", options.responses, "Names, with commas between them; all by default");
  app.option("--only", options.only, "Only seams whose name contains this");
  app.option("--starts", options.starts, "Means over so many starts, up to 3 mm aside")
      .range(1, 100);
  app.flag("--markdown", options.markdown, "Print the table in Markdown");
  if (const auto code = app.parse(argc, argv)) return *code;
  return print_table(options);
}

}  // namespace selvedge
