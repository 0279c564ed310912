// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/output.h>

#include <filesystem>
#include <string>
#include <vector>

namespace selvedge {

/// Numbers of the files STEM_NUMBER.ply in a folder, ascending; none if there is no such folder.
/// Throws std::invalid_argument if the folder cannot be read.
std::vector<int> numbers_of(const std::filesystem::path& folder, const std::string& stem);

}  // namespace selvedge
