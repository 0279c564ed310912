// SPDX-License-Identifier: MIT
// Headers of the tests, compiled once.
#pragma once

#include <gtest/gtest.h>

#include "precompiled.h"
