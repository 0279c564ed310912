// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/mesh_file.h>

#include <filesystem>
#include <string>

/// The scenes of `bench drape` as files, so that programs of two versions can run the same ones.
namespace selvedge::bench {

/// One scene: a sheet on a body, or a garment on the mannequin.
struct DrapeScene {
  std::string body = "ball";  ///< ball, mannequin or a mesh file; not used if `garment` is set
  std::string garment{};      ///< a name of garment_names(), or "": a sheet
  LoadConfig load{};          ///< unit and up axis of a mesh file
  int subdivisions = 0;       ///< of a body mesh: each one splits every triangle in four
  int frames = 120;

  /// For tables and folders: the garment, "ball", "mannequin" or the file name without its ending.
  std::string name() const;
};

/// Each triangle becomes four by the midpoints of its sides; the surface stays the same.
TriangleMesh subdivided(const TriangleMesh& mesh);

/// Writes scene.json and the meshes that it names into the folder, which is made if missing;
/// returns the path of scene.json. A sheet has side × side particles, a garment about as many.
/// Throws std::invalid_argument for a bad mesh file, garment or size.
std::filesystem::path write_drape_scene(const std::filesystem::path& folder,
                                        const DrapeScene& scene, int side);

}  // namespace selvedge::bench
