// SPDX-License-Identifier: MIT
#include "command_compare.h"

#include <fmt/format.h>
#include <selvedge/apps/compare_page.h>
#include <selvedge/apps/compare_plan.h>
#include <selvedge/apps/compare_workflow.h>
#include <selvedge/apps/detail/method_choice.h>
#include <selvedge/apps/detail/progress_bar.h>
#include <selvedge/core/atomic_file.h>
#include <selvedge/core/parallel.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#ifdef __linux__
#include <sys/prctl.h>
#endif

#include "methods.h"
#include "overrides.h"

namespace {

using namespace selvedge;
namespace fs = std::filesystem;

struct CompareOptions {
  std::string scene, out, in, only, workflow, design = "product";
  std::vector<std::string> vary, set, reference_set;
  int threads = 1, repeats = 7, repeat = -1, judged = 4;
  double budget = 300.0;
  bool no_reference = false, no_pictures = false, json = false, run_here = false;
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

/// A run of one cell, in this process: it dies with whoever started it.
int run_one(const CompareOptions& o, const ComparePlan& plan, const Methods& methods) {
#ifdef __linux__
  prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
  CellLimits limits = plan.limits;
  for (const CompareCell& cell : plan.cells)
    if (cell.id == o.only) limits.threads = cell.threads;
  run_cell(cell_folder(o.in, o.only), o.repeat, limits, methods);
  return 0;
}

/// All repeats of one cell, or of all; nothing is merged.
void run_only(const CompareOptions& o, const ComparePlan& plan, const Methods& methods) {
  CellLimits limits = plan.limits;
  int repeats = 1;  // of a reference level
  for (const CompareCell& cell : plan.cells)
    if (cell.id == o.only) repeats = plan.repeats;
  for (int repeat = 0; repeat < repeats; ++repeat)
    if (!read_cell_run(cell_folder(o.in, o.only), repeat))
      run_in_process(o.in, o.only, repeat, limits, methods);
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

int run_all(const CompareOptions& o, const fs::path& out, const ComparePlan& plan,
            const Methods& methods) {
  const auto begin = std::chrono::steady_clock::now();
  const int runs = static_cast<int>(plan.levels.size() +
                                    plan.cells.size() * static_cast<std::size_t>(plan.repeats));
  ProgressBar bar("run", runs);
  run_missing(out, plan, methods, [&](int done, int) {
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
    bar.show(done, spent.count());
  });
  bar.clear();
  return report(o, out, plan, methods);
}

int run_planned(const CompareOptions& o, const Methods& methods) {
  const ComparePlan plan = read_plan(o.in);
  // A run for another process of this compare, which has looked at it.
  if (!o.run_here && plan.build != program_hash())
    throw std::invalid_argument(o.in +
                                ": was planned by another build of this program; times and "
                                "bits of the two do not mix");
  if (o.only.empty()) {
    const FolderLock lock(o.in);
    return run_all(o, o.in, plan, methods);
  }
  if (!fs::exists(cell_folder(o.in, o.only) / "scene.json"))
    throw std::invalid_argument(
        fmt::format("--only {}: there is no such cell in {}", o.only, o.in));
  if (o.run_here) return run_one(o, plan, methods);
  run_only(o, plan, methods);
  return 0;
}

int make_workflow(const CompareOptions& o, const PlannedCompare& planned) {
  const FolderLock lock(o.workflow);
  write_plan(o.workflow, planned.plan, planned.scene_of_id);
  write_workflow(o.workflow, planned.plan);
  fmt::print("{0}/Snakefile: {1} jobs; run them with: cd {0} && snakemake --cores 2\n", o.workflow,
             planned.plan.cells.size() + planned.plan.levels.size() + 1);
  return 0;
}

/// On one thread: a process that never had a second one is copied for a run (run_in_process).
PlannedCompare plan_on_one_thread(const CompareOptions& o, const Methods& methods) {
  const ThreadLimit one(1);
  return plan_compare(request_of(o), methods, [](const std::string& what) {
    fmt::print(stderr, "note: cannot run, and is marked: {}\n", what);
  });
}

int run_command(const CompareOptions& o) {
  const Methods methods = methods_of_this_build();
  if (!o.in.empty()) return run_planned(o, methods);
  if (o.scene.empty())
    throw std::invalid_argument("compare: give a scene file and what to vary in it");
  if (o.vary.empty())
    throw std::invalid_argument(
        "compare: give --vary, such as --vary broad_phase or dt=1e-3..1e-2:5");
  const PlannedCompare planned = plan_on_one_thread(o, methods);
  if (!o.workflow.empty()) return make_workflow(o, planned);
  const fs::path out =
      o.out.empty() ? fs::path("out") / ("compare_" + planned.plan.name) : fs::path(o.out);
  const FolderLock lock(out);
  write_plan(out, planned.plan, planned.scene_of_id);
  return run_all(o, out, planned.plan, methods);
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
  command.add_option("--repeat", o.repeat)->group("");
  command.add_flag("--run-here", o.run_here)->group("");
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
