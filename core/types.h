// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace selvedge {

/// A point, direction or velocity. All lengths are in metres and all times in seconds.
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// Two vertex indices of one surface.
using Edge = std::array<std::int32_t, 2>;
/// Three vertex indices of one surface, counter-clockwise seen from the front.
using Triangle = std::array<std::int32_t, 3>;

}  // namespace selvedge
