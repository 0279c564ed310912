// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/heartbeat.h>
#include <selvedge/apps/detail/output_file.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/lab/fabric_drape.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/fabric_file.h>
#include <selvedge/scene/methods.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;

struct DrapeOptions {
  std::vector<std::string> names;
  int seeds = 5, cells = 32, levels = 2;
  bool json = false;
  std::string mesh = "arc";
  std::string stretch_law;     // empty: the fabric's
  std::string geometric, out;  // scene and mesh of a geometric drape
  int most_sweeps = GeometricDrapeConfig{}.most_sweeps;
};

/// The results of one fabric.
struct DrapeRow {
  std::string name;
  std::optional<double> measured;
  DrapeStatistics computed;
};

DrapeRow compute(const Fabric& fabric, const DrapeOptions& o) {
  DrapeSeries series{.trial = {}, .seeds = o.seeds, .levels = o.levels};
  series.trial.cells = o.cells;
  series.trial.mesh = o.mesh == "woven"        ? DrapeMesh::woven
                      : o.mesh == "triangular" ? DrapeMesh::triangular
                                               : DrapeMesh::arc;
  Material material = fabric.material;
  if (!o.stretch_law.empty()) material.stretch_law = o.stretch_law;
  return {fabric.name, fabric.constants.drape_coefficient, drape_series(material, series)};
}

std::string joined(const std::vector<std::int32_t>& numbers) {
  return fmt::format("{}", fmt::join(numbers, " "));
}

void print_row(const DrapeRow& row) {
  const DrapeStatistics& c = row.computed;
  const auto limit = c.limit();
  print_escaped(
      "{:<32}{:>9}{:>10.1f}{:>8.1f}{:>8}{:>7}{:>8}{:>8.1f}{:>11}  {}{}\n", row.name,
      row.measured ? fmt::format("{:.1f}", *row.measured) : "-", c.mean(), c.spread(),
      limit ? fmt::format("{:.1f}", limit->value) : "-",
      limit ? fmt::format("{:.1f}", limit->uncertainty) : "-",
      row.measured ? fmt::format("{:+.1f}", c.value() - *row.measured) : "-", c.strips, c.unsettled,
      joined(c.folds),
      limit ? " (finer: " + joined({c.refined_folds.begin() + 1, c.refined_folds.end()}) + ")"
            : "");
  std::fflush(stdout);
}

Json to_json(const DrapeRow& row) {
  const DrapeStatistics& c = row.computed;
  Json json = {{"name", row.name},        {"computed", c.coefficient}, {"mean", c.mean()},
               {"spread", c.spread()},    {"folds", c.folds},          {"strips", c.strips},
               {"unsettled", c.unsettled}};
  if (row.measured) json["measured"] = *row.measured;
  if (const auto limit = c.limit()) {
    json["refined"] = c.refined;
    json["refined_folds"] = c.refined_folds;
    json["limit"] = limit->value;
    json["limit_uncertainty"] = limit->uncertainty;
    json["order"] = limit->order;
  }
  return json;
}

// -- the geometric drape --------------------------------------------------------------------------

/// The grid of a scene that is hung by geometry alone.
GridConfig grid_of(const Scene& scene) {
  const auto* grid =
      scene.cloths.size() == 1 ? std::get_if<ClothGrid>(&scene.cloths[0].shape) : nullptr;
  if (grid == nullptr || grid->pattern != "rectangular")
    throw std::invalid_argument(scene.file.string() +
                                ": a geometric drape needs one piece of cloth, a grid of the "
                                "pattern \"rectangular\"");
  GridConfig scaled = grid->grid;
  scaled.size_x *= scene.cloths[0].scale;
  scaled.size_y *= scene.cloths[0].scale;
  return scaled;
}

/// The vertices that handles hold at the end of the scene, and where.
std::vector<HeldVertex> held_at_the_end(const Scene& scene, const std::vector<Vec3>& start) {
  const double end = scene.time.frames / scene.time.fps;
  std::vector<HeldVertex> held;
  for (const HandleSpec& handle : scene.handles) {
    if (handle.release && end >= *handle.release) continue;
    Vec3 pivot = Vec3::Zero();
    for (const std::int32_t v : handle.vertices) pivot += start.at(v);
    pivot /= static_cast<double>(handle.vertices.size());
    const Keyframe pose = pose_at(handle.motion, end);
    for (const std::int32_t v : handle.vertices)
      held.push_back({v, handle.motion.empty() ? start[v]
                                               : Vec3(pivot + pose.translation +
                                                      pose.rotation * (start[v] - pivot))});
  }
  return held;
}

void hang(const DrapeOptions& o) {
  const Methods methods = methods_of_this_build();
  const Scene scene = read_scene(o.geometric, {}, methods);
  const GridConfig grid = grid_of(scene);
  const BuiltScene built = build_scene(scene, methods);
  const GeometricDrape drape = drape_geometrically(
      grid, held_at_the_end(scene, built.cloth.surface.vertices), {.most_sweeps = o.most_sweeps});
  double lowest = drape.shape.vertices.front().z();
  for (const Vec3& x : drape.shape.vertices) lowest = std::min(lowest, x.z());
  if (!o.out.empty()) refuse_other_kind(o.out, kObjMesh, "--out");
  if (!o.out.empty()) write_obj(o.out, drape.shape.vertices, drape.shape.triangles);
  if (o.json) {
    print_document(Json{{"curves", drape.curves},
                        {"sweeps", drape.sweeps},
                        {"residual", drape.residual},
                        {"lowest", lowest}});
    return;
  }
  print_escaped(
      "{} catenaries, {} sweeps of the relaxation; largest strain {:.3f} %, lowest point {:.4f} "
      "m\n",
      drape.curves, drape.sweeps, 100.0 * drape.residual, lowest);
}

void run_command(const DrapeOptions& o) {
  if (!o.geometric.empty()) return hang(o);
  std::vector<Fabric> fabrics;
  if (o.names.empty())
    for (int i = 1; i <= 6; ++i)
      fabrics.push_back(find_fabric("petrak_2025/M" + std::to_string(i), "."));
  for (const std::string& name : o.names) fabrics.push_back(find_fabric(name, "."));
  if (!o.json)
    print_escaped(
        "drape coefficient, %; {} cm on 18 cm, held on the support, {} mesh, {} cells, {}"
        "\n{:<32}{:>9}{:>10}{:>8}{:>8}{:>7}{:>8}{:>8}{:>11}  {}\n",
        200.0 * DrapeSeries{}.trial.specimen, o.mesh, o.cells, counted(o.seeds, "seed"), "fabric",
        "measured", "computed", "spread", "limit", "+-", "error", "strips", "unsettled", "folds");
  Json rows = Json::array();
  Heartbeat heartbeat("drape");
  for (std::size_t i = 0; i < fabrics.size(); ++i) {
    heartbeat.now(fmt::format("fabric {} of {}", i + 1, fabrics.size()));
    const DrapeRow row = compute(fabrics[i], o);
    heartbeat.now("");
    if (o.json)
      rows.push_back(to_json(row));
    else
      print_row(row);
  }
  if (o.json) print_document(Json{{"results", rows}});
}

void add_drape_options(const Command& command) {
  const auto o = std::make_shared<DrapeOptions>();
  command.option("FABRIC", o->names, "Fabric names or files (default: the six of petrak_2025)");
  command.option("--seeds", o->seeds, "Number of drapes of each fabric, each with its own seed")
      .range(1, 1000);
  command
      .option("--cells", o->cells,
              "Cells from the centre to the rim, of the size at the rim; of other meshes across")
      .range(4, 1000);
  command
      .option("--mesh", o->mesh,
              "Rings and spokes (arc), a grid cut to a disc (woven), which converges slowly, or "
              "triangles (triangular)")
      .one_of({"arc", "woven", "triangular"});
  command
      .option("--stretch-law", o->stretch_law,
              "Springs (hooke) or finite elements instead of the fabric's own law")
      .one_of({"hooke", "st_venant_kirchhoff", "corotated"});
  command
      .option("--levels", o->levels,
              "Meshes for the first seed, each with twice the cells of the one before, "
              "from which the limit and its uncertainty are extrapolated; 1: no "
              "extrapolation")
      .range(1, 6);
  const std::vector<MethodOption> geometric = geometric_drape_options();
  command.option("--geometric", o->geometric,
                 "Instead: hang the grid of this scene from the places where its handles end, by "
                 "geometry alone (Weil 1986)");
  command.option("--most-sweeps", o->most_sweeps, "Of --geometric: " + geometric[1].meaning)
      .range(static_cast<int>(geometric[1].least), static_cast<int>(geometric[1].most));
  command.option("--out", o->out, "Of --geometric: OBJ file for the shape");
  command.flag("--json", o->json, "Print JSON");
  command.action([o] {
    run_command(*o);
    return 0;
  });
}

}  // namespace

selvedge::ProgramCommand drape_command() {
  return {.name = "drape",
          .purpose = "Compute drape coefficients of fabrics and compare them with measurements",
          .add_options = add_drape_options};
}
