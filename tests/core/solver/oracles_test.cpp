// SPDX-License-Identifier: MIT
//
// Closed forms and tables of mechanics that the cloth must meet.
#include <selvedge/core/cloth/cloth_elements.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/detail/dihedral.h>
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/core/solver/integrator.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace selvedge::oracles_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double g = 9.81;

using Vectors = std::vector<Vec3>;
using Forces = std::vector<std::unique_ptr<Force>>;

Particles make_particles(const Vectors& x, const std::vector<double>& mass) {
  Particles p{x, Vectors(x.size(), Vec3::Zero()), mass, {}};
  for (const double m : mass) p.inv_mass.push_back(1.0 / m);
  return p;
}

void hold(Particles& p, std::size_t i) { p.inv_mass[i] = 0.0; }

double largest_speed(const Particles& p) {
  double speed = 0.0;
  for (const Vec3& v : p.v) speed = std::max(speed, v.norm());
  return speed;
}

void implicit_step(Integrator& integrator, Particles& p, double h) {
  integrator.begin({p, 0.0, h}, {});
  Vectors v = p.v;
  for (std::size_t i = 0; i < v.size(); ++i)
    if (p.inv_mass[i] <= 0.0) v[i].setZero();
  EXPECT_TRUE(integrator.solve({}, {v, {}}, 1.0).converged);
  p.v = v;
  for (std::size_t i = 0; i < v.size(); ++i) p.x[i] += h * v[i];
}

/// Steps until nothing moves faster than `speed`; the steps taken.
int relax(Forces forces, Particles& p, double h, double speed, int most_steps) {
  const auto integrator =
      integrators().at("implicit_euler")(std::move(forces), p.size(), ImplicitConfig{1e-11, 5000});
  int steps = 0;
  do {
    implicit_step(*integrator, p, h);
    ++steps;
  } while (largest_speed(p) > speed && steps < most_steps);
  EXPECT_LE(largest_speed(p), speed) << "not at rest after " << steps << " steps";
  return steps;
}

Forces cloth_forces(ClothMesh cloth, const Vec3& gravity) {
  for (Spring& s : cloth.springs) s.damping = 0.0;
  for (Hinge& h : cloth.hinges) h.damping = 0.0;
  Forces forces;
  forces.push_back(make_hooke_force(cloth.springs, cloth.mass.size()));
  forces.push_back(make_bending_force(cloth.hinges, cloth.mass.size()));
  forces.push_back(make_gravity(gravity));
  return forces;
}

TEST(Strip, HangsByItsWeightOverTwiceItsStiffness) {
  Material material;
  material.shear_stiffness = 0.0;
  material.bending_stiffness = 0.0;
  for (const int cells : {1, 7, 40}) {
    const ClothMesh cloth = make_rectangular({0.1, 1.0, 1, cells}, material);
    Particles p = make_particles(cloth.surface.vertices, cloth.mass);
    hold(p, p.size() - 1);
    hold(p, p.size() - 2);
    relax(cloth_forces(cloth, {0, -g, 0}), p, 0.5, 1e-12, 400);
    const double stretch = -0.5 - p.x[0].y();  // ΔL = ρ g L²/(2K)
    EXPECT_NEAR(stretch / (0.2 * g / 1000.0), 1.0, 1e-9) << cells << " cells";
  }
}

/// Energy per area of the springs under a small uniform strain.
double strain_energy(const ClothMesh& cloth, double area, double xx, double yy, double xy) {
  Vectors x = cloth.surface.vertices;
  for (Vec3& p : x) p = Vec3((1.0 + xx) * p.x() + xy * p.y(), (1.0 + yy) * p.y(), 0.0);
  const auto force = make_hooke_force(cloth.springs, x.size());
  return force->energy({x, x, cloth.mass, 0.0}) / area;
}

TEST(Fabric, ARectangularMeshHasTheFabricsConstants) {
  constexpr double strain = 1e-5;
  const double half_square = 0.5 * strain * strain;
  for (const int cells_y : {4, 5, 6}) {
    Material material;  // K = 500, G = 100
    const ClothMesh cloth = make_rectangular({1.0, 1.0, 5, cells_y}, material);
    const double c11 = strain_energy(cloth, 1.0, strain, 0, 0) / half_square;
    const double c22 = strain_energy(cloth, 1.0, 0, strain, 0) / half_square;
    const double c33 = strain_energy(cloth, 1.0, 0, 0, strain) / half_square;
    const double both = strain_energy(cloth, 1.0, strain, strain, 0) / half_square;
    const double c12 = 0.5 * (both - c11 - c22);
    EXPECT_NEAR(c11 - c12 * c12 / c22, 500.0, 0.02);  // strip test with free sides
    EXPECT_NEAR(c22 - c12 * c12 / c11, 500.0, 0.02);
    EXPECT_NEAR(c33, 100.0, 0.02);  // shear frame: force per width and angle
    EXPECT_NEAR(c12, 100.0, 0.02);  // what every spring net couples
  }
}

TEST(Fabric, EquilateralTrianglesAreIsotropicWithPoissonsRatioOneThird) {
  constexpr double strain = 1e-5;
  const double half_square = 0.5 * strain * strain;
  const double height = 200 * 0.01 * std::sqrt(0.75);
  const ClothMesh cloth = make_triangular({2.0, height, 200, 200}, Material{});
  const double area = 2.0 * height;
  const double c11 = strain_energy(cloth, area, strain, 0, 0) / half_square;
  const double c22 = strain_energy(cloth, area, 0, strain, 0) / half_square;
  const double c33 = strain_energy(cloth, area, 0, 0, strain) / half_square;
  // E/(1-ν²) = 9/8 E and E/(2(1+ν)) = 3/8 E, but for the halved triangles of the two borders.
  EXPECT_NEAR(c11, 9.0 / 8.0 * 500.0, 4.0);
  EXPECT_NEAR(c22, 9.0 / 8.0 * 500.0, 4.0);
  EXPECT_NEAR(c33, 3.0 / 8.0 * 500.0, 2.0);
}

/// The mesh rolled on a cylinder of radius r whose curved direction is at `angle` to the x-axis.
Vectors rolled(const Vectors& flat, double r, double angle) {
  const Vec3 n(std::cos(angle), std::sin(angle), 0.0), t(-n.y(), n.x(), 0.0);
  Vectors x;
  for (const Vec3& p : flat) {
    const double s = n.dot(p) / r;
    x.push_back(r * std::sin(s) * n + t.dot(p) * t + Vec3(0, 0, r * (1.0 - std::cos(s))));
  }
  return x;
}

/// Bending energy of the hinges whose edge has its middle in the square of half side `half`, per
/// area of this square: free of the border.
double bending_energy(const ClothMesh& cloth, const Vectors& x, double half) {
  std::vector<Hinge> inner;
  for (const Hinge& hinge : cloth.hinges) {
    const Vec3 middle =
        0.5 * (cloth.surface.vertices[hinge.v[2]] + cloth.surface.vertices[hinge.v[3]]);
    const auto inside = [&](double c) { return c > -half && c < half; };
    if (inside(middle.x() + 1e-7) && inside(middle.y() + 1e-7)) inner.push_back(hinge);
  }
  const auto force = make_bending_force(inner, x.size());
  return force->energy({x, x, cloth.mass, 0.0}) / (4.0 * half * half);
}

/// A grid with every vertex moved and every diagonal drawn at random.
TriangleMesh random_mesh(int cells) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> shift(-0.25 / cells, 0.25 / cells);
  TriangleMesh mesh;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i)
      mesh.vertices.emplace_back(double(i) / cells - 0.5 + shift(generator),
                                 double(j) / cells - 0.5 + shift(generator), 0.0);
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = j * (cells + 1) + i, b = a + 1, c = a + cells + 2, d = a + cells + 1;
      if (generator() % 2 == 0) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
      } else {
        mesh.triangles.push_back({a, b, d});
        mesh.triangles.push_back({b, c, d});
      }
    }
  return mesh;
}

TEST(Plate, RolledToACylinderItStoresHalfItsRigidityTimesCurvatureSquared) {
  Material material;
  material.bending_stiffness = 2e-5;
  constexpr double r = 2.0;
  const double exact = 0.5 * 2e-5 / (r * r);
  const ClothMesh square = make_rectangular({1, 1, 50, 50}, material);
  const ClothMesh oblong = make_rectangular({1, 1, 50, 40}, material);
  // Each hinge by itself has the plate's energy on the mean of the directions (shape_operator_test
  // has what is exact).
  const TriangleMesh noise = random_mesh(60);
  material.bending_law = "hinge";
  const ClothMesh triangular =
      make_triangular({2.0, 100 * 0.02 * std::sqrt(0.75), 100, 100}, material);
  const ClothMesh random = make_from_mesh(noise, noise, material);
  for (const double angle : {0.0, pi / 8, pi / 4, pi / 2, 2.0}) {
    const auto energy = [&](const ClothMesh& cloth, double half) {
      return bending_energy(cloth, rolled(cloth.surface.vertices, r, angle), half) / exact;
    };
    EXPECT_NEAR(energy(square, 0.4), 1.0, 1e-3) << angle;
    EXPECT_NEAR(energy(oblong, 0.4), 1.0, 1e-3) << angle;
    EXPECT_NEAR(energy(triangular, 0.6), 1.0, 0.02) << angle;
    EXPECT_NEAR(energy(random, 0.4), 1.0, 0.2) << angle;
  }
}

/// y/x of the tip of a heavy strip clamped horizontally, Γ = ρ g L³/B, `elements` per length.
double cantilever_slope(double gamma, int elements) {
  constexpr double length = 0.1;
  // A hinge bends the half cells on its two sides, so the clamp stands in the middle of the held
  // first cell: the free length is half a cell more than the free cells.
  const double d = length / (elements + 0.5);
  Material material;
  material.stretch_stiffness = 2000.0;
  material.bending_stiffness = 0.2 * g * length * length * length / gamma;
  const ClothMesh cloth = make_rectangular({(elements + 1) * d, d, elements + 1, 1}, material);
  Particles p = make_particles(cloth.surface.vertices, cloth.mass);
  const std::size_t row = elements + 2;
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}, row, row + 1}) hold(p, i);
  const double clamp = cloth.surface.vertices[0].x() + 0.5 * d;
  relax(cloth_forces(cloth, {0, 0, -g}), p, 0.02, 1e-7, 3000);
  const Vec3 tip = p.x[row - 1];
  return -tip.z() / (tip.x() - clamp);
}

TEST(Cantilever, FollowsTheHeavyElastica) {
  // y/x of the tip, by integration of the elastica's differential equation.
  const std::vector<std::array<double, 2>> table{
      {1.0, 0.12456}, {2.0, 0.24667}, {5.0, 0.58572}, {10.0, 1.06680}, {20.0, 1.86393}};
  for (const auto& [gamma, slope] : table)
    EXPECT_NEAR(cantilever_slope(gamma, 20) / slope, 1.0, 0.02) << "Γ = " << gamma;
}

TEST(Cantilever, ConvergesWithSecondOrder) {
  const double coarse = std::abs(cantilever_slope(5.0, 5) / 0.58572 - 1.0);
  const double fine = std::abs(cantilever_slope(5.0, 10) / 0.58572 - 1.0);
  EXPECT_LT(fine, coarse / 3.0) << coarse << " " << fine;
}

/// A spring from a held particle at the origin to mass m at 1 + amplitude along x.
struct Oscillator {
  static constexpr double m = 0.01, k = 100.0, omega = 100.0, amplitude = 0.01;
  Particles p = make_particles({{0, 0, 0}, {1.0 + amplitude, 0, 0}}, {m, m});
  Oscillator() { hold(p, 0); }
  static Forces forces(double damping = 0.0) {
    Forces f;
    const std::vector<Spring> spring{{0, 1, 1.0, k, damping}};
    f.push_back(make_hooke_force(spring, 2));
    return f;
  }
  Eigen::Vector2d phase() const { return {p.x[1].x() - 1.0, p.v[1].x() / omega}; }
};

/// Error in phase space at time `t` with n steps.
double oscillator_error(bool implicit, double t, int n) {
  Oscillator o;
  const double h = t / n;
  const auto be =
      integrators().at("implicit_euler")(Oscillator::forces(), 2, ImplicitConfig{1e-14, 100});
  const auto se = integrators().at("symplectic_euler")(Oscillator::forces(), 2, ImplicitConfig{});
  for (int i = 0; i < n; ++i) {
    if (implicit) {
      implicit_step(*be, o.p, h);
    } else {
      Vectors v(2, Vec3::Zero());
      se->begin({o.p, 0.0, h}, {v, {}});
      o.p.v = v;
      o.p.x[1] += h * v[1];
    }
  }
  const double angle = Oscillator::omega * t;
  const Eigen::Vector2d exact(std::cos(angle), -std::sin(angle));
  return (o.phase() - Oscillator::amplitude * exact).norm();
}

TEST(OscillatorOracle, BothEulersAreOfFirstOrder) {
  const double t = 0.6 * 2.0 * pi / Oscillator::omega;
  for (const bool implicit : {false, true}) {
    const double coarse = oscillator_error(implicit, t, 400);
    const double fine = oscillator_error(implicit, t, 400 * 32);
    EXPECT_NEAR(std::log2(coarse / fine) / 5.0, 1.0, 0.1) << implicit;
  }
}

TEST(OscillatorOracle, BackwardEulerLosesItsKnownAmplitude) {
  Oscillator o;
  const auto be =
      integrators().at("implicit_euler")(Oscillator::forces(), 2, ImplicitConfig{1e-14, 100});
  for (int i = 0; i < 100; ++i) implicit_step(*be, o.p, 2.0 * pi / Oscillator::omega / 100);
  EXPECT_NEAR(o.phase().norm() / Oscillator::amplitude, 0.8212, 1e-4);
}

TEST(OscillatorOracle, SymplecticEulerIsStableBelowItsStepBoundOnly) {
  for (const double damping : {0.0, 0.005, 0.1}) {
    // Two free masses: ω² = 2k/m, for which the bound is exact.
    for (const double factor : {0.98, 1.02}) {
      Particles p = make_particles({{0, 0, 0}, {1.001, 0, 0}}, {0.01, 0.01});
      const auto se =
          integrators().at("symplectic_euler")(Oscillator::forces(damping), 2, ImplicitConfig{});
      const double h = factor * se->stable_step(p, 0.0, std::numeric_limits<double>::infinity());
      for (int i = 0; i < 500; ++i) {
        Vectors v(2);
        se->begin({p, 0.0, h}, {v, {}});
        p.v = v;
        for (int k = 0; k < 2; ++k) p.x[k] += h * v[k];
      }
      const double stretch = std::abs((p.x[1] - p.x[0]).norm() - 1.0);
      if (factor < 1.0) {
        EXPECT_LT(stretch, 0.02) << damping;
      } else {
        EXPECT_GT(stretch, 0.1) << damping;
      }
    }
  }
}

/// Time of the n-th passage of `value()` through zero, interpolated.
template <class Step, class Value>
double crossing(Step step, Value value, double h, int n) {
  double before = value();
  for (int i = 1; i < 1000000; ++i) {
    step();
    const double now = value();
    if (before * now < 0.0 && --n == 0) return h * (i - now / (now - before));
    before = now;
  }
  return 0.0;
}

void symplectic_step(Integrator& integrator, Particles& p, double h, Vectors& v) {
  std::fill(v.begin(), v.end(), Vec3::Zero());
  integrator.begin({p, 0.0, h}, {v, {}});
  p.v = v;
  for (std::size_t i = 0; i < p.size(); ++i) p.x[i] += h * v[i];
}

TEST(PendulumOracle, SwingsWithTheEllipticPeriod) {
  const std::vector<std::array<double, 2>> table{
      {10, 2.009893}, {30, 2.040990}, {60, 2.152875}, {90, 2.367842}};
  for (const auto& [degrees, period] : table) {
    const double a = degrees * pi / 180.0, h = 1e-4;
    Particles p = make_particles({{0, 0, 0}, {std::sin(a), 0, -std::cos(a)}}, {1.0, 1.0});
    hold(p, 0);
    Forces forces;
    const std::vector<Spring> spring{{0, 1, 1.0, 1e6, 1e-5}};
    forces.push_back(make_hooke_force(spring, 2));
    forces.push_back(make_gravity({0, 0, -g}));
    const auto se = integrators().at("symplectic_euler")(std::move(forces), 2, ImplicitConfig{});
    Vectors v(2);
    const auto step = [&] { symplectic_step(*se, p, h, v); };
    const auto value = [&] { return p.x[1].x(); };
    const double first = crossing(step, value, h, 1);
    EXPECT_NEAR((first + crossing(step, value, h, 2)) / 1.25, period, 3e-4) << degrees;
  }
}

TEST(ChainOracle, SwingsInItsFirstModes) {
  // A chain of length 1 hung at one end swings as J0(z sqrt(s)), s from the free end, with period
  // 4π/(z sqrt(g)), z a zero of J0.
  constexpr int n = 120;
  constexpr double d = 1.0 / n, k = 2e5, h = 1e-4;
  for (const double z : {2.404826, 5.520078}) {
    Vectors x;
    std::vector<double> mass;
    std::vector<Spring> springs;
    for (int i = 0; i <= n; ++i) {
      const double s = i * d;
      x.emplace_back(1e-4 * std::cyl_bessel_j(0.0, z * std::sqrt(s)), 0.0, s);
      mass.push_back(i == 0 || i == n ? 0.5 * d : d);
      // Under the weight below it, every link is d long.
      if (i > 0) springs.push_back({i - 1, i, d - (i - 0.5) * d * g / k, k});
    }
    Particles p = make_particles(x, mass);
    hold(p, n);
    Forces forces;
    forces.push_back(make_hooke_force(springs, n + 1));
    forces.push_back(make_gravity({0, 0, -g}));
    const auto se =
        integrators().at("symplectic_euler")(std::move(forces), n + 1, ImplicitConfig{});
    Vectors v(n + 1);
    const auto step = [&] { symplectic_step(*se, p, h, v); };
    // The free end starts at its largest deflection: zero after a quarter period.
    const double quarter = crossing(
        step, [&] { return p.x[0].x(); }, h, 1);
    EXPECT_NEAR(4.0 * quarter / (4.0 * pi / (z * std::sqrt(g))), 1.0, 2e-3) << z;
  }
}

TEST(ChainOracle, HangsInACatenary) {
  for (const auto& [span, sag] :
       std::vector<std::array<double, 2>>{{0.5, 0.398194}, {0.8, 0.265438}, {0.9, 0.190709}}) {
    constexpr int n = 60;
    Vectors x;
    std::vector<Spring> springs;
    for (int i = 0; i <= n; ++i) {
      x.emplace_back(span * i / n, 0.0, 0.0);
      if (i > 0) springs.push_back({i - 1, i, 1.0 / n, 1e7});
    }
    for (int i = 0; i <= n; ++i)  // a parabola to start from: compressed springs have no side
      x[i].z() = -4.0 * sag * i * (n - i) / (n * n);
    Particles p = make_particles(x, std::vector<double>(n + 1, 1.0 / n));
    hold(p, 0);
    hold(p, n);
    Forces forces;
    forces.push_back(make_hooke_force(springs, n + 1));
    forces.push_back(make_gravity({0, 0, -g}));
    relax(std::move(forces), p, 0.03, 1e-7, 3000);
    EXPECT_NEAR(-p.x[n / 2].z() / sag, 1.0, 1e-3) << span;
  }
}

TEST(DragOracle, AFallingTriangleFollowsTheExponential) {
  // Vertex area 1/6 m², viscous drag 0.12 N·s/m³: c = 0.02 N·s/m at m = 0.01 kg.
  const Vectors x{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<Triangle> triangles{{0, 1, 2}};
  const std::vector<double> areas{0.5};
  Particles p = make_particles(x, {0.01, 0.01, 0.01});
  Forces forces;
  forces.push_back(make_air_force({Vec3::Zero(), 0.0, 0.12}, triangles, areas, 3));
  forces.push_back(make_gravity({0, 0, -g}));
  const auto be =
      integrators().at("implicit_euler")(std::move(forces), 3, ImplicitConfig{1e-13, 100});
  constexpr double h = 1e-4;
  for (int i = 0; i < 10000; ++i) implicit_step(*be, p, h);
  EXPECT_NEAR(-p.v[0].z(), 4.2411, 2e-4);
  for (int i = 0; i < 100; ++i) implicit_step(*be, p, 1.0);
  EXPECT_NEAR(-p.v[0].z(), 4.905, 1e-9);
}

TEST(WindOracle, AHungPlateStandsAtItsAngle) {
  Material material;
  material.stretch_stiffness = 1e4;
  const ClothMesh cloth = make_rectangular({0.1, 0.5, 1, 10}, material);
  Particles p = make_particles(cloth.surface.vertices, cloth.mass);
  hold(p, p.size() - 1);
  hold(p, p.size() - 2);
  const std::vector<double> areas(cloth.surface.triangles.size(), 0.1 * 0.05 / 2.0);
  Forces forces = cloth_forces(cloth, {0, -g, 0});
  forces.push_back(
      make_air_force({{0, 0, 3.0}, 0.5, 0.0}, cloth.surface.triangles, areas, p.size()));
  relax(std::move(forces), p, 0.02, 1e-7, 3000);
  const Vec3 plate = p.x[0] - p.x[p.size() - 2];
  // tan φ = C V/(ρ g)
  EXPECT_NEAR(std::atan2(plate.z(), -plate.y()) * 180.0 / pi, 37.40, 0.1);
}

}  // namespace
}  // namespace selvedge::oracles_test
