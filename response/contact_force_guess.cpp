// SPDX-License-Identifier: MIT
//
// The loads with which the contacts of a step begin, before a solve has found them.
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/followers.h>
#include <selvedge/response/detail/contact_force.h>
#include <selvedge/response/detail/rigid_corners.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace selvedge::detail {
namespace {

// Sweeps over the contacts of the first guess. One suffices where no particle has two of them.
constexpr int kGuessSweeps = 4;

// A contact yields by at most this share of its rest gap under its guessed load. A sharp vertex of
// a body may carry hundreds of times the weight of the particles that touch it. A taut strip that
// is pulled around a cylinder stores energy in its contacts where it is slack and loses it where it
// is taut: with a share of 0.5, 1.5 % of the pull.
constexpr double kYield = 0.1;

// The same of cloth that is pinched: the loads of the sides balance each other, and no guess finds
// them. The mean normal of the contacts of a particle is at most, and at least, that long where
// they are on both sides, and on one.
constexpr double kYieldPinched = 0.5, kFromSides = 0.8, kFromOne = 0.95;

// Loads of the last step count as known if they are this share of what stops the bodies.
constexpr double kKnownShare = 0.5;

}  // namespace

// A particle keeps its velocity if the contacts balance the other forces on it.
void ContactForce::set_balanced(const ResponseStep& step) {
  v_guess_.clear();
  if (!step.implicit || step.unbalanced.empty()) return;
  v_guess_.resize(step.v.size());
  parallel_for(v_guess_.size(), kContactVertexGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      v_guess_[i] = step.v[i] + motion_.inv_mass[i] * step.unbalanced[i];
  });
}

// The first guess of the contact forces where the other forces are known: those with which the
// particles would keep their velocities, or stop at the contact. Gauss-Seidel sweeps over the
// contacts share the forces of a particle among them. Elastic forces count as they are if the cloth
// moves on as before, so that a contact carries all that hangs on it, not its own weight alone.
// Every contact that is near takes part in the first solve, which shows whether it carries load.
void ContactForce::guess_forces(std::span<Entry> entries) {
  for (Entry& e : entries) {
    e.load = e.near ? kLeastLoad : 0.0;
    if (e.near) add_guess(e, motion_.h * e.friction);
  }
  for (int sweep = 0; sweep < kGuessSweeps; ++sweep)
    for (Entry& e : entries)
      if (e.near) guess_force(e);
}

void ContactForce::guess_force(Entry& e) {
  const ContactPoint& c = e.point;
  const double per_length = e.m_eff / (motion_.h * motion_.h);  // N/m
  const Vec3 before = e.load * c.normal + e.friction;
  const Vec3 free = guessed_motion(e) - before / per_length;
  const double violation = e.target - c.gap - c.normal.dot(free);
  e.load = std::max(kLeastLoad, yielding() * per_length * violation);
  if (!e.remembers)
    e.friction = within(-per_length * tangential(free, c.normal), c.friction * e.load);
  add_guess(e, motion_.h * (e.load * c.normal + e.friction - before));
}

Vec3 ContactForce::guessed_motion(const Entry& e) const {
  Vec3 u = e.body_motion;
  for_each_mover(e.point, motion_,
                 [&](std::size_t i, double weight) { u += weight * motion_.h * v_guess_[i]; });
  return u;
}

void ContactForce::add_guess(const Entry& e, const Vec3& impulse) {
  for_each_mover(e.point, motion_, [&](std::size_t i, double weight) {
    v_guess_[i] += weight * motion_.inv_mass[i] * impulse;
  });
}

void ContactForce::Yield::add(const Entry& e, double weight) {
  load += weight * e.load;
  known += weight * std::max(e.load, e.load_before);
  stiffness += weight * e.stiffness;
  weights += weight;
  direction += weight * e.point.normal;
}

double ContactForce::Yield::one_sided() const {
  const double along = direction.norm() / weights;
  return std::clamp((along - kFromSides) / (kFromOne - kFromSides), 0.0, 1.0);
}

// Lets the contacts bear the loads that were guessed: their targets lie farther by what they yield.
// Otherwise a contact whose load is too large for the recovery of a step would sink from step to
// step until it collides. Contacts of the same particles yield alike.
void ContactForce::bear_loads(std::span<Entry> entries, bool rigid) {
  yields_.assign(v_guess_.size(), {});
  const auto for_each_particle = [&](const Entry& e, const auto& body) {
    for (int k = 0; k < 4; ++k)
      if (const auto i = static_cast<std::size_t>(e.point.vertex[k]); i < motion_.particles)
        body(yields_[i], std::abs(e.point.weight[k]));
  };
  for (const Entry& e : entries)
    if (e.near) for_each_particle(e, [&](Yield& y, double weight) { y.add(e, weight); });
  for (Entry& e : entries) {
    if (!e.near) continue;
    double guessed = 0.0, known = 0.0, weights = 0.0;  // m, twice
    e.one_sided = rigid ? 0.0 : 1.0;
    for_each_particle(e, [&](const Yield& y, double weight) {
      if (y.stiffness <= 0.0) return;
      guessed += weight * y.load / y.stiffness;
      known += weight * y.known / y.stiffness;
      weights += weight;
      e.one_sided = std::min(e.one_sided, y.one_sided());
    });
    if (weights <= 0.0) continue;
    const double most = std::lerp(kYieldPinched, kYield, e.one_sided) * e.point.rest_gap;
    const double yield = std::lerp(guessed, known, e.one_sided) / weights;
    e.stiffness *= std::clamp(yield / most, 1.0, kStiffest);
    e.target = std::min(e.point.rest_gap, e.target + std::min(yield, most));
  }
}

// Cloth between bodies that press it: no guess finds the loads, which balance each other. Those of
// the last step count. Where they are far from stopping a free body, as in a step in which a force
// closes a gap, its contacts begin with equal shares of what stops it: the light cloth alone would
// yield by more than the rest gap.
void ContactForce::press_loads(std::span<Entry> entries) {
  struct Pressed {
    int contacts = 0;
    double recalled = 0.0, needed = 0.0;  // N, sums; `needed` of what each contact alone needs
    bool known() const { return contacts == 0 || recalled >= kKnownShare * needed / contacts; }
  };
  std::map<std::size_t, Pressed> bodies;  // by first leader
  for (const Entry& e : entries) {
    Pressed& body = bodies[pressing_body(e.point)];
    body.recalled += e.load_before;
    if (const double needed = pressing_load(e); needed > 0.0) {
      ++body.contacts;
      body.needed += needed;
    }
  }
  for (Entry& e : entries) {
    const Pressed& body = bodies[pressing_body(e.point)];
    if (const double needed = pressing_load(e); needed > 0.0 && !body.known()) {
      e.near = true;
      e.load = std::max(e.load, needed / body.contacts);
    }
    if (e.near) e.load = std::max(e.load, e.load_before);
  }
}

// The first leader of the first rigid body in a contact; without one, the number of particles.
std::size_t ContactForce::pressing_body(const ContactPoint& c) const {
  for (const std::int32_t vertex : c.vertex)
    if (const auto i = static_cast<std::size_t>(vertex);
        i < motion_.particles && motion_.followers->is_rigid(vertex))
      return first_leader(i);
  return motion_.particles;
}

std::size_t ContactForce::first_leader(std::size_t i) const {
  return static_cast<std::size_t>(
      motion_.followers->leaders()[motion_.followers->shares(i)[0].leader]);
}

// N, the load with which this contact alone would stop its rigid body.
double ContactForce::pressing_load(const Entry& e) const {
  const ContactPoint& c = e.point;
  const std::size_t body = pressing_body(c);
  Vec3 free = e.body_motion;
  double mass = 0.0;
  for (int k = 0; k < 4; ++k) {
    const auto i = static_cast<std::size_t>(c.vertex[k]);
    if (i >= motion_.particles) continue;
    if (!motion_.followers->is_rigid(c.vertex[k]) || first_leader(i) != body) {
      free += c.weight[k] * motion_.h * v_start_[i];
      continue;
    }
    mass = 0.0;
    for (const Followers::Share& s : motion_.followers->shares(i)) {
      const auto leader = static_cast<std::size_t>(motion_.followers->leaders()[s.leader]);
      free += c.weight[k] * s.weight * motion_.h * v_unpushed_[leader];
      mass += mass_[leader];
    }
  }
  const double violation = e.target - c.gap - c.normal.dot(free);
  return mass * violation / (motion_.h * motion_.h);
}

}  // namespace selvedge::detail
