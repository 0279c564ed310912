// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/compare/compare_plan.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/scene/scene.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace selvedge {
namespace {

constexpr std::string_view kAnyGeometry = "geometry.*.";
constexpr std::size_t kMostCells = 10'000;
constexpr double kMostStepsPerFrame = 1000.0;  // the most that a scene file may request
/// A step that fits up to the six digits of its name counts as fitting.
constexpr double kStepDigits = 1e-5;

std::optional<double> number(const std::string& text) { return finite_number(text); }

[[noreturn]] void refuse(const std::string& text, const std::string& fault) {
  throw std::invalid_argument("--vary " + text + ": " + fault);
}

/// Splits at commas outside brackets.
std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> parts(1);
  int depth = 0;
  for (const char c : text) {
    depth += (c == '[' || c == '{') - (c == ']' || c == '}');
    if (c == ',' && depth == 0)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

/// The scene key of a short name. The short name may also precede an option: "broad_phase.cell".
std::string key_of(const std::string& name) {
  for (const auto& [shorter, key] : short_axes()) {
    if (shorter == name) return key;
    if (name.starts_with(shorter + ".")) return key + name.substr(shorter.size());
  }
  return present_key(name);
}

/// "contact.response" and "stiffness" of "contact.response.stiffness".
std::pair<std::string, std::string> split_last(const std::string& key) {
  const auto dot = key.rfind('.');
  if (dot == std::string::npos) return {"", key};
  return {key.substr(0, dot), key.substr(dot + 1)};
}

/// Calls visit(registry, option) if `key` is an option of a family of methods: for example
/// "stiffness" of "contact.response.stiffness".
template <class Visit>
void visit_option(const std::string& key, const Methods& methods, Visit visit) {
  const std::pair<std::string, std::string> split = split_last(key);
  const std::string &method_key = split.first, &option = split.second;
  for_each_family(methods, [&](const std::string& family, const auto& registry) {
    if (is_instance_of(method_key, family)) visit(registry, option);
  });
}

bool is_option(const std::string& key) {
  const std::string method_key = split_last(key).first;
  return std::any_of(kMethodKeys.begin(), kMethodKeys.end(),
                     [&](const std::string& family) { return is_instance_of(method_key, family); });
}

/// "weight_spring" and "omega" of "force_laws.weight_spring.omega"; nullopt for other keys.
std::optional<std::pair<std::string, std::string>> law_option(const std::string& key) {
  if (!is_instance_of(key, std::string(kForceLawKey) + ".*.*")) return std::nullopt;
  const auto [law_key, option] = split_last(key);
  return std::pair(split_last(law_key).second, option);
}

/// Every value that `key` may have; empty if the values are not enumerable.
std::vector<std::string> all_values(const std::string& key, const Methods& methods) {
  std::vector<std::string> values;
  for_each_family(methods, [&](const std::string& family, const auto& registry) {
    if (is_instance_of(key, family)) values = registry.names();
  });
  visit_option(key, methods, [&](const auto& registry, const std::string& name) {
    for (const auto& [method, entry] : registry)
      for (const MethodOption& option : entry.options())
        if (option.name == name && option.kind == OptionKind::boolean) values = {"false", "true"};
  });
  if (const auto law = law_option(key))
    for (const MethodOption& option : methods.force_laws.at(law->first).options())
      if (option.name == law->second && option.kind == OptionKind::boolean)
        values = {"false", "true"};
  if (!values.empty()) return values;
  for (const SceneKey& known : scene_keys())
    if (is_instance_of(key, known.path) && !known.words.empty()) return known.words;
  return {};
}

/// Rejects an option that no method of its family has.
void require_option(const std::string& key, const std::string& text, const Methods& methods) {
  visit_option(key, methods, [&](const auto& registry, const std::string& name) {
    std::vector<std::string> known;
    for (const auto& [method, entry] : registry)
      for (const MethodOption& option : entry.options()) known.push_back(option.name);
    if (std::find(known.begin(), known.end(), name) == known.end())
      refuse(text, fmt::format("no method has the option \"{}\"; nearest is \"{}\"", name,
                               nearest_word(name, known)));
  });
}

/// Rejects a force law that does not exist, and an option that the law does not have.
void require_law_option(const std::string& name, const std::string& option, const std::string& text,
                        const Methods& methods) {
  if (const std::string fault = methods.force_laws.fault(name); !fault.empty()) refuse(text, fault);
  const auto& options = methods.force_laws.at(name).options();
  if (std::none_of(options.begin(), options.end(),
                   [&](const MethodOption& o) { return o.name == option; }))
    refuse(text, name + " " + option_fault(options, option, 0.0));
}

void require_known(const std::string& name, const std::string& text, const Methods& methods) {
  if (is_option(key_of(name))) return require_option(key_of(name), text, methods);
  if (const auto law = law_option(name))
    return require_law_option(law->first, law->second, text, methods);
  std::vector<std::string> known;
  for (const auto& entry : short_axes()) {
    if (entry.first == name) return;
    known.push_back(entry.first);
  }
  const bool is_path = name.find('.') != std::string::npos;
  if (is_path) known.clear();
  for (const SceneKey& key : scene_keys()) {
    if (is_instance_of(present_key(name), key.path)) return;
    if (is_path) known.push_back(key.path);
  }
  refuse(text, fmt::format("there is nothing \"{}\" to vary; nearest is \"{}\"; {}", name,
                           nearest_word(name, known),
                           "give a short name (see --help) or a path of the scene file"));
}

/// "lo..hi:n" or "lo..hi:n log".
std::vector<std::string> read_range(const std::string& text, const std::string& range) {
  const auto dots = range.find(".."), colon = range.find(':');
  std::string count_text = colon == std::string::npos ? "" : range.substr(colon + 1);
  const auto log_at = count_text.find("log");
  const bool logarithmic = log_at != std::string::npos;
  if (logarithmic) count_text.erase(log_at);
  while (!count_text.empty() && (count_text.back() == ' ' || count_text.back() == ':'))
    count_text.pop_back();
  const auto low = number(range.substr(0, dots));
  const auto high = number(range.substr(dots + 2, colon - dots - 2));
  const auto count = number(count_text);
  constexpr double most = 1000.0;
  if (!low || !high || !count || *count < 2.0 || *count > most || *count != std::floor(*count))
    refuse(text, "a range is lo..hi:n, n from 2 to 1000, with \"log\" after it for equal ratios");
  if (logarithmic && !(*low > 0.0 && *high > 0.0))
    refuse(text, "a logarithmic range has to lie above 0");
  std::vector<std::string> values;
  for (double i = 0.0; i < *count; ++i) {
    const double share = i / (*count - 1.0);
    const double value =
        logarithmic ? *low * std::pow(*high / *low, share) : *low + (*high - *low) * share;
    values.push_back(fmt::format("{:.6g}", value));
  }
  return values;
}

void append_values(const std::string& text, const std::string& item, const std::string& name,
                   const Methods& methods, std::vector<std::string>& values) {
  if (item.empty()) refuse(text, "an empty value; part values by single commas");
  std::vector<std::string> more{item};
  if (item == "all") {
    more = all_values(key_of(name), methods);
    if (more.empty()) refuse(text, name + " has no list of all values; name some");
  } else if (item.find("..") != std::string::npos && number(item.substr(0, item.find("..")))) {
    more = read_range(text, item);
  }
  for (std::string& value : more)
    if (std::find(values.begin(), values.end(), value) == values.end())
      values.push_back(std::move(value));
}

CompareAxis make_axis(const std::string& text, const std::string& name, const std::string& list,
                      const Methods& methods) {
  require_known(name, text, methods);
  CompareAxis axis{name, {}, true};
  for (const std::string& item : split_list(list))
    append_values(text, item, name, methods, axis.values);
  // The first side of a mesh of 25 or 25x40 particles is its numeric value.
  for (const std::string& value : axis.values)
    axis.numeric =
        axis.numeric && number(name == "mesh" ? value.substr(0, value.find('x')) : value);
  return axis;
}

std::vector<Override> mesh_overrides(const std::string& value, const Scene& base) {
  const auto cross = value.find('x');
  const auto nx = number(value.substr(0, cross));
  const auto ny = cross == std::string::npos ? nx : number(value.substr(cross + 1));
  if (!nx || !ny || *nx < 2.0 || *ny < 2.0 || *nx != std::floor(*nx) || *ny != std::floor(*ny))
    throw std::invalid_argument("--vary mesh: " + value +
                                ": must be particles on a side, at least 2, or \"NxM\"");
  std::vector<Override> overrides;
  for (std::size_t i = 0; i < base.cloths.size(); ++i)
    if (std::holds_alternative<ClothGrid>(base.cloths[i].shape))
      overrides.push_back(
          {fmt::format("geometry.{}.cells", i), fmt::format("[{},{}]", *nx - 1.0, *ny - 1.0)});
  if (overrides.empty())
    throw std::invalid_argument("--vary mesh: the scene has no grid whose size could be varied");
  return overrides;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> short_axes() {
  return {{"broad_phase", "contact.broad_phase"},
          {"narrow_phase", "contact.narrow_phase"},
          {"response", "contact.response"},
          {"fail_safe", "contact.fail_safe"},
          {"rest_gap", "contact.rest_gap"},
          {"thickness", "contact.rest_gap"},
          {"integrator", "solver.integrator"},
          {"strain_limiter", "solver.strain_limiter"},
          {"tolerance", "solver.tolerance"},
          {"pattern", "geometry.*.pattern"},
          {"mesh", "mesh"},
          {"dt", "dt"},
          {"threads", "threads"}};
}

std::vector<CompareAxis> read_axes(const std::vector<std::string>& vary, const Methods& methods) {
  std::vector<CompareAxis> axes;
  for (const std::string& text : vary) {
    const auto equals = text.find('=');
    if (equals != std::string::npos)
      axes.push_back(make_axis(text, text.substr(0, equals), text.substr(equals + 1), methods));
    else
      for (const std::string& name : split_list(text))
        axes.push_back(make_axis(text, name, "all", methods));
  }
  for (std::size_t i = 0; i < axes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (key_of(axes[i].name) == key_of(axes[j].name))
        refuse(axes[i].name, "is varied twice; give all its values in one list");
  return axes;
}

std::vector<std::vector<std::string>> design_cells(const std::vector<CompareAxis>& axes,
                                                   CompareDesign design) {
  std::vector<std::vector<std::string>> cells(1);
  for (const CompareAxis& axis : axes) cells[0].push_back(axis.values.front());
  for (std::size_t a = 0; a < axes.size(); ++a) {
    std::vector<std::vector<std::string>> more;
    const auto vary = [&](std::vector<std::string> cell, bool with_first) {
      for (std::size_t v = with_first ? 0 : 1; v < axes[a].values.size(); ++v) {
        cell[a] = axes[a].values[v];
        more.push_back(cell);
      }
    };
    if (design == CompareDesign::product) {
      for (const auto& cell : cells) vary(cell, true);
      cells = std::move(more);
    } else {
      vary(cells[0], false);
      cells.insert(cells.end(), more.begin(), more.end());
    }
    if (cells.size() > kMostCells)
      throw std::invalid_argument(fmt::format(
          "--vary: more than {} cells; vary fewer values, or one at a time", kMostCells));
  }
  return cells;
}

double nominal_step(const Scene& scene) {
  return 1.0 / (scene.time.fps * scene.time.steps_per_frame);
}

std::vector<Override> step_overrides(const Scene& base, double dt) {
  const double fps = base.time.fps, end = base.time.frames / fps;
  const auto whole = [](double steps) { return std::ceil(steps * (1.0 - kStepDigits)); };
  if (dt <= (1.0 + kStepDigits) / fps) {
    const double steps = whole(1.0 / (fps * dt));
    const double parts = std::ceil(steps / kMostStepsPerFrame);
    return {{"time.frames", fmt::format("{}", base.time.frames * parts)},
            {"time.fps", fmt::format("{}", fps * parts)},
            {"time.steps_per_frame", fmt::format("{}", std::ceil(steps / parts))},
            {"time.step_error", "0"},
            {"time.sleep_speed", "0"}};
  }
  const double frames = std::max(1.0, whole(end / dt));
  return {{"time.frames", fmt::format("{}", frames)},
          {"time.fps", fmt::format("{}", frames / end)},
          {"time.steps_per_frame", "1"},
          {"time.step_error", "0"},
          {"time.sleep_speed", "0"}};
}

namespace {

/// The step that step_overrides makes of dt, s.
double stepped(const Scene& base, double dt) {
  Scene scene = base;
  for (const Override& set : step_overrides(base, dt)) {
    const double value = number(set.value).value_or(0.0);
    if (set.path == "time.fps") scene.time.fps = value;
    if (set.path == "time.steps_per_frame") scene.time.steps_per_frame = static_cast<int>(value);
  }
  return nominal_step(scene);
}

}  // namespace

std::vector<std::string> round_steps(CompareAxis& dt, const Scene& base) {
  std::vector<std::string> values, notes;
  for (const std::string& text : dt.values) {
    const auto asked = number(text);
    if (!asked || *asked <= 0.0)
      throw std::invalid_argument("--vary dt: " + text + ": must be seconds above 0");
    const double made = stepped(base, *asked);
    const std::string name = fmt::format("{:.6g}", made);
    const bool fits = std::abs(made - *asked) <= kStepDigits * *asked;
    const bool twice = std::find(values.begin(), values.end(), name) != values.end();
    if (!fits || twice)
      notes.push_back(fmt::format("dt={}: the step is {} s, so that whole steps fill the frames{}",
                                  text, name, twice ? "; it is in the list already" : ""));
    if (!twice) values.push_back(name);
  }
  dt.values = std::move(values);
  return notes;
}

std::vector<Override> cell_overrides(const std::vector<CompareAxis>& axes,
                                     const std::vector<std::string>& values, const Scene& base) {
  std::vector<Override> overrides;
  const auto append = [&](std::vector<Override> more) {
    overrides.insert(overrides.end(), more.begin(), more.end());
  };
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const std::string& name = axes[a].name;
    if (name == "dt") {
      const auto dt = number(values[a]);
      if (!dt || *dt <= 0.0)
        throw std::invalid_argument("--vary dt: " + values[a] + ": must be seconds above 0");
      append(step_overrides(base, *dt));
    } else if (name == "mesh") {
      append(mesh_overrides(values[a], base));
    } else if (name == "threads") {
      const auto threads = number(values[a]);
      if (!threads || !(*threads >= 0.0 && *threads <= kMaxThreads) ||
          *threads != std::floor(*threads))
        throw std::invalid_argument(fmt::format(
            "--vary threads: {}: must be a whole number from 0 to {}", values[a], kMaxThreads));
    } else if (const std::string key = key_of(name); key.starts_with(kAnyGeometry)) {
      for (std::size_t i = 0; i < base.cloths.size(); ++i)
        if (std::holds_alternative<ClothGrid>(base.cloths[i].shape))
          overrides.push_back(
              {fmt::format("geometry.{}.{}", i, key.substr(kAnyGeometry.size())), values[a]});
    } else {
      overrides.push_back({key_of(name), values[a]});
    }
  }
  // The name of a method replaces the whole entry, so it must precede the method's options.
  std::stable_partition(overrides.begin(), overrides.end(),
                        [](const Override& set) { return !is_option(set.path); });
  return overrides;
}

std::string axis_value(const std::vector<CompareAxis>& axes, const std::vector<std::string>& values,
                       const std::string& name) {
  for (std::size_t a = 0; a < axes.size(); ++a)
    if (axes[a].name == name) return values[a];
  return {};
}

}  // namespace selvedge
