// SPDX-License-Identifier: MIT
// Time by phase of a drape. The program runs 120 frames of one scene with 50, 100 and 200 particles
// a side (or the given sizes), from scene file to written frames, and prints a table in Markdown or
// JSON. Each size runs in a separate process, so that its peak memory is measured alone. The exact
// predicates of `check` judge each last frame, outside the measured time.
#include <selvedge/apps/command_line.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/parallel.h>
#include <selvedge/judge/judge.h>
#include <selvedge/run/run.h>

#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Options {
  std::vector<int> sizes = {50, 100, 200};  // particles a side
  fs::path scene = SELVEDGE_SOURCE_DIR "/data/scenes/cloth_on_sphere.json";
  fs::path out = "bench_drape";
  std::vector<std::string> set;  // path=value
  int threads = 0;
  bool as_json = false;
};

Options parse(int argc, char** argv) {
  Options options;
  selvedge::CommandLine app(
      "Seconds by phase, memory and quality of a drape at several resolutions");
  app.option("sizes", options.sizes, "Particles per side of the first piece of cloth")
      .range(2, 5000);
  app.option("--scene", options.scene, "Scene file whose first piece is a grid").existing_file();
  app.option("--out", options.out, "Folder for the results");
  app.option("--set", options.set, "Scene value to change, as path=value");
  app.option("--threads", options.threads, "Maximum number of threads; 0: all").non_negative();
  app.flag("--json", options.as_json, "Print JSON instead of the table");
  if (const auto code = app.parse(argc, argv)) std::exit(*code);
  return options;
}

std::vector<selvedge::Override> overrides_of(const Options& options, int size) {
  std::vector<selvedge::Override> overrides = {
      {"geometry.0.cells", fmt::format("[{0},{0}]", size - 1)}, {"time.frames", "120"}};
  for (const std::string& text : options.set) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
      throw std::invalid_argument("--set " + text + ": write path=value");
    }
    overrides.push_back({text.substr(0, equals), text.substr(equals + 1)});
  }
  return overrides;
}

fs::path folder_of(const Options& options, int size) { return options.out / std::to_string(size); }

/// Runs in the child process; exits with 0, or with 1 after a message.
int run_one(const Options& options, int size) try {
  const selvedge::ThreadLimit limit(options.threads);
  selvedge::RunConfig config;
  config.out = folder_of(options, size);
  run_scene(selvedge::read_scene(options.scene, overrides_of(options, size)), config);
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "bench_drape: {} particles per side: {}\n", size, error.what());
  return 1;
}

json read_json(const fs::path& file) {
  std::ifstream in(file);
  return in ? json::parse(in) : json::object();
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// Runs one size in a child process; returns its result.json and the system's resource usage.
json measure(const Options& options, int size) {
  fs::remove_all(folder_of(options, size));
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (child == 0) _exit(run_one(options, size));
  int status = 0;
  rusage usage{};
  if (wait4(child, &status, 0, &usage) < 0) {
    throw std::system_error(errno, std::generic_category(), "wait4");
  }
  json result = read_json(folder_of(options, size) / "result.json");
  result["particles_a_side"] = size;
  result["completed"] = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  result["cpu_s"] = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  result["process_peak_bytes"] = static_cast<std::size_t>(usage.ru_maxrss) * 1024;  // kB on Linux
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

void add_verdict(const Options& options, json& result) {
  const fs::path frames = folder_of(options, result["particles_a_side"]) / "frames";
  const fs::path cloth = last_frame(frames, "cloth_"), bodies = last_frame(frames, "bodies_");
  if (cloth.empty()) return;
  const selvedge::TriangleMesh body =
      bodies.empty() ? selvedge::TriangleMesh{} : selvedge::read_mesh(bodies);
  const selvedge::Verdict verdict = selvedge::judge(selvedge::read_mesh(cloth), body, {});
  result["body_triangles"] = body.triangles.size();
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

std::string found_in(const json& result) {
  if (!result.contains("last_frame")) return "-";
  const json& found = result["last_frame"];
  return fmt::format("{}", number(found, "self_intersections") +
                               number(found, "body_intersections") +
                               number(found, "inside_vertices"));
}

void print_table(const std::vector<json>& results) {
  const std::vector<std::string> phases = phases_of(results);
  std::string head = "| particles | wall s | CPU s |", rule = "| --: | --: | --: |";
  for (const std::string& phase : phases) {
    head += " " + phase + " s |";
    rule += " --: |";
  }
  fmt::print("{} peak MB | steps | stretch % | rest speed mm/s | clean | faults in last frame |\n",
             head);
  fmt::print("{} --: | --: | --: | --: | --- | --: |\n", rule);
  for (const json& result : results) {
    const int size = result["particles_a_side"];
    fmt::print("| {}x{} | {:.1f} | {:.1f} |", size, size, number(result, "wall_s"),
               number(result, "cpu_s"));
    const json times = result.value("phase_s", json::object());
    for (const std::string& phase : phases) fmt::print(" {:.2f} |", number(times, phase));
    fmt::print(" {:.0f} | {} | {:.2f} | {:.2f} | {} | {} |\n",
               1e-6 * number(result, "process_peak_bytes"), number(result, "steps"),
               100.0 * number(result, "max_stretch"), 1e3 * number(result, "final_max_speed"),
               result.value("clean", false) && result["completed"].get<bool>() ? "yes" : "NO",
               found_in(result));
  }
  for (const json& result : results) {
    if (!result.contains("counters")) continue;
    fmt::print("\n{}: {}", result["particles_a_side"].get<int>(), result["counters"].dump());
  }
  fmt::print("\n");
}

bool is_good(const json& result) {
  return result["completed"].get<bool>() && result.value("clean", false) && found_in(result) == "0";
}

}  // namespace

int main(int argc, char** argv) try {
  const Options options = parse(argc, argv);
  std::vector<json> results;
  for (const int size : options.sizes) results.push_back(measure(options, size));
  // Start threads only now: a process with threads cannot be forked safely.
  for (json& result : results) add_verdict(options, result);
  if (options.as_json) {
    const int threads = options.threads > 0 ? options.threads : selvedge::thread_count();
    fmt::print("{}\n", json{{"threads", threads}, {"results", results}}.dump(2));
  } else {
    print_table(results);
  }
  return std::all_of(results.begin(), results.end(), is_good) ? 0 : 1;
} catch (const std::exception& error) {
  fmt::print(stderr, "bench_drape: {}\n", error.what());
  return 2;
}
