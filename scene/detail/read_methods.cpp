// SPDX-License-Identifier: MIT
#include <selvedge/scene/detail/old_keys.h>
#include <selvedge/scene/detail/read_methods.h>

#include <algorithm>

namespace selvedge::detail {

void read_option(const LocatedJson& document, const Json& j, const std::string& path,
                 const std::string& key, const std::string& method,
                 const std::vector<MethodOption>& known, MethodOptions& options) {
  const double value = option_value(j);
  if (const std::string fault = option_fault(known, key, value); !fault.empty()) {
    const std::string answer = answer_to_old_key(path);
    fail(document, path, answer.empty() ? method + " " + fault : answer);
  }
  const auto option = std::find_if(known.begin(), known.end(),
                                   [&](const MethodOption& o) { return o.name == key; });
  if (j.is_boolean() != (option->kind == OptionKind::boolean))
    fail(document, path, j.is_boolean() ? "must be a number" : "must be true or false");
  options.set(key, value);
}

std::string read_method(const LocatedJson& document, const Json& j, const std::string& path,
                        const Methods& methods, std::size_t family, MethodOptions& options) {
  const bool named = j.is_string();
  const auto name = (named ? j : j["type"]).get<std::string>();
  for_each_family(methods, [&](const std::string& key, const auto& registry) {
    if (key != kMethodKeys[family]) return;
    if (const std::string fault = registry.fault(name); !fault.empty())
      fail(document, named ? path : join(path, "type"), fault);
    if (named) return;
    for (const auto& [option, value] : j.items())
      if (option != "type")
        read_option(document, value, join(path, option), option, name, registry.at(name).options(),
                    options);
  });
  return name;
}

}  // namespace selvedge::detail
