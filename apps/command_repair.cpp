// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/dress/internal/repair_garment.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct RepairOptions {
  std::string mesh, against, out;
  double unit = 1.0;
  bool json = false;
};

std::string suffix(const std::string& file) { return fs::path(file).extension().string(); }

/// As in its file: no axis turned, every vertex kept.
TriangleMesh read(const RepairOptions& o, const std::string& file) {
  LoadConfig config;
  config.unit = o.unit;
  config.up = UpAxis::z;
  config.weld = false;
  TriangleMesh mesh = load_mesh(file, config);
  if (mesh.triangles.empty()) throw std::invalid_argument(file + ": has no triangles");
  return mesh;
}

/// Whether an OBJ statement is a vertex; `rest` is then what follows its three coordinates, such as
/// a colour.
bool is_vertex(std::string_view line, std::string_view& rest) {
  constexpr std::string_view blank = " \t\r\n";
  rest = line;
  for (int word = 0; word < 4; ++word) {
    const std::size_t begin = std::min(rest.find_first_not_of(blank), rest.size());
    const std::size_t end = std::min(rest.find_first_of(blank, begin), rest.size());
    if (word == 0 && rest.substr(begin, end - begin) != "v") return false;
    rest.remove_prefix(end);
  }
  return true;
}

/// The text of an OBJ file with other vertices; all else, such as texture coordinates, groups and
/// polygons, stays. Vertices that did not move keep their text.
std::string with_vertices(std::string_view text, const std::vector<Vec3>& before,
                          const std::vector<Vec3>& x, double unit) {
  std::string out;
  std::size_t vertex = 0;
  for (std::size_t end = 0; !text.empty(); text.remove_prefix(end)) {
    end = std::min(text.find('\n'), text.size() - 1) + 1;
    const std::string_view line = text.substr(0, end);
    std::string_view rest;
    if (!is_vertex(line, rest) || vertex >= x.size() || x[vertex] == before[vertex]) {
      out += line;
    } else {
      const Vec3 p = x[vertex] / unit;
      out += fmt::format("v {:.17g} {:.17g} {:.17g}{}", p.x(), p.y(), p.z(), rest);
    }
    vertex += is_vertex(line, rest) ? 1 : 0;
  }
  return out;
}

constexpr std::uintmax_t kMostBytes = std::uintmax_t{1} << 40;  // it was read before

void write(const RepairOptions& o, const TriangleMesh& mesh, const std::vector<Vec3>& x) {
  if (suffix(o.mesh) == ".obj" && suffix(o.out) == ".obj") {
    const std::string text =
        with_vertices(read_whole_file(o.mesh, {.what = "mesh", .most_bytes = kMostBytes}),
                      mesh.vertices, x, o.unit);
    AtomicFile file(o.out);
    file.write(text);
    file.commit();
    return;
  }
  std::vector<Vec3> scaled = x;
  for (Vec3& p : scaled) p /= o.unit;
  if (suffix(o.out) == ".ply")
    write_ply(o.out, scaled, mesh.triangles);
  else
    write_obj(o.out, scaled, mesh.triangles);
}

Json to_json(const RepairOptions& o, const RepairResult& r) {
  const auto array = [&](const std::vector<RepairPlace>& places) {
    Json all = Json::array();
    for (const RepairPlace& place : places) {
      const Vec3 at = place.at / o.unit;
      all.push_back({{"at", {at.x(), at.y(), at.z()}},
                     {"vertices", place.vertices},
                     {"stretch", place.stretch}});
    }
    return all;
  };
  return {{"mesh", o.mesh},
          {"against", o.against},
          {"out", o.out},
          {"clean", r.clean()},
          {"good", r.good()},
          {"body_pairs_before", r.body_before},
          {"own_pairs_before", r.self_before},
          {"body_pairs_after", r.body_after},
          {"own_pairs_after", r.self_after},
          {"vertices_inside_after", r.inside_after},
          {"vertices_inside", r.inside},
          {"vertices_moved", r.moved},
          {"largest_motion_m", r.largest_motion},
          {"median_motion_of_the_others_m", r.median_motion},
          {"max_stretch", r.max_stretch},
          {"wearable_stretch", RepairConfig{}.wearable_stretch},
          {"left", array(r.left)},
          {"stretched", array(r.stretched)}};
}

void print_places(const RepairOptions& o, const RepairResult& r) {
  const auto line = [&](const char* what, const RepairPlace& place) {
    const Vec3 at = place.at / o.unit;
    print_escaped("{:13}{} near ({:.4g}, {:.4g}, {:.4g})", what,
                  counted(static_cast<std::size_t>(place.vertices), "vertex", "vertices"), at.x(),
                  at.y(), at.z());
  };
  for (const RepairPlace& place : r.left) {
    line("left", place);
    print_escaped("\n");
  }
  for (const RepairPlace& place : r.stretched) {
    line("stretched", place);
    print_escaped(" by {:.0f} %\n", 100.0 * place.stretch);
  }
}

void print(const RepairOptions& o, const RepairResult& r) {
  print_escaped("{}: {} inside the body, {} with it and {} with itself\n", o.mesh,
                counted(static_cast<std::size_t>(r.inside), "vertex", "vertices"),
                counted(static_cast<std::size_t>(r.body_before), "crossing"), r.self_before);
  print_escaped("moved        {}, at most {:.2f} mm; median of those that were outside {:.3f} mm\n",
                counted(static_cast<std::size_t>(r.moved), "vertex", "vertices"),
                1e3 * r.largest_motion, 1e3 * r.median_motion);
  print_escaped("stretch      at most {:.1f} %, wearable {:.1f} %\n", 100.0 * r.max_stretch,
                100.0 * RepairConfig{}.wearable_stretch);
  if (r.clean())
    print_escaped("clean        yes{}; {}\n",
                  r.good() ? "" : fmt::format(", but stretched by {:.0f} %", 100.0 * r.max_stretch),
                  o.out);
  else
    print_escaped("clean        NO: {} with the body and {} with itself remain, {} inside; {}\n",
                  counted(static_cast<std::size_t>(r.body_after), "crossing"), r.self_after,
                  r.inside_after, o.out);
  print_places(o, r);
}

int repair_command(RepairOptions o) {
  if (o.out.empty()) {
    const fs::path file = o.mesh;
    const std::string kind = suffix(o.mesh) == ".ply" ? ".ply" : ".obj";
    o.out = (file.parent_path() / (file.stem().string() + "_repaired" + kind)).string();
  }
  std::error_code ignored;
  if (fs::equivalent(o.out, o.mesh, ignored) || fs::equivalent(o.out, o.against, ignored))
    throw std::invalid_argument(o.out + ": is an input, too; give --out another file");
  if (suffix(o.out) != ".obj" && suffix(o.out) != ".ply")
    throw std::invalid_argument(o.out + ": --out must end in .obj or .ply");
  const TriangleMesh mesh = read(o, o.mesh), body = read(o, o.against);
  const RepairResult result = repair_garment(mesh, body);
  write(o, mesh, result.x);
  if (o.json)
    print_escaped("{}\n", to_json(o, result).dump(2));
  else
    print(o, result);
  return result.good() ? 0 : 1;
}

void add_repair_options(const Command& command) {
  const auto options = std::make_shared<RepairOptions>();
  command.option("mesh", options->mesh, "Mesh of a finished garment").required();
  command.option("--against", options->against, "Mesh of the body, in the same axes and unit")
      .required();
  command.option(
      "--out", options->out,
      "Repaired mesh, OBJ or PLY (default: MESH_repaired); an OBJ file keeps all but its "
      "vertices");
  command.option("--unit", options->unit, "Metres per unit of both files")
      .positive()
      .show_default();
  command.flag("--json", options->json, "Print the result as JSON");
  command.footer(
      "Exit code 1: crossings remain, or edges are stretched by more than 30 %; the places are "
      "named.");
  command.action([options] { return repair_command(*options); });
}

}  // namespace

selvedge::ProgramCommand repair_command() {
  return {.name = "repair",
          .purpose = "Take the crossings out of a finished garment",
          .add_options = add_repair_options};
}
