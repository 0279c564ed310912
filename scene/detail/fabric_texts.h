// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <string>

namespace selvedge::detail {

/// The files of data/fabrics as compiled in, by name without extension.
const std::map<std::string, std::string>& fabric_texts();

}  // namespace selvedge::detail
