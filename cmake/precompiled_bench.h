// SPDX-License-Identifier: MIT
// Headers of the benchmarks, compiled once.
#pragma once

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "precompiled.h"
