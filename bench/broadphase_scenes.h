// SPDX-License-Identifier: MIT
// Benchmark scenes for broad phases, at any size:
//   drape N    an N x N cloth of 1 m around a closed body of 26,680 faces, moved by a step of
//              1/60 s
//   crumple N  an N x N sheet of 1 m folded into a small box; self-collision
// Both surfaces have a thickness of 1 mm.
#pragma once

#include <selvedge/core/base/collision_types.h>
#include <selvedge/core/base/types.h>

#include <limits>
#include <string>
#include <vector>

namespace selvedge::bench {

constexpr double kStep = 1.0 / 60.0;  // s
constexpr double kThickness = 0.001;  // m

struct Surface {
  std::vector<Vec3> x_t0, x_t1;
  std::vector<Edge> edges;
  std::vector<Triangle> triangles;
  std::uint64_t static_id = 0;
  double thickness = kThickness;
  std::size_t tiny_from = std::numeric_limits<std::size_t>::max();  ///< start of the small part

  SurfaceView view() const { return {x_t0, x_t1, edges, triangles, thickness, static_id}; }
  std::size_t primitives() const { return x_t0.size() + edges.size() + triangles.size(); }

  /// Appends the other surface to this one.
  void append(Surface other) {
    const auto first = static_cast<std::int32_t>(x_t0.size());
    tiny_from = x_t0.size();
    x_t0.insert(x_t0.end(), other.x_t0.begin(), other.x_t0.end());
    for (Triangle& t : other.triangles)
      for (std::int32_t& v : t) v += first;
    triangles.insert(triangles.end(), other.triangles.begin(), other.triangles.end());
    edges = unique_edges(triangles);
    x_t1 = x_t0;
  }
};

struct SearchScene {
  std::string name;
  Surface cloth, body;
  double speed = 0.0;
  bool self = false;
  Vec3 origin = Vec3::Zero();  ///< origin of the flow
  double tiny = 1.0;           ///< size and speed of the small part over those of the rest

  std::size_t primitives() const { return cloth.primitives() + body.primitives(); }
};

/// Accepts "drape" or "crumple"; throws std::invalid_argument for other names.
SearchScene make_scene(const std::string& kind, int size);

/// A copy of the surface, scaled by `scale` and placed beside it.
Surface tiny_copy(Surface s, double scale);

/// Computes end positions from start positions: a smooth flow plus slight noise, identical on every
/// mesh.
void move(SearchScene& scene, double speed, unsigned seed);

}  // namespace selvedge::bench
