// SPDX-License-Identifier: MIT
//
// Many scenes in time, stepped together on all cores.
#pragma once

#include <selvedge/simulation/failure.h>
#include <selvedge/simulation/simulation_state.h>

#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

class Simulation;  // simulation.h
struct Methods;    // scene/methods.h
struct RunResult;
struct Scene;  // scene/scene.h

/// A member of a batch at one time, for `Batch::restore`.
struct MemberState {
  SimulationState state;
  std::map<std::size_t, std::vector<Vec3>> bodies;  ///< m, of the driven bodies, by number
};

/// A member that could not make its step. It keeps its last good state.
struct MemberFailure {
  std::size_t member = 0;
  FailureKind kind = FailureKind::not_clean;
  std::string cause;
};

/// Many simulations in memory, stepped together: a thread takes one member at a time. Each member
/// has the same bits as a Simulation of its scene alone, in any order and with any number of
/// threads.
///
/// Members of one Scene object share the memory of a step: each thread has it once, and a member
/// keeps its state alone. Members of different Scene objects, and of a scene that refines, merges,
/// untangles or carries tangled cloth on, have their own.
class Batch {
 public:
  /// `driven`: bodies by number, in every scene that has members, which `move_body` moves. Throws
  /// as Simulation does, with the number of the member before the sentence.
  explicit Batch(std::vector<std::shared_ptr<const Scene>> scenes,
                 std::span<const std::size_t> driven = {});
  Batch(std::vector<std::shared_ptr<const Scene>> scenes, std::span<const std::size_t> driven,
        std::shared_ptr<const Methods> methods);
  ~Batch();
  Batch(const Batch&) = delete;
  Batch& operator=(const Batch&) = delete;

  std::size_t size() const;
  const Scene& scene(std::size_t member) const;

  /// Each of these members, by number and without repetition, makes one accepted step
  /// (Simulation::step). Returns those that failed, by number; the others have made their step.
  std::vector<MemberFailure> step(std::span<const std::size_t> members);
  std::vector<MemberFailure> step();  ///< of all members
  /// The same for `frames` frames of each from its present one, each verified.
  std::vector<MemberFailure> advance(int frames, std::span<const std::size_t> members);
  std::vector<MemberFailure> advance(int frames);

  /// m and m/s, of all cloth vertices, member after member: (size(), n, 3) numbers where all
  /// members have n vertices. They lie in this memory until a mesh changes; the steps write it.
  std::span<const Vec3> positions() const;
  std::span<const Vec3> velocities() const;
  /// The first vertex of each member in these arrays, plus the total.
  std::span<const std::size_t> vertex_begin() const;
  /// Keeps the memory of these arrays longer.
  std::shared_ptr<const void> owner() const;

  /// The member as a simulation: to read it, and to set forces, held vertices and its state. Valid
  /// until the next call for a member of the same scene, and until the next step. The contacts of
  /// its last step are gone if its scene has other members.
  Simulation& member(std::size_t member);
  /// Simulation::move_body, of a driven body.
  void move_body(std::size_t member, std::size_t body, std::span<const Vec3> x);
  /// Times of phases, the plan, and counters of methods are those of all members of its scene.
  RunResult result(std::size_t member);

  MemberState save(std::size_t member);
  /// Continues from a state of the member's scene, saved by any batch or simulation. Forces and
  /// held vertices have to be set again. Throws std::invalid_argument for a state of another scene.
  void restore(std::size_t member, const MemberState& state);
  /// Back to the start of the scene.
  void reset(std::size_t member);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace selvedge
