// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/response.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/methods.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/run_result.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge {

/// A tangle that is being undone: the parts of its two sheets that may pass through each other,
/// and the state of the search for a motion that undoes it.
struct Tangle {
  std::array<std::vector<std::int32_t>, 2> side;  ///< joint triangles, sorted
  int way = 0;                                    ///< number of the method in use (untangle.h)
  int best = 0;                                   ///< fewest crossings so far
  int since = 0;       ///< accepted steps since `best` or the method changed
  bool jam = false;    ///< made by a body that left the cloth no room
  bool pinch = false;  ///< a jam of cloth that surfaces of bodies hold between them
  bool is_over() const { return side[0].empty() || side[1].empty(); }
};

/// All tangles of a simulation.
struct Tangles {
  std::vector<Tangle> list;
  /// For each connected part of the joint surface, a vertex of the region that the rest of the
  /// part is brought back to.
  std::vector<std::int32_t> kept;
};

/// A vertex of the cloth that two surfaces of bodies hold between them, because they leave it less
/// than a tenth of its rest gap (detail/pinches.h).
struct Pinch {
  std::int32_t vertex = 0;
  std::array<std::int32_t, 2> triangle{};  ///< of all bodies, on its two sides
  std::array<bool, 2> reversed{};          ///< its normal points away from the vertex
  double share = 0.5;  ///< of the room between them, from the first to the vertex
};

/// Position of a simulation between the ends of two nominal steps.
struct StepControl {
  std::int64_t done = 0;  ///< complete nominal steps; valid only if h > 0
  double h = 0.0;         ///< s, length of the next attempt; 0: at the end of a nominal step
  int halvings = 0;       ///< number of halvings of the planned step that led to `h`
  int span = 1;           ///< nominal steps that the planned step takes at once
};

/// All that a simulation carries from one step to the next. A simulation restored from it continues
/// with the same bits.
struct SimulationState {
  std::int64_t step = 0;      ///< accepted steps so far
  double time = 0.0;          ///< s
  std::vector<Vec3> x, v;     ///< m and m/s, of the cloth vertices
  std::vector<double> water;  ///< kg per cloth vertex; empty if the scene has no water
  StepControl control;
  /// 1/s², of the last step: root mean square by the size of the piece (detail/joined_steps.h);
  /// negative: unknown
  double acceleration = -1.0;
  double still = 0.0;  ///< s, for how long no particle has been faster than time.sleep_speed
  /// Strain that shorter steps could not avoid, by the strain limit (detail/strain_guard.h); 0:
  /// none
  double given_strain = 0.0;
  std::vector<double> memory;          ///< of the integrator and the forces, as they save it
  std::vector<double> contact_memory;  ///< of the response, as it saves it
  std::vector<Pinch> pinches;          ///< by vertex
  Tangles tangles;                     ///< crossings of the start and jams that are not undone yet
  std::vector<SplitEvent> splits;  ///< the splits that led to the present cells of refined pieces
  std::vector<MergeEvent> merges;  ///< the merges that led to the present vertices of seams
};

/// FNV-1a over the bytes of positions, velocities and water, as 16 hex digits.
std::string state_hash(const SimulationState& state);

struct StepTrace;  // explain_step.h
class DrivenBody;  // bodies/driven_body.h

/// Replaces a body of a built scene by one at the same place whose vertices the program sets. Call
/// it before the simulation is made, which then owns the body. Throws std::invalid_argument if
/// there is no such body.
DrivenBody& drive_body(BuiltScene& built, std::size_t body);

/// Why a run stopped before its end.
enum class FailureKind : std::uint8_t {
  not_clean,      ///< no step, however short, is free of collisions
  not_finite,     ///< a particle has no finite position
  stalled,        ///< step after step is accepted only near the smallest length
  out_of_budget,  ///< the granted time or the granted steps are used up
  unstable_step,  ///< the scene refuses to divide a step that is unstable for its integrator
};

/// "not clean", "not finite", "stalled", "out of budget", "unstable step".
const char* failure_name(FailureKind kind);
/// Throws std::invalid_argument for another name.
FailureKind failure_kind(const std::string& name);

/// Whether a step that was accepted after `halvings` of at most `max_halvings` is at most twice as
/// long as the smallest one allowed. Always false if fewer than 4 halvings are allowed, because the
/// smallest step is not yet small then.
bool is_near_smallest(int halvings, int max_halvings);

/// The last rejected attempt of a step.
struct RejectedAttempt {
  double h = 0.0;                   ///< s, its length; 0: no attempt was rejected
  std::string cause;                ///< why it was rejected
  std::vector<ContactPoint> pairs;  ///< that collide on the paths x_t0 -> x_t1, earliest first
  std::int32_t not_finite = -1;  ///< first particle without a finite position; -1: all are finite
  std::vector<Vec3> x_t0, x_t1;  ///< m, cloth particles, then body vertices
};

/// The run cannot continue: it diverged, or a step cannot be made clean. The message names the
/// particle or the pair.
class SimulationFailed : public std::runtime_error {
 public:
  SimulationFailed(FailureKind of_kind, const std::string& cause)
      : std::runtime_error(cause), kind(of_kind) {}
  FailureKind kind;
};

/// A contact of an accepted step.
struct StepContact {
  ContactPoint point;  ///< pair, weights, normal, rest gap; `point.gap`: at the start of the step
  double gap = 0.0;    ///< m, at the end of the step, along the normal
  /// N·s, on the first primitive; the second receives the opposite. Of the response alone: zero for
  /// a response that moves particles without impulses, and without the fail-safe's share.
  Vec3 impulse = Vec3::Zero();
};

/// What stays of a simulation that has ended.
struct FinalState {
  BuiltScene built;
  SimulationState state;
  std::vector<double> mass;  ///< kg per cloth vertex, water included
};

/// The cloth of a scene in time, in memory: nothing is read from or written to files. The mesh
/// stays: every constructor throws std::invalid_argument for a scene with "refine" or "merge",
/// which RefiningSimulation (simulation/refinement.h) serves.
class Simulation {
 public:
  /// Builds the scene. Throws std::invalid_argument for a scene that cannot be built (build_scene),
  /// and if the cloth crosses a body or itself at the start (count, first pair, remedy) and the
  /// scene does not untangle it.
  explicit Simulation(const Scene& scene, const Methods& methods = {});
  /// The same for a scene that was built before.
  Simulation(const Scene& scene, BuiltScene built, const Methods& methods = {});
  /// Continues from a state, as `restore` does; the start of the scene is not checked. A state
  /// without memory starts with that of the integrator and the forces at the start.
  Simulation(const Scene& scene, BuiltScene built, SimulationState state,
             const Methods& methods = {});
  ~Simulation();

  /// Makes one accepted step: a nominal step of 1 / (fps · steps_per_frame) s, or the next part of
  /// one that had to be halved. While the cloth sleeps (time.sleep_speed), the time advances
  /// without a step. Throws SimulationFailed and keeps the last good state.
  void step();
  /// Makes one accepted step towards frame `frame`; returns false, without a step, if its time is
  /// reached. Throws SimulationFailed and keeps the last good state.
  bool step_towards(int frame);
  /// Advances to the time of frame `frame` (frame / fps) and verifies the frame. Calls `accepted`,
  /// which may be empty, with the time of the state after every accepted step. Throws
  /// SimulationFailed and keeps the last good state.
  void advance_to_frame(int frame, const std::function<void(double time)>& accepted = {});

  /// Whether the time of frame `frame` is reached.
  bool reached(int frame) const;
  /// The last frame whose time is reached.
  int frame() const;
  /// Whether the state is that of `frame()`: no step has been made since.
  bool is_at_frame() const;
  /// Searches the present state for crossings and adds them to the result. Makes no search where
  /// the steps from a searched state have proved that there is none (docs/guarantees.md).
  void verify_frame();

  // Inputs that the program sets between two steps. They act until they are set again, and are no
  // part of `state`: set them again after `restore`. The functions throw std::invalid_argument that
  // names the index for an array of another length, an index out of range and a value that is not
  // finite.

  /// The end of the nominal step that comes next or is under way, s.
  double nominal_end() const;
  /// Forces on the cloth vertices in newtons, constant during each step, beside those of the scene.
  /// Empty: none. A force that depends on the state acts explicitly.
  void set_forces(std::span<const Vec3> forces);
  /// Holds these vertices of the cloth: each moves on a straight line to x[k] (m) by
  /// `nominal_end`, and then rests there until it is held elsewhere or released. Takes precedence
  /// over handles of the scene.
  void hold(std::span<const std::int32_t> vertices, std::span<const Vec3> x);
  /// Frees vertices that `hold` holds; no effect on others.
  void release(std::span<const std::int32_t> vertices);
  void release_all();
  /// Moves a body that drive_body made for this simulation: each vertex on a straight line to x[i]
  /// (m) by `nominal_end`; then the body rests.
  void move_body(DrivenBody& body, std::span<const Vec3> x);

  double time() const;                       ///< s
  std::span<const Vec3> positions() const;   ///< m, of the cloth vertices
  std::span<const Vec3> velocities() const;  ///< m/s, of the cloth vertices
  /// The contacts of the last accepted step. Their impulses are those of the response; what a
  /// fail-safe adds is not included. Empty before the first step, after `restore`, and after a step
  /// that failed.
  std::vector<StepContact> contacts() const;
  /// The energies of the state in joules, by the names of selvedge::energies (measures.h).
  std::map<std::string, double> energies() const;

  const SimulationState& state() const;
  /// Continues from `state` (of the same scene); throws std::invalid_argument if its size does not
  /// fit.
  void restore(SimulationState state);
  /// Goes on adding to the sums of the earlier part of a run (ledger, dripped water), so that their
  /// last bits do not depend on where the parts meet. Removes them from `before`, which carry_on
  /// adds. Call it before the first step.
  void continue_sums(RunResult& before);

  /// Lengths of the attempts of the last step, s, the accepted one included.
  const std::vector<double>& attempt_lengths() const;
  /// The last rejected attempt, of any step so far.
  const RejectedAttempt& rejected_attempt() const;
  const VertexNames& names() const;
  /// Reports every attempt to `trace` from now on; `trace` must outlive them. Null: no report.
  void set_trace(const StepTrace* trace);

  /// Guarantees that do not hold at each cloth vertex in the present state, as bits of VertexFlag.
  std::vector<std::uint8_t> flags() const;

  const BuiltScene& built() const;
  const std::vector<double>& mass() const;  ///< kg per cloth vertex, water included
  std::span<const Triangle> cloth_triangles() const;
  std::span<const Triangle> body_triangles() const;  ///< of all bodies, joined in scene order
  const std::vector<Vec3>& body_positions() const;   ///< m, at the state's time
  bool bodies_move() const;                          ///< at any time before the last frame

  /// Clean, steps, halvings, strain, speed, phase times and counters so far. The caller fills
  /// frames, wall_s, peak_bytes and stopped.
  RunResult result() const;
  /// Frees solver and detection, most of the memory, and leaves the rest. The simulation must not
  /// be used afterwards.
  FinalState end() &&;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace selvedge
