// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/body.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/cloth/wetting.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/scene/methods.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace selvedge {

/// Placement of a geometry: x = rotation * x_file + translation.
struct Placement {
  Vec3 translation = Vec3::Zero();  ///< m
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
};

/// A curve along which a grid lies at the start, folded or knotted; its rest shape stays flat.
struct StripPath {
  std::vector<Vec3> points;   ///< m, the curve runs smoothly through them; empty: flat
  Vec3 side = Vec3::UnitY();  ///< where y of the grid points, as far as it is across the curve
};

/// Condition under which cells of a rectangular grid are split into four ("refine"). Checked before
/// every frame.
struct RefineSpec {
  enum class When {
    never,
    settled,  ///< all cells, once no particle is faster than `speed` or the energy is below
              ///< `energy`
    curved    ///< cells that form an angle above `angle_deg` with a neighbour
  };
  When when = When::never;
  std::int32_t levels =
      1;                ///< largest number of splits of a cell, in [1, AdaptiveGrid::kMaxLevels]
  double speed = 0.05;  ///< m/s
  double energy = 0.0;  ///< J, kinetic
  double after = 0.2;   ///< s, of settled: shortest time after the start or the last split
  double angle_deg = 20.0;
  double join_deg = 0.0;  ///< of curved: the quarters of a cell are joined below it; 0: never

  double angle() const { return radians(angle_deg); }
  double join() const { return radians(join_deg); }

 private:
  static double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }
};

/// Cells of one piece that were split, or whose quarters were joined, at one time.
struct SplitEvent {
  std::int32_t piece = 0;  ///< of the scene
  double time = 0.0;       ///< s
  std::vector<GridCell> cells;
  bool join = false;
};

/// Springs from every particle to its position in the rest shape ("virtual_springs") [survey 2.8].
struct VirtualSpec {
  double stiffness = 0.0;  ///< N/m³, force per area and distance, >= 0; 0: none
  bool follow = false;     ///< the rest shape moves with the cloth; otherwise it stays at the start
};

struct ClothGrid {
  std::string pattern = "rectangular";  ///< a name of Methods::patterns
  GridConfig grid;
  StripPath path{};
  MethodOptions pattern_options{};  ///< options that are left out have their defaults
  /// Poisson's ratio, in (-1, 1), of a plate of the material's stretch and bending stiffness to
  /// which the springs of the triangular pattern are fitted; none: they are not.
  std::optional<double> plate{};
  RefineSpec refine{};
};

/// A rigid body that moves as cloth and others push it ("mass" of an obstacle).
struct SolidSpec {
  double mass = 0.0;          ///< kg, > 0, spread evenly within its surface, which is closed
  Vec3 slide = Vec3::Zero();  ///< direction of the line along which alone it moves; 0: it is free
  /// m, two points of the axis about which alone it turns; equal: none. It turns right-handed about
  /// the way from the first to the second.
  std::array<Vec3, 2> hinge{Vec3::Zero(), Vec3::Zero()};
  /// The least and the largest way along `slide`, m, or angle about `hinge`, degrees, from the
  /// start; equal: none.
  std::array<double, 2> limits{0.0, 0.0};
  double damping = 0.0;       ///< N·s/m along `slide`, N·m·s about `hinge`, >= 0
  Vec3 force = Vec3::Zero();  ///< N, constant, at its centre of mass
  double friction = 0.3;      ///< Coulomb coefficient of all that touches it, >= 0

  bool slides() const { return !slide.isZero(0.0); }
  bool turns() const { return hinge[0] != hinge[1]; }
  bool has_limits() const { return limits[0] != limits[1]; }
};

struct ClothFile {
  std::filesystem::path file{};  ///< any triangle mesh: initial shape, and rest shape unless given
  std::filesystem::path rest_file{};  ///< empty: the file itself
  /// Metres per unit of the texture coordinates, which then define the flat rest shape; 0: they are
  /// ignored.
  double texture_unit = 0.0;
  TriangleMesh mesh{};  ///< where `file` is empty: the mesh itself
  /// Where `file` is empty: its rest shape, with the same triangles; none: that of `mesh`.
  TriangleMesh rest_mesh{};
  std::optional<double> plate{};              ///< as in ClothGrid, for a flat mesh
  std::optional<SupportConstants> support{};  ///< a closed surface supported from inside
  std::optional<SolidSpec> solid{};           ///< a rigid body and no cloth
  RefineSpec refine{};
};

/// One piece of cloth ("geometry" in the scene file).
struct ClothSpec {
  std::string name;
  std::variant<ClothGrid, ClothFile> shape;
  double scale = 1.0;  ///< > 0, of the shape and its rest shape, before it is placed
  Placement placement;
  Vec3 velocity = Vec3::Zero();  ///< m/s at the start
  std::string material = "default";
  VirtualSpec virtual_springs{};
};

/// The rigid body of a piece; null: it is cloth.
const SolidSpec* solid_of(const ClothSpec& cloth);

/// Held particles and their prescribed motion ("handles").
struct HandleSpec {
  std::string name;
  std::string geometry;  ///< name of the piece
  std::vector<std::int32_t>
      vertices;                     ///< of the piece; corners and boxes are resolved by the parser
  std::vector<Keyframe> motion;     ///< relative to the start; empty: held still
  std::optional<double> release{};  ///< s, time of release; none: never
  /// Number of its first vertices whose mean is the centre of rotation; 0: all vertices.
  std::size_t pivots = 0;
};

/// Mass added to particles: a button, a heavy hem ("weights").
struct WeightSpec {
  std::string name;
  std::string geometry;                ///< name of the piece
  std::vector<std::int32_t> vertices;  ///< of the piece
  double mass = 0.0;                   ///< kg, to each of them, >= 0
};

/// Two rows of particles that are sewn together pair by pair, in their order ("seams").
struct SeamSpec {
  std::string name;
  std::array<std::string, 2> geometry;                ///< names of the pieces
  std::array<std::vector<std::int32_t>, 2> vertices;  ///< of the pieces, equally many
  SewingConfig sewing;
  /// m, distance at which the two vertices of a pair merge into one, >= 0; 0: never. Checked before
  /// each frame.
  double merge = 0.0;
};

/// Pairs of vertices of a scene that were merged at one time, as the scene was built.
struct MergeEvent {
  double time = 0.0;  ///< s
  std::vector<Edge> pairs;
};

/// Particles onto which water drops ("water.sources").
struct WaterSource {
  std::string geometry;                ///< name of the piece
  std::vector<std::int32_t> vertices;  ///< of the piece
  double rate = 0.0;                   ///< kg/s, onto all of them together, >= 0
  double begin = 0.0, end = 1e6;       ///< s
  Vec3 velocity = Vec3::Zero();        ///< m/s, of the drops
};
/// Water in the cloth ("water").
struct WaterSpec {
  WettingConfig wetting;
  std::vector<WaterSource> sources;
};

struct BodyFile {
  std::filesystem::path file;
  LoadConfig load;
  TriangleMesh mesh;  ///< where `file` is empty: the mesh itself
  /// m, in the frame of the mesh: vertices at most this far apart become one (bodies/weld.h); 0:
  /// none but those that `load` joins.
  double weld_distance = 0.0;
};
struct BodySequence {
  std::vector<std::filesystem::path> files;
  LoadConfig load;
  double fps = 60.0, start = 0.0;
};
struct BodyShape {
  AnalyticShape shape;
  int resolution = 64;
};

/// A body that cloth collides with ("obstacles").
struct BodySpec {
  std::string name;
  std::variant<BodyShape, BodyFile, BodySequence> shape;
  Placement placement;
  std::vector<Keyframe> motion;  ///< empty: static (or the sequence's own motion)
  double friction = 0.3;         ///< cloth on this body, >= 0
};

struct TimeSpec {
  int frames = 120;  ///< frames after the start frame, at most, >= 1
  /// The run ends with the first frame at which the cloth is at rest and nothing that the scene
  /// prescribes is still to come.
  bool until_rest = false;
  double fps = 60.0;        ///< frames per second, > 0
  int steps_per_frame = 2;  ///< >= 1
  /// Two steps of a frame are taken as one while the error of the longer step, by the size of a
  /// piece (the root of its area), is estimated to stay below step_error / steps_per_frame²; >= 0;
  /// 0: never. Only integrators of first order that are stable at any step do this.
  double step_error = 1.6e-3;
  /// m/s, >= 0: cloth sleeps, and its steps are left out, once no particle was faster for half a
  /// second and while nothing acts on it; 0: never.
  double sleep_speed = 0.0;
  int max_halvings = 8;  ///< largest number of halvings of a step that collides
  /// Halve implicit steps that gain energy without a source. Otherwise the gain is only counted.
  bool energy_guard = true;
};

/// Values of one pair of surfaces ("contact.pairs"). A field without a value changes nothing. If
/// several entries match a pair, the last one counts, for each field separately.
struct PairSpec {
  std::string a, b;  ///< names of pieces, materials or bodies, in any order; not two bodies
  std::optional<double> friction{};  ///< Coulomb coefficient, >= 0
  std::optional<double> rest_gap{};  ///< m, distance that contacts keep at rest, > 0
  /// False: the scene states that they cannot collide, and detection leaves them out [Ji2006].
  /// Frames are checked for crossings all the same.
  std::optional<bool> collide{};
};

struct ContactSpec {
  double rest_gap = 0.002;      ///< m, distance that contacts keep between two surfaces, > 0
  std::vector<PairSpec> pairs;  ///< pairs with values of their own
  bool self = true;             ///< cloth against itself and other pieces
  bool untangle_start = false;  ///< cloth that crosses at the start is untangled, not refused
  /// Cloth that cannot be untangled, or that bodies leave no room, continues with flagged vertices;
  /// otherwise the run stops.
  bool carry_tangled = false;
  // Methods and their options; options that are left out have their defaults.
  std::string broad_phase = "bvh_aabb";
  MethodOptions broad_phase_options{};
  std::string narrow_phase = "ccd_exact";
  MethodOptions narrow_phase_options{};
  std::string response = "contact_force";
  MethodOptions response_options{};
  std::string fail_safe = "layered";
  MethodOptions fail_safe_options{};
};

struct SolverSpec {
  std::string integrator = "implicit_blend";
  MethodOptions integrator_options{};
  bool strain_limiter = true;        ///< false: `limiter` is none
  std::string limiter = "position";  ///< how springs are kept within their strain limits
  MethodOptions limiter_options{};
  double tolerance = 1e-3;            ///< relative residual of the linear solve
  bool refuse_unstable_step = false;  ///< an unstable step ends the run; otherwise it is divided
};

struct CameraSpec {
  Vec3 eye = Vec3(1.6, -2.2, 1.4), target = Vec3(0.0, 0.0, 0.3);  ///< m
  double field_of_view = 35.0;                                    ///< degrees, vertical
};

struct OutputSpec {
  /// Formats of the frames beside PLY, by name (run/frame_writer.h).
  std::vector<std::string> formats;
  std::map<std::string, MethodOptions> format_options;  ///< of `formats`, by name
  CameraSpec camera;

  /// The names in `formats`, sorted, each once.
  std::vector<std::string> all_formats() const;
};

/// Random velocities at the start. Another seed gives chaotic motion, such as a drape that folds,
/// another course.
struct PerturbationSpec {
  double speed = 0.0;      ///< m/s; the largest in each coordinate
  std::uint64_t seed = 1;  ///< selects the velocities
};

struct PlanSpec {
  bool proofs = true;  ///< omit work that provably changes nothing; false: for comparisons
};

/// A motion that is known in closed form ("closed_form"); `compare` computes errors from it.
enum class ClosedForm {
  none,
  free_fall,  ///< every particle moves as in vacuum: x = x0 + v0 t + g t²/2
  incline     ///< slides down the only body, which is flat, at constant acceleration, or sticks
};

/// A scene file, checked and complete: every name resolved, every number in range.
struct Scene {
  std::string name;
  std::filesystem::path file;
  std::string json;  ///< as read: with overrides and defaults, without comments, paths absolute
  std::vector<ClothSpec> cloths;
  std::map<std::string, Material> materials;
  ForceLawOptions force_laws;  ///< options of force laws by name; every law acts, named or not
  std::vector<HandleSpec> handles;
  std::vector<WeightSpec> weights;
  std::vector<SeamSpec> seams;
  std::optional<WaterSpec> water;
  std::vector<BodySpec> bodies;
  Vec3 gravity = Vec3(0.0, 0.0, -9.81);  ///< m/s²
  AirConfig air;
  PerturbationSpec perturbation;
  TimeSpec time;
  ContactSpec contact;
  SolverSpec solver;
  PlanSpec plan;
  OutputSpec output;
  ClosedForm closed_form = ClosedForm::none;
};

/// One `--set path=value`, e.g. "time.frames=30" or "geometry.0.cells=[99,99]".
struct Override {
  std::string path, value;
};

/// Reads, completes and checks a scene file. Paths in it are relative to it. Throws
/// std::invalid_argument with one sentence: file, place (JSON path, line), fault, remedy; an
/// unknown key names the nearest known one.
Scene read_scene(const std::filesystem::path& file, const std::vector<Override>& overrides = {},
                 const Methods& methods = {});

/// One key of a scene file, from the published schema.
struct SceneKey {
  std::string path;                ///< "geometry.*.cells": a star stands for any index or name
  std::vector<std::string> words;  ///< all its values, if the schema lists them
};

/// All keys, sorted by path.
std::vector<SceneKey> scene_keys();

/// The path with the present name of a renamed key: "contact.thickness" gives "contact.rest_gap",
/// "contact.stiffness" gives "contact.response.stiffness". Other paths are returned unchanged.
std::string present_key(const std::string& path);

/// The JSON schema of scene files, of which data/scenes/scene.schema.json is a copy.
std::string scene_schema_text();

/// True if `path`, written as for --set with indices or names, is an instance of `key`.
bool is_instance_of(const std::string& path, const std::string& key);

}  // namespace selvedge
