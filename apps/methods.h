// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/methods.h>

#include <string>
#include <vector>

/// Everything this build has: the library's own methods and the adapters it was built with.
selvedge::Methods methods_of_this_build();

/// A method that comes from an optional library.
struct AdapterMethod {
  std::string family, name;
  std::string library;  ///< what has to be there, when selvedge is built
};

/// Those of any build, whether this one has them or not.
std::vector<AdapterMethod> adapter_methods();
