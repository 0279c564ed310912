// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/render.h>
#include <selvedge/core/collision_types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace selvedge {

/// One picture and the end of its file's name.
struct DetectorPicture {
  std::string name;
  Image image;
};

/// Front and back of a surface at the end of its step as image space sees them, each as a depth, a
/// normal and an index map: depth is brighter the nearer it is, normals are (n + 1)/2, every
/// triangle has a colour of its own. The back is shown as seen from behind. Throws
/// std::invalid_argument in a build without OSMesa.
std::vector<DetectorPicture> map_pictures(const SurfaceView& surface, int resolution);

/// The surface at the end of its step within the boxes of its tree, one picture for each level with
/// at most 8192 boxes.
std::vector<DetectorPicture> level_pictures(const SurfaceView& surface, const Camera& camera);

/// Writes all of them as NAME_*.png into the folder, which is made if missing. Returns what could
/// not be drawn and why, in one sentence; empty if nothing.
std::string write_detector_pictures(const SurfaceView& surface, const std::filesystem::path& folder,
                                    const std::string& name);

}  // namespace selvedge
