// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/compare/compare_plan.h>

#include <nlohmann/json.hpp>

namespace selvedge::detail {

/// The content of plan.json.
nlohmann::ordered_json plan_json(const ComparePlan& plan);

/// The plan that plan_json wrote. Throws std::invalid_argument with the place of a value that a
/// plan cannot have and what it must be, such as "cells[3].threads: must be a whole number from 0
/// to 1024, is 2.5".
ComparePlan plan_from(const nlohmann::ordered_json& json);

}  // namespace selvedge::detail
