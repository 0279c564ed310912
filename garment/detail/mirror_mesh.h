// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/garment/panel_mesh.h>

#include <optional>
#include <span>

namespace selvedge::detail {

/// A panel as it is meshed.
struct MeshedPanel {
  PanelOutline outline;
  PolygonMesh mesh;
  std::vector<Vec3> placed;  ///< the points of the loop as they stand in space, m
};

/// A mesh that is its own mirror image, or that of another panel.
struct MirrorMesh {
  PolygonMesh mesh;
  std::int32_t panel = -1;          ///< whose image it is; -1: its own
  std::vector<std::int32_t> image;  ///< of each vertex, the vertex of that panel
};

/// Mesh of an outline that is its own mirror image about a line; `across` is a vector roughly
/// normal to it. One half is meshed, the other one is its image. None for an outline that is not
/// (within a fiftieth of the edge length), has lines, or is too narrow along the line.
std::optional<MirrorMesh> mesh_of_halves(const PanelOutline& outline, const Vec2& across,
                                         const PanelMeshConfig& config);

/// Mesh of an outline that is the mirror image of one of these panels: of the one that stands
/// nearest to its image in the plane x = `middle`, and within 5 cm of it. `placed` is the loop in
/// space. None if there is no such panel.
std::optional<MirrorMesh> mesh_of_image(const PanelOutline& outline, std::span<const Vec3> placed,
                                        std::span<const MeshedPanel> panels, double middle,
                                        const PanelMeshConfig& config);

}  // namespace selvedge::detail
