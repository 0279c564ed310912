// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/garment/panel_mesh.h>
#include <selvedge/scene/detail/read_garment.h>
#include <selvedge/scene/detail/read_values.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace selvedge::detail {
namespace {

GarmentMesh mesh_file(const LocatedJson& document, const GarmentKeys& keys,
                      const std::string& path) {
  PanelMeshConfig config;
  config.edge_length = keys.edge_length;
  try {
    return mesh_garment(read_sewing_pattern(keys.sewing_pattern), config);
  } catch (const std::invalid_argument& error) {
    fail(document, join(path, "sewing_pattern"), error.what());
  }
}

void turn_upright(GarmentMesh& garment, UpAxis up) {
  LoadConfig axes;
  axes.up = up;
  axes.weld = false;
  TriangleMesh turned = prepare_mesh({garment.placed, garment.flat.triangles}, axes, garment.name);
  garment.placed = std::move(turned.vertices);
}

void move_panels(const LocatedJson& document, const std::map<std::string, Vec3>& moves,
                 const std::string& path, GarmentMesh& garment) {
  for (const auto& [name, move] : moves) {
    require_known(document, name, garment.panel_names, join(path, name), "panel");
    const auto found = std::find(garment.panel_names.begin(), garment.panel_names.end(), name);
    const auto panel = found - garment.panel_names.begin();
    for (std::int32_t v = garment.first_vertex[panel]; v < garment.first_vertex[panel + 1]; ++v)
      garment.placed[v] += move;
  }
}

/// Vertices of two panels in one place would touch from the start.
void refuse_touching(const LocatedJson& document, const std::string& path,
                     const GarmentMesh& garment) {
  const std::vector<Vec3>& x = garment.placed;
  std::vector<std::size_t> order(x.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    if (x[a] == x[b]) return a < b;
    return std::lexicographical_compare(x[a].begin(), x[a].end(), x[b].begin(), x[b].end());
  });
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (x[order[i]] != x[order[i - 1]]) continue;
    const auto name = [&](std::size_t v) {
      return garment.panel_names[garment.panel_of_vertex[v]];
    };
    fail(document, path,
         fmt::format("the panels \"{}\" and \"{}\" touch; move one of them by \"panels\"",
                     name(std::min(order[i], order[i - 1])),
                     name(std::max(order[i], order[i - 1]))));
  }
}

SeamSpec seam_of(const GarmentMesh::Stitch& stitch, const std::string& piece,
                 const GarmentSewing& sewing) {
  SeamSpec seam;
  seam.name = fmt::format("{}: {}", piece, stitch.name);
  seam.geometry = {piece, piece};
  for (std::size_t i = 0; i < stitch.a.size(); ++i) {
    if (stitch.closure == PatternStitch::Closure::buttons &&
        !std::binary_search(stitch.buttons.begin(), stitch.buttons.end(),
                            static_cast<std::int32_t>(i)))
      continue;
    if (stitch.a[i] == stitch.b[i]) continue;  // the tip of a dart
    seam.vertices[0].push_back(stitch.a[i]);
    seam.vertices[1].push_back(stitch.b[i]);
  }
  seam.sewing.pull = sewing.pull;
  seam.merge = sewing.merge;
  return seam;
}

}  // namespace

void read_garment(const LocatedJson& document, const std::string& path, PieceOf<GarmentKeys>& piece,
                  std::vector<SeamSpec>& seams) {
  const GarmentKeys& keys = piece.shape;
  GarmentMesh garment = mesh_file(document, keys, path);
  turn_upright(garment, keys.up);
  move_panels(document, keys.panels, join(path, "panels"), garment);
  refuse_touching(document, join(path, "sewing_pattern"), garment);
  for (const GarmentMesh::Stitch& stitch : garment.stitches)
    seams.push_back(seam_of(stitch, piece.cloth.name, keys.sewing));
  ClothFile shape;
  shape.mesh = {std::move(garment.placed), garment.flat.triangles};
  // The warp runs along x of a flat mesh, and along y of a panel.
  for (Vec3& x : garment.flat.vertices) x = Vec3(x.y(), -x.x(), 0.0);
  shape.rest_mesh = std::move(garment.flat);
  piece.cloth.shape = std::move(shape);
}

}  // namespace selvedge::detail
