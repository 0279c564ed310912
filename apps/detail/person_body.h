// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/mesh_file.h>

#include <string>

namespace selvedge {

/// The body of a person. Throws std::invalid_argument for a mesh without triangles, and for one
/// that has not the height of a person, with the option that would give it one.
BodyMesh read_person(const std::string& file, const LoadConfig& config);

}  // namespace selvedge
