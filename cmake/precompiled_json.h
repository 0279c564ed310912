// SPDX-License-Identifier: MIT
// Headers of sources that print text and read or write JSON, compiled once.
#pragma once

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "precompiled.h"
