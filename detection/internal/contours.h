// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/detection/internal/joint_surface.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace selvedge {

/// An open or closed curve in which two sheets cross, as the list of edges that pass through a
/// triangle along it. Its two sides are the sheets, which may be parts of one surface.
struct Contour {
  std::vector<EdgeCrossing> nodes;
  std::vector<std::uint8_t> side;  ///< of the edge of each node, 0 or 1; its triangle: the other
};

/// Joins crossings into contours [BaraffWitkin2003, section 4]: two of them are neighbours if they
/// belong to the same pair of triangles. Crossings must be sorted; contours come in the order of
/// their first crossing. A contour that turns back through a vertex of both sheets keeps the side
/// on which it was found first.
std::vector<Contour> trace_contours(const JointSurface& surface,
                                    std::span<const EdgeCrossing> crossings);

/// Which vertices a contour cuts off, on each of its sides.
///
/// Deviation from [BaraffWitkin2003]: the paper floods the two sides of a closed contour and takes
/// the smaller. Here borders stop the flood as well, so that a contour from border to border cuts
/// off a region. One component of each connected part is kept: the largest that is not inside a
/// closed body. Every contour leads back to it, so that two contours in a row bring the cloth the
/// same way. The innermost vertex of that component identifies it later, so that two components of
/// about the same size do not change places.
class CutRegions {
 public:
  static constexpr std::int32_t kUnknown = -1;
  /// The value of `kept` that asks for another component than that of vertex v, if there is one.
  static constexpr std::int32_t not_that_of(std::int32_t v) { return -2 - v; }

  /// x in metres, joint vertices. `kept` has a vertex of the kept component for each connected
  /// part, or kUnknown; unknown ones are chosen where the part is cut.
  CutRegions(const JointSurface& surface, std::span<const Contour> contours,
             std::span<const Vec3> x, std::span<std::int32_t> kept);

  /// Whether the contour divides the surface on that side.
  bool divides(std::size_t contour, int side) const {
    return !cut_off_[2 * contour + static_cast<std::size_t>(side)].empty();
  }
  /// Whether vertex v lies in the region that the contour cuts off on that side.
  bool is_cut_off(std::size_t contour, int side, std::int32_t v) const;
  /// All vertices of that region, sorted.
  std::vector<std::int32_t> region(std::size_t contour, int side) const;

 private:
  void find_components();
  void find_roots(std::span<const Vec3> x, std::span<std::int32_t> kept);
  void choose_roots(std::span<const Vec3> x, std::span<const std::int32_t> kept);
  std::vector<std::int32_t> deepest() const;
  void find_regions(std::size_t labels);
  std::vector<char> reach(std::int32_t first, std::size_t barred) const;

  const JointSurface& surface_;
  // A label is 2 * contour + side.
  std::vector<std::vector<std::size_t>> labels_of_edge_;  // by index of cut_edges_
  std::vector<std::int32_t> cut_edges_;                   // sorted
  std::vector<std::int32_t> component_;             // of each vertex; -1: of no part that is cut
  std::vector<std::vector<std::int32_t>> members_;  // of each component
  std::vector<std::int32_t> part_of_component_;
  std::vector<std::int32_t> root_;          // of each part; -1: it is not cut
  std::vector<std::vector<char>> cut_off_;  // by label: components; empty: it does not divide
};

/// Triangles of all closed bodies of the surface.
std::vector<Triangle> closed_bodies(const JointSurface& surface);

/// Whether the closed surface of these triangles winds around p, by the sum of their solid angles
/// [VanOosterom1983]; not exact near the surface.
bool is_inside(std::span<const Vec3> x, std::span<const Triangle> closed, const Vec3& p);

}  // namespace selvedge
