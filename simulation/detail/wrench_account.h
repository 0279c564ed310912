// SPDX-License-Identifier: MIT
//
// What bodies, handles and held particles feel in each step, and what gave the cloth its momentum.
#pragma once

#include <selvedge/simulation/detail/step.h>
#include <selvedge/simulation/step_report.h>

#include <map>
#include <span>
#include <vector>

namespace selvedge::detail {

/// The wrenches of the last step and their mean over several. A simulation has one only if it is
/// asked for them.
class WrenchAccount {
 public:
  WrenchAccount(const Scene& scene, const BuiltScene& built) : scene_(scene), built_(built) {}

  /// An accepted attempt, before anything has accepted it; all arguments stay alive until end_step.
  void begin_step(StepMethods& methods, const StepInput& in, const StepOutcome& outcome);
  /// The velocities of the attempt without any finish, m/s.
  void set_velocities(std::span<const Vec3> v) { v_.assign(v.begin(), v.end()); }
  /// The velocities after the limiter has finished, m/s.
  void finish_strain(std::span<const Vec3> v);
  /// The velocities after the response has finished, m/s.
  void finish_response(std::span<const Vec3> v);
  /// The step ends.
  void end_step();
  /// The masses have changed from `before`, kg, at the positions x, m, and velocities v, m/s.
  void change_mass(std::span<const double> before, std::span<const double> mass,
                   std::span<const Vec3> x, std::span<const Vec3> v);
  /// The cloth sleeps for h s and loses the velocities v: what it exerted goes on.
  void sleep(double h, std::span<const double> mass, std::span<const Vec3> x,
             std::span<const Vec3> v);

  const StepWrenches& last() const { return last_; }
  /// Of all steps since begin_mean.
  StepWrenches mean() const;
  void begin_mean();

 private:
  Vec3 touching_point(const ContactImpulse& c, std::int32_t n) const;
  void add_contacts(std::span<const ContactImpulse> impulses);
  void share_masses();
  void find_forces();
  void add_free();
  void add_held();
  void add_pinched(const Pinch& pinch, const Vec3& impulse);
  void close();
  void scale(double per_s);
  void add_to_mean();
  std::size_t body_of(std::int32_t body_vertex) const;

  const Scene& scene_;
  const BuiltScene& built_;
  // Of the step that is under way.
  StepMethods* methods_ = nullptr;
  const StepInput* in_ = nullptr;
  const StepOutcome* outcome_ = nullptr;
  std::vector<std::int32_t> solid_of_;  // of each particle; empty: there are none
  std::vector<Vec3> contact_;           // N·s, of contacts on each particle
  Wrench on_free_;                      // N·s, of contacts on free particles that no solve had
  Wrench gaps_;                         // N·s, of contacts on both of their sides
  ForceImpulses forces_;
  struct Touch {
    std::size_t piece, body;
    Vec3 x;          // m
    double impulse;  // N·s
  };
  std::vector<Touch> touches_;
  std::vector<Vec3> v_;  // m/s

  StepWrenches last_;  // impulses while the step is under way
  StepWrenches sum_;   // impulses
  std::map<std::int32_t, Vec3> held_sum_;
};

/// Σ mass (after - before)/over of the free particles and its torque at their starts; `over`: s for
/// positions in m, 1 for velocities in m/s.
Wrench given(const StepInput& in, std::span<const Vec3> before, std::span<const Vec3> after,
             double over);

}  // namespace selvedge::detail
