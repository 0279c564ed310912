// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/simulation/simulation.h>

#include <memory>

namespace selvedge {

/// What distinguishes the simulations of one scene, so that one of them can serve several in turn:
/// state, inputs and result so far. Not for a mesh that changes, and not for cloth that is
/// untangled.
class CarriedSimulation {
 public:
  CarriedSimulation();
  ~CarriedSimulation();
  CarriedSimulation(const CarriedSimulation& other);
  CarriedSimulation(CarriedSimulation&& other) noexcept;
  CarriedSimulation& operator=(CarriedSimulation other) noexcept;

  /// Takes it out of a simulation, which is empty until `put_into`.
  static CarriedSimulation out_of(Simulation& simulation);
  void put_into(Simulation& simulation) &&;
  const SimulationState& state() const;

 private:
  std::unique_ptr<Simulation::Carried> content_;
};

}  // namespace selvedge
