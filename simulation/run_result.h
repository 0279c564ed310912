// SPDX-License-Identifier: MIT
//
// The result of a run: flags of vertices, counts, times and measures; and the names of vertices in
// reports.
#pragma once

#include <selvedge/core/base/fields.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/response/response.h>
#include <selvedge/scene/build.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// Guarantees that do not hold at a vertex, as bits of its flag. 0: all of docs/guarantees.md hold.
enum VertexFlag : std::uint8_t {
  kFlagTangled = 1,     ///< in a tangle of the start: may cross the other side of that tangle
  kFlagPinched = 2,     ///< squeezed by bodies from two sides: nearer to both than its rest gap
  kFlagOverStrain = 4,  ///< at a spring that exceeds its strain limit
  kFlagGivenUp = 8,     ///< in a tangle that could not be undone; set together with kFlagTangled
};
inline constexpr int kVertexFlags = 4;
/// "tangled", "pinched", "over_strain", "given_up": bit 0 to 3.
const char* flag_name(int bit);

/// Number of vertices with each flag, by bit.
struct FlagCounts {
  std::array<int, kVertexFlags> end{}, worst{};  ///< in the last frame; the most in one frame
};
/// Adds the flags of another frame to `counts`.
void count_flags(std::span<const std::uint8_t> flags, FlagCounts& counts);

/// The tangles that a run started with; all 0 for a run that started clean.
struct TangleReport {
  int start_pairs = 0;     ///< triangle pairs that crossed at the start
  int pairs = 0;           ///< of them, that cross now
  int elsewhere = 0;       ///< most pairs that crossed at one time outside of the tangles
  double until_s = 0.0;    ///< time from which no tangle is left; -1: one is left
  double max_speed = 0.0;  ///< m/s, fastest particle in any accepted state until then
  bool given_up = false;   ///< a tangle could not be resolved
  int jams = 0;            ///< times that a body left cloth no room and passed through it
};

/// How often a part was proved to do nothing and left out (simulation/plan.h).
struct PlanFigures {
  std::int64_t asked = 0, left_out = 0;
  double saved_s = 0.0;  ///< s, estimated from the mean time of the other times; 0 without any
};

/// Whether the cloth of a state is in equilibrium.
struct RestReport {
  /// The unbalanced force is below 1e-3, and no particle is faster than 1e-3 of a fall through the
  /// root of the area of the largest piece: 3 mm/s for a square metre.
  bool at_rest = false;
  /// Root mean square over the free particles of the force that neither contacts nor the strain
  /// limiter can balance, by the weight (at 9.81 m/s²), counted by mass. Friction inside its cone
  /// counts as balanced. After a step in which the limiter moved particles, at most what would have
  /// changed their velocities without drag and damping. -1: not measured.
  double unbalanced = -1.0;
  double max_speed = 0.0;    ///< m/s, of the fastest particle in the last step
  std::int32_t vertex = -1;  ///< that particle; -1: none moves
  std::string verdict;       ///< "at rest: ..." or "still creeping: 12 mm/s at ..."
};

/// Outcome of a run. result.json has these names (run/result_folder.h). A new field needs its
/// declaration here and its line in Fields<RunResult> below, and nothing else: result.json,
/// checkpoints, resumed runs and the tables of `selvedge compare` visit the fields.
struct RunResult {
  /// No accepted state and no straight path between two of them has an intersection. A run that
  /// started tangled: none from tangle.until_s on, and before it none outside of the tangles. False
  /// after a jam, and while the last step failed.
  /// Where `unchecked` says so, the paths were not searched.
  bool clean = true;
  /// What may have passed through something between two frames without being noticed, because the
  /// scene does not have it searched: clauses joined by ", "; "" if every path was searched.
  std::string unchecked;
  bool clean_elsewhere = true;  ///< no intersection outside of tangles and jams
  int frames = 0;               ///< written, the start frame included
  int steps = 0;                ///< accepted
  int halvings = 0;             ///< of all attempts
  int retried_steps = 0;        ///< accepted steps that needed more than one attempt
  double wall_s = 0.0;
  /// s: forces, solve, strain, broad_phase, proximity, collision, response, repair, output, ...
  std::map<std::string, double> phase_s;
  int worst_self_intersections = 0, worst_body_intersections = 0;
  double max_penetration_m = 0.0;
  double max_stretch = 0.0;      ///< largest (L-L0)/L0 of any edge spring in any accepted state
  double strain_residual = 0.0;  ///< largest excess over the strain limit in any accepted state
  double final_max_speed = 0.0;  ///< m/s
  RestReport rest;               ///< of the last state
  std::size_t peak_bytes = 0;
  TangleReport tangle;
  FlagCounts flags;        ///< vertices without all guarantees
  std::string state_hash;  ///< of all positions and velocities at the end
  std::string stopped;     ///< why the run ended early; "" if it did not
  /// For example solver iterations, contacts, zones; max_gap_violation_m, the largest gap
  /// violation.
  std::map<std::string, double> counters;
  /// Momentum and energy that the stages "response" and "fail_safe" added and removed (meanings:
  /// response/response.h): steps, max_momentum_error, max_angular_error, energy_normal_J,
  /// energy_friction_J, energy_gained_J, energy_kinetic_J, and by _x, _y, _z to_particles and
  /// to_anchors (N·s), turn_particles and turn_anchors (N·m·s).
  std::map<std::string, std::map<std::string, double>> ledger;
  std::map<std::string, PlanFigures> plan;  ///< by part
  /// Of the last state (simulation/run_result.h): strain_max, strain_rms, spring_strain_*,
  /// energy_*_J, and over an upright cylinder drape_coefficient (%), folds.
  std::map<std::string, double> measures;
};

/// How the field of a resumed run is joined with that of its earlier part. A checkpoint keeps every
/// field except `last`.
enum class Merge {
  last,  ///< the value of the later part
  sum,   ///< maps: entry by entry
  max,
  both,       ///< true if true in both parts
  first_set,  ///< the value of the later part unless it is 0
  by_name,    ///< map: max for entries named "max_..." and "worst_...", sum for the others
  each        ///< a struct with Fields: each field by its own rule
};

struct FieldRule {
  Merge merge = Merge::last;
  bool column = false;  ///< a column in the tables of `selvedge compare`
};

constexpr FieldRule column(Merge merge) { return {.merge = merge, .column = true}; }

/// The fields of results, in the order of result.json.
template <>
struct Fields<PlanFigures> {
  template <class Visitor>
  static void visit(Visitor&& visitor) {
    using P = PlanFigures;
    visitor("asked", &P::asked, FieldRule{Merge::sum});
    visitor("left_out", &P::left_out, FieldRule{Merge::sum});
    visitor("saved_s", &P::saved_s, FieldRule{Merge::sum});
  }
};

template <>
struct Fields<TangleReport> {
  template <class Visitor>
  static void visit(Visitor&& visitor) {
    using T = TangleReport;
    visitor("start_pairs", &T::start_pairs, FieldRule{Merge::max});
    visitor("pairs", &T::pairs, FieldRule{Merge::last});
    visitor("elsewhere", &T::elsewhere, FieldRule{Merge::max});
    visitor("until_s", &T::until_s, FieldRule{Merge::first_set});
    visitor("max_speed", &T::max_speed, FieldRule{Merge::max});
    visitor("given_up", &T::given_up, FieldRule{Merge::last});
    visitor("jams", &T::jams, FieldRule{Merge::sum});
  }
};

template <>
struct Fields<RestReport> {
  template <class Visitor>
  static void visit(Visitor&& visitor) {
    using T = RestReport;
    visitor("verdict", &T::verdict, FieldRule{Merge::last});
    visitor("at_rest", &T::at_rest, FieldRule{Merge::last});
    visitor("unbalanced", &T::unbalanced, FieldRule{Merge::last});
    visitor("max_speed", &T::max_speed, FieldRule{Merge::last});
    visitor("vertex", &T::vertex, FieldRule{Merge::last});
  }
};

template <>
struct Fields<RunResult> {
  template <class Visitor>
  static void visit(Visitor&& visitor) {
    using R = RunResult;
    visitor("clean", &R::clean, column(Merge::last));
    visitor("unchecked", &R::unchecked, FieldRule{Merge::last});
    visitor("clean_elsewhere", &R::clean_elsewhere, FieldRule{Merge::both});
    visitor("frames", &R::frames, FieldRule{Merge::last});
    visitor("steps", &R::steps, column(Merge::last));
    visitor("halvings", &R::halvings, column(Merge::sum));
    visitor("retried_steps", &R::retried_steps, FieldRule{Merge::sum});
    visitor("wall_s", &R::wall_s, FieldRule{Merge::sum});
    visitor("phase_s", &R::phase_s, FieldRule{Merge::sum});
    visitor("worst_self_intersections", &R::worst_self_intersections, FieldRule{Merge::max});
    visitor("worst_body_intersections", &R::worst_body_intersections, FieldRule{Merge::max});
    visitor("max_penetration_m", &R::max_penetration_m, FieldRule{Merge::max});
    visitor("max_stretch", &R::max_stretch, column(Merge::max));
    visitor("strain_residual", &R::strain_residual, column(Merge::max));
    visitor("final_max_speed", &R::final_max_speed, column(Merge::last));
    visitor("rest", &R::rest, FieldRule{Merge::last});
    visitor("peak_bytes", &R::peak_bytes, FieldRule{Merge::max});
    visitor("tangle", &R::tangle, FieldRule{Merge::each});
    visitor("flags", &R::flags, FieldRule{Merge::max});  // only the largest count of one frame
    visitor("state_hash", &R::state_hash, column(Merge::last));
    visitor("stopped", &R::stopped, FieldRule{Merge::last});
    visitor("counters", &R::counters, FieldRule{Merge::by_name});
    visitor("ledger", &R::ledger, FieldRule{Merge::by_name});
    visitor("plan", &R::plan, FieldRule{Merge::sum});
    visitor("measures", &R::measures, FieldRule{Merge::last});
  }
};

/// Joins `r` with the result `before` of an earlier part of the same run.
void carry_on(const RunResult& before, RunResult& r);

/// Names the vertices of the joint index space of ContactPoint (cloth particles first, then the
/// vertices of all bodies) by piece or body and by their index there.
class VertexNames {
 public:
  VertexNames() = default;
  VertexNames(const Scene& scene, const BuiltScene& built);

  bool is_cloth(std::int32_t vertex) const { return vertex < owner_begin_[pieces_]; }
  /// Index of the owner: pieces of cloth first, then bodies.
  std::size_t owner_index(std::int32_t vertex) const;
  /// `cloth "skirt"`, `body "table"`, also of a rigid body among the pieces; an owner without a
  /// name goes by its index: `cloth 0`.
  const std::string& owner_name(std::size_t owner) const { return owner_[owner]; }
  const std::string& owner(std::int32_t vertex) const { return owner_[owner_index(vertex)]; }
  /// The first vertex of an owner.
  std::int32_t first(std::size_t owner) const { return owner_begin_[owner]; }
  std::size_t owners() const { return owner_.size(); }
  std::size_t pieces() const { return pieces_; }
  /// The index of a vertex within its owner, as in the files of that mesh.
  std::int32_t local(std::int32_t vertex) const;
  /// `vertex 24 of cloth "skirt"`.
  std::string vertex(std::int32_t vertex) const;
  /// `vertex 24 of cloth "skirt" and triangle (3, 7, 9) of body "table"`.
  std::string pair(const ContactPoint& contact) const;

 private:
  std::string primitive(const std::int32_t* vertices, int count) const;

  std::vector<std::string> owner_;
  std::vector<std::int32_t> owner_begin_;  // first vertex of each owner, plus the total
  std::size_t pieces_ = 0;
};

/// The support of a cloth in Cusick's drape test.
struct DrapeSupport {
  Vec3 centre = Vec3::Zero();  ///< m, seen from above
  double radius = 0.09;        ///< m, > 0
};
/// The first body that is an upright cylinder at rest; nullopt if there is none.
std::optional<DrapeSupport> drape_support(const Scene& scene);

/// Results of Cusick's drape test.
struct DrapeMeasures {
  double shadow = 0.0, specimen = 0.0, support = 0.0;  ///< areas, m²
  double drape_coefficient = 0.0;                      ///< %
  RimProfile rim;
};
/// nullopt if the cloth's rim does not go around the support or is smaller than it.
std::optional<DrapeMeasures> measure_drape(const BuiltScene& built, std::span<const Vec3> x,
                                           const DrapeSupport& support);

/// Energies of a state in joules: "kinetic", "gravity" (0 at the origin), "stretch_and_shear" and,
/// if the cloth has them, "bending", "buckling", "twisting", "seams" and the energies of other
/// laws.
std::map<std::string, double> energies(const Scene& scene, const BuiltScene& built,
                                       const ForceState& state,
                                       const ForceLawRegistry& laws = force_laws());

/// Measures of the last state of a run, by their names in result.json: strains, energies, drape.
std::map<std::string, double> final_measures(const Scene& scene, const BuiltScene& built,
                                             const ForceState& state,
                                             const ForceLawRegistry& laws = force_laws());

}  // namespace selvedge
