// SPDX-License-Identifier: MIT
#include <selvedge/scene/methods.h>

#include <utility>

namespace selvedge {

std::vector<ListedMethod> list_methods(const Methods& methods) {
  std::vector<ListedMethod> list;
  const auto append = [&](std::vector<ListedMethod> family) {
    for (ListedMethod& method : family) list.push_back(std::move(method));
  };
  for_each_family(methods, [&](const std::string& key, const auto& registry) {
    append(list_family(key.substr(key.rfind('.') + 1), key, registry));
  });
  append(list_family("force", kForceLawKey, methods.force_laws));
  return list;
}

}  // namespace selvedge
