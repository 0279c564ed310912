// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/text.h>  // counted
