// SPDX-License-Identifier: MIT
#include <selvedge/scene/methods.h>

namespace selvedge {

std::vector<ListedMethod> list_methods(const Methods& methods) {
  std::vector<ListedMethod> list;
  for_each_family(methods, [&](const char* key, const auto& registry) {
    for (const auto& [name, entry] : registry)
      list.push_back({.key = key,
                      .name = name,
                      .promise = entry.promise(),
                      .source = entry.source(),
                      .library = entry.library(),
                      .options = entry.options()});
    for (const auto& [name, library] : registry.absent())
      list.push_back({.key = key,
                      .name = name,
                      .promise = "needs " + library,
                      .source = "",
                      .library = library,
                      .available = false});
  });
  return list;
}

}  // namespace selvedge
