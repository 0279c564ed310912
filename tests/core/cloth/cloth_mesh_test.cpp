// SPDX-License-Identifier: MIT
//
// Meshes of the survey: counts, the continuum constants they really have, and that the same fabric
// is the same cloth on each of them.
#include <selvedge/core/cloth/cloth_elements.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/detail/law_elements.h>
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/internal/make_plate.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "crumple.h"
#include "rolled_mesh.h"

namespace selvedge::cloth_mesh_test {
namespace {

constexpr double pi = std::numbers::pi;

double sum(const std::vector<double>& values) {
  double total = 0.0;
  for (const double v : values) total += v;
  return total;
}

template <class Make>
std::string refusal(const Make& make) {
  try {
    make();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

constexpr NetConstants every_spring{100.0, 100.0, 10.0, true};

ClothMesh net(SpringNet kind, int cells, const NetConstants& constants = every_spring) {
  return make_spring_net(kind, {1.0, 1.0, cells, cells}, constants, Material{});
}

TEST(SpringNets, HaveTheSpringsThatTheSurveyCounts) {
  // 50 × 50 particles.
  EXPECT_EQ(net(SpringNet::rectangular, 49).springs.size(), 14502u);
  EXPECT_EQ(net(SpringNet::simplified, 49).springs.size(), 12101u);
  EXPECT_EQ(net(SpringNet::alternating, 49).springs.size(), 12101u);
  EXPECT_EQ(net(SpringNet::responsive, 49).springs.size(), 19110u);
}

TEST(SpringNets, ATriangulated50By50GridHas7301EdgesAnd7105Links) {
  // The simplified grid's triangles: as edges 2N(N-1) + (N-1)², of them 4(N-1) on the border.
  const ClothMesh grid = make_simplified({1.0, 1.0, 49, 49}, Material{}, false);
  const ClothMesh cloth = make_from_mesh(grid.surface, grid.surface, Material{});
  EXPECT_EQ(cloth.springs.size(), 7301u);
  EXPECT_EQ(cloth.hinges.size(), 7105u);
}

/// The kinds of springs of a printed net, found by the rest length in cells of a unit grid.
struct NetCount {
  std::size_t structural = 0, shear = 0, flexion = 0, long_diagonal = 0;
  bool operator==(const NetCount&) const = default;
};

NetCount count_by_length(const ClothMesh& cloth) {
  NetCount n;
  for (const Spring& s : cloth.springs) {
    const double squared = s.rest_length * s.rest_length;
    const double kinds[] = {1.0, 2.0, 4.0, 8.0};
    std::size_t* counts[] = {&n.structural, &n.shear, &n.flexion, &n.long_diagonal};
    for (int k = 0; k < 4; ++k)
      if (std::abs(squared - kinds[k]) < 1e-9) ++*counts[k];
  }
  return n;
}

void expect_equal_constants(const ClothMesh& cloth, double k) {
  for (const Spring& s : cloth.springs) EXPECT_EQ(s.stiffness, k);
  EXPECT_TRUE(cloth.hinges.empty());
  EXPECT_TRUE(cloth.links.empty());
  EXPECT_EQ(cloth.strain_limit.size(), cloth.springs.size());
}

// N × M particles: structural N(M-1) + M(N-1), shear 2(N-1)(M-1) or half of it, flexion
// N(M-2) + M(N-2), and 2(N-2)(M-2) more along the diagonals of the responsive net.
TEST(SpringNets, HaveThePrintedSpringsWithEqualConstants) {
  constexpr std::size_t n = 9, m = 6;
  const GridConfig grid{n - 1.0, m - 1.0, n - 1, m - 1};
  const std::size_t structural = n * (m - 1) + m * (n - 1), cells = (n - 1) * (m - 1),
                    flexion = n * (m - 2) + m * (n - 2), diagonal = 2 * (n - 2) * (m - 2);
  const std::vector<std::pair<std::string, NetCount>> nets = {
      {"rectangular_net", {structural, 2 * cells, flexion, 0}},
      {"simplified_net", {structural, cells, flexion, 0}},
      {"responsive_net", {structural, 2 * cells, flexion, diagonal}}};
  const ClothPatternRegistry patterns = cloth_patterns();
  Material fabric;
  fabric.stretch_stiffness = 777.0;  // ignored
  for (const auto& [name, count] : nets) {
    const ClothMesh cloth = patterns.at(name)(grid, fabric);
    EXPECT_TRUE(count_by_length(cloth) == count) << name;
    expect_equal_constants(cloth, 100.0);
    const ClothMesh stiff =
        patterns.at(name)({{"structural", 30.0}, {"shear", 30.0}, {"flexion", 30.0}}, grid, fabric);
    expect_equal_constants(stiff, 30.0);
  }
}

TEST(SpringNets, TheTriangularNetHasSpringsOnAndAcrossEdges) {
  // Equilateral triangles of side 1: edges have length 1 and springs across an edge √3; on the
  // border some are cut in half.
  const ClothPatternRegistry patterns = cloth_patterns();
  const ClothMesh cloth =
      patterns.at("triangular_net")({8.0, 6.0 * std::sqrt(3.0) / 2.0, 8, 6}, Material{});
  std::size_t edges = cloth.edges.size();
  // Each triangle has three edges; those with two triangles are counted twice.
  const std::size_t interior = 3 * cloth.surface.triangles.size() - edges;
  EXPECT_EQ(cloth.surface.vertices.size() + cloth.surface.triangles.size(), edges + 1);  // Euler
  EXPECT_EQ(cloth.springs.size(), edges + interior);
  expect_equal_constants(cloth, 100.0);
  std::size_t across = 0;
  for (const Spring& s : cloth.springs)
    if (std::abs(s.rest_length - std::sqrt(3.0)) < 1e-9) ++across;
  EXPECT_GT(across, interior / 2);
  EXPECT_LT(across, interior + 1);
}

TEST(SpringNets, TakeNoLawThatTheyDoNotHave) {
  const ClothPatternRegistry patterns = cloth_patterns();
  Material kes;
  kes.stretch_law = "kawabata";
  for (const char* name : {"rectangular_net", "simplified_net", "responsive_net", "triangular_net"})
    EXPECT_THROW(patterns.at(name)({1.0, 1.0, 4, 4}, kes), std::invalid_argument) << name;
}

TEST(SpringNets, ProvotsPatchHasTheConstantsOfItsClosedForm) {
  // C11 = ks + kd + 4 kb, C12 = C33 = kd; the flexion springs miss one cell of each row.
  const ClothMesh cloth = net(SpringNet::rectangular, 49);
  const ContinuumConstants c = continuum_constants(cloth, cloth.surface.vertices, 1.0);
  EXPECT_NEAR(c.c11, 240.0, 2.4);
  EXPECT_NEAR(c.c22, 240.0, 2.4);
  EXPECT_NEAR(c.c12, 100.0, 1e-9);
  EXPECT_NEAR(c.c33, 100.0, 1e-9);
  EXPECT_NEAR(c.c13, 0.0, 1e-9);
  EXPECT_NEAR(strip_modulus({240, 240, 100, 100, 0, 0}), 198.33, 0.005);
  EXPECT_NEAR(strip_poisson({240, 240, 100, 100, 0, 0}), 0.4167, 5e-5);
}

TEST(SpringNets, HalfStiffnessOnTheBorderMakesTheConstantsExact) {
  NetConstants k{100.0, 100.0, 0.0, true};
  for (const int cells : {1, 5, 20}) {
    k.half_border = true;
    const ClothMesh half = net(SpringNet::rectangular, cells, k);
    EXPECT_NEAR(continuum_constants(half, half.surface.vertices, 1.0).c11, 200.0, 1e-9);
    k.half_border = false;
    const ClothMesh full = net(SpringNet::rectangular, cells, k);
    EXPECT_NEAR(continuum_constants(full, full.surface.vertices, 1.0).c11, 200.0 + 100.0 / cells,
                1e-9);
  }
}

TEST(SpringNets, OneDiagonalHalvesTheShearAndCouplesItToTheStretch) {
  const NetConstants k{100.0, 100.0, 0.0, true};
  const ClothMesh same = net(SpringNet::simplified, 10, k);
  const ContinuumConstants c = continuum_constants(same, same.surface.vertices, 1.0);
  EXPECT_NEAR(c.c11, 150.0, 1e-9);
  EXPECT_NEAR(c.c33, 50.0, 1e-9);
  EXPECT_NEAR(c.c13, 50.0, 1e-9);
  EXPECT_NEAR(c.c23, 50.0, 1e-9);
  const ClothMesh other = net(SpringNet::alternating, 10, k);
  const ContinuumConstants d = continuum_constants(other, other.surface.vertices, 1.0);
  EXPECT_NEAR(d.c33, 50.0, 1e-9);
  EXPECT_NEAR(d.c13, 0.0, 1e-9);
  EXPECT_NEAR(d.c23, 0.0, 1e-9);
}

struct NamedMesh {
  std::string name;
  ClothMesh cloth;
};

std::vector<NamedMesh> grid_meshes(const GridConfig& grid, const Material& material) {
  Material twisting = material;
  twisting.shear_law = "twisting";
  std::vector<NamedMesh> all;
  all.push_back({"rectangular", make_rectangular(grid, material)});
  all.push_back({"rectangular, twisting", make_rectangular(grid, twisting)});
  all.push_back({"simplified", make_simplified(grid, material, false)});
  all.push_back({"alternating", make_simplified(grid, material, true)});
  all.push_back({"responsive", make_responsive(grid, material)});
  return all;
}

TEST(ClothMeshes, AFabricHasOneStripModulusAndShearOnEachGrid) {
  for (const int cells_y : {8, 10, 12})
    for (const auto& [name, cloth] : grid_meshes({1.0, 1.0, 10, cells_y}, Material{})) {
      const ContinuumConstants c = continuum_constants(cloth, cloth.surface.vertices, 1.0);
      EXPECT_NEAR(strip_modulus(c), 500.0, 1e-8) << name;
      EXPECT_NEAR(c.c33, 100.0, 1e-9) << name;
    }
}

TEST(ClothMeshes, TwistingSpringsNeedNoPoissonCouplingForTheirShear) {
  Material material;
  material.shear_law = "twisting";
  const ClothMesh cloth = make_rectangular({1.0, 1.0, 10, 10}, material);
  const ContinuumConstants c = continuum_constants(cloth, cloth.surface.vertices, 1.0);
  EXPECT_NEAR(c.c12, 0.0, 1e-9);
  EXPECT_NEAR(c.c11, 500.0, 1e-9);
  EXPECT_GT(cauchy_residual(c), 0.1);  // what springs alone could not do
}

TEST(ClothMeshes, EveryGridHasTheMassOfItsArea) {
  for (const auto& [name, cloth] : grid_meshes({0.7, 0.6, 7, 5}, Material{}))
    EXPECT_NEAR(sum(cloth.mass), 0.2 * 0.42, 1e-14) << name;
}

/// Bending energy per area of a sheet without borders: energies of n × n cells are quadratic in n.
double bending_energy(const std::string& law, double rigidity, double r, double angle) {
  constexpr double cell = 0.01;
  constexpr int step = 10;
  std::array<double, 3> energy{};
  for (int k = 0; k < 3; ++k) {
    Material material;
    material.bending_law = law;
    material.bending_stiffness = rigidity;
    const int cells = (k + 1) * step;
    ClothMesh cloth = make_rectangular({cells * cell, cells * cell * 1.2, cells, cells}, material);
    cloth.springs.clear();
    const Vectors x = rolled(cloth.surface.vertices, r, angle);
    for (const auto& force : make_internal_forces(cloth))
      energy[k] += force->energy({x, x, cloth.mass, 0.0});
  }
  return (energy[2] - 2.0 * energy[1] + energy[0]) / (2.0 * step * step * cell * cell * 1.2);
}

TEST(ClothMeshes, EveryBendingLawStoresThePlatesEnergyRolledInAnyDirection) {
  constexpr double r = 0.15;
  for (const auto& [law, rigidity, tolerance] :
       {std::tuple{"hinge", 1e-5, 0.005}, std::tuple{"bridson", 1e-5, 0.005},
        std::tuple{"twisting", 1e-5, 0.005}, std::tuple{"beam", 1e-5, 0.005},
        // A link is soft before it buckles; with so little rigidity that matters little.
        std::tuple{"buckling", 1e-8, 0.01}})
    for (const double angle : {0.0, 0.4, pi / 4, 1.2, pi / 2})
      EXPECT_NEAR(bending_energy(law, rigidity, r, angle) / (0.5 * rigidity / (r * r)), 1.0,
                  tolerance)
          << law << " at " << angle;
}

TEST(ClothMeshes, LinesOfParticlesRefuseSlenderCellsWithARemedy) {
  Material material;
  material.bending_law = "twisting";
  const std::string text = refusal([&] { make_rectangular({1.0, 1.0, 10, 18}, material); });
  EXPECT_NE(text.find("use \"hinge\""), std::string::npos) << text;
}

TEST(ClothMeshes, LawsThatNeedRowsAreRefusedOnTrianglesWithARemedy) {
  for (const std::string law : {"buckling", "twisting", "beam"}) {
    Material material;
    material.bending_law = law;
    EXPECT_NE(refusal([&] { make_triangular({}, material); }).find("\"hinge\""), std::string::npos);
    EXPECT_NE(refusal([&] { make_arc({}, material); }).find("arc"), std::string::npos);
  }
  Material material;
  material.shear_law = "twisting";
  EXPECT_NE(refusal([&] { make_triangular({}, material); }).find("\"springs\""), std::string::npos);
  EXPECT_NE(refusal([&] { make_simplified({}, material, false); }).find("rectangular"),
            std::string::npos);
}

TEST(ClothMeshes, TheResponsiveMeshHasBothTypesOfLinks) {
  const ClothMesh cloth = make_responsive({1.0, 1.0, 49, 49}, Material{});
  EXPECT_EQ(cloth.springs.size(), 9702u);
  EXPECT_EQ(cloth.links.size(), 9408u);
  EXPECT_TRUE(cloth.hinges.empty());
  ASSERT_EQ(cloth.curves.size(), 1u);
  EXPECT_EQ(cloth.curves[0].law, "tension_only");
}

TEST(ArcMesh, HasItsRingsSpokesAndDiagonals) {
  const ClothMesh cloth = make_arc({0.15, 6, 24}, Material{});
  EXPECT_EQ(cloth.surface.vertices.size(), 1u + 24 * 6);
  EXPECT_EQ(cloth.springs.size(), 24u * 6 + 24 * 6 + 2 * 24 * 5);
  EXPECT_EQ(cloth.surface.triangles.size(), 24u + 2 * 24 * 5);
  const double polygon = 0.5 * 24 * std::sin(2 * pi / 24) * 0.15 * 0.15;
  EXPECT_NEAR(sum(cloth.mass), 0.2 * polygon, 1e-14);
  for (const Triangle& t : cloth.surface.triangles) {
    const auto& x = cloth.surface.vertices;
    EXPECT_GT((x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).z(), 0.0);
  }
}

TEST(ArcMesh, UnderAnEvenPullAllRoundItIsTheFabric) {
  // Even strain in all directions needs no direction: energy per area C11 + C12 = c11 + G.
  Material material;
  material.shear_stiffness = 20.0;
  const ClothMesh cloth = make_arc({0.15, 30, 96}, material);
  const double area = 0.5 * 96 * std::sin(2 * pi / 96) * 0.15 * 0.15;
  const ContinuumConstants c = continuum_constants(cloth, cloth.surface.vertices, area);
  const double c11 = 0.5 * (500.0 + std::sqrt(500.0 * 500.0 + 4 * 20.0 * 20.0));
  EXPECT_NEAR(0.25 * (c.c11 + c.c22 + 2 * c.c12) / (0.5 * (c11 + 20.0)), 1.0, 0.02);
  // But the material is polar: over the disc it looks isotropic, with shear that it has from the
  // stretch of its rings and spokes.
  EXPECT_NEAR(c.c11, c.c22, 1e-6);
  EXPECT_GT(c.c33, 2.0 * 20.0);
}

/// Rows of equilateral triangles without halved ones at the sides.
TriangleMesh slanted_rows(int n) {
  TriangleMesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) mesh.vertices.emplace_back(i + 0.5 * j, std::sqrt(0.75) * j, 0.0);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int v = j * (n + 1) + i;
      mesh.triangles.push_back({v, v + 1, v + n + 1});
      mesh.triangles.push_back({v + 1, v + n + 2, v + n + 1});
    }
  return mesh;
}

TEST(Plate, EquilateralTrianglesFitPoissonsRatioOneThirdWithoutResidual) {
  const TriangleMesh mesh = slanted_rows(8);
  const PlateMesh plate = make_plate(mesh, {400.0, 1.0 / 3.0, 5e-4}, Material{});
  EXPECT_LT(plate.worst, 1e-12);
  const ContinuumConstants c =
      continuum_constants(plate.cloth, mesh.vertices, 64 * std::sqrt(0.75));
  EXPECT_LT(relative_distance(c, plate_constants(400.0, 1.0 / 3.0)), 1e-12);
  // Inner edges: √3/2 E h
  EXPECT_NEAR(plate.cloth.springs[plate.cloth.springs.size() / 2].stiffness,
              std::sqrt(0.75) * 400.0, 1e-9);
}

TEST(Plate, OtherPoissonRatiosLeaveExactlyTheCauchyResidual) {
  const TriangleMesh mesh = slanted_rows(4);
  for (const double poisson : {0.1, 0.2, 0.25, 0.45}) {
    const PlateMesh plate = make_plate(mesh, {400.0, poisson, 5e-4}, Material{});
    const double least = cauchy_residual(plate_constants(400.0, poisson));
    EXPECT_GT(least, 0.02);
    EXPECT_GE(plate.residual, least - 1e-12);
    EXPECT_LT(plate.residual, 1.5 * least);
    const ContinuumConstants c =
        continuum_constants(plate.cloth, mesh.vertices, 16 * std::sqrt(0.75));
    EXPECT_NEAR(relative_distance(c, plate_constants(400.0, poisson)), plate.residual, 1e-12);
  }
}

TEST(Plate, BadPlatesAreRefused) {
  TriangleMesh mesh = slanted_rows(2);
  EXPECT_THROW(make_plate(mesh, {400.0, 1.0, 5e-4}, Material{}), std::invalid_argument);
  EXPECT_THROW(make_plate(mesh, {-1.0, 0.3, 5e-4}, Material{}), std::invalid_argument);
  mesh.vertices[3].z() = 0.1;
  EXPECT_NE(refusal([&] { make_plate(mesh, {}, Material{}); }).find("vertex 3"), std::string::npos);
}

/// Gives each element that it visits other vertices, and the first element of any set it refers to.
struct Numberer {
  std::int32_t* next;
  std::int32_t vertices;

  bool vertex(std::int32_t& i) const {
    i = (*next)++ % vertices;
    return true;
  }
  template <class Element>
  bool element(std::int32_t& i) const {
    i = 0;
    return true;
  }
};

/// Lists the indices of an element, but not those of elements that a cloth has only once.
struct Recorder {
  std::vector<std::int32_t>*vertices, *elements;

  bool vertex(std::int32_t& i) const {
    vertices->push_back(i);
    return true;
  }
  template <class Element>
  bool element(std::int32_t& i) const {
    if constexpr (!requires { Element::kUnique; }) elements->push_back(i);
    return true;
  }
};

template <class Element>
void fill(std::vector<Element>& set, const Numberer& number) {
  Element element{};
  if constexpr (requires { element.terms.emplace_back(); }) element.terms.emplace_back();
  element.remap(number);
  set.push_back(element);
}
template <class Kind>
void fill(ElementColumn<Kind>& column, const Numberer&) {
  column.push_back(0);
}

/// A sheet with one element in every set, whatever sets there are.
ClothMesh with_every_element() {
  ClothMesh cloth;
  cloth.surface = make_rectangular({1.0, 1.0, 2, 2}, Material{}).surface;
  cloth.edges = unique_edges(cloth.surface.triangles);
  const auto n = static_cast<std::int32_t>(cloth.surface.vertices.size());
  cloth.mass.assign(n, 0.1);
  std::int32_t next = 0;
  for_each_element_set(cloth, [&](auto& set) { fill(set, {&next, n}); });
  return cloth;
}

std::vector<std::int32_t> sizes(const ClothMesh& cloth) {
  std::vector<std::int32_t> all;
  for_each_element_set(cloth, [&](const auto& set) { all.push_back(int(set.size())); });
  return all;
}

template <class Element>
void record(const std::vector<Element>& set, std::size_t i, const Recorder& recorder) {
  if (i >= set.size()) return;
  Element element = set[i];
  element.remap(recorder);
}
template <class Kind>
void record(const ElementColumn<Kind>&, std::size_t, const Recorder&) {}

/// Indices of element i of every set: of vertices and of other elements.
std::array<std::vector<std::int32_t>, 2> indices(const ClothMesh& cloth, std::size_t i) {
  std::array<std::vector<std::int32_t>, 2> all;
  for_each_element_set(cloth, [&](const auto& set) { record(set, i, {&all[0], &all[1]}); });
  return all;
}

TEST(ElementSets, AppendCarriesEverySet) {
  const ClothMesh piece = with_every_element();
  for (const std::int32_t size : sizes(piece)) ASSERT_EQ(size, 1);
  ClothMesh all;
  for (int k = 0; k < 2; ++k) append(all, piece);
  EXPECT_EQ(all.curves.size(), 1u);  // a cloth has each curve once
  all.curves.push_back({});
  for (const std::int32_t size : sizes(all)) EXPECT_EQ(size, 2);
  EXPECT_EQ(all.curve_of_spring[1], 0);
  const auto first = indices(piece, 0), second = indices(all, 1);
  ASSERT_EQ(first[0].size(), second[0].size());
  const auto n = static_cast<std::int32_t>(piece.surface.vertices.size());
  for (std::size_t i = 0; i < first[0].size(); ++i) EXPECT_EQ(second[0][i], first[0][i] + n);
  for (const std::int32_t i : second[1]) EXPECT_EQ(i, 1);
  EXPECT_EQ(indices(all, 0), first);
}

TEST(ElementSets, CutCarriesEverySet) {
  const ClothMesh piece = with_every_element();
  const ClothMesh all = cut(piece, piece.surface.triangles);
  EXPECT_EQ(sizes(all), sizes(piece));
  EXPECT_EQ(indices(all, 0), indices(piece, 0));
  EXPECT_EQ(all.mass, piece.mass);
}

TEST(ElementSets, RenumberedElementsNameTheNewVertices) {
  const ClothMesh piece = with_every_element();
  const auto n = static_cast<std::int32_t>(piece.surface.vertices.size());
  std::vector<std::int32_t> reversed;
  for (std::int32_t i = n; i-- > 0;) reversed.push_back(i);
  ClothMesh other;
  add_elements(other, piece, reversed);
  EXPECT_EQ(sizes(other), sizes(piece));
  const auto before = indices(piece, 0), after = indices(other, 0);
  ASSERT_EQ(before[0].size(), after[0].size());
  for (std::size_t i = 0; i < before[0].size(); ++i)
    EXPECT_EQ(after[0][i], n - 1 - before[0][i]) << i;
  EXPECT_EQ(after[1], before[1]);
}

TEST(ElementSets, ElementsOfAVertexThatIsLeftOutAreLeftOut) {
  const ClothMesh piece = with_every_element();
  const std::vector<std::int32_t> none(piece.surface.vertices.size(), -1);
  ClothMesh other;
  add_elements(other, piece, none);
  other.curves.clear();  // they name no vertex
  for (const std::int32_t size : sizes(other)) EXPECT_EQ(size, 0);
  EXPECT_NE(refusal([&] {
              add_elements(other, piece, std::span(none).first(3));
            }).find("3 indices for a cloth of 9 vertices"),
            std::string::npos);
}

/// A kind of element that one law knows.
struct Knot {
  std::int32_t a, b;
  bool remap(const auto& to) { return to.vertex(a) && to.vertex(b); }
};

std::vector<Edge> knots_of(const ClothMesh& cloth) {
  std::vector<Edge> ends;
  for (const Knot& knot : detail::elements_of_law<Knot>(cloth)) ends.push_back({knot.a, knot.b});
  return ends;
}

TEST(ElementSets, TheElementsOfALawStayWithTheCloth) {
  ClothMesh piece = make_rectangular({1.0, 1.0, 2, 2}, Material{});
  EXPECT_TRUE(knots_of(piece).empty());
  detail::elements_of_law<Knot>(piece) = {{0, 8}, {0, 1}, {3, 4}};
  EXPECT_EQ(piece.of_laws.size(), 3u);
  ClothMesh two;
  for (int k = 0; k < 2; ++k) append(two, piece);
  EXPECT_EQ(knots_of(two), (std::vector<Edge>{{0, 8}, {0, 1}, {3, 4}, {9, 17}, {9, 10}, {12, 13}}));
  // The vertices 0, 1, 3 and 4 of the first cell become 0 to 3.
  const ClothMesh cell = cut(piece, std::span(piece.surface.triangles).first(2));
  EXPECT_EQ(knots_of(cell), (std::vector<Edge>{{0, 1}, {2, 3}}));
  // Two corners become one vertex, which a knot would name twice.
  const std::vector<std::int32_t> number{0, 1, 2, 3, 4, 5, 6, 7, 0}, kept{0, 1, 2, 3, 4, 5, 6, 7};
  EXPECT_EQ(knots_of(merge_vertices(piece, number, kept)), (std::vector<Edge>{{0, 1}, {3, 4}}));
  EXPECT_EQ(knots_of(piece).size(), 3u);
}

TEST(Materials, AConstantThatTheLawDoesNotReadIsRefusedWithReason) {
  const auto of = [](const Material& m) {
    return refusal([&] { make_rectangular({1.0, 1.0, 2, 2}, m); });
  };
  Material net;
  net.poisson = 0.2;
  EXPECT_EQ(of(net),
            "poisson needs stretch_law \"st_venant_kirchhoff\" or \"corotated\", since \"hooke\" "
            "acts by a net of springs, in which C12 = C33 whatever the springs are; take one of "
            "these or leave poisson out");
  Material links;
  links.bending_law = "buckling";
  links.bending_friction = 1e-4;
  for (const char* part : {"\"hinge\"", "\"buckling\" has no hinges whose angles could stick",
                           "leave bending_friction out"})
    EXPECT_NE(of(links).find(part), std::string::npos) << of(links);
}

TEST(Materials, NumbersThatCannotBeAreRefusedByName) {
  const auto refused = [](const std::string& name, const auto& set) {
    Material m;
    set(m);
    const std::string fault = refusal([&] { make_rectangular({1.0, 1.0, 2, 2}, m); });
    EXPECT_EQ(fault.substr(0, name.size() + 9), name + " must be ") << fault;
  };
  refused("density", [](Material& m) { m.density = 0.0; });
  refused("strain_limit", [](Material& m) { m.strain_limit = -1.0; });
  refused("friction", [](Material& m) { m.friction = std::nan(""); });
  refused("stretch_weft", [](Material& m) { m.stretch_weft = 0.0; });
  refused("biphasic_growth", [](Material& m) { m.of_laws["biphasic_growth"] = -1.0; });
  // These have an upper bound also in a program.
  refused("kawabata_lt", [](Material& m) { m.kawabata_lt = 1.01; });
  refused("kawabata_rt", [](Material& m) { m.kawabata_rt = 1.01; });
  refused("poisson", [](Material& m) {
    m.stretch_law = "corotated";
    m.poisson = 1.0;
  });
  Material stiff;
  stiff.stretch_stiffness = 1e10;  // more than a file may give
  EXPECT_NO_THROW(make_rectangular({1.0, 1.0, 2, 2}, stiff));
}

TEST(Cut, HalvesTheSpringsOfTheNewBorderAndKeepsTheMassInside) {
  const ClothMesh sheet = make_rectangular({1.0, 1.0, 4, 4}, Material{});
  std::vector<Triangle> left;
  for (const Triangle& t : sheet.surface.triangles)
    if (std::all_of(t.begin(), t.end(),
                    [&](auto v) { return sheet.surface.vertices[v].x() < 1e-9; }))
      left.push_back(t);
  const ClothMesh half = cut(sheet, left);
  const ClothMesh whole = make_rectangular({0.5, 1.0, 2, 4}, Material{});
  ASSERT_EQ(half.springs.size(), whole.springs.size());
  EXPECT_NEAR(sum(half.mass), 0.5 * sum(sheet.mass), 1e-12);
  double stiffness = 0.0, expected = 0.0;
  for (const Spring& s : half.springs) stiffness += s.stiffness;
  for (const Spring& s : whole.springs) expected += s.stiffness;
  EXPECT_NEAR(stiffness, expected, 1e-9 * expected);
}

TEST(ClothPatterns, EachFillsARectangleWithCloth) {
  const ClothPatternRegistry patterns = cloth_patterns();
  for (const auto& [name, pattern] : patterns) {
    // These take their mass from the yarns; see swatch_test and knit_test.
    if (name == "weave" || name == "knit" || name == "rib" || name == "interlock") continue;
    const ClothMesh cloth = pattern({1.0, 1.0, 8, 8}, Material{});
    EXPECT_GT(sum(cloth.mass), 0.1) << name;
    EXPECT_LT(sum(cloth.mass), 0.201) << name;
    EXPECT_FALSE(make_internal_forces(cloth).empty()) << name;
  }
  EXPECT_GE(patterns.size(), 7u);
}

TEST(ClothPatterns, OptionsReachThePatternAndDefaultsAreThoseOfItsConfig) {
  const auto bilayered = cloth_patterns().at("bilayered");
  const GridConfig grid{1.0, 1.0, 8, 8};
  const auto stiffness = [](const ClothMesh& cloth) {
    double sum = 0.0;
    for (const auto& tie : cloth.layers) sum += tie.stiffness;
    return sum;
  };
  const ClothMesh usual = bilayered(grid, Material{});
  const ClothMesh same = make_bilayered(grid, LayerConfig{}, Material{});
  EXPECT_EQ(usual.mass, same.mass);
  EXPECT_EQ(stiffness(usual), stiffness(same));
  const ClothMesh other =
      bilayered({{"ratio", 2.0}, {"share", 0.5}, {"hold", 500.0}}, grid, Material{});
  EXPECT_GT(other.mass.size(), usual.mass.size());  // a finer sparse layer
  EXPECT_NEAR(stiffness(other), 0.25 * stiffness(usual), 1e-9 * stiffness(usual));
  EXPECT_GT(other.mass[0], usual.mass[0]);
}

TEST(ForceLaws, ActInTheOrderInWhichTheyWereAdded) {
  ForceLawRegistry laws = force_laws();
  // Another order of these would give other bits. A new law may stand anywhere between them.
  const std::vector<std::string> known{
      "hooke",     "tension_only",  "biphasic",       "kawabata", "measured", "st_venant_kirchhoff",
      "corotated", "yarns",         "shape_operator", "bending",  "bridson",  "buckling",
      "chord",     "bending_curve", "twisting",       "beam",     "crossing", "hysteresis",
      "tie"};
  std::vector<std::string> order;
  for (const auto* law : laws.in_order())
    if (std::find(known.begin(), known.end(), law->name()) != known.end())
      order.push_back(law->name());
  EXPECT_EQ(order, known);
  EXPECT_EQ(laws.keyed().at("sewing").key, "seams");
  // Warp and weft buckle; a law that is replaced keeps its place.
  const ClothMesh cloth = make_responsive({1, 1, 4, 4}, Material{});
  laws.add("tension_only", {}, [](const MethodOptions&, const ClothMesh&) { return ForceList{}; },
           {.promise = "", .source = ""});
  EXPECT_EQ(laws.in_order()[1]->name(), "tension_only");
  EXPECT_EQ(make_internal_forces(cloth, laws).size() + 1, make_internal_forces(cloth).size());
}

TEST(Append, KeepsTheLawOfEachPiece) {
  Material hooke, curved;
  curved.stretch_law = "biphasic";
  curved.bending_law = "bridson";
  const ClothMesh a = make_rectangular({1, 1, 2, 2}, hooke);
  const ClothMesh b = make_rectangular({1, 1, 2, 2}, curved);
  const ClothMesh r = make_responsive({1, 1, 3, 3}, hooke);
  ClothMesh all;
  for (const ClothMesh* piece : {&a, &b, &r, &b, &a}) append(all, *piece);
  ASSERT_EQ(all.curve_of_spring.size(), all.springs.size());
  EXPECT_EQ(all.curves.size(), 2u);
  // Moved apart each piece has the force it has alone: none at rest, and energies add up.
  Vectors x = all.surface.vertices;
  for (Vec3& p : x) p = Vec3(1.1 * p.x(), p.y(), 0.3 * p.x() * p.x());
  double together = 0.0, alone = 0.0;
  for (const auto& force : make_internal_forces(all))
    together += force->energy({x, x, all.mass, 0.0});
  for (const ClothMesh* piece : {&a, &b, &r, &b, &a}) {
    Vectors y = piece->surface.vertices;
    for (Vec3& p : y) p = Vec3(1.1 * p.x(), p.y(), 0.3 * p.x() * p.x());
    for (const auto& force : make_internal_forces(*piece))
      alone += force->energy({y, y, piece->mass, 0.0});
  }
  EXPECT_NEAR(together, alone, 1e-12 * alone);
}

TEST(ClothMeshes, MassesAddUpToDensityTimesArea) {
  for (const auto make : {make_rectangular, make_triangular}) {
    const ClothMesh cloth = make({0.7, 0.3, 7, 5}, Material{});
    double sum = 0.0;
    for (const double m : cloth.mass) sum += m;
    EXPECT_NEAR(sum, 0.2 * 0.7 * 0.3, 1e-14);
    EXPECT_EQ(cloth.mass.size(), cloth.surface.vertices.size());
    EXPECT_EQ(cloth.strain_limit.size(), cloth.springs.size());
    EXPECT_NO_THROW(validate(cloth.surface, "cloth"));
    EXPECT_EQ(cloth.edges, unique_edges(cloth.surface.triangles));
    for (const Triangle& t : cloth.surface.triangles) {
      const auto& x = cloth.surface.vertices;
      EXPECT_GT((x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).z(), 0.0);
    }
  }
}

TEST(ClothMeshes, TheRectangleHasTheSpringsOfTheSurvey) {
  // 50 × 50 particles: 2N(N-1) structural and 2(N-1)² shear.
  const ClothMesh cloth = make_rectangular({1.0, 1.0, 49, 49}, Material{});
  EXPECT_EQ(cloth.springs.size(), 2u * 50 * 49 + 2u * 49 * 49);
  EXPECT_EQ(cloth.surface.triangles.size(), 2u * 49 * 49);
  // Two for each inner grid edge, one for each cell.
  EXPECT_EQ(cloth.hinges.size(), 2u * 2 * 49 * 48 + 49 * 49);
}

TEST(ClothMeshes, BadConfigurationNamesFieldAndValue) {
  const auto message = [](GridConfig grid, Material material) -> std::string {
    try {
      make_rectangular(grid, material);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  Material material;
  EXPECT_NE(message({1.0, 1.0, 0, 5}, material).find("cells_x"), std::string::npos);
  EXPECT_NE(message({-2.5, 1.0, 5, 5}, material).find("-2.5"), std::string::npos);
  EXPECT_NE(message({1.0, 1.0, 2000000000, 2000000000}, material).find("cells"), std::string::npos);
  material.density = 0.0;
  EXPECT_NE(message({}, material).find("density"), std::string::npos);
  material = {};
  material.stretch_stiffness = std::nan("");
  EXPECT_NE(message({}, material).find("stretch_stiffness"), std::string::npos);
  material = {};
  material.shear_stiffness = 1e6;
  EXPECT_NE(message({1.0, 1.0, 10, 50}, material).find("shear_stiffness"), std::string::npos);
}

TEST(ClothMeshes, BadMeshesAreRefused) {
  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}}, {{0, 1, 2}}};
  EXPECT_THROW(make_from_mesh(mesh, mesh, Material{}), std::invalid_argument);  // stray vertex
  mesh.vertices.pop_back();
  EXPECT_NO_THROW(make_from_mesh(mesh, mesh, Material{}));
  TriangleMesh line = mesh;
  line.vertices[2] = {2, 0, 0};
  EXPECT_NO_THROW(make_from_mesh(line, mesh, Material{}));
  EXPECT_THROW(make_from_mesh(mesh, line, Material{}), std::invalid_argument);
  TriangleMesh other = mesh;
  other.triangles[0] = {0, 2, 1};
  EXPECT_THROW(make_from_mesh(mesh, other, Material{}), std::invalid_argument);
  EXPECT_THROW(make_from_mesh({}, {}, Material{}), std::invalid_argument);
}

TEST(ClothMeshes, AppendShiftsEveryIndex) {
  ClothMesh all = make_rectangular({1, 1, 2, 2}, Material{});
  const ClothMesh piece = make_triangular({1, 1, 3, 2}, Material{});
  EXPECT_EQ(append(all, piece), 9);
  EXPECT_EQ(all.mass.size(), 9 + piece.mass.size());
  EXPECT_EQ(all.edges, unique_edges(all.surface.triangles));
  const Spring s = all.springs[all.springs.size() - piece.springs.size()];
  EXPECT_EQ(s.a, piece.springs[0].a + 9);
  EXPECT_EQ(all.hinges.back().v[3], piece.hinges.back().v[3] + 9);
}

TEST(ClothMeshes, EveryElementHasTheDampingOfItsFabric) {
  Material material;
  material.spring_damping = 0.02;
  material.bending_damping = 0.03;
  ClothMesh grid = make_rectangular({1, 1, 3, 2}, material);
  ClothMesh triangles = make_triangular({1, 1, 3, 2}, material);
  ClothMesh file = make_from_mesh(grid.surface, grid.surface, material);
  for (ClothMesh* cloth : {&grid, &triangles, &file}) {
    append(*cloth, with_damping(*cloth, 0.5));
    ASSERT_FALSE(cloth->hinges.empty());
    const std::size_t springs = cloth->springs.size(), hinges = cloth->hinges.size();
    for (std::size_t i = 0; i < springs; ++i)
      EXPECT_EQ(cloth->springs[i].damping, i < springs / 2 ? 0.02 : 0.5) << i;
    for (std::size_t i = 0; i < hinges; ++i)
      EXPECT_EQ(cloth->hinges[i].damping, i < hinges / 2 ? 0.03 : 0.5) << i;
  }
}

TEST(ClothMeshes, NonManifoldEdgesHaveNoHinge) {
  TriangleMesh fin{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}},
                   {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}};
  EXPECT_TRUE(make_from_mesh(fin, fin, Material{}).hinges.empty());
}

}  // namespace
}  // namespace selvedge::cloth_mesh_test
