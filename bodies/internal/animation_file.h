// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/mesh_file.h>

#include <filesystem>
#include <vector>

namespace selvedge {

/// A mesh whose vertices move: the same triangles at every time.
struct MeshAnimation {
  std::vector<Triangle> triangles;
  std::vector<std::vector<Vec3>> frames;  ///< m, z up; vertices of each frame
  double fps = 0.0;                       ///< frames per second; 0: the file does not say
  FileAxes axes{};                        ///< with which it was read
};

/// How an animation is read.
struct AnimationConfig {
  /// Frames per second at which skeletons and keyframes are sampled (glTF, FBX, Collada, ...), in
  /// (0, 1000]. Caches and USD have frames of their own.
  double fps = 30.0;
  std::filesystem::path base{};  ///< mesh with the triangles of a point cache (.pc2, .mdd)
  /// Unit, up axis and limits, as for load_mesh: what USD, glTF, Collada and FBX files state
  /// counts unless it is given here. Vertices are not welded.
  LoadConfig load{.weld = false};
};

/// Reads an animated mesh:
///   .pc2, .mdd   point caches; `base` gives the triangles
///   .usda        all UsdGeomMesh prims of an ASCII stage, joined; upAxis and metersPerUnit count
///   others       by assimp in a child process, as load_mesh: nodes, skins and morph targets of the
///                first animation, baked to vertices
/// A file without animation gives one frame. Throws std::invalid_argument with file, fault and
/// remedy.
MeshAnimation load_animation(const std::filesystem::path& file, const AnimationConfig& config = {});

}  // namespace selvedge
