// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/detail/impact_zone.h>
#include <selvedge/response/fail_safe.h>

#include <map>
#include <string>
#include <utility>

namespace selvedge::detail {

/// A fail-safe of two layers: a few passes that correct the motion contact by contact, then rigid
/// impact zones for the collisions that remain.
class ZonesAfter : public FailSafe {
 public:
  void begin(const ResponseStep& step, Clearances&) final {
    step_ = step;
    round_ = 0;
  }

  bool resolve(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) final {
    const int round = round_++;
    if (round < passes_) {
      pass(step_, round == 0, hits, x_t1);
      counters_[counter_] += 1;
      return true;
    }
    if (round == passes_) zones_.begin(step_.motion);
    if (round >= passes_ + ImpactZones::kRounds) {
      failure_reason_ = name_ + " and rigid impact zones could not resolve all collisions";
      return false;
    }
    if (zones_.grow(hits, step_.mass, x_t1, counters_)) return true;
    failure_reason_ = zones_.failure_reason();
    return false;
  }

  const std::string& failure_reason() const final { return failure_reason_; }
  const std::map<std::string, double>& counters() const final { return counters_; }

 protected:
  /// `name` describes the passes in messages; `counter` is the name of their counter.
  ZonesAfter(int passes, std::string name, std::string counter)
      : passes_(passes), name_(std::move(name)), counter_(std::move(counter)) {}

 private:
  /// Moves particles in `x_t1` for these hits. `first`: this is the first pass of the step.
  virtual void pass(const ResponseStep& step, bool first, std::span<const ContactPoint> hits,
                    std::span<Vec3> x_t1) = 0;

  const int passes_;
  const std::string name_, counter_;
  ResponseStep step_;
  ImpactZones zones_;
  int round_ = 0;
  std::string failure_reason_;
  std::map<std::string, double> counters_;
};

}  // namespace selvedge::detail
