// SPDX-License-Identifier: MIT
#include <selvedge/response/response.h>

#include <Eigen/Geometry>
#include <algorithm>

namespace selvedge {
namespace {

// Linear and angular momentum, and how much of each was exchanged, as the scale of relative errors.
struct Momentum {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  double linear_size = 0.0, angular_size = 0.0;

  void add(const Vec3& x, const Vec3& p) {
    const Vec3 turn = x.cross(p);
    linear += p;
    angular += turn;
    linear_size += p.norm();
    angular_size += turn.norm();
  }
};

// From the change of velocities. The scale is the momenta themselves, because positions are rounded
// relative to them.
Momentum measured(const LedgerStep& step, double& kinetic) {
  Momentum change;
  kinetic = 0.0;
  for (std::size_t i = 0; i < step.motion.particles; ++i) {
    if (step.motion.inv_mass[i] <= 0.0) continue;
    const Vec3 &x = step.motion.x_t0[i], &a = step.v_before[i], &b = step.v_after[i];
    change.linear_size += step.mass[i] * a.norm();
    change.angular_size += step.mass[i] * x.cross(a).norm();
    if (a == b) continue;
    change.add(x, step.mass[i] * (b - a));
    kinetic += 0.5 * step.mass[i] * (b.squaredNorm() - a.squaredNorm());
  }
  return change;
}

double ratio(double part, double whole) { return whole > 0.0 ? part / whole : 0.0; }

}  // namespace

void Ledger::add(const Ledger& step) {
  steps += step.steps;
  to_particles += step.to_particles;
  to_anchors += step.to_anchors;
  turn_particles += step.turn_particles;
  turn_anchors += step.turn_anchors;
  momentum_error = std::max(momentum_error, step.momentum_error);
  angular_error = std::max(angular_error, step.angular_error);
  energy_normal += step.energy_normal;
  energy_friction += step.energy_friction;
  energy_gained += step.energy_gained;
  energy_kinetic += step.energy_kinetic;
}

std::map<std::string, double> Ledger::figures() const {
  std::map<std::string, double> all = {{"steps", steps},
                                       {"max_momentum_error", momentum_error},
                                       {"max_angular_error", angular_error},
                                       {"energy_normal_J", energy_normal},
                                       {"energy_friction_J", energy_friction},
                                       {"energy_gained_J", energy_gained},
                                       {"energy_kinetic_J", energy_kinetic}};
  const std::pair<const char*, const Vec3*> vectors[] = {{"to_particles", &to_particles},
                                                         {"to_anchors", &to_anchors},
                                                         {"turn_particles", &turn_particles},
                                                         {"turn_anchors", &turn_anchors}};
  for (const auto& [name, value] : vectors)
    for (int axis = 0; axis < 3; ++axis)
      all[std::string(name) + "_" + "xyz"[axis]] = (*value)[axis];
  return all;
}

Ledger measure(const LedgerStep& step) {
  const std::span<const double> inv_mass = step.motion.inv_mass;
  Ledger ledger;
  Momentum free = measured(step, ledger.energy_kinetic), anchors;
  const bool changed = free.linear != Vec3::Zero() || ledger.energy_kinetic != 0.0;
  // Changes that `finish` makes after a solve reach anchors unreported, as does everything from a
  // stage that does not report its impulses.
  const bool reported = !step.impulses.empty() && !step.solved;
  const bool anchored =
      std::any_of(inv_mass.begin(), inv_mass.end(), [](double w) { return w <= 0.0; });
  if (!reported && anchored) {
    anchors.linear = -free.linear;
    anchors.angular = -free.angular;
  }
  double work = 0.0;
  for (const ContactImpulse& c : step.impulses) {
    for (int k = 0; k < 4; ++k) {
      const auto i = static_cast<std::size_t>(c.vertex[k]);
      if (inv_mass[i] <= 0.0)
        anchors.add(step.motion.x_t0[i], c.weight[k] * c.impulse);
      else if (step.solved)
        free.add(step.motion.x_t0[i], c.weight[k] * c.impulse);
    }
    ledger.energy_normal += c.work_normal;
    ledger.energy_friction += c.work_friction;
    work += c.work_normal + c.work_friction;
  }
  if (!reported) {
    ledger.energy_normal += ledger.energy_kinetic;
    work += ledger.energy_kinetic;
  }
  ledger.steps = changed || !step.impulses.empty() ? 1 : 0;
  ledger.to_particles = free.linear;
  ledger.to_anchors = anchors.linear;
  ledger.turn_particles = free.angular;
  ledger.turn_anchors = anchors.angular;
  ledger.momentum_error =
      ratio((free.linear + anchors.linear).norm(), free.linear_size + anchors.linear_size);
  ledger.angular_error =
      ratio((free.angular + anchors.angular).norm(), free.angular_size + anchors.angular_size);
  ledger.energy_gained = std::max(0.0, work);
  return ledger;
}

}  // namespace selvedge
