// SPDX-License-Identifier: MIT
//
// A garment while it is put on.
#pragma once

#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/dress/dress.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/internal/explain_step.h>
#include <selvedge/simulation/simulation.h>

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// A stitch of a garment: a[i] is sewn to b[i]; vertices of the flat pattern.
struct Stitching {
  std::vector<std::int32_t> a, b;
  double spacing = 0.0;           ///< m, of the pairs along the seam
  double ease = 0.0;              ///< excess of the longer side over the shorter one
  double span = 0.0;              ///< m, mean distance of its pairs at the start
  bool closes_last = false;       ///< a zip or buttons
  std::vector<char> is_joined{};  ///< of each pair, by buttons; empty: all are sewn

  /// Whether the longer side is gathered into the seam.
  bool is_gathered() const { return ease > 0.25; }
};

/// Seams that pull at the same time.
enum class SeamChoice {
  all,
  gathered,  ///< those whose longer side is gathered
  spanning,  ///< those that are far open at the start, as between front and back
  halves     ///< all but those: they join the panels in front, and the panels behind
};

/// An edge of a panel as it is divided in the mesh: vertices of the flat pattern from its start to
/// its end.
struct DividedEdge {
  std::int32_t panel = 0, edge = 0;
  std::vector<std::int32_t> vertices;
};

/// A fold line or an elastic: rows of vertices of the flat pattern.
using DividedFold = GarmentMesh::Fold;
using DividedElastic = GarmentMesh::Elastic;

/// A garment below, in one state.
struct UnderLayer {
  const WornGarment* worn = nullptr;  ///< of DressConfig::under
  std::vector<Vec3> x, v;             ///< m and m/s
};

/// The garment in one state.
struct Garment {
  TriangleMesh surface;              ///< m; triangle i corresponds to triangle i of `flat`
  TriangleMesh flat;                 ///< m, the rest shape, z = 0
  std::vector<Vec3> velocity;        ///< m/s
  std::vector<std::int32_t> corner;  ///< of each vertex of `flat`, that of the surface
  std::vector<std::int32_t> panel_of_triangle;
  std::vector<Stitching> stitches;
  bool is_closing = false;  ///< zips and buttons are pulled together, too
  std::vector<DividedEdge> borders;
  std::vector<DividedFold> folds;
  std::vector<DividedElastic> elastics;
  std::vector<std::string> panel_fabrics;
  std::vector<char> mirrored;         ///< per panel: `flat` mirrors the plane of the pattern
  std::vector<std::int32_t> image{};  ///< GarmentMesh::image, until triangles are split
  std::vector<std::int32_t> held;     ///< vertices of `flat` on edges that a label holds
  std::vector<UnderLayer> under;      ///< as cloth, their vertices follow those of the garment

  /// Whether a choice includes stitch `s`.
  bool is_chosen(std::size_t s, SeamChoice choice) const;
  /// The pairs of stitch `s` that are not one vertex, as vertices of the surface; none of one that
  /// closes last before `is_closing`.
  std::vector<Edge> open_pairs(std::size_t s) const;
  std::size_t open_pairs() const;
  std::size_t pairs(std::size_t s) const;  ///< of stitch `s` that are sewn or joined by buttons
  double opening(std::size_t s) const;     ///< m, the largest distance of a pair
  double largest_opening() const;          ///< m
  std::size_t widest_seam() const;  ///< the stitch with the largest opening; 0 without stitches
  double mean_opening() const;      ///< m, of the open pairs
};

Garment start_garment(const GarmentMesh& mesh, std::span<const WornGarment> under = {},
                      std::span<const std::string> held_labels = {});

/// Splits every triangle into four. No point of the surface moves, so a clean state stays clean; in
/// the flat pattern, the new vertices of curved edges lie on their curves.
void split_garment(const SewingPattern& pattern, Garment& garment);

/// Properties of a scene that change from phase to phase.
struct PhaseSettings {
  Vec3 gravity = Vec3::Zero();  ///< m/s²
  double drag = 0.0;            ///< kg/(m² s)
  double friction = 0.0;        ///< on the body and on cloth
  double pull = 0.0;            ///< N per metre of seam
  double least_bending = 0.0;   ///< N·m, to which each softer fabric is stiffened
  double merge = 0.0;  ///< share of the spacing of a seam at which its pairs merge; 0: they do not
  bool limit_strain = true;
  bool with_elastics = true;  ///< they pull
  /// Garments below rest in place, as bodies do, instead of moving as cloth.
  bool hold_under = false;
  SeamChoice seams = SeamChoice::all;  ///< that pull
  /// 1/s, frames of the scene while the body moves; then cloth to which it leaves no room is
  /// carried on. 0: the body rests.
  double moving_fps = 0.0;
};

/// The end of the time that a garment may take (DressConfig::budget).
class Deadline {
 public:
  explicit Deadline(double budget) : budget_(budget) {}
  Deadline(const Deadline&) = delete;
  Deadline& operator=(const Deadline&) = delete;

  void check() const;  ///< throws DressOverBudget once the time is spent
  /// Checks it in every stage of every attempt of a step.
  const StepTrace& trace() const { return trace_; }

 private:
  double budget_;  // s
  Stopwatch watch_;
  StepTrace trace_{.begin = [this](const TracedAttempt&) { check(); },
                   .stage = [this](const TracedStage&) { check(); }};
};

/// A scene of the garment as it is, and what is built from it.
struct DressScene {
  Scene scene;
  BuiltScene built;
};
DressScene make_dress_scene(const Garment& garment, const TriangleMesh& body,
                            const DressConfig& config, const PhaseSettings& settings);
/// What stays the same while a garment is put on.
struct Dressing {
  const TriangleMesh& body;
  const DressConfig& config;
  const Methods& methods;
  const DressObserver& observer;
  const Deadline& deadline;
  std::optional<double> middle{};  ///< m, x between left and right of a person; none: no person
};

/// Its simulation, which takes what is built over; merge_closed merges the seams.
std::unique_ptr<Simulation> start_simulation(DressScene& scene, const Dressing& dressing);

/// Acceleration of gravity, m/s².
inline constexpr double kGravity = 9.81;
/// Frames between two merges.
inline constexpr int kMergeEvery = 3;
/// Distance at which the pairs of a seam merge, m: `share` of their spacing, but more than contacts
/// keep.
double merge_distance(const Stitching& stitch, const DressConfig& config, double share);

/// Merges the pairs that have met, as far as nothing collides on their paths. Returns the number of
/// merged pairs; 0: the garment is unchanged.
std::size_t merge_closed(const DressScene& scene, const Simulation& simulation,
                         const Methods& methods, Garment& garment, DressResult& result);

/// Moves one vertex of each pair that is within its merge distance (`share`) almost to the other
/// one, if nothing collides on its path, so that the pair can merge where the common motion of both
/// is blocked. Returns the number of moved vertices.
std::size_t move_together(const Simulation& simulation, Garment& garment, const Dressing& dressing,
                          double share);

/// Whether a layer of cloth lies between the two vertices of a pair, which no pull brings together.
bool has_layer_between(const Garment& garment, std::span<const Edge> pairs);

/// Separates merged pairs within `around` steps of open ones, along the seams and round their
/// corners, so that a fold of cloth between their sides can come out. Returns whether it did;
/// otherwise the garment is unchanged.
bool unpick(Garment& garment, const Dressing& dressing, int around);

/// Mean height of points by weight, m; without weights, each counts the same.
double mean_height(std::span<const Vec3> x, std::span<const double> weight);

/// Takes positions and velocities over from a simulation, also of garments below that are cloth.
void take_state(const Simulation& simulation, Garment& garment);

/// The part of values of all vertices of a simulation that belongs to the garment itself.
template <class T>
std::span<const T> of_garment(const Simulation& simulation, std::span<const T> values) {
  return values.first(static_cast<std::size_t>(simulation.built().piece_begin[1]));
}
/// Mean height of the garment, by mass, m.
double garment_height(const Simulation& simulation);
/// Largest strain of a spring of one piece, elastics left out: 0 is the garment, the others lie
/// below it.
double max_stretch(const Simulation& simulation, std::size_t piece);

/// Adds the result of a simulation that ends: clean, states, and seconds under the name of a phase.
void add_run(const Simulation& simulation, const char* phase, DressResult& result);

/// Largest opening with which a seam counts as closed, m.
double closed_opening(const DressConfig& config);

/// One sewing attempt: the order in which the seams pull, and the merging distance. Seams that jam
/// with one order mostly close with another.
struct SewAttempt {
  double merge_share = 0.35;       ///< distance at which pairs merge, in spacings of their seam
  std::vector<SeamChoice> stages;  ///< the seams that pull, one choice after the other
  bool is_stiff = false;           ///< panels as stiff as card
  bool gives_up = false;           ///< ends where cloth lies in a seam, for a stiff attempt follows
};

/// Closes and merges all seams; in the phase `close`, zips and buttons as well. Throws DressFailed
/// that names the stitch.
void sew(Garment& garment, const Dressing& dressing, DressPhase phase, const SewAttempt& attempt,
         DressResult& result);
/// Where a panel belongs on the body.
struct PanelPlace {
  /// Unit, along trunk, leg or arm: the direction of the seams that join the panel to that on the
  /// other side of the body. Zero: it has none.
  Vec3 axis = Vec3::Zero();
  /// m, along the axis, from where the pattern places it: panels may be drawn apart, such as a
  /// skirt below a bodice, and belong where the panel is to which they are sewn.
  Vec3 shift = Vec3::Zero();
  double strength = 1.0;  ///< factor of the pull that draws it there
};
/// Of each panel of a garment before the sewing. The highest panels around the trunk have no shift.
/// A panel whose middle is above `neck`, m, such as a hood, is not one of these.
std::vector<PanelPlace> panel_places(const Garment& start, std::size_t panels, double neck);
/// Pulls a sewn garment along its panels to their places, and one that is its own mirror image
/// straight on a person; `start` is the garment before the sewing.
void draw_into_place(Garment& garment, const Garment& start, const std::vector<PanelPlace>& places,
                     const Dressing& dressing, DressResult& result);
/// Lets the garment come to rest.
void settle(Garment& garment, const Dressing& dressing, DressPhase phase, DressResult& result);
/// Lets the skin of `worn`, which made room, come out to `body` again, as far as the cloth leaves
/// it room; the garment moves with it.
void return_skin(Garment& garment, const Dressing& dressing, const TriangleMesh& body,
                 TriangleMesh& worn, DressResult& result);
/// How far the body on which the garment lies differs from that of the user.
void report_skin(const TriangleMesh& body, DressResult& result);
/// Moves the body through DressConfig::motion; the garment follows. `body` is that in the dressing
/// pose without room. A motion that cannot go on ends with its reason in the result.
void follow_poses(Garment& garment, const Dressing& dressing, const TriangleMesh& body,
                  DressResult& result);

}  // namespace selvedge::detail
