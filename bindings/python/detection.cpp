// SPDX-License-Identifier: MIT
//
// Detection on plain arrays.
#include <pybind11/stl.h>
#include <selvedge/detection/find.h>

#include <atomic>
#include <type_traits>

#include "arrays.h"
#include "interruptible.h"
#include "method_choice.h"
#include "parts.h"

namespace selvedge::python {
namespace {

/// A surface during a step or in one state (x_t1 is x_t0). Keeps its arrays alive.
struct Moving {
  Doubles x_t0, x_t1;
  Whole triangles;

  MovingSurface surface() const {
    return {positions(x_t0, "x_t0"), positions(x_t1, "x_t1"),
            python::triangles(triangles, "triangles")};
  }
  SurfaceState state() const {
    return {positions(x_t0, "x"), python::triangles(triangles, "triangles")};
  }
};

template <class Pair>
void add_primitives(py::dict& out, const std::vector<Pair>& pairs) {
  out["kind"] =
      column<std::uint8_t>(pairs, [](const Pair& p) { return static_cast<std::uint8_t>(p.kind); });
  out["primitive_a"] = column<std::int32_t>(pairs, [](const Pair& p) { return p.primitive_a; });
  out["primitive_b"] = column<std::int32_t>(pairs, [](const Pair& p) { return p.primitive_b; });
  out["vertices"] = column<std::int32_t>(pairs, [](const Pair& p) { return p.vertex; });
  out["weights"] = column<double>(pairs, [](const Pair& p) { return p.weight; });
  out["normal"] = column<double>(pairs, [](const Pair& p) { return p.normal; });
}

py::dict collision_table(const std::vector<Collision>& found) {
  py::dict out;
  out["toi"] = column<double>(found, [](const Collision& c) { return c.toi; });
  add_primitives(out, found);
  return out;
}

/// A broad phase and a narrow phase that one thread uses at a time.
class Detector {
 public:
  Detector(SharedMethods methods, MethodChoice broad, MethodChoice narrow, double min_separation)
      : methods_(std::move(methods)),
        broad_choice_(std::move(broad)),
        narrow_choice_(std::move(narrow)),
        min_separation_(min_separation) {
    if (min_separation != 0.0) narrow_choice_.options.set("min_separation", min_separation);
    make();
  }

  py::dict collisions(const Moving& a, const std::optional<Moving>& b) {
    return collision_table(search([&] {
      const DetectionMethods methods{*broad_, *narrow_, min_separation_};
      return b ? find_collisions(methods, a.surface(), b->surface())
               : find_collisions(methods, a.surface());
    }));
  }

  py::dict candidates(const Moving& a, const std::optional<Moving>& b, double distance) {
    std::vector<Edge> edges_a, edges_b;
    CandidatePairs found = search([&] {
      edges_a = unique_edges(a.surface().triangles);
      edges_b = b ? unique_edges(b->surface().triangles) : edges_a;
      return b ? find_candidates(*broad_, a.surface(), b->surface(), distance)
               : find_candidates(*broad_, a.surface(), distance);
    });
    py::dict out;
    out["point_triangle"] = own<std::int32_t>(std::move(found.point_triangle));
    out["triangle_point"] = own<std::int32_t>(std::move(found.triangle_point));
    out["edge_edge"] = own<std::int32_t>(std::move(found.edge_edge));
    out["edges_a"] = own<std::int32_t>(std::move(edges_a));
    out["edges_b"] = own<std::int32_t>(std::move(edges_b));
    return out;
  }

 private:
  void make() {
    broad_ = make_method(methods_->broad_phases, broad_choice_.name, "broad_phase",
                         broad_choice_.options);
    narrow_ = make_method(methods_->narrow_phases, narrow_choice_.name, "narrow_phase",
                          narrow_choice_.options);
  }

  /// Calls work(), which uses the methods. A call that is interrupted leaves them incomplete.
  template <class Work>
  std::invoke_result_t<const Work&> search(const Work& work) {
    const OneThread mine(busy_, "detector");
    try {
      return stoppable(work);
    } catch (const py::error_already_set&) {
      make();
      throw;
    }
  }

  SharedMethods methods_;
  MethodChoice broad_choice_, narrow_choice_;
  double min_separation_;  // m
  std::unique_ptr<BroadPhase> broad_;
  std::unique_ptr<NarrowPhase> narrow_;
  std::atomic<bool> busy_{false};
};

/// Pairs that cross and pairs that touch.
py::tuple meetings(const Moving& a, const std::optional<Moving>& b) {
  TriangleMeetings found = stoppable([&] {
    return b ? find_meetings(a.state(), b->state())
             : find_meetings(a.state().x, a.state().triangles);
  });
  return py::make_tuple(own<std::int32_t>(std::move(found.crossings)),
                        own<std::int32_t>(std::move(found.touches)));
}

py::dict contacts(const Moving& a, const std::optional<Moving>& b, double distance) {
  const std::vector<Proximity> found = stoppable([&] {
    return b ? find_contacts(a.state(), b->state(), distance)
             : find_contacts(a.state().x, a.state().triangles, distance);
  });
  py::dict out;
  out["gap"] = column<double>(found, [](const Proximity& p) { return p.gap; });
  add_primitives(out, found);
  return out;
}

}  // namespace

void add_detection(py::module_& m, const SharedMethods& methods) {
  py::class_<Moving>(m, "Surface")
      .def(py::init([](const Doubles& x_t0, const Doubles& x_t1, const Whole& triangles) {
        return Moving{x_t0, x_t1, triangles};
      }));
  py::class_<Detector>(m, "Detector")
      .def(py::init([methods](const py::dict& broad, const py::dict& narrow, double separation) {
        return std::make_unique<Detector>(methods, method_choice(broad), method_choice(narrow),
                                          separation);
      }))
      .def("collisions", &Detector::collisions)
      .def("candidates", &Detector::candidates);
  m.def("find_meetings", &meetings);
  m.def("find_contacts", &contacts);
}

}  // namespace selvedge::python
