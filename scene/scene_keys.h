// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace selvedge {

/// One key of a scene file, by the published schema.
struct SceneKey {
  std::string path;                ///< "geometry.*.cells": a star stands for any index or name
  std::vector<std::string> words;  ///< the values it may hold, if they are finitely many
};

/// All keys, sorted by path.
std::vector<SceneKey> scene_keys();

/// Whether `path` (as --set takes it, with indices or names) is an instance of `key`.
bool is_instance_of(const std::string& path, const std::string& key);

/// The known word with the smallest edit distance, the first of several; "" if none is known.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

}  // namespace selvedge
