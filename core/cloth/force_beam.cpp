// SPDX-License-Identifier: MIT
//
// Bending after J. Villard, H. Borouchaki, "Adaptive meshing for cloth animation", Engineering with
// Computers 2005: the edges of the mesh are beams. Survey eq. 4 gives the force at the end of a
// beam of length l whose surface deviates by the angle α,
//   F = EI α/l²,
// and calls EI the stiffness of a spring and α/l² its displacement. The units say what is meant: a
// spring of stiffness EI/l³ whose displacement is α l, the distance of the end from the straight
// continuation of the beam before. So the force is Hooke's law on that displacement, linear in the
// positions.
//
// For two beams of lengths p and q at particle 1, with h = (p + q)/2,
//   w = (x2 - x1)/q - (x1 - x0)/p,  E = ½ (EI/h) |w|²,
// and the ends feel EI w/(h p) and EI w/(h q), particle 1 the opposite of both. On equal beams
// these are EI α/l² with α = 2 sin(½ turning angle), the chord of the angle. The energy is that of
// a beam of length h bent to the circle through the three particles: the circle has the curvature
// 2 sin(½ angle)/l.
// Deviations: both beams at a particle share one displacement, so that the force has no sum and no
// moment on beams of unequal lengths (cells that are split), where eq. 4 for each beam by itself
// has a moment. A twisting spring (force_twist.cpp) instead is linear in the turning angle, with
// links as long as they are now.
#include <selvedge/core/cloth/detail/element_force.h>
#include <selvedge/core/cloth/detail/grid_mesh.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

namespace selvedge {
namespace {

class Beams {
 public:
  static constexpr int arity = 3;
  static constexpr const char* name = "beam";

  explicit Beams(std::span<const Beam> beams) : beams_(beams.begin(), beams.end()) {
    for (std::size_t i = 0; i < beams.size(); ++i) {
      for (const double length : beams[i].length)
        detail::require_number_of("length", name, i, length, false);
      detail::require_number_of("rigidity", name, i, beams[i].rigidity, false);
      detail::require_number_of("damping", name, i, beams[i].damping);
    }
  }

  std::size_t size() const { return beams_.size(); }
  std::int32_t particle(std::size_t e, int k) const { return beams_[e].v[k]; }
  void reorder(std::span<const std::int32_t> order) { detail::reorder(beams_, order); }

  detail::ElementSample<3> sample(std::size_t e, std::span<const Vec3> x) const {
    const Beam& beam = beams_[e];
    const auto [p, q] = beam.length;
    const Vec3 w = (x[beam.v[2]] - x[beam.v[1]]) / q - (x[beam.v[1]] - x[beam.v[0]]) / p;
    const double bend = w.norm(), stiffness = 2.0 * beam.rigidity / (p + q);
    // Straight beams have the same stiffness in any direction.
    const Vec3 u = bend > 0.0 ? Vec3(w / bend) : Vec3::UnitX();
    detail::ElementSample<3> s;
    s.valid = true;
    s.energy = 0.5 * stiffness * bend * bend;
    s.moment = stiffness * bend;
    s.slope = s.across = s.bound = stiffness;
    s.damping = stiffness * beam.damping;
    s.weight = {1.0 / p, -1.0 / p - 1.0 / q, 1.0 / q};
    for (int k = 0; k < arity; ++k) s.gradient[k] = s.weight[k] * u;
    s.plane = Mat3::Identity() - u * u.transpose();
    return s;
  }

 private:
  std::vector<Beam> beams_;
};

}  // namespace

std::unique_ptr<Force> make_beam_force(std::span<const Beam> beams, std::size_t particles) {
  return std::make_unique<detail::ElementForce<Beams>>(Beams(beams), particles);
}

namespace {

// A row of beams stands for a strip of one cell, on the border of half a cell.
void add_beams(ClothMesh& cloth, const GridConfig& grid, const Material& material) {
  const detail::CellConstants c = detail::cell_sides(grid);
  const double warp = material.bending_stiffness, weft = bending_along_weft(material);
  const std::int32_t nx = grid.cells_x, ny = grid.cells_y, up = nx + 1;
  const auto add = [&](std::int32_t at, std::int32_t step, double length, double rigidity) {
    if (rigidity > 0.0)
      cloth.beams.push_back(
          {{at - step, at, at + step}, {length, length}, rigidity, material.bending_damping});
  };
  for (std::int32_t j = 0; j <= ny; ++j)
    for (std::int32_t i = 0; i <= nx; ++i) {
      const bool inner_x = i > 0 && i<nx, inner_y = j> 0 && j < ny;
      if (inner_x) add(j * up + i, 1, c.a, warp * c.b * (inner_y ? 1.0 : 0.5));
      if (inner_y) add(j * up + i, up, c.b, weft * c.a * (inner_x ? 1.0 : 0.5));
    }
  detail::add_grid_hinges(cloth, grid, material, detail::GridHinges::twist);
}

void add_beam(ClothMesh& cloth, const SplitSide& side, const Material& material) {
  if (side.rigidity_width > 0.0)
    cloth.beams.push_back({side.line, side.length, side.rigidity_width, material.bending_damping});
}

}  // namespace

void register_beam(FabricLaws& laws) {
  laws.bending.push_back({.name = "beam",
                          .text = "beams along rows and columns, linear in the positions",
                          .on_cut_cells = false,
                          .add_to_grid = add_beams,
                          .add_to_side = add_beam});
  laws.forces.add(
      "beam", {},
      [](const MethodOptions&, const ClothMesh& cloth) {
        ForceList forces;
        if (!cloth.beams.empty()) forces.push_back(make_beam_force(cloth.beams, cloth.mass.size()));
        return forces;
      },
      {.promise = "survey eq. 4 corrected: linear in the positions, also on split cells",
       .source = "Villard, Borouchaki, Adaptive meshing for cloth animation, 2005",
       .energy = "bending"});
}

}  // namespace selvedge
