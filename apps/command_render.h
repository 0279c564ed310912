// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace CLI {
class App;
}
namespace selvedge {
struct CameraSpec;
}

/// `selvedge render`: pictures, turntables and animations of a result folder or a mesh file.
void add_command_render(CLI::App& app, int& exit_code);

/// Draws one frame of a result folder into a PNG file.
void render_frame(const std::filesystem::path& result, int frame,
                  const selvedge::CameraSpec& camera, const std::filesystem::path& picture);
