// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/run/frame_writer.h>
#include <selvedge/scene/scene.h>

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace selvedge::detail {

using Json = nlohmann::json;

/// nullopt if the file is missing or holds no JSON object.
std::optional<Json> read_json(const std::filesystem::path& file);
/// Writes a file that appears only when it is complete.
void write_text(const std::filesystem::path& file, const std::string& text);

/// Removes frames, steps and pictures with numbers above `frame` and `step`, in the formats given,
/// and nothing else. Throws std::invalid_argument for a file that cannot be removed.
void remove_beyond(const std::filesystem::path& out, const FrameFormatRegistry& formats,
                   std::int64_t frame, std::int64_t step);
/// Removes the unfinished files that a killed run has left.
void remove_leftovers(const std::filesystem::path& out);
/// Removes every file that a run and `measure` write, and nothing else.
void remove_former_run(const std::filesystem::path& out, const FrameFormatRegistry& formats);

/// Throws std::invalid_argument with folder, fault and remedy for a folder that holds anything but
/// a run of this scene.
void check_folder(const Scene& scene, const std::filesystem::path& folder);
/// Throws std::invalid_argument if the folder holds frames, a checkpoint or the result of a run.
void refuse_results(const std::filesystem::path& out);
/// Throws std::invalid_argument if the folder cannot be made or written.
void make_folder(const std::filesystem::path& folder);

/// Writes scene.json, by which the folder is recognized. A scene made in code has no text; then the
/// file holds its name.
void write_scene(const std::filesystem::path& out, const Scene& scene);
/// Throws std::invalid_argument unless scene.json agrees with `scene` in everything but time.frames
/// and output. Accepts the keys of older versions.
void check_same_scene(const std::filesystem::path& out, const Scene& scene, const Methods& methods);

}  // namespace selvedge::detail
