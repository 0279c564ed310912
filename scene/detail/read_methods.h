// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/detail/scene_json.h>
#include <selvedge/scene/methods.h>

#include <string>
#include <vector>

namespace selvedge::detail {

/// Reads one option of the method `method`. Throws std::invalid_argument through `fail` for an
/// option that it does not have or a value that the option does not accept.
void read_option(const LocatedJson& document, const Json& j, const std::string& path,
                 const std::string& key, const std::string& method,
                 const std::vector<MethodOption>& known, MethodOptions& options);

/// Reads a method of the family kMethodKeys[family] by its name, or an object with its name
/// ("type") and its options. Returns the name.
std::string read_method(const LocatedJson& document, const Json& j, const std::string& path,
                        const Methods& methods, std::size_t family, MethodOptions& options);

}  // namespace selvedge::detail
