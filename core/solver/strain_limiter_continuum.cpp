// SPDX-License-Identifier: MIT
//
// Strain limits of triangles after B. Thomaszewski, S. Pabst, W. Strasser, "Continuum-based strain
// limiting", 2009 [Thomaszewski2009]: each component of the strain of a triangle,
// along warp, along weft and in shear, has a limit of its own, and the vertices are moved until all
// triangles keep theirs. The deformation gradient F of a triangle has the columns f1 and f2, the
// images of the unit vectors of warp and weft:
//   F = Σ x_k b_kᵀ,  b_k: gradient of the shape function of corner k at rest
//   warp |f1| ≤ 1 + τ,  weft |f2| ≤ 1 + τ,  shear |½ f1·f2| ≤ τ + ½ τ²
// The shear is that of Green's strain ½(FᵀF - 1), whose stretches are at their limit τ + ½ τ² where
// |f| is 1 + τ. A component C beyond its limit moves the corners along its gradient,
//   x_k -= w_k ∇_k C (C - limit)/Σ w_j |∇_j C|²,  w: inverse mass,
// the least move, weighted by mass, that corrects it to first order (stretch: exactly). The
// gradients of a triangle sum to 0 and have no moment, since its strain is that of the turned and
// moved triangle too: momentum and angular momentum are kept, and rigid motion is free. Sweeps
// over the triangles, component after component, continue until the worst is within the tolerance.
//
// Guarantee: no triangle exceeds a limit by more than the tolerance after the sweeps, or they were
// used up; held particles may forbid it. Springs along warp and weft then keep their limit; on the
// bias, stretch and shear add up to a strain of sqrt(1 + 4 τ + 2 τ²) - 1 < 2 τ.
//
// Deviations: the paper was not at hand. That it limits the components apart is what later papers
// say of it; strain measure and correction are ours. The limiter knows springs, so the triangles
// are those that three springs enclose: on a grid with both diagonals four in each cell, on a
// triangular mesh its own. Springs over two cells enclose none. Triangles of the surface get warp
// and weft from the flat rest shape; all others, the longer leg of their widest angle as warp,
// which is a right angle on a grid. τ is the least limit of the three springs. `compression` also
// holds |f1| and |f2| above 1 - τ.
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/cloth/detail/coloring.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/solver/detail/register_limiter.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace selvedge {
namespace {

/// Springs this much longer than a path through a third particle, relatively, are over two cells.
constexpr double kStraight = 1e-6;

/// A side of a triangle as seen from one of its ends.
struct Side {
  std::int32_t to;
  double length;  // m, at rest
  std::size_t spring;
};

/// Three particles with the gradients of their shape functions, 1/m, along warp and weft.
struct LimitedTriangle {
  std::array<std::int32_t, 3> v;
  std::array<std::array<double, 2>, 3> b;
  double limit;  // τ
};

/// The springs at each particle, by the index of the other end.
class SpringGraph {
 public:
  SpringGraph(std::span<const Spring> springs, std::size_t particles) : sides_(particles) {
    for (std::size_t s = 0; s < springs.size(); ++s) {
      sides_[springs[s].a].push_back({springs[s].b, springs[s].rest_length, s});
      sides_[springs[s].b].push_back({springs[s].a, springs[s].rest_length, s});
    }
    for (std::vector<Side>& sides : sides_)
      std::sort(sides.begin(), sides.end(), [](const Side& l, const Side& r) {
        return std::pair(l.to, l.spring) < std::pair(r.to, r.spring);
      });
  }

  /// Calls visit(side from a, side from b) for each particle that springs join to both.
  void for_each_common(std::int32_t a, std::int32_t b, auto&& visit) const {
    auto i = sides_[a].begin(), j = sides_[b].begin();
    while (i != sides_[a].end() && j != sides_[b].end()) {
      if (i->to == j->to) visit(*i, *j);
      if (i->to <= j->to)
        ++i;
      else
        ++j;
    }
  }

  /// Whether the spring passes a particle that springs join to both of its ends.
  bool is_over_two_cells(const Spring& spring) const {
    bool passes = false;
    for_each_common(spring.a, spring.b, [&](const Side& p, const Side& q) {
      passes = passes || p.length + q.length < (1.0 + kStraight) * spring.rest_length;
    });
    return passes;
  }

 private:
  std::vector<std::vector<Side>> sides_;
};

/// Corner v[0] of a triangle with its sides: warp to v[1], the other leg to v[2], the third between
/// them.
struct Corner {
  std::array<std::int32_t, 3> v;
  double warp, leg, third;  // m, at rest
  double cosine() const { return (warp * warp + leg * leg - third * third) / (2.0 * warp * leg); }
};

/// Its gradients for corners at these places along warp and weft; false if they enclose no area.
bool set_gradients(LimitedTriangle& t, const std::array<Vec3, 3>& place) {
  const Vec3 a = place[1] - place[0], b = place[2] - place[0];
  const double area = a.x() * b.y() - a.y() * b.x();
  if (!(std::abs(area) > kStraight * std::max(a.squaredNorm(), b.squaredNorm()))) return false;
  t.b[1] = {b.y() / area, -b.x() / area};
  t.b[2] = {-a.y() / area, a.x() / area};
  t.b[0] = {-t.b[1][0] - t.b[2][0], -t.b[1][1] - t.b[2][1]};
  return true;
}

/// The triangle in the frame of this corner; none if it has no area.
std::optional<LimitedTriangle> in_frame(const Corner& c, double limit) {
  const double cosine = c.cosine(), sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  LimitedTriangle t{.v = c.v, .b = {}, .limit = limit};
  const Vec3 leg(c.leg * cosine, c.leg * sine, 0.0);
  if (!set_gradients(t, {Vec3::Zero(), Vec3(c.warp, 0.0, 0.0), leg})) return std::nullopt;
  return t;
}

/// The frame at the corner with the widest angle, whose longer leg is warp.
std::optional<LimitedTriangle> with_warp(const std::array<std::int32_t, 3>& v,
                                         const std::array<double, 3>& side, double limit) {
  // side[k] lies opposite to v[k].
  const auto widest = static_cast<int>(std::max_element(side.begin(), side.end()) - side.begin());
  int p = (widest + 1) % 3, q = (widest + 2) % 3;
  if (side[q] < side[p]) std::swap(p, q);  // the side to p lies opposite to q
  return in_frame(
      {.v = {v[widest], v[p], v[q]}, .warp = side[q], .leg = side[p], .third = side[widest]},
      limit);
}

std::vector<LimitedTriangle> triangles_of(std::span<const Spring> springs,
                                          std::span<const double> limits, std::size_t particles) {
  const SpringGraph all(springs, particles);
  std::vector<Spring> sides;
  std::vector<double> limit;
  for (std::size_t s = 0; s < springs.size(); ++s)
    if (!all.is_over_two_cells(springs[s])) {
      sides.push_back(springs[s]);
      limit.push_back(limits[s]);
    }
  const SpringGraph graph(sides, particles);
  std::vector<LimitedTriangle> triangles;
  for (std::size_t s = 0; s < sides.size(); ++s) {
    const std::int32_t a = std::min(sides[s].a, sides[s].b), b = std::max(sides[s].a, sides[s].b);
    graph.for_each_common(a, b, [&](const Side& from_a, const Side& from_b) {
      if (from_a.to <= b) return;  // once, from its first two particles
      if (const auto t =
              with_warp({a, b, from_a.to}, {from_b.length, from_a.length, sides[s].rest_length},
                        std::min({limit[from_a.spring], limit[from_b.spring], limit[s]})))
        triangles.push_back(*t);
    });
  }
  return triangles;
}

class ContinuumLimiter final : public StrainLimitMethod {
 public:
  ContinuumLimiter(std::span<const Spring> springs, std::span<const double> limits,
                   std::size_t particles, LimitedStrain limited)
      : springs_(springs, limits, particles, limited) {
    const std::vector<LimitedTriangle> found = triangles_of(springs, limits, particles);
    std::vector<std::int32_t> corners;
    for (const LimitedTriangle& t : found) corners.insert(corners.end(), t.v.begin(), t.v.end());
    detail::Coloring coloring = detail::color_elements(corners, 3, particles);
    for (const std::int32_t t : coloring.order) triangles_.push_back(found[t]);
    color_begin_ = std::move(coloring.color_begin);
    worst_.resize(triangles_.size() / detail::kColorChunk + 1);
  }

  LimiterTraits traits() const override {
    return {.promise =
                "bounds the strain of triangles along warp, along weft and in shear; springs "
                "on the bias may stretch twice as far; keeps momentum",
            .source = "Thomaszewski, Pabst, Strasser, Continuum-based strain limiting, 2009",
            .of_springs = false};
  }
  const StrainLimiter* limiter() const override { return &springs_; }

  void set_directions(std::span<const Triangle> triangles, const TriangleMesh& rest) override {
    if (!detail::in_a_level(rest.vertices)) return;
    std::map<std::array<std::int32_t, 3>, std::size_t> with_vertices;
    for (std::size_t i = 0; i < triangles_.size(); ++i)
      with_vertices.emplace(sorted(triangles_[i].v), i);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const std::array<std::int32_t, 3> v{triangles[i][0], triangles[i][1], triangles[i][2]};
      const auto found = with_vertices.find(sorted(v));
      if (found == with_vertices.end()) continue;  // not all of its sides are springs
      const Triangle& flat = rest.triangles[i];
      LimitedTriangle turned{.v = v, .b = {}, .limit = triangles_[found->second].limit};
      if (set_gradients(turned,
                        {rest.vertices[flat[0]], rest.vertices[flat[1]], rest.vertices[flat[2]]}))
        triangles_[found->second] = turned;
    }
  }

  void find_held(std::span<const Vec3> x, double tolerance,
                 std::vector<HeldStrain>& out) const override {
    for (const LimitedTriangle& t : triangles_) {
      const std::array<Vec3, 2> f{column(t, 0, x), column(t, 1, x)};
      for (int c = 0; c < 2; ++c) {
        const double length = f[c].norm();
        if (!(length > 0.0)) continue;  // without a direction
        const std::array<Vec3, 3> gradient = gradient_of_stretch(t, c, f[c] / length);
        if (length - 1.0 > t.limit - tolerance) out.push_back(pull(t, gradient, 1.0));
        if (springs_.limits_compression() && 1.0 - length > t.limit - tolerance)
          out.push_back(pull(t, gradient, -1.0));
      }
      const double strain = 0.5 * f[0].dot(f[1]);
      if (std::abs(strain) > most_shear(t) - tolerance)
        out.push_back(pull(t, gradient_of_shear(t, f[0], f[1]), strain > 0.0 ? 1.0 : -1.0));
    }
  }

  std::optional<LimitedValue> worst(std::span<const Vec3> x) const override {
    LimitedValue worst{-1.0, 0.0};
    for (const LimitedTriangle& t : triangles_)
      for (int c = 0; c < 3; ++c)
        if (const double e = std::abs(excess(t, c, x).value); e > worst.strain - worst.limit)
          worst = {t.limit + e, t.limit};
    return worst;
  }

  StrainReport limit_ends(const LimitStep& step, std::span<Vec3> x_t1) override {
    int sweeps = 0;
    double most = largest_excess(x_t1);
    while (most > step.tolerance && sweeps < step.max_sweeps) {
      ++sweeps;
      most = sweep(step, x_t1);
      if (most <= step.tolerance) most = largest_excess(x_t1);
    }
    StrainReport report = springs_.measure(x_t1);
    report.sweeps = sweeps;
    return report;
  }

 private:
  static std::array<std::int32_t, 3> sorted(std::array<std::int32_t, 3> v) {
    std::sort(v.begin(), v.end());
    return v;
  }

  /// By how much a component exceeds its limit, negative where it is too small; 0: it does not. Its
  /// gradients at the corners, 1/m, if it does.
  struct Excess {
    double value = 0.0;
    std::array<Vec3, 3> gradient;
  };

  /// Brings a component to its limit, to first order.
  static void correct(const LimitedTriangle& t, const Excess& e, std::span<const double> inv_mass,
                      std::span<Vec3> x) {
    double yielding = 0.0;
    for (int k = 0; k < 3; ++k) yielding += inv_mass[t.v[k]] * e.gradient[k].squaredNorm();
    if (yielding <= 0.0) return;
    for (int k = 0; k < 3; ++k)
      x[t.v[k]] -= (inv_mass[t.v[k]] * e.value / yielding) * e.gradient[k];
  }

  /// Forces against the growth of a component, or against its decrease if `sign` is -1.
  static HeldStrain pull(const LimitedTriangle& t, const std::array<Vec3, 3>& gradient,
                         double sign) {
    return {t.v, {-sign * gradient[0], -sign * gradient[1], -sign * gradient[2]}, 3};
  }

  static std::array<Vec3, 3> gradient_of_stretch(const LimitedTriangle& t, int c, const Vec3& n) {
    return {t.b[0][c] * n, t.b[1][c] * n, t.b[2][c] * n};
  }
  static std::array<Vec3, 3> gradient_of_shear(const LimitedTriangle& t, const Vec3& warp,
                                               const Vec3& weft) {
    std::array<Vec3, 3> gradient;
    for (int k = 0; k < 3; ++k) gradient[k] = 0.5 * (t.b[k][0] * weft + t.b[k][1] * warp);
    return gradient;
  }
  /// Of Green's strain, where the stretch is at the same limit.
  static double most_shear(const LimitedTriangle& t) { return t.limit * (1.0 + 0.5 * t.limit); }

  static Vec3 column(const LimitedTriangle& t, int c, std::span<const Vec3> x) {
    // Differences, so that a far place loses no digits.
    return t.b[1][c] * (x[t.v[1]] - x[t.v[0]]) + t.b[2][c] * (x[t.v[2]] - x[t.v[0]]);
  }

  /// Of the stretch along warp (0) or weft (1), or of the shear (2).
  Excess excess(const LimitedTriangle& t, int component, std::span<const Vec3> x) const {
    return component < 2 ? excess_of_stretch(t, component, x) : excess_of_shear(t, x);
  }

  Excess excess_of_stretch(const LimitedTriangle& t, int c, std::span<const Vec3> x) const {
    const Vec3 f = column(t, c, x);
    const double squared = f.squaredNorm(), longest = 1.0 + t.limit;
    const double shortest = springs_.limits_compression() ? std::max(0.0, 1.0 - t.limit) : 0.0;
    if (squared <= longest * longest && squared >= shortest * shortest) return {};
    const double length = std::sqrt(squared);
    if (!(length > 0.0)) return {};  // without a direction
    return {length - std::clamp(length, shortest, longest), gradient_of_stretch(t, c, f / length)};
  }

  static Excess excess_of_shear(const LimitedTriangle& t, std::span<const Vec3> x) {
    const Vec3 warp = column(t, 0, x), weft = column(t, 1, x);
    const double most = most_shear(t), strain = 0.5 * warp.dot(weft);
    if (std::abs(strain) <= most) return {};
    return {strain - std::clamp(strain, -most, most), gradient_of_shear(t, warp, weft)};
  }

  double largest_excess(std::span<const Vec3> x) const {
    const LimitedValue most = *worst(x);
    return most.strain - most.limit;
  }

  /// Corrects every triangle; returns the largest excess before.
  double sweep(const LimitStep& step, std::span<Vec3> x) {
    std::fill(worst_.begin(), worst_.end(), 0.0);
    detail::for_each_color(color_begin_, [&](std::size_t begin, std::size_t end) {
      double& most = worst_[begin / detail::kColorChunk];  // one for each chunk of a colour
      for (std::size_t i = begin; i < end; ++i)
        for (int c = 0; c < 3; ++c) {
          const Excess e = excess(triangles_[i], c, x);
          if (e.value == 0.0) continue;
          most = std::max(most, std::abs(e.value));
          correct(triangles_[i], e, step.inv_mass, x);
        }
    });
    return *std::max_element(worst_.begin(), worst_.end());
  }

  StrainLimiter springs_;
  std::vector<LimitedTriangle> triangles_;  // sorted by colour
  std::vector<std::size_t> color_begin_;
  std::vector<double> worst_;
};

}  // namespace

void register_continuum_limiter(StrainLimiterRegistry& registry) {
  detail::register_method(registry, "continuum",
                          [](std::span<const Spring> s, std::span<const double> l, std::size_t n,
                             LimitedStrain limited) -> std::unique_ptr<StrainLimitMethod> {
                            return std::make_unique<ContinuumLimiter>(s, l, n, limited);
                          });
}

}  // namespace selvedge
