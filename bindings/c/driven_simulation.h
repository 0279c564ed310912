// SPDX-License-Identifier: MIT
//
// The simulation that other languages see: with driven bodies by number, and states that include
// where these are.
#pragma once

#include <selvedge/bodies/driven_body.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/methods.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/batch.h>
#include <selvedge/simulation/internal/mesh_change.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <atomic>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace selvedge::bindings {

/// A state, with the places of driven bodies.
using SavedState = MemberState;

/// The first vertex of each body among those of all bodies, plus the total.
inline std::vector<std::size_t> body_begin(const Simulation& simulation) {
  std::vector<std::size_t> begin{0};
  for (const auto& body : simulation.built().bodies)
    begin.push_back(begin.back() + body->vertex_count());
  return begin;
}

class DrivenSimulation {
 public:
  DrivenSimulation(std::shared_ptr<const Scene> scene, std::shared_ptr<const Methods> methods,
                   std::span<const std::size_t> driven)
      : scene_(std::move(scene)), methods_(std::move(methods)) {
    BuiltScene built = build_scene(*scene_, *methods_);
    warnings_ = built.warnings;
    if (const std::string cause = mesh_change(*scene_); !driven.empty() && !cause.empty())
      throw std::invalid_argument(cause + " changes the mesh; driven bodies need one that stays");
    for (const std::size_t body : driven) driven_[body] = &drive_body(built, body);
    simulation_.emplace(*scene_, std::move(built), *methods_);
  }

  Simulation& now() { return *simulation_; }
  const Simulation& now() const { return *simulation_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

  std::vector<std::size_t> body_begin() const { return bindings::body_begin(now()); }

  SavedState save() const {
    SavedState saved{now().state(), {}};
    const auto& bodies = now().built().bodies;
    for (const auto& [body, driven] : driven_) {
      std::vector<Vec3>& x = saved.bodies[body];
      x.resize(bodies[body]->vertex_count());
      bodies[body]->positions(now().time(), x);
    }
    return saved;
  }

  /// Makes another simulation, so that arrays that view the present one stay valid while its
  /// `owner` lives.
  void restore(const SavedState& saved) {
    if (saved.bodies.size() != driven_.size())
      throw std::invalid_argument("the saved state is not of this scene");
    BuiltScene built = build_scene(*scene_, *methods_);
    std::map<std::size_t, DrivenBody*> driven;
    for (const auto& [body, x] : saved.bodies) {
      driven[body] = &drive_body(built, body);
      driven[body]->place(x, saved.state.time);
    }
    simulation_.emplace(*scene_, std::move(built), saved.state, *methods_);
    driven_ = std::move(driven);
  }

  void move_body(std::size_t body, std::span<const Vec3> x) {
    const auto driven = driven_.find(body);
    if (driven == driven_.end())
      throw std::invalid_argument("body " + std::to_string(body) +
                                  " is not driven; name it in `driven` when you make the "
                                  "simulation");
    now().move_body(*driven->second, x);
  }

  /// Set while a thread uses the simulation.
  std::atomic<bool>& busy() { return busy_; }

 private:
  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const Methods> methods_;
  std::vector<std::string> warnings_;
  std::map<std::size_t, DrivenBody*> driven_;
  std::optional<Simulation> simulation_;  // never empty; replaced by `restore`
  std::atomic<bool> busy_{false};
};

}  // namespace selvedge::bindings
