// SPDX-License-Identifier: MIT
#include "command_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include <selvedge/core/cloth_pattern.h>
#include <selvedge/core/force.h>
#include <selvedge/run/frame_writer.h>
#include <selvedge/scene/methods.h>

namespace {

struct Method {
  std::string family, name, guarantee, source;
  bool available = true;
  std::vector<selvedge::Option> options{};
};

constexpr bool has_assimp = SELVEDGE_HAS_ASSIMP;

std::vector<Method> bodies() {
  return {
      {"body", "plane, box, sphere, capsule, cylinder, cone, torus", "vertices on the true shape",
       ""},
      {"body", "OBJ, PLY, OFF", "read exactly, by a reader of our own", ""},
      {"body", "STL, glTF and other formats", "single precision, in a child process",
       "Open Asset Import Library (assimp)", has_assimp},
      {"body", "keyframes", "static, moved rigidly, or a sequence of meshes", ""},
  };
}

/// "contact.broad_phase" is of the family "broad_phase".
std::string family_of(const std::string& key) { return key.substr(key.find('.') + 1); }

template <class Members>
void add_members(const char* family, const Members& members, std::vector<Method>& methods) {
  for (const auto& member : members)
    methods.push_back({family, std::string(member.name), std::string(member.promise),
                       std::string(member.source)});
}

std::vector<Method> all_methods() {
  std::vector<Method> methods;
  for (const selvedge::ListedMethod& m : selvedge::list_methods(selvedge::methods_of_this_build()))
    methods.push_back({family_of(m.key), m.name, m.promise, m.source, m.available, m.options});
  methods.push_back({"strain_limiter", "biphasic (materials: stretch_law)",
                     "stiffer above a strain, continuous; a law of the springs",
                     "Chen, Zhu, Kaufman, Physically based animation, 1998"});
  const auto by_family = [](const Method& a, const Method& b) { return a.family < b.family; };
  std::stable_sort(methods.begin(), methods.end(), by_family);
  add_members("pattern", selvedge::cloth_patterns(), methods);
  add_members("force", selvedge::force_laws(), methods);
  for (const auto& [name, format] : selvedge::frame_formats())
    methods.push_back({"output_format", name, format.promise, format.source});
  for (Method& method : bodies()) methods.push_back(std::move(method));
  return methods;
}

/// "from 1 to 24", "at least 0", "above 0".
std::string range_text(const selvedge::Option& option) {
  const bool low = std::isfinite(option.least), high = std::isfinite(option.most);
  if (option.kind == selvedge::OptionKind::boolean) return "true or false";
  if (option.above_least && low)
    return fmt::format("above {:g}{}", option.least,
                       high ? fmt::format(" to {:g}", option.most) : std::string());
  if (low && high) return fmt::format("from {:g} to {:g}", option.least, option.most);
  if (low) return fmt::format("at least {:g}", option.least);
  return high ? fmt::format("at most {:g}", option.most) : "any number";
}

/// The default with its unit.
std::string default_text(const selvedge::Option& option) {
  return selvedge::options_text({option}, {{option.name, option.initial}});
}

const char* type_of(const selvedge::Option& option) {
  if (option.kind == selvedge::OptionKind::boolean) return "boolean";
  return option.kind == selvedge::OptionKind::whole ? "integer" : "number";
}

void print_table(const std::vector<Method>& methods) {
  std::string_view family;
  for (const Method& method : methods) {
    if (method.family != family) fmt::print("{}{}\n", family.empty() ? "" : "\n", method.family);
    family = method.family;
    fmt::print("  {}{}\n", method.name, method.available ? "" : "  (not in this build)");
    if (!method.guarantee.empty()) fmt::print("      {}\n", method.guarantee);
    if (!method.source.empty()) fmt::print("      {}\n", method.source);
    for (const selvedge::Option& option : method.options)
      fmt::print("      {} ({}): {}\n", default_text(option), range_text(option), option.meaning);
  }
}

nlohmann::json json_of(const selvedge::Option& option) {
  const auto number = [](double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
  };
  const bool boolean = option.kind == selvedge::OptionKind::boolean;
  nlohmann::json initial = option.initial;
  if (boolean) initial = option.initial != 0.0;
  return {{"name", option.name},
          {"type", type_of(option)},
          {"default", initial},
          {"unit", option.unit},
          {"min", number(option.least)},
          {"max", number(option.most)},
          {"above_min", option.above_least},
          {"meaning", option.meaning}};
}

void print_json(const std::vector<Method>& methods) {
  auto list = nlohmann::json::array();
  for (const Method& method : methods) {
    auto options = nlohmann::json::array();
    for (const selvedge::Option& option : method.options) options.push_back(json_of(option));
    list.push_back({{"family", method.family},
                    {"name", method.name},
                    {"guarantee", method.guarantee},
                    {"source", method.source},
                    {"available", method.available},
                    {"options", options}});
  }
  fmt::print("{}\n", nlohmann::json{{"methods", list}}.dump(2));
}

}  // namespace

void add_command_list(const selvedge::Command& app) {
  const selvedge::Command command =
      app.subcommand("list", "List every method of this build with its source and guarantee");
  const auto json = std::make_shared<bool>(false);
  command.flag("--json", *json, "Print JSON");
  command.action([json] {
    if (*json)
      print_json(all_methods());
    else
      print_table(all_methods());
    return 0;
  });
}
