// SPDX-License-Identifier: MIT
// Bullet's soft bodies find the pairs of nodes and faces that may touch by two dynamic trees of
// boxes (btDbvt). In this example Bullet simulates a cloth that hangs by one corner. In each step
// such trees and our broad phase find the self-collision candidates of the cloth. Both use the same
// boxes: the swept boxes of nodes and faces, inflated by the margin. Both must find the same pairs.
// Our broad phase also finds edge-edge pairs, which Bullet does not search for, in the printed
// time.
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/types.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

using Pairs = std::vector<selvedge::PointTrianglePair>;

namespace {

constexpr int kSide = 90, kSteps = 40;
constexpr double kMargin = 0.004;  // m, for a cloth of 2 m

/// A btDbvt over moving boxes. Leaves are kept and updated, as in Bullet's soft bodies.
struct DynamicTree {
  btDbvt tree;
  std::vector<btDbvtNode*> leaves;

  void set(std::size_t i, btDbvtVolume box) {
    if (i == leaves.size())
      leaves.push_back(tree.insert(box, reinterpret_cast<void*>(i)));
    else
      tree.update(leaves[i], box);
  }
};

struct Collect : btDbvt::ICollide {
  const std::vector<selvedge::Triangle>& faces;
  Pairs pairs;

  explicit Collect(const std::vector<selvedge::Triangle>& f) : faces(f) {}
  void Process(const btDbvtNode* node, const btDbvtNode* face) override {
    const auto v = static_cast<std::int32_t>(reinterpret_cast<std::size_t>(node->data));
    const auto f = static_cast<std::int32_t>(reinterpret_cast<std::size_t>(face->data));
    if (std::find(faces[f].begin(), faces[f].end(), v) == faces[f].end()) pairs.push_back({v, f});
  }
};

selvedge::Vec3 vec3(const btVector3& x) { return {x.x(), x.y(), x.z()}; }

/// Box of the given nodes at both ends of the step.
template <std::size_t n>
btDbvtVolume swept(const btSoftBody& cloth, const std::array<std::int32_t, n>& nodes) {
  btVector3 lo = cloth.m_nodes[nodes[0]].m_x, hi = lo;
  for (const std::int32_t v : nodes)
    for (const btVector3& x : {cloth.m_nodes[v].m_q, cloth.m_nodes[v].m_x})
      lo.setMin(x), hi.setMax(x);
  // Single precision: inflate by slightly more than the margin to allow for rounding.
  const btVector3 margin = btVector3(1, 1, 1) * btScalar(kMargin * (1 + 1e-3));
  return btDbvtVolume::FromMM(lo - margin, hi + margin);
}

/// The search of Bullet, on the nodes and faces of one cloth.
Pairs find_by_bullet(const btSoftBody& cloth, const std::vector<selvedge::Triangle>& faces,
                     DynamicTree& nodes, DynamicTree& face_tree) {
  for (std::int32_t v = 0; v < cloth.m_nodes.size(); ++v)
    nodes.set(v, swept(cloth, std::array<std::int32_t, 1>{v}));
  for (std::size_t f = 0; f < faces.size(); ++f) face_tree.set(f, swept(cloth, faces[f]));
  // Bullet rebalances its trees a little in every step.
  nodes.tree.optimizeIncremental(1);
  face_tree.tree.optimizeIncremental(1);
  Collect collect(faces);
  nodes.tree.collideTT(nodes.tree.m_root, face_tree.tree.m_root, collect);
  return std::move(collect.pairs);
}

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

}  // namespace

int main() {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase bodies;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world(&dispatcher, &bodies, &solver, &configuration);
  world.setGravity({0, -10, 0});
  world.getWorldInfo().m_gravity = world.getGravity();
  btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), {-1, 0, -1}, {1, 0, -1},
                                                     {-1, 0, 1}, {1, 0, 1}, kSide, kSide, 1, true);
  cloth->setTotalMass(1.0);
  world.addSoftBody(cloth);

  std::vector<selvedge::Triangle> faces;
  const btSoftBody::Node* first = &cloth->m_nodes[0];
  for (int f = 0; f < cloth->m_faces.size(); ++f) {
    auto& n = cloth->m_faces[f].m_n;
    faces.push_back({int(n[0] - first), int(n[1] - first), int(n[2] - first)});
  }
  const std::vector<selvedge::Edge> edges = selvedge::unique_edges(faces);
  const std::size_t count = cloth->m_nodes.size();
  std::vector<selvedge::Vec3> before(count), after(count);
  const selvedge::SurfaceView surface{before, after, edges, faces, kMargin, 0};

  DynamicTree nodes, face_tree;
  const auto broad_phase = selvedge::make_bvh_aabb();
  const selvedge::ThreadLimit one_thread(1);  // Bullet uses one thread as well
  selvedge::CandidatePairs ours;
  double bullet_ms = 0.0, our_ms = 0.0;
  std::size_t found = 0, missing = 0, more = 0;
  for (int step = 0; step < kSteps; ++step) {
    world.stepSimulation(btScalar(1.0 / 60), 1, btScalar(1.0 / 60));
    auto start = std::chrono::steady_clock::now();
    Pairs theirs = find_by_bullet(*cloth, faces, nodes, face_tree);
    if (step > 0) bullet_ms += milliseconds_since(start);  // The first step inserts all leaves.

    start = std::chrono::steady_clock::now();
    for (std::size_t v = 0; v < count; ++v) {
      before[v] = vec3(cloth->m_nodes[int(v)].m_q);
      after[v] = vec3(cloth->m_nodes[int(v)].m_x);
    }
    broad_phase->find_self_pairs(surface, ours);
    if (step > 0) our_ms += milliseconds_since(start);

    std::sort(theirs.begin(), theirs.end());
    Pairs lost;
    std::set_difference(ours.point_triangle.begin(), ours.point_triangle.end(), theirs.begin(),
                        theirs.end(), std::back_inserter(lost));
    found += ours.point_triangle.size();
    missing += lost.size();
    more += theirs.size() + lost.size() - ours.point_triangle.size();
  }
  std::printf("%zu faces, %zu node-face pairs a step\n", faces.size(), found / kSteps);
  std::printf(
      "Bullet's trees: %.2f ms a step, node-face pairs only; %zu of ours not found, %zu more "
      "within single precision\n",
      bullet_ms / (kSteps - 1), missing, more);
  std::printf("selvedge: %.2f ms a step, with %zu pairs of edges\n", our_ms / (kSteps - 1),
              ours.edge_edge.size());
  world.removeSoftBody(cloth);
  delete cloth;
  return missing == 0 && found > 0 && more < found / 10 ? 0 : 1;
}
