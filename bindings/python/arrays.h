// SPDX-License-Identifier: MIT
//
// NumPy arrays and the arrays of the library. Python code (selvedge/_arrays.py) has checked data
// types and shapes and copied what does not lie in memory as the library needs it, so that arrays
// come in without a copy here.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <selvedge/core/base/collision_types.h>
#include <selvedge/core/base/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace selvedge::python {

namespace py = pybind11;

using Doubles = py::array_t<double, py::array::c_style>;
using Whole = py::array_t<std::int32_t, py::array::c_style>;

static_assert(sizeof(Vec3) == 3 * sizeof(double) && alignof(Vec3) == alignof(double));
static_assert(sizeof(Triangle) == 3 * sizeof(std::int32_t));

/// The rows of an (n,k) array.
template <class Row, class Number>
std::span<const Row> rows(const py::array_t<Number, py::array::c_style>& array, const char* name) {
  constexpr std::size_t width = sizeof(Row) / sizeof(Number);
  if (array.ndim() != 2 || static_cast<std::size_t>(array.shape(1)) != width)
    throw std::invalid_argument(std::string(name) + ": must have the shape (n, " +
                                std::to_string(width) + ")");
  return {reinterpret_cast<const Row*>(array.data()), static_cast<std::size_t>(array.shape(0))};
}
inline std::span<const Vec3> positions(const Doubles& array, const char* name) {
  return rows<Vec3>(array, name);
}
inline std::span<const Triangle> triangles(const Whole& array, const char* name) {
  return rows<Triangle>(array, name);
}

/// An (n,k) array, or (n) for k = 1, that owns the memory of `values`; nothing is copied.
template <class Number, class Row>
py::array own(std::vector<Row>&& values) {
  constexpr std::size_t width = sizeof(Row) / sizeof(Number);
  auto* kept = new std::vector<Row>(std::move(values));
  const py::capsule owner(kept, [](void* p) { delete static_cast<std::vector<Row>*>(p); });
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(kept->size())};
  if constexpr (width > 1) shape.push_back(static_cast<py::ssize_t>(width));
  return py::array_t<Number>(shape, reinterpret_cast<const Number*>(kept->data()), owner);
}

/// A read-only (n,k) array over the memory of `values`, which `owner` keeps alive.
template <class Number, class Row>
py::array view(std::span<const Row> values, std::shared_ptr<const void> owner) {
  constexpr std::size_t width = sizeof(Row) / sizeof(Number);
  auto* kept = new std::shared_ptr<const void>(std::move(owner));
  const py::capsule base(kept,
                         [](void* p) { delete static_cast<std::shared_ptr<const void>*>(p); });
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(values.size())};
  if constexpr (width > 1) shape.push_back(static_cast<py::ssize_t>(width));
  py::array_t<Number> array(shape, reinterpret_cast<const Number*>(values.data()), base);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

/// One field of each of `values` as an array that owns its memory.
template <class Number, class Value, class Field>
py::array column(const std::vector<Value>& values, Field field) {
  std::vector<decltype(field(values.front()))> out;
  out.reserve(values.size());
  for (const Value& value : values) out.push_back(field(value));
  return own<Number>(std::move(out));
}

}  // namespace selvedge::python
