// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/option_values.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/bodies/internal/mesh_groups.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/bodies/mesh_report.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/detection/find.h>

#include <cctype>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;

struct InfoOptions {
  std::string mesh, up;
  std::optional<double> unit;
  std::vector<std::string> groups;
  bool json = false;
};

struct GroupInfo {
  MeshGroup group;
  MeshReport report;
  TriangleMeetings meetings;
};

struct MeshInfo {
  MeshReport report;
  TriangleMeetings meetings;  // of the file as it is, before vertices are merged
  FileAxes axes;
  std::vector<GroupInfo> groups;
  std::string question;
};

LoadConfig load_config(const InfoOptions& o) {
  LoadConfig config;
  config.unit = o.unit;
  config.up = up_axis(o.up);
  config.groups = o.groups;
  return config;
}

const char* kind_name(MeshGroup::Kind kind) {
  return kind == MeshGroup::Kind::object  ? "object"
         : kind == MeshGroup::Kind::group ? "group"
                                          : "material";
}

bool is_obj(const std::string& file) {
  return file.size() > 4 && (file.ends_with(".obj") || file.ends_with(".OBJ"));
}

/// Whether the triangles of the file name vertices by number.
bool has_shared_vertices(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".obj" || extension == ".ply" || extension == ".off";
}

std::vector<GroupInfo> groups_of(const InfoOptions& o) {
  std::vector<GroupInfo> list;
  if (!is_obj(o.mesh)) return list;
  GroupedMesh grouped = read_grouped_mesh(o.mesh);
  LoadConfig config = load_config(o);
  config.groups.clear();
  for (MeshGroup& group : grouped.groups) {
    TriangleMesh part;
    part.vertices = grouped.mesh.vertices;
    for (const std::int32_t t : group.triangles)
      part.triangles.push_back(grouped.mesh.triangles[t]);
    const bool empty = part.triangles.empty();
    const TriangleMeetings meetings = find_meetings(part.vertices, part.triangles);
    MeshReport report;
    if (!empty) report = report_mesh(prepare_mesh(std::move(part), config, o.mesh));
    list.push_back({std::move(group), report, meetings});
  }
  return list;
}

/// As `check` and `run` read it: only formats without shared vertices are welded.
TriangleMeetings meetings_in_file(const InfoOptions& o) {
  LoadConfig config;
  config.groups = o.groups;
  config.weld = !has_shared_vertices(o.mesh);
  const TriangleMesh mesh = load_mesh(o.mesh, config);
  return find_meetings(mesh.vertices, mesh.triangles);
}

MeshInfo inspect(const InfoOptions& o) {
  MeshInfo info;
  BodyMesh body = load_body_mesh(o.mesh, load_config(o));
  info.axes = body.axes;
  info.report = report_mesh(std::move(body.mesh));
  info.meetings = meetings_in_file(o);
  info.groups = groups_of(o);
  if (!o.unit && !info.axes.unit_stated)
    info.question = ask_about_unit(info.report.upper - info.report.lower);
  return info;
}

Json point_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

Json report_json(const MeshReport& r, const TriangleMeetings& meetings) {
  return {{"vertices", r.vertices},
          {"triangles", r.triangles},
          {"parts", r.components},
          {"lower", point_json(r.lower)},
          {"upper", point_json(r.upper)},
          {"closed", r.closed()},
          {"boundary_edges", r.boundary_edges},
          {"non_manifold_edges", r.non_manifold_edges},
          {"inconsistent_edges", r.inconsistent_edges},
          {"crossings", meetings.crossings.size()},
          {"touches", meetings.touches.size()},
          {"folded_neighbours", r.folded_neighbours},
          {"volume", r.closed() ? Json(r.volume) : Json()}};
}

std::string up_letter(const FileAxes& axes) { return {"xyz"[static_cast<int>(axes.up)]}; }

/// Where a value comes from: the option, the file, or neither.
std::string origin_of(bool given, bool stated) {
  return given ? "as given" : stated ? "stated by the file" : "the file does not say";
}

std::string axes_text(const InfoOptions& o, const FileAxes& axes) {
  return fmt::format("1 unit is {:g} m ({}), {} is up ({})", axes.unit,
                     origin_of(o.unit.has_value(), axes.unit_stated), up_letter(axes),
                     origin_of(!o.up.empty(), axes.up_stated));
}

void print_json(const InfoOptions& o, const MeshInfo& info) {
  Json j = report_json(info.report, info.meetings);
  j["file"] = o.mesh;
  j["unit_m"] = info.axes.unit;
  j["up"] = up_letter(info.axes);
  j["unit_stated"] = info.axes.unit_stated;
  j["up_stated"] = info.axes.up_stated;
  j["faults"] = info.report.sentences();
  j["unit_question"] = info.question.empty() ? Json() : Json(info.question);
  j["groups"] = Json::array();
  for (const GroupInfo& g : info.groups) {
    Json of_group = report_json(g.report, g.meetings);
    of_group["kind"] = kind_name(g.group.kind);
    of_group["name"] = g.group.name;
    j["groups"].push_back(std::move(of_group));
  }
  print_document(j);
}

std::string box_text(const MeshReport& r) {
  const Vec3 size = r.upper - r.lower;
  return fmt::format("{:.4g} x {:.4g} x {:.4g} m, from ({:.4g}, {:.4g}, {:.4g})", size.x(),
                     size.y(), size.z(), r.lower.x(), r.lower.y(), r.lower.z());
}

void print_report(const InfoOptions& o, const MeshInfo& info) {
  const MeshReport& r = info.report;
  print_escaped("{}\n", o.mesh);
  print_escaped("  vertices   {}\n  triangles  {} in {} part{}\n", r.vertices, r.triangles,
                r.components, r.components == 1 ? "" : "s");
  print_escaped("  axes       {}\n", axes_text(o, info.axes));
  print_escaped("  box        {}\n", box_text(r));
  if (r.closed())
    print_escaped("  surface    closed, {:.4g} litres\n", 1e3 * r.volume);
  else
    print_escaped("  surface    open: {}, {} with more than two triangles\n",
                  counted(r.boundary_edges, "border edge"), r.non_manifold_edges);
  print_escaped("  crossings  {} of triangles\n", counted(info.meetings.crossings.size(), "pair"));
  if (!info.meetings.touches.empty())
    print_escaped("  touches    {} of triangles\n", counted(info.meetings.touches.size(), "pair"));
  if (!info.question.empty()) print_escaped("  unit?      {} (--unit)\n", info.question);
  for (const std::string& sentence : r.sentences()) print_escaped("  fault      {}\n", sentence);
  if (info.groups.empty()) return;
  print_escaped("  groups\n");
  for (const GroupInfo& g : info.groups)
    if (g.group.triangles.empty())
      print_escaped("    {:<8} {}: no faces\n", kind_name(g.group.kind), g.group.name);
    else
      print_escaped("    {:<8} {}: {}, {}, {}, {}\n", kind_name(g.group.kind), g.group.name,
                    counted(g.group.triangles.size(), "triangle"),
                    g.report.closed() ? "closed" : "open", box_text(g.report),
                    counted(g.meetings.crossings.size(), "crossing"));
}

void add_info_options(const Command& command) {
  const auto o = std::make_shared<InfoOptions>();
  command.option("MESH", o->mesh, "Mesh file: OBJ, PLY, OFF, or what assimp reads").required();
  command.option("--unit", o->unit, "Metres per unit of the file (default: what it states, else 1)")
      .positive();
  command.option("--up", o->up, "Axis of the file that points up (default: what it states, else z)")
      .one_of({"x", "y", "z"});
  command.option("--groups", o->groups, "Only these groups, objects or materials of an OBJ file");
  command.flag("--json", o->json, "Print JSON");
  command.action([o] {
    const MeshInfo info = inspect(*o);
    if (o->json)
      print_json(*o, info);
    else
      print_report(*o, info);
    return 0;
  });
}

}  // namespace

selvedge::ProgramCommand info_command() {
  return {.name = "info",
          .purpose = "Report box, unit, groups, closedness and crossings of a mesh file",
          .add_options = add_info_options};
}
