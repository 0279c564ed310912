// SPDX-License-Identifier: MIT
//
// The finite elements for stretch and shear on whole meshes: patch tests by the formula of the
// stress, linear elasticity, convergence to an exact solution. What holds for each triangle in any
// state is in internal_force_test.
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/tests/cantilever.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include "dense_force.h"

namespace selvedge::membrane_test {
namespace {

using Mat32 = Eigen::Matrix<double, 3, 2>;
using Mat2 = Eigen::Matrix2d;

const std::array<std::string, 2> kLaws{"st_venant_kirchhoff", "corotated"};

Material woven(const std::string& law) {
  Material m;
  m.stretch_stiffness = 400.0;
  m.stretch_weft = 250.0;
  m.shear_stiffness = 60.0;
  m.poisson = 0.25;
  m.stretch_law = law;
  return m;
}

/// A grid of triangles whose inner vertices are moved at random, so that no triangle is like
/// another.
TriangleMesh irregular() {
  TriangleMesh mesh = make_rectangular({0.6, 0.5, 6, 5}, {}).surface;
  const Vectors moves = random_vectors(mesh.vertices.size(), 0.03, 3);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    Vec3& x = mesh.vertices[i];
    if (std::abs(x.x()) < 0.29 && std::abs(x.y()) < 0.24)
      x += Vec3(moves[i].x(), moves[i].y(), 0.0);
  }
  return mesh;
}

std::map<std::string, ClothMesh> meshes(const Material& m) {
  AdaptiveGrid split({0.6, 0.5, 3, 3}, m, 2);
  const auto cells = split.divisible();
  split.split(std::span(cells).first(2));
  return {{"rectangular", make_rectangular({0.6, 0.5, 4, 3}, m)},
          {"triangular", make_triangular({0.6, 0.5, 4, 4}, m)},
          {"simplified", make_simplified({0.6, 0.5, 4, 3}, m, false)},
          {"checkerboard", make_simplified({0.6, 0.5, 4, 3}, m, true)},
          {"arc", make_arc({0.3, 4, 12}, m)},
          {"woven disc", make_woven_disc(0.3, 10, m)},
          {"split", split.cloth()},
          {"irregular", make_from_mesh(irregular(), irregular(), m)}};
}

/// The one force of the mesh that carries stretch.
std::unique_ptr<Force> stretch_force(const ClothMesh& cloth, const std::string& law) {
  return make_membrane_force(cloth.membranes,
                             law == "corotated" ? MembraneStrain::corotated : MembraneStrain::green,
                             cloth.mass.size());
}

ForceStateOwner mapped(const ClothMesh& cloth, const Mat32& f) {
  ForceStateOwner s{cloth.surface.vertices, Vectors(cloth.mass.size(), Vec3::Zero()), cloth.mass};
  for (Vec3& x : s.x) x = f * x.head<2>();
  return s;
}

/// The vertices that are on the border of the surface.
std::vector<char> border(const ClothMesh& cloth) {
  std::map<Edge, int> count;
  for (const Triangle& t : cloth.surface.triangles)
    for (int k = 0; k < 3; ++k)
      ++count[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
  std::vector<char> on(cloth.mass.size(), 0);
  for (const auto& [edge, triangles] : count)
    if (triangles == 1) on[edge[0]] = on[edge[1]] = 1;
  return on;
}

Mat2 of_strain(const Mat2& e, const ContinuumConstants& c) {
  Mat2 s;
  s << c.c11 * e(0, 0) + c.c12 * e(1, 1), 2.0 * c.c33 * e(0, 1), 2.0 * c.c33 * e(0, 1),
      c.c12 * e(0, 0) + c.c22 * e(1, 1);
  return s;
}

/// St. Venant-Kirchhoff: P = F S with S = C : ½ (FᵀF - 1).
Mat32 green_stress(const Mat32& f, const ContinuumConstants& c) {
  return f * of_strain(0.5 * (f.transpose() * f - Mat2::Identity()), c);
}

/// A uniform deformation leaves the inner vertices in equilibrium, and the forces of the border are
/// those of the stress: -Σ fᵢ Xᵢᵀ = A P.
void expect_stress(const ClothMesh& cloth, const std::string& law, const Mat32& f,
                   const Mat32& stress, const std::string& name) {
  const auto force = stretch_force(cloth, law);
  const ForceStateOwner s = mapped(cloth, f);
  const Vectors forces = force_at(*force, s);
  const std::vector<char> on_border = border(cloth);
  const auto& rest = cloth.surface;
  const double area = surface_area(rest.vertices, rest.triangles);
  Mat32 virial = Mat32::Zero();
  double largest = 0.0, inner = 0.0;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    virial -= forces[i] * rest.vertices[i].head<2>().transpose();
    largest = std::max(largest, forces[i].norm());
    if (on_border[i] == 0) inner = std::max(inner, forces[i].norm());
  }
  EXPECT_LT(inner, 1e-12 * largest) << name;
  EXPECT_LT((virial - area * stress).norm(), 1e-12 * area * stress.norm()) << name;
}

Mat32 in_space(const Mat2& f) {
  Mat32 turned;
  turned << f, Eigen::RowVector2d::Zero();
  return Eigen::AngleAxisd(0.8, Vec3(1.0, -2.0, 0.5).normalized()).toRotationMatrix() * turned;
}

Mat2 matrix(double a, double b, double c, double d) {
  Mat2 m;
  m << a, b, c, d;
  return m;
}

const std::map<std::string, Mat2> kDeformations{{"along warp", matrix(1.3, 0.0, 0.0, 1.0)},
                                                {"along weft", matrix(1.0, 0.0, 0.0, 1.2)},
                                                {"both", matrix(1.2, 0.0, 0.0, 0.9)},
                                                {"shear", matrix(1.0, 0.4, 0.0, 1.0)},
                                                {"all", matrix(1.1, 0.3, -0.1, 0.95)}};

TEST(StVenantKirchhoff, PassesThePatchTestOnEveryMesh) {
  const Material m = woven("st_venant_kirchhoff");
  const ContinuumConstants c = membrane_constants(m, true);
  for (const auto& [mesh, cloth] : meshes(m))
    for (const auto& [name, f] : kDeformations)
      expect_stress(cloth, m.stretch_law, in_space(f), green_stress(in_space(f), c),
                    mesh + ", " + name);
}

TEST(Corotated, PassesThePatchTestOnEveryMesh) {
  const Material m = woven("corotated");
  const ContinuumConstants c = membrane_constants(m, true);
  // Stretches along warp and weft have no rotation: P = C : (F - 1).
  for (const auto& [mesh, cloth] : meshes(m))
    for (const char* name : {"along warp", "along weft", "both"}) {
      const Mat2& f = kDeformations.at(name);
      const Mat32 turn = in_space(Mat2::Identity());
      expect_stress(cloth, m.stretch_law, in_space(f), turn * of_strain(f - Mat2::Identity(), c),
                    mesh + ", " + name);
    }
}

TEST(Membrane, AStripHasTheStiffnessOfTheFabric) {
  for (const std::string& law : kLaws) {
    Material m = woven(law);
    for (const bool given : {true, false}) {
      if (!given) m.poisson.reset();
      const ContinuumConstants c = membrane_constants(m, true);
      EXPECT_NEAR(strip_modulus(c), 400.0, 1e-10);
      EXPECT_NEAR(c.c22 - c.c12 * c.c12 / c.c11, 250.0, 1e-10);
      EXPECT_EQ(c.c33, 60.0);
      EXPECT_NEAR(c.c12, given ? 0.25 * std::sqrt(c.c11 * c.c22) : c.c33, 1e-10);
    }
  }
}

TEST(Membrane, RigidMotionsHaveNoForce) {
  for (const std::string& law : kLaws)
    for (const auto& [mesh, cloth] : meshes(woven(law))) {
      const auto force = stretch_force(cloth, law);
      ForceStateOwner s = mapped(cloth, in_space(Mat2::Identity()));
      const Vec3 spin(3.0, -1.0, 2.0);
      for (std::size_t i = 0; i < s.x.size(); ++i) {
        s.v[i] = spin.cross(s.x[i]) + Vec3(1.0, 2.0, 3.0);
        s.x[i] += Vec3(5.0, -7.0, 2.0);
      }
      EXPECT_LT(flat(force_at(*force, s)).cwiseAbs().maxCoeff(), 1e-12 * 400.0 * 10.0) << mesh;
    }
}

/// Force of small displacements and what linear elasticity makes of them, relative.
double off_linear(const std::string& law, double size) {
  const Material m = woven(law);
  const ClothMesh cloth = make_from_mesh(irregular(), irregular(), m);
  const auto force = stretch_force(cloth, law);
  ForceStateOwner s{cloth.surface.vertices, Vectors(cloth.mass.size(), Vec3::Zero()), cloth.mass};
  const Vectors moves = random_vectors(s.x.size(), 0.1 * size, 9);
  const ContinuumConstants c = membrane_constants(m, true);
  Vectors linear(s.x.size(), Vec3::Zero());
  const auto& rest = cloth.surface.vertices;
  for (const Triangle& t : cloth.surface.triangles) {
    // ∇u from the sides, and the forces -A σ ∇Nᵢ, without the elements' own shape functions.
    Mat2 sides, moved;
    for (int k = 0; k < 2; ++k) {
      sides.col(k) = (rest[t[k + 1]] - rest[t[0]]).head<2>();
      moved.col(k) = (moves[t[k + 1]] - moves[t[0]]).head<2>();
    }
    const Mat2 slope = moved * sides.inverse();
    const Mat2 f = -0.5 * sides.determinant() * of_strain(0.5 * (slope + slope.transpose()), c) *
                   sides.inverse().transpose();
    for (int k = 0; k < 2; ++k) {
      linear[t[k + 1]].head<2>() += f.col(k);
      linear[t[0]].head<2>() -= f.col(k);
    }
  }
  for (std::size_t i = 0; i < s.x.size(); ++i) s.x[i].head<2>() += moves[i].head<2>();
  const Vectors f = force_at(*force, s);
  return (flat(f) - flat(linear)).norm() / flat(linear).norm();
}

TEST(Membrane, IsLinearElasticityToSecondOrder) {
  for (const std::string& law : kLaws) {
    // A relative error of first order in the force is one of second order in the force itself.
    const double once = off_linear(law, 1e-3), half = off_linear(law, 5e-4);
    EXPECT_LT(once, 0.02);
    EXPECT_NEAR(once / half, 2.0, 0.05);
  }
}

/// Largest error of the cantilever's displacements, relative to its deflection.
double cantilever_error(const std::string& law, std::int32_t rows) {
  const selvedge::testing::Cantilever c;
  const ClothMesh cloth =
      make_rectangular({c.length, 2.0 * c.half, 4 * rows, rows}, c.material(law));
  return c.error(cloth, *stretch_force(cloth, law), rows);
}

TEST(Membrane, ACantileverConvergesToTheExactSolutionWithOrderTwo) {
  for (const std::string& law : kLaws) {
    const double coarse = cantilever_error(law, 4), middle = cantilever_error(law, 8),
                 fine = cantilever_error(law, 16);
    EXPECT_LT(fine, 0.02);
    EXPECT_NEAR(std::log2(coarse / middle), 2.0, 0.35);
    EXPECT_NEAR(std::log2(middle / fine), 2.0, 0.15);
  }
}

TEST(Membrane, SpringsOnlyMeasureStrain) {
  const ForceLawRegistry laws = force_laws();
  for (const std::string& law : kLaws) {
    const ClothMesh cloth = make_rectangular({0.6, 0.5, 4, 3}, woven(law));
    EXPECT_FALSE(cloth.springs.empty());
    EXPECT_EQ(cloth.springs.size(), cloth.strain_limit.size());
    std::size_t carry_stretch = 0;
    for (const auto* entry : laws.in_order())
      if (entry->traits().energy == "stretch_and_shear")
        carry_stretch += make_forces_of(*entry, cloth, {}).size();
    EXPECT_EQ(carry_stretch, 1u);
  }
}

TEST(Membrane, APieceThatIsCutKeepsTheElementsOfItsTriangles) {
  const ClothMesh cloth = make_rectangular({0.6, 0.5, 4, 3}, woven("corotated"));
  // All vertices of the triangle that is left out stay.
  std::vector<Triangle> inside = cloth.surface.triangles;
  inside.erase(inside.begin() + 10);
  const ClothMesh part = cut(cloth, inside);
  ASSERT_EQ(part.membranes.size(), inside.size());
  for (std::size_t i = 0; i < inside.size(); ++i)
    EXPECT_EQ(part.membranes[i].v, part.surface.triangles[i]);
}

TEST(Membrane, TheResultDoesNotDependOnTheNumberOfThreads) {
  for (const std::string& law : kLaws) {
    const ClothMesh cloth = make_rectangular({1.0, 1.0, 60, 60}, woven(law));
    const auto force = stretch_force(cloth, law);
    ForceStateOwner s{cloth.surface.vertices, random_vectors(cloth.mass.size(), 1.0, 4),
                      cloth.mass};
    const Vectors moves = random_vectors(s.x.size(), 0.01, 5);
    for (std::size_t i = 0; i < s.x.size(); ++i) s.x[i] += moves[i];
    Vectors once;
    for (const int threads : {1, 2, 8}) {
      const ThreadLimit limit(threads);
      const Vectors f = force_at(*force, s);
      if (once.empty()) once = f;
      EXPECT_EQ(f, once) << threads;
    }
  }
}

TEST(Membrane, RefusesWhatItCannotCompute) {
  const auto refused = [](auto change) {
    MembraneTriangle t{{0, 1, 2}, {{{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}}}, 10.0, 10.0, 2.0, 3.0};
    change(t);
    EXPECT_THROW(make_membrane_force(std::span(&t, 1), MembraneStrain::corotated, 3),
                 std::invalid_argument);
  };
  refused([](MembraneTriangle& t) { t.rest[2] = {2.0, 0.0}; });
  refused([](MembraneTriangle& t) { t.c12 = 10.0; });
  refused([](MembraneTriangle& t) { t.c33 = -1.0; });
  refused([](MembraneTriangle& t) { t.v[2] = 3; });
  Material springs;
  springs.poisson = 0.2;
  EXPECT_THROW(make_rectangular({1.0, 1.0, 2, 2}, springs), std::invalid_argument);
  EXPECT_THROW(make_responsive({1.0, 1.0, 2, 2}, woven("corotated")), std::invalid_argument);
}

}  // namespace
}  // namespace selvedge::membrane_test
