// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/garment/sewing_pattern.h>

#include <string>
#include <vector>

namespace selvedge::detail {

/// Edges that are much shorter than the triangles of a mesh. Each run of such edges becomes one
/// vertex of the mesh, in the middle of the run.
class ShortEdges {
 public:
  /// Joins nothing.
  explicit ShortEdges(const SewingPattern& pattern);
  /// Joins edges from the shortest on, while the run to which an edge belongs stays below a fifth
  /// of `edge_length` (m). The two edges of a stitch are joined both or not at all, and each panel
  /// keeps three edges.
  ShortEdges(const SewingPattern& pattern, double edge_length);

  bool any() const;
  bool is_joined(std::int32_t panel, std::int32_t edge) const { return joined_[panel][edge] != 0; }
  /// Divides an edge that is not joined, as divide_edge does; ends in runs are those of the mesh.
  std::vector<Vec2> divide(std::int32_t panel, std::int32_t edge, std::int32_t pieces) const;
  /// A sentence for each panel with joined edges.
  std::vector<std::string> notes() const;

 private:
  std::int32_t around(std::int32_t panel, std::int32_t edge) const;
  double run_length(std::int32_t panel, std::int32_t edge, std::int32_t step) const;
  bool can_join(std::int32_t panel, std::int32_t edge) const;
  Vec2 corner(std::int32_t panel, std::int32_t edge) const;

  const SewingPattern& pattern_;
  double longest_ = 0.0;                     // m, of a run
  std::vector<std::vector<double>> length_;  // m, per panel and edge
  std::vector<std::vector<char>> joined_;    // per panel and edge
  std::vector<std::int32_t> kept_;           // edges per panel that are not joined
};

}  // namespace selvedge::detail
