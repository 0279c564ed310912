// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/run/frame_writer.h>
#include <selvedge/scene/build.h>

#include <array>
#include <vector>

namespace selvedge {

/// Texture coordinates from the rest shape of each piece that lies flat: its box, as large as fits
/// the unit square; for each corner of each triangle, as Frame::texture.
std::vector<std::array<TexturePoint, 3>> flat_texture(const BuiltScene& built);

}  // namespace selvedge
