// SPDX-License-Identifier: MIT
#include <selvedge/bodies/detail/mesh_source.h>
#include <selvedge/bodies/mesh_file.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge {
namespace {

/// Vertices that others may join, by cells of a lattice.
class JoinTargets {
 public:
  JoinTargets(const std::vector<Vec3>& x, double distance) : x_(x), distance_(distance) {}

  /// The nearest target of vertex v within the distance, the first of several; -1: none.
  std::int32_t nearest(std::int32_t v) const {
    std::int32_t best = -1;
    double square = distance_ * distance_;
    const Cell middle = cell_of(x_[v]);
    for (double i = -1.0; i <= 1.0; ++i)
      for (double j = -1.0; j <= 1.0; ++j)
        for (double k = -1.0; k <= 1.0; ++k) {
          const auto found = cells_.find({middle[0] + i, middle[1] + j, middle[2] + k});
          if (found == cells_.end()) continue;
          for (const std::int32_t w : found->second) {
            const double d = (x_[v] - x_[w]).squaredNorm();
            if (d > square || (d == square && best >= 0 && w > best)) continue;
            best = w;
            square = d;
          }
        }
    return best;
  }
  void add(std::int32_t v) { cells_[cell_of(x_[v])].push_back(v); }

 private:
  using Cell = std::array<double, 3>;

  Cell cell_of(const Vec3& x) const {
    return {std::floor(x.x() / distance_), std::floor(x.y() / distance_),
            std::floor(x.z() / distance_)};
  }

  const std::vector<Vec3>& x_;
  double distance_;
  std::map<Cell, std::vector<std::int32_t>> cells_;
};

}  // namespace

WeldReport weld_vertices(TriangleMesh& mesh, double distance) {
  if (!(distance > 0.0) || !std::isfinite(distance))
    throw std::invalid_argument("weld distance must be finite and > 0, is " +
                                std::to_string(distance));
  WeldReport report;
  report.vertices = mesh.vertices.size();
  JoinTargets targets(mesh.vertices, distance);
  std::vector<std::int32_t> target(mesh.vertices.size());
  for (std::size_t i = 0; i < target.size(); ++i) {
    const auto v = static_cast<std::int32_t>(i);
    const std::int32_t other = targets.nearest(v);
    target[i] = other < 0 ? v : other;
    if (other < 0) {
      targets.add(v);
      continue;
    }
    ++report.joined;
    report.farthest = std::max(report.farthest, (mesh.vertices[i] - mesh.vertices[other]).norm());
  }
  for (Triangle& t : mesh.triangles)
    for (std::int32_t& v : t) v = target[v];
  report.collapsed = std::erase_if(mesh.triangles, [](const Triangle& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  });
  detail::drop_unused_vertices(mesh);
  return report;
}

}  // namespace selvedge
