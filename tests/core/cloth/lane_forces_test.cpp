// SPDX-License-Identifier: MIT
// Springs and hinges side by side in vectors: whatever the width, the bits are the same, and the
// forces are those of each element by itself.
#include <gtest/gtest.h>
#include <selvedge/core/cloth/detail/dihedral.h>
#include <selvedge/core/cloth/detail/lane_forces.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/core/solver/detail/aggregation.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>
#include <type_traits>

namespace selvedge::lane_forces_test {
namespace {

using detail::kGroupLanes;
using detail::LaneGroups;
using detail::LaneKernel;
using Vectors = std::vector<Vec3>;

constexpr double kPi = std::numbers::pi;

/// A creased, moving cloth. Shuffled, its particles are numbered without order, so that no group
/// is a run.
struct Cloth {
  ClothMesh mesh;
  Vectors x, v;

  explicit Cloth(bool shuffled) {
    mesh = make_rectangular({1.0, 0.9, 23, 19}, Material{});
    const std::size_t n = mesh.mass.size();
    std::mt19937 random(7);
    std::uniform_real_distribution<double> some(-0.02, 0.02);
    x = mesh.surface.vertices;
    for (Vec3& p : x) p += Vec3(some(random), some(random), some(random));
    for (std::size_t i = 0; i < n; ++i)
      v.push_back(Vec3::NullaryExpr([&] { return some(random); }));
    std::vector<std::int32_t> to(n);
    std::iota(to.begin(), to.end(), 0);
    if (shuffled) std::shuffle(to.begin(), to.end(), random);
    Vectors y = x;
    for (std::size_t i = 0; i < n; ++i) y[to[i]] = x[i];
    x = y;
    for (Spring& s : mesh.springs) {
      s.a = to[s.a];
      s.b = to[s.b];
    }
    for (Hinge& h : mesh.hinges) {
      for (std::int32_t& k : h.v) k = to[k];
      h.rest_angle = 100.0 * some(random);
    }
  }
};

std::vector<std::int32_t> corners_of(const std::vector<Hinge>& hinges) {
  std::vector<std::int32_t> corners;
  for (const Hinge& h : hinges) corners.insert(corners.end(), h.v.begin(), h.v.end());
  return corners;
}

std::vector<std::int32_t> corners_of(const std::vector<Spring>& springs) {
  std::vector<std::int32_t> corners;
  for (const Spring& s : springs) corners.insert(corners.end(), {s.a, s.b});
  return corners;
}

std::array<double, 3> numbers_of(const Hinge& h) { return {h.rest_angle, h.stiffness, h.damping}; }
std::array<double, 3> numbers_of(const Spring& s) {
  return {s.rest_length, s.stiffness, s.damping};
}

/// The forces by one kernel.
template <class Element>
Vectors forces(detail::AddLanes add, const std::vector<Element>& elements, const Vectors& x,
               const Vectors& v) {
  const auto corners = corners_of(elements);
  detail::Coloring coloring =
      detail::color_elements(corners, corners.size() / elements.size(), x.size());
  const LaneGroups lanes =
      detail::make_lane_groups(corners, corners.size() / elements.size(), coloring);
  std::vector<Element> sorted;
  for (const std::int32_t e : coloring.order) sorted.push_back(elements[e]);
  const auto numbers =
      detail::lane_numbers<3>(lanes, sorted, [](const Element& e) { return numbers_of(e); });
  Vectors f(x.size(), Vec3::Zero());
  add(detail::lane_force(lanes, numbers, {x, v, {}, 0.0}, f), 0, lanes.groups.size());
  return f;
}

Vectors hinges_one_by_one(const std::vector<Hinge>& hinges, const Vectors& x, const Vectors& v) {
  Vectors f(x.size(), Vec3::Zero());
  for (const Hinge& h : hinges) {
    const detail::Dihedral d = detail::dihedral(x, h.v);
    if (!d.valid) continue;
    double rate = 0.0;
    for (int k = 0; k < 4; ++k) rate += d.gradient[k].dot(v[h.v[k]]);
    const double turn = std::remainder(d.angle - h.rest_angle, 2.0 * kPi);
    for (int k = 0; k < 4; ++k)
      f[h.v[k]] -= h.stiffness * (turn + h.damping * rate) * d.gradient[k];
  }
  return f;
}

Vectors springs_one_by_one(const std::vector<Spring>& springs, const Vectors& x, const Vectors& v) {
  Vectors f(x.size(), Vec3::Zero());
  for (const Spring& s : springs) {
    const Vec3 d = x[s.b] - x[s.a], u = d.normalized();
    const double rate = u.dot(v[s.b] - v[s.a]);
    const Vec3 pull = s.stiffness * (d.norm() - s.rest_length + s.damping * rate) * u;
    f[s.a] += pull;
    f[s.b] -= pull;
  }
  return f;
}

double largest(const Vectors& f) {
  double all = 0.0;
  for (const Vec3& p : f) all = std::max(all, p.norm());
  return all;
}

double largest_difference(const Vectors& f, const Vectors& g) {
  double all = 0.0;
  for (std::size_t i = 0; i < f.size(); ++i) all = std::max(all, (f[i] - g[i]).norm());
  return all;
}

TEST(LaneForces, OfEveryWidthHaveTheSameBits) {
  ASSERT_FALSE(detail::lane_kernels().empty());
  const LaneKernel& narrow = detail::lane_kernels().front();
  for (const bool shuffled : {false, true}) {
    const Cloth c(shuffled);
    const Vectors hinges = forces(narrow.hinges, c.mesh.hinges, c.x, c.v);
    const Vectors springs = forces(narrow.hooke, c.mesh.springs, c.x, c.v);
    for (const LaneKernel& kernel : detail::lane_kernels()) {
      EXPECT_EQ(forces(kernel.hinges, c.mesh.hinges, c.x, c.v), hinges) << kernel.width;
      EXPECT_EQ(forces(kernel.hooke, c.mesh.springs, c.x, c.v), springs) << kernel.width;
    }
  }
}

TEST(LaneForces, AreThoseOfEachElementByItself) {
  for (const bool shuffled : {false, true}) {
    const Cloth c(shuffled);
    const Vectors hinges = hinges_one_by_one(c.mesh.hinges, c.x, c.v);
    const Vectors springs = springs_one_by_one(c.mesh.springs, c.x, c.v);
    const LaneKernel& kernel = detail::lane_kernel();
    EXPECT_LT(largest_difference(forces(kernel.hinges, c.mesh.hinges, c.x, c.v), hinges),
              1e-12 * largest(hinges));
    EXPECT_LT(largest_difference(forces(kernel.hooke, c.mesh.springs, c.x, c.v), springs),
              1e-13 * largest(springs));
  }
}

/// The Jacobian of springs or hinges by one kernel, h = 0.01 s.
template <class Element>
std::vector<Mat3> blocks(const LaneKernel& kernel, const std::vector<Element>& elements,
                         const Cloth& c) {
  constexpr bool springs = std::is_same_v<Element, Spring>;
  constexpr std::size_t arity = springs ? 2 : 4;
  const auto corners = corners_of(elements);
  detail::Coloring coloring = detail::color_elements(corners, arity, c.x.size());
  const LaneGroups lanes = detail::make_lane_groups(corners, arity, coloring);
  std::vector<Element> sorted;
  for (const std::int32_t e : coloring.order) sorted.push_back(elements[e]);
  std::vector<Edge> links;
  for (std::size_t e = 0; e < elements.size(); ++e)
    for (std::size_t i = 0; i < arity; ++i)
      for (std::size_t j = 0; j < i; ++j)
        links.push_back({corners[arity * e + i], corners[arity * e + j]});
  BlockMatrix matrix(c.x.size(), links);
  const detail::BlockElements by_block = detail::blocks_of(corners_of(sorted), arity, matrix);
  const auto numbers =
      detail::lane_numbers<3>(lanes, sorted, [](const Element& e) { return numbers_of(e); });
  std::vector<double> parts((springs ? detail::kSpringParts : detail::kHingeParts) * sorted.size());
  (springs ? kernel.spring_parts : kernel.hinge_parts)(
      detail::lane_force(lanes, numbers, {c.x, c.v, {}, 0.0}, {}), 0.01, parts.data(), 0,
      lanes.groups.size());
  (springs ? kernel.spring_blocks : kernel.hinge_blocks)(
      detail::lane_jacobian(by_block, parts, matrix), 0, by_block.size());
  return {matrix.values().begin(), matrix.values().end()};
}

TEST(LaneForces, HaveTheSameJacobianForEveryWidth) {
  for (const bool shuffled : {false, true}) {
    const Cloth c(shuffled);
    const LaneKernel& narrow = detail::lane_kernels().front();
    const auto springs = blocks(narrow, c.mesh.springs, c);
    const auto hinges = blocks(narrow, c.mesh.hinges, c);
    for (const LaneKernel& kernel : detail::lane_kernels()) {
      EXPECT_EQ(blocks(kernel, c.mesh.springs, c), springs) << kernel.width;
      EXPECT_EQ(blocks(kernel, c.mesh.hinges, c), hinges) << kernel.width;
    }
  }
}

/// Pᵀ A P of a random matrix with some held particles, by one kernel.
std::vector<Mat3> product(const LaneKernel& kernel, const BlockMatrix& a,
                          std::span<const char> free) {
  const detail::Prolongation p = detail::make_prolongation(a.row_begin(), a.columns());
  detail::GalerkinProduct galerkin;
  detail::BlockRows coarse;
  galerkin.set_pattern(a.row_begin(), a.columns(), p, coarse);
  galerkin.compute(a.values(), p, free, coarse, kernel);
  return coarse.value;
}

TEST(LaneForces, HaveTheSameCoarseProductForEveryWidth) {
  const Cloth c(true);
  std::vector<Edge> links;
  for (const Spring& s : c.mesh.springs) links.push_back({s.a, s.b});
  BlockMatrix a(c.x.size(), links);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (Mat3& block : a.values()) block = Mat3::NullaryExpr([&] { return any(random); });
  std::vector<char> free(c.x.size(), 1);
  for (std::size_t i = 0; i < free.size(); i += 7) free[i] = 0;
  const auto narrow = product(detail::lane_kernels().front(), a, free);
  for (const LaneKernel& kernel : detail::lane_kernels())
    EXPECT_EQ(product(kernel, a, free), narrow) << kernel.width;

  // Pᵀ A P by its definition.
  const detail::Prolongation p = detail::make_prolongation(a.row_begin(), a.columns());
  const auto parents = static_cast<Eigen::Index>(p.parents());
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * parents, 3 * parents), same = dense;
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::int32_t k = a.row_begin()[i]; k < a.row_begin()[i + 1]; ++k) {
      const std::int32_t j = a.columns()[k];
      if (!free[i] || !free[j]) continue;
      for (std::int32_t e = p.begin[i]; e < p.begin[i + 1]; ++e)
        for (std::int32_t f = p.begin[j]; f < p.begin[j + 1]; ++f)
          dense.block<3, 3>(3 * p.parent[e], 3 * p.parent[f]) +=
              p.weight[e] * p.weight[f] * a.values()[k];
    }
  detail::GalerkinProduct galerkin;
  detail::BlockRows coarse;
  galerkin.set_pattern(a.row_begin(), a.columns(), p, coarse);
  for (std::size_t r = 0; r < coarse.size(); ++r)
    for (std::int32_t k = coarse.begin[r]; k < coarse.begin[r + 1]; ++k) {
      same.block<3, 3>(3 * static_cast<Eigen::Index>(r), 3 * coarse.column[k]) = narrow[k];
      largest = std::max(largest, narrow[k].norm());
    }
  EXPECT_LT((dense - same).cwiseAbs().maxCoeff(), 1e-13 * largest);
}

/// Hinges whose moments are a matrix times their turns, each coupled with up to three others, and a
/// patch each of one, two and three hinges.
struct Plate {
  std::vector<Hinge> hinges;
  LaneGroups lanes;
  std::vector<double> numbers;
  std::vector<std::uint32_t> row_begin{0};
  std::vector<std::int32_t> column;
  std::vector<double> couple, turn, moment, gradient;
  std::vector<detail::LanePatch> patches;

  explicit Plate(const Cloth& c) {
    const auto corners = corners_of(c.mesh.hinges);
    detail::Coloring coloring = detail::color_elements(corners, 4, c.x.size());
    lanes = detail::make_lane_groups(corners, 4, coloring);
    for (const std::int32_t e : coloring.order) hinges.push_back(c.mesh.hinges[e]);
    numbers = detail::lane_numbers<3>(lanes, hinges, [](const Hinge& h) { return numbers_of(h); });
    const std::size_t places = kGroupLanes * lanes.groups.size();
    std::mt19937 random(5);
    std::uniform_int_distribution<std::int32_t> any(0, static_cast<std::int32_t>(places) - 1);
    std::uniform_real_distribution<double> stiffness(-1e-5, 1e-5);
    for (std::size_t g = 0; g < lanes.groups.size(); ++g) {
      for (std::size_t k = 0; k < kGroupLanes * (g % 4); ++k) {
        column.push_back(any(random));
        couple.push_back(stiffness(random));
      }
      row_begin.push_back(static_cast<std::uint32_t>(column.size() / kGroupLanes));
    }
    for (int n = 1; n <= 3; ++n) {
      detail::LanePatch patch;
      patch.hinges = n;
      patch.damping = 0.01;
      for (int a = 0; a < n; ++a) {
        patch.hinge[a] = any(random);
        patch.corner[a] = {static_cast<std::int8_t>(a), static_cast<std::int8_t>((a + 1) % 4),
                           static_cast<std::int8_t>((a + 2) % 4),
                           static_cast<std::int8_t>((a + 3) % 4)};
        for (int b = 0; b < n; ++b) patch.couple[a][b] = 1e-5 / (1.0 + a + b);
      }
      patches.push_back(patch);
    }
    turn.resize(places);
    moment.resize(places);
    gradient.resize(detail::kLaneGradient * lanes.groups.size() + detail::kLaneGradientMore);
  }

  detail::LanePlate view() {
    return {row_begin.data(), column.data(), couple.data(),  patches.data(),
            turn.data(),      moment.data(), gradient.data()};
  }

  /// Forces of one kernel; turns, moments and gradients are left here.
  Vectors forces(const LaneKernel& kernel, const Cloth& c) {
    Vectors f(c.x.size(), Vec3::Zero());
    const auto force = detail::lane_force(lanes, numbers, {c.x, c.v, {}, 0.0}, f);
    for (const auto pass : {kernel.bends, kernel.moments, kernel.turning_forces})
      pass(force, view(), 0, lanes.groups.size());
    return f;
  }

  /// Blocks of all patches, side by side, h = 0.01 s, of the gradients that are here.
  std::vector<double> blocks(const LaneKernel& kernel) {
    std::vector<std::int32_t> slots(36 * patches.size());
    std::iota(slots.begin(), slots.end(), 0);
    std::vector<double> values(9 * slots.size(), 0.0);
    kernel.patch_blocks(view(), {slots.data(), values.data(), 0.01}, 0, patches.size());
    return values;
  }
};

TEST(LaneForces, OfCoupledHingesHaveTheSameBitsForEveryWidth) {
  for (const bool shuffled : {false, true}) {
    const Cloth c(shuffled);
    const LaneKernel& narrow = detail::lane_kernels().front();
    Plate first(c);
    const Vectors f = first.forces(narrow, c);
    const std::vector<double> blocks = first.blocks(narrow);
    for (const LaneKernel& kernel : detail::lane_kernels()) {
      Plate plate(c);
      EXPECT_EQ(plate.forces(kernel, c), f) << kernel.width;
      EXPECT_EQ(plate.turn, first.turn) << kernel.width;
      EXPECT_EQ(plate.moment, first.moment) << kernel.width;
      EXPECT_EQ(plate.gradient, first.gradient) << kernel.width;
      EXPECT_EQ(plate.blocks(kernel), blocks) << kernel.width;
    }
  }
}

TEST(LaneForces, OfCoupledHingesAreTheProductOfTheMatrixAndTheirTurns) {
  for (const bool shuffled : {false, true}) {
    const Cloth c(shuffled);
    Plate plate(c);
    const Vectors f = plate.forces(detail::lane_kernel(), c);
    std::vector<double> turn(plate.turn.size());
    detail::lane_kernel().turns(
        detail::lane_force(plate.lanes, plate.numbers, {c.x, {}, {}, 0.0}, {}), turn.data(), 0,
        plate.lanes.groups.size());
    Vectors each(c.x.size(), Vec3::Zero());
    for (std::size_t g = 0; g < plate.lanes.groups.size(); ++g)
      for (std::int16_t l = 0; l < plate.lanes.groups[g].count; ++l) {
        const Hinge& h = plate.hinges[plate.lanes.groups[g].element + l];
        double moment = h.stiffness * plate.turn[kGroupLanes * g + l];
        for (std::size_t r = plate.row_begin[g]; r < plate.row_begin[g + 1]; ++r)
          moment +=
              plate.couple[kGroupLanes * r + l] * plate.turn[plate.column[kGroupLanes * r + l]];
        const detail::Dihedral d = detail::dihedral(c.x, h.v);
        for (int k = 0; k < 4; ++k) each[h.v[k]] -= moment * d.gradient[k];
        EXPECT_NEAR(turn[kGroupLanes * g + l], std::remainder(d.angle - h.rest_angle, 2.0 * kPi),
                    1e-14);
      }
    EXPECT_LT(largest_difference(f, each), 1e-12 * largest(each));
  }
}

TEST(LaneForces, OfDegenerateElementsAreZeroAndSpoilNoNeighbour) {
  Cloth c(false);
  const std::int32_t lost = c.mesh.hinges[40].v[2];
  c.x[lost] = c.x[c.mesh.hinges[40].v[3]];
  const LaneKernel& kernel = detail::lane_kernel();
  const Vectors hinges = forces(kernel.hinges, c.mesh.hinges, c.x, c.v);
  const Vectors springs = forces(kernel.hooke, c.mesh.springs, c.x, c.v);
  const Vectors each = hinges_one_by_one(c.mesh.hinges, c.x, c.v);
  EXPECT_LT(largest_difference(hinges, each), 1e-12 * largest(each));
  EXPECT_TRUE(std::all_of(springs.begin(), springs.end(), [](auto& f) { return f.allFinite(); }));
}

TEST(LaneForces, LeaveWhatIsNotANumberToTheParticlesOfItsSprings) {
  Cloth c(false);
  const std::int32_t lost = c.mesh.hinges[40].v[2];
  c.x[lost].setConstant(std::numeric_limits<double>::quiet_NaN());
  const Vectors f = forces(detail::lane_kernel().hinges, c.mesh.hinges, c.x, c.v);
  EXPECT_TRUE(std::all_of(f.begin(), f.end(), [](auto& p) { return p.allFinite(); }));
}

TEST(LaneForces, KnowAnglesAsAtan2DoesInEveryQuadrant) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-kPi, kPi), power(-150.0, 150.0);
  constexpr double tolerance = 4.5e-16;  // a rounding at π and one of a sum
  for (const LaneKernel& kernel : detail::lane_kernels())
    for (int round = 0; round < 20000; ++round) {
      std::array<double, kGroupLanes> y, x, theta;
      for (std::size_t l = 0; l < kGroupLanes; ++l) {
        const double angle = any(random), radius = std::pow(10.0, power(random));
        y[l] = radius * std::sin(angle);
        x[l] = radius * std::cos(angle);
      }
      kernel.angle(y.data(), x.data(), theta.data());
      for (std::size_t l = 0; l < kGroupLanes; ++l)
        ASSERT_NEAR(theta[l], std::atan2(y[l], x[l]), tolerance) << y[l] << " " << x[l];
    }
}

TEST(LaneForces, KnowTheAnglesOfTheAxes) {
  const std::array<double, kGroupLanes> y{0, 1, 0, -1, 1, -1, 0, 1e-300},
      x{1, 0, -1, 0, 1, -1, 0, 1};
  const std::array<double, kGroupLanes> expected{0,          0.5 * kPi,   kPi, -0.5 * kPi,
                                                 0.25 * kPi, -0.75 * kPi, 0,   1e-300};
  for (const LaneKernel& kernel : detail::lane_kernels()) {
    std::array<double, kGroupLanes> theta;
    kernel.angle(y.data(), x.data(), theta.data());
    for (std::size_t l = 0; l < kGroupLanes; ++l) EXPECT_DOUBLE_EQ(theta[l], expected[l]) << l;
  }
}

TEST(LaneGroups, HoldEveryElementOnceAndRunsAreRuns) {
  const Cloth c(false);
  const auto corners = corners_of(c.mesh.hinges);
  detail::Coloring coloring = detail::color_elements(corners, 4, c.x.size());
  const std::vector<std::size_t> colors = coloring.color_begin;
  const LaneGroups lanes = detail::make_lane_groups(corners, 4, coloring);
  EXPECT_EQ(coloring.color_begin, colors);
  std::size_t at = 0, runs = 0;
  for (const detail::LaneGroup& group : lanes.groups) {
    EXPECT_EQ(detail::group_of(at), static_cast<std::size_t>(&group - lanes.groups.data()));
    runs += group.run;
    for (std::int32_t l = 0; l < group.count; ++l)
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t place = group.particles + (group.run ? k : k * kGroupLanes + l);
        EXPECT_EQ(lanes.particles[place] + (group.run ? l : 0),
                  corners[4 * coloring.order[at + l] + k]);
      }
    at += group.count;
  }
  EXPECT_EQ(at, c.mesh.hinges.size());
  EXPECT_GT(2 * runs, lanes.groups.size());
  std::vector<std::int32_t> all = coloring.order;
  std::sort(all.begin(), all.end());
  for (std::size_t e = 0; e < all.size(); ++e) EXPECT_EQ(all[e], static_cast<std::int32_t>(e));
}

}  // namespace

}  // namespace selvedge::lane_forces_test
