// SPDX-License-Identifier: MIT
// Nanoseconds a query of the narrow phases, on files in the public format (eight rows a query):
//   bench_narrowphase FOLDER...   one line a family (first folder below FOLDER) and kind
// Mean over warm batches on one thread, median of the repeats; methods take turns. The slowest
// single query is the largest of all queries' least times, so that a hiccup of the machine does
// not count.
#include <fmt/format.h>
#include <selvedge/core/parallel.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

using namespace selvedge;
namespace fs = std::filesystem;

namespace {

std::vector<Query> read(const fs::path& file, ContactKind kind) {
  std::vector<Query> queries;
  std::ifstream in(file);
  int row = 0;
  for (std::string line; std::getline(in, line); row = (row + 1) % 8) {
    if (row == 0) queries.emplace_back().kind = kind;
    std::stringstream stream(line);
    auto& x = row < 4 ? queries.back().x_t0 : queries.back().x_t1;
    for (int i = 0; i < 3; ++i) {
      std::string num, den;
      std::getline(stream, num, ','), std::getline(stream, den, ',');
      x[row % 4][i] = std::strtod(num.c_str(), nullptr) / std::strtod(den.c_str(), nullptr);
    }
  }
  return queries;
}

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Nanoseconds a query of one batch that lasts about a millisecond.
double time_batch(const NarrowPhase& method, const std::vector<Query>& queries,
                  std::vector<double>& toi, int rounds) {
  const auto begin = Clock::now();
  for (int r = 0; r < rounds; ++r) method.find_times(queries, toi);
  return 1e9 * seconds_since(begin) / (static_cast<double>(rounds) * queries.size());
}

double slowest_query(const NarrowPhase& method, const std::vector<Query>& queries) {
  double slowest = 0.0;
  constexpr int kTries = 7;
  for (const Query& q : queries) {
    double least = 1e30, toi = 0.0;
    for (int k = 0; k < kTries; ++k) {
      const auto begin = Clock::now();
      method.find_times({&q, 1}, {&toi, 1});
      least = std::min(least, 1e9 * seconds_since(begin));
    }
    slowest = std::max(slowest, least);
  }
  return slowest;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Nanoseconds a query of the narrow phases");
  std::vector<std::string> folders, names;
  int repeats = 15;
  app.add_option("folder", folders, "folders of query files")->required();
  app.add_option("--narrow-phase", names, "methods; default: all");
  app.add_option("--repeats", repeats, "batches of which the median is printed");
  CLI11_PARSE(app, argc, argv);
  const ThreadLimit limit(1);
  std::map<std::string, std::vector<Query>> families;
  for (const std::string& folder : folders)
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      const std::string path = entry.path().string();
      if (!path.ends_with(".csv") || path.ends_with(".toi.csv")) continue;
      const bool face = path.find("vertex-face") != std::string::npos;
      const auto kind = face ? ContactKind::point_triangle : ContactKind::edge_edge;
      const std::string family = fs::relative(entry.path(), folder).begin()->string();
      auto& all = families[family + (face ? " point_triangle" : " edge_edge")];
      const auto more = read(entry.path(), kind);
      all.insert(all.end(), more.begin(), more.end());
    }
  for (auto& [family, queries] : families) {
    std::map<std::string, std::unique_ptr<NarrowPhase>> methods;
    for (const auto& [name, make] : narrow_phases())
      if (names.empty() || std::find(names.begin(), names.end(), name) != names.end())
        methods[name] = make({});
    std::map<std::string, std::vector<double>> times;
    std::vector<double> toi(queries.size());
    for (int r = 0; r < repeats; ++r)
      for (const auto& [name, method] : methods) {
        const double once = time_batch(*method, queries, toi, 1) * 1e-9 * queries.size();
        times[name].push_back(
            time_batch(*method, queries, toi, std::clamp(static_cast<int>(2e-3 / once), 1, 200)));
      }
    for (auto& [name, t] : times) {
      std::nth_element(t.begin(), t.begin() + t.size() / 2, t.end());
      fmt::print("{:<32} {:<24} {:>6} queries {:>10.1f} ns  slowest {:>10.0f} ns\n", family, name,
                 queries.size(), t[t.size() / 2], slowest_query(*methods[name], queries));
    }
  }
}
