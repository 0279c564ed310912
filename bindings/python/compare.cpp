// SPDX-License-Identifier: MIT
//
// Comparisons of error against run time. A comparison copies its process for every run, so that the
// package calls these functions in a process of their own without other threads (_worker.py).
#include <pybind11/stl.h>
#include <selvedge/compare/compare_plan.h>
#include <selvedge/compare/compare_table.h>
#include <selvedge/core/system/internal/files.h>

#include "parts.h"

namespace selvedge::python {
namespace {

namespace py = pybind11;

void write_whole(const std::filesystem::path& file, const std::string& text) {
  AtomicFile out(file);
  out.write(text);
  out.commit();
}

std::vector<Override> overrides_of(const py::dict& request, const char* key) {
  std::vector<Override> out;
  for (const auto& [path, value] :
       request[key].cast<std::vector<std::pair<std::string, std::string>>>())
    out.push_back({path, value});
  return out;
}

CompareRequest request_of(const py::dict& given) {
  CompareRequest request;
  request.scene = given["scene"].cast<std::string>();
  request.set = overrides_of(given, "set");
  request.vary = given["vary"].cast<std::vector<std::string>>();
  request.design = given["design"].cast<std::string>() == "product" ? CompareDesign::product
                                                                    : CompareDesign::one_at_a_time;
  request.reference = given["reference"].cast<bool>();
  request.error = given["error"].cast<std::string>();
  request.repeats = given["repeats"].cast<int>();
  request.limits.threads = given["threads"].cast<int>();
  request.limits.budget_s = given["budget"].cast<double>();
  request.command = given["command"].cast<std::string>();
  return request;
}

}  // namespace

void add_compare(py::module_& m, const SharedMethods& methods) {
  m.def("plan_compare", [methods](const py::dict& given, const std::string& out,
                                  const std::string& build) {
    PlannedCompare made = plan_compare(request_of(given), *methods, [](const std::string&) {});
    made.plan.build = build;
    const FolderLock lock(out, "compare");
    write_plan(out, made.plan, made.scene_of_id);
  });
  m.def("run_compare", [methods](const std::string& out, const std::string& build,
                                 const py::object& progress) {
    const ComparePlan plan = read_plan(out);
    if (plan.build != build)
      throw std::invalid_argument(out +
                                  ": was planned by another build; times and bits of the two do "
                                  "not mix");
    const FolderLock lock(out, "compare");
    run_missing(out, plan, *methods, [&](int done, int all) { progress(done, all); });
  });
  m.def("compare_table", [methods](const std::string& out) {
    const CompareTable table = make_table(out, read_plan(out), *methods);
    const std::string text = to_json_text(table);
    write_whole(std::filesystem::path(out) / "compare.csv", to_csv(table));
    write_whole(std::filesystem::path(out) / "compare.json", text);
    write_whole(std::filesystem::path(out) / "compare.html", compare_page(out, table));
    return text;
  });
  m.def("error_names", &error_names);
}

}  // namespace selvedge::python
