// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>
#include <selvedge/pictures/renderer/render.h>

#include <filesystem>
#include <string>
#include <vector>

namespace selvedge {

/// One picture and the suffix of its file name.
struct DetectorPicture {
  std::string name;
  Image image;
};

/// Depth, normal and index maps of the front and the back of a surface at the end of its step, as
/// the image-space detector draws them. Near depths are bright, normals are stored as (n + 1)/2,
/// and each triangle has its own colour. The back is seen from behind. Throws std::invalid_argument
/// in a build without OSMesa.
std::vector<DetectorPicture> map_pictures(const SurfaceView& surface, int resolution);

/// The surface at the end of its step and the boxes of its tree, one picture for each level with at
/// most 8192 boxes.
std::vector<DetectorPicture> level_pictures(const SurfaceView& surface, const Camera& camera);

/// Writes all pictures as NAME_*.png into the folder and creates it if necessary. Returns a
/// sentence that names the pictures that could not be drawn and why; empty if all were drawn.
std::string write_detector_pictures(const SurfaceView& surface, const std::filesystem::path& folder,
                                    const std::string& name);

}  // namespace selvedge
