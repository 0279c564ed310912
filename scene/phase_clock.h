// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <map>
#include <string>

namespace selvedge {

/// Wall seconds by phase of a run. A Scope adds the time for which it lives; scopes do not nest.
class PhaseClock {
 public:
  class Scope {
   public:
    explicit Scope(double& total) : total_(total) {}
    ~Scope() {
      total_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    double& total_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  };

  [[nodiscard]] Scope measure(const std::string& phase) { return Scope(seconds_[phase]); }
  const std::map<std::string, double>& seconds() const { return seconds_; }

 private:
  std::map<std::string, double> seconds_;
};

}  // namespace selvedge
