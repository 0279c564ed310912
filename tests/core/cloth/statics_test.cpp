// SPDX-License-Identifier: MIT
//
// Statics of strips and patches: what a pull, a shear and the weight make of a sheet.
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/core/solver/integrator.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace selvedge::statics_test {
namespace {

constexpr double g = 9.81;

/// Steps of implicit Euler, which damps, until nothing moves faster than `speed`.
std::vector<Vec3> at_rest(std::vector<std::unique_ptr<Force>> forces, const ClothMesh& cloth,
                          const std::vector<std::int32_t>& held, std::vector<Vec3> x, double h,
                          double speed) {
  const std::size_t n = cloth.mass.size();
  Particles p{std::move(x), std::vector<Vec3>(n, Vec3::Zero()), cloth.mass, {}};
  for (const double m : p.mass) p.inv_mass.push_back(1.0 / m);
  for (const std::int32_t i : held) p.inv_mass[i] = 0.0;
  const auto integrator =
      integrators().at("implicit_euler")(std::move(forces), n, ImplicitConfig{1e-10, 5000});
  double fastest = 1.0;
  for (int step = 0; step < 3000 && (fastest > speed || step < 5); ++step) {
    integrator->begin({p, 0.0, h}, {});
    std::vector<Vec3> v = p.v;
    EXPECT_TRUE(integrator->solve({}, {v, {}}, 1.0).converged);
    p.v = v;
    fastest = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      p.x[i] += h * v[i];
      fastest = std::max(fastest, v[i].norm());
    }
  }
  EXPECT_LE(fastest, speed);
  return p.x;
}

/// Provot's patch of unit size: ks = kd = 100, kb = 10 N/m.
ClothMesh provots_patch(int cells) {
  return make_spring_net(SpringNet::rectangular, {1, 1, cells, cells}, {100, 100, 10, true},
                         Material{});
}

/// A force of `pull` newtons along x on the side at the highest x, half as much at its ends.
class SidePull : public Force {
 public:
  SidePull(std::vector<std::int32_t> side, double pull) : side_(std::move(side)), pull_(pull) {}
  void add_force(const ForceState&, std::span<Vec3> f) const override {
    const double share = pull_ / static_cast<double>(side_.size() - 1);
    for (std::size_t i = 0; i < side_.size(); ++i)
      f[side_[i]].x() += i == 0 || i + 1 == side_.size() ? 0.5 * share : share;
  }
  double energy(const ForceState&) const override { return 0.0; }
  void add_links(std::vector<Edge>&) const override {}
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const ForceState&, double, BlockMatrix&) const override {}
  void add_stiffness_bound(const ForceState&, std::span<double>, std::span<double>) const override {
  }

 private:
  std::vector<std::int32_t> side_;
  double pull_;
};

TEST(ProvotsPatch, PulledItHasItsModulusAndPoissonsRatio) {
  constexpr int cells = 30;
  const ClothMesh cloth = provots_patch(cells);
  const std::vector<Vec3>& flat = cloth.surface.vertices;
  std::vector<std::int32_t> left, right;
  for (std::int32_t j = 0; j <= cells; ++j) {
    left.push_back(j * (cells + 1));
    right.push_back(j * (cells + 1) + cells);
  }
  auto forces = make_internal_forces(cloth);
  constexpr double load = 0.2;  // N/m: a strain of 0.1 %
  forces.push_back(std::make_unique<SidePull>(right, load));
  forces.push_back(std::make_unique<SidePull>(left, -load));
  const std::int32_t middle = cells / 2;
  const std::vector<Vec3> x = at_rest(std::move(forces), cloth, {}, flat, 0.5, 1e-7);
  // In the middle, away from the ends: E = C11 - C12²/C11 = 198.33 N/m, ν = C12/C11 = 0.4167.
  const auto at = [&](int i, int j) { return x[j * (cells + 1) + i]; };
  const double length = (at(middle + 5, middle) - at(middle - 5, middle)).x() * cells / 10.0;
  const double width = (at(middle, middle + 5) - at(middle, middle - 5)).y() * cells / 10.0;
  EXPECT_NEAR(load / (length - 1.0) / 198.33, 1.0, 0.01);
  EXPECT_NEAR(-(width - 1.0) / (length - 1.0) / 0.4167, 1.0, 0.01);
}

TEST(ShearFrame, NeedsTheShearStiffnessTimesTheAnglePerWidth) {
  for (const bool one_diagonal : {false, true}) {
    constexpr int cells = 8;
    const ClothMesh cloth =
        make_spring_net(one_diagonal ? SpringNet::simplified : SpringNet::rectangular,
                        {1, 1, cells, cells}, {100, 100, 0, true}, Material{});
    constexpr double angle = 1e-4;
    std::vector<Vec3> x = cloth.surface.vertices, v(x.size(), Vec3::Zero()), f = v;
    for (Vec3& p : x) p.x() += angle * p.y();
    for (const auto& force : make_internal_forces(cloth))
      force->add_force({x, v, cloth.mass, 0.0}, f);
    double along = 0.0;  // on the side at the highest y, held by the frame
    for (int i = 0; i <= cells; ++i) along += f[cells * (cells + 1) + i].x();
    EXPECT_NEAR(-along / (angle * (one_diagonal ? 50.0 : 100.0)), 1.0, 1e-3);
  }
}

TEST(EndLoad, StretchesAStripByLoadOverStiffnessTimesLength) {
  Material m;
  m.shear_stiffness = 0.0;
  constexpr int cells = 20;
  const ClothMesh cloth = make_rectangular({2.0, 0.1, cells, 1}, m);
  auto forces = make_internal_forces(cloth);
  const std::vector<std::int32_t> right = {cells, 2 * cells + 1};
  constexpr double load = 5.0;  // N/m, on a width of 0.1 m
  forces.push_back(std::make_unique<SidePull>(right, 0.1 * load));
  const std::vector<Vec3> x =
      at_rest(std::move(forces), cloth, {0, cells + 1}, cloth.surface.vertices, 0.5, 1e-10);
  EXPECT_NEAR((x[cells].x() - 1.0) / (load / 500.0 * 2.0), 1.0, 1e-6);
}

/// y/x of the tip of a heavy strip of 20 elements, four wide, clamped horizontally,
/// Γ = ρ g L³/B. `axis`: the strip lies along x (0) or y (1) of its grid.
double slope_of_strip(int axis, bool rectangular, double gamma) {
  constexpr int elements = 20, rows = 4;
  constexpr double length = 0.1;
  // The clamp stands in the middle of the first column of cells: that is held.
  const double d = length / (elements + 0.5), long_side = (elements + 1) * d;
  Material m;
  m.stretch_stiffness = 2000.0;
  m.bending_stiffness = m.density * g * length * length * length / gamma;
  const GridConfig grid = axis == 0 ? GridConfig{long_side, rows * d, elements + 1, rows}
                                    : GridConfig{rows * d, long_side, rows, elements + 1};
  const ClothMesh cloth =
      rectangular ? make_rectangular(grid, m) : make_simplified(grid, m, /*alternating=*/true);
  const std::vector<Vec3>& flat = cloth.surface.vertices;
  std::vector<std::int32_t> held;
  for (std::size_t i = 0; i < flat.size(); ++i)
    if (flat[i][axis] < -0.5 * long_side + 1.01 * d) held.push_back(static_cast<std::int32_t>(i));
  auto forces = make_internal_forces(cloth);
  forces.push_back(make_gravity({0, 0, -g}));
  const std::vector<Vec3> x = at_rest(std::move(forces), cloth, held, flat, 0.02, 1e-5);
  Vec3 tip = Vec3::Zero();
  double count = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (flat[i][axis] > 0.5 * long_side - 0.01 * d) {
      tip += x[i];
      count += 1.0;
    }
  tip /= count;
  return -tip.z() / (tip[axis] + 0.5 * long_side - 0.5 * d);
}

TEST(CantileverStrip, FollowsTheHeavyElasticaAlongWarpAndWeft) {
  for (const bool rectangular : {true, false})
    for (const int axis : {0, 1})
      for (const auto& [gamma, slope] : {std::array{2.0, 0.24667}, std::array{10.0, 1.06680}})
        EXPECT_NEAR(slope_of_strip(axis, rectangular, gamma) / slope, 1.0, 0.02)
            << (rectangular ? "rectangular" : "checkerboard") << ", axis " << axis
            << ", Γ = " << gamma;
}

}  // namespace
}  // namespace selvedge::statics_test
