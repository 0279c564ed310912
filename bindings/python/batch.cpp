// SPDX-License-Identifier: MIT
//
// Many simulations stepped together.
#include <selvedge/simulation/batch.h>

#include "parts.h"
#include "simulation_class.h"

namespace selvedge::python {
namespace {

/// A batch that one thread uses at a time.
struct BatchSession {
  static constexpr const char* kName = "batch";

  BatchSession(const std::vector<std::shared_ptr<Scene>>& scenes,
               const std::vector<std::size_t>& driven, const SharedMethods& methods)
      : batch({scenes.begin(), scenes.end()}, driven, methods) {}

  /// Calls use(batch) without the lock of the interpreter.
  template <class Use>
  auto unlocked(Use use) {
    const OneThread mine(busy, kName);
    const py::gil_scoped_release release;
    return use(batch);
  }

  Batch batch;
  std::atomic<bool> busy{false};
};

/// A member of a batch. What is not in the arrays of the batch is copied, because other members
/// use its memory.
class MemberSession {
 public:
  static constexpr const char* kName = BatchSession::kName;
  MemberSession(std::shared_ptr<BatchSession> of, std::size_t number)
      : of_(std::move(of)), number_(number) {
    of_->batch.scene(number);  // refuses a number that no member has
  }

  Simulation& now() { return of_->batch.member(number_); }
  std::atomic<bool>& busy() { return of_->busy; }
  MemberState save() { return of_->batch.save(number_); }
  void restore(const MemberState& saved) { of_->batch.restore(number_, saved); }
  void reset() { of_->batch.reset(number_); }
  void move_body(std::size_t body, std::span<const Vec3> x) {
    of_->batch.move_body(number_, body, x);
  }
  std::vector<std::size_t> body_begin() { return bindings::body_begin(now()); }

  std::span<const Vec3> positions() { return own_part(of_->batch.positions()); }
  std::span<const Vec3> velocities() { return own_part(of_->batch.velocities()); }
  std::shared_ptr<const void> owner() { return of_->batch.owner(); }
  py::array mass() { return own<double>(std::vector<double>(now().mass())); }
  py::array body_positions() { return own<double>(std::vector<Vec3>(now().body_positions())); }

 private:
  std::span<const Vec3> own_part(std::span<const Vec3> all) {
    const std::span<const std::size_t> begin = of_->batch.vertex_begin();
    return all.subspan(begin[number_], begin[number_ + 1] - begin[number_]);
  }

  std::shared_ptr<BatchSession> of_;
  std::size_t number_;
};

/// (number, kind, cause) of each member that failed.
py::list table_of(const std::vector<MemberFailure>& failures) {
  py::list table;
  for (const MemberFailure& f : failures)
    table.append(py::make_tuple(f.member, failure_name(f.kind), f.cause));
  return table;
}

}  // namespace

void add_batch(py::module_& m, const SharedMethods& methods) {
  using B = BatchSession;
  py::class_<B, std::shared_ptr<B>>(m, "Batch")
      .def(py::init([methods](const std::vector<std::shared_ptr<Scene>>& scenes,
                              const std::vector<std::size_t>& driven) {
        const py::gil_scoped_release release;
        return std::make_shared<B>(scenes, driven, methods);
      }))
      .def("member", [](const std::shared_ptr<B>& b, std::size_t k) { return MemberSession(b, k); })
      .def("step",
           [](B& b, const std::vector<std::size_t>& members) {
             return table_of(b.unlocked([&](Batch& batch) { return batch.step(members); }));
           })
      .def("advance",
           [](B& b, int frames, const std::vector<std::size_t>& members) {
             return table_of(
                 b.unlocked([&](Batch& batch) { return batch.advance(frames, members); }));
           })
      .def_property_readonly(
          "positions",
          [](const B& b) { return view<double>(b.batch.positions(), b.batch.owner()); })
      .def_property_readonly(
          "velocities",
          [](const B& b) { return view<double>(b.batch.velocities(), b.batch.owner()); })
      .def_property_readonly("vertex_begin", [](const B& b) {
        const std::span<const std::size_t> begin = b.batch.vertex_begin();
        return std::vector<std::size_t>(begin.begin(), begin.end());
      });
  py::class_<MemberSession> member(m, "Member");
  define_steps(member);
  define_reading(member);
  member.def("reset", [](MemberSession& s) { unlocked(s, [&](Simulation&) { s.reset(); }); });
}

}  // namespace selvedge::python
