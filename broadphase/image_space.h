// SPDX-License-Identifier: MIT
//
// T. Vassilev, B. Spanlang, Y. Chrysanthou, "Fast cloth animation on walking avatars", Computer
// Graphics Forum 20(3), 2001 [Vassilev2001]: draws a body from its front and from its back, and
// compares each particle with the depth at its place in the two pictures.
//
// Both classes draw off screen, on the processor, by OSMesa. Both are APPROXIMATE: they only detect
// the part of a body that a picture shows. The comment of each class says what it misses.
#pragma once

#include <selvedge/broadphase/broad_phase.h>

#include <memory>
#include <span>
#include <vector>

namespace selvedge {

/// Options of DepthNormalMaps.
struct DepthNormalConfig {
  /// Texels along the longer side of the picture, 16 to 4096. Finer: errors shrink in proportion to
  /// the texel side, drawing cost grows with the square of the resolution.
  int resolution = 512;
  /// Points from the back to the front of the body, any length. Zero: the axis along which the box
  /// of the body is shortest, so that most of the body is visible.
  Vec3 axis = Vec3::Zero();
  /// Also accept bodies that are not closed. `inside` then only means "between front and back".
  bool allow_open = false;
};

/// One side of the body, row by row from the bottom: the surface at the middle of each texel.
struct DepthNormalLayer {
  std::vector<std::int32_t> triangle;         ///< -1: nothing
  std::vector<float> depth;                   ///< m along the axis from DepthNormalMaps::center
  std::vector<Eigen::Vector3f> normal;        ///< vertex normals, interpolated, not unit
  std::vector<Eigen::Vector3f> displacement;  ///< m, of the body in this step
};

/// What the maps give for one particle.
struct ParticleAnswer {
  bool covered = false;  ///< the picture shows the body here; otherwise the other fields have no
                         ///< meaning
  bool inside = false;   ///< between front and back
  bool front = false;    ///< the nearer side is the front
  double depth = 0.0;    ///< m, depth along the axis below the nearer side; negative: outside
  Vec3 normal = Vec3::Zero();        ///< unit normal of the nearer side at this place
  Vec3 displacement = Vec3::Zero();  ///< m, displacement of the nearer side in this step
};

/// Depth and normal maps of a body at the end of the step [Vassilev2001], which answer particle
/// queries directly, without pairs.
///
/// Error: if the body's outermost side is a graph over the picture with slope at most m (normals
/// within atan m of the axis), its depth is off by at most m·sideways_error(), half the diagonal of
/// a texel times the slope. If it is also smooth and m is below 5, the error is at most
/// texel²/8·(|∂²z/∂x²| + |∂²z/∂y²|). Single precision adds 2^-21 of the body's half depth. No bound
/// holds at a silhouette. Proof of the first bound: for weights w over the corners c of a cell that
/// interpolate its point p, Σ w|p - c| ≤ √(Σ w|p - c|²), which has its maximum, texel/√2, in the
/// middle.
///
/// Misses: everything between the outermost front and the outermost back, such as the gap between
/// arm and trunk or a hole across the axis, which count as inside; parts thinner than a texel; and,
/// because only particles are tested, everything that passes between them.
///
/// Deviations from the paper: a particle between four covered texels is interpolated; the paper
/// takes one texel. Colours are floats instead of bytes. The displacement of the body, which the
/// paper draws into a third pair of maps, is drawn together with the normals.
class DepthNormalMaps {
 public:
  /// Throws std::invalid_argument for a resolution out of range and an axis that is not finite.
  explicit DepthNormalMaps(const DepthNormalConfig& config = {});
  ~DepthNormalMaps();
  DepthNormalMaps(DepthNormalMaps&&) noexcept;
  DepthNormalMaps& operator=(DepthNormalMaps&&) noexcept;

  /// Draws the body if it has changed since the last call; returns whether it did. Throws
  /// std::invalid_argument for a body without triangles, with a coordinate that is not finite
  /// (naming the vertex) or, unless allow_open is set, with an edge whose triangles do not close
  /// the body; throws std::runtime_error if drawing is not possible.
  bool update(const SurfaceView& body);

  /// Answers each point, on all threads. The two spans must have the same length.
  void answer(std::span<const Vec3> points, std::span<ParticleAnswer> answers) const;

  /// The two sides in the last drawn picture.
  const DepthNormalLayer& front() const;
  const DepthNormalLayer& back() const;
  int width() const;              ///< texels
  int height() const;             ///< texels
  double texel() const;           ///< m, side of a texel
  double sideways_error() const;  ///< m, half the diagonal of a texel
  Vec3 axis() const;              ///< unit, from the back to the front
  Vec3 center() const;            ///< m, where depth is 0; the middle of the picture
  std::size_t renders() const;    ///< how often a body was drawn; front and back count once

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Options of ImageSpace.
struct ImageSpaceConfig {
  /// Texels along the longer side of each picture, 16 to 4096. A triangle that covers no texel's
  /// middle is not seen, so choose texels smaller than the body's triangles. The tests measure the
  /// recall.
  int resolution = 1024;
};

/// Candidate pairs from pictures. One surface is drawn from six sides, along the three axes; each
/// texel holds the index of the visible triangle. The swept and inflated box of each primitive of
/// the other surface is a window in each picture, and the triangles visible in it are tested by
/// their boxes. The surface with a static_id is drawn, otherwise the second one; it is drawn again
/// only after it has moved. Does not support a surface with itself.
///
/// Approximate: every reported pair is one of brute force, but it misses triangles that are hidden
/// from all six sides (armpits, pleats, inner layers), triangles that cover no texel's middle, and
/// edges and vertices without a triangle. A moving surface is drawn at the middle of the step, and
/// windows grow by half of its largest displacement. A few triangles that are much larger or move
/// much farther than the others are not drawn but tested against everything. A window that shows as
/// many triangles as the whole surface is replaced by the whole surface, so that no primitive,
/// however large, costs more than one test per triangle.
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

  std::size_t renders() const;  ///< how often a surface was drawn; its six sides count once
  std::size_t unseen() const;   ///< triangles of the drawn surface that no picture shows

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Adds `image_space`.
void register_image_space(BroadPhaseRegistry& registry);

}  // namespace selvedge
