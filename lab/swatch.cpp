// SPDX-License-Identifier: MIT
//
// Tension tests of woven swatches at the level of their yarns.
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
#include <selvedge/core/base/internal/check.h>
#include <selvedge/lab/detail/clamped_specimen.h>
#include <selvedge/lab/fabric_drape.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace selvedge {

namespace {

using detail::Specimen;
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

/// The swatch in a frame with hinged corners, which holds half a cell beyond the last crossings.
Specimen frame_specimen(const SwatchTrial& t) {
  Specimen s = straight_specimen(t, true);
  s.frame = {0.5 * (t.crossings - 1.5) / t.picks, 0.5 * (t.crossings - 1.5) / t.ends};
  s.length = t.crossings / t.picks;
  s.width = t.crossings / t.ends;
  s.middle = s.width;
  return s;
}

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
  switch (pull) {
    case SwatchPull::bias:
      return detail::pull_specimen(bias_specimen(trial),
                                   detail::Clamps::flat_ends,  // else it wrinkles
                                   trial.strain, trial.points);
    case SwatchPull::shear:
      return detail::pull_specimen(frame_specimen(trial), detail::Clamps::frame, trial.strain,
                                   trial.points);
    default:
      return detail::pull_specimen(straight_specimen(trial, pull == SwatchPull::warp),
                                   detail::Clamps::ends, trial.strain, trial.points);
  }
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
  m.stretch_law = "measured";
  m.shear_law = "angle";
  m.tension_curve = curve_of(warp);
  m.tension_weft = curve_of(weft);
  m.shear_curve = curve_of(shear);
  set_curves(m);
  return m;
}

}  // namespace selvedge
