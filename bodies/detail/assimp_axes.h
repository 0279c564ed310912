// SPDX-License-Identifier: MIT
//
// What a file that assimp reads states of its axes. Only selvedge-assimp includes this.
#pragma once

#include <assimp/scene.h>

#include <string>
#include <vector>

namespace selvedge::detail {

/// The unit and the up axis that a file states.
struct Axes {
  double unit = 0.0;  ///< m; 0: the file does not say
  /// 1, 2 or 3 for the file's x, y or z; negative where the negative axis points up; 0: the file
  /// does not say
  int up = 0;
  double applied = 1.0;  ///< m; assimp has multiplied all positions by it
};

/// glTF is in metres with y up [glTF 2.0, 3.4]. A Collada file states both in its <asset>; else it
/// is in metres with y up [COLLADA 1.4.1]. FBX has UnitScaleFactor, in centimetres, and UpAxis in
/// its global settings. Other formats state nothing that assimp passes on.
Axes stated_axes(const aiScene& scene, const std::string& file);

/// Undoes the scale that assimp has applied, at the root of the scene.
void undo_unit(const aiScene& scene, const Axes& axes);

/// Unit and up axis as they stand in the output.
std::vector<double> words_of(const Axes& axes);

}  // namespace selvedge::detail
