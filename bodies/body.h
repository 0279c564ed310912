// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>
#include <selvedge/core/base/types.h>

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace selvedge {

// Shapes centred at the origin with axis +z. Sizes in metres, > 0.

/// The square with this side in the plane z = 0.
struct Plane {
  double size = 20.0;
};
/// `size`: the full extents.
struct Box {
  Vec3 size = Vec3::Ones();
};
struct Sphere {
  double radius = 0.5;
};
/// `length`: distance between the centres of the two half spheres.
struct Capsule {
  double radius = 0.25, length = 1.0;
};
struct Cylinder {
  double radius = 0.5, height = 1.0;
};
/// Base at z = -height/2, tip up.
struct Cone {
  double radius = 0.5, height = 1.0;
};
/// Ring in the xy-plane.
struct Torus {
  double radius = 0.3, tube = 0.05;
};

using AnalyticShape = std::variant<Plane, Box, Sphere, Capsule, Cylinder, Cone, Torus>;

/// Distance to the surface, m; negative inside (for the plane: below it). Exact, in closed form.
double signed_distance(const AnalyticShape& shape, const Vec3& x);

/// Closed, outward-oriented triangle mesh (open for the plane). `resolution`: number of segments
/// around the axis, >= 3; flat faces are subdivided only as far as their rim requires. Vertices on
/// curved parts lie on the shape to rounding. The mesh therefore lies inside the shape, by at most
/// r(1 - cos(pi/resolution)). Throws std::invalid_argument naming a bad size or resolution.
TriangleMesh tessellate(const AnalyticShape& shape, int resolution);

/// An obstacle for the cloth: a triangle surface whose vertices are known at every time. Analytic
/// shapes become bodies by tessellation, so all bodies have the same guarantee. During a step every
/// vertex moves on a straight line.
class Body {
 public:
  virtual ~Body() = default;

  virtual const std::vector<Triangle>& triangles() const = 0;
  virtual std::size_t vertex_count() const = 0;
  /// Writes the n positions (m) at `time` (s) into x. Outside the animation the first or last frame
  /// holds.
  virtual void positions(double time, std::span<Vec3> x) const = 0;
  /// True if the positions are the same at every time in [t0, t1].
  virtual bool is_static(double t0, double t1) const = 0;
  /// Pose of a rigidly moving body: it maps fixed points to the positions at `time`. Empty for
  /// other bodies.
  virtual std::optional<Pose> pose(double) const { return std::nullopt; }
};

/// The pose of a rigid body at one time. Between keyframes the translation is interpolated linearly
/// and the rotation spherically.
struct Keyframe {
  double time = 0.0;                                             ///< s
  Vec3 translation = Vec3::Zero();                               ///< m
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< about the body's own origin
};

/// The pose at `time`, interpolated between keyframes and constant beyond the first and last one.
/// The identity if there are no keyframes.
Keyframe pose_at(std::span<const Keyframe> keys, double time);

/// A body that does not move.
std::unique_ptr<Body> make_static_body(TriangleMesh mesh);
/// A mesh that moves rigidly along keyframes. Throws std::invalid_argument unless the keyframes are
/// finite and sorted by time.
std::unique_ptr<Body> make_keyframed_body(TriangleMesh mesh, std::vector<Keyframe> keys);
/// A sequence of meshes with the same triangles: frame k is shown at time start + k/fps, with
/// linear interpolation between frames. Throws std::invalid_argument if the frames do not match.
std::unique_ptr<Body> make_sequence_body(std::vector<TriangleMesh> frames, double fps,
                                         double start);

}  // namespace selvedge
