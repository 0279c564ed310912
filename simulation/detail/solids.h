// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/solver/integrator.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/simulation_state.h>

#include <array>
#include <span>
#include <vector>

namespace selvedge::detail {

/// The longest step, s, at most h, in which no rigid body of the pieces turns so far that its
/// vertices on their straight paths leave their arcs by more than a share of the rest gap.
double longest_turn(const Scene& scene, const BuiltScene& built, const SimulationState& state,
                    double h);

/// The number of the rigid body of each particle; -1: none. Empty: there are none.
std::vector<std::int32_t> solid_of_particles(const BuiltScene& built);

/// What stops rigid bodies that slide or turn on hinges at their limits. A limit is a plane that
/// one point of the body does not cross: on its straight path, this is exact. A stop pushes in the
/// same solve as contacts do, and never pulls. It takes the whole speed towards it: nothing
/// bounces.
class JointStops {
 public:
  JointStops(const Scene& scene, const BuiltScene& built);

  bool empty() const { return joints_.empty(); }
  /// Starts a step of h s: finds the stops in reach, and which of them bodies with these mean
  /// velocities, m/s, would meet.
  void begin(std::span<const Vec3> x, std::span<const Vec3> v_mean, double h);
  /// These terms and those of the stops that push. Valid until the next call.
  std::span<const ImplicitTerm> with(std::span<const ImplicitTerm> terms);
  /// Takes the solved mean velocities. True: a stop began or ceased to push, so that another solve
  /// is needed.
  bool update(std::span<const Vec3> v_mean);

 private:
  struct Joint {
    std::int32_t leader;
    std::array<double, 4> weight;
    Vec3 origin, axis;          // m, of the way or of the axis; a unit vector
    Vec3 start = Vec3::Zero();  // unit vector from the axis to the point at the start; 0: it slides
    double low, high, stiffness;  // m or radians, N/m
  };
  struct Stop {
    const Joint* joint;
    Vec3 normal;
    double gap;  // m, at the start of the step
    bool pushes = false;
    int changes = 0;
  };
  double gap_at_end(const Stop& stop, std::span<const Vec3> v_mean) const;

  std::vector<Joint> joints_;
  std::vector<Stop> stops_;  // in reach
  std::vector<ImplicitTerm> terms_;
  double h_ = 0.0;  // s
};

}  // namespace selvedge::detail
