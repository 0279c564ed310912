// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/detail/scene_json.h>
#include <selvedge/scene/methods.h>

namespace selvedge::detail {

/// Gives the keys of older scene files their present places, and drops those that are gone if their
/// value changes nothing. Call it before the document is checked. Throws std::invalid_argument
/// through `fail` if a value stands at both places.
void rename_old_keys(LocatedJson& document);

/// The same for options of methods that stand beside the name of the method. Call it after all
/// overrides, as one of them may name another method.
void move_old_options(LocatedJson& document, const Methods& methods);

/// One sentence, without full stop, on a key that was renamed or removed; empty for other keys.
std::string answer_to_old_key(const std::string& path);

/// The present path of an old key in a `--set`, except that of an option: see move_old_options.
std::string renamed_path(const std::string& path);

}  // namespace selvedge::detail
