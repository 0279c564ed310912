// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/dress/detail/deformation.h>
#include <selvedge/dress/detail/dressing.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace selvedge::detail {
namespace {

constexpr double kOneDirection = 0.3;  // of seams: difference of the moments over their sum
constexpr double kUpright = 0.7;       // cosine of an axis from the vertical
constexpr double kSameTop = 0.05;      // m, between the tops of panels that hang side by side
constexpr double kSeamGap = 0.03;      // m, above which panels were drawn apart

class PanelPlaces {
 public:
  PanelPlaces(const Garment& start, std::size_t panels)
      : start_(start), places_(panels), panel_of_(start.flat.vertices.size(), -1) {
    for (std::size_t i = 0; i < start.flat.triangles.size(); ++i)
      for (const std::int32_t v : start.flat.triangles[i])
        panel_of_[v] = start.panel_of_triangle[i];
  }

  std::vector<PanelPlace> find(double neck) {
    find_axes();
    std::vector<char> is_placed = roots(neck);
    for (int next = best_next(is_placed); next >= 0; next = best_next(is_placed)) {
      const auto p = static_cast<std::size_t>(next);
      const Vec3& axis = places_[p].axis;
      const double gap = axis.dot(mean_gap(next, is_placed));
      if (std::abs(gap) > kSeamGap) places_[p].shift = gap * axis;
      is_placed[p] = 1;
    }
    return std::move(places_);
  }

 private:
  const Vec3& at(std::int32_t flat_vertex) const {
    return start_.surface.vertices[start_.corner[flat_vertex]];
  }

  void find_axes() {
    std::vector<Mat3> moment(places_.size(), Mat3::Zero());
    for (std::size_t s = 0; s < start_.stitches.size(); ++s) {
      if (!start_.is_chosen(s, SeamChoice::spanning)) continue;
      for (const std::vector<std::int32_t>* side : {&start_.stitches[s].a, &start_.stitches[s].b})
        for (std::size_t i = 1; i < side->size(); ++i) {
          const Vec3 way = at((*side)[i]) - at((*side)[i - 1]);
          if (!way.isZero(0.0)) moment[panel_of_[(*side)[i]]] += way * way.transpose() / way.norm();
        }
    }
    for (std::size_t p = 0; p < places_.size(); ++p)
      places_[p].axis = axis_of(moment[p], frame_of(static_cast<std::int32_t>(p)));
  }

  /// The axes of a panel's plane in space.
  Eigen::Matrix<double, 3, 2> frame_of(std::int32_t panel) const {
    for (std::size_t i = 0; i < start_.flat.triangles.size(); ++i)
      if (start_.panel_of_triangle[i] == panel)
        return deformation(start_.surface, start_.flat, i).gradient;
    return Eigen::Matrix<double, 3, 2>::Zero();
  }

  static Vec3 axis_of(const Mat3& moment, const Eigen::Matrix<double, 3, 2>& frame) {
    const Eigen::Matrix2d m = frame.transpose() * moment * frame;
    const double half = 0.5 * (m(0, 0) - m(1, 1)), sum = m(0, 0) + m(1, 1);
    if (elementary::hypot(half, m(0, 1)) > 0.5 * kOneDirection * sum) {
      const double angle = 0.5 * elementary::atan2(m(0, 1), half);
      return (frame * Eigen::Vector2d(elementary::cos(angle), elementary::sin(angle))).normalized();
    }
    // Upright in its plane; a panel that lies flat has no such direction.
    const Vec3 up = frame * (frame.transpose() * Vec3::UnitZ());
    return up.norm() > 0.5 ? up.normalized() : Vec3::Zero();
  }

  /// The highest panels around the trunk, which carry the others.
  std::vector<char> roots(double neck) const {
    std::vector<double> top(places_.size(), -std::numeric_limits<double>::infinity()),
        sum(top.size()), count(top.size());
    for (std::size_t v = 0; v < panel_of_.size(); ++v) {
      if (panel_of_[v] < 0) continue;
      const auto p = static_cast<std::size_t>(panel_of_[v]);
      const double z = at(static_cast<std::int32_t>(v)).z();
      top[p] = std::max(top[p], z);
      sum[p] += z;
      count[p] += 1.0;
    }
    double highest = -std::numeric_limits<double>::infinity();
    const auto can_carry = [&](std::size_t p) {
      return std::abs(places_[p].axis.z()) > kUpright && sum[p] < neck * count[p];
    };
    for (std::size_t p = 0; p < top.size(); ++p)
      if (can_carry(p)) highest = std::max(highest, top[p]);
    std::vector<char> is_root(top.size(), 0);
    for (std::size_t p = 0; p < top.size(); ++p)
      is_root[p] = can_carry(p) && top[p] > highest - kSameTop ? 1 : 0;
    return is_root;
  }

  /// Calls visit(a, b) for each pair of a stitch with a on the panel and b on a placed one.
  template <class Visit>
  void for_each_pair(std::int32_t panel, const std::vector<char>& is_placed, Visit&& visit) const {
    for (const Stitching& stitch : start_.stitches)
      for (std::size_t i = 0; i < stitch.a.size(); ++i)
        for (const auto& [own, other] :
             {std::pair(stitch.a[i], stitch.b[i]), {stitch.b[i], stitch.a[i]}})
          if (panel_of_[own] == panel && is_placed[panel_of_[other]]) visit(own, other);
  }

  /// The panel with the most pairs to those that are placed; -1: none has any.
  int best_next(const std::vector<char>& is_placed) const {
    int best = -1;
    std::size_t most = 0;
    for (std::size_t p = 0; p < places_.size(); ++p) {
      if (is_placed[p]) continue;
      std::size_t pairs = 0;
      for_each_pair(static_cast<std::int32_t>(p), is_placed,
                    [&](std::int32_t, std::int32_t) { ++pairs; });
      if (pairs <= most) continue;
      most = pairs;
      best = static_cast<int>(p);
    }
    return best;
  }

  Vec3 mean_gap(std::int32_t panel, const std::vector<char>& is_placed) const {
    Vec3 sum = Vec3::Zero();
    double count = 0.0;
    for_each_pair(panel, is_placed, [&](std::int32_t own, std::int32_t other) {
      sum += at(other) + places_[static_cast<std::size_t>(panel_of_[other])].shift - at(own);
      count += 1.0;
    });
    return sum / count;
  }

  const Garment& start_;
  std::vector<PanelPlace> places_;
  std::vector<std::int32_t> panel_of_;  // of each vertex of the flat pattern
};

}  // namespace

std::vector<PanelPlace> panel_places(const Garment& start, std::size_t panels, double neck) {
  return PanelPlaces(start, panels).find(neck);
}

}  // namespace selvedge::detail
