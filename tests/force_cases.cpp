// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/detail/chord_link.h>
#include <selvedge/tests/force_cases.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

namespace selvedge::testing {
namespace {

constexpr double pi = std::numbers::pi;

using Positions = std::span<const HyperVec>;

HyperDual square(const HyperDual& p) { return p * p; }
HyperDual cube(const HyperDual& p) { return p * p * p; }

HyperDual length_of(Positions x) { return norm(x[1] - x[0]); }

// -- springs ----------------------------------------------------------------------------------

constexpr double k_spring = 100.0, rest_length = 1.0;

const Vectors link{{0.0, 0.0, 0.0}, {rest_length, 0.0, 0.0}};
const Vectors stretched_link{{0.1, -0.2, 0.3}, {0.9, 0.8, 1.2}};

ForceCase spring_case(const std::string& name, const SpringCurve& curve, EnergyOracle energy) {
  const std::vector<Spring> springs{{0, 1, rest_length, k_spring, 0.02}};
  return {name,          make_curve_force(springs, curve, 2), {0.5, 2.0}, link, std::move(energy),
          stretched_link};
}

HyperDual hooke(Positions x) { return 0.5 * k_spring * square(length_of(x) - rest_length); }

HyperDual tension_only(Positions x) {
  return length_of(x).value > rest_length ? hooke(x) : HyperDual(0.0);
}

constexpr double growth = 10.0, threshold = 0.02;

// k ΔL (1 + β (ε - ε*)) integrated from L0, by hand: ½ k ΔL² + β k (ΔL³/3 - ε* ΔL²/2) + constant.
HyperDual biphasic(Positions x) {
  const HyperDual d = length_of(x) - rest_length;
  if (d.value <= threshold) return hooke(x);
  const HyperDual more = cube(d) / 3.0 - 0.5 * threshold * square(d);
  const double at_threshold = -threshold * threshold * threshold / 6.0;
  return hooke(x) + growth * k_spring * (more - at_threshold);
}

constexpr double lt = 0.7, emt = 0.05;

// f = F (α s + (1-α) s³), F = k EMT/α.
HyperDual kawabata(Positions x) {
  const double alpha = 2.0 * lt - 1.0, full = k_spring * emt / alpha;
  const HyperDual s = (length_of(x) - rest_length) / emt;
  if (s.value <= 0.0) return hooke(x);
  const auto inside = [&](const HyperDual& t) {
    return full * emt * (0.5 * alpha * square(t) + 0.25 * (1.0 - alpha) * square(square(t)));
  };
  if (s.value <= 1.0) return inside(s);
  const HyperDual over = s - 1.0;
  return inside(1.0) + full * emt * (over + 0.5 * (3.0 - 2.0 * alpha) * square(over));
}

// Half the work comes back: W²/(2 W_m) below the longest length that it remembers.
constexpr double longest = 1.06 * rest_length;
HyperDual resilient(Positions x) {
  const std::array<HyperVec, 2> far{HyperVec{0.0, 0.0, 0.0}, HyperVec{longest, 0.0, 0.0}};
  const double top = kawabata(far).value, length = length_of(x).value;
  const HyperDual load = kawabata(x);
  if (length <= rest_length) return load;
  return length >= longest ? load - 0.5 * top : (0.5 / top) * square(load);
}

const SewingConfig sewing_config{50.0, 0.3, 0.2};

HyperDual sewing(Positions x) {
  const HyperDual d = length_of(x);
  const double pull = sewing_config.pull, far = sewing_config.tolerance, near = 0.01 * far;
  if (d.value <= near) return 0.5 * pull * far / near * square(d);
  const double first = 0.5 * pull * far * near;
  if (d.value <= far) return first + pull * far * (d - near);
  return first + pull * far * (far - near) + 0.5 * pull * (square(d) - far * far);
}

// -- the link that buckles ------------------------------------------------------------------------

const BucklingLink buckling_link{0, 1, rest_length, 0.1, 20.0, 0.02};

/// u with sin(u)/u = s in [0, π]: bisection for the value, two steps of Newton's for the
/// derivatives.
HyperDual inverse_sinc(const HyperDual& s) {
  double low = 0.0, high = pi;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (std::sin(middle) > s.value * middle ? low : high) = middle;
  }
  HyperDual u(low);
  for (int i = 0; i < 2; ++i) {
    const HyperDual sinc = sin(u) / u;
    u = u - (sinc - s) * u / (cos(u) - sinc);
  }
  return u;
}

HyperDual bent(const HyperDual& length) {
  const HyperDual kappa = 2.0 / rest_length * inverse_sinc(length / rest_length);
  return 0.5 * buckling_link.rigidity * rest_length * square(kappa);
}

/// -dE/dr of the arc.
double thrust(double length) { return -bent(HyperDual(length, 1.0, 0.0, 0.0)).da; }

HyperDual buckling(Positions x) {
  const HyperDual r = length_of(x), shortening = rest_length - r;
  if (shortening.value <= 0.0) return 0.0;
  double soft = 1e-6, hard = 1.0 - 1e-12;  // shortenings around where onset and arc meet
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (soft + hard);
    (buckling_link.onset * middle < thrust(rest_length - middle) ? soft : hard) = middle;
  }
  const auto onset = [](const HyperDual& s) { return 0.5 * buckling_link.onset * square(s); };
  if (shortening.value < hard) return onset(shortening);
  return bent(r) + onset(hard) - bent(rest_length - hard);
}

// -- measured curves and the link with their moment -----------------------------------------------

const MonotoneCurve strain_curve({0.0, 0.1, 0.3, 0.5}, {0.0, 4.0, 30.0, 90.0});
const MonotoneCurve moment_curve({0.0, 0.5, 2.0, 9.0}, {0.0, 0.2, 0.3, 0.6});

/// The integral of a curve, by its derivatives, which measured_test tests.
HyperDual work_of(const MonotoneCurve& curve, const HyperDual& x) {
  return chain(x, curve.work(x.value), curve.value(x.value), curve.slope(x.value));
}

HyperDual measured_tension(const HyperDual& strain, double stiffness) {
  if (strain.value <= 0.0) return 0.5 * stiffness * square(strain);
  return stiffness / strain_curve.slope_at_rest() * work_of(strain_curve, strain);
}

const detail::ChordLink chord_link{0, 1, 0.5 * rest_length, 0.2, 0.4, 4.0, 0.02, 0};

/// w d Ψ(κ) with 2d cos(κd/2) = r.
HyperDual chord_bent(const HyperDual& r) {
  const double d = chord_link.spacing;
  const HyperDual cosine = r / (2.0 * d), half = atan2(sqrt(1.0 - square(cosine)), cosine);
  const double scale = chord_link.width * d * chord_link.rigidity / moment_curve.slope_at_rest();
  return scale * work_of(moment_curve, 2.0 / d * half);
}

HyperDual chord(Positions x) {
  const HyperDual r = length_of(x), shortening = rest_length - r;
  if (shortening.value <= 0.0) return 0.0;
  double soft = 1e-9, hard = 1.0 - 1e-12;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (soft + hard);
    const double push = -chord_bent(HyperDual(rest_length - middle, 1.0, 0.0, 0.0)).da;
    (chord_link.onset * middle < push ? soft : hard) = middle;
  }
  const auto onset = [](const HyperDual& s) { return 0.5 * chord_link.onset * square(s); };
  if (shortening.value < hard) return onset(shortening);
  return chord_bent(r) + onset(hard) - chord_bent(rest_length - hard);
}

// -- angles ---------------------------------------------------------------------------------------

const Vectors hinge_rest{{0.3, -0.8, 0.0}, {0.6, 0.9, 0.0}, {0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}};
constexpr double k_hinge = 3.0, theta0 = 0.4;

/// Between the normals, positive as the hinge folds along its edge 2-3.
HyperDual hinge_angle(Positions x) {
  const HyperVec e = x[3] - x[2];
  const HyperVec n1 = cross(x[0] - x[2], x[0] - x[3]), n2 = cross(x[1] - x[3], x[1] - x[2]);
  return atan2(dot(cross(n2, n1), e) / norm(e), dot(n1, n2));
}

/// How much the way over three particles turns.
HyperDual corner_angle(Positions x) {
  const HyperVec p = x[1] - x[0], q = x[2] - x[1];
  return atan2(norm(cross(p, q)), dot(p, q));
}

HyperDual angle_energy(const HyperDual& angle, double rest, double stiffness) {
  HyperDual off = angle - rest;
  off.value = std::remainder(off.value, 2.0 * pi);
  return 0.5 * stiffness * square(off);
}

/// ½ (M/y) e² up to y, M (|e| - y/2) beyond.
HyperDual friction_energy(const HyperDual& angle, double rest, double moment, double yield) {
  const HyperDual off = angle - rest;
  if (std::abs(off.value) <= yield) return 0.5 * moment / yield * square(off);
  return moment * ((off.value > 0.0 ? off : -1.0 * off) - 0.5 * yield);
}

/// The hinge folded about its edge until its angle is `angle`.
Vectors folded(double angle) {
  Vectors x = hinge_rest;
  const Mat3 turn = Eigen::AngleAxisd(angle, Vec3::UnitX()).toRotationMatrix();
  x[1] = turn * x[1];
  std::array<HyperVec, 4> h;
  for (int i = 0; i < 4; ++i) h[i] = {x[i][0], x[i][1], x[i][2]};
  if (hinge_angle(h).value * angle < 0.0) x[1] = turn.transpose() * hinge_rest[1];
  return x;
}

const Vectors right_angle{{-1.0, 0.1, 0.0}, {0.0, 0.0, 0.0}, {0.1, 1.0, 0.0}};
constexpr double phi0 = 1.2;

Vectors turned(double angle) {
  return {{-1.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {std::cos(angle), std::sin(angle), 0.0}};
}

// -- more particles -------------------------------------------------------------------------------

template <int N>
HyperDual tie_energy(Positions x, const Tie<N>& tie) {
  HyperVec d = x[0];
  for (int k = 0; k < N; ++k) d = d - HyperDual(tie.weight[k]) * x[k + 1];
  return 0.5 * tie.stiffness * dot(d, d);
}

const Tie<4> layer{{0, 1, 2, 3, 4}, {0.42, 0.18, 0.28, 0.12}, 40.0, 0.02};

const Vectors tetrahedron{{0, 0, 0}, {1, 0, 0}, {0.2, 1, 0}, {0.3, 0.2, 1.1}, {0.4, 0.3, 0.2}};
const std::vector<Triangle> faces{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

std::vector<double> ones(std::size_t n) { return std::vector<double>(n, 1.0); }

void add_springs(std::vector<ForceCase>& all) {
  all.push_back(spring_case("hooke", {}, hooke));
  all.push_back(spring_case("tension_only", {"tension_only"}, tension_only));
  all.push_back(spring_case("biphasic", {"biphasic", threshold, growth}, biphasic));
  all.push_back(spring_case("kawabata", {"kawabata", emt, lt}, kawabata));
  all.push_back(spring_case("resilient", {"kawabata", emt, lt, 0.5}, resilient));
  all.back().force->restore_memory(std::vector<double>{longest});
  all.push_back(
      spring_case("measured", {.law = "measured", .measured = strain_curve}, [](Positions x) {
        return rest_length * rest_length *
               measured_tension(length_of(x) / rest_length - 1.0, k_spring);
      }));
  const std::vector<detail::ChordLink> chords{chord_link};
  const std::vector<SpringCurve> moments{{.law = "measured", .measured = moment_curve}};
  all.push_back({"chord", detail::make_chord_force(chords, moments, 2), {0.5, 2.0}, link, chord});
  const std::vector<BucklingLink> links{buckling_link};
  all.push_back({"buckling", make_buckling_force(links, 2), {0.5, 2.0}, link, buckling});
  const std::vector<Edge> seams{{0, 1}};
  all.push_back({"sewing",
                 make_sewing_force(seams, sewing_config, 2),
                 {0.5, 2.0},
                 Vectors(2, Vec3::Zero()),
                 sewing,
                 stretched_link});
}

/// A triangle and its three neighbours, with couples between its hinges.
void add_shape_operator(std::vector<ForceCase>& all) {
  const Vectors rest{{0, 0, 0},      {1, 0, 0},     {0.4, 0.9, 0},
                     {0.5, -0.8, 0}, {1.2, 0.9, 0}, {-0.5, 0.6, 0}};
  const std::vector<Hinge> hinges{{{2, 3, 0, 1}, 0.0, 3.0, 0.02},
                                  {{0, 4, 1, 2}, 0.0, 2.0, 0.02},
                                  {{1, 5, 2, 0}, 0.0, 4.0, 0.02}};
  const std::vector<HingeCouple> couples{{0, 1, 0.7}, {0, 2, -1.1}, {1, 2, 0.4}};
  all.push_back({"shape_operator", make_shape_operator_force(hinges, couples, 6), ones(6), rest,
                 [=](Positions x) {
                   std::array<HyperDual, 3> angle;
                   HyperDual sum = 0.0;
                   for (std::size_t i = 0; i < 3; ++i) {
                     const auto& v = hinges[i].v;
                     const std::array<HyperVec, 4> own{x[v[0]], x[v[1]], x[v[2]], x[v[3]]};
                     angle[i] = hinge_angle(own);
                     sum = sum + 0.5 * hinges[i].stiffness * square(angle[i]);
                   }
                   for (const HingeCouple& c : couples)
                     sum = sum + c.stiffness * (angle[c.a] * angle[c.b]);
                   return sum;
                 },
                 rest});
}

/// The friction of a curvature that three hinges make.
void add_curvature_friction(std::vector<ForceCase>& all) {
  const Vectors rest{{0, 0, 0},      {1, 0, 0},     {0.4, 0.9, 0},
                     {0.5, -0.8, 0}, {1.2, 0.9, 0}, {-0.5, 0.6, 0}};
  const std::vector<Hinge> hinges{
      {{2, 3, 0, 1}, 0.0, 0.0}, {{0, 4, 1, 2}, 0.0, 0.0}, {{1, 5, 2, 0}, 0.0, 0.0}};
  const std::vector<CurvatureFriction> frictions{
      {{{0, {1.0, 0.2, -0.3}}, {1, {0.1, 0.8, 0.4}}, {2, {0.3, -0.2, 0.9}}}, 2.0, 0.3}};
  all.push_back({"curvature_friction", make_curvature_friction(hinges, frictions, 6), ones(6), rest,
                 [=](Positions x) {
                   HyperDual sum = 0.0;
                   for (int c = 0; c < 3; ++c) {
                     HyperDual off = 0.0;
                     for (const auto& [hinge, curvature] : frictions[0].terms) {
                       const auto& v = hinges[hinge].v;
                       const std::array<HyperVec, 4> own{x[v[0]], x[v[1]], x[v[2]], x[v[3]]};
                       off = off + curvature[c] * hinge_angle(own);
                     }
                     sum = sum + square(off);
                   }
                   constexpr double m = 2.0, y = 0.3;
                   if (sum.value <= y * y) return 0.5 * m / y * sum;
                   return m * (sqrt(sum) - 0.5 * y);
                 }});
}

void add_hinges(std::vector<ForceCase>& all) {
  const std::array<std::int32_t, 4> v{0, 1, 2, 3};
  const std::vector<Hinge> hinges{{v, theta0, k_hinge, 0.02}};
  all.push_back({"bending", make_bending_force(hinges, 4), ones(4), folded(theta0),
                 [](Positions x) { return angle_energy(hinge_angle(x), theta0, k_hinge); },
                 folded(theta0)});
  all.push_back({"bridson", make_bridson_force(hinges, 4), ones(4), folded(theta0),
                 [](Positions x) {
                   const HyperDual half = 0.5 * hinge_angle(x);
                   return k_hinge * (4.0 * (std::cos(0.5 * theta0) - cos(half)) -
                                     2.0 * (2.0 * half - theta0) * std::sin(0.5 * theta0));
                 },
                 folded(theta0)});
  add_shape_operator(all);
  add_curvature_friction(all);
  const std::vector<HingeFriction> frictions{{v, theta0, 2.0, 0.3}};
  all.push_back({"hinge_friction", make_hinge_friction(frictions, 4), ones(4), folded(theta0),
                 [](Positions x) { return friction_energy(hinge_angle(x), theta0, 2.0, 0.3); },
                 folded(theta0)});
}

void add_corners(std::vector<ForceCase>& all) {
  const std::array<std::int32_t, 3> v{0, 1, 2};
  const std::vector<TwistSpring> shear{{v, phi0, k_hinge, 0.02}}, bend{{v, 0.0, k_hinge, 0.02}};
  all.push_back({"twisting_shear", make_twist_force(shear, 3), ones(3), turned(phi0),
                 [](Positions x) { return angle_energy(corner_angle(x), phi0, k_hinge); },
                 turned(phi0)});
  all.push_back({"twisting_bend", make_twist_force(bend, 3), ones(3), turned(0.0),
                 [](Positions x) { return angle_energy(corner_angle(x), 0.0, k_hinge); }});
  const std::vector<CornerFriction> frictions{{v, phi0, 2.0, 0.3}};
  all.push_back({"corner_friction", make_corner_friction(frictions, 3), ones(3), turned(phi0),
                 [](Positions x) { return friction_energy(corner_angle(x), phi0, 2.0, 0.3); },
                 turned(phi0)});
}

void add_bodies(std::vector<ForceCase>& all) {
  const std::vector<Tie<4>> layers{layer};
  const Vectors layer_rest{{0.4, 0.4, 0.0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  all.push_back({"layer_tie", make_tie_force(layers, 5), ones(5), layer_rest,
                 [](Positions x) { return tie_energy(x, layer); }, tetrahedron});
  const std::vector<double> stiffness{10.0, 20.0, 5.0, 8.0};
  const Vectors rest(tetrahedron.begin(), tetrahedron.end() - 1);
  all.push_back({"virtual_follow", make_virtual_springs(rest, stiffness, true), ones(4), rest, {}});
  all.push_back(
      {"volume", make_volume_force(50.0, 4, faces, tetrahedron), ones(5), tetrahedron, {}});
}

// -- finite elements ------------------------------------------------------------------------------

// A triangle of a sheet that is stiffer along x.
constexpr double c11 = 100.0, c22 = 60.0, c12 = 25.0, c33 = 18.0;
const Vectors sheet_rest{{0, 0, 0}, {1, 0.1, 0}, {0.9, 1.1, 0}};
const std::vector<Triangle> sheet_triangles{{0, 1, 2}};

std::vector<MembraneTriangle> sheet() {
  std::vector<MembraneTriangle> all;
  for (const Triangle& t : sheet_triangles) {
    MembraneTriangle m{t, {}, c11, c22, c12, c33, 0.02};
    for (int k = 0; k < 3; ++k) m.rest[k] = {sheet_rest[t[k]].x(), sheet_rest[t[k]].y()};
    all.push_back(m);
  }
  return all;
}

/// The energy of a sheet, by the strain of the metric (FᵀF)11, (FᵀF)22, (FᵀF)12.
template <class Strain>
HyperDual sheet_energy(Positions x, const Strain& strain) {
  HyperDual sum = 0.0;
  for (const auto& [a, b, c] : sheet_triangles) {
    const Vec3 u = sheet_rest[b] - sheet_rest[a], v = sheet_rest[c] - sheet_rest[a];
    const double twice = u.x() * v.y() - u.y() * v.x();
    // F maps the sides of the rest shape to those of x.
    const HyperVec p = x[b] - x[a], q = x[c] - x[a];
    const HyperVec f1 = HyperDual(v.y() / twice) * p - HyperDual(u.y() / twice) * q;
    const HyperVec f2 = HyperDual(u.x() / twice) * q - HyperDual(v.x() / twice) * p;
    const auto [e1, e2, e3] = strain(dot(f1, f1), dot(f2, f2), dot(f1, f2));
    sum =
        sum + 0.25 * twice *
                  (c11 * square(e1) + c22 * square(e2) + 2.0 * c12 * (e1 * e2) + c33 * square(e3));
  }
  return sum;
}

using Strains = std::array<HyperDual, 3>;

HyperDual green(Positions x) {
  return sheet_energy(x, [](const HyperDual& a, const HyperDual& b, const HyperDual& c) {
    return Strains{0.5 * (a - 1.0), 0.5 * (b - 1.0), c};
  });
}

/// The square root of a 2 × 2 matrix M is (M + √det M)/√(tr M + 2 √det M).
HyperDual stretch(Positions x) {
  return sheet_energy(x, [](const HyperDual& a, const HyperDual& b, const HyperDual& c) {
    const HyperDual root = sqrt(a * b - c * c), trace = sqrt(a + b + 2.0 * root);
    return Strains{(a + root) / trace - 1.0, (b + root) / trace - 1.0, 2.0 * (c / trace)};
  });
}

/// A woven triangle: the columns of its deformation gradient, and twice its area.
struct Woven {
  HyperVec warp, weft;
  double twice;
};
Woven woven(Positions x) {
  const Vec3 u = sheet_rest[1] - sheet_rest[0], v = sheet_rest[2] - sheet_rest[0];
  const double twice = u.x() * v.y() - u.y() * v.x();
  const HyperVec p = x[1] - x[0], q = x[2] - x[0];
  return {HyperDual(v.y() / twice) * p - HyperDual(u.y() / twice) * q,
          HyperDual(u.x() / twice) * q - HyperDual(v.x() / twice) * p, twice};
}

HyperDual shear_angle(Positions x) {
  const Woven w = woven(x);
  return atan2(norm(cross(w.warp, w.weft)), dot(w.warp, w.weft)) - 0.5 * pi;
}

void add_yarns(std::vector<ForceCase>& all, const Vectors& pulled) {
  YarnTriangle t{{0, 1, 2}, {}, c11, c22, c33, 3.0, 0.02};
  for (int k = 0; k < 3; ++k) t.rest[k] = {sheet_rest[k].x(), sheet_rest[k].y()};
  std::vector<SpringCurve> curves{{.law = "measured", .measured = strain_curve}, {.law = "hooke"}};
  const std::vector<YarnTriangle> linear{t};
  t.shear_curve = 0;
  t.curve = {0, 1};
  const std::vector<YarnTriangle> curved{t};
  auto yarns = make_yarn_stretch(curved, curves, 3);
  all.push_back({"yarn_warp", std::move(yarns.at(0)), ones(3), sheet_rest,
                 [](Positions x) {
                   const Woven w = woven(x);
                   return 0.5 * w.twice * measured_tension(norm(w.warp) - 1.0, c11);
                 },
                 pulled});
  all.push_back({"yarn_weft", std::move(yarns.at(1)), ones(3), sheet_rest,
                 [](Positions x) {
                   const Woven w = woven(x);
                   return 0.25 * w.twice * c22 * square(norm(w.weft) - 1.0);
                 },
                 pulled});
  const double area = 0.5 * (1.0 * 1.1 - 0.1 * 0.9);
  all.push_back({"yarn_shear", make_yarn_shear(linear, curves, 3), ones(3), sheet_rest,
                 [area](Positions x) { return 0.5 * area * c33 * square(shear_angle(x)); },
                 sheet_rest});
  all.push_back({"yarn_shear_curve", make_yarn_shear(curved, curves, 3), ones(3), sheet_rest,
                 [area](Positions x) {
                   return area * c33 / strain_curve.slope_at_rest() *
                          work_of(strain_curve, shear_angle(x));
                 }});
  constexpr double yield = 0.0087;
  all.push_back(
      {"yarn_friction", make_yarn_friction(linear, 3), ones(3), sheet_rest,
       [area](Positions x) { return friction_energy(shear_angle(x), 0.0, 3.0 * area, yield); }});
}

void add_sheets(std::vector<ForceCase>& all) {
  Vectors pulled = sheet_rest;  // under tension in every direction
  for (Vec3& p : pulled)
    p = Vec3(1.3 * p.x() + 0.05 * p.y(), 0.1 * p.x() + 1.25 * p.y(), 0.2 * p.y());
  all.push_back({"st_venant_kirchhoff", make_membrane_force(sheet(), MembraneStrain::green, 3),
                 ones(3), sheet_rest, green, pulled});
  all.push_back({"corotated", make_membrane_force(sheet(), MembraneStrain::corotated, 3), ones(3),
                 sheet_rest, stretch, pulled});
  add_yarns(all, pulled);
}

// -- beams ----------------------------------------------------------------------------------------

/// ½ EI/h |w|² with the difference w of the two directions.
void add_beam(std::vector<ForceCase>& all) {
  const std::vector<Beam> beams{{{0, 1, 2}, {1.0, 0.5}, 2.0, 0.02}};
  const Vectors rest{{-1.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.5, 0.0, 0.0}};
  const Vectors bent{{-1.0, 0.1, 0.0}, {0.0, 0.0, 0.2}, {0.1, 0.6, 0.0}};
  all.push_back({"beam", make_beam_force(beams, 3), ones(3), rest,
                 [](Positions x) {
                   const HyperVec w = 2.0 * (x[2] - x[1]) - (x[1] - x[0]);
                   return 0.5 * (2.0 / 0.75) * dot(w, w);
                 },
                 bent});
}

/// ½ k φ² with the angle φ by which two yarns differ from a right one.
void add_crossing(std::vector<ForceCase>& all) {
  const std::vector<Crossing> crossings{{{0, 1, 2, 3}, 0.3, 1.7, 0.02}};
  const Vectors rest{{-1.0, 0.0, 0.1}, {1.0, 0.0, 0.1}, {0.0, -0.7, -0.1}, {0.0, 0.8, -0.1}};
  all.push_back({"crossing", make_crossing_force(crossings, 4), ones(4), rest, [](Positions x) {
                   const HyperVec u = x[1] - x[0], w = x[3] - x[2];
                   const HyperVec n = cross(u, w);
                   const HyperDual angle = atan2(dot(u, w), sqrt(dot(n, n)));
                   return 0.5 * 1.7 * square(angle - 0.3);
                 }});
}

double power(std::mt19937& random, double low, double high) {
  return std::pow(10.0, std::uniform_real_distribution<double>(low, high)(random));
}

Vec3 random_vector(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> coordinate(-size, size);
  const double x = coordinate(random), y = coordinate(random);
  return {x, y, coordinate(random)};
}

void spread(Vectors& x, double size, std::mt19937& random) {
  for (Vec3& p : x) p += random_vector(random, size);
}

void put_on_line(Vectors& x, bool along_axis, std::mt19937& random) {
  const Vec3 direction = along_axis ? Vec3::UnitY() : random_vector(random, 1.0);
  for (Vec3& p : x) p = random_vector(random, 1.0).x() * direction;
}

}  // namespace

std::vector<ForceCase> internal_force_cases() {
  std::vector<ForceCase> all;
  add_springs(all);
  add_hinges(all);
  add_corners(all);
  add_bodies(all);
  add_sheets(all);
  add_beam(all);
  add_crossing(all);
  return all;
}

ForceStateOwner random_state(const ForceCase& c, Shape shape, std::mt19937& random) {
  const std::size_t n = c.rest.size();
  ForceStateOwner s{c.rest, Vectors(n, Vec3::Zero()), c.mass};
  spread(s.v, 1.0, random);
  switch (shape) {
    case Shape::anywhere:
      s.x.assign(n, Vec3::Zero());
      spread(s.x, power(random, -3.0, 3.0), random);
      break;
    case Shape::near_rest:
      spread(s.x, power(random, -6.0, -0.5), random);
      break;
    case Shape::far_away:
      spread(s.x, 0.1, random);
      for (Vec3& p : s.x) p += Vec3(1e4, -1e4, 1e4);
      break;
    case Shape::together:
      spread(s.x, 0.3, random);
      s.x[random() % n] = s.x[random() % n];
      break;
    case Shape::collapsed:
      s.x.assign(n, random_vector(random, 2.0));
      break;
    case Shape::on_a_line:
      put_on_line(s.x, random() % 2 == 0, random);
      break;
    case Shape::flat:
      spread(s.x, 0.5, random);
      for (Vec3& p : s.x) p.z() = 0.25;
      break;
    case Shape::nearly_a_line:
      put_on_line(s.x, random() % 2 == 0, random);
      spread(s.x, power(random, -16.0, -6.0), random);
      break;
  }
  return s;
}

Balance balance_of(const ForceCase& c, const ForceStateOwner& state) {
  const std::size_t n = state.x.size();
  Vectors f(n, Vec3::Zero());
  c.force->add_force(state.view(), f);
  Vec3 centre = Vec3::Zero(), sum = Vec3::Zero(), moment = Vec3::Zero();
  for (const Vec3& x : state.x) centre += x / static_cast<double>(n);
  double size = 0.0, lever = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    if (!f[i].allFinite()) return {infinity, infinity};
    const Vec3 arm = state.x[i] - centre;
    sum += f[i];
    moment += arm.cross(f[i]);
    size += f[i].norm();
    lever += arm.norm() * f[i].norm();
  }
  return {size > 0.0 ? sum.norm() / size : 0.0, lever > 0.0 ? moment.norm() / lever : 0.0};
}

}  // namespace selvedge::testing
