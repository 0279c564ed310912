// SPDX-License-Identifier: MIT
//
// T. Vassilev, B. Spanlang, "Efficient cloth model for dressing animated virtual people", The
// Visual Computer 17(4), 2000 [VassilevSpanlang2000; survey 6.1.3, "Image space"], and with
// Y. Chrysanthou, "Fast cloth animation on walking avatars", Computer Graphics Forum 20(3), 2001
// [Vassilev2001]: draws a body from its front and from its back, and compares each particle with
// the depth at its place in the two pictures.
//
// DepthNormalMaps are these pictures and ParticleMaps is the detector that uses them.
// ImageSpacePairs is ours: it yields pairs for a narrow phase from pictures of triangle indices.
// All draw off screen, on the processor, by OSMesa. All are APPROXIMATE: they only detect the part
// of a body that a picture shows. The comment of each class says what it misses.
#pragma once

#include <selvedge/broadphase/broad_phase.h>

#include <array>
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
  std::int32_t triangle = -1;        ///< of the body, that the nearer side shows here
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

  /// The triangles that front and back show at the place of a point; -1: none.
  std::array<std::int32_t, 2> triangles_at(const Vec3& point) const;

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

/// Options of ParticleMaps.
struct ParticleMapsConfig {
  /// Texels along the longer side of each picture, 16 to 4096. Finer: errors shrink in proportion
  /// to the texel side, drawing cost grows with the square of the resolution. 0: the least multiple
  /// of 64 for which sideways_error() is an eighth of the reach of the first call, at most 4096;
  /// 512 if the first call is of find_pairs.
  int resolution = 0;
  /// Axes that the body is drawn along, 1 to 3, those along which its box is shortest first. 1:
  /// front and back. 2: also from both sides. 3: also from above and below. More: fewer hidden
  /// parts, and contacts beside the outline; costs one pair of pictures each. 0: as few as show 99
  /// % of the area of the first body under at most 60 degrees, else 3.
  int views = 0;
};

/// The detector of [Vassilev2001]: contacts of particles with a closed body from its depth and
/// normal maps. The pictures are drawn with the body at the end of the step, again only after it
/// has moved. The end of each particle is looked up in them. Its distance from the surface is the
/// difference of the depths, survey section 6.1.3, times the cosine between normal and axis; the
/// normal of the contact is that of the map. The contact's point of the body moves with the
/// triangle that the map shows, which gives the response the velocity V_human of survey eq. 49.
///
/// The body is the intersection of what the views enclose, so the largest of their distances
/// counts. A particle that lies outside the outline in one view, or above the body by more than
/// twice the reach along its axis, is outside.
///
/// Error: where DepthNormalMaps states a bound m·sideways_error() of its depth, the distance is off
/// by at most sideways_error() and by the curvature of the body over that depth. Misses what no
/// picture shows, as DepthNormalMaps does, and everything that passes between particles or, within
/// a step, through a thin part of the body.
///
/// find_pairs gives a narrow phase the pairs of a particle with the triangles that the pictures
/// show at its start and its end, if their swept boxes overlap. Does not support a surface with
/// itself.
class ParticleMaps final : public BroadPhase {
 public:
  /// Throws std::invalid_argument for an option out of range.
  explicit ParticleMaps(const ParticleMapsConfig& config = {});
  ~ParticleMaps() override;

  void find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) override;
  /// Throws std::invalid_argument, always.
  void find_self_pairs(const SurfaceView& a, CandidatePairs& out) override;
  void find_particle_contacts(const SurfaceView& a, const SurfaceView& b, double reach,
                              std::vector<ParticleContact>& out) override;
  BroadPhaseTraits traits() const override;
  BroadPhaseCost last_cost() const override;

  std::size_t renders() const;    ///< pairs of pictures drawn so far, of all views
  int views() const;              ///< in use; 0: nothing was drawn yet
  double sideways_error() const;  ///< m, half the diagonal of the largest texel in use

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Options of ImageSpacePairs.
struct ImageSpacePairsConfig {
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
class ImageSpacePairs final : public BroadPhase {
 public:
  /// Throws std::invalid_argument for a resolution out of range.
  explicit ImageSpacePairs(const ImageSpacePairsConfig& config = {});
  ~ImageSpacePairs() override;

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

/// Adds `depth_normal_maps` (ParticleMaps) and `image_space_pairs`.
void register_image_space(BroadPhaseRegistry& registry);

}  // namespace selvedge
