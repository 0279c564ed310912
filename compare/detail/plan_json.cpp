// SPDX-License-Identifier: MIT
#include <selvedge/compare/detail/plan_json.h>

#include <fmt/format.h>
#include <selvedge/core/text.h>
#include <selvedge/core/whole_number.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <limits>
#include <stdexcept>

namespace selvedge::detail {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kReferenceWords[] = {"none", "closed_form", "converged"};

/// A value of plan.json and its place in the file.
class Value {
 public:
  Value(const Json& json, std::string place) : json_(json), place_(std::move(place)) {}

  Value operator[](const char* key) const {
    if (!json_.is_object()) refuse("an object {...}");
    const std::string place = place_.empty() ? key : place_ + "." + key;
    if (!json_.contains(key)) throw std::invalid_argument(place + ": is missing");
    return {json_[key], place};
  }

  std::vector<Value> list() const {
    if (!json_.is_array()) refuse("a list [...]");
    std::vector<Value> values;
    for (std::size_t i = 0; i < json_.size(); ++i)
      values.emplace_back(json_[i], fmt::format("{}[{}]", place_, i));
    return values;
  }

  std::string text() const {
    if (!json_.is_string()) refuse("a string");
    return json_.get<std::string>();
  }

  /// The name of a folder of a run: it leads to no other place.
  std::string folder() const {
    const std::string name = text();
    const auto plain = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
    if (name.empty() || !std::all_of(name.begin(), name.end(), plain))
      refuse("a name of letters, digits and _");
    return name;
  }

  std::vector<std::string> texts() const {
    std::vector<std::string> texts;
    for (const Value& value : list()) texts.push_back(value.text());
    return texts;
  }

  bool flag() const {
    if (!json_.is_boolean()) refuse("true or false");
    return json_.get<bool>();
  }

  int whole(int low, int high = std::numeric_limits<int>::max()) const {
    const auto number = whole_number<int>(json_, low, high);
    if (!number) refuse(fmt::format("a whole number from {} to {}", low, high));
    return *number;
  }

  double positive() const {
    if (!json_.is_number() || !(json_.get<double>() > 0.0)) refuse("a number greater than 0");
    return json_.get<double>();
  }

  [[noreturn]] void refuse(const std::string& wanted) const {
    constexpr std::size_t longest = 60;
    std::string shown = printable(json_.dump(-1, ' ', true, Json::error_handler_t::replace));
    if (shown.size() > longest) shown = shown.substr(0, longest - 3) + "...";
    throw std::invalid_argument(fmt::format("{}: must be {}, is {}", place_, wanted, shown));
  }

 private:
  const Json& json_;
  std::string place_;
};

std::string error_from(const Value& error) {
  const std::vector<std::string> known = error_names();
  const std::string word = error.text();
  if (std::find(known.begin(), known.end(), word) == known.end())
    error.refuse(fmt::format("one of {}", fmt::join(known, ", ")));
  return word;
}

CompareAxis axis_from(const Value& axis) {
  return {axis["name"].text(), axis["values"].texts(), axis["numeric"].flag()};
}

CompareCell cell_from(const Value& cell, std::size_t axes) {
  CompareCell read{cell["id"].folder(), cell["values"].texts(), cell["set"].texts(),
                   cell["threads"].whole(0, kMaxThreads), cell["impossible"].text()};
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
  return {plan["threads"].whole(0, kMaxThreads), plan["budget_s"].positive(),
          plan["judged_motions"].whole(0), plan["seeds"].flag(), plan["core"].whole(-1)};
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
  for (const Value& level : j["levels"].list()) plan.levels.push_back(level.folder());
  plan.limits = limits_from(j);
  plan.error = error_from(j["error"]);
  plan.repeats = j["repeats"].whole(1, kMaxRepeats);
  plan.build = j["build"].text();
  return plan;
}

}  // namespace selvedge::detail
