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
      {"pattern", "bilayered", "a dense layer that collides, tied to a sparse one that carries",
       "Kang, Cho, Bilayered approximate integration, 2002"},
      {"pattern", "refine curved", "cells split where they bend; tied hanging nodes, no gap",
       "Villard, Borouchaki, Adaptive meshing for cloth animation, 2005"},
      {"pattern", "refine settled", "cells split everywhere at rest; mass and momentum kept",
       "Zhang, Yuen, Cloth simulation using multilevel meshes, 2001"},
      {"pattern", "support", "a closed surface and its middle; survey eq. 3 mended",
       "Zhengdong, Shuyuan, A mass-spring model for real time cloth deformation, 2011"},
      {"pattern", "mesh", "any triangle mesh, file order and double precision kept", ""},
      {"force", "hooke", "minus the gradient of its energy",
       "stretch and shear springs, Hooke's law"},
      {"force", "bending", "minus the gradient of its energy",
       "Bridson, Marino, Fedkiw, Simulation of clothing with folds and wrinkles, 2003"},
      {"force", "shape_operator", "a plate on any mesh; minus the gradient of its energy",
       "Onate, Zarate, Rotation-free triangular plate and shell elements, 2000; Gingold et al., "
       "2004"},
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
      {"force", "hysteresis", "minus the gradient of its energy within a step; has a memory",
       "Kawabata, KES-F; Zhong, Wang, 1998; Ji et al., 2006; Zhang et al., 2012"},
      {"force", "plate", "springs fitted to a plate; tells what they cannot fit",
       "Wang, Devarajan, Improved 2D mass-spring-damper model with unstructured meshes, 2008"},
      {"force", "volume", "no sum, no moment; not a gradient; survey eq. 3 mended",
       "Zhengdong, Shuyuan, 2011; Vassilev, Spanlang, 2014"},
      {"force", "virtual_springs", "minus the gradient of its energy; fixed in space or following",
       "Yuan et al., Real-time simulation of tissue cutting with CUDA, 2010"},
      {"force", "tie", "minus the gradient of its energy; hanging nodes and dense layers",
       "Villard, Borouchaki, 2005; Kang, Cho, 2002"},
      {"force", "sewing", "minus the gradient of its energy; survey eq. 10 mended",
       "Zhong, Xu, Three-dimensional garment dressing simulation, 2009"},
      {"force", "water", "no water, mass or momentum is lost until it drips",
       "Chen, Magnenat Thalmann, Allen, Physical simulation of wet clothing, 2012"},
      {"force", "gravity", "", ""},
      {"force", "air", "", "drag of triangles and particles, wind"},
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

void add_integrators(const selvedge::Methods& build, std::vector<Method>& methods) {
  for (const auto& [name, make] : build.integrators) {
    const selvedge::IntegratorTraits traits = make({}, 0, {})->traits();
    methods.push_back(
        {"integrator", name, std::string(traits.promise), std::string(traits.source)});
  }
}

void add_strain_limiters(const selvedge::Methods& build, std::vector<Method>& methods) {
  for (const auto& [name, entry] : build.strain_limiters)
    methods.push_back(
        {"strain_limiter", name, std::string(entry.promise), std::string(entry.source)});
  methods.push_back({"strain_limiter", "biphasic (materials: stretch_law)",
                     "stiffer above a strain, continuous; a law of the springs",
                     "Chen, Zhu, Kaufman, Physically based animation, 1998"});
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
  add_integrators(build, methods);
  add_strain_limiters(build, methods);
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
