// SPDX-License-Identifier: MIT
// Times, pairs and memory of every broad phase of this build, on the scenes of broadphase_scenes.h.
// Tables:
//   detectors  times by part. `cold` is the first call of a new detector (topology, build, query).
//              `build` is the part of a call that builds the structure, and `refit` the part that
//              updates it after every vertex has moved. `query` and `warm` are the search and the
//              whole of the latter call. `recall` counts the pairs of bvh_aabb, which tests prove
//              equal to those of brute force.
//   libraries  the speed-up of the default detector over the best library in the same turn: of the
//              first call, of a call that rebuilds the structure, and of a warm call
//   spikes     the warm call with one vertex that moves 1 m, 10 m and 1 km, with the scene at
//              1e6 m from the origin, and with a copy of the mesh beside it that is 1e5 times
//              smaller (--smaller: other ratios), each over the plain one; pairs reported per
//              microsecond
//   scaling    the warm call over the size, and its log-log slope over the sum of moving primitives
//              and pairs
//   memory     memory that a detector keeps between calls, per primitive, and the increase of a
//              separate process's peak memory by its first two calls; --large adds 2.5 million
//              triangles
//   frames     milliseconds per frame of a cloth that swings to and fro at a given speed
// Detectors take turns, and the program prints medians.
#include "bench.h"
#include "broadphase_scenes.h"
#include "table.h"

#include <fmt/format.h>
#include <selvedge/apps/command_line.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/scene/methods.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <numbers>
#include <optional>
#include <set>

using namespace selvedge::bench;

namespace selvedge {
namespace broadphase_bench {
namespace {

constexpr double kFramesOfASwing = 60.0;
constexpr int kLargeSize = 1119;       // 2·1118² = 2.5 million triangles
constexpr int kSizeOfThickness = 200;  // the thickness scales with the edges of this size
constexpr const char* kReference = "bvh_aabb";

struct BenchOptions {
  std::vector<std::string> tables = {"detectors"}, detectors, scenes = {"drape", "crumple"};
  std::vector<double> smaller = {1e5};
  std::vector<int> sizes = {50, 100, 200}, threads = {1};
  int repeats = 9, largest_brute = 50, frames = 60;
  double limit = 20.0;  // s
  bool least = false, markdown = false, large = false;
  std::string csv, peak_of, peak_scene = "drape";
  bool in_proportion = false;
};

double pick(std::vector<double> values, bool least) {
  if (values.empty()) return std::nan("");
  const std::size_t place = least ? 0 : values.size() / 2;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(place),
                   values.end());
  return values[place];
}

std::string milliseconds(double seconds) { return fmt::format("{:.3f}", 1e3 * seconds); }

/// Times one call, in seconds.
double detect(BroadPhase& detector, const SearchScene& scene, CandidatePairs& out) {
  const auto begin = std::chrono::steady_clock::now();
  if (scene.self)
    detector.find_self_pairs(scene.cloth.view(), out);
  else
    detector.find_pairs(scene.cloth.view(), scene.body.view(), out);
  return seconds_since(begin);
}

template <class Pair>
std::size_t common(const std::vector<Pair>& a, const std::vector<Pair>& b) {
  std::size_t count = 0;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();)
    if (*i < *j) {
      ++i;
    } else if (*j < *i) {
      ++j;
    } else {
      ++count, ++i, ++j;
    }
  return count;
}

double recall(const CandidatePairs& found, const CandidatePairs& all) {
  const std::size_t seen = common(found.point_triangle, all.point_triangle) +
                           common(found.triangle_point, all.triangle_point) +
                           common(found.edge_edge, all.edge_edge);
  return all.size() == 0 ? 1.0 : static_cast<double>(seen) / static_cast<double>(all.size());
}

/// Measurements of one detector on one scene.
struct Measured {
  std::unique_ptr<BroadPhase> detector;
  std::vector<double> cold, built, build, refit, query, warm;
  CandidatePairs out;
  std::size_t bytes = 0;
  std::string why_not;  ///< the reason for a missing result
  bool slow = false;    ///< exceeded the limit; not measured again

  double warm_s(bool least) const { return pick(warm, least); }
};

using Measurement = std::map<std::string, Measured>;

std::string why_not(const BroadPhaseTraits& traits, const SearchScene& scene) {
  if (traits.particles) return "answers particles";  // see `bench image_space`
  if (scene.self && !traits.self) return "no self-collision";
  if (scene.self && (traits.closed_body_only || !traits.deforming)) return "bodies only";
  return "";
}

/// One turn: a cold call, a call that rebuilds the structure, and a warm call. Repeating the
/// promise of a static surface makes a detector that keeps trees build a tree for it.
void take_turn(Measured& m, const std::function<std::unique_ptr<BroadPhase>()>& make,
               SearchScene& scene) {
  m.detector = make();
  move(scene, scene.speed, 1);
  m.cold.push_back(detect(*m.detector, scene, m.out));
  move(scene, scene.speed, 3);
  scene.cloth.static_id = 2;
  m.built.push_back(detect(*m.detector, scene, m.out));
  m.build.push_back(m.detector->last_cost().build_s);
  scene.cloth.static_id = 0;
  move(scene, scene.speed, 2);
  m.warm.push_back(detect(*m.detector, scene, m.out));
  const BroadPhaseCost cost = m.detector->last_cost();
  m.refit.push_back(cost.refit_s + cost.build_s);
  m.query.push_back(cost.query_s);
  m.bytes = cost.bytes;
}

Measurement measure(SearchScene& scene, const BroadPhaseRegistry& registry,
                    const BenchOptions& options) {
  Measurement all;
  for (int repeat = 0; repeat < options.repeats; ++repeat)
    for (const auto& [name, make] : registry) {
      Measured& m = all[name];
      if (repeat == 0) m.why_not = why_not(make()->traits(), scene);
      if (!m.why_not.empty() || m.slow) continue;
      try {
        take_turn(m, make, scene);
      } catch (const std::exception& error) {
        scene.cloth.static_id = 0;
        m.why_not = error.what();
      }
      m.slow = !m.warm.empty() && m.warm.back() > options.limit / options.repeats;
    }
  return all;
}

BroadPhaseRegistry detectors(const BenchOptions& options, int size) {
  BroadPhaseRegistry all = methods_of_this_build().broad_phases;
  if (!options.detectors.empty()) {
    BroadPhaseRegistry some;
    for (const std::string& name : options.detectors) some.add(name, all.at(name));
    all = some;
  }
  if (size > options.largest_brute) all.erase("brute_force");
  return all;
}

CandidatePairs reference(SearchScene& scene) {
  CandidatePairs out;
  move(scene, scene.speed, 2);
  detect(*methods_of_this_build().broad_phases.at(kReference)(), scene, out);
  return out;
}

Table detector_table(const BenchOptions& options) {
  Table table({"scene", "detector", "threads", "cold ms", "build ms", "refit ms", "query ms",
               "warm ms", "point-triangle", "edge-edge", "recall", "MB", "B/primitive"});
  for (const int size : options.sizes)
    for (const std::string& kind : options.scenes)
      for (const int threads : options.threads) {
        const ThreadLimit limit(threads);
        SearchScene scene = make_scene(kind, size);
        for (const auto& [name, m] : measure(scene, detectors(options, size), options)) {
          if (!m.why_not.empty()) {
            table.add({scene.name, name, std::to_string(threads), m.why_not});
            continue;
          }
          table.add(
              {scene.name, name, std::to_string(threads), milliseconds(pick(m.cold, options.least)),
               milliseconds(pick(m.build, options.least)),
               milliseconds(pick(m.refit, options.least)),
               milliseconds(pick(m.query, options.least)), milliseconds(m.warm_s(options.least)),
               std::to_string(m.out.point_triangle.size() + m.out.triangle_point.size()),
               std::to_string(m.out.edge_edge.size()),
               fmt::format("{:.4f}", recall(m.out, reference(scene))),
               fmt::format("{:.1f}", 1e-6 * static_cast<double>(m.bytes)),
               fmt::format("{:.0f}", static_cast<double>(m.bytes) /
                                         static_cast<double>(scene.primitives()))});
        }
      }
  return table;
}

/// Detectors that wrap third-party libraries, by library.
BroadPhaseRegistry libraries(const BroadPhaseRegistry& all) {
  BroadPhaseRegistry some;
  for (const auto& [name, entry] : all)
    if (!entry.library().empty() && entry.traits().guarantee == Guarantee::conservative)
      some.add(name, entry);
  return some;
}

/// The times of one kind of call, by turn.
using Times = std::vector<double> Measured::*;

/// The row of one kind of call. Turns are compared one by one, so that a slow moment of the machine
/// affects both sides.
std::vector<std::string> library_row(const Measurement& all, Times times, bool least) {
  const std::vector<double>& own = all.at(kReference).*times;
  std::string best_name = "none";
  double best = std::numeric_limits<double>::infinity();
  for (const auto& [name, m] : all)
    if (name != kReference && m.why_not.empty() && pick(m.*times, least) < best) {
      best = pick(m.*times, least);
      best_name = name;
    }
  std::vector<double> ratio;
  for (std::size_t turn = 0; turn < own.size(); ++turn) {
    double quickest = std::numeric_limits<double>::infinity();
    for (const auto& [name, m] : all)
      if (name != kReference && m.why_not.empty() && turn < (m.*times).size())
        quickest = std::min(quickest, (m.*times)[turn]);
    ratio.push_back(quickest / own[turn]);
  }
  return {milliseconds(pick(own, true)),
          milliseconds(pick(own, false)),
          best_name,
          milliseconds(pick(all.at(best_name).*times, true)),
          milliseconds(pick(all.at(best_name).*times, false)),
          fmt::format("{:.2f}", pick(all.at(best_name).*times, true) / pick(own, true)),
          fmt::format("{:.2f}", pick(ratio, false))};
}

Table library_table(const BenchOptions& options) {
  Table table({"scene", "call", "threads", "bvh_aabb minimum ms", "median ms", "best library",
               "its minimum ms", "its median ms", "ratio of minima", "ratio of medians"});
  BroadPhaseRegistry all = methods_of_this_build().broad_phases;
  BroadPhaseRegistry some = libraries(all);
  if (some.empty())
    throw std::runtime_error("this build contains none of the libraries to compare with");
  some.add(kReference, all.at(kReference));
  for (const int size : options.sizes)
    for (const std::string& kind : options.scenes)
      for (const int threads : options.threads) {
        const ThreadLimit limit(threads);
        SearchScene scene = make_scene(kind, size);
        const Measurement measured = measure(scene, some, options);
        const std::pair<const char*, Times> calls[] = {
            {"first", &Measured::cold}, {"built", &Measured::built}, {"warm", &Measured::warm}};
        for (const auto& [call, times] : calls) {
          std::vector<std::string> row = {scene.name, call, std::to_string(threads)};
          for (std::string& cell : library_row(measured, times, options.least))
            row.push_back(std::move(cell));
          table.add(row);
        }
      }
  return table;
}

/// A modification of a scene.
struct Perturbation {
  std::string name;
  std::function<void(SearchScene&)> act;
};

/// Called after `move`, so it changes the start position: the sweep is as long as the spike.
void spike(SearchScene& scene, double length) {
  Vec3& x = scene.cloth.x_t0[scene.cloth.x_t0.size() / 2];
  x += length / std::sqrt(3.0) * Vec3(1, 1, 1);
}

/// Adds a copy of the mesh, `times` smaller, beside the scene's.
Perturbation with_small_copy(double times) {
  return {fmt::format("copy 1e{:.0f} times smaller", std::log10(times)), [times](SearchScene& s) {
            s.tiny = 1.0 / times;
            s.cloth.append(tiny_copy(s.cloth, s.tiny));
            // Use the thickness of the small mesh; with the full one, all its primitives would
            // overlap.
            if (s.self) s.cloth.thickness *= s.tiny;
          }};
}

std::vector<Perturbation> perturbations(const BenchOptions& options) {
  std::vector<Perturbation> all = {{"plain", [](SearchScene&) {}},
                                   {"spike 1 m", [](SearchScene& s) { spike(s, 1.0); }},
                                   {"spike 10 m", [](SearchScene& s) { spike(s, 10.0); }},
                                   {"spike 1 km", [](SearchScene& s) { spike(s, 1000.0); }},
                                   {"1e6 m away", [](SearchScene& s) {
                                      s.origin = Vec3(1e6, 1e6, 1e6);
                                      for (Surface* surface : {&s.cloth, &s.body})
                                        for (auto* xs : {&surface->x_t0, &surface->x_t1})
                                          for (Vec3& x : *xs) x += s.origin;
                                    }}};
  for (const double times : options.smaller) all.push_back(with_small_copy(times));
  return all;
}

Table spike_table(const BenchOptions& options) {
  Table table({"scene", "detector", "threads", "perturbation", "warm ms", "ratio to plain", "pairs",
               "pairs/us"});
  for (const int size : options.sizes)
    for (const std::string& kind : options.scenes)
      for (const int threads : options.threads) {
        const ThreadLimit limit(threads);
        std::map<std::string, double> plain;
        for (const Perturbation& perturbation : perturbations(options)) {
          SearchScene scene = make_scene(kind, size);
          perturbation.act(scene);
          for (const auto& [name, m] : measure(scene, detectors(options, size), options)) {
            if (!m.why_not.empty()) {
              table.add({scene.name, name, std::to_string(threads), perturbation.name, m.why_not});
              continue;
            }
            const double warm = m.warm_s(options.least);
            plain.try_emplace(name, warm);
            table.add({scene.name, name, std::to_string(threads), perturbation.name,
                       milliseconds(warm), fmt::format("{:.2f}", warm / plain[name]),
                       std::to_string(m.out.size()),
                       fmt::format("{:.1f}", 1e-6 * static_cast<double>(m.out.size()) / warm)});
          }
        }
      }
  return table;
}

/// Least-squares slope of log y over log x.
double slope(const std::vector<std::array<double, 2>>& points) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const auto& [x, y] : points) {
    const double lx = std::log(x), ly = std::log(y);
    n += 1, sx += lx, sy += ly, sxx += lx * lx, sxy += lx * ly;
  }
  return points.size() < 2 ? std::nan("") : (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

Table scaling_table(const BenchOptions& options) {
  std::vector<std::string> head = {"scene", "detector", "threads"};
  for (const int size : options.sizes) head.push_back(fmt::format("{} ms", size));
  head.push_back("slope");
  Table table(head);
  for (const std::string& kind : options.scenes)
    for (const int threads : options.threads) {
      const ThreadLimit limit(threads);
      std::map<std::string, std::vector<std::array<double, 2>>> points;
      std::map<std::string, std::vector<std::string>> cells;
      std::set<std::string> stopped;
      for (const int size : options.sizes) {
        SearchScene scene = make_scene(kind, size);
        BroadPhaseRegistry registry = detectors(options, size);
        for (const std::string& name : stopped) registry.erase(name);
        for (const auto& [name, m] : measure(scene, registry, options)) {
          if (!m.why_not.empty()) continue;
          const double warm = m.warm_s(options.least);
          cells[name].push_back(milliseconds(warm));
          // A warm call spends no time on the body.
          points[name].push_back(
              {static_cast<double>(scene.cloth.primitives() + m.out.size()), warm});
          if (m.slow) stopped.insert(name);
        }
      }
      for (const auto& [name, done] : cells) {
        std::vector<std::string> row = {kind, name, std::to_string(threads)};
        for (std::size_t i = 0; i < options.sizes.size(); ++i)
          row.push_back(i < done.size() ? done[i] : "-");
        row.push_back(fmt::format("{:.2f}", slope(points[name])));
        table.add(row);
      }
    }
  return table;
}

/// A value of /proc/self/status in bytes, if the system provides it.
std::optional<double> status(const std::string& key) {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);)
    if (line.rfind(key + ":", 0) == 0) return 1024.0 * std::stod(line.substr(key.size() + 1));
  return std::nullopt;
}

SearchScene memory_scene(const BenchOptions& options) {
  SearchScene scene = make_scene(options.peak_scene, options.sizes.at(0));
  if (options.in_proportion)
    for (Surface* s : {&scene.cloth, &scene.body})
      s->thickness *= static_cast<double>(kSizeOfThickness) / options.sizes[0];
  return scene;
}

/// Runs in a separate process; prints bytes kept, pairs, increase of the peak, and primitives.
int print_peak(const BenchOptions& options) {
  SearchScene scene = memory_scene(options);
  const BroadPhaseRegistry all = methods_of_this_build().broad_phases;
  move(scene, scene.speed * (options.in_proportion ? 0.2 : 1.0), 1);
  std::ofstream("/proc/self/clear_refs") << 5;  // Reset the peak.
  const double before = status("VmRSS").value_or(0.0);
  const auto detector = all.at(options.peak_of)();
  CandidatePairs out;
  detect(*detector, scene, out);
  const double seconds = detect(*detector, scene, out);
  fmt::print("{} {} {} {} {}\n", detector->last_cost().bytes, out.size(),
             status("VmHWM").value_or(before) - before, scene.primitives(), seconds);
  return 0;
}

struct Peak {
  double kept, pairs, peak, primitives, warm;
};

/// Measures in a new process of this program.
std::optional<Peak> peak_of(const std::string& detector, const std::string& kind, int size,
                            bool in_proportion) {
  const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
  const std::string command =
      fmt::format("'{}' --peak-of {} --peak-scene {} --size {}{} 2>/dev/null", self, detector, kind,
                  size, in_proportion ? " --in-proportion" : "");
  std::FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) return std::nullopt;
  Peak p{};
  const bool whole = std::fscanf(pipe, "%lf %lf %lf %lf %lf", &p.kept, &p.pairs, &p.peak,
                                 &p.primitives, &p.warm) == 5;
  pclose(pipe);
  return whole ? std::optional(p) : std::nullopt;
}

Table memory_table(const BenchOptions& options) {
  Table table({"scene", "detector", "pairs", "kept MB", "kept B/primitive", "peak MB",
               "peak B/(primitive + pair)", "warm ms"});
  std::vector<int> sizes = options.sizes;
  if (options.large) sizes.push_back(kLargeSize);
  for (const int size : sizes)
    for (const std::string& kind : options.scenes) {
      const bool in_proportion = size == kLargeSize;
      for (const auto& [name, make] : detectors(options, size)) {
        if (!why_not(make()->traits(), make_scene(kind, 2)).empty()) continue;
        const std::optional<Peak> p = peak_of(name, kind, size, in_proportion);
        const std::string scene = fmt::format("{} {}", kind, size);
        if (!p) {
          table.add({scene, name, "failed"});
          continue;
        }
        table.add(
            {scene, name, fmt::format("{:.0f}", p->pairs), fmt::format("{:.1f}", 1e-6 * p->kept),
             fmt::format("{:.0f}", p->kept / p->primitives), fmt::format("{:.1f}", 1e-6 * p->peak),
             fmt::format("{:.0f}", p->peak / (p->primitives + p->pairs)), milliseconds(p->warm)});
      }
    }
  return table;
}

/// Seconds per frame of every detector while the cloth moves.
Table frame_table(const BenchOptions& options) {
  Table table({"scene", "detector", "threads", "m/s", "mean ms", "median ms", "worst ms"});
  for (const int size : options.sizes)
    for (const std::string& kind : options.scenes)
      for (const int threads : options.threads)
        for (const double speed : {0.01, 0.05, 0.25}) {
          const ThreadLimit limit(threads);
          SearchScene scene = make_scene(kind, size);
          Measurement all;
          for (const auto& [name, make] : detectors(options, size))
            if (why_not(make()->traits(), scene).empty()) all[name].detector = make();
          for (int frame = 0; frame < options.frames; ++frame) {
            scene.cloth.x_t0 = scene.cloth.x_t1;
            // The flow alternates, because a steady flow would contract the cloth.
            move(scene, speed * std::cos(2.0 * std::numbers::pi * frame / kFramesOfASwing), 5);
            for (auto& [name, m] : all) m.warm.push_back(detect(*m.detector, scene, m.out));
          }
          for (const auto& [name, m] : all) {
            double sum = 0.0;
            for (const double s : m.warm) sum += s;
            table.add({scene.name, name, std::to_string(threads), fmt::format("{}", speed),
                       milliseconds(sum / options.frames), milliseconds(pick(m.warm, false)),
                       milliseconds(*std::max_element(m.warm.begin(), m.warm.end()))});
          }
        }
  return table;
}

Table table_of(const std::string& name, const BenchOptions& options) {
  if (name == "detectors") return detector_table(options);
  if (name == "libraries") return library_table(options);
  if (name == "spikes") return spike_table(options);
  if (name == "scaling") return scaling_table(options);
  if (name == "memory") return memory_table(options);
  return frame_table(options);
}

void read_options(const Command& app, BenchOptions& options) {
  app.option("table", options.tables,
             "tables: detectors, libraries, spikes, scaling, memory, frames")
      .one_of({"detectors", "libraries", "spikes", "scaling", "memory", "frames"});
  app.option("--detectors", options.detectors, "names of detectors (default: all)")
      .comma_separated();
  app.option("--scene", options.scenes, "scenes: drape, crumple (default: both)")
      .one_of({"drape", "crumple"})
      .comma_separated();
  app.option("--size", options.sizes, "vertices per side").range(2, 3000).comma_separated();
  app.option("--threads", options.threads, "threads").comma_separated();
  app.option("--repeats", options.repeats, "repeats; the median is printed").range(1, 1000);
  app.option("--smaller", options.smaller,
             "table spikes: size ratios of the added copy, powers of ten")
      .range(10.0, 1e9)
      .comma_separated();
  app.option("--frames", options.frames, "table frames: number of frames").range(1, 100000);
  app.option("--limit", options.limit,
             "s; a detector whose warm calls take longer is measured once");
  app.option("--largest-brute", options.largest_brute, "largest size for brute_force");
  app.option("--csv", options.csv, "also write the tables to this file");
  app.flag("--least", options.least, "print the minimum instead of the median");
  app.flag("--markdown", options.markdown, "print the tables as Markdown");
  app.flag("--large", options.large, "table memory: also 2.5 million triangles");
  app.option("--peak-of", options.peak_of, "internal").hidden();
  app.option("--peak-scene", options.peak_scene, "internal").hidden();
  app.flag("--in-proportion", options.in_proportion, "internal").hidden();
}

int run(const BenchOptions& options) {
  if (!options.peak_of.empty()) return print_peak(options);
  std::ofstream csv;
  if (!options.csv.empty()) {
    csv.open(options.csv);
    if (!csv) throw std::runtime_error("cannot write " + options.csv);
  }
  for (const std::string& name : options.tables) {
    const Table table = table_of(name, options);
    fmt::print("{}\n", options.markdown ? table.markdown() : table.text());
    std::fflush(stdout);
    if (csv.is_open()) csv << table.csv() << "\n";
  }
  return 0;
}

}  // namespace
}  // namespace broadphase_bench

int bench_broadphase(int argc, char** argv) {
  using namespace broadphase_bench;
  CommandLine app("Times, pairs and memory of the broad phases");
  BenchOptions options;
  read_options(app, options);
  if (const auto code = app.parse(argc, argv)) return *code;
  return run(options);
}

}  // namespace selvedge
