// SPDX-License-Identifier: MIT
//
// Tension tests of woven swatches at the level of their yarns. Every state is an equilibrium,
// found by Newton's method on the energy with the positive part of its Jacobian and a line search.
//
// Initial modulus of a plain weave. A part of a yarn between two crossings, of length l at the
// slope θ, is a beam whose ends keep their directions, because a crossing is a plane of symmetry.
// Pulled by (F, q) along the cloth and across it, its ends move by (dL, dh) = C (F, q) with
//   C = l³ (1 + 2/n²)/(12 B) n nᵀ + l/(EA) t tᵀ,  n = (-sin θ, cos θ), t = (cos θ, sin θ).
// Both yarns of a crossing feel the same q, and the contact of stiffness k gives way by 2q/k:
//   dh1 + dh2 = -4q/k,  q = -C1_Lh F/(C1_hh + C2_hh + 4/k),  dL1 = C1_LL F + C1_Lh q.
// With EA and k infinite and n links without end this is the formula of G. Leaf and K. Kandil,
// "The initial load-extension behaviour of plain-woven fabrics", Journal of the Textile Institute
// 1980: E1 = (12 B1 L1)/(L2 l1³ sin² θ1) (1 + B2 l1³ cos² θ1/(B1 l2³ cos² θ2)).
//
// Initial shear modulus, after G. Leaf, A. Sheta, "The initial shear modulus of plain-woven
// fabrics", Journal of the Textile Institute 1984: yarns bend to an S between crossings whose
// directions turn against each other by moment/rotation,
//   1/G = L1 L2/rotation + a1 L2/L1 + a2 L1/L2,  a = (1 - 1/n) (1 - 2/n) l³/(12 B).
// The angle of a crossing takes in a link on each side, which do not bend.
#include <selvedge/core/check.h>
#include <selvedge/core/force.h>
#include <selvedge/lab/fabric_drape.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace selvedge {

namespace {

using Mat2 = Eigen::Matrix2d;

void validate_swatch(const SwatchTrial& t) {
  const auto positive = [](const char* name, double value) {
    require(std::isfinite(value) && value > 0.0, name, value, "positive and finite");
  };
  positive("ends in 1/m", t.ends);
  positive("picks in 1/m", t.picks);
  positive("strain", t.strain);
  require(t.crossings >= 8, "crossings", t.crossings, "at least 8");
  require(t.points >= 2, "points", t.points, "at least 2");
}

/// A yarn of the trial: its spacing of crossings, its crimp height, and how dense such yarns lie.
struct SwatchYarn {
  const YarnConfig& rod;
  double spacing;  ///< m, of crossings along the yarn
  double height;   ///< m
  double dense;    ///< 1/m, yarns across

  double length() const { return std::hypot(spacing, height); }
};

SwatchYarn swatch_yarn(const SwatchTrial& t, bool warp) {
  if (warp) return {t.weave.warp, 1.0 / t.picks, t.weave.warp_crimp(), t.ends};
  return {t.weave.weft, 1.0 / t.ends, t.weave.weft_crimp(), t.picks};
}

/// Mean length of a yarn per crossing: two parts of a repeat interlace, the others float.
double mean_length(const SwatchTrial& t, const SwatchYarn& yarn) {
  const double repeat = t.weave.over + t.weave.under;
  return (2.0 * yarn.length() + (repeat - 2.0) * yarn.spacing) / repeat;
}

/// C of the part between two crossings.
Mat2 compliance(const SwatchYarn& yarn, double links) {
  const double l = yarn.length(), c = yarn.spacing / l, s = yarn.height / l;
  const Eigen::Vector2d across(-s, c), along(c, s);
  return (l * l * l * (1.0 + 2.0 / (links * links)) / (12.0 * yarn.rod.bending())) * across *
             across.transpose() +
         (l / yarn.rod.stretch()) * along * along.transpose();
}

double modulus_along(const SwatchTrial& t, bool warp) {
  const SwatchYarn pulled = swatch_yarn(t, warp), other = swatch_yarn(t, !warp);
  const Mat2 a = compliance(pulled, t.weave.links), b = compliance(other, t.weave.links);
  const double soft = a(0, 0) - a(0, 1) * a(0, 1) / (a(1, 1) + b(1, 1) + 4.0 / t.weave.contact);
  return pulled.spacing * pulled.dense / soft;
}

// -- the specimen ---------------------------------------------------------------------------------

/// Cloth, and the coordinates along and across the pull at rest.
struct Specimen {
  ClothMesh cloth;
  Vec3 along, across;
  double length = 0.0;      ///< m, between the grips
  double grip = 0.0;        ///< m, that particles are held inside of this length
  double middle = 0.0;      ///< m, half of the width whose force is measured
  double width = 0.0;       ///< m, that bears this force
  std::size_t surface = 0;  ///< the first vertices, which belong to triangles
};

ClothMesh weave_without_damping(const SwatchTrial& t, std::int32_t columns, std::int32_t rows) {
  Material still;
  still.spring_damping = still.bending_damping = 0.0;
  const GridConfig grid{(columns - 1) / t.picks, (rows - 1) / t.ends, columns - 1, rows - 1};
  return make_weave(grid, t.weave, still);
}

Specimen straight_specimen(const SwatchTrial& t, bool warp) {
  Specimen s;
  s.cloth = weave_without_damping(t, t.crossings, t.crossings);
  s.along = warp ? Vec3::UnitX() : Vec3::UnitY();
  s.across = warp ? Vec3::UnitY() : Vec3::UnitX();
  const double along = 1.0 / (warp ? t.picks : t.ends), across = 1.0 / (warp ? t.ends : t.picks);
  s.length = (t.crossings - 1) * along;
  s.grip = 0.01 * along;
  // An even number of the yarns in the middle, or an odd one, as the swatch has.
  const double yarns = t.crossings / 4 * 2 + t.crossings % 2;
  s.width = yarns * across;
  s.middle = 0.5 * s.width;
  s.surface = static_cast<std::size_t>(t.crossings) * t.crossings;
  return s;
}

/// The swatch cut at 45°, twice as long as wide.
Specimen bias_specimen(const SwatchTrial& t) {
  const double width = t.crossings * std::sqrt(1.0 / (t.ends * t.picks)), length = 2.0 * width;
  const double side = (length + width) / std::numbers::sqrt2;
  const auto columns = static_cast<std::int32_t>(std::ceil(side * t.picks)) + 2;
  const auto rows = static_cast<std::int32_t>(std::ceil(side * t.ends)) + 2;
  const ClothMesh sheet = weave_without_damping(t, columns, rows);
  Specimen s;
  s.along = Vec3(1.0, 1.0, 0.0).normalized();
  s.across = Vec3(-1.0, 1.0, 0.0).normalized();
  const std::vector<Vec3>& x = sheet.surface.vertices;
  std::vector<std::int32_t> number(x.size(), -1);
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (std::abs(x[i].dot(s.along)) > 0.5 * length || std::abs(x[i].dot(s.across)) > 0.5 * width)
      continue;
    number[i] = static_cast<std::int32_t>(s.cloth.surface.vertices.size());
    s.cloth.surface.vertices.push_back(x[i]);
    s.cloth.mass.push_back(sheet.mass[i]);
    if (i < static_cast<std::size_t>(columns) * rows) s.surface = s.cloth.surface.vertices.size();
  }
  add_elements(s.cloth, sheet, number);
  s.grip = std::sqrt(1.0 / (t.ends * t.picks));
  s.length = length;
  s.middle = s.width = width;
  return s;
}

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
        "swatch: a step of the tension test found no equilibrium; take smaller "
        "steps of strain");
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

/// A test of a specimen: the coordinates that the clamps prescribe, and how far they move them.
class ClampedSpecimen {
 public:
  ClampedSpecimen(const SwatchTrial& trial, SwatchPull pull)
      : specimen_(pull == SwatchPull::bias ? bias_specimen(trial)
                                           : straight_specimen(trial, pull != SwatchPull::weft)),
        sheared_(pull == SwatchPull::shear) {
    std::vector<Vec3>& x = specimen_.cloth.surface.vertices;
    x = turned(x, specimen_.along, specimen_.across);
    fixed_.assign(3 * x.size(), 0);
    if (sheared_)
      hold_frame(trial);
    else
      hold_ends(pull);
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
  void hold_ends(SwatchPull pull) {
    const double edge = 0.5 * specimen_.length - specimen_.grip;
    std::size_t anchor = 0;  // keeps the specimen from drifting across
    for (std::size_t i = 0; i < rest().size(); ++i) {
      const Vec3& x = rest()[i];
      if (x.squaredNorm() < rest()[anchor].squaredNorm()) anchor = i;
      // Cut at 45° it would wrinkle.
      const bool is_flat = pull == SwatchPull::bias || std::abs(x.x()) > edge;
      if (is_flat && i < specimen_.surface) fixed_[3 * i + 2] = 1;
      if (std::abs(x.x()) <= edge) continue;
      fixed_[3 * i] = 1;
    }
    fixed_[3 * anchor + 1] = 1;
  }

  /// All four sides turn like a frame with hinged corners, and the ends of the yarns with them.
  void hold_frame(const SwatchTrial& trial) {
    const double edge_x = 0.5 * (trial.crossings - 1.5) / trial.picks;
    const double edge_y = 0.5 * (trial.crossings - 1.5) / trial.ends;
    for (std::size_t i = 0; i < rest().size(); ++i) {
      const Vec3& x = rest()[i];
      if (i < specimen_.surface) fixed_[3 * i + 2] = 1;
      if (std::abs(x.x()) <= edge_x && std::abs(x.y()) <= edge_y) continue;
      fixed_[3 * i] = fixed_[3 * i + 1] = 1;
    }
    specimen_.length = trial.crossings / trial.picks;
    specimen_.width = trial.crossings / trial.ends;
    specimen_.middle = specimen_.width;
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

double SwatchTrial::density() const {
  const SwatchYarn a = swatch_yarn(*this, true), b = swatch_yarn(*this, false);
  constexpr double kg_per_m = 1e-6;  // of a tex
  return kg_per_m * (ends * weave.warp.tex * mean_length(*this, a) / a.spacing +
                     picks * weave.weft.tex * mean_length(*this, b) / b.spacing);
}

WarpWeft SwatchTrial::crimp() const {
  const SwatchYarn a = swatch_yarn(*this, true), b = swatch_yarn(*this, false);
  return {mean_length(*this, a) / a.spacing - 1.0, mean_length(*this, b) / b.spacing - 1.0};
}

WarpWeft SwatchTrial::bending() const {
  const WarpWeft c = crimp();
  return {ends * weave.warp.bending() / (1.0 + c.warp),
          picks * weave.weft.bending() / (1.0 + c.weft)};
}

WarpWeft SwatchTrial::plain_modulus() const {
  if (weave.over != 1 || weave.under != 1)
    throw std::invalid_argument("plain_modulus is that of a plain weave: over and under must be 1");
  return {modulus_along(*this, true), modulus_along(*this, false)};
}

double SwatchTrial::shear_modulus() const {
  const SwatchYarn a = swatch_yarn(*this, true), b = swatch_yarn(*this, false);
  const double n = weave.links;
  const auto bend = [&](const SwatchYarn& yarn) {
    const double l = mean_length(*this, yarn);
    return (1.0 - 1.0 / n) * (1.0 - 2.0 / n) * l * l * l / (12.0 * yarn.rod.bending());
  };
  return 1.0 / (a.spacing * b.spacing / weave.rotation + bend(a) * b.spacing / a.spacing +
                bend(b) * a.spacing / b.spacing);
}

std::vector<SwatchPoint> pull_swatch(const SwatchTrial& trial, SwatchPull pull) {
  validate_swatch(trial);
  const ClampedSpecimen clamped(trial, pull);
  Equilibrium equilibrium(clamped.specimen().cloth, clamped.fixed());
  std::vector<Vec3> x = clamped.rest();
  std::vector<SwatchPoint> curve{SwatchPoint{}};
  for (std::int32_t k = 1; k <= trial.points; ++k) {
    const double now = trial.strain * k / trial.points;
    clamped.move(x, trial.strain * (k - 1) / trial.points, now);
    const std::vector<Vec3> f = equilibrium.solve(x);
    curve.push_back(clamped.measure(now, x, f));
  }
  return curve;
}

double initial_modulus(std::span<const SwatchPoint> curve) {
  require(curve.size() >= 3, "points of the curve", static_cast<double>(curve.size()),
          "at least 3");
  const SwatchPoint &a = curve[1], &b = curve[2];
  const double ka = a.force / a.strain, kb = b.force / b.strain;
  return ka - (kb - ka) * a.strain / (b.strain - a.strain);
}

Material material_of(const SwatchTrial& trial, std::span<const SwatchPoint> warp,
                     std::span<const SwatchPoint> weft, std::span<const SwatchPoint> shear) {
  const auto curve_of = [](std::span<const SwatchPoint> points) {
    std::vector<double> strain, force;
    for (const SwatchPoint& p : points) {
      strain.push_back(p.strain);
      force.push_back(p.force);
    }
    return MonotoneCurve(strain, force);
  };
  Material m;
  m.density = trial.density();
  const WarpWeft bending = trial.bending();
  m.bending_stiffness = bending.warp;
  m.bending_weft = bending.weft;
  m.stretch_law = StretchLaw::measured;
  m.shear_law = ShearLaw::angle;
  m.tension_curve = curve_of(warp);
  m.tension_weft = curve_of(weft);
  m.shear_curve = curve_of(shear);
  set_curves(m);
  return m;
}

}  // namespace selvedge
