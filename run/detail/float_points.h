// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <filesystem>
#include <span>
#include <vector>

namespace selvedge::detail {

/// The nearest single-precision numbers of points, x y z of one after the other. Throws
/// std::invalid_argument that names `file` and the first point outside the range of float.
std::vector<float> float_points(std::span<const Vec3> x, const std::filesystem::path& file);

/// Throws std::invalid_argument that names `file` if a frame has another number of points than the
/// first one, or if they do not fit 32-bit counts.
void check_point_count(std::size_t points, std::size_t first, const std::filesystem::path& file);

}  // namespace selvedge::detail
