// SPDX-License-Identifier: MIT
//
// The methods of this build, its version, and its threads.
#include <pybind11/stl.h>
#include <selvedge/apps/version.h>
#include <selvedge/core/base/parallel.h>

#include "arrays.h"
#include "parts.h"

namespace selvedge::python {
namespace {

py::dict option_table(const MethodOption& option) {
  py::dict out;
  out["name"] = option.name;
  if (option.kind == OptionKind::boolean)
    out["default"] = option.initial != 0.0;
  else if (option.kind == OptionKind::whole)
    out["default"] = static_cast<std::int64_t>(option.initial);
  else
    out["default"] = option.initial;
  out["unit"] = option.unit;
  out["least"] = option.least;
  out["most"] = option.most;
  out["meaning"] = option.meaning;
  return out;
}

py::list method_table(const Methods& methods) {
  py::list out;
  for (const ListedMethod& method : list_methods(methods)) {
    py::list options;
    for (const MethodOption& option : method.options) options.append(option_table(option));
    py::dict row;
    row["family"] = method.family;
    row["name"] = method.name;
    row["key"] = method.key;
    row["promise"] = method.promise;
    row["source"] = method.source;
    row["library"] = method.library;
    row["available"] = method.available;
    row["options"] = options;
    out.append(row);
  }
  return out;
}

/// `with ThreadLimit(n):`
class ThreadScope {
 public:
  explicit ThreadScope(int threads) : threads_(threads) {
    if (threads < 0)
      throw std::invalid_argument("threads is " + std::to_string(threads) +
                                  "; it must be 0 (all) or positive");
  }
  void enter() { limit_ = std::make_unique<ThreadLimit>(threads_); }
  void leave() { limit_.reset(); }

 private:
  int threads_;
  std::unique_ptr<ThreadLimit> limit_;
};

}  // namespace

void add_methods(py::module_& m, const SharedMethods& methods) {
  m.def("list_methods", [methods] { return method_table(*methods); });
  m.def("version_text", &version_text);
  py::class_<ThreadScope>(m, "ThreadScope")
      .def(py::init<int>())
      .def("enter", &ThreadScope::enter)
      .def("leave", &ThreadScope::leave);
}

}  // namespace selvedge::python
