// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>
#include <selvedge/core/triangle_mesh.h>

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// What cloth falls on: a triangle surface whose vertices are given at every time. Analytic shapes
/// are bodies through their tessellation, so that one guarantee covers all; between two times of
/// a step every vertex moves on a straight line.
class Body {
 public:
  virtual ~Body() = default;

  virtual const std::vector<Triangle>& triangles() const = 0;
  virtual std::size_t vertex_count() const = 0;
  /// Positions at `time` seconds into x (n). Times outside the animation hold its ends.
  virtual void positions(double time, std::span<Vec3> x) const = 0;
  /// True if the body has the same positions at every time in [t0, t1].
  virtual bool is_static(double t0, double t1) const = 0;
  /// The pose that takes the same points to the positions at `time`, of a body that moves rigidly;
  /// nothing for others.
  virtual std::optional<Pose> pose(double) const { return std::nullopt; }
};

/// A pose at a time; between keys translation is linear and rotation spherical-linear.
struct Keyframe {
  double time = 0.0;                                             ///< s
  Vec3 translation = Vec3::Zero();                               ///< m
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< about the body's own origin
};

/// The pose at `time`: linear in translation, spherical-linear in rotation, the ends held; the
/// identity if there are no keys.
Keyframe pose_at(std::span<const Keyframe> keys, double time);

/// A mesh that does not move.
std::unique_ptr<Body> make_static_body(TriangleMesh mesh);
/// A mesh moved rigidly by keyframes, sorted by time (throws std::invalid_argument if not).
std::unique_ptr<Body> make_keyframed_body(TriangleMesh mesh, std::vector<Keyframe> keys);
/// A sequence of meshes with the same triangles, frame k at time start + k/fps; linear between.
std::unique_ptr<Body> make_sequence_body(std::vector<TriangleMesh> frames, double fps,
                                         double start);

}  // namespace selvedge
