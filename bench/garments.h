// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <cstdint>
#include <string>
#include <vector>

/// Garments of about one square metre of cloth for the mannequin, on triangle meshes. The triangles
/// are nearly equilateral and their rows have different numbers of particles, as in the meshes of
/// sewing patterns.
namespace selvedge::bench {

/// One piece of a garment as it lies at the start.
struct GarmentPiece {
  std::string name;
  TriangleMesh surface;  ///< m
  /// The flat pattern, m, with the triangles of `surface` but cut open; empty: `surface` is flat.
  TriangleMesh pattern;
};

/// Two rows of as many particles that are sewn together in their order.
struct GarmentSeam {
  std::string piece_a, piece_b;
  std::vector<std::int32_t> a, b;
};

struct Garment {
  std::vector<GarmentPiece> pieces;
  std::vector<GarmentSeam> seams{};
  double pull = 0.0;                 ///< N, of each pair of a seam at any distance
  std::vector<std::int32_t> held{};  ///< particles of the first piece that stay where they are
  bool arms_level = false;           ///< the mannequin stretches out its arms
};

/// The names that make_garment accepts.
const std::vector<std::string>& garment_names();

/// A garment of about side × side particles, around a mannequin of 1.7 m that looks to -y.
/// - poncho: a flat disc with a hole for the neck, which lies above the shoulders;
/// - skirt: half of a flat ring, sewn to a cone; its waist is held;
/// - torso: two flat panels, in front of and behind the trunk, sewn along sides and shoulders.
/// Throws std::invalid_argument for another name or side < 8.
Garment make_garment(const std::string& name, int side);

}  // namespace selvedge::bench
