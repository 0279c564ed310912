// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace selvedge::detail {

using Json = nlohmann::json;

/// None if the file is missing or holds no JSON object.
std::optional<Json> read_json(const std::filesystem::path& file);

/// Removes frames, steps and pictures with larger numbers, and nothing else. Throws
/// std::invalid_argument for a file that cannot be removed.
void remove_beyond(const std::filesystem::path& out, std::int64_t frame, std::int64_t step);
/// Removes every file that a run writes, and nothing else.
void remove_former_run(const std::filesystem::path& out);

/// Refuses a folder in which a run of this scene would mix with something else:
/// std::invalid_argument with folder, fault and remedy.
void check_folder(const Scene& scene, const std::filesystem::path& folder);
/// Throws std::invalid_argument if the folder cannot be made or written.
void make_folder(const std::filesystem::path& folder);

void write_text(const std::filesystem::path& file, const std::string& text);

}  // namespace selvedge::detail
