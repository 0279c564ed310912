// SPDX-License-Identifier: MIT
// Nanoseconds per query of the narrow phases on query files, which `selvedge run --record` writes
// for any scene. Prints one line for each kind and method, and for each folder directly below the
// given one (or the given folder itself). Times are means over warm batches on one thread and the
// median of the repeats; methods take turns. The clock is the processor time of the thread. The
// slowest single query is the largest of all queries' minimum times, which excludes interruptions.
#include <fmt/format.h>
#include <selvedge/apps/command_line.h>
#include <selvedge/core/parallel.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/query_file.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <map>

using namespace selvedge;
namespace fs = std::filesystem;

namespace {

using Methods = std::map<std::string, std::unique_ptr<NarrowPhase>>;
using Families = std::map<std::string, std::vector<Query>>;

Families read_families(const std::vector<std::string>& folders) {
  Families families;
  for (const std::string& folder : folders)
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      const std::string path = entry.path().string();
      if (!path.ends_with(".csv") || path.ends_with(".toi.csv")) continue;
      const fs::path below = fs::relative(entry.path(), folder);
      const fs::path family = below.has_parent_path() ? *below.begin() : fs::path(folder);
      const QuerySet set = read_queries(entry.path());
      auto& all = families[family.string() + "  " + query_kind_name(set.kind)];
      all.insert(all.end(), set.queries.begin(), set.queries.end());
    }
  return families;
}

Methods make_methods(const std::vector<std::string>& wanted) {
  Methods methods;
  for (const auto& [name, make] : narrow_phases())
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), name) != wanted.end())
      methods[name] = make({});
  for (const int width : {2, 4, 8}) {
    const std::string name = fmt::format("ccd_exact/{}", width);
    if (std::find(wanted.begin(), wanted.end(), name) != wanted.end())
      methods[name] = make_ccd_exact({.vector_width = width});
  }
  return methods;
}

/// Processor time of this thread, s.
double now() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  constexpr double kNano = 1e-9;
  return static_cast<double>(t.tv_sec) + kNano * static_cast<double>(t.tv_nsec);
}

/// Time of `rounds` calls, s.
double time_calls(const NarrowPhase& method, std::span<const Query> queries, std::span<double> toi,
                  int rounds) {
  const double begin = now();
  for (int r = 0; r < rounds; ++r) method.find_times(queries, toi);
  return now() - begin;
}

/// Seconds per query with warm caches, in a batch of some milliseconds.
double time_batch(const NarrowPhase& method, std::span<const Query> queries,
                  std::span<double> toi) {
  constexpr double kBatch = 3e-3;  // s
  constexpr int kMostRounds = 500;
  const double once = time_calls(method, queries, toi, 1);
  const int rounds = std::clamp(static_cast<int>(kBatch / once), 1, kMostRounds);
  return time_calls(method, queries, toi, rounds) / (rounds * static_cast<double>(queries.size()));
}

double slowest_query(const NarrowPhase& method, const std::vector<Query>& queries) {
  constexpr int kTries = 7;
  double slowest = 0.0, toi = 0.0;
  for (const Query& q : queries) {
    double least = time_calls(method, {&q, 1}, {&toi, 1}, 1);
    for (int k = 1; k < kTries; ++k)
      least = std::min(least, time_calls(method, {&q, 1}, {&toi, 1}, 1));
    slowest = std::max(slowest, least);
  }
  return slowest;
}

void measure(const std::string& family, const std::vector<Query>& queries, const Methods& methods,
             int repeats) {
  std::map<std::string, std::vector<double>> times;
  std::vector<double> toi(queries.size());
  for (int r = 0; r < repeats; ++r)
    for (const auto& [name, method] : methods)
      times[name].push_back(time_batch(*method, queries, toi));
  constexpr double kNano = 1e9;
  for (auto& [name, t] : times) {
    const auto middle = t.begin() + static_cast<std::ptrdiff_t>(t.size() / 2);
    std::nth_element(t.begin(), middle, t.end());
    fmt::print("{:<34} {:<20} {:>8} {:>12.1f} {:>12.0f}\n", family, name, queries.size(),
               kNano * *middle, kNano * slowest_query(*methods.at(name), queries));
  }
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app("Nanoseconds per query of the narrow phases");
  std::vector<std::string> folders, wanted;
  int repeats = 15;
  app.option("folder", folders, "folders of query files").required().existing_folder();
  app.option("--narrow-phase", wanted,
             "methods, separated by commas; ccd_exact/2, /4 and /8 set its vector width")
      .comma_separated();
  app.option("--repeats", repeats, "batches; the median is printed").range(1, 1000);
  if (const auto code = app.parse(argc, argv)) return *code;
  const ThreadLimit limit(1);
  const Methods methods = make_methods(wanted);
  fmt::print("{:<34} {:<20} {:>8} {:>12} {:>12}\n", "family  kind", "narrow_phase", "queries",
             "ns/query", "slowest ns");
  for (const auto& [family, queries] : read_families(folders))
    measure(family, queries, methods, repeats);
}
