// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <vector>

namespace selvedge::detail {

/// Winding numbers of points about a surface, within 0.02: its solid angle as seen from the point
/// over 4π. Of a closed surface it is 0 outside, 1 inside, and 2 where two parts of it overlap. A
/// query takes time proportional to the logarithm of the number of triangles.
class WindingNumber {
 public:
  /// This is a view: its creator keeps the surface alive.
  explicit WindingNumber(const TriangleMesh& body);
  double at(const Vec3& point) const;

 private:
  struct Cluster {
    std::int32_t first = 0, end = 0;  // of order_
    std::int32_t second = 0;          // second half; the first one follows the cluster; 0: a leaf
    Vec3 middle = Vec3::Zero();       // m, by area
    Vec3 area = Vec3::Zero();         // m², the sum of the area vectors
    double radius = 0.0;              // m, about the middle
  };
  std::int32_t build(std::int32_t first, std::int32_t end);

  const TriangleMesh& body_;
  std::vector<std::int32_t> order_;  // triangles
  std::vector<Cluster> clusters_;
};

}  // namespace selvedge::detail
