// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/cloth_elements.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/detail/dihedral.h>
#include <selvedge/core/cloth/detail/grid_mesh.h>
#include <selvedge/core/cloth/detail/shape_operator.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/internal/material_fields.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace selvedge {
namespace detail {
namespace {

/// A side of a triangle, with its undirected edge as the sort key.
struct Side {
  Edge key;
  std::int32_t triangle, opposite;
  bool forward;  // the triangle traverses the side from key[0] to key[1]
};

std::vector<Side> sorted_sides(std::span<const Triangle> triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      sides.push_back({{std::min(a, b), std::max(a, b)},
                       static_cast<std::int32_t>(t),
                       triangles[t][(k + 2) % 3],
                       a < b});
    }
  std::stable_sort(sides.begin(), sides.end(),
                   [](const Side& a, const Side& b) { return a.key < b.key; });
  return sides;
}

}  // namespace

namespace {

/// `"a", "b" or "c"` for the laws that read a constant.
template <class Law>
std::string laws_that_read(const std::vector<Law>& laws, const std::string& constant) {
  std::vector<std::string> names;
  for (const Law& law : laws)
    if (reads(law.reads, constant)) names.push_back("\"" + law.name + "\"");
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 < names.size() ? ", " : " or ") + names[i];
  return text;
}

/// Refuses a constant that the law of the material does not read; `why` says what this law has
/// instead.
template <class Law>
void require_reader(const char* key, const Law& law, const std::vector<Law>& laws,
                    const char* constant, bool given, const char* why) {
  if (given && !reads(law.reads, constant))
    throw std::invalid_argument(std::string(constant) + " needs " + key + " " +
                                laws_that_read(laws, constant) + ", since \"" + law.name + "\" " +
                                why + "; take one of these or leave " + constant + " out");
}

/// Refuses constants without a law that reads them, and laws without their curves.
void validate_laws(const Material& m) {
  const StretchLaw& stretch = stretch_law_of(m);
  const ShearLaw& shear = shear_law_of(m);
  const BendingLaw& bending = bending_law_of(m);
  const FabricLaws& laws = fabric_laws();
  const bool tension = !m.tension_curve.empty();
  require_reader("stretch_law", stretch, laws.stretch, "tension_curve", tension,
                 "has a formula of its own");
  if (!tension && reads(stretch.reads, "tension_curve"))
    throw std::invalid_argument("stretch_law \"" + stretch.name +
                                "\" needs the points of a tension_curve");
  if (!tension && !m.tension_weft.empty())
    throw std::invalid_argument("tension_curve_weft needs a tension_curve of the warp");
  require_reader("stretch_law", stretch, laws.stretch, "poisson", m.poisson.has_value(),
                 "acts by a net of springs, in which C12 = C33 whatever the springs are");
  require_reader("shear_law", shear, laws.shear, "shear_curve", !m.shear_curve.empty(),
                 "is linear");
  require_reader("shear_law", shear, laws.shear, "shear_friction", m.shear_friction > 0.0,
                 "has no angle between warp and weft that could stick");
  if (m.bending_curve.empty() && !m.bending_curve_weft.empty())
    throw std::invalid_argument("bending_curve_weft needs a bending_curve of the warp");
  require_reader("bending_law", bending, laws.bending, "bending_curve", !m.bending_curve.empty(),
                 "has a formula of its own");
  if (shear.by_triangles && stretch.add_to_triangles != nullptr)
    throw std::invalid_argument(
        "shear_law \"" + shear.name +
        "\" stretches warp and weft each by itself; finite elements carry shear themselves, so "
        "leave shear_law out or take another stretch_law");
}

}  // namespace

void require_reader_of_bending_friction(const Material& m) {
  require_reader("bending_law", bending_law_of(m), fabric_laws().bending, "bending_friction",
                 m.bending_friction > 0.0, "has no hinges whose angles could stick");
}

void validate_material(const Material& m) {
  check_fields(m, "");
  validate_laws(m);
}

void validate_grid(const GridConfig& grid) {
  require(std::isfinite(grid.size_x) && grid.size_x > 0.0, "size_x", grid.size_x,
          "positive and finite");
  require(std::isfinite(grid.size_y) && grid.size_y > 0.0, "size_y", grid.size_y,
          "positive and finite");
  require(grid.cells_x >= 1, "cells_x", grid.cells_x, "at least 1");
  require(grid.cells_y >= 1, "cells_y", grid.cells_y, "at least 1");
  // A vertex has about 13 matrix blocks, which are numbered by 32-bit integers.
  constexpr double most_vertices = std::numeric_limits<std::int32_t>::max() / 16;
  const double vertices = (grid.cells_x + 2.0) * (grid.cells_y + 1.0);
  require(vertices <= most_vertices, "cells_x * cells_y", vertices, "below 134 million");
}

std::vector<InteriorEdge> interior_edges(std::span<const Triangle> triangles) {
  const std::vector<Side> sides = sorted_sides(triangles);
  std::vector<InteriorEdge> edges;
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].key == sides[i].key) ++end;
    if (end - i == 2) {
      const bool swap = !sides[i].forward && sides[i + 1].forward;
      const Side& first = sides[swap ? i + 1 : i];
      const Side& second = sides[swap ? i : i + 1];
      if (first.opposite != second.opposite)
        edges.push_back({{first.opposite, second.opposite, first.key[0], first.key[1]},
                         {first.triangle, second.triangle}});
    }
    i = end;
  }
  return edges;
}

double hinge_stiffness(const std::array<std::int32_t, 4>& v, std::span<const Vec3> rest,
                       double bending_stiffness) {
  // Unfold the hinge: the edge from (0,0) to (l,0), the opposite vertices at (s1,-h1) and (s2,h2).
  // If the plate is bent to w = ½ κ (n·x)² with n = (c,s), the gradient of θ at rest gives, to
  // first order in κ, θ = ½ κ (P c² + 2 Q c s + R s²), with the sums P, Q, R below over the four
  // vertices.
  const Vec3 edge = rest[v[3]] - rest[v[2]];
  const double l = edge.norm();
  const Vec3 e = edge / l;
  const Vec3 to_1 = rest[v[0]] - rest[v[2]], to_2 = rest[v[1]] - rest[v[2]];
  const double s1 = to_1.dot(e), s2 = to_2.dot(e);
  const double h1 = to_1.cross(e).norm(), h2 = to_2.cross(e).norm();
  const double p = -s1 * (l - s1) / h1 - s2 * (l - s2) / h2;
  const double q = s2 - s1;
  const double r = h1 + h2;
  // Mean of (θ/κ)² over all directions: <c⁴> = <s⁴> = 3/8, <c²s²> = 1/8.
  const double mean_square = (3.0 * (p * p + r * r) + 4.0 * q * q + 2.0 * p * r) / 32.0;
  const double area = l * (h1 + h2) / 6.0;
  return bending_stiffness * area / mean_square;
}

bool in_a_level(std::span<const Vec3> rest) {
  return std::all_of(rest.begin(), rest.end(),
                     [&](const Vec3& x) { return x.z() == rest.front().z(); });
}

namespace {

/// Spring stiffnesses of the sides of a triangle, summed over its edges.
class EdgeSprings {
 public:
  EdgeSprings(const ClothMesh& cloth, std::span<const Vec3> rest, const Material& material)
      : cloth_(cloth), rest_(rest), stiffness_(cloth.edges.size(), 0.0) {
    const double warp = material.stretch_stiffness, weft = stretch_along_weft(material);
    const bool fitted = warp != weft && in_a_level(rest);
    // Strips have these moduli, with C12 = C33 as in any spring net. The free constant follows the
    // softer yarn, so that triangles can fit it; in the isotropic case it is Van Gelder's.
    const double between = 3.0 / 8.0 * std::min(warp, weft);
    const auto [c11, c22] = stretch_constants(warp, weft, between);
    const ContinuumConstants c{c11, c22, between, between, 0.0, 0.0};
    for (const Triangle& t : cloth.surface.triangles) {
      if (fitted)
        add(t, fit_springs(rest, t, c).stiffness);
      else
        add_van_gelder(t, 0.5 * (warp + weft));
    }
  }

  const std::vector<double>& stiffness() const { return stiffness_; }

 private:
  // [VanGelder1998]: k = E h Σ A / l². For equilateral triangles the sheet is isotropic with
  // Poisson's ratio 1/3, and its shear stiffness is 3/8 of the stretch stiffness.
  void add_van_gelder(const Triangle& t, double stretch) {
    const double area = 0.5 * (rest_[t[1]] - rest_[t[0]]).cross(rest_[t[2]] - rest_[t[0]]).norm();
    Vec3 k;
    for (int s = 0; s < 3; ++s)
      k[s] = stretch * area / (rest_[t[(s + 1) % 3]] - rest_[t[s]]).squaredNorm();
    add(t, k);
  }

  void add(const Triangle& t, const Vec3& k) {
    for (int s = 0; s < 3; ++s) {
      const Edge key{std::min(t[s], t[(s + 1) % 3]), std::max(t[s], t[(s + 1) % 3])};
      const auto& edges = cloth_.edges;
      stiffness_[std::lower_bound(edges.begin(), edges.end(), key) - edges.begin()] += k[s];
    }
  }

  const ClothMesh& cloth_;
  std::span<const Vec3> rest_;
  std::vector<double> stiffness_;
};

}  // namespace

void add_edge_springs(ClothMesh& cloth, std::span<const Vec3> rest, const Material& material) {
  const EdgeSprings springs(cloth, rest, material);
  // The fit may leave an edge without a spring. Strain limit and damping need one, so each edge
  // gets at least a thousandth of the cloth's stiffness.
  constexpr double least = 1e-3;
  for (std::size_t e = 0; e < cloth.edges.size(); ++e) {
    const auto [a, b] = cloth.edges[e];
    const double stiffness = std::max(springs.stiffness()[e], least * material.stretch_stiffness);
    cloth.springs.push_back({a, b, (rest[b] - rest[a]).norm(), stiffness, material.spring_damping});
    cloth.strain_limit.push_back(material.strain_limit);
  }
}

void add_hinges(ClothMesh& cloth, std::span<const Vec3> rest, const Material& material) {
  if (material.bending_stiffness > 0.0)
    bending_law_of(material).add_to_triangles(cloth, rest, material);
}

void add_edge_hinges(ClothMesh& cloth, std::span<const Vec3> rest, const Material& material) {
  const bool by_sine = bending_law_of(material).by_sine;
  for (const InteriorEdge& edge : interior_edges(cloth.surface.triangles)) {
    const Dihedral d = dihedral(rest, edge.v);
    if (!d.valid) continue;
    cloth.hinges.push_back({edge.v, d.angle,
                            hinge_stiffness(edge.v, rest, material.bending_stiffness),
                            material.bending_damping, by_sine});
  }
}

void add_side_hinge(ClothMesh& cloth, const SplitSide& side, const Material& material) {
  cloth.hinges.push_back({side.hinge, 0.0, side.stiffness, material.bending_damping,
                          bending_law_of(material).by_sine});
}

namespace {

/// Places of the vertices of a triangle along warp and weft: x and y if the cloth is flat, else
/// along and across its first side.
std::array<std::array<double, 2>, 3> warp_and_weft(std::span<const Vec3> rest, const Triangle& t,
                                                   bool flat) {
  std::array<std::array<double, 2>, 3> place{};
  const Vec3 a = rest[t[1]] - rest[t[0]], b = rest[t[2]] - rest[t[0]];
  for (int k = 0; flat && k < 3; ++k) place[k] = {rest[t[k]].x(), rest[t[k]].y()};
  if (flat) return place;
  const double length = a.norm();
  place[1] = {length, 0.0};
  place[2] = {a.dot(b) / length, a.cross(b).norm() / length};
  return place;
}

}  // namespace

void add_membrane(ClothMesh& cloth, std::span<const Vec3> rest, const Material& m,
                  MembraneStrain strain) {
  const bool flat = in_a_level(rest);
  const ContinuumConstants c = membrane_constants(m, flat);
  for (const Triangle& t : cloth.surface.triangles)
    cloth.membranes.push_back(
        {t, warp_and_weft(rest, t, flat), c.c11, c.c22, c.c12, c.c33, m.spring_damping, strain});
}

namespace {

/// The triangles follow `laws` along warp and weft.
void add_yarns(ClothMesh& cloth, std::span<const Vec3> rest, const Material& m,
               const std::array<std::int32_t, 2>& laws) {
  if (!in_a_level(rest))
    throw std::invalid_argument(
        "shear_law \"angle\" needs the directions of warp and weft, which a rest shape that is not "
        "flat does not have; give a flat \"rest_mesh\" or \"rest_mesh\": \"texture\", or take "
        "shear_law \"springs\"");
  for (const std::int32_t law : laws) cloth.curves[law].idle = true;
  const std::int32_t shear_curve =
      m.shear_curve.empty() ? -1 : detail::add_idle_curve(cloth, m.shear_curve);
  for (const Triangle& t : cloth.surface.triangles)
    cloth.yarns.push_back({t, warp_and_weft(rest, t, true), m.stretch_stiffness,
                           stretch_along_weft(m), m.shear_stiffness, m.shear_friction,
                           m.spring_damping, laws, shear_curve});
}

/// Springs along x follow the curve of the warp, along y that of the weft; diagonals are linear.
void set_measured_springs(ClothMesh& cloth, std::span<const Vec3> rest,
                          const std::array<std::int32_t, 2>& laws) {
  constexpr double rounding = 1e-9;
  cloth.curve_of_spring.clear();
  for (const Spring& s : cloth.springs) {
    const Vec3 d = (rest[s.b] - rest[s.a]).cwiseAbs();
    cloth.curve_of_spring.push_back(d.y() <= rounding * d.x()   ? laws[0]
                                    : d.x() <= rounding * d.y() ? laws[1]
                                                                : -1);
  }
}

}  // namespace

void set_stretch_law(ClothMesh& cloth, std::span<const Vec3> rest, const Material& m) {
  const StretchLaw& stretch = stretch_law_of(m);
  const bool on_triangles = shear_law_of(m).by_triangles;
  if (stretch.add_to_triangles != nullptr) stretch.add_to_triangles(cloth, rest, m);
  SpringCurve curve = stretch.curve(m);
  if (curve == SpringCurve{} && !on_triangles) return;
  std::array<std::int32_t, 2> laws{};
  laws.fill(static_cast<std::int32_t>(cloth.curves.size()));
  cloth.curves.push_back(curve);
  if (!m.tension_weft.empty()) {
    ++laws[1];
    curve.measured = m.tension_weft;
    cloth.curves.push_back(curve);
  }
  cloth.curve_of_spring.assign(cloth.springs.size(), laws[0]);
  if (on_triangles)
    add_yarns(cloth, rest, m, laws);
  else if (!curve.measured.empty())
    set_measured_springs(cloth, rest, laws);
}

std::array<std::int32_t, 2> add_bending_shapes(ClothMesh& cloth, const Material& m) {
  std::array<std::int32_t, 2> shapes{};
  shapes.fill(add_idle_curve(cloth, m.bending_curve));
  if (!m.bending_curve_weft.empty()) shapes[1] = add_idle_curve(cloth, m.bending_curve_weft);
  return shapes;
}

std::int32_t add_idle_curve(ClothMesh& cloth, const MonotoneCurve& curve) {
  cloth.curves.push_back({.law = "measured", .measured = curve, .idle = true});
  return static_cast<std::int32_t>(cloth.curves.size()) - 1;
}

namespace {

/// Refuses a constant that the bending law reads on grids of whole cells only.
void refuse_beyond_grids(const Material& m, const char* mesh, const char* constant, bool given) {
  if (!given || reads(bending_law_of(m).reads_on_triangles, constant)) return;
  std::string others;
  for (const BendingLaw& law : fabric_laws().bending)
    if (reads(law.reads_on_triangles, constant))
      others += (others.empty() ? "\"" : " or \"") + law.name + "\"";
  throw std::invalid_argument(std::string(constant) + " needs rows of particles; " + mesh +
                              " has none; use bending_law " + others);
}

/// Refuses what cells that are split do not serve.
void refuse_on_split_cells(const Material& m, const char* mesh) {
  if (!m.bending_curve.empty())
    throw std::invalid_argument(std::string("bending_curve is not served on ") + mesh +
                                "; take a grid without \"refine\"");
  if (m.shear_friction > 0.0)
    throw std::invalid_argument(std::string("shear_friction is not served on ") + mesh +
                                ", whose loops would begin anew at each split; take a grid without "
                                "\"refine\"");
}

/// Refuses a stretch law that needs springs along warp and weft.
void require_free_springs(const Material& m, const char* mesh) {
  if (reads(stretch_law_of(m).reads, "tension_curve") && !shear_law_of(m).by_triangles)
    throw std::invalid_argument("stretch_law \"" + m.stretch_law +
                                "\" needs springs along warp and weft; " + mesh +
                                " has none; use shear_law \"angle\", or a grid of cells");
}

}  // namespace

void require_hinges(const Material& m, const char* mesh, bool split_cells) {
  const BendingLaw& law = bending_law_of(m);
  const auto serves = [&](const BendingLaw& one) {
    return split_cells ? one.add_to_side != nullptr : one.add_to_triangles != nullptr;
  };
  if (!serves(law)) {
    std::string others;
    for (const BendingLaw& one : fabric_laws().bending)
      if (serves(one)) others += "\"" + one.name + "\", ";
    throw std::invalid_argument(std::string("bending_law needs rows of particles; ") + mesh +
                                " has none; use " + others + "or a grid of cells");
  }
  refuse_beyond_grids(m, mesh, "bending_friction", m.bending_friction > 0.0);
  refuse_beyond_grids(m, mesh, "bending_curve", !m.bending_curve.empty());
  if (split_cells) refuse_on_split_cells(m, mesh);
  if (shear_law_of(m).add_to_grid != nullptr)
    throw std::invalid_argument("shear_law \"" + m.shear_law +
                                "\" needs warp and weft at right angles; " + mesh +
                                " has none; use \"angle\" or \"springs\", or the rectangular "
                                "pattern");
  if (!split_cells) require_free_springs(m, mesh);
}

std::vector<char> coupled_hinges(const ClothMesh& cloth) {
  std::vector<char> coupled(cloth.hinges.size(), 0);
  for (const HingeCouple& c : cloth.couples) coupled[c.a] = coupled[c.b] = 1;
  return coupled;
}

}  // namespace detail

}  // namespace selvedge
