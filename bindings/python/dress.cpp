// SPDX-License-Identifier: MIT
//
// Garments from sewing patterns, put on bodies.
#include <pybind11/stl.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/dress/dress_result.h>
#include <selvedge/garment/sewing_pattern.h>
#include <selvedge/scene/fabric_file.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "arrays.h"
#include "interruptible.h"
#include "parts.h"

namespace selvedge::python {
namespace {

UpAxis axis_of(const std::string& up) {
  return up == "x" ? UpAxis::x : up == "z" ? UpAxis::z : UpAxis::y;
}

template <class Value>
std::optional<Value> given(const py::dict& options, const char* key) {
  if (options[key].is_none()) return std::nullopt;
  return options[key].cast<Value>();
}

/// Meshes from files, with the axes of the first of them, or from arrays with z up.
struct Meshes {
  std::vector<TriangleMesh> list;
  LoadConfig axes{.up = UpAxis::z};

  void add(const py::handle& mesh, const py::dict& options) {
    if (py::isinstance<py::str>(mesh)) {
      const auto file = mesh.cast<std::string>();
      LoadConfig config;
      config.unit = given<double>(options, "unit");
      if (const auto up = given<std::string>(options, "up"); up || !states_axes(file))
        config.up = axis_of(up.value_or("y"));
      const BodyMesh body = load_body_mesh(file, config);
      if (list.empty()) axes = {.unit = body.axes.unit, .up = body.axes.up};
      list.push_back(body.mesh);
      return;
    }
    const auto [x, t] = mesh.cast<std::pair<Doubles, Whole>>();
    const auto vertices = positions(x, "body");
    const auto faces = triangles(t, "body triangles");
    list.push_back({{vertices.begin(), vertices.end()}, {faces.begin(), faces.end()}});
  }
};

DressConfig config_of(const py::dict& options) {
  DressConfig config;
  config.edge_length = options["resolution"].cast<double>();
  if (const auto fabric = given<std::string>(options, "fabric")) {
    config.fabric = find_fabric(*fabric, std::filesystem::current_path()).material;
    config.fabric_name = *fabric;
    config.wearable_stretch = config.fabric.strain_limit;
  }
  if (const auto friction = given<double>(options, "friction")) config.body_friction = *friction;
  if (const auto budget = given<double>(options, "budget")) config.budget = *budget;
  config.fit_origin = options["fit_origin"].cast<bool>();
  config.motion.rate = options["pose_rate"].cast<double>();
  return config;
}

py::dict tables(DressResult&& r) {
  py::dict out;
  out["panels"] = r.panel_names;
  out["x"] = own<double>(std::move(r.garment.vertices));
  out["triangles"] = own<std::int32_t>(std::move(r.garment.triangles));
  out["flat_x"] = own<double>(std::move(r.flat.vertices));
  out["flat_triangles"] = own<std::int32_t>(std::move(r.flat.triangles));
  out["panel_of_triangle"] = own<std::int32_t>(std::move(r.panel_of_triangle));
  out["pressure"] = own<double>(std::move(r.pressure));
  out["body_x"] = own<double>(std::move(r.body.vertices));
  return out;
}

/// The text of result.json, and the arrays of the garment.
std::pair<std::string, py::dict> dress_garment(const SharedMethods& methods,
                                               const std::string& pattern_file,
                                               const py::object& body, const py::list& poses,
                                               const py::dict& options) {
  Meshes meshes;
  meshes.add(body, options);
  for (const py::handle& pose : poses) meshes.add(pose, options);
  DressConfig config = config_of(options);
  config.motion.poses.assign(meshes.list.begin() + 1, meshes.list.end());
  DressFolderConfig folder;
  folder.out = options["out"].cast<std::string>();
  folder.pictures = options["pictures"].cast<bool>();
  folder.body_file = meshes.axes;
  folder.pose_formats = options["pose_formats"].cast<std::vector<std::string>>();
  if (py::isinstance<py::str>(body)) folder.body_name = body.cast<std::string>();
  const UpAxis up = axis_of(given<std::string>(options, "up").value_or("y"));
  DressResult result = stoppable([&] {
    const SewingPattern pattern = turned_upright(read_sewing_pattern(pattern_file), up);
    return dress_into_folder(pattern, meshes.list.front(), config, folder, *methods);
  });
  const std::string text = dress_result_text(pattern_file, result, folder.body_name);
  return {text, tables(std::move(result))};
}

}  // namespace

void add_dress(py::module_& m, const SharedMethods& methods) {
  m.def("dress", [methods](const std::string& pattern, const py::object& body,
                           const py::list& poses, const py::dict& options) {
    return dress_garment(methods, pattern, body, poses, options);
  });
}

}  // namespace selvedge::python
