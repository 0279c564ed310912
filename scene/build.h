// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/body.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/force.h>
#include <selvedge/scene/scene.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace selvedge {

/// Friction and rest gap of every pair of surfaces of a scene, and whether it can collide, resolved
/// once from its materials, its bodies and `contact.pairs`. Surface indices count the pieces first,
/// in the order of Scene::cloths, then the bodies.
class ContactPairs {
 public:
  /// Throws std::invalid_argument that names the entry of `contact.pairs` if a name is unknown or
  /// ambiguous, or if a pair has no cloth.
  explicit ContactPairs(const Scene& scene);

  /// Coulomb coefficient between a piece and a surface, >= 0.
  double friction(std::int32_t piece, std::int32_t surface) const {
    return table_[index(piece, surface)].friction;
  }
  /// Distance that contacts between a piece and a surface keep at rest, m, > 0.
  double rest_gap(std::int32_t piece, std::int32_t surface) const {
    return table_[index(piece, surface)].rest_gap;
  }
  /// Whether the two can collide; false where the scene excludes it, and for a rigid body and
  /// itself.
  bool collide(std::int32_t piece, std::int32_t surface) const {
    return table_[index(piece, surface)].collide;
  }
  /// The pairs of surfaces that can meet, with each piece of cloth and itself among them: their
  /// number, and the numbers of the surfaces of those that the scene excludes.
  std::int64_t count() const { return count_; }
  const std::vector<std::pair<std::size_t, std::size_t>>& excluded() const { return excluded_; }
  /// Whether all pairs collide.
  bool collide_all() const { return collide_all_; }
  /// The largest rest gap of any pair, m. A search for candidates that reaches this far misses no
  /// pair.
  double largest_rest_gap() const { return largest_; }

 private:
  struct Entry {
    double friction, rest_gap;
    bool collide = true;
  };
  std::size_t index(std::int32_t piece, std::int32_t surface) const {
    return static_cast<std::size_t>(piece) * surfaces_ + static_cast<std::size_t>(surface);
  }

  std::size_t surfaces_;
  double largest_;
  std::int64_t count_ = 0;
  bool collide_all_ = true;
  std::vector<std::pair<std::size_t, std::size_t>> excluded_;
  std::vector<Entry> table_;  // (piece, surface), symmetric among the pieces
};

/// The fault of an entry of `contact.pairs`: its key ("" for the entry itself) and a sentence
/// without the place. An empty sentence means no fault.
struct PairFault {
  std::string key, sentence;
};
PairFault fault_of(const PairSpec& pair, const Scene& scene);

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

/// A rigid body among the pieces: its leaders are point masses with its mass, centre and moments of
/// inertia, and the vertices of its surface follow them.
struct BuiltSolid {
  std::size_t piece = 0;
  std::int32_t leader = 0;  ///< first of the leaders, the last vertices of the piece
  int leaders = 4;          ///< 1: it slides
  double mass = 0.0;        ///< kg
  double radius = 0.0;      ///< m, of its farthest vertex from the centre of mass or from its hinge
  /// A point that the leaders move with their weights: on the hinge and off it, or the centre of
  /// mass of a body that slides.
  struct Point {
    std::array<double, 4> weight{};
    Vec3 start = Vec3::Zero();  ///< m

    Vec3 at(std::span<const Vec3> leaders) const {
      return weight[0] * leaders[0] + weight[1] * leaders[1] + weight[2] * leaders[2] +
             weight[3] * leaders[3];
    }
  };
  std::array<Point, 2> pins{};  ///< the points that a hinge holds; of weight 0: it has none
  Point limited{};              ///< the point whose way shows how far the body has come
  double lever = 0.0;           ///< m, of this point and of the pins; on a hinge
};

/// The parts of a scene as they are simulated: all pieces joined, meshes loaded and placed.
struct BuiltScene {
  ClothMesh cloth;
  /// The rest shape: triangle i corresponds to triangle i of cloth.surface. Grids and patterns lie
  /// flat in the xy-plane. The vertices are those of the cloth, except in garments.
  TriangleMesh rest;
  std::vector<Vec3> velocity;                 ///< at the start, per cloth vertex
  std::vector<std::int32_t> piece_begin;      ///< first vertex of each piece, plus the total
  std::vector<std::unique_ptr<Body>> bodies;  ///< in the order of Scene::bodies
  std::vector<std::string> warnings;  ///< one sentence each, e.g. about a body that is not closed
  std::vector<BuiltVirtualSprings> virtual_springs;
  std::vector<BuiltVolume> volumes;
  std::vector<BuiltSolid> solids;
  std::vector<std::vector<Edge>> seams;  ///< vertices of the pairs of each of Scene::seams
  /// m², of the triangles at the start, if vertices of seams were merged; else empty. A triangle
  /// may then have vertices of several pieces.
  std::vector<double> merged_areas;
};
/// Builds the parts of a scene. Throws std::invalid_argument with place, fault and remedy for a
/// number out of range or a mesh that cannot be used.
BuiltScene build_scene(const Scene& scene, const Methods& methods = {});

/// One piece of cloth: its start and its rest shape.
struct Piece {
  ClothMesh cloth;
  TriangleMesh rest;  ///< scaled, neither rotated nor translated
};
/// Makes or loads one piece, scales it together with its rest shape, rotates and translates it.
/// Throws std::invalid_argument if the mesh or the pattern cannot be made.
Piece make_piece(const ClothSpec& cloth, const Material& material,
                 const ClothPatternRegistry& patterns = cloth_patterns());

/// The grid of a piece with "refine", before any split and without placement. Throws
/// std::invalid_argument for a pattern that cannot be refined.
AdaptiveGrid make_adaptive_grid(const ClothSpec& cloth, const Material& material,
                                const ClothPatternRegistry& patterns = cloth_patterns());

/// Makes piece number `piece` of a scene at its start position.
using PieceMaker = FunctionRef<Piece(std::size_t piece)>;

/// build_scene with pieces from `make` instead of the scene's own.
BuiltScene build_scene(const Scene& scene, const PieceMaker& make);

/// All forces on the cloth of a scene except contact forces. Takes the force laws and the limiter
/// from `methods`.
std::vector<std::unique_ptr<Force>> make_forces(const Scene& scene, const BuiltScene& built,
                                                const Methods& methods = {});
/// The same with the internal forces of `cloth`, which has the vertices of the scene's cloth.
std::vector<std::unique_ptr<Force>> make_forces(const Scene& scene, const BuiltScene& built,
                                                const ClothMesh& cloth, const Methods& methods);

/// Areas of the triangles of the cloth at the start, m².
std::vector<double> start_areas(const BuiltScene& built);

/// Only the sewing forces of a scene.
std::vector<std::unique_ptr<Force>> make_seams(const Scene& scene, const BuiltScene& built);

}  // namespace selvedge
