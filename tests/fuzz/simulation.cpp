// SPDX-License-Identifier: MIT
// A small random scene: cloth above and on bodies, with methods of every family. After each step
// whose methods promise to miss nothing, no triangle crosses another and none did on the way, by
// the judge; and all numbers are finite.
#include <selvedge/judge/judge.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/simulation.h>

#include <cstdlib>

#include "fuzz.h"

namespace {

using namespace selvedge;

template <class Registry>
std::string pick(fuzz::Bytes& in, const Registry& registry) {
  const std::vector<std::string> names = registry.names();
  return names[static_cast<std::size_t>(in.below(static_cast<int>(names.size())))];
}

Eigen::Quaterniond rotation(fuzz::Bytes& in) {
  const Eigen::Vector4d q(in.between(-1, 1), in.between(-1, 1), in.between(-1, 1),
                          in.between(0.1, 1));
  return Eigen::Quaterniond(q.normalized());
}

Vec3 vector(fuzz::Bytes& in, double size) {
  const double x = in.between(-size, size), y = in.between(-size, size);
  return {x, y, in.between(-size, size)};
}

Scene random_scene(fuzz::Bytes& in, const Methods& methods) {
  Scene scene;
  scene.time.steps_per_frame = 1 + in.below(3);
  scene.time.max_halvings = 4;
  scene.materials["default"] = {.density = in.between(0.02, 1.0),
                                .stretch_stiffness = in.between(1.0, 2000.0),
                                .bending_stiffness = in.between(0.0, 1e-3)};
  for (int i = 0, n = 1 + in.below(2); i < n; ++i) {
    ClothSpec& cloth = scene.cloths.emplace_back();
    cloth.name = "cloth" + std::to_string(i);
    const std::int32_t cells = 1 + in.below(4);
    cloth.shape = ClothGrid{.grid = {.cells_x = cells, .cells_y = cells}};
    cloth.placement = {Vec3(0.0, 0.0, 1.0 + 1.5 * i), rotation(in)};
    cloth.scale = in.between(0.2, 1.0);
    cloth.velocity = vector(in, 20.0);
  }
  for (int i = 0, n = in.below(3); i < n; ++i) {
    BodySpec& body = scene.bodies.emplace_back();
    body.name = "body" + std::to_string(i);
    const double size = in.between(0.05, 0.4);
    switch (in.below(3)) {
      case 0:
        body.shape = BodyShape{Sphere{.radius = size}, 6};
        break;
      case 1:
        body.shape = BodyShape{Box{.size = Vec3::Constant(size)}, 6};
        break;
      default:
        body.shape = BodyShape{Cone{.radius = size, .height = in.between(0.05, 1.0)}, 6};
    }
    body.placement = {vector(in, 0.3) - Vec3(0.0, 0.0, 0.5), rotation(in)};
    body.friction = in.between(0.0, 2.0);
    if (in.below(2) == 1) body.motion = {{}, {0.05, vector(in, 0.8), rotation(in)}};
  }
  if (in.below(2) == 1) scene.contact.broad_phase = pick(in, methods.broad_phases);
  if (in.below(2) == 1) scene.contact.response = pick(in, methods.responses);
  if (in.below(2) == 1) scene.contact.fail_safe = pick(in, methods.fail_safes);
  if (in.below(2) == 1) scene.solver.integrator = pick(in, methods.integrators);
  if (in.below(2) == 1) scene.solver.limiter = pick(in, methods.strain_limiters);
  scene.contact.rest_gap = in.between(1e-4, 1e-2);
  return scene;
}

/// The state is clean, and so was the way to it from `before`.
void check(const Simulation& simulation, const TriangleMesh& before, const TriangleMesh& bodies) {
  const auto x = simulation.positions();
  for (const Vec3& p : x)
    if (!p.allFinite()) std::abort();
  const std::vector<Vec3>& bodies_now = simulation.body_positions();
  const PathVerdict way = judge_path(before, x, bodies, bodies_now);
  if (way.self_collisions + way.body_collisions != 0) std::abort();
  const TriangleMesh mesh{{x.begin(), x.end()}, before.triangles};
  const TriangleMesh body{bodies_now, bodies.triangles};
  const Verdict verdict = judge(mesh, body, {});
  if (verdict.self_intersections + verdict.body_intersections != 0) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t n) {
  static const Methods methods;
  fuzz::Bytes in(bytes, n);
  const Scene scene = random_scene(in, methods);
  const bool exact = methods.broad_phases.at(scene.contact.broad_phase).traits().guarantee ==
                     Guarantee::conservative;
  try {
    Simulation simulation(scene, methods);
    const auto triangles = simulation.cloth_triangles(), of_bodies = simulation.body_triangles();
    for (int step = 0; step < 6; ++step) {
      const auto x = simulation.positions();
      const TriangleMesh before{{x.begin(), x.end()}, {triangles.begin(), triangles.end()}};
      const TriangleMesh bodies{simulation.body_positions(), {of_bodies.begin(), of_bodies.end()}};
      simulation.step();
      if (exact) check(simulation, before, bodies);
    }
  } catch (const std::invalid_argument&) {
  } catch (const SimulationFailed&) {
  }
  return 0;
}
