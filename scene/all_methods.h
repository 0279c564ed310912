// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/methods.h>

/// Everything this build has: the library's own methods and the adapters it was built with.
selvedge::Methods methods_of_this_build();
