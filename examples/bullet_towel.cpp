// SPDX-License-Identifier: MIT
// A towel on rigid bodies of another engine, coupled both ways. Bullet moves three boxes on a floor
// and resolves the contacts among them; selvedge moves the towel. Hands hold its four corners while
// a light box falls into it, let both down onto the other boxes, let go, take two corners again and
// pull up. In each step Bullet's boxes get the force
// and torque that the towel exerted in the step before, with its effective mass, and selvedge takes
// the boxes where Bullet moved them. Without the effective mass the light box would be thrown
// about.
#include <btBulletDynamicsCommon.h>
#include <selvedge/bodies/driven_body.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/step_report.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <vector>

namespace {

using selvedge::Vec3;

constexpr double kGravity = 9.81;  // m/s²
constexpr int kCells = 24, kStepsPerFrame = 8;
constexpr double kRate = 60.0 * kStepsPerFrame;  // steps per s
constexpr double kTowel = 0.2;                   // kg/m²; the towel has 0.6 m x 0.6 m

// m, by which a box is larger for Bullet: two boxes leave the towel its rest gap on both sides.
constexpr double kRoom = 0.0025;

btVector3 to_bullet(const Vec3& v) { return {btScalar(v.x()), btScalar(v.y()), btScalar(v.z())}; }
Vec3 to_eigen(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

/// A box that both engines know.
class SharedBox {
 public:
  SharedBox(btDiscreteDynamicsWorld& world, const Vec3& centre, const Vec3& size, double mass)
      : size_(size), mass_(mass), shape_(to_bullet(0.5 * size + kRoom * Vec3::Ones())) {
    shape_.setMargin(btScalar(0.001));
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, &shape_, own_inertia());
    info.m_startWorldTransform.setOrigin(to_bullet(centre));
    info.m_friction = btScalar(0.5);
    bullet_ = std::make_unique<btRigidBody>(info);
    bullet_->setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(bullet_.get());
  }

  selvedge::BodySpec spec() const {
    selvedge::BodySpec body;
    body.shape = selvedge::BodyShape{selvedge::Box{size_}};
    body.placement.translation = centre();
    body.friction = 0.4;
    return body;
  }
  void drive(selvedge::BuiltScene& built, std::size_t index) {
    driven_ = &selvedge::drive_body(built, index);
    local_.resize(driven_->vertex_count());
    driven_->positions(0.0, local_);
    for (Vec3& x : local_) x -= centre();
  }

  /// What the towel did in the last step acts in the next one: (m + m_e) a' = f + m_e a.
  void take(const selvedge::Wrench& felt, const selvedge::EffectiveMass& towel, bool added) {
    const double m = added ? towel.mass : 0.0;
    const Vec3 arm = towel.centre - centre();
    const Vec3 inertia =
        towel.inertia.diagonal() +
        m * (arm.squaredNorm() * Vec3::Ones() - arm.cwiseProduct(arm));  // about the box, roughly
    bullet_->setMassProps(btScalar(mass_ + m),
                          own_inertia() + (added ? to_bullet(inertia) : btVector3(0, 0, 0)));
    bullet_->updateInertiaTensor();
    bullet_->setGravity({0, 0, 0});
    bullet_->clearForces();
    const Vec3 force = felt.force + m * acceleration_ - mass_ * kGravity * Vec3::UnitZ();
    bullet_->applyCentralForce(to_bullet(force));
    bullet_->applyTorque(to_bullet(felt.torque_about(centre())));
    before_ = velocity();
  }
  /// After Bullet's step: selvedge moves the box to the same place.
  void give(selvedge::Simulation& towel) {
    acceleration_ = kRate * (velocity() - before_);
    std::vector<Vec3> x;
    for (const Vec3& p : local_) x.push_back(to_eigen(bullet_->getWorldTransform() * to_bullet(p)));
    towel.move_body(*driven_, x);
  }

  Vec3 centre() const { return to_eigen(bullet_->getCenterOfMassPosition()); }
  Vec3 velocity() const { return to_eigen(bullet_->getLinearVelocity()); }
  double mass() const { return mass_; }
  btRigidBody* bullet() const { return bullet_.get(); }

 private:
  btVector3 own_inertia() const {
    const Vec3 s = size_.cwiseProduct(size_);
    return to_bullet(mass_ / 12.0 * Vec3(s.y() + s.z(), s.z() + s.x(), s.x() + s.y()));
  }

  Vec3 size_, acceleration_ = Vec3::Zero(), before_ = Vec3::Zero();
  double mass_;
  btBoxShape shape_;
  std::unique_ptr<btRigidBody> bullet_;
  selvedge::DrivenBody* driven_ = nullptr;
  std::vector<Vec3> local_;
};

selvedge::Scene towel_over(const std::vector<std::unique_ptr<SharedBox>>& boxes) {
  selvedge::Scene scene;
  scene.materials["default"] = {.density = kTowel, .bending_stiffness = 5e-5, .friction = 0.4};
  selvedge::ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.shape = selvedge::ClothGrid{
      .grid = {.size_x = 0.6, .size_y = 0.6, .cells_x = kCells, .cells_y = kCells}};
  cloth.placement.translation = {0.0, 0.0, 0.25};
  for (const auto& box : boxes) scene.bodies.push_back(box->spec());
  selvedge::BodySpec& floor = scene.bodies.emplace_back();
  floor.shape = selvedge::BodyShape{selvedge::Plane{}};
  scene.time.steps_per_frame = kStepsPerFrame;
  scene.time.step_error = 0.0;  // no joined steps: both engines make the same
  return scene;
}

/// The hands: down with four corners, open, then up with two of them.
void move_hands(selvedge::Simulation& towel, const std::vector<Vec3>& start) {
  constexpr double kDown = 0.5, kOpen = 0.8, kClose = 1.8, kWay = 0.12, kUp = 0.5, kSpeed = 0.4;
  const double t = towel.nominal_end();
  const int side = kCells + 1;
  const std::vector<std::int32_t> corners{0, kCells, kCells * side, side * side - 1};
  const std::vector<std::int32_t> lifted{0, kCells};
  std::vector<Vec3> x;
  if (t < kOpen) {
    for (const auto c : corners)
      x.push_back(start[c] - std::clamp(kSpeed * (t - kDown), 0.0, kWay) * Vec3::UnitZ());
    towel.hold(corners, x);
  } else if (t < kClose) {
    towel.release_all();
  } else {
    for (const auto c : lifted) {
      const Vec3 now = towel.positions()[c];
      x.push_back(now.z() < kUp ? Vec3(now + kSpeed / kRate * Vec3::UnitZ()) : now);
    }
    towel.hold(lifted, x);
  }
}

struct Outcome {
  bool clean = false;
  double fastest = 0.0;  // m/s, a box until the hands close again
  double carried = 0.0;  // N, mean on boxes and floor while the towel lies
  double error = 0.0;    // of Newton's law for all that the towel felt, relative
  double still = 0.0;    // m/s, the fastest box at the end
};

Outcome run(bool added_mass) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broad_phase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broad_phase, &solver, &configuration);
  btStaticPlaneShape ground({0, 0, 1}, 0);
  btRigidBody floor(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &ground));
  floor.setFriction(btScalar(0.5));
  world.addRigidBody(&floor);

  std::vector<std::unique_ptr<SharedBox>> boxes;
  // Two on the floor, the second of half the towel's mass, and one of a fifth that falls into it.
  boxes.push_back(
      std::make_unique<SharedBox>(world, Vec3(0, 0, 0.053), Vec3(0.16, 0.16, 0.1), 1.0));
  boxes.push_back(
      std::make_unique<SharedBox>(world, Vec3(0.19, 0.02, 0.043), Vec3(0.08, 0.08, 0.08), 0.036));
  boxes.push_back(
      std::make_unique<SharedBox>(world, Vec3(0.01, 0, 0.28), Vec3(0.12, 0.12, 0.03), 0.006));
  const selvedge::Scene scene = towel_over(boxes);
  selvedge::BuiltScene built = selvedge::build_scene(scene);
  for (std::size_t b = 0; b < boxes.size(); ++b) boxes[b]->drive(built, b);
  selvedge::Simulation towel(scene, std::move(built));
  towel.measure_wrenches(true);
  const std::vector<Vec3> start(towel.positions().begin(), towel.positions().end());

  Outcome out;
  int lying = 0;
  std::vector<selvedge::Wrench> felt(boxes.size());
  std::vector<selvedge::EffectiveMass> mass(boxes.size());
  for (int step = 0; step < int(2.8 * kRate); ++step) {
    for (std::size_t b = 0; b < boxes.size(); ++b) boxes[b]->take(felt[b], mass[b], added_mass);
    world.stepSimulation(btScalar(1.0 / kRate), 0);
    for (const auto& box : boxes) box->give(towel);
    move_hands(towel, start);
    // The parts of one step of Bullet: the mean of their forces is what the boxes feel.
    const double end = towel.nominal_end();
    for (auto& f : felt) f = {};
    double spent = 0.0;
    while (towel.time() < end - 1e-9) {
      towel.step();
      const selvedge::StepWrenches& w = towel.wrenches();
      for (std::size_t b = 0; b < boxes.size(); ++b) felt[b] += w.bodies[b] * w.h;
      spent += w.h;
      mass = w.body_mass;
      out.error = std::max(out.error, w.force_error);
      if (towel.time() > 1.5 && towel.time() < 1.8) {
        for (const selvedge::Wrench& f : w.bodies) out.carried -= f.force.z();
        ++lying;
      }
    }
    for (auto& f : felt) f = f * (1.0 / spent);
    double fastest = 0.0;
    for (const auto& box : boxes) fastest = std::max(fastest, box->velocity().norm());
    if (towel.time() < 1.8) out.fastest = std::max(out.fastest, fastest);
    out.still = fastest;
  }
  out.carried /= std::max(lying, 1);
  towel.verify_frame();
  out.clean = towel.result().clean;
  for (const auto& box : boxes) world.removeRigidBody(box->bullet());
  world.removeRigidBody(&floor);
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  const bool also_without = argc > 1 && std::strcmp(argv[1], "--compare") == 0;
  const double weight = 0.6 * 0.6 * kTowel * kGravity;
  bool good = true;
  for (const bool added : {true, false}) {
    if (!added && !also_without) break;
    const Outcome o = run(added);
    std::printf(
        "%s effective mass: %s; fastest box %.2f m/s, at the end %.3f m/s; lying, the towel weighs "
        "%.3f N of %.3f N; momentum balances to %.1e\n",
        added ? "with" : "without", o.clean ? "clean" : "NOT CLEAN", o.fastest, o.still, o.carried,
        weight, o.error);
    if (added)
      good = o.clean && o.fastest < 2.0 && std::abs(o.carried - weight) < 0.05 * weight &&
             o.error < 1e-9;
  }
  return good ? 0 : 1;
}
