// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <variant>

namespace selvedge {

/// Shapes about the origin, axis +z. Sizes in metres, > 0.
struct Plane {
  double size = 20.0;
};  ///< z = 0, square of this side
struct Box {
  Vec3 size = Vec3::Ones();
};  ///< full extents
struct Sphere {
  double radius = 0.5;
};
struct Capsule {
  double radius = 0.25, length = 1.0;
};  ///< length between the centres
struct Cylinder {
  double radius = 0.5, height = 1.0;
};
struct Cone {
  double radius = 0.5, height = 1.0;
};  ///< base at -height/2, tip up
struct Torus {
  double radius = 0.3, tube = 0.05;
};  ///< ring in the xy-plane

using AnalyticShape = std::variant<Plane, Box, Sphere, Capsule, Cylinder, Cone, Torus>;

/// Distance to the surface, negative inside (below the plane); exact closed form.
double signed_distance(const AnalyticShape& shape, const Vec3& x);

/// Closed, outward-oriented surface (the plane: open), no vertex farther than rounding from the
/// true one. `resolution`: segments around the axis, >= 3; flat faces are not subdivided further
/// than the rim needs. Vertices on curved parts lie on the shape, so the mesh lies inside it by at
/// most r(1 - cos(pi/resolution)).
TriangleMesh tessellate(const AnalyticShape& shape, int resolution);

}  // namespace selvedge
