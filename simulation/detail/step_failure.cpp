// SPDX-License-Identifier: MIT
#include <selvedge/simulation/failure.h>
#include <selvedge/simulation/step_report.h>

namespace selvedge {
namespace {

constexpr FailureKind kKinds[] = {FailureKind::not_clean, FailureKind::not_finite,
                                  FailureKind::stalled, FailureKind::out_of_budget,
                                  FailureKind::unstable_step};

// Steps of at least 1/8 of the nominal one are no sign of a stall.
constexpr int kFewHalvings = 4;

}  // namespace

bool is_near_smallest(int halvings, int max_halvings) {
  return max_halvings >= kFewHalvings && halvings >= max_halvings - 1;
}

const char* failure_name(FailureKind kind) {
  switch (kind) {
    case FailureKind::not_clean:
      return "not clean";
    case FailureKind::not_finite:
      return "not finite";
    case FailureKind::stalled:
      return "stalled";
    case FailureKind::out_of_budget:
      return "out of budget";
    case FailureKind::unstable_step:
      return "unstable step";
  }
  return "";
}

FailureKind failure_kind(const std::string& name) {
  for (const FailureKind kind : kKinds)
    if (name == failure_name(kind)) return kind;
  throw std::invalid_argument("\"" + name + "\" is not a cause for which a run stops");
}

}  // namespace selvedge
