// SPDX-License-Identifier: MIT
//
// selvedge._core, the compiled half of the package `selvedge`. The Python files of the package hold
// its public functions and their documentation.
#include "parts.h"

PYBIND11_MODULE(_core, m) {
  m.doc() = "The compiled half of selvedge; use the package selvedge itself.";
  const auto methods = std::make_shared<const selvedge::Methods>(selvedge::methods_of_this_build());
  selvedge::python::add_methods(m, methods);
  selvedge::python::add_detection(m, methods);
  selvedge::python::add_ccd(m, methods);
  selvedge::python::add_scene(m, methods);
  selvedge::python::add_simulation(m, methods);
  selvedge::python::add_batch(m, methods);
  selvedge::python::add_results(m, methods);
  selvedge::python::add_pictures(m);
  selvedge::python::add_dress(m, methods);
  selvedge::python::add_compare(m, methods);
}
