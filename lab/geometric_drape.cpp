// SPDX-License-Identifier: MIT
//
// A drape by geometry alone, after J. Weil, "The synthesis of cloth objects", Computer Graphics
// 1986, the geometric model that the survey's introduction names: catenaries between the held
// points, of crossing ones the upper; then catenaries from a corner of each triangle between them
// to the middle of its opposite side, until every point of the grid has a place; then a relaxation
// that moves every point towards the distances that it has from its neighbours in the flat cloth.
//
// Deviations: a triangle is always divided from the corner opposite its longest side, so that the
// result does not depend on the order of the corners. The paper places only points inside the
// convex hull of the held ones; here the others start straight below their nearest neighbour in the
// cloth.
#include <selvedge/core/base/internal/check.h>
#include <selvedge/lab/fabric_drape.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <optional>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

/// z > 0 with sinh(z)/z = ratio > 1, by bisection.
double inverse_sinhc(double ratio) {
  double low = 0.0, high = 1.0;
  while (std::sinh(high) < ratio * high) high *= 2.0;
  for (double middle = 0.5 * high; low < middle && middle < high; middle = 0.5 * (low + high))
    (std::sinh(middle) < ratio * middle ? low : high) = middle;
  return low;
}

/// The depth of a thread that hangs double from two points above each other, at the arc length s
/// from the first, below it.
double doubled_depth(double rise, double length, double s) {
  const double turn = 0.5 * (length - rise);  // arc length to the lowest point
  return s < turn ? s : 2.0 * turn - s;
}

}  // namespace

std::vector<Vec3> catenary(const Vec3& a, const Vec3& b, double length,
                           std::span<const double> arc) {
  require(std::isfinite(length) && length > 0.0, "length in m", length, "positive and finite");
  for (const double s : arc)
    require(s >= 0.0 && s <= length, "arc length in m", s, "on the thread");
  std::vector<Vec3> points;
  points.reserve(arc.size());
  const Vec3 along(b.x() - a.x(), b.y() - a.y(), 0.0);
  const double d = along.norm(), rise = b.z() - a.z();
  constexpr double taut = 1e-12, upright = 1e-9;  // relative to the length
  if (std::hypot(d, rise) >= length * (1.0 - taut)) {
    for (const double s : arc) points.push_back(a + (s / length) * (b - a));
    return points;
  }
  if (d <= upright * length) {
    for (const double s : arc)
      points.push_back(a + (s / length) * along - Vec3(0.0, 0.0, doubled_depth(rise, length, s)));
    return points;
  }
  // y = c cosh((x - x0)/c) + constant, with sinh(z)/z = √(L² - rise²)/d for z = d/(2c), and
  // rise/L = tanh of the middle's distance from x0, over c.
  const double z = inverse_sinhc(std::sqrt((length - rise) * (length + rise)) / d);
  const double c = 0.5 * d / z, x0 = 0.5 * d - c * std::atanh(rise / length);
  const double slope = std::sinh(-x0 / c), height = std::cosh(x0 / c);
  for (const double s : arc) {
    const double q = slope + s / c;  // slope of the thread at s
    const double x = x0 + c * std::asinh(q);
    points.push_back(a + (x / d) * along + Vec3(0.0, 0.0, c * (std::hypot(1.0, q) - height)));
  }
  return points;
}

std::vector<MethodOption> geometric_drape_options() {
  const GeometricDrapeConfig config;
  return {{.name = "tolerance",
           .initial = config.tolerance,
           .unit = "1",
           .least = 0.0,
           .most = 1.0,
           .above_least = true,
           .meaning = "motion of every vertex, in cell sides, below which the relaxation ends"},
          {.name = "most_sweeps",
           .initial = static_cast<double>(config.most_sweeps),
           .unit = "1",
           .least = 0.0,
           .most = 1e6,
           .kind = OptionKind::whole,
           .meaning = "sweeps of the relaxation; 0 leaves the catenaries as they are"}};
}

namespace {

using Place = std::array<std::int32_t, 2>;

/// Twice the area of a triangle of places, in cells; positive if it turns left.
std::int64_t turn(const Place& a, const Place& b, const Place& c) {
  return std::int64_t{b[0] - a[0]} * (c[1] - a[1]) - std::int64_t{b[1] - a[1]} * (c[0] - a[0]);
}

bool between(const Place& p, const Place& a, const Place& b) {
  return turn(a, b, p) == 0 && std::min(a[0], b[0]) <= p[0] && p[0] <= std::max(a[0], b[0]) &&
         std::min(a[1], b[1]) <= p[1] && p[1] <= std::max(a[1], b[1]) && p != a && p != b;
}

/// A grid whose vertices get their places one after the other.
class Hanging {
 public:
  Hanging(const GridConfig& grid, std::span<const HeldVertex> held)
      : grid_(grid),
        x_((grid.cells_x + std::size_t{1}) * (grid.cells_y + std::size_t{1})),
        held_(x_.size(), 0) {
    for (const HeldVertex& h : held) {
      const std::string name = "held vertex " + std::to_string(h.vertex);
      if (h.vertex < 0 || static_cast<std::size_t>(h.vertex) >= x_.size())
        throw std::invalid_argument(name + ": the grid has " + std::to_string(x_.size()));
      if (held_[h.vertex] != 0) throw std::invalid_argument(name + " is held twice");
      if (!h.x.allFinite()) throw std::invalid_argument(name + ": its place is not finite");
      x_[h.vertex] = h.x;
      held_[h.vertex] = 1;
      pins_.push_back(h.vertex);
    }
    if (pins_.size() < 2) throw std::invalid_argument("a drape needs two held vertices or more");
  }

  GeometricDrape drape(const GeometricDrapeConfig& config) {
    const std::vector<Edge> sides = curves_between_pins();
    for (const Edge& side : sides) trace(side[0], side[1]);
    for (const Triangle& t : triangles(sides)) divide(t);
    hang_the_others();
    GeometricDrape drape;
    drape.curves = curves_;
    drape.sweeps = relax(config);
    drape.shape = make_rectangular(grid_, {}).surface;
    for (std::size_t i = 0; i < x_.size(); ++i) drape.shape.vertices[i] = *x_[i];
    for (const Edge& link : links())
      drape.residual = std::max(drape.residual, std::abs(strain(link)));
    return drape;
  }

 private:
  std::int32_t index(std::int32_t i, std::int32_t j) const { return j * (grid_.cells_x + 1) + i; }
  Place place(std::int32_t v) const { return {v % (grid_.cells_x + 1), v / (grid_.cells_x + 1)}; }
  double side_x() const { return grid_.size_x / grid_.cells_x; }
  double side_y() const { return grid_.size_y / grid_.cells_y; }

  /// Distance in the flat cloth, m.
  double distance(std::int32_t a, std::int32_t b) const {
    const Place p = place(a), q = place(b);
    return std::hypot(side_x() * (q[0] - p[0]), side_y() * (q[1] - p[1]));
  }

  /// The vertices nearest to the line from a to b in the flat cloth, in order, with both ends. In
  /// integers, so that the line from b to a has the same ones.
  std::vector<std::int32_t> line(std::int32_t a, std::int32_t b) const {
    const Place p = place(a), q = place(b);
    const std::int64_t steps = std::max(std::abs(q[0] - p[0]), std::abs(q[1] - p[1]));
    const auto nearest = [&](int axis, std::int64_t k) {
      const std::int64_t sum = p[axis] * steps + k * (q[axis] - p[axis]);
      return static_cast<std::int32_t>((2 * sum + steps) / (2 * steps));
    };
    std::vector<std::int32_t> on;
    for (std::int64_t k = 0; k <= steps; ++k) on.push_back(index(nearest(0, k), nearest(1, k)));
    return on;
  }

  std::vector<Vec3> curve(std::int32_t a, std::int32_t b, std::size_t pieces) const {
    const double length = distance(a, b);
    std::vector<double> arc;
    for (std::size_t k = 0; k <= pieces; ++k)
      arc.push_back(
          std::min(length, length * static_cast<double>(k) / static_cast<double>(pieces)));
    return catenary(*x_[a], *x_[b], length, arc);
  }

  /// Places the vertices on the line from a to b. Of two curves through a vertex, the upper counts.
  void trace(std::int32_t a, std::int32_t b) {
    const std::vector<std::int32_t> on = line(a, b);
    if (on.size() < 3) return;
    ++curves_;
    const std::vector<Vec3> points = curve(a, b, on.size() - 1);
    for (std::size_t k = 1; k + 1 < on.size(); ++k) {
      std::optional<Vec3>& x = x_[on[k]];
      if (held_[on[k]] == 0 && (!x || points[k].z() > x->z())) x = points[k];
    }
  }

  // -- the curves between held vertices ---------------------------------------------------------

  bool cross(const Edge& one, const Edge& other) const {
    const Place a = place(one[0]), b = place(one[1]), c = place(other[0]), d = place(other[1]);
    return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
  }

  /// Height of the curve `one` where `other` crosses it.
  double height_at(const Edge& one, const Edge& other) const {
    const Place a = place(one[0]), b = place(one[1]), c = place(other[0]), d = place(other[1]);
    const auto from = static_cast<double>(turn(c, d, a)), to = static_cast<double>(turn(c, d, b));
    const double length = distance(one[0], one[1]), s = length * from / (from - to);
    return catenary(*x_[one[0]], *x_[one[1]], length, std::array{std::clamp(s, 0.0, length)})[0]
        .z();
  }

  /// A largest set of curves between held vertices that do not cross, the upper of two that do.
  std::vector<Edge> curves_between_pins() const {
    std::vector<Edge> all;
    for (std::size_t i = 0; i < pins_.size(); ++i)
      for (std::size_t j = i + 1; j < pins_.size(); ++j) {
        require_in_reach(pins_[i], pins_[j]);
        const Place a = place(pins_[i]), b = place(pins_[j]);
        if (std::none_of(pins_.begin(), pins_.end(),
                         [&](std::int32_t v) { return between(place(v), a, b); }))
          all.push_back({pins_[i], pins_[j]});
      }
    std::vector<char> lower(all.size(), 0);
    for (std::size_t k = 0; k < all.size(); ++k)
      for (std::size_t l = k + 1; l < all.size(); ++l)
        if (lower[k] == 0 && lower[l] == 0 && cross(all[k], all[l]))
          lower[height_at(all[k], all[l]) < height_at(all[l], all[k]) ? k : l] = 1;
    std::vector<Edge> kept;
    for (const char again : {0, 1})  // a lower one may be free after the removal of its rivals
      for (std::size_t k = 0; k < all.size(); ++k)
        if (lower[k] == again &&
            std::none_of(kept.begin(), kept.end(), [&](const Edge& e) { return cross(e, all[k]); }))
          kept.push_back(all[k]);
    return kept;
  }

  void require_in_reach(std::int32_t a, std::int32_t b) const {
    constexpr double rounding = 1e-9;
    const double apart = (*x_[b] - *x_[a]).norm(), cloth = distance(a, b);
    if (apart <= cloth * (1.0 + rounding)) return;
    throw std::invalid_argument("held vertices " + std::to_string(a) + " and " + std::to_string(b) +
                                " are " + std::to_string(apart) +
                                " m apart, but the cloth between " + "them is only " +
                                std::to_string(cloth) + " m long");
  }

  /// The triangles of three kept curves with no held vertex inside.
  std::vector<Triangle> triangles(const std::vector<Edge>& sides) const {
    const auto has = [&](std::int32_t a, std::int32_t b) {
      return std::any_of(sides.begin(), sides.end(), [&](const Edge& e) {
        return (e[0] == a && e[1] == b) || (e[0] == b && e[1] == a);
      });
    };
    std::vector<Triangle> all;
    for (std::size_t i = 0; i < pins_.size(); ++i)
      for (std::size_t j = i + 1; j < pins_.size(); ++j)
        for (std::size_t k = j + 1; k < pins_.size(); ++k) {
          const Triangle t{pins_[i], pins_[j], pins_[k]};
          if (has(t[0], t[1]) && has(t[1], t[2]) && has(t[0], t[2]) && empty(t)) all.push_back(t);
        }
    return all;
  }

  bool empty(const Triangle& t) const {
    const Place a = place(t[0]), b = place(t[1]), c = place(t[2]);
    const std::int64_t sign = turn(a, b, c) > 0 ? 1 : -1;
    return turn(a, b, c) != 0 && std::none_of(pins_.begin(), pins_.end(), [&](std::int32_t v) {
             const Place p = place(v);
             return sign * turn(a, b, p) > 0 && sign * turn(b, c, p) > 0 &&
                    sign * turn(c, a, p) > 0;
           });
  }

  /// Traces the curve from the corner opposite the longest side to its middle, and divides both
  /// halves.
  void divide(const Triangle& t) {
    int longest = 0;
    for (int k = 1; k < 3; ++k)
      if (distance(t[k], t[(k + 1) % 3]) > distance(t[longest], t[(longest + 1) % 3])) longest = k;
    const std::int32_t a = t[longest], b = t[(longest + 1) % 3], c = t[(longest + 2) % 3];
    const std::vector<std::int32_t> side = line(std::min(a, b), std::max(a, b));
    if (side.size() < 3) return;
    const std::int32_t middle = side[side.size() / 2];
    if (!x_[middle] || middle == c) return;
    trace(c, middle);
    divide({a, middle, c});
    divide({middle, b, c});
  }

  /// Places what no curve reached straight below the nearest neighbour along a side of a cell.
  void hang_the_others() {
    std::deque<std::int32_t> next;
    for (std::size_t v = 0; v < x_.size(); ++v)
      if (x_[v]) next.push_back(static_cast<std::int32_t>(v));
    for (; !next.empty(); next.pop_front())
      for_each_neighbour(next.front(), [&](std::int32_t w) {
        const Place p = place(next.front()), q = place(w);
        if (x_[w] || (p[0] != q[0] && p[1] != q[1])) return;
        x_[w] = *x_[next.front()] - Vec3(0.0, 0.0, distance(w, next.front()));
        next.push_back(w);
      });
  }

  // -- relaxation ---------------------------------------------------------------------------------

  void for_each_neighbour(std::int32_t v, auto&& visit) const {
    const Place p = place(v);
    for (std::int32_t j = std::max(0, p[1] - 1); j <= std::min(grid_.cells_y, p[1] + 1); ++j)
      for (std::int32_t i = std::max(0, p[0] - 1); i <= std::min(grid_.cells_x, p[0] + 1); ++i)
        if (const std::int32_t w = index(i, j); w != v) visit(w);
  }

  std::vector<Edge> links() const {
    std::vector<Edge> all;
    for (std::size_t v = 0; v < x_.size(); ++v)
      for_each_neighbour(static_cast<std::int32_t>(v), [&](std::int32_t w) {
        if (w > static_cast<std::int32_t>(v)) all.push_back({static_cast<std::int32_t>(v), w});
      });
    return all;
  }

  double strain(const Edge& e) const {
    return (*x_[e[1]] - *x_[e[0]]).norm() / distance(e[0], e[1]) - 1.0;
  }

  /// Moves each vertex by the mean of what its neighbours ask for, one after the other. Returns the
  /// number of sweeps.
  std::int32_t relax(const GeometricDrapeConfig& config) {
    const double enough = config.tolerance * std::min(side_x(), side_y());
    for (std::int32_t sweep = 0; sweep < config.most_sweeps; ++sweep) {
      double largest = 0.0;
      for (std::size_t v = 0; v < x_.size(); ++v)
        if (held_[v] == 0) largest = std::max(largest, settle(static_cast<std::int32_t>(v)));
      if (largest < enough) return sweep + 1;
    }
    return config.most_sweeps;
  }

  double settle(std::int32_t v) {
    Vec3 move = Vec3::Zero();
    int count = 0;
    for_each_neighbour(v, [&](std::int32_t w) {
      const Vec3 d = *x_[w] - *x_[v];
      const double length = d.norm();
      ++count;
      if (length > 0.0) move += (1.0 - distance(v, w) / length) * d;
    });
    move /= count;
    *x_[v] += move;
    return move.norm();
  }

  GridConfig grid_;
  std::vector<std::optional<Vec3>> x_;
  std::vector<char> held_;
  std::vector<std::int32_t> pins_;
  std::int32_t curves_ = 0;
};

}  // namespace

GeometricDrape drape_geometrically(const GridConfig& grid, std::span<const HeldVertex> held,
                                   const GeometricDrapeConfig& config) {
  require(config.tolerance > 0.0, "tolerance in cell sides", config.tolerance, "positive");
  require(config.most_sweeps >= 0, "most_sweeps", config.most_sweeps, "at least 0");
  make_rectangular(grid, {});  // refuses a grid without size or cells
  return Hanging(grid, held).drape(config);
}

}  // namespace selvedge
