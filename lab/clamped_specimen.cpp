// SPDX-License-Identifier: MIT
//
// Equilibria are found by Newton's method on the energy with the positive part of its Jacobian and
// a line search.
#include <selvedge/core/cloth/force.h>
#include <selvedge/lab/detail/clamped_specimen.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace selvedge::detail {
namespace {

// -- equilibrium ----------------------------------------------------------------------------------

/// Finds equilibria of a cloth whose coordinates are partly prescribed.
class Equilibrium {
 public:
  Equilibrium(const ClothMesh& cloth, std::vector<char> fixed)
      : forces_(make_internal_forces(cloth), cloth.mass.size()),
        mass_(cloth.mass),
        still_(cloth.mass.size(), Vec3::Zero()),
        fixed_(std::move(fixed)),
        place_(fixed_.size(), -1) {
    std::vector<Edge> links;
    for (const auto& force : forces_.members()) force->add_links(links);
    matrix_ = BlockMatrix(mass_.size(), std::move(links));
    for (const auto& force : forces_.members()) force->bind(matrix_);
    for (std::size_t c = 0; c < fixed_.size(); ++c)
      if (fixed_[c] == 0) place_[c] = free_++;
  }

  /// Moves the free coordinates of `x` to equilibrium and returns the forces there.
  std::vector<Vec3> solve(std::vector<Vec3>& x) {
    constexpr int most = 400;
    constexpr double small = 1e-6;  // of the largest force on a held particle
    std::vector<Vec3> f(x.size());
    for (int k = 0; k < most; ++k) {
      forces_.evaluate(state(x), f);
      const Eigen::VectorXd out = out_of_balance(f);
      double held = 0.0;
      for (std::size_t c = 0; c < fixed_.size(); ++c)
        if (fixed_[c] != 0) held = std::max(held, std::abs(f[c / 3][c % 3]));
      if (out.lpNorm<Eigen::Infinity>() <= small * held || out.isZero(0.0)) return f;
      if (!descend(x, direction(x, out), out)) {
        if (out.lpNorm<Eigen::Infinity>() <= 1e-5 * held) return f;  // as far as rounding allows
        break;
      }
    }
    throw std::runtime_error(
        "swatch: a step of the test found no equilibrium; take smaller steps of strain");
  }

 private:
  ForceState state(const std::vector<Vec3>& x) const { return {x, still_, mass_, 0.0}; }

  Eigen::VectorXd out_of_balance(const std::vector<Vec3>& f) const {
    Eigen::VectorXd out(free_);
    for (std::size_t c = 0; c < fixed_.size(); ++c)
      if (place_[c] >= 0) out[place_[c]] = f[c / 3][c % 3];
    return out;
  }

  Eigen::VectorXd direction(const std::vector<Vec3>& x, const Eigen::VectorXd& out) {
    matrix_.set_zero();
    for (const auto& force : forces_.members()) force->add_jacobian(state(x), 1.0, matrix_);
    std::vector<Eigen::Triplet<double>> entries;
    const auto begin = matrix_.row_begin();
    double largest = 0.0;
    for (std::size_t i = 0; i < mass_.size(); ++i)
      for (std::int32_t b = begin[i]; b < begin[i + 1]; ++b)
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) {
            const auto row = place_[3 * i + r], column = place_[3 * matrix_.columns()[b] + c];
            if (row < 0 || column > row || column < 0) continue;
            entries.emplace_back(row, column, matrix_.values()[b](r, c));
            if (row == column) largest = std::max(largest, entries.back().value());
          }
    // Motions without energy, such as turning the end of a yarn about its axis, get this much.
    constexpr double prop = 1e-10;
    for (int c = 0; c < free_; ++c) entries.emplace_back(c, c, prop * largest);
    Eigen::SparseMatrix<double> a(free_, free_);
    a.setFromTriplets(entries.begin(), entries.end());
    if (!analyzed_) solver_.analyzePattern(a);
    analyzed_ = true;
    solver_.factorize(a);
    return solver_.solve(out);
  }

  /// Goes along `step` until energy is lost. False if that is below rounding.
  bool descend(std::vector<Vec3>& x, const Eigen::VectorXd& step, const Eigen::VectorXd& out) {
    constexpr double gain = 1e-4, least = 1e-8;
    const double before = forces_.energy(state(x)), slope = out.dot(step);
    const double rounding = 1e-13 * before;
    std::vector<Vec3> there = x;
    for (double share = 1.0; share > least; share *= 0.5) {
      for (std::size_t c = 0; c < fixed_.size(); ++c)
        if (place_[c] >= 0) there[c / 3][c % 3] = x[c / 3][c % 3] + share * step[place_[c]];
      if (forces_.energy(state(there)) > before - gain * share * slope + rounding) continue;
      x = there;
      return true;
    }
    return false;
  }

  ForceSum forces_;
  std::vector<double> mass_;
  std::vector<Vec3> still_;
  std::vector<char> fixed_;  // of each coordinate
  std::vector<int> place_;   // of each coordinate among the free ones, or -1
  int free_ = 0;
  BlockMatrix matrix_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
  bool analyzed_ = false;
};

/// A coordinate system along the pull.
std::vector<Vec3> turned(const std::vector<Vec3>& x, const Vec3& along, const Vec3& across) {
  std::vector<Vec3> out;
  for (const Vec3& p : x) out.push_back({p.dot(along), p.dot(across), p.z()});
  return out;
}

/// The particle nearest to the middle.
std::size_t middle_of(const std::vector<Vec3>& x) {
  std::size_t anchor = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (x[i].squaredNorm() < x[anchor].squaredNorm()) anchor = i;
  return anchor;
}

/// A test of a specimen: the coordinates that the clamps prescribe, and how far they move them.
class ClampedSpecimen {
 public:
  ClampedSpecimen(Specimen specimen, Clamps clamps)
      : specimen_(std::move(specimen)), sheared_(clamps == Clamps::frame) {
    std::vector<Vec3>& x = specimen_.cloth.surface.vertices;
    x = turned(x, specimen_.along, specimen_.across);
    fixed_.assign(3 * x.size(), 0);
    if (sheared_)
      hold_frame();
    else
      hold_ends(clamps == Clamps::flat_ends);
  }

  const Specimen& specimen() const { return specimen_; }
  const std::vector<char>& fixed() const { return fixed_; }
  const std::vector<Vec3>& rest() const { return specimen_.cloth.surface.vertices; }

  /// Moves the prescribed coordinates, and the others by a guess.
  void move(std::vector<Vec3>& x, double before, double now) const {
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Vec3 guess = (now - before) * (sheared_ ? rate(i, now) : Vec3(rest()[i].x(), 0.0, 0.0));
      const Vec3 place =
          sheared_ ? turned_frame(rest()[i], now) : Vec3(rest()[i] + now * rate(i, now));
      for (int c = 0; c < 3; ++c) x[i][c] = fixed_[3 * i + c] != 0 ? place[c] : x[i][c] + guess[c];
    }
  }

  /// The state in which the clamps feel the forces `f` of the cloth.
  SwatchPoint measure(double size, const std::vector<Vec3>& x, const std::vector<Vec3>& f) const {
    SwatchPoint point;
    double work = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (std::abs(rest()[i].y()) > specimen_.middle) continue;
      const Vec3 moved = rate(i, size);
      for (int c = 0; c < 3; ++c)
        if (fixed_[3 * i + c] != 0) work -= f[i][c] * moved[c];
    }
    point.force = work / (specimen_.length * specimen_.width);
    point.strain = sheared_ ? size : gauge_strain(x, 0);
    point.contraction = sheared_ ? 0.0 : -gauge_strain(x, 1);
    return point;
  }

 private:
  /// Two ends are pulled apart; the grips let the specimen contract across.
  void hold_ends(bool flat) {
    const double edge = 0.5 * specimen_.length - specimen_.grip;
    for (std::size_t i = 0; i < rest().size(); ++i) {
      const Vec3& x = rest()[i];
      const bool is_flat = flat || std::abs(x.x()) > edge;
      if (is_flat && i < specimen_.surface) fixed_[3 * i + 2] = 1;
      if (std::abs(x.x()) <= edge) continue;
      fixed_[3 * i] = 1;
    }
    fixed_[3 * middle_of(rest()) + 1] = 1;  // keeps the specimen from drifting across
  }

  /// All four sides turn like a frame with hinged corners, and the ends of the yarns with them.
  void hold_frame() {
    const auto [edge_x, edge_y] = specimen_.frame;
    for (std::size_t i = 0; i < rest().size(); ++i) {
      const Vec3& x = rest()[i];
      if (i < specimen_.surface) fixed_[3 * i + 2] = 1;
      if (std::abs(x.x()) <= edge_x && std::abs(x.y()) <= edge_y) continue;
      fixed_[3 * i] = fixed_[3 * i + 1] = 1;
    }
  }

  /// Place of a point when both yarns have turned towards each other by half the angle.
  static Vec3 turned_frame(const Vec3& x, double angle) {
    const double c = std::cos(0.5 * angle), s = std::sin(0.5 * angle);
    return {c * x.x() + s * x.y(), s * x.x() + c * x.y(), x.z()};
  }

  /// Motion of a clamp at particle i, m per strain or radian.
  Vec3 rate(std::size_t i, double size) const {
    const Vec3& x = rest()[i];
    if (!sheared_) return {std::copysign(0.5 * specimen_.length, x.x()), 0.0, 0.0};
    const double c = std::cos(0.5 * size), s = std::sin(0.5 * size);
    return 0.5 * Vec3(c * x.y() - s * x.x(), c * x.x() - s * x.y(), 0.0);
  }

  /// Slope of a coordinate over that at rest, for the surface in the middle third, less 1.
  double gauge_strain(const std::vector<Vec3>& x, int axis) const {
    const double reach = specimen_.length / 6.0;
    double top = 0.0, bottom = 0.0;
    for (std::size_t i = 0; i < specimen_.surface; ++i) {
      const Vec3& place = rest()[i];
      if (std::abs(place.x()) > reach || std::abs(place.y()) > reach) continue;
      top += place[axis] * x[i][axis];
      bottom += place[axis] * place[axis];
    }
    return top / bottom - 1.0;
  }

  Specimen specimen_;
  bool sheared_;
  std::vector<char> fixed_;
};

}  // namespace

std::vector<SwatchPoint> pull_specimen(Specimen specimen, Clamps clamps, double strain,
                                       std::int32_t points, std::vector<Vec3>* last) {
  const ClampedSpecimen clamped(std::move(specimen), clamps);
  Equilibrium equilibrium(clamped.specimen().cloth, clamped.fixed());
  std::vector<Vec3> x = clamped.rest();
  std::vector<SwatchPoint> curve{SwatchPoint{}};
  for (std::int32_t k = 1; k <= points; ++k) {
    const double now = strain * k / points;
    clamped.move(x, strain * (k - 1) / points, now);
    const std::vector<Vec3> f = equilibrium.solve(x);
    curve.push_back(clamped.measure(now, x, f));
  }
  if (last != nullptr) *last = std::move(x);
  return curve;
}

}  // namespace selvedge::detail
