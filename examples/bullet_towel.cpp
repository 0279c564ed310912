// SPDX-License-Identifier: MIT
//
// Bodies of another engine. Bullet moves two boxes that stand on each other; a towel is lifted,
// laid on them and let go. In the simulation of the cloth each box is a rigid body of the same mass
// ("mass" of an obstacle), so that the cloth and what it does to the box are solved together: the
// mass is the effective mass, and the coupling is stable however light the box is. In each step
//   1. Bullet gets place and velocity of the box, and steps alone: its contacts and joints;
//   2. what changed the velocity there acts on the box as a force of the program;
//   3. the cloth and the box step together.
#include <selvedge/scene/build.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/step_report.h>

#include <btBulletDynamicsCommon.h>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

using selvedge::Mat3;
using selvedge::Vec3;

namespace {

constexpr double kStep = 1.0 / 240.0;  // s
const Vec3 kGravity(0.0, 0.0, -9.81);

struct BoxSpec {
  Vec3 size, place;
  double mass;
};
const std::array<BoxSpec, 2> kBoxes{{{Vec3(0.2, 0.2, 0.2), Vec3(0.0, 0.0, 0.1), 0.5},
                                     {Vec3(0.12, 0.12, 0.1), Vec3(0.02, 0.01, 0.25), 0.05}}};

selvedge::Scene make_scene() {
  selvedge::Scene scene;
  scene.materials["default"] = {
      .density = 0.3, .stretch_stiffness = 2000.0, .bending_stiffness = 3e-5};
  scene.gravity = kGravity;
  selvedge::ClothSpec& towel = scene.cloths.emplace_back();
  towel.name = "towel";
  towel.shape =
      selvedge::ClothGrid{.grid = {.size_x = 0.5, .size_y = 0.5, .cells_x = 25, .cells_y = 25}};
  towel.placement.translation = Vec3(0.4, 0.0, 0.004);
  for (const BoxSpec& box : kBoxes) {
    selvedge::ClothSpec& body = scene.cloths.emplace_back();
    body.name = "box " + std::to_string(scene.cloths.size() - 1);
    body.shape =
        selvedge::ClothFile{.mesh = tessellate(selvedge::Box{.size = box.size}, 8),
                            .solid = selvedge::SolidSpec{.mass = box.mass, .friction = 0.4}};
    body.placement.translation = box.place;
  }
  selvedge::BodySpec& floor = scene.bodies.emplace_back();
  floor.name = "floor";
  floor.shape = selvedge::BodyShape{selvedge::Box{.size = Vec3(3.0, 3.0, 0.1)}};
  floor.placement.translation = Vec3(0.0, 0.0, -0.05);
  // Bullet answers for the boxes among themselves and on the floor.
  scene.contact.pairs = {{.a = "box 1", .b = "box 2", .collide = false},
                         {.a = "box 1", .b = "floor", .collide = false},
                         {.a = "box 2", .b = "floor", .collide = false}};
  scene.time = {.frames = 1200, .fps = 1.0 / kStep, .steps_per_frame = 1, .step_error = 0.0};
  return scene;
}

/// A rigid body among the pieces: its leaders are four equal point masses.
class Solid {
 public:
  Solid(const selvedge::Simulation& simulation, std::size_t number)
      : simulation_(simulation), solid_(simulation.built().solids[number]) {
    place_ = centre();
    for (int k = 0; k < 4; ++k) start_[k] = x(k) - place_;
  }

  Vec3 centre() const { return 0.25 * (x(0) + x(1) + x(2) + x(3)); }
  Vec3 velocity() const { return 0.25 * (v(0) + v(1) + v(2) + v(3)); }
  Mat3 inertia() const {
    Mat3 sum = Mat3::Zero();
    for (int k = 0; k < 4; ++k) {
      const Vec3 r = x(k) - centre();
      sum += 0.25 * solid_.mass * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
    }
    return sum;
  }
  Vec3 spin() const {
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < 4; ++k) sum += 0.25 * solid_.mass * (x(k) - centre()).cross(v(k));
    return inertia().inverse() * sum;
  }
  Eigen::Quaterniond turn() const {
    Mat3 covariance = Mat3::Zero();
    for (int k = 0; k < 4; ++k) covariance += (x(k) - centre()) * start_[k].transpose();
    const Eigen::JacobiSVD<Mat3> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Mat3 rotation = svd.matrixU() * svd.matrixV().transpose();
    return Eigen::Quaterniond(rotation);
  }
  /// Adds a force, N, and a torque, N·m, to those on the vertices.
  void push(const Vec3& force, const Vec3& torque, std::vector<Vec3>& forces) const {
    const Vec3 turning = inertia().inverse() * torque;
    for (int k = 0; k < 4; ++k)
      forces[solid_.leader + k] += 0.25 * (force + solid_.mass * turning.cross(x(k) - centre()));
  }
  double mass() const { return solid_.mass; }

 private:
  const Vec3& x(int k) const { return simulation_.positions()[solid_.leader + k]; }
  const Vec3& v(int k) const { return simulation_.velocities()[solid_.leader + k]; }

  const selvedge::Simulation& simulation_;
  const selvedge::BuiltSolid solid_;
  Vec3 place_;
  std::array<Vec3, 4> start_;
};

btVector3 to_bullet(const Vec3& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}
Vec3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

/// The boxes and the floor in Bullet.
class World {
 public:
  World() {
    world_.setGravity(to_bullet(kGravity));
    add(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), btScalar(0)), 0.0, Vec3::Zero());
    for (const BoxSpec& box : kBoxes)
      add(std::make_unique<btBoxShape>(to_bullet(0.5 * box.size)), box.mass, box.place);
  }
  ~World() {
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  btRigidBody& box(std::size_t number) { return *bodies_[number + 1]; }
  void step() { world_.stepSimulation(static_cast<btScalar>(kStep), 0); }

 private:
  void add(std::unique_ptr<btCollisionShape> shape, double mass, const Vec3& place) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0.0) shape->calculateLocalInertia(static_cast<btScalar>(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr, shape.get(),
                                                  inertia);
    info.m_startWorldTransform.setOrigin(to_bullet(place));
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    shapes_.push_back(std::move(shape));
    world_.addRigidBody(bodies_.back().get());
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broad_phase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broad_phase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

/// What Bullet does to the boxes in one step, as forces on the vertices.
std::vector<Vec3> forces_of(World& world, const std::vector<Solid>& solids, std::size_t vertices) {
  for (std::size_t b = 0; b < solids.size(); ++b) {
    const Eigen::Quaterniond q = solids[b].turn();
    const btQuaternion turn(static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()),
                            static_cast<btScalar>(q.z()), static_cast<btScalar>(q.w()));
    world.box(b).setWorldTransform(btTransform(turn, to_bullet(solids[b].centre())));
    world.box(b).setLinearVelocity(to_bullet(solids[b].velocity()));
    world.box(b).setAngularVelocity(to_bullet(solids[b].spin()));
    world.box(b).activate(true);
  }
  world.step();
  std::vector<Vec3> forces(vertices, Vec3::Zero());
  for (std::size_t b = 0; b < solids.size(); ++b) {
    const Solid& s = solids[b];
    const Vec3 v = from_bullet(world.box(b).getLinearVelocity());
    const Vec3 w = from_bullet(world.box(b).getAngularVelocity());
    s.push(s.mass() * ((v - s.velocity()) / kStep - kGravity), s.inertia() * (w - s.spin()) / kStep,
           forces);
  }
  return forces;
}

/// Where the corners of the towel are held at a time, s: up, over the boxes, and down; m.
Vec3 lift(double time) {
  const double up = std::min(time, 0.8) / 0.8;
  const double over = std::min(std::max(time - 0.8, 0.0), 0.8) / 0.8;
  return {-0.4 * over, 0.0, 0.5 * up};
}

}  // namespace

int main() {
  selvedge::Simulation simulation(make_scene());
  simulation.measure_wrenches(true);
  World world;
  std::vector<Solid> solids;
  for (std::size_t b = 0; b < kBoxes.size(); ++b) solids.emplace_back(simulation, b);
  const std::vector<std::int32_t> corners{0, 25, 26 * 25, 26 * 26 - 1};
  std::vector<Vec3> start;
  for (const std::int32_t c : corners) start.push_back(simulation.positions()[c]);

  double fastest = 0.0;
  while (simulation.time() < 4.0) {
    simulation.set_forces(forces_of(world, solids, simulation.positions().size()));
    if (simulation.time() < 1.8) {
      std::vector<Vec3> ends;
      for (const Vec3& x : start) ends.push_back(x + lift(simulation.nominal_end()));
      simulation.hold(corners, ends);
    } else {
      simulation.release_all();
    }
    simulation.step();
    for (const Solid& s : solids) fastest = std::max(fastest, s.velocity().norm());
  }
  simulation.verify_frame();
  const selvedge::StepWrenches& felt = simulation.wrenches();
  for (std::size_t b = 0; b < solids.size(); ++b)
    std::printf("box %zu: centre at (%.3f, %.3f, %.3f) m, the towel presses with %.3f N\n", b + 1,
                solids[b].centre().x(), solids[b].centre().y(), solids[b].centre().z(),
                -felt.solids[b].force.z());
  std::printf("fastest box: %.2f m/s; %s\n", fastest,
              simulation.result().clean ? "clean" : "not clean");
  return simulation.result().clean && fastest < 5.0 ? 0 : 1;
}
