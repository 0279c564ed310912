// SPDX-License-Identifier: MIT
// Compares verdict and time of ccd_exact with the judge, an independent oracle in integer
// arithmetic, on any number of adversarial queries. ccd_exact answers each query twice: alone, and
// in a batch of all families. The program prints counts by family and exits with 1 on any error.
// Times are processor times.
//
// With --digest it does not run the judge. It prints one number for each vector width, a digest of
// times and contacts, for comparing builds and vector paths.
#include <fmt/format.h>
#include <selvedge/apps/command_line.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/tests/ccd_queries.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <ctime>
#include <random>
#include <string>
#include <vector>

using namespace selvedge;
using namespace selvedge::ccd_queries;

namespace {

/// Queries of each family in one task.
constexpr std::size_t kPerFamily = 32;
/// Wrong queries that are printed.
constexpr std::size_t kPrinted = 10;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Seconds that this thread has worked.
double worked() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct Tally {
  std::size_t queries = 0, hits = 0, wrong_verdicts = 0, wrong_times = 0;
  double judge_seconds = 0.0, judge_worst = 0.0, exact_seconds = 0.0, exact_worst = 0.0;

  void operator+=(const Tally& o) {
    queries += o.queries, hits += o.hits;
    wrong_verdicts += o.wrong_verdicts, wrong_times += o.wrong_times;
    judge_seconds += o.judge_seconds, exact_seconds += o.exact_seconds;
    judge_worst = std::max(judge_worst, o.judge_worst);
    exact_worst = std::max(exact_worst, o.exact_worst);
  }
};

struct Wrong {
  std::string_view family;
  Query query;
  Truth truth;
  double toi;
};

struct Report {
  std::vector<Tally> by_family;
  std::vector<Wrong> wrong;
  double slowest_seconds = 0.0;
  Query slowest{};
};

struct Task {
  std::vector<Query> queries;  // kPerFamily of each family, family after family
  std::vector<double> alone, mixed;
};

Task make_task(std::span<const Family> families, std::uint64_t seed, std::size_t index) {
  std::seed_seq seeds{seed, static_cast<std::uint64_t>(index)};
  Random r(seeds);
  Task task;
  for (const Family& family : families)
    for (std::size_t i = 0; i < kPerFamily; ++i)
      task.queries.push_back(family.make(r, kind_of_index(i)));
  task.alone.resize(task.queries.size());
  task.mixed.resize(task.queries.size());
  return task;
}

void ask_alone(const NarrowPhase& method, Task& task, Report& report) {
  for (std::size_t i = 0; i < task.queries.size(); ++i) {
    Tally& tally = report.by_family[i / kPerFamily];
    const double start = worked();
    method.find_times({&task.queries[i], 1}, {&task.alone[i], 1});
    const double seconds = worked() - start;
    tally.exact_seconds += seconds;
    tally.exact_worst = std::max(tally.exact_worst, seconds);
    if (seconds <= report.slowest_seconds) continue;
    report.slowest_seconds = seconds;
    report.slowest = task.queries[i];
  }
}

/// In an order that puts queries of different families side by side.
void ask_mixed(const NarrowPhase& method, Task& task) {
  std::vector<Query> mixed;
  const std::size_t n = task.queries.size(), families = n / kPerFamily;
  const auto place = [&](std::size_t i) { return (i % families) * kPerFamily + i / families; };
  for (std::size_t i = 0; i < n; ++i) mixed.push_back(task.queries[place(i)]);
  std::vector<double> toi(n);
  method.find_times(mixed, toi);
  for (std::size_t i = 0; i < n; ++i) task.mixed[place(i)] = toi[i];
}

bool right_verdict(const Truth& truth, double toi) {
  return (toi != kNoCollision) == truth.touches;
}

void compare(const Task& task, std::size_t i, const Family& family, Tally& tally, Report& report) {
  const double start = worked();
  const Truth truth = truth_of(task.queries[i]);
  const double seconds = worked() - start;
  tally.judge_seconds += seconds;
  tally.judge_worst = std::max(tally.judge_worst, seconds);
  ++tally.queries;
  tally.hits += truth.touches ? 1 : 0;
  for (const double toi : {task.alone[i], task.mixed[i]}) {
    if (toi == truth.toi_lo) continue;
    ++(right_verdict(truth, toi) ? tally.wrong_times : tally.wrong_verdicts);
    if (report.wrong.size() < kPrinted)
      report.wrong.push_back({family.name, task.queries[i], truth, toi});
    return;
  }
}

Report run_task(const NarrowPhase& method, std::span<const Family> families, std::uint64_t seed,
                std::size_t index) {
  Report report;
  report.by_family.resize(families.size());
  Task task = make_task(families, seed, index);
  ask_alone(method, task, report);
  ask_mixed(method, task);
  for (std::size_t i = 0; i < task.queries.size(); ++i) {
    const std::size_t f = i / kPerFamily;
    compare(task, i, families[f], report.by_family[f], report);
  }
  return report;
}

Report run(std::span<const Family> families, std::size_t tasks, std::uint64_t seed) {
  const auto method = make_ccd_exact();
  std::vector<Report> reports(tasks);
  parallel_for(tasks, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) reports[i] = run_task(*method, families, seed, i);
  });
  Report sum;
  sum.by_family.resize(families.size());
  for (const Report& report : reports) {
    for (std::size_t f = 0; f < families.size(); ++f) sum.by_family[f] += report.by_family[f];
    for (const Wrong& w : report.wrong)
      if (sum.wrong.size() < kPrinted) sum.wrong.push_back(w);
    if (report.slowest_seconds <= sum.slowest_seconds) continue;
    sum.slowest_seconds = report.slowest_seconds;
    sum.slowest = report.slowest;
  }
  return sum;
}

/// A running hash after FNV-1a of 64 bits, by words.
class Digest {
 public:
  void add(std::uint64_t word) { value_ = (value_ ^ word) * 0x100000001b3; }
  void add(double x) { add(std::bit_cast<std::uint64_t>(x)); }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325;
};

std::uint64_t digest(const NarrowPhase& method, std::span<const Query> queries) {
  Digest digest;
  std::vector<double> toi(queries.size());
  method.find_times(queries, toi);
  for (const double t : toi) digest.add(t);
  const Scene scene = scene_of(queries);
  std::vector<Contact> contacts;
  method.find_contacts(scene.a.view(), scene.b.view(), scene.pairs, contacts);
  for (const Contact& c : contacts) {
    for (const std::int32_t v : c.vertex) digest.add(static_cast<std::uint64_t>(v));
    for (const double w : c.weight) digest.add(w);
    for (const double n : c.normal) digest.add(n);
    digest.add(c.toi);
    digest.add(c.gap);
  }
  return digest.value();
}

/// Once for every width: where the processor has no such vectors, a narrower one answers.
void print_digests(std::span<const Family> families, std::size_t tasks, std::uint64_t seed) {
  std::vector<Query> queries;
  for (std::size_t i = 0; i < tasks; ++i) {
    const Task task = make_task(families, seed, i);
    queries.insert(queries.end(), task.queries.begin(), task.queries.end());
  }
  for (const int width : {2, 4, 8})
    fmt::print("width {}: {:016x}\n", width,
               digest(*make_ccd_exact({.vector_width = width}), queries));
}

void print_row(std::string_view name, const Tally& t) {
  const double n = static_cast<double>(std::max<std::size_t>(t.queries, 1));
  fmt::print("{:<30} {:>9} {:>9} {:>7} {:>7} {:>9.2f} {:>9.0f} {:>9.2f} {:>9.0f}\n", name,
             t.queries, t.hits, t.wrong_verdicts, t.wrong_times, 1e6 * t.exact_seconds / n,
             1e6 * t.exact_worst, 1e6 * t.judge_seconds / n, 1e6 * t.judge_worst);
}

Tally print_table(std::span<const Family> families, const Report& report) {
  fmt::print("{:<30} {:>9} {:>9} {:>7} {:>7} {:>9} {:>9} {:>9} {:>9}\n", "", "", "", "wrong",
             "wrong", "exact/us", "exact/us", "judge/us", "judge/us");
  fmt::print("{:<30} {:>9} {:>9} {:>7} {:>7} {:>9} {:>9} {:>9} {:>9}\n", "family", "queries",
             "hits", "verdict", "time", "mean", "max", "mean", "max");
  Tally all;
  for (std::size_t f = 0; f < families.size(); ++f) {
    print_row(families[f].name, report.by_family[f]);
    all += report.by_family[f];
  }
  print_row("all", all);
  return all;
}

void print_wrong(const Wrong& w) {
  fmt::print("\n{}: truth {} at [{:a}, {:a}], ccd_exact gives {:a}\n{}\nAs in a query file:\n{}",
             w.family, w.truth.touches ? "touches" : "apart", w.truth.toi_lo, w.truth.toi_hi, w.toi,
             hex_text(w.query), file_rows(w.query, w.truth.touches));
}

std::vector<Family> chosen(const std::vector<std::string>& names) {
  if (names.empty()) return {families().begin(), families().end()};
  std::vector<Family> out;
  for (const Family& family : families())
    if (std::find(names.begin(), names.end(), family.name) != names.end()) out.push_back(family);
  if (out.size() != names.size()) {
    std::string known;
    for (const Family& family : families()) known += fmt::format(" {}", family.name);
    fmt::print(stderr, "--families: every name must be one of:{}\n", known);
    std::exit(2);
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app("Compares ccd_exact with the judge on adversarial queries");
  std::size_t queries = 200000;
  std::uint64_t seed = 1;
  int threads = 0;
  std::vector<std::string> names;
  app.option("--queries", queries, "Minimum number of queries; rounded up to whole tasks")
      .show_default();
  app.option("--seed", seed).show_default();
  app.option("--families", names, "Names of families (default: all)");
  app.option("--threads", threads, "0: all processors").show_default();
  bool digest_only = false;
  app.flag("--digest", digest_only, "Print a digest for each vector width instead");
  if (const auto code = app.parse(argc, argv)) return *code;
  const std::vector<Family> families = chosen(names);

  const ThreadLimit limit(threads);
  const std::size_t per_task = kPerFamily * families.size();
  const std::size_t tasks = (queries + per_task - 1) / per_task;
  if (digest_only) return print_digests(families, tasks, seed), 0;
  const double start = now();
  const Report report = run(families, tasks, seed);
  const double seconds = now() - start;
  const Tally all = print_table(families, report);
  for (const Wrong& w : report.wrong) print_wrong(w);
  fmt::print("\nThe slowest query of ccd_exact, {:.0f} us: {}\n", 1e6 * report.slowest_seconds,
             hex_text(report.slowest));
  fmt::print(
      "\nseed {}, {} queries in {:.1f} s: {:.0f} per second; {} wrong verdicts, {} wrong times\n",
      seed, all.queries, seconds, static_cast<double>(all.queries) / seconds, all.wrong_verdicts,
      all.wrong_times);
  return all.wrong_verdicts + all.wrong_times > 0 ? 1 : 0;
}
