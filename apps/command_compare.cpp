// SPDX-License-Identifier: MIT
#include "command_compare.h"

#include <fmt/format.h>
#include <selvedge/apps/compare_page.h>
#include <selvedge/apps/compare_plan.h>
#include <selvedge/apps/compare_workflow.h>
#include <selvedge/apps/detail/method_choice.h>
#include <selvedge/apps/detail/progress_bar.h>
#include <selvedge/core/atomic_file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "methods.h"
#include "overrides.h"

namespace {

using namespace selvedge;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct CompareOptions {
  std::string scene, out, in, only, workflow, design = "product";
  std::vector<std::string> vary, set, reference_set;
  int threads = 1, repeats = 7, judged = 4;
  double budget = 300.0;
  bool no_reference = false, no_pictures = false, json = false;
};

void write_whole(const fs::path& file, const std::string& text) {
  AtomicFile out(file);
  out.write(text);
  out.commit();
}

std::string quoted(const std::string& word) {
  constexpr const char* plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=,:+";
  return word.find_first_not_of(plain) == std::string::npos ? word : "'" + word + "'";
}

/// What makes the same compare again, without the folder and how it is printed.
std::string command_in_words(const CompareOptions& o) {
  std::string text = "selvedge compare " + quoted(o.scene);
  const auto add = [&](const char* option, const std::vector<std::string>& values) {
    for (const std::string& value : values) text += std::string(" ") + option + " " + quoted(value);
  };
  add("--vary", o.vary);
  add("--set", o.set);
  add("--reference-set", o.reference_set);
  if (o.design != "product") text += " --design " + o.design;
  if (o.no_reference) text += " --no-reference";
  return text + fmt::format(" --repeats {} --threads {}", o.repeats, o.threads);
}

CompareRequest request_of(const CompareOptions& o) {
  CompareRequest request;
  request.scene = fs::absolute(o.scene).lexically_normal();
  request.set = read_overrides(o.set, "--set");
  request.reference_set = read_overrides(o.reference_set, "--reference-set");
  request.vary = o.vary;
  request.design = o.design == "product" ? CompareDesign::product : CompareDesign::one_at_a_time;
  request.reference = !o.no_reference;
  request.repeats = o.repeats;
  request.limits = {o.threads, o.budget, o.judged};
  request.command = command_in_words(o);
  return request;
}

/// All repeats of one cell, or of all; nothing is merged.
void run_only(const CompareOptions& o, const ComparePlan& plan, const Methods& methods) {
  int repeats = 1;  // of a reference level
  for (const CompareCell& cell : plan.cells)
    if (cell.id == o.only) repeats = plan.repeats;
  for (int repeat = 0; repeat < repeats; ++repeat)
    if (!read_cell_run(cell_folder(o.in, o.only), repeat))
      run_in_process(o.in, o.only, repeat, limits_of(plan, o.only), methods);
}

int report(const CompareOptions& o, const fs::path& out, const ComparePlan& plan,
           const Methods& methods) {
  const CompareTable table = make_table(out, plan, methods);
  write_whole(out / "compare.csv", to_csv(table));
  write_whole(out / "compare.json", to_json_text(table));
  PageConfig page;
  page.pictures = !o.no_pictures;
  write_whole(out / "compare.html", compare_page(out, table, page));
  fmt::print("{}", o.json ? to_json_text(table) : to_text(table));
  if (!o.json)
    fmt::print("{0}/compare.html, compare.csv and compare.json have all of it\n", out.string());
  return table.failed() ? 1 : 0;
}

/// What of the time was not the runs': where runs are short, take longer ones.
void print_own_share(const TimeOfRuns& time, double all_s) {
  if (time.runs == 0) return;
  std::string parts;
  double rest_s = all_s - time.run_s;
  for (const auto& [what, seconds] : time.beside_s) {
    parts += fmt::format("{} {:.2f} s, ", what, seconds);
    rest_s -= seconds;
  }
  fmt::print("{} runs took {:.2f} s, compare itself {:.1f} % more: {}the rest {:.2f} s\n",
             time.runs, time.run_s, 100.0 * (all_s / time.run_s - 1.0), parts, rest_s);
}

int run_all(const CompareOptions& o, const fs::path& out, const ComparePlan& plan,
            const Methods& methods, Clock::time_point begin) {
  const auto spent = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  const int runs = static_cast<int>(plan.levels.size() +
                                    plan.cells.size() * static_cast<std::size_t>(plan.repeats));
  ProgressBar bar("run", runs);
  const TimeOfRuns time =
      run_missing(out, plan, methods, [&](int done, int) { bar.show(done, spent()); });
  bar.clear();
  const int code = report(o, out, plan, methods);
  if (!o.json) print_own_share(time, spent());
  return code;
}

int run_planned(const CompareOptions& o, const Methods& methods, Clock::time_point begin) {
  const ComparePlan plan = read_plan(o.in);
  if (plan.build != program_hash())
    throw std::invalid_argument(o.in +
                                ": was planned by another build of this program; times and "
                                "bits of the two do not mix");
  if (o.only.empty()) {
    const FolderLock lock(o.in);
    return run_all(o, o.in, plan, methods, begin);
  }
  if (!fs::exists(cell_folder(o.in, o.only) / "scene.json"))
    throw std::invalid_argument(
        fmt::format("--only {}: there is no such cell in {}", o.only, o.in));
  run_only(o, plan, methods);
  return 0;
}

PlannedCompare planned(const CompareOptions& o, const Methods& methods) {
  return plan_compare(request_of(o), methods, [](const std::string& what) {
    fmt::print(stderr, "note: cannot run, and is marked: {}\n", what);
  });
}

int make_workflow(const CompareOptions& o, const Methods& methods) {
  const PlannedCompare made = planned(o, methods);
  const FolderLock lock(o.workflow);
  write_plan(o.workflow, made.plan, made.scene_of_id);
  write_workflow(o.workflow, made.plan);
  fmt::print("{0}/Snakefile: {1} jobs; run them with: cd {0} && snakemake --cores 2\n", o.workflow,
             made.plan.cells.size() + made.plan.levels.size() + 1);
  return 0;
}

/// Plans into the folder in a copy of this process, so that this one never has a second thread and
/// can be copied for every run (run_in_process). What the copy throws its own `main` says; returns
/// its exit code.
int plan_in_a_copy(const CompareOptions& o, const fs::path& out, const Methods& methods) {
  const pid_t copy = fork();
  if (copy < 0) throw std::runtime_error("no process for the plan could be started");
  if (copy == 0) {
    const PlannedCompare made = planned(o, methods);
    const FolderLock lock(out);
    write_plan(out, made.plan, made.scene_of_id);
    std::fflush(nullptr);
    _exit(0);
  }
  int status = 0;
  while (waitpid(copy, &status, 0) < 0 && errno == EINTR) continue;
  return WIFEXITED(status) ? WEXITSTATUS(status) : EXIT_FAILURE;
}

int run_command(const CompareOptions& o) {
  const auto begin = Clock::now();
  const Methods methods = methods_of_this_build();
  if (!o.in.empty()) return run_planned(o, methods, begin);
  if (o.scene.empty())
    throw std::invalid_argument("compare: give a scene file and what to vary in it");
  if (o.vary.empty())
    throw std::invalid_argument(
        "compare: give --vary, such as --vary broad_phase or dt=1e-3..1e-2:5");
  if (!o.workflow.empty()) return make_workflow(o, methods);
  fs::path out = o.out;
  if (out.empty())
    out = fs::path("out") / ("compare_" + read_scene(o.scene, read_overrides(o.set), methods).name);
  if (const int code = plan_in_a_copy(o, out, methods); code != 0) return code;
  const FolderLock lock(out);
  return run_all(o, out, read_plan(out), methods, begin);
}

void add_options(CLI::App& command, CompareOptions& o) {
  command.add_option("scene", o.scene, "Scene file (JSON)");
  command
      .add_option("--vary", o.vary,
                  "NAME=a,b,c or NAME=lo..hi:n or \"NAME=lo..hi:n log\" or NAME,NAME (all values "
                  "of each); may be given several times")
      ->allow_extra_args(false);
  command.add_option("--design", o.design, "product: every combination; one: one at a time")
      ->check(CLI::IsMember({"product", "one"}));
  command.add_option("--set", o.set, "path=value replaces a value of the scene file in all cells")
      ->allow_extra_args(false);
  command
      .add_option("--reference-set", o.reference_set,
                  "path=value of the scene of the converged reference alone")
      ->allow_extra_args(false);
  command.add_flag("--no-reference", o.no_reference, "No errors: times and detectors only");
  command.add_option("--out", o.out,
                     "Folder (default: out/compare_NAME); started again it goes on");
  command.add_option("--repeats", o.repeats, "Runs of each cell (default 7)")
      ->check(CLI::Range(1, 1000));
  command.add_option("--threads", o.threads, "Threads of a run (default 1); 0: all")
      ->check(CLI::Range(0, 1024));
  command.add_option("--budget", o.budget, "Wall seconds granted to a run (default 300)")
      ->check(CLI::PositiveNumber);
  command.add_option("--judge", o.judged, "Motions on which detectors are judged (default 4)")
      ->check(CLI::Range(0, 1000));
  command.add_flag("--no-pictures", o.no_pictures, "No thumbnails in the page");
  command.add_flag("--json", o.json, "Print JSON");
  command.add_option("--in", o.in, "Go on with the compare in this folder");
  command.add_option("--only", o.only, "With --in: the runs of this cell alone, nothing is merged");
  command.add_option(
      "--workflow", o.workflow,
      "Folder for a Snakemake workflow of this compare, one job a cell; nothing runs");
}

std::string footer() {
  std::string names;
  for (const auto& [name, key] : short_axes()) names += (names.empty() ? "" : ", ") + name;
  return "Short names: " + names +
         ";\nany path of the scene file serves as well. mesh: particles on a side, dt: seconds a "
         "step.\nEvery run has a process of its own; rounds of repeats are interleaved.\n"
         "Exit code: 0 done, 1 a method broke its promise (FAILURE), 2 bad input.";
}

}  // namespace

void add_command_compare(CLI::App& app, int& exit_code) {
  const auto o = std::make_shared<CompareOptions>();
  CLI::App* command =
      app.add_subcommand("compare", "Error against run time, over what is varied in a scene");
  add_options(*command, *o);
  command->footer(footer());
  command->callback([o, &exit_code] { exit_code = run_command(*o); });
}
