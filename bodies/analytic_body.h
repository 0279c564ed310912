// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <variant>

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

}  // namespace selvedge
