// SPDX-License-Identifier: MIT
//
// Sections of meshes by planes, and the lengths of tapes around them.
#pragma once

#include <selvedge/core/base/types.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// A plane with coordinates in it, m.
class CutPlane {
 public:
  CutPlane(const Vec3& point, const Vec3& normal);  ///< any length of the normal but 0
  double height(const Vec3& x) const { return normal_.dot(x - point_); }
  Eigen::Vector2d flat(const Vec3& x) const;
  Vec3 in_space(const Eigen::Vector2d& p) const;
  const Vec3& point() const { return point_; }
  const Vec3& normal() const { return normal_; }

 private:
  Vec3 point_, normal_;
  std::array<Vec3, 2> axes_;
};

/// Where a plane cuts a mesh: one segment for each triangle that it cuts.
struct Section {
  /// Ends are points of edges of the mesh.
  struct Segment {
    std::size_t triangle = 0;
    std::array<Edge, 2> edge;
    std::array<double, 2> share;  ///< of the way from the first to the second vertex of the edge
  };
  /// Segments that hang together.
  struct Part {
    std::vector<Segment> segments;
    std::vector<Eigen::Vector2d> hull;                 ///< m, the convex hull, counter-clockwise
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();  ///< m, mean of the segments by length
    double length = 0.0;                               ///< m, of all segments
    double tape = 0.0;                                 ///< m, around the hull
    bool is_ring = false;  ///< each end of a segment is that of one other
  };
  std::vector<Part> parts;
};
Section section_of(const TriangleMesh& mesh, const CutPlane& plane);

/// The end of a segment, m.
Vec3 end_of(const TriangleMesh& mesh, const Section::Segment& segment, int end);
/// The length of segments in another mesh, m, such as the flat pattern: its triangle i corresponds
/// to triangle i of `mesh`.
double length_in(const TriangleMesh& other, const TriangleMesh& mesh,
                 std::span<const Section::Segment> segments);

/// Corners of the convex hull, counter-clockwise.
std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points);
bool contains(std::span<const Eigen::Vector2d> hull, const Eigen::Vector2d& p);
double around(std::span<const Eigen::Vector2d> loop);  ///< its length, m
/// Of a tape around all parts of a section whose middles lie in a convex loop, m; 0: there are
/// none.
double tape_inside(const Section& section, std::span<const Eigen::Vector2d> loop);

}  // namespace selvedge::detail
