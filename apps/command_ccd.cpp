// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/method_choice.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/compare/detectors/compare_detectors.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <selvedge/scene/methods.h>

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct CcdOptions {
  std::vector<std::string> files, narrow_phase{"all"};
  std::string kind, merge;
  NarrowPhaseConfig config;
  int repeats = 5;
  bool json = false, markdown = false;
};

/// A query file and the family that it is merged into.
struct QueryFile {
  fs::path file;
  std::string family;
};

/// Queries that are reported in one line.
struct NamedQueries {
  std::string name;
  QuerySet set;
  bool times_from_file = true;
};

// -- files ----------------------------------------------------------------------------------------

bool is_query_file(const fs::path& file) {
  const std::string name = file.filename().string();
  return name.ends_with(".csv") && !name.ends_with(".toi.csv");
}

/// The first folder of `below` that is not named after a kind, else the folder that was given.
std::string family_of(const fs::path& folder, const fs::path& below) {
  for (const fs::path& part : below.parent_path())
    if (!query_kind_of(fs::path("/") / part)) return part.string();
  const fs::path given = fs::absolute(folder).lexically_normal();
  return (given.has_filename() ? given : given.parent_path()).filename().string();
}

void append_folder(const fs::path& folder, std::vector<QueryFile>& files) {
  const std::size_t before = files.size();
  std::error_code error;
  for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error))
    if (at->is_regular_file(error) && is_query_file(at->path()))
      files.push_back({at->path(), family_of(folder, at->path().lexically_relative(folder))});
  if (error) throw std::invalid_argument(folder.string() + ": cannot be read: " + error.message());
  if (files.size() == before)
    throw std::invalid_argument(folder.string() + ": holds no query file (*.csv)");
  std::sort(files.begin() + static_cast<std::ptrdiff_t>(before), files.end(),
            [](const QueryFile& a, const QueryFile& b) { return a.file < b.file; });
}

std::vector<QueryFile> query_files(const std::vector<std::string>& names) {
  std::vector<QueryFile> files;
  for (const std::string& name : names) {
    std::error_code ignored;  // an unreadable path fails with a message when it is read
    if (fs::is_directory(name, ignored))
      append_folder(name, files);
    else
      files.push_back({name, family_of(fs::path(name).parent_path() / ".", "")});
  }
  return files;
}

std::optional<ContactKind> kind_option(const std::string& kind) {
  if (kind.empty()) return {};
  return kind == "edge_edge" ? ContactKind::edge_edge : ContactKind::point_triangle;
}

QuerySet read(const fs::path& file, const CcdOptions& o) {
  std::error_code ignored;  // a missing file has a message of its own
  if (o.kind.empty() && !query_kind_of(file) && fs::is_regular_file(file, ignored))
    throw std::invalid_argument(
        file.string() +
        ": neither the file name nor a folder states the kind of the queries; "
        "give --kind point_triangle or --kind edge_edge");
  const QuerySet set = read_queries(file, kind_option(o.kind));
  for (const std::string& remark : set.remarks) print_escaped(stderr, "note: {}\n", remark);
  return set;
}

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

/// Adds to the queries of that name and kind, or as new ones.
void merge(NamedQueries&& more, std::vector<NamedQueries>& all) {
  for (NamedQueries& queries : all) {
    if (queries.name != more.name || queries.set.kind != more.set.kind) continue;
    append(queries.set.queries, more.set.queries);
    append(queries.set.truth, more.set.truth);
    append(queries.set.toi, more.set.toi);
    queries.times_from_file = queries.times_from_file && more.times_from_file;
    return;
  }
  all.push_back(std::move(more));
}

std::string name_of(const QueryFile& file, const std::string& merge) {
  if (merge == "family") return file.family;
  return merge == "kind" ? "all" : file.file.string();
}

std::vector<NamedQueries> read_all(const CcdOptions& o) {
  std::vector<NamedQueries> all;
  for (const QueryFile& file : query_files(o.files)) {
    NamedQueries queries{name_of(file, o.merge), read(file.file, o)};
    queries.times_from_file = !complete_times(queries.set);
    if (o.merge.empty())
      all.push_back(std::move(queries));
    else
      merge(std::move(queries), all);
  }
  return all;
}

// -- results --------------------------------------------------------------------------------------

struct Row {
  const NamedQueries* queries;
  std::string method;
  QueryScore score;
};

/// A method that does not serve some queries, or none.
struct SkippedMethod {
  std::string method, file, why;
};

struct MethodResults {
  std::vector<Row> rows;
  std::vector<SkippedMethod> skipped;
};

template <class T>
Json number(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json to_json(const Row& row) {
  const QueryScore& s = row.score;
  return {{"file", row.queries->name},
          {"kind", query_kind_name(row.queries->set.kind)},
          {"narrow_phase", row.method},
          {"queries", s.queries},
          {"positives", s.positives},
          {"misses", s.misses},
          {"false_alarms", s.false_alarms},
          {"late_toi", number(s.late_toi)},
          {"max_toi_error", number(s.max_toi_error)},
          {"mean_us", number(s.mean_us)},
          {"median_us", number(s.median_us)},
          {"p99_us", number(s.p99_us)},
          {"max_us", number(s.max_us)},
          {"toi_from", row.queries->times_from_file ? "file" : "ccd_exact"},
          {"first_miss", number(s.first_miss)},
          {"first_false_alarm", number(s.first_false_alarm)},
          {"slowest", number(s.slowest)}};
}

void print_json(const MethodResults& results) {
  Json rows = Json::array(), skipped = Json::array();
  for (const Row& row : results.rows) rows.push_back(to_json(row));
  for (const SkippedMethod& s : results.skipped)
    skipped.push_back({{"narrow_phase", s.method}, {"file", s.file}, {"why", s.why}});
  print_document(Json{{"results", rows}, {"skipped", skipped}});
}

std::string shown(const std::optional<double>& value, const char* format) {
  return value ? fmt::format(fmt::runtime(format), *value) : "-";
}

using Cells = std::array<std::string, 9>;

Cells cells_of(const Row& row) {
  const QueryScore& s = row.score;
  return {row.method,
          std::to_string(s.misses),
          std::to_string(s.false_alarms),
          s.late_toi ? std::to_string(*s.late_toi) : "-",
          shown(s.max_toi_error, "{:.2g}"),
          shown(s.mean_us, "{:.4f}"),
          shown(s.median_us, "{:.4f}"),
          shown(s.p99_us, "{:.4f}"),
          shown(s.max_us, "{:.3f}")};
}

void print_cells(const Cells& cells, bool markdown, bool head) {
  if (markdown) {
    print_escaped("{}| {} |\n", head ? "\n" : "", fmt::join(cells, " | "));
    if (head) print_escaped("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
    return;
  }
  print_escaped("{:<24}{:>8}{:>8}{:>8}", cells[0], cells[1], cells[2], cells[3]);
  for (std::size_t i = 4; i < cells.size(); ++i) print_escaped(" {:>10}", cells[i]);
  print_escaped("\n");
}

std::string heading(const NamedQueries& queries, const QueryScore& score) {
  return fmt::format("{}: {} {} {}, {} {}{}", queries.name, score.queries,
                     query_kind_name(queries.set.kind), score.queries == 1 ? "query" : "queries",
                     score.positives, score.positives == 1 ? "collides" : "collide",
                     queries.times_from_file ? "" : "; their times as ccd_exact finds them");
}

/// One table for each set of queries.
void print_tables(const MethodResults& results, bool markdown) {
  const NamedQueries* last = nullptr;
  for (const Row& row : results.rows) {
    if (row.queries != last) {
      print_escaped("{}{}{}\n", last ? "\n" : "", markdown ? "### " : "",
                    heading(*row.queries, row.score));
      print_cells(
          {"", "misses", "false", "late", "time off", "mean us", "median us", "99 % us", "max us"},
          markdown, true);
    }
    last = row.queries;
    print_cells(cells_of(row), markdown, false);
  }
  for (const SkippedMethod& s : results.skipped)
    print_escaped(stderr, "note: {} left out{}: {}\n", s.method,
                  s.file.empty() ? "" : " for " + s.file, s.why);
}

/// The method, or null if it refuses the configuration and the user asked for all methods.
std::unique_ptr<NarrowPhase> make(const std::string& name, const MethodChoice& choice,
                                  const NarrowPhaseRegistry& registry,
                                  const NarrowPhaseConfig& config, MethodResults& results) {
  try {
    return registry.at(name)(narrow_options(registry.at(name).options(), config, choice.all));
  } catch (const std::invalid_argument& error) {
    const std::string why = without_name(name, error.what());
    if (!choice.all) throw std::invalid_argument(name + ": " + why);
    results.skipped.push_back({name, "", why});
    return nullptr;
  }
}

MethodResults score_all(const std::vector<NamedQueries>& all, const MethodChoice& choice,
                        const NarrowPhaseRegistry& registry, const CcdOptions& o) {
  MethodResults results;
  std::vector<std::pair<std::string, std::unique_ptr<NarrowPhase>>> methods;
  for (const std::string& name : choice.names)
    if (auto method = make(name, choice, registry, o.config, results))
      methods.emplace_back(name, std::move(method));
  for (const NamedQueries& queries : all)
    for (const auto& [name, method] : methods) try {
        results.rows.push_back({&queries, name, score_queries(*method, queries.set, o.repeats)});
      } catch (const std::invalid_argument& error) {  // a method for the other kind only
        results.skipped.push_back({name, queries.name, without_name(name, error.what())});
      }
  if (results.rows.empty() && !results.skipped.empty())
    throw std::invalid_argument(results.skipped.front().method + ": " +
                                results.skipped.front().why);
  return results;
}

void run_command(const CcdOptions& o) {
  const NarrowPhaseRegistry registry = methods_of_this_build().narrow_phases;
  const MethodChoice choice = choose_methods(o.narrow_phase, registry, "--narrow-phase");
  const std::vector<NamedQueries> all = read_all(o);
  const MethodResults results = score_all(all, choice, registry, o);
  if (o.json)
    print_json(results);
  else
    print_tables(results, o.markdown);
}

void add_ccd_options(const Command& command) {
  const auto o = std::make_shared<CcdOptions>();
  command
      .option("QUERIES", o->files,
              "Query files (eight rows a query: x_num,x_den,y_num,y_den,z_num,z_den,truth), or "
              "folders of them; X.toi.csv beside X.csv gives the times")
      .required();
  command
      .option("--narrow-phase", o->narrow_phase,
              "Names, separated by commas, or all (the default); `selvedge list` shows "
              "them")
      .comma_separated()
      .one_word();
  command
      .option("--kind", o->kind,
              "Kind of all queries; required if neither file names nor folders state it")
      .one_of({"point_triangle", "edge_edge"});
  command
      .option("--merge", o->merge,
              "One result for each kind and family (subfolder of the given folder), or "
              "for each kind, instead of each file")
      .one_of({"family", "kind"});
  command
      .option("--min-separation", o->config.min_separation,
              "Minimum separation, metres: nearer primitives count as colliding. The "
              "answers in the files are for 0, so earlier times count as false alarms")
      .non_negative();
  command
      .option("--repeats", o->repeats, "Repeats of each measurement (default 5); 0: verdicts only")
      .range(0, 1000);
  command.flag("--json", o->json, "Print JSON");
  command.flag("--markdown", o->markdown, "Print the tables as Markdown");
  command.footer(
      "Times are of one thread, the least of the repeats, so interruptions do not count.\n"
      "mean: calls with all queries at once, warm. median, 99 % and max: single queries,\n"
      "each repeated 32 times in one call (once if it takes more than 50 us). late: times\n"
      "of impact later than the true one. time off: largest distance from the enclosure of\n"
      "the true time, as a fraction of the step. Without an X.toi.csv, the times of\n"
      "ccd_exact are the true ones.\n"
      "Exit code: 0 done, 2 bad input.");
  command.action([o] {
    run_command(*o);
    return 0;
  });
}

}  // namespace

selvedge::ProgramCommand ccd_command() {
  return {
      .name = "ccd",
      .purpose = "Compare narrow phases on queries with known answers: misses, false alarms, time",
      .add_options = add_ccd_options};
}
