// SPDX-License-Identifier: MIT
#include <selvedge/simulation/run_result.h>

#include <algorithm>
#include <type_traits>

namespace selvedge {
namespace {

bool is_maximum(const std::string& name) {
  return name.starts_with("max_") || name.starts_with("worst_");
}

template <class T>
requires std::is_arithmetic_v<T>
void join(Merge rule, const T& before, T& r) {
  switch (rule) {
    case Merge::sum:
      r = static_cast<T>(r + before);
      return;
    case Merge::max:
      r = std::max(r, before);
      return;
    case Merge::both:
      r = static_cast<T>(r && before);
      return;
    case Merge::first_set:
      if (r == T{}) r = before;
      return;
    default:
      return;
  }
}

void join(Merge, const std::string&, std::string&) {}

void join(Merge, const FlagCounts& before, FlagCounts& r) {
  for (std::size_t bit = 0; bit < kVertexFlags; ++bit)
    r.worst[bit] = std::max(r.worst[bit], before.worst[bit]);
}

template <class T>
void join(Merge rule, const std::map<std::string, T>& before, std::map<std::string, T>& r);

template <HasFields T>
void join(Merge, const T& before, T& r) {
  Fields<T>::visit([&](const char*, auto member, FieldRule rule) {
    join(rule.merge, before.*member, r.*member);
  });
}

template <class T>
void join(Merge rule, const std::map<std::string, T>& before, std::map<std::string, T>& r) {
  if (rule == Merge::last) return;
  for (const auto& [name, value] : before) {
    const bool resolves = rule == Merge::by_name && std::is_arithmetic_v<T>;
    join(!resolves ? rule : is_maximum(name) ? Merge::max : Merge::sum, value, r[name]);
  }
}

}  // namespace

void carry_on(const RunResult& before, RunResult& r) {
  join(Merge::each, before, r);
  r.clean = r.clean && r.clean_elsewhere && r.tangle.jams == 0;
}

}  // namespace selvedge
