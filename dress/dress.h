// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/cloth/fabric.h>
#include <selvedge/garment/panel_mesh.h>
#include <selvedge/scene/methods.h>
#include <selvedge/simulation/simulation.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge {

/// The phases in which a garment is put on, in order.
enum class DressPhase {
  sew,     ///< without weight: seams pull their sides together, and pairs that have met merge
  close,   ///< the same with zips and buttons
  draw,    ///< without weight: each panel is pulled along its axis to its place
  settle,  ///< gravity and friction, until the garment is at rest
  refine,  ///< the same with smaller triangles
  move     ///< the body takes its poses, one after the other, and the garment follows
};
/// "sew", "close", "draw", "settle", "refine", "move".
const char* phase_name(DressPhase phase);

/// Conditions under which a dressed garment counts as at rest. Speeds are those of the straight
/// line between the two ends of the window, so a particle that trembles in place counts as slow.
struct RestCriterion {
  double window = 0.2;       ///< s
  double rms_speed = 0.005;  ///< m/s, root of the mean square speed, by mass
  double max_speed = 0.05;   ///< m/s, of the fastest particle
  /// Mean kinetic energy in the window, over the energy of the same mass at a height of one edge.
  double energy_share = 0.002;
};

/// Poses that the body takes once the garment is at rest on it.
struct BodyMotion {
  std::vector<TriangleMesh> poses;  ///< m, z up, with the triangles of the body; empty: it rests
  double rate = 30.0;               ///< 1/s, poses; between two of them every vertex goes straight
  /// s, from the pose in which the garment is put on to the first pose; unused if they are the same
  double lead = 1.0;
  double drag = 0.1;  ///< kg/(m² s), of the air while the body moves
};

/// A garment that the body wears already, below the one that is put on.
struct WornGarment {
  std::string name;
  TriangleMesh surface;         ///< m, z up; seams are merged
  TriangleMesh flat;            ///< m, the rest shape; triangle i of both correspond
  std::string fabric_name;      ///< as DressConfig::fabric_name
  Material fabric;              ///< its friction is that of this garment with itself
  double body_friction = 0.4;   ///< Coulomb coefficient, with the body
  double outer_friction = 0.3;  ///< Coulomb coefficient, with the garments over it
};

struct DressConfig {
  /// Of the garment. The default is a knit with assumed constants: it stretches by up to 80 %.
  Material fabric{.density = 0.2, .stretch_stiffness = 500.0, .strain_limit = 0.8};
  std::map<std::string, Material> fabrics{};  ///< of the panels that name one (find_fabrics)
  std::string fabric_name;    ///< by which find_fabric finds it; empty: the default. For the result
  double edge_length = 0.01;  ///< m, of the triangles of the finished garment
  /// m, of the mesh on which seams close; its triangles are then split into four until they have
  /// at most `edge_length`. A value up to `edge_length` turns this off; a larger one is faster.
  double sewing_edge_length = 0.02;
  double body_friction = 0.4;   ///< Coulomb coefficient, while the garment settles
  double rest_gap = 0.0015;     ///< m, distance that contacts keep
  double pull = 10.0;           ///< N per metre of seam at first; doubled where it stalls
  double largest_pull = 320.0;  ///< N per metre of seam
  double sew_drag = 2.0;        ///< kg/(m² s), of the air while seams close; more is slower
  double settle_drag = 0.5;     ///< kg/(m² s), of the air while the garment settles
  double sew_time = 4.0;        ///< s, longest simulated time of the sewing
  double settle_time = 12.0;    ///< s, longest simulated time of the settling
  double fps = 60.0;            ///< 1/s, frames
  int steps_per_frame = 1;
  /// m, by which a panel may be moved away from the body to find a free start.
  double largest_move = 0.5;
  /// m, room that the body leaves for cloth where it faces itself across a narrow gap, as between
  /// thighs; its skin goes back by at most half of it. 0: the body stays as it is.
  double body_room = 0.009;
  /// m, by which the mean height of a panel may sink or rise since the start.
  double largest_drop = 0.2;
  /// Stretch from which a garment is too small to be worn, whatever its fabric survives.
  double wearable_stretch = 0.3;
  /// Moves a pattern that stands beside the body, because it is drawn for a body with another
  /// origin, to its place. Otherwise such a pattern is refused. Also moves one that is drawn for a
  /// person of another height up or down.
  bool fit_origin = false;
  double budget = std::numeric_limits<double>::infinity();  ///< s of wall time, for all of it
  PatternLimits limits;
  RestCriterion rest;
  /// Edges of the pattern with one of these labels, such as a waist, are held where the sewing left
  /// them while the rest settles, until it is at rest or for `hold_time`. Then friction has to hold
  /// them.
  std::vector<std::string> held_labels = {"waist", "lower_interface"};
  double hold_time = 0.5;  ///< s; 0: nothing is held
  BodyMotion motion;
  /// Garments below this one, the innermost first. They stay cloth and move with it.
  std::vector<WornGarment> under;
};

/// Adds the fabrics that panels of a pattern name to `config`, as find_fabric finds them from
/// `folder`. Throws std::invalid_argument where it does not find one.
void find_fabrics(const SewingPattern& pattern, const std::filesystem::path& folder,
                  DressConfig& config);

/// A panel that was moved before the start because it crossed the body or another panel.
struct MovedPanel {
  std::int32_t panel = 0;
  Vec3 by = Vec3::Zero();  ///< m
};

/// One stitch of the finished garment.
struct SeamReport {
  std::string name;
  double length_a = 0.0, length_b = 0.0;  ///< m, of its sides in the flat pattern
  double length_end = 0.0;                ///< m, as worn
  double opening_start = 0.0;             ///< m, the largest distance of a pair at the start
  double opening_end = 0.0;               ///< m, the same at the end; 0 if all pairs are merged
  double opening_at_merge = 0.0;          ///< m, largest distance of a pair when it merged
  std::size_t pairs = 0, merged = 0;      ///< that are sewn, or joined by buttons
  PatternStitch::Closure closure = PatternStitch::Closure::seam;
  /// Excess of the longer side, gathered or eased into the seam, over the shorter one.
  double ease() const;
};

/// An elastic as it lies at the end.
struct ElasticReport {
  std::string name;
  double length = 0.0, rest = 0.0, worn = 0.0;  ///< m: of the flat cloth, its own at rest, as worn
};

/// The garment at one pose of the body.
struct PoseReport {
  double time = 0.0;         ///< s, since the body began to move
  double max_stretch = 0.0;  ///< of a spring
  /// m, by which the garment sank relative to the body: difference of the heights of their centres
  /// (mean of the body's vertices, centre of the garment's mass), compared with the dressing pose.
  double drop = 0.0;
  int flagged = 0;  ///< vertices without all guarantees, such as those that the body squeezes
};

/// A garment below the one that was put on, as it lies at the end.
struct UnderReport {
  WornGarment garment;
  double max_stretch = 0.0;  ///< of a spring
  double drop = 0.0;         ///< m, by which its centre sank
};

/// A place at which the skin stays back from the user's body, because cloth is between two parts.
struct SkinPlace {
  Vec3 at = Vec3::Zero();  ///< m
  double by = 0.0;         ///< m, at most
  std::int64_t vertices = 0;
};

/// The most stretched place of a garment.
struct TightPlace {
  std::int32_t panel = -1;
  Vec3 at = Vec3::Zero();   ///< m
  double strain = 0.0;      ///< largest principal one of a triangle
  double area_share = 0.0;  ///< of the garment, stretched beyond DressConfig::wearable_stretch
  /// m, around the garment in the flat pattern and around the body there; 0: not a closed ring
  double cloth = 0.0, body = 0.0;
};

/// How a garment fits at a place where a tailor measures. Tapes lie in the plane, taut: along the
/// convex hull of what it cuts.
struct FitZone {
  std::string name;  ///< neck, bust, waist, hip, left thigh, left upper arm, and the right ones
  Vec3 at = Vec3::Zero(), normal = Vec3::UnitZ();  ///< m, of the plane
  double body = 0.0;                               ///< m, tape around the body
  double cloth = 0.0;      ///< m, around the garment in the flat pattern; 0: no cloth is there
  double worn = 0.0;       ///< m, tape around the garment
  bool is_closed = false;  ///< the cloth is a ring, not open as a jacket is in front
  double strain = 0.0, strain_max = 0.0;      ///< largest principal ones within 3 cm of the tape
  double pressure = 0.0, pressure_max = 0.0;  ///< Pa, of the body, there
  std::vector<std::int32_t> triangles;        ///< of the garment, there
  double ease() const { return is_closed ? cloth - body : 0.0; }  ///< m, of a ring
};

/// An opening of the sewn garment, such as that of a sleeve, and what comes out of it.
struct GarmentOpening {
  std::int32_t panel = -1;         ///< with the largest part of its border
  Vec3 at = Vec3::Zero();          ///< m, its middle
  double length = 0.0;             ///< m, around it in the pattern
  std::vector<std::string> parts;  ///< "head", "left arm", "right leg"...; empty: nothing does
  /// A hole in the cloth, such as a keyhole, out of which nothing has to come.
  bool is_hole = false;
};

/// A panel that lies elsewhere on the body than its name or the pattern says.
struct WornFault {
  enum class Kind {
    hood,      ///< the head is not in the hood
    at_back,   ///< its name says front
    in_front,  ///< its name says back
  };
  Kind kind = Kind::hood;
  std::int32_t panel = -1;
};

/// A garment on a body. The fields describe the pose in which it was put on, except `clean`,
/// `states`, and those of the motion.
struct DressResult {
  TriangleMesh garment;        ///< m, with merged seams, z up
  TriangleMesh flat;           ///< m, the pattern: triangle i of both correspond
  std::vector<Vec3> velocity;  ///< m/s
  std::vector<std::int32_t> panel_of_triangle;
  std::vector<std::string> panel_names;
  /// m, by which a panel lies lower than where it belongs: where the pattern places it, or, if it
  /// is drawn apart from the panel above it, where that is
  std::vector<double> panel_drop;
  std::vector<std::string> notes;   ///< sentences about the pattern, from its mesh
  std::vector<std::uint8_t> flags;  ///< per vertex, bits of VertexFlag
  std::vector<double> pressure;     ///< Pa per vertex, of the body on it, normal, in the last step
  std::vector<MovedPanel> moved;
  TriangleMesh body;                 ///< m, on which it lies
  std::int64_t body_moved = 0;       ///< its vertices that differ from the user's body
  double body_moved_by = 0.0;        ///< m, at most
  std::vector<SkinPlace> skin;       ///< where they are
  std::int64_t body_crossings = 0;   ///< pairs of triangles of garment and `body` that meet
  Vec3 origin_moved = Vec3::Zero();  ///< m, by which DressConfig::fit_origin moved the pattern
  std::vector<SeamReport> seams;
  std::vector<ElasticReport> elastics;
  bool clean = false;    ///< no accepted state and no path between two has an intersection
  bool sewn = false;     ///< every pair of every stitch is one vertex, or nearer than edge/10
  bool at_rest = false;  ///< the rest criterion holds
  double rms_speed = 0.0, max_speed = 0.0;  ///< m/s, at the end
  double energy_share = 0.0;                ///< as in RestCriterion
  double largest_opening = 0.0;             ///< m, of all seams at the end
  double max_stretch = 0.0;                 ///< of a spring, at the end
  double strain_limit = 0.0;                ///< of the fabric, the largest of several
  double wearable_stretch = 0.0;            ///< DressConfig::wearable_stretch
  TightPlace tight;
  double folded = 0.0;               ///< share of the area that lies folded over itself
  std::vector<double> panel_folded;  ///< the same of each panel
  /// m, mean distance of the corners of a panel from the mirror images of their partners, about the
  /// middle of the body, the largest of all panels; -1: the pattern is not its own mirror image
  double asymmetry = -1.0;
  std::int32_t asymmetric_panel = -1;
  /// Openings that a hand passes through, and panels that lie elsewhere. Empty unless the body has
  /// head, arms, legs and feet.
  std::vector<GarmentOpening> openings;
  std::vector<WornFault> misworn;
  bool is_upside_down = false;       ///< as the pattern places it
  std::vector<double> panel_turned;  ///< rad, of each panel, from where the pattern places it
  std::vector<FitZone> fit;          ///< where they were found on the body
  std::string fabric_name;           ///< DressConfig::fabric_name
  double body_friction = 0.0;        ///< DressConfig::body_friction
  double largest_drop = 0.0;         ///< m, DressConfig::largest_drop
  double drop = 0.0;                 ///< m, by which its centre sank while it settled
  std::int64_t states = 0;           ///< accepted and judged
  int attempts = 0;                  ///< to close the seams, the last one included
  double sew_time = 0.0, settle_time = 0.0;  ///< s, simulated
  std::size_t held = 0;                      ///< vertices that a label held at first
  double held_time = 0.0;                    ///< s, for that long
  std::vector<UnderReport> under;            ///< as DressConfig::under
  std::vector<PoseReport> poses;             ///< that the body reached, in order
  std::string motion_fault;                  ///< why the motion ended early; "": it did not
  int jams = 0;  ///< times that the moving body left cloth no room and passed through it
  std::map<std::string, double>
      seconds;  ///< by phase: start, sew, draw, settle, refine, move; and parts of them
  std::string state_hash;

  /// Why it is not worn: not clean against the body on which it lies, not sewn, or not at rest; the
  /// first reason, as a sentence. Empty: it is worn.
  std::string fault() const;
  /// Why a tailor would not sign it although it is worn: too small, lower or higher than the
  /// pattern places it, folded over, one-sided; all reasons. Empty: none.
  std::string reservation() const;
  bool worn() const { return fault().empty(); }
  bool good() const { return worn() && reservation().empty(); }
  /// "good", "worn, but " and the reservation, or the fault.
  std::string verdict() const;
  std::size_t open_pairs() const;  ///< pairs of all seams that are not merged
};

/// A garment that cannot be put on: no free start, a step that cannot be made clean. The message
/// names the panel, the stitch or the pair.
class DressFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A garment that was not finished within DressConfig::budget.
class DressOverBudget : public DressFailed {
 public:
  using DressFailed::DressFailed;
};

/// Called by `dress`; each may be empty.
struct DressObserver {
  /// After every frame, the start and every merge included.
  std::function<void(const Simulation& now, DressPhase phase, double time)> frame;
  /// After every accepted step, the start and every merge included.
  std::function<void(const Simulation& now, DressPhase phase)> accepted;
  /// Before the next sewing attempt: the garment returns to its start, and the states reported so
  /// far no longer lead to the result. Also before the garment returns to the end of the best of
  /// several failed attempts.
  std::function<void()> restart;
  /// At every pose of the moving body, with its index in BodyMotion::poses.
  std::function<void(const Simulation& now, std::size_t pose)> pose;
};

/// Puts a garment on a body. `body`: m, z up, of closed parts; `pattern`: in the same axes
/// (`turned_upright`). Deterministic for any number of threads. Throws std::invalid_argument for
/// numbers out of range, patterns that check_sewing_pattern refuses, and garments below that cross
/// the body or each other, and DressFailed if the garment cannot be put on.
DressResult dress(const SewingPattern& pattern, const TriangleMesh& body, const DressConfig& config,
                  const Methods& methods = {}, const DressObserver& observer = {});

/// A pattern whose panels stand in axes with `up`, turned into axes with z up, as load_mesh does.
SewingPattern turned_upright(SewingPattern pattern, UpAxis up);

/// A body with room for cloth (DressConfig::body_room).
struct BodyRoom {
  TriangleMesh body;
  std::int64_t vertices = 0;  ///< that were moved back
  double largest = 0.0;       ///< m, the farthest
};
BodyRoom make_room(const TriangleMesh& body, double room);
/// The same for the frames of a moving body. A vertex goes back early and returns late, so that the
/// skin does not jump between two frames.
void make_room(std::vector<TriangleMesh>& frames, double room);

/// The garment with panels moved outward until nothing crosses: no panel the body, another panel or
/// a garment that is worn below. Throws DressFailed that names the panel for which no free place
/// was found. Calls `round`, which may be empty and may throw, before each of the moves.
std::vector<MovedPanel> find_free_start(GarmentMesh& garment, const TriangleMesh& body,
                                        double largest_move,
                                        std::span<const WornGarment> under = {},
                                        const std::function<void()>& round = {});

}  // namespace selvedge
