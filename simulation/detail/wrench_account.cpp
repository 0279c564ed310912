// SPDX-License-Identifier: MIT
//
// The momentum of a particle changes by the forces, by contacts and by the stages that move it. For
// a free one these are known: the solve has the forces, the response reports its impulses, and the
// other stages are measured one by one. For a held one, what holds it gives the rest: that is how
// its reaction is defined.
#include <selvedge/scene/build.h>
#include <selvedge/simulation/detail/handles.h>
#include <selvedge/simulation/detail/simulation_parts.h>
#include <selvedge/simulation/detail/solids.h>
#include <selvedge/simulation/detail/wrench_account.h>

#include <algorithm>
#include <utility>

namespace selvedge {

Wrench& Wrench::operator+=(const Wrench& other) {
  force += other.force;
  torque += other.torque;
  return *this;
}

void EffectiveMass::add(const Vec3& x, double m) {
  const Vec3 d = x - centre;
  const double all = mass + m;
  inertia += mass * m / all * (d.squaredNorm() * Mat3::Identity() - d * d.transpose());
  centre += m / all * d;
  mass = all;
}

namespace detail {
namespace {

Wrench minus(const Wrench& a, const Wrench& b) { return {a.force - b.force, a.torque - b.torque}; }

bool is_zero(const Wrench& w) { return w.force.isZero(0.0) && w.torque.isZero(0.0); }

Wrench momentum(std::span<const double> mass, std::span<const Vec3> x, std::span<const Vec3> v) {
  Wrench sum;
  for (std::size_t i = 0; i < v.size(); ++i) sum.add(x[i], mass[i] * v[i]);
  return sum;
}

double ratio(double part, double whole) { return whole > 0.0 ? part / whole : 0.0; }

// A particle of the cloth of a contact; -1: two bodies.
std::int32_t cloth_of(const ContactImpulse& c, std::int32_t n) {
  const auto found = std::find_if(c.vertex.begin(), c.vertex.end(), [n](auto i) { return i < n; });
  return found == c.vertex.end() ? -1 : *found;
}

// The handle that holds each particle; -1: none.
std::vector<std::int32_t> handle_of(const Scene& scene, const BuiltScene& built,
                                    const StepInput& in) {
  std::vector<std::int32_t> handle(in.n(), -1);
  visit_held(scene, built, in.t0, in.t1,
             [&](std::int32_t i, const Vec3&, std::int32_t number) { handle[i] = number; });
  for (const HeldByProgram& held : in.program->held) handle[held.particle] = -1;
  return handle;
}

}  // namespace

Wrench given(const StepInput& in, std::span<const Vec3> before, std::span<const Vec3> after,
             double over) {
  Wrench sum;
  for (std::size_t i = 0; i < in.n(); ++i)
    if (in.inv_mass[i] > 0.0 && after[i] != before[i])
      sum.add(in.x_t0[i], in.particles.mass[i] / over * (after[i] - before[i]));
  return sum;
}

std::size_t WrenchAccount::body_of(std::int32_t body_vertex) const {
  const VertexNames& names = methods_->names;
  return names.owner_index(static_cast<std::int32_t>(in_->n()) + body_vertex) - names.pieces();
}

void WrenchAccount::begin_step(StepMethods& methods, const StepInput& in,
                               const StepOutcome& outcome) {
  methods_ = &methods;
  in_ = &in;
  outcome_ = &outcome;
  last_ = {};
  last_.h = in.h;
  last_.bodies.resize(built_.bodies.size());
  last_.handles.resize(scene_.handles.size());
  last_.solids.resize(built_.solids.size());
  last_.body_mass.resize(built_.bodies.size());
  touches_.clear();
  if (solid_of_.empty()) solid_of_ = solid_of_particles(built_);
  last_.others = outcome.parting.ends.given;
  contact_.assign(in.n(), Vec3::Zero());
  on_free_ = gaps_ = {};
  std::vector<ContactImpulse> impulses;
  methods.response->impulses(outcome.v.mean, impulses);
  add_contacts(impulses);
  if (outcome.v.answered) on_free_ = {};
  find_forces();
  add_free();
}

// The rest gap belongs to the body: its outside, which the cloth touches, bears the force.
Vec3 WrenchAccount::touching_point(const ContactImpulse& c, std::int32_t n) const {
  Vec3 point = Vec3::Zero();
  double weights = 0.0;
  for (int k = 0; k < 4; ++k) {
    if (c.vertex[k] >= n) continue;
    point += c.weight[k] * in_->x_t0[c.vertex[k]];
    weights += c.weight[k];
  }
  return weights != 0.0 ? Vec3(point / weights) : point;
}

void WrenchAccount::add_contacts(std::span<const ContactImpulse> impulses) {
  const auto n = static_cast<std::int32_t>(in_->n());
  for (const ContactImpulse& c : impulses) {
    const Vec3 touch = touching_point(c, n);
    for (int k = 0; k < 4; ++k) {
      const std::int32_t i = c.vertex[k];
      const Vec3 impulse = c.weight[k] * c.impulse;
      gaps_.add(i >= n ? touch : in_->x_t0[i], impulse);
      if (i >= n) {
        last_.bodies[body_of(i - n)].add(touch, impulse);
        if (const std::int32_t other = cloth_of(c, n); other >= 0)
          touches_.push_back(
              {methods_->names.owner_index(other), body_of(i - n), touch, impulse.norm()});
        continue;
      }
      contact_[i] += impulse;
      if (!solid_of_.empty() && solid_of_[i] >= 0)
        last_.solids[solid_of_[i]].add(in_->x_t0[i], impulse);
      if (in_->inv_mass[i] > 0.0) on_free_.add(in_->x_t0[i], impulse);
    }
  }
}

void WrenchAccount::share_masses() {
  const std::vector<std::int32_t>& begin = built_.piece_begin;
  std::vector<double> mass(begin.size() - 1), total(begin.size() - 1);
  for (std::size_t p = 0; p < mass.size(); ++p)
    for (std::int32_t i = begin[p]; i < begin[p + 1]; ++i) mass[p] += in_->particles.mass[i];
  for (const Touch& t : touches_) total[t.piece] += t.impulse;
  for (const Touch& t : touches_)
    if (t.impulse > 0.0)
      last_.body_mass[t.body].add(t.x, mass[t.piece] * t.impulse / total[t.piece]);
}

// Where the method does not keep them: what the free particles took from them, and for held ones
// the forces at the start.
void WrenchAccount::find_forces() {
  if (methods_->integrator->force_impulses(outcome_->v.mean, forces_)) return;
  const StepInput& in = *in_;
  const ForceState start{in.particles.x, in.particles.v, in.particles.mass, in.t0};
  const auto& v = methods_->traits.ends_with_mean ? outcome_->v.mean : outcome_->v.free;
  forces_.all.assign(in.n(), Vec3::Zero());
  forces_.external.assign(in.n(), Vec3::Zero());
  methods_->integrator->forces().evaluate(start, forces_.all);
  for (const auto& force : methods_->integrator->forces().members())
    if (force->is_external()) force->add_force(start, forces_.external);
  for (std::size_t i = 0; i < in.n(); ++i) {
    forces_.external[i] *= in.h;
    forces_.all[i] *= in.h;
    if (in.inv_mass[i] <= 0.0) continue;
    forces_.all[i] = in.particles.mass[i] * (v[i] - in.particles.v[i]);
    if (outcome_->v.answered) forces_.all[i] -= contact_[i];
  }
}

void WrenchAccount::add_free() {
  const StepInput& in = *in_;
  const auto& v = methods_->traits.ends_with_mean ? outcome_->v.mean : outcome_->v.free;
  Wrench loads, internal, left;
  for (std::size_t i = 0; i < in.n(); ++i) {
    loads.add(in.x_t0[i], forces_.external[i]);
    internal.add(in.x_t0[i], forces_.all[i] - forces_.external[i]);
    if (in.inv_mass[i] <= 0.0) continue;
    Vec3 rest = in.particles.mass[i] * (v[i] - in.particles.v[i]) - forces_.all[i];
    if (outcome_->v.answered) rest -= contact_[i];
    left.add(in.x_t0[i], rest);
  }
  last_.others["loads"] = loads;
  last_.others["internal"] = internal;
  Wrench& solver = last_.others[methods_->untangling() ? "untangling" : "solver"];
  solver = minus(left, last_.others["tempering"]);
}

void WrenchAccount::finish_strain(std::span<const Vec3> v) {
  last_.others["strain_limit"] += given(*in_, v_, v, 1.0);
  set_velocities(v);
}

void WrenchAccount::finish_response(std::span<const Vec3> v) {
  std::vector<ContactImpulse> impulses;
  methods_->response->finish_impulses(v_, impulses);
  add_contacts(impulses);
  Wrench& moved = last_.others["response"];
  moved += given(*in_, v_, v, 1.0);
  moved = minus(moved, on_free_);
  set_velocities(v);
}

void WrenchAccount::add_held() {
  const StepInput& in = *in_;
  const std::vector<Pinch>& pinches = outcome_->near.pinches;
  const std::vector<std::int32_t> handle = handle_of(scene_, built_, in);
  auto pinch = pinches.begin();  // by vertex
  for (std::size_t i = 0; i < in.n(); ++i) {
    const auto particle = static_cast<std::int32_t>(i);
    while (pinch != pinches.end() && pinch->vertex < particle) ++pinch;
    if (in.inv_mass[i] > 0.0) continue;
    const Vec3 on_holder =
        forces_.all[i] + contact_[i] - in.particles.mass[i] * (v_[i] - in.particles.v[i]);
    if (pinch != pinches.end() && pinch->vertex == particle) {
      add_pinched(*pinch, on_holder);
      continue;
    }
    last_.held.push_back(particle);
    last_.held_force.push_back(on_holder);
    std::int32_t by = handle[i];
    if (by < 0 && in.followers != nullptr && !in.followers->empty())
      by = handle[in.followers->leaders()[in.followers->shares(i)[0].leader]];
    if (by >= 0) last_.handles[by].add(in.x_t0[i], on_holder);
  }
}

void WrenchAccount::add_pinched(const Pinch& pinch, const Vec3& impulse) {
  for (const std::int32_t triangle : pinch.triangle) {
    const std::int32_t vertex = methods_->detection.body_triangles()[triangle][0];
    last_.bodies[body_of(vertex)].add(in_->x_t0[pinch.vertex], 0.5 * impulse);
  }
}

void WrenchAccount::end_step() {
  add_held();
  share_masses();
  close();
  add_to_mean();
}

// From impulses to forces, with the sum of all.
void WrenchAccount::close() {
  const StepInput& in = *in_;
  const std::span<const Vec3> x_t0 = std::span(in.x_t0).first(in.n());
  const std::span<const Vec3> x_t1 = outcome_->x_t1().first(in.n());
  const std::vector<double>& mass = in.particles.mass;
  double size = 0.0, turn_size = 0.0;
  Vec3 moved = Vec3::Zero();
  for (std::size_t i = 0; i < in.n(); ++i) {
    size += mass[i] * (in.particles.v[i].norm() + v_[i].norm());
    turn_size +=
        mass[i] * (x_t0[i].norm() * in.particles.v[i].norm() + x_t1[i].norm() * v_[i].norm());
    moved += (x_t1[i] - x_t0[i]).cross(mass[i] * v_[i]);
  }
  Vec3& internal = last_.others["internal"].torque;
  last_.others["lever_arms"] = {Vec3::Zero(),
                                moved + gaps_.torque + std::exchange(internal, Vec3::Zero())};
  std::erase_if(last_.others, [](const auto& entry) { return is_zero(entry.second); });
  last_.change = minus(momentum(mass, x_t1, v_), momentum(mass, x_t0, in.particles.v));
  Wrench sum;
  const auto add = [&](const Wrench& w, double sign) {
    sum += w * sign;
    size += w.force.norm();
    turn_size += w.torque.norm();
  };
  for (const auto& [name, w] : last_.others) add(w, 1.0);
  for (const Wrench& w : last_.bodies) add(w, -1.0);
  for (std::size_t k = 0; k < last_.held.size(); ++k) {
    Wrench held;
    held.add(x_t0[last_.held[k]], last_.held_force[k]);
    add(held, -1.0);
  }
  last_.force_error = ratio((last_.change.force - sum.force).norm(), size);
  last_.torque_error = ratio((last_.change.torque - sum.torque).norm(), turn_size);
  scale(1.0 / in.h);
}

void WrenchAccount::scale(double per_s) {
  for (auto* list : {&last_.bodies, &last_.handles, &last_.solids})
    for (Wrench& w : *list) w = w * per_s;
  for (Vec3& f : last_.held_force) f *= per_s;
  for (auto& [name, w] : last_.others) w = w * per_s;
  last_.change = last_.change * per_s;
}

void WrenchAccount::change_mass(std::span<const double> before, std::span<const double> mass,
                                std::span<const Vec3> x, std::span<const Vec3> v) {
  const Wrench gained = minus(momentum(mass, x, v), momentum(before, x, v)) * (1.0 / last_.h);
  last_.others["water"] += gained;
  last_.change += gained;
  sum_.others["water"] += gained * last_.h;
  sum_.change += gained * last_.h;
}

void WrenchAccount::sleep(double h, std::span<const double> mass, std::span<const Vec3> x,
                          std::span<const Vec3> v) {
  last_.h = h;
  last_.change = momentum(mass, x, v) * (-1.0 / h);
  const auto loads = last_.others.find("loads");
  Wrench goes_on = loads == last_.others.end() ? Wrench{} : loads->second;
  last_.others = {{"loads", goes_on}};
  for (const Wrench& w : last_.bodies) goes_on = minus(goes_on, w);
  for (std::size_t k = 0; k < last_.held.size(); ++k)
    goes_on.add(x[last_.held[k]], -last_.held_force[k]);
  last_.others["sleep"] = minus(last_.change, goes_on);
  last_.force_error = last_.torque_error = 0.0;
  add_to_mean();
}

void WrenchAccount::begin_mean() {
  sum_ = {};
  held_sum_.clear();
}

void WrenchAccount::add_to_mean() {
  const double h = last_.h;
  sum_.h += h;
  sum_.bodies.resize(last_.bodies.size());
  sum_.body_mass = last_.body_mass;
  sum_.handles.resize(last_.handles.size());
  sum_.solids.resize(last_.solids.size());
  for (std::size_t b = 0; b < last_.bodies.size(); ++b) sum_.bodies[b] += last_.bodies[b] * h;
  for (std::size_t k = 0; k < last_.handles.size(); ++k) sum_.handles[k] += last_.handles[k] * h;
  for (std::size_t s = 0; s < last_.solids.size(); ++s) sum_.solids[s] += last_.solids[s] * h;
  for (std::size_t k = 0; k < last_.held.size(); ++k) {
    const auto at = held_sum_.try_emplace(last_.held[k], Vec3::Zero()).first;
    at->second += h * last_.held_force[k];
  }
  for (const auto& [name, w] : last_.others) sum_.others[name] += w * h;
  sum_.change += last_.change * h;
  sum_.force_error = std::max(sum_.force_error, last_.force_error);
  sum_.torque_error = std::max(sum_.torque_error, last_.torque_error);
}

StepWrenches WrenchAccount::mean() const {
  StepWrenches mean = sum_;
  const double per_s = ratio(1.0, sum_.h);
  for (auto* list : {&mean.bodies, &mean.handles, &mean.solids})
    for (Wrench& w : *list) w = w * per_s;
  for (auto& [name, w] : mean.others) w = w * per_s;
  mean.change = mean.change * per_s;
  for (const auto& [particle, impulse] : held_sum_) {
    mean.held.push_back(particle);
    mean.held_force.push_back(per_s * impulse);
  }
  return mean;
}

}  // namespace detail
}  // namespace selvedge

namespace selvedge {

void Simulation::Parts::measure_wrenches(bool on) {
  methods.notes_stages = on;
  if (!on)
    wrenches.reset();
  else if (!wrenches)
    wrenches.emplace(scene, built);
}

}  // namespace selvedge
