// SPDX-License-Identifier: MIT
//
// Continuous collision detection of single pairs, in batches.
#include <selvedge/narrowphase/narrow_phase.h>

#include <limits>

#include "arrays.h"
#include "interruptible.h"
#include "method_choice.h"
#include "parts.h"

namespace selvedge::python {
namespace {

constexpr std::size_t kRows = 8;  // of a query: four points at t = 0, then the same at t = 1

/// Copies of some points of each query; views of them.
struct Side {
  std::vector<Vec3> x_t0, x_t1;
  std::vector<Edge> edges;
  std::vector<Triangle> triangles;

  Side(std::span<const Vec3> q, std::size_t first, std::size_t points) {
    const std::size_t n = q.size() / kRows;
    x_t0.reserve(n * points);
    x_t1.reserve(n * points);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = first; k < first + points; ++k) {
        x_t0.push_back(q[kRows * i + k]);
        x_t1.push_back(q[kRows * i + k + kRows / 2]);
      }
    for (std::size_t i = 0; i < n; ++i) {
      const auto v = static_cast<std::int32_t>(points * i);
      if (points == 2) edges.push_back({v, v + 1});
      if (points == 3) triangles.push_back({v, v + 1, v + 2});
    }
  }
  SurfaceView view() const { return {x_t0, x_t1, edges, triangles}; }
};

struct Impacts {
  std::vector<double> toi;
  std::vector<std::array<double, 4>> weights;
  std::vector<Vec3> normal;
};

Impacts find_impacts(const NarrowPhase& method, std::span<const Vec3> q, bool edges) {
  const std::size_t n = q.size() / kRows;
  const Side a(q, 0, edges ? 2 : 1), b(q, edges ? 2 : 1, edges ? 2 : 3);
  CandidatePairs pairs;
  for (std::size_t i = 0; i < n; ++i) {
    const auto k = static_cast<std::int32_t>(i);
    if (edges)
      pairs.edge_edge.push_back({k, k});
    else
      pairs.point_triangle.push_back({k, k});
  }
  std::vector<Contact> found;
  method.find_contacts(a.view(), b.view(), pairs, found);
  const double none = std::numeric_limits<double>::quiet_NaN();
  Impacts out{std::vector<double>(n, kNoCollision),
              std::vector<std::array<double, 4>>(n, {none, none, none, none}),
              std::vector<Vec3>(n, Vec3::Constant(none))};
  for (const Contact& contact : found) {
    const std::size_t i = contact.vertex[0] / (edges ? 2 : 1);
    out.toi[i] = contact.toi;
    out.weights[i] = contact.weight;
    out.normal[i] = contact.normal;
  }
  return out;
}

}  // namespace

void add_ccd(py::module_& m, const SharedMethods& methods) {
  m.def("impacts", [methods](const Doubles& q, bool edges, const py::dict& given) {
    const MethodChoice choice = method_choice(given);
    const auto method =
        make_method(methods->narrow_phases, choice.name, "narrow_phase", choice.options);
    const std::span<const Vec3> points(reinterpret_cast<const Vec3*>(q.data()),
                                       static_cast<std::size_t>(q.size()) / 3);
    Impacts found = stoppable([&] { return find_impacts(*method, points, edges); });
    py::dict out;
    out["toi"] = own<double>(std::move(found.toi));
    out["weights"] = own<double>(std::move(found.weights));
    out["normal"] = own<double>(std::move(found.normal));
    return out;
  });
}

}  // namespace selvedge::python
