// SPDX-License-Identifier: MIT
//
// Measured curves as monotone piecewise cubics after F. N. Fritsch, R. E. Carlson, "Monotone
// piecewise cubic interpolation", SIAM Journal on Numerical Analysis 17(2), 1980. On the piece
// between two points, with t = (x - x0)/h in [0, 1], secant δ = (y1 - y0)/h and slopes d0, d1,
//   y = y0 + h [d0 t + (3 δ - 2 d0 - d1) t² + (d0 + d1 - 2 δ) t³].
// The slopes start as the means of the neighbouring secants (at the ends as the secant). Where
// (d0/δ)² + (d1/δ)² > 9, both are scaled back to that circle, inside which the piece is monotone.
// The circle meets the border of the monotone region only where a slope is 0, so with rising data
// the curve has a positive slope everywhere.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace selvedge {
namespace {

std::string curve_point(std::size_t i, const std::vector<double>& x, const std::vector<double>& y) {
  return "point " + std::to_string(i) + " (" + std::to_string(x[i]) + ", " + std::to_string(y[i]) +
         ")";
}

void require_rising(const std::vector<double>& x, const std::vector<double>& y) {
  if (x.size() != y.size())
    throw std::invalid_argument("a measured curve needs as many values as arguments, not " +
                                std::to_string(y.size()) + " for " + std::to_string(x.size()));
  if (x.size() < 2) throw std::invalid_argument("a measured curve needs at least two points");
  if (x[0] != 0.0 || y[0] != 0.0)
    throw std::invalid_argument("a measured curve must begin at (0, 0), not at " +
                                curve_point(0, x, y));
  for (std::size_t i = 1; i < x.size(); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i]))
      throw std::invalid_argument("a measured curve has a number that is not finite at " +
                                  curve_point(i, x, y));
    if (!(x[i] > x[i - 1]) || !(y[i] > y[i - 1]))
      throw std::invalid_argument("a measured curve must rise from each point to the next, but " +
                                  curve_point(i, x, y) +
                                  " does not; leave it out or average the readings");
  }
}

std::vector<double> monotone_slopes(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t pieces = x.size() - 1;
  std::vector<double> secant(pieces), slope(x.size());
  for (std::size_t i = 0; i < pieces; ++i) secant[i] = (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
  slope.front() = secant.front();
  slope.back() = secant.back();
  for (std::size_t i = 1; i < pieces; ++i) slope[i] = 0.5 * (secant[i - 1] + secant[i]);
  constexpr double radius = 3.0;
  for (std::size_t i = 0; i < pieces; ++i) {
    const double size = elementary::hypot(slope[i], slope[i + 1]) / secant[i];
    if (size <= radius) continue;
    slope[i] *= radius / size;
    slope[i + 1] *= radius / size;
  }
  return slope;
}

/// One piece: the curve over s = x - x0 is y0 + s (d0 + s (quadratic + s cubic)).
struct CubicPiece {
  double y0, d0, quadratic, cubic;

  double value(double s) const { return y0 + s * (d0 + s * (quadratic + s * cubic)); }
  double slope(double s) const { return d0 + s * (2.0 * quadratic + s * 3.0 * cubic); }
  double work(double s) const {
    return s * (y0 + s * (0.5 * d0 + s * (quadratic / 3.0 + s * 0.25 * cubic)));
  }
};

CubicPiece cubic_piece(std::size_t i, std::span<const double> x, std::span<const double> y,
                       std::span<const double> slope) {
  if (i + 1 == x.size()) return {y[i], slope[i], 0.0, 0.0};
  const double h = x[i + 1] - x[i], secant = (y[i + 1] - y[i]) / h;
  return {y[i], slope[i], (3.0 * secant - 2.0 * slope[i] - slope[i + 1]) / h,
          (slope[i] + slope[i + 1] - 2.0 * secant) / (h * h)};
}

}  // namespace

MonotoneCurve::MonotoneCurve(std::vector<double> x, std::vector<double> y)
    : x_(std::move(x)), y_(std::move(y)) {
  require_rising(x_, y_);
  slope_ = monotone_slopes(x_, y_);
  work_.assign(x_.size(), 0.0);
  for (std::size_t i = 0; i + 1 < x_.size(); ++i)
    work_[i + 1] = work_[i] + cubic_piece(i, x_, y_, slope_).work(x_[i + 1] - x_[i]);
}

std::size_t MonotoneCurve::piece_of(double size) const {
  const auto above = std::upper_bound(x_.begin(), x_.end(), size);
  return above == x_.begin() ? 0 : static_cast<std::size_t>(above - x_.begin()) - 1;
}

double MonotoneCurve::value(double x) const {
  const double size = std::abs(x);
  const std::size_t i = piece_of(size);
  return std::copysign(cubic_piece(i, x_, y_, slope_).value(size - x_[i]), x);
}

double MonotoneCurve::slope(double x) const {
  const double size = std::abs(x);
  const std::size_t i = piece_of(size);
  return cubic_piece(i, x_, y_, slope_).slope(size - x_[i]);
}

double MonotoneCurve::work(double x) const {
  const double size = std::abs(x);
  const std::size_t i = piece_of(size);
  return work_[i] + cubic_piece(i, x_, y_, slope_).work(size - x_[i]);
}

void set_curves(Material& m) {
  if (!m.tension_curve.empty()) {
    m.stretch_law = "measured";
    m.stretch_stiffness = m.tension_curve.slope_at_rest();
    m.stretch_weft.reset();
  }
  if (!m.tension_weft.empty()) m.stretch_weft = m.tension_weft.slope_at_rest();
  if (!m.shear_curve.empty()) {
    m.shear_law = "angle";
    m.shear_stiffness = m.shear_curve.slope_at_rest();
  }
  if (!m.bending_curve.empty()) {
    m.bending_stiffness = m.bending_curve.slope_at_rest();
    m.bending_weft.reset();
  }
  if (!m.bending_curve_weft.empty()) m.bending_weft = m.bending_curve_weft.slope_at_rest();
}

TensionFigures figures_of(const MonotoneCurve& pull) {
  const double end = pull.x().back(), work = pull.work(end);
  return {end, work, work / (0.5 * pull.y().back() * end)};
}

double resilience(const MonotoneCurve& pull, const TensionCurve& release) {
  if (release.strain.empty() || release.strain.size() != release.force.size())
    throw std::invalid_argument("the curve of return needs as many forces as strains");
  std::vector<double> from_slack = release.strain;
  for (double& strain : from_slack) strain -= release.strain.front();
  const MonotoneCurve back(std::move(from_slack), release.force);
  // Readings have three digits.
  constexpr double reading = 1e-3;
  if (std::abs(release.strain.back() - pull.x().back()) > reading * pull.x().back() ||
      std::abs(release.force.back() - pull.y().back()) > reading * pull.y().back())
    throw std::invalid_argument("the curve of return must end where the pull ends");
  const double share = back.work(back.x().back()) / pull.work(pull.x().back());
  if (share > 1.0)
    throw std::invalid_argument("the curve of return lies above the pull; are they exchanged?");
  return share;
}

double shear_of_bias(double modulus, const WarpWeft& stretch) {
  const double compliance = 4.0 / modulus - 1.0 / stretch.warp - 1.0 / stretch.weft;
  require(std::isfinite(compliance) && compliance > 0.0, "modulus at 45 degrees in N/m", modulus,
          "below that of yarns that cannot turn, 4/(1/E1 + 1/E2)");
  return 1.0 / compliance;
}

MonotoneCurve shear_of_bias(const TensionCurve& bias, const WarpWeft& stretch) {
  if (bias.strain.size() != bias.force.size() || bias.strain.empty() || bias.strain[0] != 0.0 ||
      bias.force[0] != 0.0)
    throw std::invalid_argument("the tensile test at 45 degrees must begin at strain 0, force 0");
  const double yarns = 0.25 * (1.0 / stretch.warp + 1.0 / stretch.weft);
  std::vector<double> angle{0.0}, force{0.0};
  for (std::size_t i = 1; i < bias.strain.size(); ++i) {
    const double cosine = (1.0 + bias.strain[i] - yarns * bias.force[i]) / std::numbers::sqrt2;
    if (!(cosine > 1.0 / std::numbers::sqrt2))
      throw std::invalid_argument(
          "point " + std::to_string(i) +
          " of the tensile test at 45 degrees: warp and weft alone stretch farther than this "
          "strain; check the stretch stiffness");
    if (!(cosine < 1.0))
      throw std::invalid_argument("point " + std::to_string(i) +
                                  " of the tensile test at 45 degrees: no trellis turns so far; "
                                  "leave it out");
    const double half = elementary::acos(cosine);  // between yarn and load
    angle.push_back(0.5 * std::numbers::pi - 2.0 * half);
    force.push_back(bias.force[i] * elementary::sin(half) / std::numbers::sqrt2);
  }
  return {std::move(angle), std::move(force)};
}

}  // namespace selvedge
