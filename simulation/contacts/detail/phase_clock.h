// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/internal/stopwatch.h>

#include <map>
#include <string>

namespace selvedge::detail {

/// Wall seconds by phase of a run. A Scope adds its lifetime; scopes must not nest.
class PhaseClock {
 public:
  class Scope {
   public:
    explicit Scope(double& total) : total_(total) {}
    ~Scope() { total_ += watch_.seconds(); }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    double& total_;
    Stopwatch watch_;
  };

  [[nodiscard]] Scope measure(const std::string& phase) { return Scope(seconds_[phase]); }
  const std::map<std::string, double>& seconds() const { return seconds_; }

 private:
  std::map<std::string, double> seconds_;
};

}  // namespace selvedge::detail
