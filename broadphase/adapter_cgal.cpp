// SPDX-License-Identifier: MIT
// A. Zomorodian, H. Edelsbrunner, "Fast software for box intersections", 2002 [Zomorodian2002], as
// implemented in CGAL.
#include <selvedge/broadphase/adapters.h>
#include <selvedge/broadphase/detail/box_library.h>
#include <selvedge/broadphase/detail/cgal_tree.h>
#include <selvedge/core/base/parallel.h>

#include <CGAL/box_intersection_d.h>

#include <cstddef>

namespace selvedge {
namespace {

/// Below this number of boxes the recursion sweeps instead. Measured on sheets of 20,000 to 320,000
/// triangles: CGAL's default of 10 takes two to three times as long.
constexpr std::ptrdiff_t kCutoff = 1000;

/// The interface that CGAL needs of a box. The id orders equal boxes, so it must be unique over
/// both lists of a call.
struct Box {
  using NT = float;
  using ID = std::uint32_t;

  detail::UnitBox box;
  std::uint32_t unit, id_;

  static int dimension() { return 3; }
  ID id() const { return id_; }
  NT min_coord(int k) const { return box.lo[k]; }
  NT max_coord(int k) const { return box.hi[k]; }
};

struct AddPair {
  detail::UnitPairs* out;
  void operator()(const Box& a, const Box& b) const { out->add(a.unit, b.unit); }
};

class CgalLibrary final : public detail::BoxLibrary {
 public:
  void build(int slot, std::span<const detail::UnitBox> boxes, bool) override {
    boxes_[slot] = boxes;
  }
  bool refit(int slot, std::span<const detail::UnitBox> boxes) override {
    boxes_[slot] = boxes;
    return true;
  }

  void find(int slot_a, int slot_b, detail::UnitPairs& out) override {
    const auto offset = static_cast<std::uint32_t>(boxes_[slot_a].size());
    copy(boxes_[slot_a], 0, a_);
    copy(boxes_[slot_b], offset, b_);
    const auto find = [&](auto tag) {
      CGAL::box_intersection_d<decltype(tag)>(a_.begin(), a_.end(), b_.begin(), b_.end(),
                                              AddPair{&out}, kCutoff);
    };
    with_threads(find);
  }

  void find_self(int slot, detail::UnitPairs& out) override {
    copy(boxes_[slot], 0, a_);
    const auto find = [&](auto tag) {
      CGAL::box_self_intersection_d<decltype(tag)>(a_.begin(), a_.end(), AddPair{&out}, kCutoff);
    };
    with_threads(find);
  }

  std::size_t bytes() const override { return (a_.capacity() + b_.capacity()) * sizeof(Box); }

  BroadPhaseTraits traits() const override {
    return {.source =
                "box_intersection_d of CGAL over swept triangles; A. Zomorodian, H. Edelsbrunner, "
                "Fast software for box intersections, 2002"};
  }

 private:
  /// The library reorders the boxes that it receives, so it gets a copy.
  static void copy(std::span<const detail::UnitBox> boxes, std::uint32_t first_id,
                   std::vector<Box>& out) {
    out.resize(boxes.size());
    for (std::uint32_t i = 0; i < boxes.size(); ++i) out[i] = {boxes[i], i, first_id + i};
  }

  template <class Find>
  static void with_threads(const Find& find) {
#ifdef CGAL_LINKED_WITH_TBB
    if (thread_count() > 1) return find(CGAL::Parallel_tag());
#endif
    find(CGAL::Sequential_tag());
  }

  std::array<std::span<const detail::UnitBox>, detail::kBoxSlots> boxes_;
  std::vector<Box> a_, b_;
};

}  // namespace

void register_cgal(BroadPhaseRegistry& registry) {
  registry.add("cgal_box_intersection", {}, [](const MethodOptions&) {
    return detail::make_box_broad_phase(std::make_unique<CgalLibrary>());
  });
  registry.add("cgal_aabb_tree", {}, [](const MethodOptions&) {
    return detail::make_box_broad_phase(detail::make_cgal_tree());
  });
}

}  // namespace selvedge
