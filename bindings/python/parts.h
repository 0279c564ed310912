// SPDX-License-Identifier: MIT
//
// The parts of the module; each adds its functions and classes.
#pragma once

#include <pybind11/pybind11.h>
#include <selvedge/scene/methods.h>

#include <memory>

namespace selvedge::python {

/// The methods of this build, made once when the module is imported.
using SharedMethods = std::shared_ptr<const Methods>;

void add_methods(pybind11::module_& m, const SharedMethods& methods);
void add_detection(pybind11::module_& m, const SharedMethods& methods);
void add_ccd(pybind11::module_& m, const SharedMethods& methods);
void add_scene(pybind11::module_& m, const SharedMethods& methods);
void add_simulation(pybind11::module_& m, const SharedMethods& methods);
void add_batch(pybind11::module_& m, const SharedMethods& methods);
void add_results(pybind11::module_& m, const SharedMethods& methods);
void add_pictures(pybind11::module_& m);
void add_dress(pybind11::module_& m, const SharedMethods& methods);
void add_compare(pybind11::module_& m, const SharedMethods& methods);

}  // namespace selvedge::python
