// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/analytic_body.h>
#include <selvedge/bodies/body.h>
#include <selvedge/bodies/load_mesh.h>
#include <selvedge/core/adaptive_grid.h>
#include <selvedge/core/cloth_mesh.h>
#include <selvedge/core/force.h>
#include <selvedge/core/wetting.h>
#include <selvedge/scene/methods.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace selvedge {

/// Placement of a geometry: x = rotation * (scale * x_file) + translation.
struct Placement {
  Vec3 translation = Vec3::Zero();  ///< m
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  double scale = 1.0;  ///< > 0
};

enum class ClothPattern {
  rectangular,
  triangular,
  simplified,
  checkerboard,
  responsive,
  bilayered,  ///< cells are those of the dense layer
  arc         ///< a disc of diameter size_x = size_y; cells_x particles on each of cells_y rings
};

/// A curve along which a grid lies at the start, folded or knotted; its rest shape stays flat.
struct StripPath {
  std::vector<Vec3> points;   ///< m, the curve runs smoothly through them; empty: flat
  Vec3 side = Vec3::UnitY();  ///< where y of the grid points, as far as it is across the curve
};

/// Springs fitted to a plate of the material's stretch and bending stiffness: the triangular
/// pattern, or a flat mesh ("plate").
struct PlateSpec {
  double poisson = 1.0 / 3.0;  ///< in (-1, 1)
};

/// When the cells of a rectangular grid are split in four ("refine"), looked at before every frame.
struct RefineSpec {
  enum class When {
    never,
    settled,  ///< all of them, once nothing is faster than `speed` or the energy is below `energy`
    curved    ///< those that meet a neighbour at more than `angle`
  };
  When when = When::never;
  std::int32_t levels = 1;  ///< at most so many times, in [1, AdaptiveGrid::max_levels]
  double speed = 0.05;      ///< m/s
  double energy = 0.0;      ///< J, kinetic
  double after = 0.2;       ///< s, of settled: not sooner after the start or the last split
  double angle = 0.35;      ///< rad
};

/// Cells of one piece that were split at one time.
struct SplitEvent {
  std::int32_t piece = 0;  ///< of the scene
  double time = 0.0;       ///< s
  std::vector<GridCell> cells;
};

/// Springs of every particle to its place ("virtual_springs") [survey 2.8].
struct VirtualSpec {
  double stiffness = 0.0;  ///< N/m³, force per area and distance, >= 0; 0: none
  bool follow = false;     ///< the places go along with the cloth; else they stay where it starts
};

struct ClothGrid {
  ClothPattern pattern = ClothPattern::rectangular;
  GridConfig grid;
  StripPath path{};
  LayerConfig layers{};  ///< of the bilayered pattern
  std::optional<PlateSpec> plate{};
  RefineSpec refine{};
};

struct ClothFile {
  std::filesystem::path file;  ///< any triangle mesh: initial shape, and rest shape unless given
  std::filesystem::path rest_file;  ///< empty: the file itself
  /// Metres per unit of the texture coordinates, which then are the flat pattern at rest; 0: they
  /// are not.
  double texture_unit = 0.0;
  TriangleMesh mesh;  ///< where `file` is empty: the mesh itself
  std::optional<PlateSpec> plate{};
  std::optional<SupportConstants> support{};  ///< a closed surface held up from within
};

/// One piece of cloth ("geometry" in the scene file).
struct ClothSpec {
  std::string name;
  std::variant<ClothGrid, ClothFile> shape;
  Placement placement;
  Vec3 velocity = Vec3::Zero();  ///< m/s at the start
  std::string material = "default";
  VirtualSpec virtual_springs{};
};

/// Particles that are held, and how they move ("handles").
struct HandleSpec {
  std::string name;
  std::string geometry;  ///< name of the piece
  std::vector<std::int32_t>
      vertices;                  ///< of the piece; corners and boxes are resolved by the parser
  std::vector<Keyframe> motion;  ///< relative to the start; empty: held still
  double release = -1.0;         ///< s; negative: never let go
  /// It turns about the mean of so many of its first vertices; 0: of all.
  std::size_t pivots = 0;
};

/// Mass added to particles: a button, a heavy hem ("weights").
struct WeightSpec {
  std::string name;
  std::string geometry;                ///< name of the piece
  std::vector<std::int32_t> vertices;  ///< of the piece
  double mass = 0.0;                   ///< kg, to each of them, >= 0
};

/// Two rows of particles that are sewn together, the first of one to the first of the other
/// ("seams").
struct SeamSpec {
  std::string name;
  std::array<std::string, 2> geometry;                ///< names of the pieces
  std::array<std::vector<std::int32_t>, 2> vertices;  ///< of the pieces, equally many
  SewingConfig sewing;
};

/// Particles onto which water drops ("water.sources").
struct WaterSource {
  std::string geometry;                ///< name of the piece
  std::vector<std::int32_t> vertices;  ///< of the piece
  double rate = 0.0;                   ///< kg/s, onto all of them together, >= 0
  double begin = 0.0, end = 0.0;       ///< s
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

/// What cloth falls on ("obstacles").
struct BodySpec {
  std::string name;
  std::variant<BodyShape, BodyFile, BodySequence> shape;
  Placement placement;
  std::vector<Keyframe> motion;  ///< empty: static (or the sequence's own motion)
  double friction = 0.3;         ///< cloth on this body, >= 0
};

struct TimeSpec {
  int frames = 120;         ///< frames after the start frame, >= 1
  double fps = 60.0;        ///< frames per second, > 0
  int steps_per_frame = 2;  ///< >= 1
  int max_halvings = 8;     ///< a step that cannot be made clean is halved this often
};

/// Friction and thickness of one pair of surfaces ("contact.pairs"); what is left out stays as it
/// is. Of several entries that match a pair the last one counts, for either field by itself.
struct PairSpec {
  std::string a, b;  ///< names of pieces, materials or bodies, in any order; not two bodies
  std::optional<double> friction;   ///< Coulomb coefficient, >= 0
  std::optional<double> thickness;  ///< m, rest distance, > 0
};

struct ContactSpec {
  double thickness = 0.002;     ///< m, rest distance between two surfaces, > 0
  std::vector<PairSpec> pairs;  ///< pairs with a friction or thickness of their own
  bool self = true;             ///< cloth against itself and other pieces
  bool untangle_start = false;  ///< cloth that crosses at the start is untangled, not refused
  bool carry_tangled =
      false;  ///< one that cannot be untangled goes on, flagged; else the run stops
  std::string broad_phase = "bvh_aabb";
  std::string narrow_phase = "ccd_exact";
  std::string response = "contact_force";
  ResponseConfig response_config;  // the keys beside
  std::string fail_safe = "layered";
};

struct SolverSpec {
  std::string integrator = "implicit_euler";
  bool strain_limiter = true;        ///< false: `limiter` is none
  std::string limiter = "position";  ///< how springs are kept within their strain limits
  double tolerance = 1e-3;           ///< relative residual of the linear solve
  int max_iterations = 2000;
  bool refuse_unstable_step = false;  ///< a step beyond stability ends the run; else it is divided
  double error = 1e-5;                ///< m, of position in an inner step of rkf45, > 0
  double drag = 0.5;                  ///< 1/s, of damped_verlet, >= 0
  int max_newton = 20;                ///< iterations of implicit_newton in one solve, >= 1
};

struct CameraSpec {
  Vec3 eye = Vec3(1.6, -2.2, 1.4), target = Vec3(0.0, 0.0, 0.3);  ///< m
  double field_of_view = 35.0;                                    ///< degrees, vertical
  int width = 960, height = 720;                                  ///< pixels
};

struct OutputSpec {
  bool vtk = false;       ///< .vtp + .pvd
  bool pc2 = false;       ///< base .ply + .pc2
  int picture_every = 0;  ///< render every n-th frame; 0: the last one only
  CameraSpec camera;
};

struct PlanSpec {
  bool proofs = true;  ///< leave out what provably does nothing (the same bits); off: to compare
};

/// A motion of the scene that is known in closed form ("closed_form"), for errors of `compare`.
enum class ClosedForm {
  none,
  free_fall,  ///< every particle flies as a point in vacuum: x = x0 + v0 t + g t²/2
  incline     ///< the cloth slides down a flat body at a constant acceleration, or sticks
};
struct ClosedFormSpec {
  ClosedForm motion = ClosedForm::none;
  std::string body;  ///< incline: which; its slope and friction are those of the motion
};

/// A scene file, checked and complete: every name resolved, every number in range.
struct Scene {
  std::string name;
  std::filesystem::path file;
  std::string json;  ///< the file as read: overrides and defaults in, comments out, paths absolute
  std::vector<ClothSpec> cloths;
  std::map<std::string, Material> materials;
  std::vector<HandleSpec> handles;
  std::vector<WeightSpec> weights;
  std::vector<SeamSpec> seams;
  std::optional<WaterSpec> water;
  std::vector<BodySpec> bodies;
  Vec3 gravity = Vec3(0.0, 0.0, -9.81);  ///< m/s²
  AirConfig air;
  TimeSpec time;
  ContactSpec contact;
  SolverSpec solver;
  PlanSpec plan;
  OutputSpec output;
  ClosedFormSpec closed_form;
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

/// Virtual springs of one piece.
struct BuiltVirtualSprings {
  std::int32_t begin = 0;         ///< first vertex of the piece
  std::vector<double> stiffness;  ///< N/m, of each of its vertices
  bool follow = false;
};
/// The volume of one closed piece.
struct BuiltVolume {
  double stiffness = 0.0;           ///< N/m
  std::int32_t centre = 0;          ///< vertex
  std::vector<Triangle> triangles;  ///< of the piece
};

/// The pieces of the scene as simulated: all cloth joined, meshes loaded and placed.
struct BuiltScene {
  ClothMesh cloth;
  /// At rest: triangle i is that of cloth.surface; each piece in its own place, grids and patterns
  /// flat in the xy-plane. Vertices are those of the cloth but in garments.
  TriangleMesh rest;
  std::vector<Vec3> velocity;                 ///< at the start, per cloth vertex
  std::vector<std::int32_t> piece_begin;      ///< first vertex of each piece, plus the total
  std::vector<std::unique_ptr<Body>> bodies;  ///< in the order of Scene::bodies
  std::vector<std::string> warnings;          ///< e.g. a body that is not closed
  std::vector<BuiltVirtualSprings> virtual_springs;
  std::vector<BuiltVolume> volumes;
};
/// Throws std::invalid_argument for numbers out of range and meshes that cannot be used, naming
/// place, fault and remedy.
BuiltScene build_scene(const Scene& scene);

}  // namespace selvedge
