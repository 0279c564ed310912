// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/solver/integrator.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/step_report.h>
#include <selvedge/tests/slender.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

namespace selvedge::testing {

// -- theory ---------------------------------------------------------------------------------------

namespace {

constexpr int kSteps = 500;  // of the integration along a strip

/// One step of the classical Runge-Kutta method.
template <class State, class Slope>
State runge_kutta(const State& y, double s, double h, const Slope& slope) {
  const State k1 = slope(s, y), k2 = slope(s + 0.5 * h, State(y + 0.5 * h * k1));
  const State k3 = slope(s + 0.5 * h, State(y + 0.5 * h * k2)),
              k4 = slope(s + h, State(y + h * k3));
  return y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

/// Slope θ below the horizontal, θ', and the way travelled: θ'' = -Γ (1 - s) cos θ. From the tip to
/// the clamp.
Eigen::Vector4d fallen(double gamma, double tip, double natural) {
  Eigen::Vector4d y(tip, natural, 0.0, 0.0);
  const double h = -1.0 / kSteps;
  for (int i = 0; i < kSteps; ++i)
    y = runge_kutta(y, 1.0 + i * h, h, [&](double s, const Eigen::Vector4d& z) {
      return Eigen::Vector4d(z[1], -gamma * (1.0 - s) * std::cos(z[0]), std::cos(z[0]),
                             std::sin(z[0]));
    });
  return y;
}

}  // namespace

double cantilever_ratio(double gamma, double natural) {
  constexpr int stages = 40, iterations = 30;
  constexpr double nudge = 1e-6, enough = 1e-12;
  double tip = natural;
  for (int k = 1; k <= stages; ++k) {
    const double load = gamma * k / stages;
    double off = 1.0;
    for (int i = 0; i < iterations && std::abs(off) > enough; ++i) {
      off = fallen(load, tip, natural)[0];
      tip -= off * nudge / (fallen(load, tip + nudge, natural)[0] - off);
    }
  }
  const Eigen::Vector4d clamp = fallen(gamma, tip, natural);
  return clamp[3] / clamp[2];
}

/// The strip carries the moment q s²/2 at the distance s from its tip, where q = ρ g b. With the
/// stiffness B b of bending out of its plane and 2 B b of twist, its twist φ obeys φ'' = -Γ² s⁴/8
/// φ, φ' = 0 at the tip and φ = 0 at the clamp. A clamp of some breadth also makes φ' = 0. The
/// strip resists this by B b³/12 φ''; with 2 B b, φ then grows behind a layer of the depth b/√24,
/// as if it were clamped there: Γ is that of a shorter strip.
double lateral_buckling_gamma(double breadth) {
  const auto twist_at_clamp = [](double gamma) {
    Eigen::Vector2d y(1.0, 0.0);
    const double h = 1.0 / kSteps;
    for (int i = 0; i < kSteps; ++i)
      y = runge_kutta(y, i * h, h, [&](double s, const Eigen::Vector2d& z) {
        return Eigen::Vector2d(z[1], -gamma * gamma * s * s * s * s / 8.0 * z[0]);
      });
    return y[0];
  };
  double low = 1.0, high = 30.0;  // of one sign change
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (twist_at_clamp(middle) > 0.0 ? low : high) = middle;
  }
  return low / std::pow(1.0 - breadth / std::sqrt(24.0), 3);
}

namespace {

/// Columns: frame (tangent, normal, breadth) as three, place, and the moment (about the tangent,
/// the normal, the breadth; over B b).
using TwistedState = Eigen::Matrix<double, 3, 5>;

/// Kirchhoff's equations m' + t × N = 0, with the weight N = Γ (1 - s) beyond s
/// [LandauLifshitz1986]: the strip turns by m_t/2 about the tangent, by m_n/in_plane about the
/// normal and by natural + m_b about the breadth. From the clamp to the tip; no twist before b/√24,
/// see lateral_buckling_gamma.
TwistedState twisted(const StripLoad& load, const Vec3& moment) {
  const double unwarped = load.breadth / std::sqrt(24.0);
  TwistedState y = TwistedState::Zero();
  y.leftCols<3>() = Mat3::Identity();  // tangent x, normal y, breadth z upwards
  y.col(4) = moment;
  const double h = 1.0 / kSteps;
  for (int i = 0; i < kSteps; ++i)
    y = runge_kutta(y, i * h, h, [&](double s, const TwistedState& z) {
      const Mat3 frame = z.leftCols<3>();
      const Vec3 m = z.col(4), weight(0.0, 0.0, -load.gamma * (1.0 - s));
      const Vec3 turn(s < unwarped ? 0.0 : 0.5 * m[0], m[1] / load.in_plane, load.natural + m[2]);
      TwistedState slope;
      for (int k = 0; k < 3; ++k) slope.col(k) = frame * turn.cross(Vec3::Unit(k));
      slope.col(3) = frame.col(0);
      slope.col(4) = -turn.cross(m) - Vec3::UnitX().cross(frame.transpose() * weight);
      return slope;
    });
  return y;
}

/// Newton's method for the moment at the clamp that leaves none at the tip.
bool solve_twisted(Vec3& moment, const StripLoad& load) {
  constexpr int iterations = 50;
  constexpr double nudge = 1e-6, enough = 1e-9;
  for (int i = 0; i < iterations; ++i) {
    const Vec3 off = twisted(load, moment).col(4);
    if (off.norm() < enough) return true;
    Mat3 slope;
    for (int k = 0; k < 3; ++k) {
      Vec3 moved = moment;
      moved[k] += nudge;
      slope.col(k) = (twisted(load, moved).col(4) - off) / nudge;
    }
    moment -= slope.partialPivLu().solve(off);
  }
  return false;
}

}  // namespace

std::optional<BendTwist> bent_and_twisted(const StripLoad& load) {
  constexpr int stages = 40;
  Vec3 moment = Vec3::Zero();
  for (int k = 1; k <= stages; ++k) {
    StripLoad part = load;
    part.gamma *= static_cast<double>(k) / stages;
    if (!solve_twisted(moment, part)) return {};
  }
  const Vec3 tip = twisted(load, moment).col(3);
  return BendTwist{-tip.z(), tip.x()};
}

namespace {

/// Angle θ from the downward vertical and θ', and two columns (φ, ψ, τ, λ): turns out of the plane
/// about the tangent and the normal, twist, multiplier of ψ' = -κ φ.
using HangingState = Eigen::Matrix<double, 10, 1>;

struct HangingStrip {
  double gamma, natural, twist;
};

/// θ'' = Γ (1 - s) sin θ. With C = `twist`, the second variation of the energy over B b is
/// ½ ∫ C τ² + m κ (φ² - ψ²) + Γ (1 - s) cos θ ψ², where τ = φ' - κ ψ and m = κ - natural.
HangingState hanging_slope(double s, const HangingState& y, const HangingStrip& strip) {
  const double curve = y[1], m = curve - strip.natural, weight = strip.gamma * (1.0 - s);
  HangingState slope;
  slope[0] = curve;
  slope[1] = weight * std::sin(y[0]);
  for (const int k : {2, 6}) {
    const double phi = y[k], psi = y[k + 1], twist = y[k + 2], multiplier = y[k + 3];
    slope[k] = twist + curve * psi;
    slope[k + 1] = -curve * phi;
    slope[k + 2] = curve * (m * phi + multiplier) / strip.twist;
    slope[k + 3] = -strip.twist * curve * twist + (weight * std::cos(y[0]) - m * curve) * psi;
  }
  return slope;
}

struct Hanging {
  double clamp = 0.0;  // θ there
  double least = 1.0;  // of the determinant of (φ, ψ) over the strip: Jacobi's test
};
Hanging hanging(const HangingStrip& strip, double tip) {
  HangingState y;
  y << tip, strip.natural, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0;
  Hanging result;
  const double h = -1.0 / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    y = runge_kutta(y, 1.0 + i * h, h,
                    [&](double s, const HangingState& z) { return hanging_slope(s, z, strip); });
    result.least = std::min(result.least, y[2] * y[7] - y[3] * y[6]);
  }
  result.clamp = y[0];
  return result;
}

}  // namespace

std::optional<bool> hangs_in_its_plane(double gamma, double natural, double twist) {
  constexpr int stages = 200, iterations = 30;
  constexpr double nudge = 1e-6, enough = 1e-10;
  double tip = natural;
  for (int k = 1; k <= stages; ++k) {
    const HangingStrip part{gamma * k / stages, natural, twist};
    double off = 1.0;
    for (int i = 0; i < iterations && !(std::abs(off) < enough); ++i) {
      off = hanging(part, tip).clamp;
      tip -= off * nudge / (hanging(part, tip + nudge).clamp - off);
    }
    if (!(std::abs(off) < enough)) return {};
  }
  return hanging({gamma, natural, twist}, tip).least > 0.0;
}

namespace {

/// From the foot to the clamp: lean θ from the vertical, θ' = -M/B, place, and the energy 2 E/B.
/// `force`: of the ground, at `toward` from the vertical: θ'' = -force sin(θ - toward).
using PushedState = Eigen::Matrix<double, 5, 1>;
PushedState pushed_up(double foot, double force, double toward) {
  PushedState y = PushedState::Zero();
  y[0] = foot;
  const double h = 1.0 / kSteps;
  for (int i = 0; i < kSteps; ++i)
    y = runge_kutta(y, 0.0, h, [&](double, const PushedState& z) {
      PushedState slope;
      slope << z[1], -force * std::sin(z[0] - toward), std::sin(z[0]), std::cos(z[0]), z[1] * z[1];
      return slope;
    });
  return y;
}

/// Newton's method for (lean of the foot, force, direction of the force).
bool solve_pushed(Vec3& unknown, const PushPath& path, double descent) {
  constexpr int iterations = 50;
  constexpr double nudge = 1e-6, enough = 1e-10;
  const auto off = [&](const Vec3& u) {
    const PushedState top = pushed_up(u[0], u[1], u[2]);
    return Vec3(top[0] - path.lean, top[2] - std::sin(path.lean) - path.sideways,
                top[3] - std::cos(path.lean) + descent);
  };
  for (int i = 0; i < iterations; ++i) {
    const Vec3 error = off(unknown);
    if (error.norm() < enough) return true;
    Mat3 slope;
    for (int k = 0; k < 3; ++k) {
      Vec3 moved = unknown;
      moved[k] += nudge;
      slope.col(k) = (off(moved) - error) / nudge;
    }
    unknown -= slope.partialPivLu().solve(error);
  }
  return false;
}

}  // namespace

std::vector<Pushed> pushed_strip(const PushPath& path) {
  // To begin with, the column that is clamped above and pinned below: tan k = k, and the force
  // leaves the chord by A where the chord is shorter by 5.05 A². Of its two sides the strip takes
  // that of less energy.
  constexpr double k = 4.4934, of_foot = 5.603, of_short = 5.05, step = 0.005;
  const double x = std::sin(path.lean) + path.sideways, z = std::cos(path.lean) - path.first;
  Vec3 unknown = Vec3::Zero();
  double least = HUGE_VAL;
  for (const double side : {-1.0, 1.0}) {
    const double a = side * std::sqrt((1.0 - std::hypot(x, z)) / of_short);
    Vec3 guess(std::atan2(x, z) + of_foot * a, k * k, std::atan2(x, z) + a);
    if (!solve_pushed(guess, path, path.first)) continue;
    const double energy = pushed_up(guess[0], guess[1], guess[2])[4];
    if (energy < least) unknown = guess;
    least = std::min(least, energy);
  }
  std::vector<Pushed> states;
  for (int i = 0; path.first + i * step <= path.last; ++i) {
    const double descent = path.first + i * step;
    // A foot that leans by more than a right angle would lie on the ground.
    if (!solve_pushed(unknown, path, descent) || std::abs(unknown[0]) > 0.5 * std::numbers::pi)
      break;
    states.push_back({descent, std::tan(unknown[2])});
  }
  return states;
}

std::optional<double> slip_descent(const std::vector<Pushed>& states, double friction) {
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (std::abs(states[i].ratio) < friction) continue;
    if (i == 0) return states[0].descent;
    const double before = std::abs(states[i - 1].ratio), after = std::abs(states[i].ratio);
    const double share = (friction - before) / (after - before);
    return states[i - 1].descent + share * (states[i].descent - states[i - 1].descent);
  }
  return {};
}

// -- simulation -----------------------------------------------------------------------------------

namespace {

constexpr double kLength = 0.1, kGravity = 9.81, kDensity = 0.2;  // m, m/s², kg/m²

/// Side of a cell where the clamp is in the middle of the first one, because a hinge bends half of
/// the cells on both its sides. Twist begins at the second column instead.
double cell_of(int cells) { return kLength / (cells + 0.5); }

double rigidity(double gamma) { return kDensity * kGravity * kLength * kLength * kLength / gamma; }

std::string number(double x) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.12g", x);
  return text.data();
}

/// The scene of a strip with these cells of side `d`; `rows` across. `with`: its clamp and its
/// place, which in the files are those of 20 cells.
Scene strip_scene(const SlenderStrips& strips, const char* name, int rows, double d, double bending,
                  std::vector<Override> with) {
  with.push_back(
      {"geometry.0.size", "[" + number((strips.cells + 1) * d) + "," + number(rows * d) + "]"});
  with.push_back({"geometry.0.cells",
                  "[" + std::to_string(strips.cells + 1) + "," + std::to_string(rows) + "]"});
  with.push_back({"materials.default.bending_stiffness", number(bending)});
  return read_scene(strips.folder / (std::string(name) + ".json"), with);
}

/// The clamp holds two columns at the end with the smallest x, for any number of cells.
Override clamp_of_two_columns(int cells, double d) {
  const double end = -0.5 * (cells + 1) * d;
  return {"handles.0.select.box",
          "[[" + number(end - 0.5 * d) + ",-0.05,0.1],[" + number(end + 1.5 * d) + ",0.05,0.3]]"};
}

/// The same at the upper end of the strip that stands on the ground and leans by 10°, and its
/// place.
std::vector<Override> standing(int cells, double d) {
  // m; the rest gap and a little: a foot that stands from the first step on makes the strip buckle
  // to the other side, where it stores more energy.
  constexpr double gap = 0.0005 + 1.918e-6;
  const double upwards = std::cos(PushPath{}.lean), half = 0.5 * (cells + 1) * d;
  const double middle = gap + upwards * half;
  return {{"geometry.0.transformation.translation", "[0,0," + number(middle) + "]"},
          {"handles.0.select.box",
           "[[-0.05,-0.05," + number(middle + upwards * (half - 1.5 * d)) + "],[0.05,0.05,0.2]]"}};
}

/// Mean place of the column of particles `from_end` columns before the end with the largest index.
Vec3 column(std::span<const Vec3> x, int columns, int at) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (std::size_t i = at; i < x.size(); i += columns, ++count) sum += x[i];
  return sum / count;
}

/// Runs until nothing moves, however long the scene is. Near a critical load that takes long.
std::vector<Vec3> settle(Scene scene) {
  constexpr double at_rest = 2e-6;              // m/s
  constexpr int warm_up = 30, most_times = 20;  // frames, and the scene's length
  const int most = scene.time.frames *= most_times;
  Simulation simulation(scene);
  for (int frame = 1; frame <= most; ++frame) {
    simulation.advance_to_frame(frame);
    double fastest = 0.0;
    for (const Vec3& v : simulation.velocities()) fastest = std::max(fastest, v.norm());
    if (frame > warm_up && fastest < at_rest)
      return {simulation.positions().begin(), simulation.positions().end()};
  }
  throw std::runtime_error("the strip still moves after " + std::to_string(most) + " frames");
}

/// Implicit steps until nothing moves; particles up to `held` (m along x at rest) are held.
std::vector<Vec3> settle(const ClothMesh& cloth, const std::vector<char>& held,
                         const Vec3& gravity) {
  constexpr double h = 0.01, at_rest = 1e-6;
  constexpr int most = 4000, warm_up = 20;
  const std::size_t n = cloth.mass.size();
  Particles p{cloth.surface.vertices, std::vector<Vec3>(n, Vec3::Zero()), cloth.mass, {}};
  for (std::size_t i = 0; i < n; ++i) p.inv_mass.push_back(held[i] != 0 ? 0.0 : 1.0 / p.mass[i]);
  ForceList forces = make_internal_forces(cloth);
  forces.push_back(make_gravity(gravity));
  const auto integrator =
      integrators().at("implicit_euler")(std::move(forces), n, ImplicitConfig{1e-9, 5000});
  double fastest = 1.0;
  for (int step = 0; step < most && (fastest > at_rest || step < warm_up); ++step) {
    integrator->begin({p, step * h, h}, {});
    std::vector<Vec3> v = p.v;
    integrator->solve({}, {v, {}}, 1.0);
    p.v = std::move(v);
    fastest = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      p.x[i] += h * p.v[i];
      fastest = std::max(fastest, p.v[i].norm());
    }
    integrator->accept({p.x, p.v, p.mass, (step + 1) * h});
  }
  return std::move(p.x);
}

/// -∂f_z/∂z of the forces, by central differences, among the particles that are not held.
Eigen::MatrixXd stiffness_across(const ForceList& forces, const ClothMesh& cloth,
                                 std::vector<Vec3> x, const std::vector<char>& held) {
  constexpr double nudge = 1e-7;  // m
  std::vector<std::size_t> free;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (held[i] == 0) free.push_back(i);
  const std::vector<Vec3> still(x.size(), Vec3::Zero());
  const auto force = [&] {
    std::vector<Vec3> f(x.size(), Vec3::Zero());
    for (const auto& one : forces) one->add_force({x, still, cloth.mass, 0.0}, f);
    return f;
  };
  const auto n = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd k(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    x[free[j]].z() = nudge;
    const std::vector<Vec3> up = force();
    x[free[j]].z() = -nudge;
    const std::vector<Vec3> down = force();
    x[free[j]].z() = 0.0;
    for (Eigen::Index i = 0; i < n; ++i)
      k(i, j) = (down[free[i]].z() - up[free[i]].z()) / (2.0 * nudge);
  }
  return 0.5 * (k + k.transpose());
}

}  // namespace

double SlenderStrips::cantilever(double gamma, double natural) const {
  const double d = cell_of(cells);
  const int columns = cells + 2;
  if (natural == 0.0) {
    const std::vector<Vec3> x = settle(
        strip_scene(*this, "cantilever", 4, d, rigidity(gamma), {clamp_of_two_columns(cells, d)}));
    const Vec3 way =
        column(x, columns, columns - 1) - 0.5 * (column(x, columns, 0) + column(x, columns, 1));
    return -way.z() / way.x();
  }
  Material m;
  m.density = kDensity;
  m.stretch_stiffness = 2000.0;
  m.bending_stiffness = rigidity(gamma);
  m.bending_damping = 0.05;
  TriangleMesh rest = make_rectangular({(cells + 1) * d, 4 * d, cells + 1, 4}, m).surface;
  const double clamp = -0.5 * (cells + 1) * d + 0.5 * d, bend = natural / kLength;
  std::vector<char> held;
  for (Vec3& x : rest.vertices) {
    const double s = x.x() - clamp;
    held.push_back(s < 0.6 * d ? 1 : 0);
    x = Vec3(std::sin(bend * s) / bend, x.y(), -(1.0 - std::cos(bend * s)) / bend);
  }
  const ClothMesh cloth = make_from_mesh(rest, rest, m);
  const std::vector<Vec3> x = settle(cloth, held, {0.0, 0.0, -kGravity});
  const Vec3 tip = column(x, columns, columns - 1);
  return -tip.z() / tip.x();
}

namespace {

/// A strip of finite elements, curved at rest about its breadth (y), from the clamp at 0 along x
/// and towards +z; two columns of particles are clamped, at 0 and before.
struct CurvedStrip {
  ClothMesh cloth;
  std::vector<char> held;
};
constexpr double kMembrane = 2e4, kBreadth = 0.05;  // N/m; over the length
CurvedStrip curved_strip(int cells, double gamma, double natural) {
  const double d = kLength / cells, bend = natural / kLength;
  const int rows = std::max(2, static_cast<int>(std::lround(kBreadth * cells)));
  Material m;
  m.density = kDensity;
  m.stretch_stiffness = kMembrane;
  m.shear_stiffness = 0.5 * m.stretch_stiffness;
  m.poisson = 0.0;
  m.stretch_law = "corotated";
  m.bending_stiffness = rigidity(gamma);
  m.bending_damping = 0.05;
  Material bare;
  bare.shear_stiffness = 0.0;
  TriangleMesh rest =
      make_simplified({(cells + 1) * d, kBreadth * kLength, cells + 1, rows}, bare, true).surface;
  std::vector<char> held;
  for (Vec3& x : rest.vertices) {
    const double s = x.x() + 0.5 * (cells + 1) * d - d;
    held.push_back(s < 0.1 * d ? 1 : 0);
    x = Vec3(std::sin(bend * s) / bend, x.y(), (1.0 - std::cos(bend * s)) / bend);
  }
  return {make_from_mesh(rest, rest, m), held};
}

}  // namespace

StripLoad SlenderStrips::bend_twist_load(double gamma, double natural) {
  const double breadth = kBreadth * kLength;
  return {gamma, natural, kBreadth, kMembrane * breadth * breadth / (12.0 * rigidity(gamma))};
}

BendTwist SlenderStrips::bend_twist(double gamma, double natural) const {
  const auto [cloth, held] = curved_strip(cells, gamma, natural);
  const std::vector<Vec3> x = settle(cloth, held, {0.0, -kGravity, 0.0});
  const Vec3 tip = column(x, cells + 2, cells + 1) / kLength;
  return {-tip.y(), tip.x()};
}

double SlenderStrips::out_of_plane(double gamma, double natural, double turn) const {
  auto [cloth, held] = curved_strip(cells, gamma, natural);
  for (Vec3& x : cloth.surface.vertices) {
    const double part = std::max(0.0, x.x()) / kLength;
    x.y() += turn * part * x.z();
  }
  const std::vector<Vec3> x = settle(cloth, held, {kGravity, 0.0, 0.0});
  return std::abs(column(x, cells + 2, cells + 1).y()) / kLength;
}

double SlenderStrips::buckling_gamma(double breadth) const {
  const double d = kLength / cells;
  const int rows = std::max(2, static_cast<int>(std::lround(breadth * kLength / d)));
  Material m;
  m.density = kDensity;
  m.stretch_stiffness = 2e4;
  m.shear_stiffness = 1e4;
  m.poisson = 0.0;
  m.stretch_law = "corotated";
  m.bending_stiffness = 1.0;
  Material bare;
  bare.shear_stiffness = 0.0;
  const TriangleMesh flat =
      make_simplified({(cells + 1) * d, breadth * kLength, cells + 1, rows}, bare, true).surface;
  const ClothMesh cloth = make_from_mesh(flat, flat, m);
  std::vector<char> held;
  for (const Vec3& x : cloth.surface.vertices)
    held.push_back(x.x() < -0.5 * (cells + 1) * d + 1.1 * d ? 1 : 0);
  const std::vector<Vec3> x = settle(cloth, held, {0.0, -kGravity, 0.0});
  ForceList stretch, bending;
  stretch.push_back(make_membrane_force(cloth.membranes, cloth.membranes.front().strain, x.size()));
  bending.push_back(make_shape_operator_force(cloth.hinges, cloth.couples, x.size()));
  // B K_b + K_s is singular for the largest eigenvalue B of -K_b⁻¹ K_s.
  const Eigen::MatrixXd own = stiffness_across(bending, cloth, x, held);
  const Eigen::MatrixXd load = -stiffness_across(stretch, cloth, x, held);
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(load, own,
                                                                         Eigen::EigenvaluesOnly);
  const double largest = solver.eigenvalues().maxCoeff();
  return kDensity * kGravity * kLength * kLength * kLength / largest;
}

double SlenderStrips::buckled(double gamma) const {
  const double d = kLength / cells;
  const std::vector<Vec3> x = settle(strip_scene(*this, "lateral_buckling", 2, d, rigidity(gamma),
                                                 {clamp_of_two_columns(cells, d)}));
  return std::abs(column(x, cells + 2, cells + 1).y()) / kLength;
}

std::vector<Pushed> SlenderStrips::pushed(double friction) const {
  constexpr double bending = 1e-5, begin = 1.0, speed = (0.03 - 0.0005) / 6.0;  // N·m, s, m/s
  const double d = cell_of(cells);
  Scene scene = strip_scene(*this, "stick_slip", 4, d, bending, standing(cells, d));
  for (BodySpec& body : scene.bodies) body.friction = friction;
  Simulation simulation(scene);
  std::vector<Pushed> states;
  for (int frame = 1; frame <= scene.time.frames; ++frame) {
    simulation.advance_to_frame(frame);
    if (simulation.time() < begin) continue;
    Vec3 push = Vec3::Zero();
    for (const StepContact& c : simulation.contacts()) push += c.impulse;
    const double foot = column(simulation.positions(), cells + 2, 0).x() / kLength;
    states.push_back({PushPath{}.first + (simulation.time() - begin) * speed / kLength,
                      push.x() / push.z(), foot});
  }
  return states;
}

std::optional<double> SlenderStrips::slip(double friction) const {
  constexpr double moved = 0.001;
  const std::vector<Pushed> states = pushed(friction);
  for (const Pushed& state : states)
    if (std::abs(state.foot - states.front().foot) > moved) return state.descent;
  return {};
}

}  // namespace selvedge::testing
