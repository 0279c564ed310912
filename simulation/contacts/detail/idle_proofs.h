// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Proves that no two primitives without a common vertex of a flat, convex piece of cloth come near
/// each other while it moves, in time proportional to the number of triangles.
///
/// The piece lies in a plane at its start; F maps that plane to the present positions. Each
/// triangle has a constant gradient G of F, linear in time along straight paths. Let B have
/// orthonormal columns. If the symmetric part of BᵀG has no eigenvalue below c for any triangle,
/// then along the straight line from a to b, which stays in the convex piece,
///   |F(a) − F(b)| ≥ (a−b)ᵀBᵀ(F(a) − F(b)) / |a−b| ≥ c |a−b|:
/// the sheet is a height field over the plane of B with a distance between its points (a monotone
/// map; the normals in a cone of less than 90° of [Volino1994] with the contour as a consequence
/// and not a test of its own). The least eigenvalue is concave in G, so both ends of the motion
/// suffice. Far pairs need any c > 0, near pairs a larger one: they are examined in overlapping
/// squares, each with a B of its own.
///
/// A proof at y with c to spare holds for many short steps: if all displacements from y lie in a
/// box of diagonal D, the edges of a triangle with edge matrix E changed by at most |D| each, and G
/// by at most √2 |D| ‖E⁻¹‖. This test visits the particles only.
///
/// A positive answer is never wrong, except for rounding, which is a million times smaller than the
/// distances in question. A negative answer proves nothing.
class SheetProof {
 public:
  /// `x`: the piece at its start, m, all its vertices; triangles count from its first vertex.
  SheetProof(std::span<const Vec3> x, std::span<const Triangle> triangles);

  /// Whether the piece is flat and convex at its start; otherwise nothing can be proved.
  bool applies() const { return nearest_ > 0.0; }
  /// Least distance at the start of two primitives without a common vertex, m.
  double nearest() const { return nearest_; }

  /// Proves that primitives without a common vertex stay farther apart than `distance` during the
  /// whole motion, and that the gap of two of them at t = 0, measured along its own direction,
  /// stays above `distance` as well. Spans of this piece's vertices, m.
  bool keeps_apart(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1, double distance);

 private:
  using Gradient = Eigen::Matrix<double, 3, 2>;
  /// Triangles of a square of the plane, overlapping with its neighbours.
  struct Patch {
    std::vector<std::int32_t> triangles;
  };

  void flatten(std::span<const Vec3> x);
  bool is_convex() const;
  double nearest_link() const;
  void make_patches();
  double room(std::span<const std::int32_t> some, double enough) const;
  bool moved_little(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1) const;
  double spare_room(double distance) const;
  void find_gradients(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1);

  std::vector<Triangle> triangles_;
  std::vector<std::int32_t> all_;         // 0, 1, ...
  std::vector<Eigen::Vector2d> flat_;     // of the vertices, m
  std::vector<Eigen::Matrix2d> inverse_;  // of the edge matrices of the triangles
  std::vector<Gradient> start_, change_;  // of this motion: at t = 0, and to t = 1
  std::vector<Patch> patches_;
  std::vector<Vec3> proved_;                    // positions that had room to spare, m
  double proved_distance_ = 0.0, spare_ = 0.0;  // m; and the unused part of the eigenvalue there
  double steepest_ = 0.0;                       // 1/m, of the inverse edge matrices
  double nearest_ = 0.0, far_ = 0.0;            // m; far: pairs beyond it are proved all together
};

/// How often a part was due and how often it was proved idle.
struct IdleCount {
  std::int64_t asked = 0, idle = 0;
  double busy_s = 0.0;  ///< s, spent when it was not idle
  /// s, time saved, if an idle call takes the mean time of the others; 0 if there were no others.
  double saved_s() const;
};

/// Delays the next attempt of a proof that failed: after n failures in a row it is due only every
/// 2^n-th time, but at least every 64th, so that proofs in vain cost nearly nothing.
class ProofBackoff {
 public:
  bool is_due();
  void note(bool proved);

 private:
  int wait_ = 0, failures_ = 0;
};

/// An axis-aligned box around a motion.
struct SweptBox {
  Vec3 low, high;  ///< m
};
SweptBox swept_box(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1);
/// Whether they keep apart by more than `distance` along an axis.
bool keep_apart(const SweptBox& a, const SweptBox& b, double distance);

}  // namespace selvedge::detail
