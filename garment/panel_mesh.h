// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/garment/sewing_pattern.h>

#include <map>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

struct PanelMeshConfig {
  double edge_length = 0.01;    ///< m, of the triangles, > 0; shorter at gathers and narrow places
  std::int32_t smoothing = 12;  ///< sweeps that improve the angles, >= 0
  double gap = 0.02;            ///< m, distance of the flat panels from each other, >= 0
  std::int64_t vertices = 4000000;  ///< refuse larger meshes
  PatternLimits limits = {};
};

/// Quality of a mesh.
struct PanelMeshQuality {
  std::int64_t vertices = 0, triangles = 0;
  double area = 0.0;                                 ///< m², of the triangles
  double shortest = 0.0, mean = 0.0, longest = 0.0;  ///< m, of the edges
  double least_angle = 0.0;                          ///< rad, of all triangles
  /// rad, of the triangles that have no corner of a panel below 60 degrees, which bound the angle.
  double least_free_angle = 0.0;
  double mean_least_angle = 0.0;  ///< rad, mean over triangles of the least angle
};

/// The meshes of the panels of a garment, which are not sewn yet. All lists are in the order of the
/// pattern. Vertices of one panel follow each other, those of its border first, along the loop.
struct GarmentMesh {
  std::string name;
  /// The flat panels side by side, z = 0, m: the rest shape. Triangles are counter-clockwise, seen
  /// from the outer side. A panel whose outer side is the back of the file's plane is mirrored in
  /// x.
  TriangleMesh flat;
  std::vector<Vec3> placed;  ///< the same vertices as the panels stand in space, m
  std::vector<std::int32_t> panel_of_vertex, panel_of_triangle;
  /// Of each vertex, the one that is its mirror image, left and right (along x) exchanged; -1 in a
  /// panel that is the mirror image neither of itself nor of another one.
  std::vector<std::int32_t> image;
  /// Per panel: index of its first vertex and first triangle, and one past those of the last panel.
  std::vector<std::int32_t> first_vertex, first_triangle;
  std::vector<std::string> panel_names;
  std::vector<char> mirrored;  ///< per panel: `flat` mirrors the file's plane in x
  /// edge_vertices[panel][edge]: the vertices along the edge from its start to its end, both
  /// included; a single one for an edge so short that the mesh joins it with its neighbours.
  std::vector<std::vector<std::vector<std::int32_t>>> edge_vertices;
  std::vector<std::vector<std::vector<std::int32_t>>> line_vertices;  ///< the same of its lines

  struct Stitch {
    std::vector<std::int32_t> a, b;  ///< equally many; a[i] is sewn to b[i], ends included
    std::string name;  ///< such as stitch 3: edge 2 of panel "front" to edge 5 of panel "back"
    double length_a = 0.0, length_b = 0.0;  ///< m, along the curves
    SeamDirection direction;
    PatternStitch::Closure closure = PatternStitch::Closure::seam;
    std::vector<std::int32_t> buttons{};  ///< the pairs that buttons join; else all are sewn
  };
  /// The first or last vertices of both sides are the same vertex where a dart ends. Both sides
  /// have a single vertex if they are joined with their neighbours.
  std::vector<Stitch> stitches;
  /// A line along which the cloth is folded at rest.
  struct Fold {
    std::vector<std::int32_t> vertices;   ///< along the line
    double angle = 0.0, stiffness = 0.0;  ///< as PatternLine, rad and N
  };
  std::vector<Fold> folds;
  /// An elastic along an edge or a line.
  struct Elastic {
    std::vector<std::int32_t> vertices;  ///< along it
    PatternElastic elastic;
    std::string name;  ///< such as edge 2 of panel "front"
  };
  std::vector<Elastic> elastics;

  /// Vertices of the edges with a label, ascending.
  std::map<std::string, std::vector<std::int32_t>> labels;
  std::vector<std::string> panel_labels;   ///< empty: none
  std::vector<std::string> panel_fabrics;  ///< as PatternPanel::fabric

  std::vector<PanelMeshQuality> panel_quality;
  PanelMeshQuality quality;  ///< of all panels
  std::vector<std::string>
      notes;  ///< sentences for the user: short edges, turned panels, twisted seams
};

/// Meshes every panel at the wanted edge length. Both sides of a seam have equally many vertices,
/// equally spaced along each curve, so a longer side is gathered evenly. Edges far below the edge
/// length are joined with their neighbours, as a note says. No triangle has two sides
/// on the border of its panel, so that sewing never makes two triangles with the same vertices at a
/// corner. Panels that are mirror images of themselves or of each other, as they stand, get such
/// meshes. The same bits for the same input. Throws std::invalid_argument as check_sewing_pattern
/// does, for a bad field of the config, and if a border crosses itself at this edge length.
GarmentMesh mesh_garment(const SewingPattern& pattern, const PanelMeshConfig& config = {});

/// Mesh of a simple polygon: the vertices of the loop first, in order, then those inside.
struct PolygonMesh {
  std::vector<Vec2> vertices;  ///< m
  std::vector<Triangle> triangles;
  PanelMeshQuality quality;
};
/// Constrained Delaunay mesh of a polygon (m) whose sides stay whole; edges inside grow from the
/// length of the sides to `edge_length`. Counter-clockwise triangles for a loop either way round.
/// Throws std::invalid_argument if the loop crosses or touches itself, which is decided exactly on
/// coordinates rounded to 2^-25 of its extent.
PolygonMesh mesh_polygon(std::span<const Vec2> loop, const PanelMeshConfig& config = {});

/// A simple polygon with lines inside it.
struct PanelOutline {
  std::vector<Vec2> points;  ///< m, those of the loop first
  std::size_t sides = 0;     ///< points of the loop, at least 3
  std::vector<Edge> lines;   ///< two points each; they meet others only at their ends

  std::span<const Vec2> loop() const { return std::span(points).first(sides); }
};
/// The same with lines that stay whole, too. The points of the outline are its first vertices.
PolygonMesh mesh_outline(const PanelOutline& outline, const PanelMeshConfig& config = {});

}  // namespace selvedge
