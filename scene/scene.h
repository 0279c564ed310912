// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/analytic_body.h>
#include <selvedge/bodies/body.h>
#include <selvedge/bodies/load_mesh.h>
#include <selvedge/core/cloth_mesh.h>
#include <selvedge/core/force.h>
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
  arc  ///< a disc of diameter size_x = size_y; cells_x particles on each of cells_y rings
};

/// A curve along which a grid lies at the start, folded or knotted; its rest shape stays flat.
struct StripPath {
  std::vector<Vec3> points;   ///< m, the curve runs smoothly through them; empty: flat
  Vec3 side = Vec3::UnitY();  ///< where y of the grid points, as far as it is across the curve
};

struct ClothGrid {
  ClothPattern pattern = ClothPattern::rectangular;
  GridConfig grid;
  StripPath path{};
};

struct ClothFile {
  std::filesystem::path file;  ///< any triangle mesh: initial shape, and rest shape unless given
  std::filesystem::path rest_file;  ///< empty: the file itself
  TriangleMesh mesh;                ///< where `file` is empty: the mesh itself
};

/// One piece of cloth ("geometry" in the scene file).
struct ClothSpec {
  std::string name;
  std::variant<ClothGrid, ClothFile> shape;
  Placement placement;
  Vec3 velocity = Vec3::Zero();  ///< m/s at the start
  std::string material = "default";
};

/// Particles that are held, and how they move ("handles").
struct HandleSpec {
  std::string name;
  std::string geometry;  ///< name of the piece
  std::vector<std::int32_t>
      vertices;                  ///< of the piece; corners and boxes are resolved by the parser
  std::vector<Keyframe> motion;  ///< relative to the start; empty: held still
  double release = -1.0;         ///< s; negative: never let go
};

/// Mass added to particles: a button, a heavy hem ("weights").
struct WeightSpec {
  std::string name;
  std::string geometry;                ///< name of the piece
  std::vector<std::int32_t> vertices;  ///< of the piece
  double mass = 0.0;                   ///< kg, to each of them, >= 0
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
  std::string integrator = "implicit_euler";  ///< or "symplectic_euler"
  bool strain_limiter = true;
  double tolerance = 1e-3;  ///< relative residual of the linear solve
  int max_iterations = 2000;
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

/// A scene file, checked and complete: every name resolved, every number in range.
struct Scene {
  std::string name;
  std::filesystem::path file;
  std::string json;  ///< the file as read: overrides and defaults in, comments out, paths absolute
  std::vector<ClothSpec> cloths;
  std::map<std::string, Material> materials;
  std::vector<HandleSpec> handles;
  std::vector<WeightSpec> weights;
  std::vector<BodySpec> bodies;
  Vec3 gravity = Vec3(0.0, 0.0, -9.81);  ///< m/s²
  AirConfig air;
  TimeSpec time;
  ContactSpec contact;
  SolverSpec solver;
  OutputSpec output;
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

/// The pieces of the scene as simulated: all cloth joined, meshes loaded and placed.
struct BuiltScene {
  ClothMesh cloth;
  std::vector<Vec3> velocity;                 ///< at the start, per cloth vertex
  std::vector<std::int32_t> piece_begin;      ///< first vertex of each piece, plus the total
  std::vector<std::unique_ptr<Body>> bodies;  ///< in the order of Scene::bodies
  std::vector<std::string> warnings;          ///< e.g. a body that is not closed
};
/// Throws std::invalid_argument for numbers out of range and meshes that cannot be used, naming
/// place, fault and remedy.
BuiltScene build_scene(const Scene& scene);

}  // namespace selvedge
