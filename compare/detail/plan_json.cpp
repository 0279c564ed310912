// SPDX-License-Identifier: MIT
#include <selvedge/compare/detail/plan_json.h>

#include <fmt/format.h>
#include <selvedge/core/base/internal/json_value.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <stdexcept>

namespace selvedge::detail {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kReferenceWords[] = {"none", "closed_form", "converged"};

using Value = JsonValue<Json>;

/// The name of a folder of a run: it leads to no other place.
std::string folder_from(const Value& value) {
  const std::string name = value.text();
  const auto plain = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  if (name.empty() || !std::all_of(name.begin(), name.end(), plain))
    value.refuse("a name of letters, digits and _");
  return name;
}

std::vector<std::string> texts_from(const Value& value) {
  std::vector<std::string> texts;
  for (const Value& text : value.list()) texts.push_back(text.text());
  return texts;
}

double positive_from(const Value& value) {
  const Json& json = value.json();
  if (!json.is_number() || !(json.get<double>() > 0.0)) value.refuse("a number greater than 0");
  return value.number();
}

std::string error_from(const Value& error) {
  const std::vector<std::string> known = error_names();
  const std::string word = error.text();
  if (std::find(known.begin(), known.end(), word) == known.end())
    error.refuse(fmt::format("one of {}", fmt::join(known, ", ")));
  return word;
}

CompareAxis axis_from(const Value& axis) {
  return {axis["name"].text(), texts_from(axis["values"]), axis["numeric"].flag()};
}

CompareCell cell_from(const Value& cell, std::size_t axes) {
  CompareCell read{folder_from(cell["id"]), texts_from(cell["values"]), texts_from(cell["set"]),
                   cell["threads"].whole<int>(0, kMaxThreads), cell["impossible"].text()};
  if (read.values.size() != axes)
    cell["values"].refuse(fmt::format("a list of {}, one value for each axis", axes));
  return read;
}

ReferenceKind reference_from(const Value& reference) {
  const std::string word = reference.text();
  const auto* const known = std::find(std::begin(kReferenceWords), std::end(kReferenceWords), word);
  if (known == std::end(kReferenceWords))
    reference.refuse("\"none\", \"closed_form\" or \"converged\"");
  return static_cast<ReferenceKind>(known - std::begin(kReferenceWords));
}

CellLimits limits_from(const Value& plan) {
  return {plan["threads"].whole<int>(0, kMaxThreads), positive_from(plan["budget_s"]),
          plan["judged_motions"].whole<int>(0), plan["seeds"].flag(), plan["core"].whole<int>(-1)};
}

}  // namespace

Json plan_json(const ComparePlan& plan) {
  Json axes = Json::array(), cells = Json::array();
  for (const CompareAxis& axis : plan.axes)
    axes.push_back({{"name", axis.name}, {"values", axis.values}, {"numeric", axis.numeric}});
  for (const CompareCell& cell : plan.cells)
    cells.push_back({{"id", cell.id},
                     {"values", cell.values},
                     {"set", cell.set},
                     {"threads", cell.threads},
                     {"impossible", cell.impossible}});
  return {{"name", plan.name},
          {"command", plan.command},
          {"scene", plan.scene.string()},
          {"axes", axes},
          {"cells", cells},
          {"reference", kReferenceWords[static_cast<int>(plan.reference)]},
          {"levels", plan.levels},
          {"error", plan.error},
          {"threads", plan.limits.threads},
          {"budget_s", plan.limits.budget_s},
          {"judged_motions", plan.limits.judged_motions},
          {"seeds", plan.limits.seeds},
          {"core", plan.limits.core},
          {"repeats", plan.repeats},
          {"build", plan.build}};
}

ComparePlan plan_from(const Json& json) {
  const Value j(json, "");
  ComparePlan plan;
  plan.name = j["name"].text();
  plan.command = j["command"].text();
  plan.scene = j["scene"].text();
  for (const Value& axis : j["axes"].list()) plan.axes.push_back(axis_from(axis));
  for (const Value& cell : j["cells"].list())
    plan.cells.push_back(cell_from(cell, plan.axes.size()));
  plan.reference = reference_from(j["reference"]);
  for (const Value& level : j["levels"].list()) plan.levels.push_back(folder_from(level));
  plan.limits = limits_from(j);
  plan.error = error_from(j["error"]);
  plan.repeats = j["repeats"].whole<int>(1, kMaxRepeats);
  plan.build = j["build"].text();
  return plan;
}

}  // namespace selvedge::detail
