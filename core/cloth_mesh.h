// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/material.h>
#include <selvedge/core/triangle_mesh.h>

#include <vector>

namespace selvedge {

/// A spring between two particles.
struct Spring {
  std::int32_t a, b;
  double rest_length;    ///< m, > 0
  double stiffness;      ///< N/m, force per length change, > 0
  double damping = 0.0;  ///< s, damping force per stiffness and rate of length, >= 0
};

/// Two triangles that share an edge: the edge v[2]-v[3], the opposite vertices v[0] and v[1]. They
/// need not be triangles of the surface.
struct Hinge {
  std::array<std::int32_t, 4> v;
  double rest_angle;     ///< rad, 0 where the rest shape is flat
  double stiffness;      ///< N·m, energy ½·stiffness·(angle - rest_angle)²
  double damping = 0.0;  ///< s, damping moment per stiffness and rate of angle, >= 0
};

/// A piece of cloth at rest: the surface that collides and the springs and hinges that hold it.
/// Several pieces are joined into one by `append`.
struct ClothMesh {
  TriangleMesh surface;     ///< initial shape
  std::vector<Edge> edges;  ///< unique_edges(surface.triangles)
  std::vector<Spring> springs;
  std::vector<Hinge> hinges;
  std::vector<double> mass;          ///< kg per vertex
  std::vector<double> strain_limit;  ///< per spring, largest (L-L0)/L0
};

/// A rectangle in the xy-plane, centred at the origin, cells_x × cells_y cells, vertex (i,j) at
/// index j·(cells_x+1)+i.
struct GridConfig {
  double size_x = 1.0, size_y = 1.0;        ///< m, > 0
  std::int32_t cells_x = 50, cells_y = 50;  ///< >= 1
};

/// Rectangular mesh [Provot1995]: structural and both shear springs; bending by hinges.
/// Throws std::invalid_argument naming the bad field and its value.
ClothMesh make_rectangular(const GridConfig& grid, const Material& material);
/// Near-equilateral triangles: edges are springs [VanGelder1998]; bending by hinges.
ClothMesh make_triangular(const GridConfig& grid, const Material& material);
/// Any triangle mesh; `rest` (same topology) gives the rest lengths and angles, `surface` the
/// start. Non-manifold edges get no hinge.
ClothMesh make_from_mesh(const TriangleMesh& surface, const TriangleMesh& rest,
                         const Material& material);

/// Adds `piece` to `all`; returns the index of its first vertex.
std::int32_t append(ClothMesh& all, const ClothMesh& piece);

}  // namespace selvedge
