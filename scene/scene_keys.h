// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace selvedge {

/// One key of a scene file, from the published schema.
struct SceneKey {
  std::string path;                ///< "geometry.*.cells": a star stands for any index or name
  std::vector<std::string> words;  ///< all its values, if the schema lists them
};

/// All keys, sorted by path.
std::vector<SceneKey> scene_keys();

/// The path with the present name of a renamed key: "contact.thickness" gives "contact.rest_gap".
/// Other paths are returned unchanged.
std::string present_key(const std::string& path);

/// True if `path`, written as for --set with indices or names, is an instance of `key`.
bool is_instance_of(const std::string& path, const std::string& key);

}  // namespace selvedge
