// SPDX-License-Identifier: MIT
#include "command_list.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "methods.h"

namespace {

struct Method {
  std::string family, name, guarantee, source;
  bool available = true;
};

constexpr bool has_assimp = SELVEDGE_HAS_ASSIMP;

/// The members of families that are chosen by the scene and not by a registry.
std::vector<Method> fixed_methods() {
  return {
      {"pattern", "rectangular", "",
       "Provot, Deformation constraints in a mass-spring model, 1995"},
      {"pattern", "triangular", "",
       "Van Gelder, Approximate simulation of elastic membranes, 1998"},
      {"pattern", "simplified", "one diagonal: couples stretch and shear",
       "Huang et al., Cloth simulation based on simplified mass-spring model, 2014"},
      {"pattern", "checkerboard", "one diagonal, the other one in every second cell: no coupling",
       "Huang et al., 2014, mended"},
      {"pattern", "responsive", "resists tension only; links over two cells buckle",
       "Choi, Ko, Stable but responsive cloth, 2002"},
      {"pattern", "arc", "a disc of rings and spokes: polar, not woven",
       "Rusinko, Swan, Agent-based fabric modeling using differential equations, 2012"},
      {"pattern", "mesh", "any triangle mesh, file order and double precision kept", ""},
      {"force", "hooke", "minus the gradient of its energy",
       "stretch and shear springs, Hooke's law"},
      {"force", "bending", "minus the gradient of its energy",
       "Bridson, Marino, Fedkiw, Simulation of clothing with folds and wrinkles, 2003"},
      {"force", "bridson", "as printed: by the sine of half the angle, damped by its rate",
       "Bridson, Marino, Fedkiw, Simulation of clothing with folds and wrinkles, 2003"},
      {"force", "tension_only, biphasic", "minus the gradient of its energy",
       "Choi, Ko, 2002; Chen, Zhu, Kaufman, Physically based animation, 1998"},
      {"force", "kawabata",
       "tension curve of KES-F1 by LT and EMT; minus the gradient of its energy",
       "Zhong, Wang, 1998; Ji et al., 2006; Zhang et al., 2012"},
      {"force", "buckling", "minus the gradient of its energy; survey eq. 5 mended",
       "Choi, Ko, Stable but responsive cloth, 2002"},
      {"force", "twisting", "minus the gradient of its energy; also the beam, survey eq. 4 mended",
       "Dai, Li, Zhang, 2003; Villard, Borouchaki, 2005"},
      {"force", "gravity", "", ""},
      {"force", "air", "", "drag of triangles and particles, wind"},
      {"integrator", "implicit_euler", "stable at any step of the scene",
       "Baraff, Witkin, Large steps in cloth simulation, 1998"},
      {"integrator", "symplectic_euler", "stable below 2/omega, which is checked", ""},
      {"strain_limiter", "position", "says the residual it leaves",
       "Provot, Deformation constraints in a mass-spring model, 1995"},
      {"body", "plane, box, sphere, capsule, cylinder, cone, torus", "vertices on the true shape",
       ""},
      {"body", "OBJ, PLY, OFF", "read exactly, by a reader of our own", ""},
      {"body", "STL, glTF and other formats", "single precision, in a child process",
       "Open Asset Import Library (assimp)", has_assimp},
      {"body", "keyframes", "static, moved rigidly, or a sequence of meshes", ""},
  };
}

std::string describe(const selvedge::BroadPhaseTraits& traits) {
  std::string text = traits.guarantee == selvedge::Guarantee::conservative
                         ? "conservative: misses nothing"
                         : "approximate: may miss";
  if (!traits.self) text += "; no self-collision";
  if (!traits.deforming) text += "; static bodies only";
  if (traits.closed_body_only) text += "; closed bodies only";
  return text;
}

std::string describe(const selvedge::NarrowPhaseTraits& traits) {
  return std::string(traits.misses_nothing ? "misses nothing" : "may miss") +
         (traits.no_false_alarm ? ", no false alarm" : ", may raise false alarms") +
         (traits.gives_time ? "" : ", gives no time") +
         (traits.limits.empty() ? "" : "; " + traits.limits);
}

std::string describe(const selvedge::ResponseTraits& traits) { return traits.promise; }

template <class Registry, class... Config>
void add_registry(const char* family, const Registry& registry, std::vector<Method>& methods,
                  const Config&... config) {
  for (const auto& [name, make] : registry) {
    const auto traits = make(config...)->traits();
    methods.push_back({family, name, describe(traits), traits.source});
  }
}

void add_absent_adapters(const selvedge::Methods& build, std::vector<Method>& methods) {
  for (const AdapterMethod& adapter : adapter_methods()) {
    const bool there = adapter.family == "broad_phase" ? build.broad_phases.contains(adapter.name)
                                                       : build.narrow_phases.contains(adapter.name);
    if (!there)
      methods.push_back({adapter.family, adapter.name, "needs " + adapter.library, "", false});
  }
}

std::vector<Method> all_methods() {
  std::vector<Method> methods;
  const selvedge::Methods build = methods_of_this_build();
  add_registry("broad_phase", build.broad_phases, methods);
  add_registry("narrow_phase", build.narrow_phases, methods, selvedge::NarrowPhaseConfig{});
  add_registry("response", build.responses, methods, selvedge::ResponseConfig{});
  add_registry("fail_safe", build.fail_safes, methods);
  add_absent_adapters(build, methods);
  const auto by_family = [](const Method& a, const Method& b) { return a.family < b.family; };
  std::stable_sort(methods.begin(), methods.end(), by_family);
  for (Method& method : fixed_methods()) methods.push_back(std::move(method));
  return methods;
}

void print_table(const std::vector<Method>& methods) {
  std::string_view family;
  for (const Method& method : methods) {
    if (method.family != family) fmt::print("{}{}\n", family.empty() ? "" : "\n", method.family);
    family = method.family;
    fmt::print("  {}{}\n", method.name, method.available ? "" : "  (not in this build)");
    if (!method.guarantee.empty()) fmt::print("      {}\n", method.guarantee);
    if (!method.source.empty()) fmt::print("      {}\n", method.source);
  }
}

void print_json(const std::vector<Method>& methods) {
  auto list = nlohmann::json::array();
  for (const Method& method : methods)
    list.push_back({{"family", method.family},
                    {"name", method.name},
                    {"guarantee", method.guarantee},
                    {"source", method.source},
                    {"available", method.available}});
  fmt::print("{}\n", nlohmann::json{{"methods", list}}.dump(2));
}

}  // namespace

void add_command_list(CLI::App& app, int&) {
  CLI::App* command =
      app.add_subcommand("list", "Every method of this build, its paper and guarantee");
  const auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "Print JSON");
  command->callback([json] {
    if (*json)
      print_json(all_methods());
    else
      print_table(all_methods());
  });
}
