// SPDX-License-Identifier: MIT
//
// Runs into result folders; exact checks; measures.
#include <pybind11/stl.h>
#include <selvedge/judge/judge.h>
#include <selvedge/run/check_result.h>
#include <selvedge/run/measure_result.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/run/run.h>

#include "arrays.h"
#include "interruptible.h"
#include "parts.h"

namespace selvedge::python {
namespace {

TriangleMesh mesh_of(const Doubles& x, const Whole& t) {
  const auto vertices = positions(x, "x");
  const auto corners = triangles(t, "triangles");
  return {{vertices.begin(), vertices.end()}, {corners.begin(), corners.end()}};
}

py::dict verdict_table(const Verdict& v) {
  py::dict out;
  out["vertices"] = v.vertices;
  out["triangles"] = v.triangles;
  out["self_intersections"] = v.self_intersections;
  out["body_intersections"] = v.body_intersections;
  out["self_touches"] = v.self_touches;
  out["body_touches"] = v.body_touches;
  out["inside_vertices"] = v.inside_vertices;
  out["max_penetration_m"] = v.max_penetration_m;
  out["max_stretch"] = v.max_stretch;
  out["max_compression"] = v.max_compression;
  return out;
}

void add_path(py::dict& out, const PathVerdict& path) {
  out["path_pairs"] = path.pairs;
  out["path_self_collisions"] = path.self_collisions;
  out["path_body_collisions"] = path.body_collisions;
}

/// Meshes as pairs of arrays; of length 0 where there is none.
using Mesh = std::pair<Doubles, Whole>;

py::dict check_arrays(const Mesh& mesh, const std::optional<Mesh>& body,
                      const std::optional<Mesh>& rest, const std::optional<Doubles>& next,
                      const std::optional<Doubles>& body_next) {
  const TriangleMesh cloth = mesh_of(mesh.first, mesh.second);
  const TriangleMesh against = body ? mesh_of(body->first, body->second) : TriangleMesh{};
  const TriangleMesh unstrained = rest ? mesh_of(rest->first, rest->second) : TriangleMesh{};
  Verdict verdict;
  std::optional<PathVerdict> path;
  {
    const py::gil_scoped_release release;
    verdict = judge(cloth, against, unstrained);
    if (next)
      path = judge_path(cloth, positions(*next, "next"), against,
                        body_next ? positions(*body_next, "against_next")
                                  : std::span<const Vec3>(against.vertices));
  }
  py::dict out = verdict_table(verdict);
  if (path) add_path(out, *path);
  return out;
}

py::dict check_folder(const std::string& folder, const std::string& rest, const py::object& call) {
  Progress progress(call);
  const ResultCheck sum = run_interruptible(progress, [&] {
    return check_result(folder, rest, [&](int done, int of) { progress.report(done, of); });
  });
  py::dict out = verdict_table(sum.worst.state);
  if (sum.worst.path) add_path(out, *sum.worst.path);
  out["states"] = sum.states;
  out["paths"] = sum.paths;
  out["first_wrong"] = sum.first_faulty;
  out["last_wrong"] = sum.last_faulty;
  return out;
}

py::list check_files(const std::vector<std::string>& meshes,
                     const std::vector<std::string>& against, const std::string& rest, bool paths) {
  std::vector<CheckFinding> findings;
  {
    const py::gil_scoped_release release;
    check_meshes({.meshes = meshes,
                  .against = against,
                  .rest = rest,
                  .paths = paths,
                  .next = {},
                  .against_next = {}},
                 [&](const CheckFinding& finding) { findings.push_back(finding); });
  }
  py::list out;
  for (const CheckFinding& finding : findings) {
    py::dict row;
    row["file"] = finding.file;
    const py::dict verdict = verdict_table(finding.state);
    for (const auto& [key, value] : verdict) row[key] = value;
    if (finding.path) add_path(row, *finding.path);
    out.append(row);
  }
  return out;
}

std::string run_into(const std::shared_ptr<Scene>& scene, const SharedMethods& methods,
                     const py::dict& options, const py::object& call) {
  RunConfig config;
  config.methods = *methods;
  config.out = options["out"].cast<std::string>();
  config.resume = options["resume"].cast<bool>();
  config.overwrite = options["overwrite"].cast<bool>();
  config.every_step = options["every_step"].cast<bool>();
  Progress progress(call);
  config.stop = &progress.stop();
  config.progress = [&](int frame, double seconds) {
    if (!progress.stop()) progress.report(frame, seconds);
  };
  return run_interruptible(progress, [&, scene] { return result_text(run_scene(*scene, config)); });
}

py::dict strain_tables(const ResultMeasures& found) {
  py::dict out;
  out["x"] = column<double>(found.x, [](const Vec3& x) { return x; });
  out["triangles"] = column<std::int32_t>(found.triangles, [](const Triangle& t) { return t; });
  out["spring_vertices"] = column<std::int32_t>(found.spring_strains, [](const SpringStrain& s) {
    return std::array{s.a, s.b};
  });
  out["spring_strain"] =
      column<double>(found.spring_strains, [](const SpringStrain& s) { return s.strain; });
  out["triangle_strain"] = column<double>(found.triangle_strains, [](const TriangleStrain& s) {
    return std::array{s.smaller, s.larger};
  });
  return out;
}

}  // namespace

void add_results(py::module_& m, const SharedMethods& methods) {
  m.def("check_arrays", &check_arrays);
  m.def("check_folder", &check_folder);
  m.def("check_files", &check_files);
  m.def("run", [methods](const std::shared_ptr<Scene>& scene, const py::dict& options,
                         const py::object& progress) {
    return run_into(scene, methods, options, progress);
  });
  m.def("measure", [methods](const std::string& folder, int frame,
                             const std::optional<double>& support_radius,
                             const std::optional<std::array<double, 2>>& support_centre) {
    MeasureConfig config{.frame = frame, .support_radius = support_radius, .support_centre = {}};
    if (support_centre)
      config.support_centre = Eigen::Vector2d((*support_centre)[0], (*support_centre)[1]);
    ResultMeasures found;
    {
      const py::gil_scoped_release release;
      found = measure_result(folder, config, *methods);
    }
    return py::make_tuple(measures_text(found), strain_tables(found));
  });
}

}  // namespace selvedge::python
