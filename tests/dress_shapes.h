// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>
#include <selvedge/garment/sewing_pattern.h>

#include <cmath>
#include <numbers>

/// A simple garment and a body for tests of dressing.
namespace selvedge::dress_shapes {

/// A tube of two rectangles, `width` wide, in front of and behind the z axis; its lower edge is at
/// z = 0.
inline SewingPattern tube(double width, double height, double distance) {
  SewingPattern pattern;
  pattern.name = "tube";
  for (const double side : {-1.0, 1.0}) {
    PatternPanel panel;
    panel.name = side < 0.0 ? "front" : "back";
    const double w = 0.5 * width;
    panel.vertices = {{-w, 0.0}, {w, 0.0}, {w, height}, {-w, height}};
    for (std::int32_t i = 0; i < 4; ++i) panel.edges.push_back({{i, (i + 1) % 4}, {}, ""});
    // The plane's normal leads away from the axis.
    panel.rotation << -side, 0, 0, 0, 0, side, 0, 1, 0;
    panel.translation = Vec3(0.0, side * distance, 0.0);
    pattern.panels.push_back(panel);
  }
  using Direction = PatternStitch::Direction;
  pattern.stitches = {{{0, 1}, {1, 3}, Direction::end_to_start},
                      {{0, 3}, {1, 1}, Direction::end_to_start}};
  return pattern;
}

/// A cone with its tip up, on which a tube comes to rest.
inline TriangleMesh cone(double radius, double height, int segments = 24) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3(0.0, 0.0, height), Vec3::Zero()};
  for (int i = 0; i < segments; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / segments;
    mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0);
  }
  for (int i = 0; i < segments; ++i) {
    const std::int32_t a = 2 + i, b = 2 + (i + 1) % segments;
    mesh.triangles.push_back({0, a, b});
    mesh.triangles.push_back({1, b, a});
  }
  return mesh;
}

}  // namespace selvedge::dress_shapes
