// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/internal/json_value.h>
#include <selvedge/simulation/run_result.h>

#include <nlohmann/json.hpp>

namespace selvedge::detail {

/// All fields, in order. Numbers that are not finite become "nan", "inf" or "-inf".
nlohmann::ordered_json result_json(const RunResult& r);
/// The fields that a resumed run joins with its own (Merge).
nlohmann::json checkpoint_json(const RunResult& r);

/// Reads result_json. Throws JsonFault for a missing field or a wrong type.
RunResult result_from(const JsonValue<nlohmann::json>& j);
/// Reads checkpoint_json; the other fields keep their defaults. Throws as result_from.
RunResult result_from_checkpoint(const JsonValue<nlohmann::json>& j);

}  // namespace selvedge::detail
