// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

#include <filesystem>
#include <string>
#include <vector>

namespace selvedge {

/// Reads a scene from JSON text in memory. `file` does not have to exist: messages begin with it,
/// relative paths of the scene start at its folder, and a scene without a name takes its stem.
/// Errors as in read_scene.
Scene read_scene_text(const std::string& text, const std::filesystem::path& file,
                      const std::vector<Override>& overrides = {}, const Methods& methods = {});

/// The parts of a scene file with their keys, as a table in Markdown (docs/scene_files.md).
std::string scene_table_text();

}  // namespace selvedge
