// SPDX-License-Identifier: MIT
#include <selvedge/run/internal/replay.h>
#include <selvedge/simulation/step_report.h>

#include <limits>
#include <stdexcept>

namespace selvedge {
namespace {

// The step may be beyond the last frame of its scene, which may have been shortened.
constexpr int kAnyFrame = std::numeric_limits<int>::max();

void check_bodies(const Simulation& simulation, const FailureBundle& bundle) {
  SimulationState bodies;
  bodies.x = simulation.body_positions();
  if (state_hash(bodies) != bundle.bodies_hash)
    throw std::invalid_argument(
        (bundle.folder / "scene.json").string() +
        ": its bodies are not where they were when the run stopped; the file, or a mesh that it "
        "names, has changed");
}

bool is_stalled(const Simulation& simulation, const Scene& scene, const FailureBundle& bundle) {
  const int attempts = static_cast<int>(simulation.last_step().lengths.size());
  return bundle.kind == FailureKind::stalled &&
         is_near_smallest(bundle.state.control.halvings + attempts - 1, scene.time.max_halvings);
}

}  // namespace

StepReplay replay_step(Simulation& simulation, const Scene& scene, const FailureBundle& bundle) {
  simulation.restore(bundle.state);
  check_bodies(simulation, bundle);
  StepReplay replay;
  try {
    simulation.step_towards(kAnyFrame);
    if (is_stalled(simulation, scene, bundle)) {
      replay.failure = FailureKind::stalled;
      replay.cause = bundle.cause;
    }
  } catch (const SimulationFailed& failed) {
    replay.failure = failed.kind;
    replay.cause = failed.what();
  }
  replay.attempts = simulation.last_step().lengths;
  replay.state_hash = state_hash(simulation.state());
  replay.as_recorded = replay.failure == bundle.kind && replay.cause == bundle.cause &&
                       replay.attempts == bundle.attempts;
  return replay;
}

}  // namespace selvedge
