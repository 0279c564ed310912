// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/detail/read_fields.h>

namespace selvedge::detail {

/// Reads "obstacles" of a checked and complete document into `scene`. Throws std::invalid_argument
/// through `fail`.
void read_bodies(LocatedJson& document, const FieldReader& fields, Scene& scene);

}  // namespace selvedge::detail
