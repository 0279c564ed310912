// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/scene/fabric_file.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;

struct FabricOptions {
  std::vector<std::string> names;
  int cells = 40;
  bool list = false, json = false, meshes = false;
};

/// Elastic constants in the plane of one mesh pattern.
struct MeshRow {
  std::string mesh, refused;
  ContinuumConstants c;
  double off = 0.0;  ///< relative distance from the fabric's
};

double mean_bending(const Material& m) {
  return 0.5 * (m.bending_stiffness + bending_along_weft(m));
}

/// A net of springs with the strip modulus and the shear of the fabric has these: C12 is not free.
ContinuumConstants wanted(const Material& m) {
  const double g = shear_law_of(m).by_springs ? m.shear_stiffness : 0.0;
  const double warp = m.stretch_stiffness, weft = stretch_along_weft(m);
  // c11 - g²/c22 = warp, c22 - g²/c11 = weft
  const double c11 = 0.5 * (warp + std::sqrt(warp * warp + 4.0 * g * g * warp / weft));
  return {c11, c11 * weft / warp, g, m.shear_stiffness, 0.0, 0.0};
}

ClothMesh make(const std::string& mesh, int cells, const Material& m) {
  constexpr double size = 0.3;
  const GridConfig grid{size, size, cells, cells};
  if (mesh == "rectangular") return make_rectangular(grid, m);
  if (mesh == "triangular") {
    const double height = size * std::sqrt(0.75);  // so that triangles are equilateral
    return make_triangular({size, height, cells, cells}, m);
  }
  if (mesh == "simplified") return make_simplified(grid, m, false);
  if (mesh == "checkerboard") return make_simplified(grid, m, true);
  if (mesh == "responsive") return make_responsive(grid, m);
  return make_arc({0.5 * size, cells / 2, 2 * cells}, m);
}

std::vector<MeshRow> mesh_rows(const Material& material, int cells) {
  std::vector<MeshRow> rows;
  for (const char* mesh :
       {"rectangular", "triangular", "simplified", "checkerboard", "responsive", "arc"}) {
    MeshRow& row = rows.emplace_back();
    row.mesh = mesh;
    try {
      const ClothMesh cloth = make(mesh, cells, material);
      const auto& x = cloth.surface.vertices;
      row.c = continuum_constants(cloth, x, surface_area(x, cloth.surface.triangles));
      row.off = relative_distance(row.c, wanted(material));
    } catch (const std::invalid_argument& error) {
      row.refused = error.what();
    }
  }
  return rows;
}

Json to_json(const MeshRow& row) {
  if (!row.refused.empty()) return {{"mesh", row.mesh}, {"refused", row.refused}};
  return {{"mesh", row.mesh},
          {"c11", row.c.c11},
          {"c22", row.c.c22},
          {"c12", row.c.c12},
          {"c33", row.c.c33},
          {"c13", row.c.c13},
          {"c23", row.c.c23},
          {"strip_modulus", strip_modulus(row.c)},
          {"strip_poisson", strip_poisson(row.c)},
          {"off", row.off},
          {"cauchy_residual", cauchy_residual(row.c)}};
}

Json to_json(const Fabric& fabric, const FabricOptions& o) {
  const Material& m = fabric.material;
  Json json = {{"name", fabric.name},
               {"description", fabric.description},
               {"source", fabric.source},
               {"kind", fabric.kind},
               {"material", Json::parse(material_json(m))},
               {"bending_length_m", bending_length(mean_bending(m), m.density)},
               {"notes", fabric.notes}};
  if (fabric.constants.drape_coefficient)
    json["drape_coefficient"] = *fabric.constants.drape_coefficient;
  if (!o.meshes) return json;
  for (const MeshRow& row : mesh_rows(m, o.cells)) json["meshes"].push_back(to_json(row));
  return json;
}

void print_meshes(const Material& material, int cells) {
  print_escaped(
      "  elastic constants of a mesh of {} x {} cells, N/m; off: deviation "
      "from the fabric; Cauchy: the least deviation of any net of springs\n",
      cells, cells);
  print_escaped("  {:<13}{:>9}{:>9}{:>9}{:>9}{:>8}{:>8}{:>9}{:>7}{:>8}{:>8}\n", "mesh", "C11",
                "C22", "C12", "C33", "C13", "C23", "strip", "nu", "off %", "Cauchy%");
  for (const MeshRow& row : mesh_rows(material, cells)) {
    if (!row.refused.empty()) {
      print_escaped("  {:<13}refused: {}\n", row.mesh, row.refused);
      continue;
    }
    const ContinuumConstants& c = row.c;
    print_escaped(
        "  {:<13}{:>9.2f}{:>9.2f}{:>9.2f}{:>9.2f}{:>8.2f}{:>8.2f}{:>9.2f}{:>7.3f}{:>8.2f}"
        "{:>8.2f}\n",
        row.mesh, c.c11, c.c22, c.c12, c.c33, c.c13, c.c23, strip_modulus(c), strip_poisson(c),
        100.0 * row.off, 100.0 * cauchy_residual(c));
  }
}

void print_report(const Fabric& fabric, const FabricOptions& o) {
  const Material& m = fabric.material;
  const double c = bending_length(mean_bending(m), m.density);
  print_escaped("{}{}{}\n", fabric.name, fabric.description.empty() ? "" : ": ",
                fabric.description);
  print_escaped("  source             {}\n", fabric.source);
  print_escaped("  density            {:.6g} kg/m2\n", m.density);
  print_escaped("  stretch_stiffness  {:.6g} N/m along warp, {:.6g} N/m along weft\n",
                m.stretch_stiffness, stretch_along_weft(m));
  print_escaped("  shear_stiffness    {:.6g} N/m\n", m.shear_stiffness);
  print_escaped(
      "  bending_stiffness  {:.6g} N*m along warp, {:.6g} N*m along weft   (bending length of the "
      "mean {:.2f} mm)\n",
      m.bending_stiffness, bending_along_weft(m), 1e3 * c);
  if (m.stretch_law == "kawabata")
    print_escaped("  kawabata           LT {:.4g}, EMT {:.4g}, RT {:.4g}\n", m.kawabata_lt,
                  m.kawabata_strain, m.kawabata_rt);
  const auto print_curve = [](const char* key, const MonotoneCurve& curve) {
    if (!curve.empty()) print_escaped("  {:<18} {}\n", key, counted(curve.x().size(), "point"));
  };
  if (!m.tension_curve.empty()) {
    const TensionFigures figures = figures_of(m.tension_curve);
    print_escaped(
        "  tension_curve      {} points, LT {:.4g}, EMT {:.4g}, WT {:.4g} N/m, RT {:.4g}\n",
        m.tension_curve.x().size(), figures.linearity, figures.extension, figures.work,
        m.kawabata_rt);
  }
  print_curve("tension_curve_weft", m.tension_weft);
  print_curve("shear_curve", m.shear_curve);
  print_curve("bending_curve", m.bending_curve);
  print_curve("bending_curve_weft", m.bending_curve_weft);
  if (m.shear_friction > 0.0) print_escaped("  shear_friction     {:.6g} N/m\n", m.shear_friction);
  if (m.bending_friction > 0.0)
    print_escaped("  bending_friction   {:.6g} N\n", m.bending_friction);
  if (c > 0.0)
    print_escaped("  drape coefficient  {:.1f} % at least (strips){}\n", strip_drape_coefficient(c),
                  fabric.constants.drape_coefficient
                      ? fmt::format(", measured {:.1f} %", *fabric.constants.drape_coefficient)
                      : "");
  for (const std::string& note : fabric.notes) print_escaped("  note: {}\n", note);
  if (o.meshes) print_meshes(m, o.cells);
}

std::vector<Fabric> chosen(const FabricOptions& o) {
  if (o.names.empty() && !o.list)
    throw std::invalid_argument("fabric: give the name of a fabric or a file, or --list");
  if (o.list) return measured_fabrics();
  std::vector<Fabric> fabrics;
  std::error_code ignored;
  for (const std::string& name : o.names) {
    if (std::filesystem::is_regular_file(name, ignored)) {
      for (Fabric& fabric : read_fabrics(name)) fabrics.push_back(std::move(fabric));
    } else {
      fabrics.push_back(find_fabric(name, "."));
    }
  }
  return fabrics;
}

void run_command(const FabricOptions& o) {
  const std::vector<Fabric> fabrics = chosen(o);
  if (o.json) {
    Json list = Json::array();
    for (const Fabric& fabric : fabrics) list.push_back(to_json(fabric, o));
    print_document(Json{{"fabrics", list}});
    return;
  }
  for (const Fabric& fabric : fabrics) {
    if (o.list)
      print_escaped("{:<34}{}\n", fabric.name, fabric.description);
    else
      print_report(fabric, o);
  }
  if (!o.list) return;
  for (const auto& [name, fabric] : everyday_fabrics())
    print_escaped("{:<34}is {}\n", name, fabric);
}

void add_fabric_options(const Command& command) {
  const auto o = std::make_shared<FabricOptions>();
  command.option("FABRIC", o->names,
                 "Fabric files, or names such as petrak_2025/M1; KES-F, FAST, cantilever and "
                 "drape sheets too");
  command.flag("--list", o->list, "List the measured fabrics that are built in");
  command.flag("--meshes", o->meshes,
               "Show the elastic constants that each mesh pattern has, and their "
               "deviation from the fabric");
  command.option("--cells", o->cells, "Cells along a side for --meshes").range(2, 1000);
  command.flag("--json", o->json, "Print JSON");
  command.action([o] {
    run_command(*o);
    return 0;
  });
}

}  // namespace

selvedge::ProgramCommand fabric_command() {
  return {.name = "fabric",
          .purpose = "Convert laboratory measurements of a fabric to the material of a scene",
          .add_options = add_fabric_options};
}
