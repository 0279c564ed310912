// SPDX-License-Identifier: MIT
#include <selvedge/core/parallel.h>
#include <selvedge/response/contact_force.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace selvedge {
namespace {

constexpr std::size_t kGrain = 1024;

// How far cloth may come inside a rest gap because its contact was left out of the solve.
constexpr double kIntrusion = 0.05;

// Updates of a step in which friction may ask for another solve. It settles in two or three; what
// then goes on is neighbours that push each other to and fro across the limit, by little.
constexpr int kFrictionUpdates = 3;

// A contact that was pushed and turned back creeps: with the viscosity that gives μλ at its slip,
// and at this one, a share of the rest gap in a step, where it is slower.
constexpr double kCreepSlip = 4e-4;

// Shear load over μλ above which a sticking contact lets go; covers the error of the linear solve.
constexpr double kStickSlack = 1.01;

// A contact within this share of its rest gap touches: more than a resting one yields, less than
// can be seen when one that should part is held for a solve.
constexpr double kTouch = 0.02;

Vec3 tangential(const Vec3& u, const Vec3& normal) { return u - normal.dot(u) * normal; }

}  // namespace

void ContactForce::begin(const ResponseStep& step) {
  motion_ = step.motion;
  body_displacement_.assign(step.body_displacement.begin(), step.body_displacement.end());
  v_start_.assign(step.v.begin(), step.v.end());
  v_predicted_.assign(step.v_predicted.begin(), step.v_predicted.end());
  entries_.clear();
  updates_ = 0;
  terms_.clear();
  term_entry_.clear();
  if (step.implicit) {
    explicit_.reset();
    return;
  }
  if (!explicit_) explicit_ = make_impulse();
  explicit_->begin(step);
}

// m/s
double ContactForce::stick_speed(const ContactPoint& c) const {
  return config_.stick_slip * c.rest_gap / motion_.h;
}

bool ContactForce::coupled(const ContactPoint& c) const {
  int free = 0;
  for (int k = 0; k < 4; ++k)
    if (motion_.inv_mass[c.vertex[k]] > 0.0 && c.weight[k] != 0.0) ++free;
  return free > 1;
}

// Relative displacement of the two contact points over the step, m.
Vec3 ContactForce::motion_of(const Entry& e, std::span<const Vec3> v) const {
  Vec3 u = e.body_motion;
  for (int k = 0; k < 4; ++k)
    if (const auto i = static_cast<std::size_t>(e.point.vertex[k]); i < motion_.particles)
      u += e.point.weight[k] * motion_.h * v[i];
  return u;
}

void ContactForce::add(std::span<const ContactPoint> contacts) {
  if (explicit_) return explicit_->add(contacts);
  const double h = motion_.h;
  for (const ContactPoint& c : contacts) {
    const double compliance_c = compliance(c, motion_.inv_mass);
    if (compliance_c <= 0.0) continue;  // nothing here can move
    const double m_eff = 1.0 / compliance_c;
    Entry e;
    e.point = c;
    e.body_motion = Vec3::Zero();
    for (int k = 0; k < 4; ++k)
      if (const auto i = static_cast<std::size_t>(c.vertex[k]); i >= motion_.particles)
        e.body_motion += c.weight[k] * body_displacement_[i - motion_.particles];
    e.target = std::min(c.rest_gap, std::max(c.gap, 0.0) + config_.recovery * c.rest_gap);
    e.stiffness = config_.normal_ratio * m_eff / (h * h);
    e.stick = (coupled(c) ? config_.coupled_stick_ratio : config_.stick_ratio) * m_eff / h;
    e.m_eff = m_eff;
    e.load = first_load(e);
    const Vec3 slip = tangential(motion_of(e, v_start_), c.normal) / h;
    set_friction(e, slip.norm() <= stick_speed(c) ? Slip::stick : Slip::slide, slip);
    entries_.push_back(e);
  }
}

ResponseTraits ContactForce::traits() const {
  return {"Coulomb friction; the contacts carry and stick as the solved step says",
          "Wriggers, Computational contact mechanics, 2006", true, false, false};
}

// A contact carries at first if it touches or comes near at the speed it has. At rest it carries
// what its penetration says; else the guess of its load is what it takes to stop the predicted
// approach. A wrong guess costs a solve.
double ContactForce::first_load(const Entry& e) const {
  const ContactPoint& c = e.point;
  const Vec3 u = motion_of(e, v_start_);
  const double coasting = c.gap + c.normal.dot(u);
  if (coasting >= e.target + kTouch * c.rest_gap) return 0.0;
  const double h = motion_.h;
  // λ that satisfies λ = k (lack - h² λ/m).
  const double yielding = config_.normal_ratio / (1.0 + config_.normal_ratio);
  const double stopping =
      yielding * e.m_eff / (h * h) *
      std::max(0.0, e.target - c.gap - c.normal.dot(motion_of(e, v_predicted_)));
  const bool rests = u.norm() <= stick_speed(c) * h && c.gap <= c.rest_gap;
  return rests ? std::max(stopping, e.stiffness * (e.target - coasting)) : stopping;
}

std::span<const ImplicitTerm> ContactForce::terms() {
  const double h = motion_.h;
  terms_.clear();
  term_entry_.clear();
  for (const Entry& e : entries_) {
    if (e.load <= 0.0) continue;
    term_entry_.push_back(static_cast<std::size_t>(&e - entries_.data()));
    const ContactPoint& c = e.point;
    const Mat3 nn = c.normal * c.normal.transpose();
    ImplicitTerm term;
    for (int k = 0; k < 4; ++k) {
      const bool particle = static_cast<std::size_t>(c.vertex[k]) < motion_.particles;
      term.particle[k] = particle ? c.vertex[k] : -1;
      term.weight[k] = c.weight[k];
    }
    const double push = e.stiffness * (e.target - c.gap - c.normal.dot(e.body_motion));
    const Mat3 across = Mat3::Identity() - nn - e.along * e.along.transpose();
    term.matrix = h * h * e.stiffness * nn + h * e.viscosity * across;
    term.rhs = h * push * c.normal - e.viscosity * (across * e.body_motion) - h * e.push * e.along;
    terms_.push_back(term);
  }
  return terms_;
}

// By how much the contact's force will differ from what the last solve used, N.
double ContactForce::update(Entry& e, std::span<const Vec3> v) const {
  const ContactPoint& c = e.point;
  const Vec3 u = motion_of(e, v);
  const bool carried = e.load > 0.0;
  const double push = e.stiffness * (e.target - c.gap - c.normal.dot(u));
  e.load = std::max(0.0, push);
  // A contact that was left out shows where the cloth goes freely: its true load stops that motion,
  // the penalty of it is far more.
  if (!carried) e.load /= 1.0 + config_.normal_ratio;
  double change = carried ? e.load - push : e.load;
  // One that should have carried and let the cloth in visibly asks for a solve whatever its load.
  if (!carried && push > kIntrusion * c.rest_gap * e.stiffness)
    change = std::numeric_limits<double>::infinity();
  if (c.friction <= 0.0 || (!carried && e.load <= 0.0)) return change;
  const double friction = update_friction(e, tangential(u, c.normal) / motion_.h, carried);
  return updates_ <= kFrictionUpdates ? change + friction : change;
}

// The friction that a solve with slip `s` has used.
Vec3 ContactForce::friction_used(const Entry& e, const Vec3& s) const {
  return -e.push * e.along - e.viscosity * (s - e.along.dot(s) * e.along);
}

double ContactForce::update_friction(Entry& e, const Vec3& s, bool carried) const {
  const double limit = e.point.friction * e.load, speed = s.norm();
  const Vec3 used = carried ? friction_used(e, s) : Vec3::Zero();
  const Vec3 due = speed > 0.0 ? Vec3(-std::min(e.stick, limit / speed) * s) : Vec3::Zero();
  Slip next = e.slip;
  if (!carried) {
    next = speed <= stick_speed(e.point) ? Slip::stick : Slip::slide;
  } else if (limit >= kStickSlack * e.stick * speed) {
    next = Slip::stick;
  } else if (e.slip == Slip::slide && e.along.dot(s) <= 0.0) {
    next = Slip::stick;
    e.turned_back = true;
  } else if (e.slip == Slip::stick && used.norm() > kStickSlack * limit) {
    next = e.turned_back ? Slip::creep : Slip::slide;
  }
  set_friction(e, next, s);
  return (due - used).norm();
}

// Friction of the next solve from the slip of the last one.
void ContactForce::set_friction(Entry& e, Slip slip, const Vec3& s) const {
  const double limit = e.point.friction * e.load, speed = s.norm();
  e.slip = slip;
  e.along.setZero();
  e.push = 0.0;
  e.viscosity = 0.0;
  if (e.point.friction <= 0.0) return;
  const double least = slip == Slip::creep ? kCreepSlip * e.point.rest_gap / motion_.h : 0.0;
  e.viscosity = slip == Slip::stick ? e.stick : std::min(e.stick, limit / std::max(speed, least));
  if (slip != Slip::slide) return;
  e.along = s / speed;
  e.push = limit;
}

bool ContactForce::update(std::span<const Vec3> v) {
  ++updates_;
  const double change = parallel_sum(entries_.size(), kGrain, [&](std::size_t b, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = b; i < end; ++i) sum += update(entries_[i], v);
    return sum;
  });
  double load = 0.0;
  for (const Entry& e : entries_) load += e.load;
  return change > config_.load_tolerance * load;
}

void ContactForce::correct(std::span<Vec3> x_t1) {
  if (explicit_) explicit_->correct(x_t1);
}

void ContactForce::impulses(std::span<const Vec3> v, std::vector<ContactImpulse>& out) const {
  if (explicit_) return explicit_->impulses(v, out);
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const ImplicitTerm& term = terms_[t];
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < 4; ++k)
      if (term.particle[k] >= 0) sum += term.weight[k] * v[term.particle[k]];
    const Vec3 impulse = term.rhs - term.matrix * sum;
    const ContactPoint& c = entries_[term_entry_[t]].point;
    const Vec3 motion = motion_of(entries_[term_entry_[t]], v) / motion_.h;
    const double normal = c.normal.dot(impulse), parting = c.normal.dot(motion);
    out.push_back(
        {c.vertex, c.weight, impulse, normal * parting, impulse.dot(motion) - normal * parting});
  }
}

void ContactForce::finish(std::span<Vec3> v) const {
  if (explicit_) return explicit_->finish(v);
  for (const Entry& e : entries_) {
    const ContactPoint& c = e.point;
    if (e.load <= 0.0 || e.target <= c.gap) continue;
    const double parting = c.normal.dot(motion_of(e, v)) / motion_.h;
    const double speed = std::min(parting, (e.target - c.gap) / motion_.h);
    if (speed <= 0.0) continue;
    for (int k = 0; k < 4; ++k)
      if (const auto i = static_cast<std::size_t>(c.vertex[k]); i < motion_.particles)
        v[i] -= c.weight[k] * motion_.inv_mass[i] * e.m_eff * speed * c.normal;
  }
}

}  // namespace selvedge
