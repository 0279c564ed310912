// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/compare/compare_table.h>
#include <selvedge/compare/detail/compare_error.h>
#include <selvedge/core/base/internal/text.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>
#include <type_traits>
#include <utility>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

/// All finished runs of one cell, by repeat.
std::map<int, CellRun> good_runs(const fs::path& out, const std::string& id, int repeats) {
  std::map<int, CellRun> runs;
  for (int repeat = 0; repeat < repeats; ++repeat)
    if (auto run = read_cell_run(cell_folder(out, id), repeat); run && run->status == RunStatus::ok)
      runs[repeat] = std::move(*run);
  return runs;
}

/// Members of an `ensemble` start differently and end in different bits.
void add_times(const std::map<int, CellRun>& runs, const std::map<int, CellRun>& first,
               bool ensemble, CompareRow& row) {
  std::vector<double> seconds, ratios;
  std::map<std::string, std::vector<double>> phases;
  for (const auto& [repeat, run] : runs) {
    seconds.push_back(run.run_s);
    if (const auto at = first.find(repeat); at != first.end())
      ratios.push_back(run.run_s / at->second.run_s);
    for (const auto& [phase, s] : run.result.phase_s) phases[phase].push_back(s);
    if (!ensemble && run.result.state_hash != row.run.result.state_hash && row.failure.empty())
      row.failure = fmt::format("repeat {} ended in other bits than the first", repeat);
  }
  row.repeats = static_cast<int>(runs.size());
  row.run_s = quartiles(seconds);
  row.ratio = quartiles(ratios);
  for (const auto& [phase, s] : phases) row.phase_s[phase] = quartiles(s).median;
}

/// An ensemble of which one member did not finish has no mean.
void note_failed_member(const fs::path& out, const ComparePlan& plan, CompareRow& row) {
  for (int member = 0; member < plan.repeats && row.status == RunStatus::ok; ++member) {
    const auto run = read_cell_run(cell_folder(out, row.id), member);
    if (run && run->status == RunStatus::ok) {
      row.run.result.clean = row.run.result.clean && run->result.clean;
      continue;
    }
    row.status = run ? run->status : RunStatus::crashed;
    row.why = fmt::format("seed {}: {}", member + 1, run ? run->why : "has not been run yet");
  }
}

CompareRow make_row(const fs::path& out, const ComparePlan& plan, const CompareCell& cell,
                    const std::map<int, CellRun>& first) {
  CompareRow row;
  row.id = cell.id;
  row.label = cell.values.empty() ? plan.name : joined(cell.values, ", ");
  row.values = cell.values;
  row.command = command_of(plan, cell);
  if (!cell.impossible.empty()) {
    row.status = RunStatus::refused;
    row.why = cell.impossible;
    return row;
  }
  const auto run = read_cell_run(cell_folder(out, cell.id), 0);
  if (!run) {
    row.status = RunStatus::crashed;
    row.why = "has not been run yet";
    return row;
  }
  row.run = *run;
  row.status = run->status;
  row.why = run->why;
  row.failure = run->pairs.failure;
  add_times(good_runs(out, cell.id, plan.repeats), first, plan.limits.seeds, row);
  if (plan.limits.seeds) note_failed_member(out, plan, row);
  return row;
}

void add_errors(const fs::path& out, const detail::Reference& reference, CompareTable& table) {
  const int members = level_runs(table.plan);
  const detail::ErrorQuantity& chosen = detail::error_quantity(table.plan.error);
  std::optional<detail::CellEnd> first;
  for (CompareRow& row : table.rows) {
    if (row.status != RunStatus::ok) continue;
    const auto end = detail::read_cell_end(cell_folder(out, row.id), members);
    if (!end) continue;
    if (&row == &table.rows.front()) first = end;
    for (const detail::ErrorQuantity& quantity : detail::error_quantities())
      if (const auto error = reference.error(quantity, row.id, *end))
        row.errors[std::string(quantity.name)] = error->value;
    if (const auto error = reference.error(chosen, row.id, *end)) {
      row.error = error->value;
      row.error_half = error->half;
      row.counts = error->value > std::max(table.uncertainty, error->half);
    }
    if (!first) continue;
    if (const auto deviation = difference(chosen, *end, *first)) row.deviation = deviation->value;
  }
}

bool competes(const CompareRow& row) {
  return row.status == RunStatus::ok && row.counts && row.failure.empty() && row.run.result.clean;
}

void mark_front(std::vector<CompareRow>& rows) {
  for (CompareRow& row : rows)
    row.pareto = competes(row) && std::none_of(rows.begin(), rows.end(), [&](const CompareRow& r) {
                   return competes(r) && *r.error <= *row.error &&
                          r.run_s.median <= row.run_s.median &&
                          (*r.error < *row.error || r.run_s.median < row.run_s.median);
                 });
}

std::string figure(double value) {
  return std::isfinite(value) ? fmt::format("{:.6g}", value) : "";
}
std::string figure(const std::optional<double>& value) { return value ? figure(*value) : ""; }

/// Names and values of a row; every row of a table has the same names.
using RowText = std::vector<std::pair<std::string, std::string>>;

std::set<std::string> phases_of(const CompareTable& table) {
  std::set<std::string> phases;
  for (const CompareRow& row : table.rows)
    for (const auto& [phase, s] : row.phase_s) phases.insert(phase);
  return phases;
}

double counter(const CompareRow& row, const char* name) {
  const auto found = row.run.result.counters.find(name);
  return found == row.run.result.counters.end() ? 0.0 : found->second;
}

std::string cell_text(double value) { return figure(value); }
template <std::integral T>
std::string cell_text(T value) {
  return std::to_string(value);
}
std::string cell_text(const std::string& text) { return text; }
std::string cell_text(bool value) { return value ? "yes" : "no"; }

/// Calls visit(name, value) for the fields of the result that are table columns.
template <class Visit>
void visit_columns(const RunResult& r, const Visit& visit) {
  Fields<RunResult>::visit([&](const char* name, auto member, FieldRule rule) {
    using T = std::remove_cvref_t<decltype(r.*member)>;
    if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>)
      if (rule.column) visit(name, r.*member);
  });
}

void add_result_columns(const CompareRow& row, RowText& f) {
  visit_columns(row.run.result, [&](const char* name, const auto& value) {
    // An unfinished run does not fill columns such as "clean".
    const bool says =
        !std::is_same_v<std::remove_cvref_t<decltype(value)>, bool> || row.status == RunStatus::ok;
    f.emplace_back(name, says ? cell_text(value) : "");
  });
}

/// Simulated seconds per second of the run: 1 is real time.
double simulated_per_second(const CompareRow& row) {
  return row.run_s.median > 0.0 ? row.run.end_s / row.run_s.median : 0.0;
}

RowText fields(const CompareTable& table, const CompareRow& row,
               const std::set<std::string>& phases) {
  const bool ok = row.status == RunStatus::ok;
  const auto if_ok = [&](const std::string& text) { return ok ? text : std::string(); };
  RowText f;
  for (std::size_t a = 0; a < table.plan.axes.size(); ++a)
    f.emplace_back(table.plan.axes[a].name, row.values[a]);
  f.emplace_back("status", status_word(row.status));
  f.emplace_back("error", figure(row.error));
  f.emplace_back("counts", row.error ? (row.counts ? "yes" : "no") : "");
  f.emplace_back("deviation", figure(row.deviation));
  if (table.plan.limits.seeds) f.emplace_back("error_half_interval", figure(row.error_half));
  for (const std::string& quantity : error_names()) {
    const auto found = row.errors.find(quantity);
    f.emplace_back("error_" + quantity, found == row.errors.end() ? "" : figure(found->second));
  }
  add_result_columns(row, f);
  f.emplace_back("recall", if_ok(figure(row.run.pairs.recall)));
  f.emplace_back("colliding", if_ok(std::to_string(row.run.pairs.colliding)));
  if (axis_value(table.plan.axes, row.values, "dt").empty())  // else a column already
    f.emplace_back("dt", figure(row.run.dt));
  f.emplace_back("particles", std::to_string(row.run.particles));
  f.emplace_back("contacts", figure(counter(row, "contacts")));
  f.emplace_back("solver_iterations", figure(counter(row, "solver_iterations")));
  f.emplace_back("failure", row.failure);
  f.emplace_back("why", row.why);
  f.emplace_back("repeats", std::to_string(row.repeats));
  f.emplace_back("median_s", if_ok(figure(row.run_s.median)));
  f.emplace_back("q1_s", if_ok(figure(row.run_s.low)));
  f.emplace_back("q3_s", if_ok(figure(row.run_s.high)));
  f.emplace_back("ratio_of_s", if_ok(figure(row.ratio.median)));
  f.emplace_back("ratio_q1_of_s", if_ok(figure(row.ratio.low)));
  f.emplace_back("ratio_q3_of_s", if_ok(figure(row.ratio.high)));
  f.emplace_back("simulated_s_per_s", if_ok(figure(simulated_per_second(row))));
  f.emplace_back("build_s", figure(row.run.build_s));
  f.emplace_back("pareto_by_s", row.pareto ? "yes" : "");
  for (const std::string& phase : phases) {
    const auto found = row.phase_s.find(phase);
    f.emplace_back(phase + "_s", found == row.phase_s.end() ? "" : figure(found->second));
  }
  f.emplace_back("peak_bytes", std::to_string(row.run.peak_bytes));
  return f;
}

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

OrderedJson optional_json(const std::optional<double>& value) {
  return value ? OrderedJson(*value) : OrderedJson(nullptr);
}

OrderedJson row_json(const CompareRow& row) {
  const PairJudgement& p = row.run.pairs;
  const auto range = [](const Quartiles& q) {
    return OrderedJson::array({q.median, q.low, q.high});
  };
  OrderedJson json = {{"id", row.id},
                      {"label", row.label},
                      {"values", row.values},
                      {"command", row.command},
                      {"status", status_word(row.status)},
                      {"why", row.why},
                      {"failure", row.failure},
                      {"error", optional_json(row.error)},
                      {"error_half_interval", row.error_half},
                      {"errors", row.errors},
                      {"counts", row.counts},
                      {"deviation", optional_json(row.deviation)},
                      {"pareto", row.pareto},
                      {"repeats", row.repeats},
                      {"run_s", range(row.run_s)},
                      {"ratio", range(row.ratio)},
                      {"build_s", row.run.build_s},
                      {"end_s", row.run.end_s},
                      {"dt", row.run.dt},
                      {"particles", row.run.particles},
                      {"peak_bytes", row.run.peak_bytes}};
  visit_columns(row.run.result, [&](const char* name, const auto& value) { json[name] = value; });
  json["phase_s"] = row.phase_s;
  json["counters"] = row.run.result.counters;
  json["pairs"] = {{"motions", p.motions},           {"colliding", p.colliding},
                   {"broad_missed", p.broad_missed}, {"narrow_missed", p.narrow_missed},
                   {"narrow_false", p.narrow_false}, {"recall", p.recall}};
  return json;
}

std::string remark(const CompareRow& row) {
  if (!row.failure.empty()) return "FAILURE: " + row.failure;
  if (row.status != RunStatus::ok) return row.why;
  if (!row.run.result.clean) return "NOT CLEAN";
  if (row.error && !row.counts)
    return *row.error <= row.error_half ? "within the scatter of the seeds"
                                        : "below the reference's uncertainty";
  return row.pareto ? "Pareto front" : "";
}

}  // namespace

Quartiles quartiles(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    const double place = share * static_cast<double>(values.size() - 1);
    const auto low = static_cast<std::size_t>(place);
    const std::size_t high = std::min(low + 1, values.size() - 1);
    return values[low] + (place - static_cast<double>(low)) * (values[high] - values[low]);
  };
  return {at(0.5), at(0.25), at(0.75)};
}

bool CompareTable::failed() const {
  return std::any_of(rows.begin(), rows.end(),
                     [](const CompareRow& row) { return !row.failure.empty(); });
}

CompareTable make_table(const fs::path& out, const ComparePlan& plan, const Methods& methods) {
  CompareTable table;
  table.plan = plan;
  table.machine = machine_in_words();
  const auto first = plan.cells.empty() ? std::map<int, CellRun>{}
                                        : good_runs(out, plan.cells[0].id, plan.repeats);
  for (const CompareCell& cell : plan.cells) table.rows.push_back(make_row(out, plan, cell, first));
  const detail::Reference reference(out, plan, methods);
  const detail::ErrorQuantity& quantity = detail::error_quantity(plan.error);
  const detail::Convergence convergence = reference.convergence(quantity);
  table.error_unit = quantity.unit;
  table.error_meaning = quantity.meaning;
  table.reference = convergence.sentence;
  table.uncertainty = convergence.uncertainty;
  table.converges = convergence.converges;
  add_errors(out, reference, table);
  mark_front(table.rows);
  return table;
}

bool is_measured(const std::string& column) {
  return column.ends_with("_s") || column == "peak_bytes";
}

std::string to_csv(const CompareTable& table) {
  const auto phases = phases_of(table);
  std::string text;
  for (const CompareRow& row : table.rows) {
    std::string names, values;
    for (const auto& [name, value] : fields(table, row, phases)) {
      names += (names.empty() ? "" : ",") + quoted(name);
      values += (values.empty() ? "" : ",") + quoted(value);
    }
    if (text.empty()) text = names + "\n";
    text += values + "\n";
  }
  return text;
}

std::string to_json_text(const CompareTable& table) {
  OrderedJson axes = OrderedJson::array(), rows = OrderedJson::array();
  for (const CompareAxis& axis : table.plan.axes)
    axes.push_back({{"name", axis.name}, {"values", axis.values}, {"numeric", axis.numeric}});
  for (const CompareRow& row : table.rows) rows.push_back(row_json(row));
  const OrderedJson all = {{"name", table.plan.name},
                           {"scene", table.plan.scene.string()},
                           {"command", table.plan.command},
                           {"machine", table.machine},
                           {"threads", table.plan.limits.threads},
                           {"reference", table.reference},
                           {"quantity", table.plan.error},
                           {"error_unit", table.error_unit},
                           {"error_meaning", table.error_meaning},
                           {"seeds", table.plan.limits.seeds ? table.plan.repeats : 0},
                           {"uncertainty", table.uncertainty},
                           {"converges", table.converges},
                           {"ranking", ranking(table)},
                           {"axes", axes},
                           {"rows", rows}};
  return all.dump(1, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

std::string to_text(const CompareTable& table) {
  std::size_t width = 8;
  for (const CompareRow& row : table.rows) width = std::max(width, row.label.size() + 2);
  std::string text = ranking(table) + "\n" +
                     fmt::format("{:<{}}{:<10}{:>10}{:>11}{:>11}{:>11} {:>29}{:>8}{:>8}\n", "cell",
                                 width, "status", "error", "deviation", "ms/step", "real time",
                                 "ratio (quartiles)", "recall", "steps");
  for (const CompareRow& row : table.rows) {
    constexpr double milli = 1e3;
    const bool ok = row.status == RunStatus::ok;
    const double step_ms = milli * row.run_s.median / std::max(1, row.run.result.steps);
    text += fmt::format(
        "{:<{}}{:<10}{:>10}{:>11}{:>11}{:>11} {:>29}{:>8}{:>8}", row.label, width,
        status_word(row.status), row.error ? fmt::format("{:.2e}", *row.error) : "-",
        row.deviation ? fmt::format("{:.1e}", *row.deviation) : "-",
        ok ? fmt::format("{:.3f}", step_ms) : "-",
        ok ? fmt::format("{:.3g} x", simulated_per_second(row)) : "-",
        ok ? fmt::format("{:.2f} ({:.2f}-{:.2f})", row.ratio.median, row.ratio.low, row.ratio.high)
           : "-",
        ok ? fmt::format("{:.4f}", row.run.pairs.recall) : "-", row.run.result.steps);
    const std::string more = remark(row);
    text += (more.empty() ? "" : "  " + more) + "\n";
  }
  const std::string seeds = table.plan.limits.seeds
                                ? fmt::format(", means of {} seeds", table.plan.repeats)
                                : std::string();
  return text + fmt::format("errors: {} ({}){}; against: {}\n", table.error_meaning,
                            table.error_unit, seeds, table.reference);
}

std::string command_of(const ComparePlan& plan, const CompareCell& cell) {
  std::string command = "selvedge run " + shell_quoted(plan.scene.string());
  for (const std::string& set : cell.set) command += " --set " + shell_quoted(set);
  return command + fmt::format(" --threads {}", cell.threads);
}

std::string machine_in_words() {
  std::ifstream in("/proc/cpuinfo");
  std::string processor = "unknown processor";
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("model name")) {
      processor = line.substr(line.find(':') + 2);
      break;
    }
#if defined(__clang__)
  const std::string compiler = "clang " __clang_version__;
#else
  const std::string compiler = "g++ " __VERSION__;
#endif
  return fmt::format("{}, {} cores, {}", processor, std::thread::hardware_concurrency(), compiler);
}

}  // namespace selvedge
