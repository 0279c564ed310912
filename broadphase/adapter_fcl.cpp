// SPDX-License-Identifier: MIT
// The dynamic AABB tree of J. Pan, S. Chitta, D. Manocha, "FCL: A general purpose library for
// collision and proximity queries", 2012 [Pan2012].
#include <selvedge/broadphase/adapters.h>
#include <selvedge/broadphase/detail/box_library.h>

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision_object.h>

#include <memory>

namespace selvedge {
namespace {

using Manager = fcl::DynamicAABBTreeCollisionManager<double>;
using Node = Manager::DynamicAABBNode;

/// update() keeps the shape of the tree. Once the total area of the inner boxes has grown by this
/// factor since the last build, a build is cheaper than queries in the degraded tree.
constexpr double kRebuildQualityLoss = 1.3;

/// An object that consists only of its box. The library also requires a shape but never uses it, so
/// all objects share one sphere.
class Box final : public fcl::CollisionObject<double> {
 public:
  Box(const std::shared_ptr<fcl::CollisionGeometry<double>>& shape, std::uint32_t index)
      : CollisionObject(shape), index_(index) {}

  void set(const detail::UnitBox& box) {
    for (int k = 0; k < 3; ++k) {
      aabb.min_[k] = box.lo[k];
      aabb.max_[k] = box.hi[k];
    }
  }
  std::uint32_t index() const { return index_; }

 private:
  std::uint32_t index_;
};

double half_area(const fcl::AABB<double>& box) {
  const fcl::Vector3d size = box.max_ - box.min_;
  return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
}

/// Sum over the inner nodes.
double inner_area(const Node* root) {
  double sum = 0.0;
  std::vector<const Node*> left{root};
  while (!left.empty()) {
    const Node* node = left.back();
    left.pop_back();
    if (node->isLeaf()) continue;
    sum += half_area(node->bv);
    left.push_back(node->children[0]);
    left.push_back(node->children[1]);
  }
  return sum;
}

struct Tree {
  std::vector<std::unique_ptr<Box>> boxes;
  Manager manager;
  double built_area = 0.0;
};

/// Returning true would end the search.
bool add_pair(fcl::CollisionObject<double>* a, fcl::CollisionObject<double>* b, void* out) {
  auto& pairs = *static_cast<detail::UnitPairs*>(out);
  pairs.add(static_cast<const Box*>(a)->index(), static_cast<const Box*>(b)->index());
  return pairs.stopped();
}

class FclLibrary final : public detail::BoxLibrary {
 public:
  void build(int slot, std::span<const detail::UnitBox> boxes, bool) override {
    Tree& tree = trees_[slot];
    tree.manager.clear();
    tree.boxes.resize(std::min(tree.boxes.size(), boxes.size()));
    while (tree.boxes.size() < boxes.size())
      tree.boxes.push_back(
          std::make_unique<Box>(shape_, static_cast<std::uint32_t>(tree.boxes.size())));
    set(tree, boxes);
    std::vector<fcl::CollisionObject<double>*> objects;
    for (const auto& box : tree.boxes) objects.push_back(box.get());
    tree.manager.registerObjects(objects);
    tree.built_area = inner_area(tree.manager.getTree().getRoot());
  }

  bool refit(int slot, std::span<const detail::UnitBox> boxes) override {
    Tree& tree = trees_[slot];
    set(tree, boxes);
    tree.manager.update();
    return inner_area(tree.manager.getTree().getRoot()) <= kRebuildQualityLoss * tree.built_area;
  }

  void find(int slot_a, int slot_b, detail::UnitPairs& out) override {
    trees_[slot_a].manager.collide(&trees_[slot_b].manager, &out, add_pair);
  }
  void find_self(int slot, detail::UnitPairs& out) override {
    trees_[slot].manager.collide(&out, add_pair);
  }

  std::size_t bytes() const override {
    // An object, two nodes for it, and an entry in the manager's table.
    constexpr std::size_t per_box =
        sizeof(Box) + 2 * sizeof(Node) + 4 * sizeof(void*) + sizeof(std::unique_ptr<Box>);
    std::size_t sum = 0;
    for (const Tree& tree : trees_) sum += tree.boxes.size() * per_box;
    return sum;
  }

  BroadPhaseTraits traits() const override {
    return {.source =
                "dynamic AABB tree of FCL over swept triangles; J. Pan, S. Chitta, D. Manocha, "
                "FCL: A general purpose library for collision and proximity queries, 2012"};
  }

 private:
  static void set(Tree& tree, std::span<const detail::UnitBox> boxes) {
    for (std::size_t i = 0; i < boxes.size(); ++i) tree.boxes[i]->set(boxes[i]);
  }

  std::shared_ptr<fcl::CollisionGeometry<double>> shape_ = std::make_shared<fcl::Sphered>(1.0);
  std::array<Tree, detail::kBoxSlots> trees_;
};

}  // namespace

void register_fcl(BroadPhaseRegistry& registry) {
  registry.add("fcl_dynamic_aabb_tree", {}, [](const MethodOptions&) {
    return detail::make_box_broad_phase(std::make_unique<FclLibrary>());
  });
}

}  // namespace selvedge
