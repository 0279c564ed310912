// SPDX-License-Identifier: MIT
//
// T. Vassilev, B. Spanlang, Y. Chrysanthou, "Fast cloth animation on walking avatars", Computer
// Graphics Forum 20(3), 2001 [Vassilev2001]: a body is drawn from its front and from its back, and
// a particle is compared with the depth at its place in the two pictures.
//
// Both classes draw off screen, on the processor, by OSMesa. Both are APPROXIMATE: they know of the
// body what a picture shows. What each misses stands at the class.
#pragma once

#include <selvedge/broadphase/broad_phase.h>

#include <memory>
#include <span>
#include <vector>

namespace selvedge {

struct DepthNormalConfig {
  /// Texels along the longer side of the picture, 16 to 4096. Finer: smaller errors, in proportion
  /// to the side; more to draw, in proportion to its square.
  int resolution = 512;
  /// Points from the back to the front of the body, any length. Zero: the axis along which the box
  /// of the body is shortest, so that most of it can be seen.
  Vec3 axis = Vec3::Zero();
  /// Serves bodies that are not closed too. `inside` then means no more than "between the two".
  bool allow_open = false;
};

/// One side of the body, row by row from the bottom: what is seen at the middle of each texel.
struct DepthNormalLayer {
  std::vector<std::int32_t> triangle;         ///< -1: nothing
  std::vector<float> depth;                   ///< m along the axis from DepthNormalMaps::center
  std::vector<Eigen::Vector3f> normal;        ///< vertex normals, interpolated, not unit
  std::vector<Eigen::Vector3f> displacement;  ///< m, of the body in this step
};

/// What the maps say of one particle.
struct ParticleAnswer {
  bool covered = false;  ///< the body is in the picture here; else nothing below has a meaning
  bool inside = false;   ///< between the front and the back
  bool front = false;    ///< the nearer side is the front
  double depth = 0.0;    ///< m along the axis beneath the nearer side; negative: outside it
  Vec3 normal = Vec3::Zero();        ///< unit, of the nearer side at this place
  Vec3 displacement = Vec3::Zero();  ///< m, of the nearer side in this step
};

/// Depth and normal maps of a body at the end of the step [Vassilev2001], from which particles are
/// answered directly, without pairs.
///
/// Error: where the body's outermost side is a graph over the picture whose slope is at most m
/// (normals within atan m of the axis) its depth is off by at most m·sideways_error(), half the
/// diagonal of a texel times the slope; where it is also smooth and m is below 5 by at most
/// texel²/8·(|∂²z/∂x²| + |∂²z/∂y²|). Single precision adds 2^-21 of the body's half depth. No bound
/// holds at a silhouette. The first bound: of weights w over the corners c of a cell that
/// interpolate its point p, Σ w|p - c| ≤ √(Σ w|p - c|²), which is largest, texel/√2, in the middle.
/// Misses: everything between the outermost front and the outermost back, such as the gap between
/// arm and trunk or a hole that runs across the axis, which counts as inside; parts thinner than a
/// texel; and, because it is asked of particles alone, what passes between them.
///
/// Deviations from the paper: a particle between four covered texels is interpolated between them,
/// the paper takes one; colours are floats and not bytes; the displacement of the body, which the
/// paper draws into a third pair of maps, is drawn with the normals.
class DepthNormalMaps {
 public:
  /// Throws std::invalid_argument for a resolution out of range and an axis that is not finite.
  explicit DepthNormalMaps(const DepthNormalConfig& config = {});
  ~DepthNormalMaps();
  DepthNormalMaps(DepthNormalMaps&&) noexcept;
  DepthNormalMaps& operator=(DepthNormalMaps&&) noexcept;

  /// Draws the body if it has changed since the last time; says whether it did. Throws
  /// std::invalid_argument for one without triangles, with a coordinate that is not finite (naming
  /// the vertex) or, unless allowed, with an edge whose triangles do not close the body, and
  /// std::runtime_error if there is nothing to draw with.
  bool update(const SurfaceView& body);

  /// Answers each point, on all threads. The two spans have the same length.
  void answer(std::span<const Vec3> points, std::span<ParticleAnswer> answers) const;

  const DepthNormalLayer& front() const;
  const DepthNormalLayer& back() const;
  int width() const;              ///< texels
  int height() const;             ///< texels
  double texel() const;           ///< m, side of a texel
  double sideways_error() const;  ///< m, half the diagonal of a texel
  Vec3 axis() const;              ///< unit, from the back to the front
  Vec3 center() const;            ///< m, where depth is 0; the middle of the picture
  std::size_t renders() const;    ///< how often a body was drawn, front and back counting once

 private:
  struct State;
  std::unique_ptr<State> state_;
};

struct ImageSpaceConfig {
  /// Texels along the longer side of each picture, 16 to 4096. A triangle that no texel's middle
  /// meets is not seen: choose texels smaller than the body's triangles. See recall in the tests.
  int resolution = 1024;
};

/// Candidate pairs from pictures: one surface is drawn from six sides, along the three axes, each
/// texel holding the index of the triangle that it shows. The box of each primitive of the other
/// surface, swept and inflated, is a window in each picture; the triangles that show up there are
/// tried with their boxes. Of the two surfaces the one with a static_id is drawn, else the second;
/// it is drawn again only after it has moved. Does not serve a surface with itself.
///
/// Approximate: every pair that it reports is one of brute force, but it misses triangles that are
/// hidden from all six sides (armpits, pleats, inner layers), those that no middle of a texel
/// meets, and edges and vertices without a triangle. A moving surface is drawn at the middle of the
/// step and windows grow by half of its largest displacement; a few triangles that are far larger
/// than the others or move far more are not drawn but tried with everything. A window that shows
/// as much as the whole surface is replaced by the whole surface, so that no primitive, however
/// large, costs more than one test per triangle.
class ImageSpace final : public BroadPhase {
 public:
  /// Throws std::invalid_argument for a resolution out of range.
  explicit ImageSpace(const ImageSpaceConfig& config = {});
  ~ImageSpace() override;

  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override;
  /// Throws std::invalid_argument, always.
  void find_self_pairs(const SurfaceView& a, CandidatePairs& out) override;
  BroadPhaseTraits traits() const override;
  BroadPhaseCost last_cost() const override;

  std::size_t renders() const;  ///< how often a surface was drawn, its six sides counting once
  std::size_t unseen() const;   ///< triangles of the drawn surface that no picture shows

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Adds `image_space`.
void register_image_space(BroadPhaseRegistry& registry);

}  // namespace selvedge
