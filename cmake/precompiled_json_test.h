// SPDX-License-Identifier: MIT
// Headers of tests that read JSON, compiled once.
#pragma once

#include <nlohmann/json.hpp>

#include "precompiled_test.h"
