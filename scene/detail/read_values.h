// SPDX-License-Identifier: MIT
//
// Values that several parts of a scene have: names, files, rotations, motions. The
// document is checked and complete. Faults throw std::invalid_argument through `fail`.
#pragma once

#include <selvedge/scene/detail/scene_json.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace selvedge::detail {

Vec3 read_vec3(const Json& j);
std::string in_quotes(const std::string& word);

/// The name of an element, unique in its list; made from the index if the element has none.
std::string read_name(const LocatedJson& document, Json& element, const std::string& stem,
                      std::size_t index, std::set<std::string>& taken);

/// Fails unless `word` is known, and names the nearest known one.
void require_known(const LocatedJson& document, const std::string& word,
                   const std::vector<std::string>& known, const std::string& path,
                   const std::string& kind);

/// The path of a file name, which is relative to the scene file.
std::filesystem::path absolute_path(const LocatedJson& document, const std::string& name);
/// The absolute path of a file that exists; also stored in the document.
std::filesystem::path read_file(const LocatedJson& document, Json& j, const std::string& path);

/// One rotation, or a list that is applied in order.
Eigen::Quaterniond read_rotation(const LocatedJson& document, const Json& j,
                                 const std::string& path);

/// Checks all of "motions", used or not.
void check_motions(const LocatedJson& document);
/// Keyframes, or the name of one of "motions".
std::vector<Keyframe> read_motion(const LocatedJson& document, const Json& j,
                                  const std::string& path);

}  // namespace selvedge::detail
