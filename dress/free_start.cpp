// SPDX-License-Identifier: MIT
//
// A free start: panels that cross the body or each other are moved along the normals of their outer
// sides until an exact search finds no crossing.
#include <fmt/format.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/winding_number.h>
#include <selvedge/dress/dress.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

namespace selvedge {
namespace {

constexpr double kStep = 0.005;    // m, of one move
constexpr double kParallel = 0.9;  // cosine above which two panels face the same way

class FreeStart {
 public:
  FreeStart(GarmentMesh& garment, const TriangleMesh& body, double largest_move,
            std::span<const WornGarment> under, const std::function<void()>& round)
      : garment_(garment),
        body_(body),
        winding_(body),
        largest_move_(largest_move),
        under_(under),
        round_(round) {
    const std::size_t panels = garment.panel_names.size();
    for (std::size_t p = 0; p < panels; ++p) outward_.push_back(outward(p));
    moved_.assign(panels, 0.0);
  }

  std::vector<MovedPanel> find() {
    for (std::set<std::int32_t> panels = crossing(); !panels.empty(); panels = crossing()) {
      if (round_) round_();
      for (const std::int32_t p : panels) move(p);
    }
    std::vector<MovedPanel> list;
    for (std::size_t p = 0; p < moved_.size(); ++p)
      if (moved_[p] > 0.0) list.push_back({static_cast<std::int32_t>(p), moved_[p] * outward_[p]});
    return list;
  }

 private:
  std::span<Vec3> vertices(std::size_t p) {
    const auto first = static_cast<std::size_t>(garment_.first_vertex[p]),
               end = static_cast<std::size_t>(garment_.first_vertex[p + 1]);
    return std::span(garment_.placed).subspan(first, end - first);
  }

  /// The normal of the outer side of a panel. Its triangles are counter-clockwise there.
  Vec3 outward(std::size_t p) const {
    const Triangle& t = garment_.flat.triangles[garment_.first_triangle[p]];
    const std::vector<Vec3>& x = garment_.placed;
    return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).normalized();
  }

  void move(std::int32_t panel) {
    const auto p = static_cast<std::size_t>(panel);
    moved_[p] += kStep;
    if (moved_[p] > largest_move_)
      throw DressFailed(
          fmt::format("panel \"{}\" crosses the body, a garment or another panel, and moving it "
                      "outward by {:g} m does "
                      "not free it; place it farther from the body",
                      garment_.panel_names[p], largest_move_));
    for (Vec3& x : vertices(p)) x += kStep * outward_[p];
  }

  /// Panels to be moved, because they cross or touch something. Of two panels that cross each other
  /// and face the same way, the second one.
  std::set<std::int32_t> crossing() {
    const std::vector<Triangle>& triangles = garment_.flat.triangles;
    const auto panel = [&](std::int32_t t) { return garment_.panel_of_triangle[t]; };
    std::set<std::int32_t> found;
    for (const TrianglePair& pair :
         find_meetings({garment_.placed, triangles}, {body_.vertices, body_.triangles}).all())
      found.insert(panel(pair.triangle_a));
    for (const WornGarment& worn : under_)
      for (const TrianglePair& pair : find_meetings({garment_.placed, triangles},
                                                    {worn.surface.vertices, worn.surface.triangles})
                                          .all())
        found.insert(panel(pair.triangle_a));
    for (std::size_t p = 0; p < moved_.size(); ++p)
      if (!found.contains(static_cast<std::int32_t>(p)) &&
          std::abs(winding_.at(vertices(p).front())) > 0.5)
        found.insert(static_cast<std::int32_t>(p));
    for (const TrianglePair& pair : find_meetings(garment_.placed, triangles).all()) {
      const std::int32_t a = std::min(panel(pair.triangle_a), panel(pair.triangle_b)),
                         b = std::max(panel(pair.triangle_a), panel(pair.triangle_b));
      found.insert(b);
      if (outward_[a].dot(outward_[b]) < kParallel) found.insert(a);
    }
    return found;
  }

  GarmentMesh& garment_;
  const TriangleMesh& body_;
  detail::WindingNumber winding_;
  double largest_move_;
  std::span<const WornGarment> under_;
  const std::function<void()>& round_;
  std::vector<Vec3> outward_;
  std::vector<double> moved_;  // m
};

}  // namespace

std::vector<MovedPanel> find_free_start(GarmentMesh& garment, const TriangleMesh& body,
                                        double largest_move, std::span<const WornGarment> under,
                                        const std::function<void()>& round) {
  return FreeStart(garment, body, largest_move, under, round).find();
}

}  // namespace selvedge
