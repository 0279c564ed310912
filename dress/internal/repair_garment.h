// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace selvedge {

struct RepairConfig {
  double clearance = 0.001;  ///< m, from the body, of vertices that were inside it
  int rounds = 6;            ///< in which the vertices around a bad place join in, >= 1
  /// Of an edge, relative to its length in the file: beyond, the garment is not worn as it was.
  double wearable_stretch = 0.3;
};

/// A place of a garment that still crosses something, or is stretched too far.
struct RepairPlace {
  Vec3 at = Vec3::Zero();  ///< m
  std::int64_t vertices = 0;
  double stretch = 0.0;  ///< the largest of its edges
};

struct RepairResult {
  std::vector<Vec3> x;           ///< m, the vertices of the garment
  std::int64_t moved = 0;        ///< vertices
  double largest_motion = 0.0;   ///< m
  double median_motion = 0.0;    ///< m, of the vertices that were outside the body
  std::int64_t inside = 0;       ///< vertices that were inside the body
  std::int64_t body_before = 0;  ///< pairs of triangles of garment and body that met
  std::int64_t self_before = 0;  ///< pairs of triangles of the garment that met
  std::int64_t body_after = 0, self_after = 0, inside_after = 0;
  std::vector<RepairPlace> left;  ///< where they are, the largest first
  double max_stretch = 0.0;       ///< of an edge, relative to its length in the file
  /// Where edges are stretched beyond RepairConfig::wearable_stretch, the most stretched first.
  std::vector<RepairPlace> stretched;
  bool clean() const { return body_after == 0 && self_after == 0 && inside_after == 0; }
  bool good() const { return clean() && stretched.empty(); }
};

/// Takes the crossings with a body and with itself out of a finished garment, with little motion.
/// Both in metres; the body consists of closed parts. Vertices at the same position move together.
/// Throws std::invalid_argument for meshes without triangles.
RepairResult repair_garment(const TriangleMesh& garment, const TriangleMesh& body,
                            const RepairConfig& config = {});

}  // namespace selvedge
