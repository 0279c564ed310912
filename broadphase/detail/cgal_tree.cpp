// SPDX-License-Identifier: MIT
// P. Alliez, S. Tayeb, C. Wormser, "3D fast intersection and distance computation", in CGAL user
// and reference manual [Alliez2022].
//
// The tree holds boxes, because a swept triangle is not a triangle. It is queried with one box at a
// time, so of two surfaces one has a tree and the other provides the queries. It has no refit.
#include <selvedge/broadphase/detail/cgal_tree.h>
#include <selvedge/core/base/parallel.h>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Simple_cartesian.h>

namespace selvedge::detail {
namespace {

constexpr std::size_t kQueryGrain = 1024;  // boxes per task of queries

using Kernel = CGAL::Simple_cartesian<double>;  // floats are exact in it

CGAL::Bbox_3 bbox_of(const UnitBox& box) {
  return {box.lo[0], box.lo[1], box.lo[2], box.hi[0], box.hi[1], box.hi[2]};
}

/// A box as stored in the tree.
struct BoxPrimitive {
  using Id = std::uint32_t;
  using Point = Kernel::Point_3;
  using Datum = Point;

  Id index = 0;
  Point middle;  ///< doubled; boxes are split by it
  CGAL::Bbox_3 box;

  BoxPrimitive(Id i, const UnitBox& b)
      : index(i),
        middle(double{b.lo[0]} + b.hi[0], double{b.lo[1]} + b.hi[1], double{b.lo[2]} + b.hi[2]),
        box(bbox_of(b)) {}
  Id id() const { return index; }
  Datum datum() const { return middle; }
  Point reference_point() const { return middle; }
};

/// The library's traits, except that the bounding box of a primitive is not that of its datum.
struct Traits : CGAL::AABB_traits<Kernel, BoxPrimitive> {
  using Base = CGAL::AABB_traits<Kernel, BoxPrimitive>;
  using Bounding_box = CGAL::Bbox_3;

  struct BoxOfRange {
    template <class Iterator>
    Bounding_box operator()(Iterator first, Iterator beyond) const {
      Bounding_box all = first->box;
      while (++first != beyond) all += first->box;
      return all;
    }
  };
  BoxOfRange compute_bbox_object() const { return {}; }
};

using Tree = CGAL::AABB_tree<Traits>;

/// Visitor of the tree's search for one box.
struct Visit {
  UnitPairs& out;
  std::uint32_t index;
  bool self, first_asks;

  bool go_further() const { return true; }
  void intersection(const CGAL::Bbox_3& query, const BoxPrimitive& p) {
    if (self && p.index <= index) return;
    if (!CGAL::do_overlap(query, p.box)) return;
    if (first_asks)
      out.add(index, p.index);
    else
      out.add(p.index, index);
  }
  bool do_intersect(const CGAL::Bbox_3& query, const CGAL::AABB_node<Traits>& node) const {
    return CGAL::do_overlap(query, node.bbox());
  }
};

class CgalTree final : public BoxLibrary {
 public:
  /// The tree itself is built at the first query, as is the library's default: which of two
  /// surfaces needs one is not known before.
  void build(int slot, std::span<const UnitBox> boxes, bool stays) override {
    slots_[slot].boxes = boxes;
    slots_[slot].stays = stays;
    slots_[slot].is_made = false;
  }
  bool refit(int slot, std::span<const UnitBox> boxes) override {
    build(slot, boxes, false);
    return true;
  }

  void find(int slot_a, int slot_b, UnitPairs& out) override {
    const bool tree_of_b = prefers(slots_[slot_b], slots_[slot_a]);
    Slot& tree = slots_[tree_of_b ? slot_b : slot_a];
    make(tree);
    ask(tree, slots_[tree_of_b ? slot_a : slot_b].boxes, {out, 0, false, tree_of_b});
  }
  void find_self(int slot, UnitPairs& out) override {
    make(slots_[slot]);
    ask(slots_[slot], slots_[slot].boxes, {out, 0, true, true});
  }

  std::size_t bytes() const override {
    std::size_t sum = 0;
    for (const Slot& slot : slots_)
      sum += slot.tree.size() * (sizeof(BoxPrimitive) + sizeof(CGAL::AABB_node<Traits>));
    return sum;
  }

  BroadPhaseTraits traits() const override {
    return {.source =
                "AABB tree of CGAL over swept triangles; P. Alliez, S. Tayeb, C. Wormser, 3D fast "
                "intersection and distance computation, 2022"};
  }

 private:
  struct Slot {
    std::span<const UnitBox> boxes;
    Tree tree;
    bool stays = false;
    bool is_made = false;
  };

  /// Prefers a tree that exists or will be kept, then the tree with fewer boxes.
  static bool prefers(const Slot& a, const Slot& b) {
    if (a.is_made != b.is_made) return a.is_made;
    if (a.stays != b.stays) return a.stays;
    return a.boxes.size() <= b.boxes.size();
  }

  static void make(Slot& slot) {
    if (slot.is_made) return;
    slot.tree.clear();
    for (std::uint32_t i = 0; i < slot.boxes.size(); ++i)
      slot.tree.insert(BoxPrimitive(i, slot.boxes[i]));
    slot.tree.build();
    slot.is_made = true;
  }

  static void ask(const Slot& slot, std::span<const UnitBox> boxes, const Visit& visit) {
    parallel_for(boxes.size(), kQueryGrain, [&](std::size_t begin, std::size_t end) {
      Visit mine = visit;
      for (std::size_t i = begin; i < end && !mine.out.stopped(); ++i) {
        mine.index = static_cast<std::uint32_t>(i);
        slot.tree.traversal(bbox_of(boxes[i]), mine);
      }
    });
  }

  std::array<Slot, kBoxSlots> slots_;
};

}  // namespace

std::unique_ptr<BoxLibrary> make_cgal_tree() { return std::make_unique<CgalTree>(); }

}  // namespace selvedge::detail
