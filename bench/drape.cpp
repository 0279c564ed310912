// SPDX-License-Identifier: MIT
// Time by phase of a drape. The program runs 120 frames of a sheet on a body, or of a garment, with
// 50, 100 and 200 particles per side (or the given sizes), from scene file to written frames, and
// prints tables in Markdown, or JSON: times, cost of the solver beside the bandwidth of the memory,
// memory and quality. Each row runs in a separate process, so that its peak memory is measured
// alone. The exact predicates of `check` judge each last frame, outside the measured time.
#include <selvedge/apps/command_line.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/judge/judge.h>
#include <selvedge/run/run.h>

#include "bench.h"
#include "drape_scenes.h"
#include "table.h"
#include "triad.h"

#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

namespace selvedge {
namespace drape_bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Options {
  std::vector<int> sizes = {50, 100, 200};  // particles per side
  std::vector<std::string> bodies, garments;
  fs::path scene;  // empty: bodies and garments
  std::string up = "z";
  double unit = 1.0;  // m
  int subdivisions = 0;
  int frames = 120;
  fs::path out = "bench_drape";
  std::vector<std::string> set;  // path=value
  std::vector<int> threads = {0};
  bool as_json = false, write_scenes = false, triad = false, no_judge = false;
};

Options parse(int argc, char** argv) {
  Options options;
  selvedge::CommandLine app(
      "Seconds by phase, cost of the solver, memory and quality of a drape at several resolutions");
  app.option("sizes", options.sizes,
             "Particles per side of the sheet; a garment has about as many as a sheet")
      .range(2, 5000);
  const auto scene = app.option("--scene", options.scene, "Scene file whose first piece is a grid")
                         .existing_file();
  app.option("--body", options.bodies,
             "ball (radius 0.25 m, 64 segments; the default), mannequin or a mesh file. A sheet "
             "of 1 m and 0.2 kg/m² starts 2 cm above the highest point; friction 0.3. The mesh "
             "stays where it is and as large as it is, except for --unit and --up")
      .comma_separated()
      .one_word()
      .excludes(scene);
  app.option("--garment", options.garments,
             "poncho, skirt or torso: about 1 m² of cloth on a triangle mesh, on the mannequin")
      .comma_separated()
      .one_word()
      .excludes(scene);
  app.option("--unit", options.unit, "Metres per unit of the mesh file").positive();
  app.option("--up", options.up, "Axis of the mesh file that points up").one_of({"x", "y", "z"});
  app.option("--subdivide", options.subdivisions,
             "Times that every triangle of a body mesh is split in four")
      .range(0, 6);
  app.option("--frames", options.frames, "Frames at 60 per second").range(1, 99999);
  app.option("--out", options.out, "Folder for the results");
  app.option("--set", options.set, "Scene value to change, as path=value").one_word();
  app.option("--threads", options.threads,
             "Maximum number of threads; 0: all. With several numbers each scene runs with each of "
             "them and must end in the same bits")
      .non_negative()
      .comma_separated()
      .one_word();
  app.flag("--json", options.as_json, "Print JSON instead of the tables");
  app.flag("--write-scenes", options.write_scenes,
           "Only write the scene files of --body and --garment, and print their paths")
      .excludes(scene);
  app.flag("--triad", options.triad, "Only measure the bandwidth of the memory");
  app.flag("--no-judge", options.no_judge, "Do not judge the last frames");
  if (const auto code = app.parse(argc, argv)) std::exit(*code);
  if (options.bodies.empty() && options.garments.empty() && options.scene.empty())
    options.bodies = {"ball"};
  return options;
}

/// One row of the tables.
struct Row {
  fs::path scene_file;  // empty: `scene`
  selvedge::bench::DrapeScene scene;
  int size = 0;
  std::string name;
  int threads = 0;  // 0: all
};

std::vector<Row> rows_of(const Options& options) {
  std::vector<Row> rows;
  const auto add = [&](Row row) {
    for (const int size : options.sizes) {
      for (const int threads : options.threads) {
        row.size = size;
        row.threads = threads;
        rows.push_back(row);
      }
    }
  };
  if (!options.scene.empty())
    add({.scene_file = options.scene, .scene = {}, .name = options.scene.stem().string()});
  selvedge::bench::DrapeScene scene{.subdivisions = options.subdivisions, .frames = options.frames};
  scene.load.unit = options.unit;
  scene.load.up = options.up == "x"   ? selvedge::UpAxis::x
                  : options.up == "y" ? selvedge::UpAxis::y
                                      : selvedge::UpAxis::z;
  for (const std::string& body : options.bodies) {
    scene.body = body;
    add({.scene_file = {}, .scene = scene, .name = scene.name()});
  }
  for (const std::string& garment : options.garments) {
    scene.garment = garment;
    add({.scene_file = {}, .scene = scene, .name = scene.name()});
  }
  return rows;
}

fs::path folder_of(const Options& options, const Row& row) {
  const std::string threads = row.threads == 0 ? "" : fmt::format("_threads_{}", row.threads);
  return options.out / fmt::format("{}_{}{}", row.name, row.size, threads);
}

std::vector<selvedge::Override> overrides_of(const Options& options, const Row& row) {
  std::vector<selvedge::Override> overrides;
  if (!row.scene_file.empty()) {
    overrides = {{"geometry.0.cells", fmt::format("[{0},{0}]", row.size - 1)},
                 {"time.frames", std::to_string(options.frames)}};
  }
  for (const std::string& text : options.set) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
      throw std::invalid_argument("--set " + text + ": write path=value");
    }
    overrides.push_back({text.substr(0, equals), text.substr(equals + 1)});
  }
  return overrides;
}

/// How a child process ended, and what it used.
struct ChildEnd {
  int code = -1;  // -1: killed by a signal
  rusage usage{};
};

/// Runs the task in a child process, which prints the message of an exception. The exit code is 0,
/// after std::invalid_argument 2, and after any other exception 1.
template <class Task>
ChildEnd in_child(const Row& row, const Task& task) {
  const auto fail = [&](const std::exception& error, int code) {
    fmt::print(stderr, "bench drape: {}, {} particles per side: {}\n", row.name, row.size,
               error.what());
    return code;
  };
  const auto code_of_task = [&] {
    try {
      task();
      return 0;
    } catch (const std::invalid_argument& error) {
      return fail(error, 2);
    } catch (const std::exception& error) {
      return fail(error, 1);
    }
  };
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (child == 0) _exit(code_of_task());
  int status = 0;
  ChildEnd end;
  if (wait4(child, &status, 0, &end.usage) < 0)
    throw std::system_error(errno, std::generic_category(), "wait4");
  if (WIFEXITED(status)) end.code = WEXITSTATUS(status);
  if (end.code == 2) std::exit(2);
  return end;
}

fs::path scene_folder(const Options& options, const Row& row) {
  return folder_of(options, row) / "scene";
}

void run_row(const Options& options, const Row& row) {
  const selvedge::ThreadLimit limit(row.threads);
  const fs::path file =
      row.scene_file.empty() ? scene_folder(options, row) / "scene.json" : row.scene_file;
  selvedge::RunConfig config;
  config.out = folder_of(options, row) / "result";
  run_scene(selvedge::read_scene(file, overrides_of(options, row)), config);
}

json read_json(const fs::path& file) {
  std::ifstream in(file);
  return in ? json::parse(in) : json::object();
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// Runs one row in child processes; returns its result.json and the system's resource usage.
json measure(const Options& options, const Row& row) {
  const fs::path folder = folder_of(options, row);
  fs::remove_all(folder);
  // In a child as well: the making of a mesh shall not count, nor leave memory to the next child.
  if (row.scene_file.empty())
    in_child(row, [&] { write_drape_scene(scene_folder(options, row), row.scene, row.size); });
  const ChildEnd end = in_child(row, [&] { run_row(options, row); });
  json result = read_json(folder / "result" / "result.json");
  result["scene"] = row.name;
  result["particles_a_side"] = row.size;
  result["completed"] = end.code == 0;
  result["cpu_s"] = seconds(end.usage.ru_utime) + seconds(end.usage.ru_stime);
  result["process_peak_bytes"] =
      static_cast<std::size_t>(end.usage.ru_maxrss) * 1024;  // kB on Linux
  return result;
}

/// The file with the highest number for a stem in the folder of frames, or an empty path.
fs::path last_frame(const fs::path& frames, const std::string& stem) {
  fs::path last;
  if (!fs::exists(frames)) return last;
  for (const auto& entry : fs::directory_iterator(frames)) {
    const std::string name = entry.path().filename();
    if (name.starts_with(stem) && name > last.filename().string()) last = entry.path();
  }
  return last;
}

/// Adds what the last frame shows: particles, and the faults that the judge finds.
void add_last_frame(const Options& options, const Row& row, json& result) {
  const fs::path frames = folder_of(options, row) / "result" / "frames";
  const fs::path file = last_frame(frames, "cloth_"), bodies = last_frame(frames, "bodies_");
  if (file.empty()) return;
  const selvedge::TriangleMesh cloth = selvedge::read_mesh(file);
  result["particles"] = cloth.vertices.size();
  const selvedge::TriangleMesh body =
      bodies.empty() ? selvedge::TriangleMesh{} : selvedge::read_mesh(bodies);
  result["body_triangles"] = body.triangles.size();
  if (options.no_judge) return;
  const selvedge::Verdict verdict = selvedge::judge(cloth, body, {});
  result["last_frame"] = {{"self_intersections", verdict.self_intersections},
                          {"body_intersections", verdict.body_intersections},
                          {"inside_vertices", verdict.inside_vertices}};
}

double number(const json& object, const std::string& key) {
  return object.contains(key) && object[key].is_number() ? object[key].get<double>() : 0.0;
}

std::vector<std::string> phases_of(const std::vector<json>& results) {
  std::vector<std::string> phases;
  for (const json& result : results) {
    if (!result.contains("phase_s")) continue;
    for (const auto& [phase, time] : result["phase_s"].items()) {
      if (std::find(phases.begin(), phases.end(), phase) == phases.end()) phases.push_back(phase);
    }
  }
  return phases;
}

double counter(const json& result, const std::string& key) {
  return result.contains("counters") ? number(result["counters"], key) : 0.0;
}

double phase(const json& result, const std::string& key) {
  return result.contains("phase_s") ? number(result["phase_s"], key) : 0.0;
}

/// A quotient with these decimals, or "-" if the divisor is 0.
std::string ratio(double numerator, double divisor, int decimals) {
  return divisor > 0.0 ? fmt::format("{:.{}f}", numerator / divisor, decimals) : "-";
}

/// The quotient, or "-" if one of the two was not counted.
std::string counted_ratio(double numerator, double divisor, int decimals) {
  return numerator > 0.0 ? ratio(numerator, divisor, decimals) : "-";
}

std::vector<std::string> title_of(const json& result) {
  const int size = result["particles_a_side"];
  return {result["scene"], fmt::format("{0} x {0}", size),
          fmt::format("{}", result["threads"].get<int>())};
}

using Cells = std::vector<std::string>;

/// Prints a table in Markdown with one row per result; the first three columns name the scene.
template <class RowOf>
void print_table(const std::vector<json>& results, const Cells& columns, const RowOf& row_of) {
  Cells head = {"scene", "size", "threads"};
  head.insert(head.end(), columns.begin(), columns.end());
  Table table(head);
  for (const json& result : results) {
    Cells row = title_of(result);
    for (const std::string& cell : row_of(result)) row.push_back(cell);
    table.add(row);
  }
  fmt::print("{}\n", table.markdown());
}

void print_times(const std::vector<json>& results) {
  const Cells phases = phases_of(results);
  Cells columns = {"wall s", "CPU s"};
  for (const std::string& name : phases) columns.push_back(name + " s");
  print_table(results, columns, [&](const json& result) {
    Cells row = {fmt::format("{:.2f}", number(result, "wall_s")),
                 fmt::format("{:.2f}", number(result, "cpu_s"))};
    for (const std::string& name : phases)
      row.push_back(fmt::format("{:.2f}", phase(result, name)));
    return row;
  });
}

bool of_one_scene(const json& a, const json& b) {
  return a["scene"] == b["scene"] && a["particles_a_side"] == b["particles_a_side"];
}

/// Prints how many times faster each result is than the first one of its scene.
void print_speed_ups(const std::vector<json>& results) {
  const Cells phases = phases_of(results);
  Cells columns = {"times faster"};
  columns.insert(columns.end(), phases.begin(), phases.end());
  print_table(results, columns, [&](const json& result) {
    const json& first = *std::find_if(results.begin(), results.end(), [&](const json& other) {
      return of_one_scene(other, result);
    });
    Cells row = {ratio(number(first, "wall_s"), number(result, "wall_s"), 2)};
    for (const std::string& name : phases)
      row.push_back(ratio(phase(first, name), phase(result, name), 2));
    return row;
  });
}

void print_solver(const std::vector<json>& results) {
  const Cells columns = {"particles",
                         "steps",
                         "solves per step",
                         "iterations per step",
                         "solve us per particle and step",
                         "MB per iteration",
                         "GB/s",
                         "triad GB/s",
                         "times the limit"};
  print_table(results, columns, [&](const json& result) {
    const double steps = number(result, "steps"), solve = phase(result, "solve");
    const double bytes = counter(result, "solver_bytes");
    const double iterations = counter(result, "solver_iterations");
    const double triad = number(result, "triad_bytes_per_s");
    return Cells{fmt::format("{}", number(result, "particles")),
                 fmt::format("{}", steps),
                 ratio(counter(result, "solves"), steps, 2),
                 ratio(iterations, steps, 1),
                 ratio(1e6 * solve, steps * number(result, "particles"), 2),
                 counted_ratio(1e-6 * bytes, iterations, 2),
                 counted_ratio(1e-9 * bytes, solve, 1),
                 fmt::format("{:.1f}", 1e-9 * triad),
                 ratio(solve * triad, bytes, 1)};
  });
}

std::string found_in(const json& result, const std::string& fault) {
  if (!result.contains("last_frame")) return "-";
  return fmt::format("{}", number(result["last_frame"], fault));
}

const Cells kFaults = {"self_intersections", "body_intersections", "inside_vertices"};

void print_quality(const std::vector<json>& results) {
  const Cells columns = {"peak MB",        "kB per particle", "stretch %", "rest speed mm/s",
                         "self crossings", "body crossings",  "inside",    "clean"};
  print_table(results, columns, [](const json& result) {
    const double peak = number(result, "process_peak_bytes");
    Cells row = {fmt::format("{:.0f}", 1e-6 * peak),
                 ratio(1e-3 * peak, number(result, "particles"), 1),
                 fmt::format("{:.2f}", 100.0 * number(result, "max_stretch")),
                 fmt::format("{:.2f}", 1e3 * number(result, "final_max_speed"))};
    for (const std::string& fault : kFaults) row.push_back(found_in(result, fault));
    const bool clean = result.value("clean", false) && result["completed"].get<bool>();
    row.push_back(clean ? "yes" : "NO");
    return row;
  });
}

void print_counters(const std::vector<json>& results) {
  for (const json& result : results) {
    if (!result.contains("counters")) continue;
    fmt::print("{} {}: {}\n", result["scene"].get<std::string>(),
               result["particles_a_side"].get<int>(), result["counters"].dump());
  }
}

bool is_good(const json& result) {
  if (!result["completed"].get<bool>() || !result.value("clean", false)) return false;
  return std::all_of(kFaults.begin(), kFaults.end(), [&](const std::string& fault) {
    const std::string found = found_in(result, fault);
    return found == "0" || found == "-";
  });
}

void write_scenes(const Options& options) {
  for (const Row& row : rows_of(options)) {
    const fs::path file = write_drape_scene(scene_folder(options, row), row.scene, row.size);
    fmt::print("{}\n", file.string());
  }
}

/// Whether all finished results of a scene have the same bits; prints those that do not.
bool are_same(const std::vector<json>& results) {
  bool same = true;
  for (std::size_t i = 1; i < results.size(); ++i) {
    const json &before = results[i - 1], &result = results[i];
    const std::string hash = result.value("state_hash", "");
    const std::string hash_before = before.value("state_hash", "");
    if (!of_one_scene(before, result) || hash == hash_before || hash.empty() || hash_before.empty())
      continue;
    same = false;
    fmt::print(stderr, "bench drape: {} {}: {} and {} threads end in different states\n",
               result["scene"].get<std::string>(), result["particles_a_side"].get<int>(),
               before["threads"].get<int>(), result["threads"].get<int>());
  }
  return same;
}

/// Bandwidth of the memory, B/s, for each number of threads.
std::map<int, double> triads(const Options& options) {
  std::map<int, double> bandwidth;
  for (const int threads : options.threads) {
    const selvedge::ThreadLimit limit(threads);
    bandwidth.try_emplace(threads, triad_bandwidth());
  }
  return bandwidth;
}

/// Returns the exit code.
int measure_all(const Options& options) {
  const std::vector<Row> rows = rows_of(options);
  std::vector<json> results;
  for (const Row& row : rows) results.push_back(measure(options, row));
  // Start threads only now: a process with threads cannot be forked safely.
  std::map<int, double> bandwidth = triads(options);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const selvedge::ThreadLimit limit(rows[i].threads);
    results[i]["threads"] = selvedge::thread_count();
    results[i]["triad_bytes_per_s"] = bandwidth[rows[i].threads];
    add_last_frame(options, rows[i], results[i]);
  }
  if (options.as_json) {
    fmt::print("{}\n", json{{"results", results}}.dump(2));
  } else {
    print_times(results);
    if (options.threads.size() > 1) print_speed_ups(results);
    print_solver(results);
    print_quality(results);
    print_counters(results);
  }
  const bool good = std::all_of(results.begin(), results.end(), is_good);
  return are_same(results) && good ? 0 : 1;
}

int measure_triad(const Options& options) {
  for (const auto& [threads, triad] : triads(options)) {
    const selvedge::ThreadLimit limit(threads);
    if (options.as_json)
      fmt::print("{}\n",
                 json{{"threads", selvedge::thread_count()}, {"triad_bytes_per_s", triad}}.dump());
    else
      fmt::print("The triad moves {:.1f} GB/s on {} threads.\n", 1e-9 * triad,
                 selvedge::thread_count());
  }
  return 0;
}

}  // namespace
}  // namespace drape_bench

int bench_drape(int argc, char** argv) {
  using namespace drape_bench;
  const Options options = parse(argc, argv);
  if (options.triad) return measure_triad(options);
  if (!options.write_scenes) return measure_all(options);
  write_scenes(options);
  return 0;
}

}  // namespace selvedge
