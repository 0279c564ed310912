// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/print.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include <selvedge/lab/fabric_drape.h>
#include <selvedge/lab/identify.h>
#include <selvedge/run/frame_writer.h>
#include <selvedge/scene/internal/scene_text.h>
#include <selvedge/scene/methods.h>
#include <selvedge/scene/scene.h>

namespace {

using selvedge::ListedMethod;
using selvedge::print_document;
using selvedge::print_escaped;

constexpr bool has_assimp = SELVEDGE_HAS_ASSIMP;

std::vector<ListedMethod> bodies() {
  const auto body = [](const char* name, const char* promise, const char* source,
                       bool available = true) {
    return ListedMethod{.family = "body",
                        .key = "obstacles",
                        .name = name,
                        .promise = promise,
                        .source = source,
                        .available = available};
  };
  return {
      body("plane, box, sphere, capsule, cylinder, cone, torus", "vertices on the true shape", ""),
      body("OBJ, PLY, OFF", "read exactly, by a reader of our own", ""),
      body("STL, glTF and other formats", "single precision, in a child process",
           "Open Asset Import Library (assimp)", has_assimp),
      body("keyframes", "static, moved rigidly, or a sequence of meshes", ""),
  };
}

/// Methods that commands select, not scenes.
std::vector<ListedMethod> methods_of_commands() {
  const bool genetic = selvedge::has_genetic();
  return {{.family = "drape",
           .key = "drape --geometric",
           .name = "geometric",
           .promise = "catenaries between held vertices, then lengths; no forces",
           .source = "Weil, The synthesis of cloth objects, 1986",
           .options = selvedge::geometric_drape_options()},
          {.family = "identification",
           .key = "identify --method",
           .name = "genetic",
           .promise = "the same result for any number of threads",
           .source = "Louchet, Provot, Crochemore 1995; Bianchi et al. 2004; Mongus et al. 2012",
           .library = "pagmo",
           .available = genetic},
          {.family = "identification",
           .key = "identify --method",
           .name = "nelder_mead",
           .promise = "a local search without gradients",
           .source = "Nelder, Mead, A simplex method for function minimization, 1965"}};
}

std::vector<ListedMethod> all_methods() {
  using namespace selvedge;
  std::vector<ListedMethod> methods = list_methods(methods_of_this_build());
  const auto append = [&](const std::vector<ListedMethod>& family) {
    methods.insert(methods.end(), family.begin(), family.end());
  };
  append(list_family("output_format", "output.formats", frame_formats()));
  append(methods_of_commands());
  append(bodies());
  return methods;
}

/// "from 1 to 24", "at least 0", "above 0".
std::string range_text(const selvedge::MethodOption& option) {
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
std::string default_text(const selvedge::MethodOption& option) {
  return selvedge::options_text({option}, {{option.name, option.initial}});
}

const char* type_of(const selvedge::MethodOption& option) {
  if (option.kind == selvedge::OptionKind::boolean) return "boolean";
  return option.kind == selvedge::OptionKind::whole ? "integer" : "number";
}

void print_table(const std::vector<ListedMethod>& methods) {
  std::string_view family;
  for (const ListedMethod& method : methods) {
    if (method.family != family)
      print_escaped("{}{} ({})\n", family.empty() ? "" : "\n", method.family, method.key);
    family = method.family;
    print_escaped("  {}{}{}\n", method.name,
                  method.keyed ? fmt::format("  (key {})", method.key) : std::string(),
                  method.available ? "" : "  (not in this build)");
    if (!method.promise.empty()) print_escaped("      {}\n", method.promise);
    if (!method.source.empty()) print_escaped("      {}\n", method.source);
    for (const selvedge::MethodOption& option : method.options)
      print_escaped("      {} ({}): {}\n", default_text(option), range_text(option),
                    option.meaning);
  }
}

nlohmann::json json_of(const selvedge::MethodOption& option) {
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

nlohmann::json commands() {
  auto list = nlohmann::json::array();
  for (const selvedge::ProgramCommand& command : selvedge::program_commands())
    list.push_back({{"name", command.name}, {"purpose", command.purpose}});
  return list;
}

void print_json(const std::vector<ListedMethod>& methods) {
  auto list = nlohmann::json::array();
  for (const ListedMethod& method : methods) {
    auto options = nlohmann::json::array();
    for (const selvedge::MethodOption& option : method.options) options.push_back(json_of(option));
    list.push_back({{"family", method.family},
                    {"name", method.name},
                    {"key", method.key},
                    {"guarantee", method.promise},
                    {"source", method.source},
                    {"available", method.available},
                    {"options", options}});
  }
  print_document(nlohmann::json{{"commands", commands()}, {"methods", list}});
}

/// One key a line, the table in docs/scene_files.md, or the JSON schema.
std::string scene_text(const std::string& form) {
  if (form == "schema") return selvedge::scene_schema_text();
  if (form == "table") return selvedge::scene_table_text();
  std::string text;
  for (const selvedge::SceneKey& key : selvedge::scene_keys()) text += key.path + "\n";
  return text;
}

void add_list_options(const selvedge::Command& command) {
  const auto json = std::make_shared<bool>(false);
  command.flag("--json", *json, "Print JSON");
  const auto scene = std::make_shared<std::string>();
  command.option("--scene", *scene, "Print the keys of scene files instead: keys, table or schema")
      .one_of({"keys", "table", "schema"});
  command.action([json, scene] {
    if (!scene->empty())
      print_escaped("{}", scene_text(*scene));
    else if (*json)
      print_json(all_methods());
    else
      print_table(all_methods());
    return 0;
  });
}

}  // namespace

selvedge::ProgramCommand list_command() {
  return {.name = "list",
          .purpose = "List every method of this build with its source and guarantee",
          .add_options = add_list_options};
}
