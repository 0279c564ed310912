// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/solver/detail/implicit_system.h>
#include <selvedge/core/solver/integrator.h>

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// The integrator `implicit_blend`; integrator_implicit_blend.cpp says what it does.
class ImplicitBlend : public Integrator {
 public:
  ImplicitBlend(ForceList forces, std::size_t n, const ImplicitConfig& config);

  IntegratorTraits traits() const override;
  bool expect(double h, std::span<const Vec3> v, std::span<Vec3> mean) override;
  void begin(const StepStart& start, StepEnd end) override;
  SolveReport solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) override;
  std::span<const Vec3> unbalanced(std::span<const Vec3> mean) override;
  bool force_impulses(std::span<const Vec3> mean, ForceImpulses& out) override;
  bool net_impulses(std::span<const Vec3> mean, std::vector<Vec3>& out) override;

 protected:
  void remember(const ForceState& end) override;
  std::map<std::string, double> counters() const override {
    return {{"substituted_implicit_blend_by_implicit_euler", static_cast<double>(euler_steps_)}};
  }
  void save_history(std::vector<double>& memory) const override;
  std::span<const double> restore_history(std::span<const double> memory) override;

  ImplicitSystem system_;

 private:
  bool moves_freely(const StepStart& start);
  bool turns_back(const Particles& p) const;
  void begin_euler(const StepStart& start);
  void begin_blend(const StepStart& start, std::span<const Vec3> mean);
  void find_rigid(const Particles& p);
  void stop_met(std::span<const ImplicitTerm> terms);
  void remember_motion(const ForceState& end);
  void remember_method();

  std::vector<double> alpha_;
  std::vector<Vec3> x_, guess_;  // x + β h u⁻, and u⁻
  std::vector<Vec3> v_;          // m/s, at the start of the step
  std::vector<Vec3> kept_;       // N·s
  Particles heavy_;              // the particles with masses M/α
  std::vector<std::int32_t> met_;
  std::vector<char> rigid_;  // 1: of a rigid body; empty: there are none
  const Particles* start_ = nullptr;
  double h_ = 0.0;  // s, of the present step
  // The mean velocities of the last step and of the one before, relative to the velocity at the
  // end, m/s, so that a change of that shifts them. Lengths of the two steps, s; 0: there was none.
  std::vector<Vec3> lead_, lag_;
  double last_h_ = 0.0, former_h_ = 0.0;
  double pause_ = 0.0;       // steps of implicit Euler that are left
  double next_pause_ = 2.0;  // after the next failure
  bool blends_ = false;      // the last attempt
  bool rings_ = false;       // the start of the step
  bool turned_ = false;      // the velocities turned back in the last step
  int attempts_ = 0;         // since the last accepted step
  std::size_t euler_steps_ = 0;
};

}  // namespace selvedge::detail
