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
  terms_.clear();
  term_entry_.clear();
  if (step.implicit) {
    explicit_.reset();
    return;
  }
  if (!explicit_) explicit_ = make_impulse();
  explicit_->begin(step);
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
    // A contact carries at first if it touches or comes near at the speed it has; the guess of its
    // load is what it takes to stop the predicted approach. A wrong guess costs a solve.
    const double coasting = c.gap + c.normal.dot(motion_of(e, v_start_));
    if (coasting < e.target + kTouch * c.rest_gap)
      e.load = m_eff / (h * h) *
               std::max(0.0, e.target - c.gap - c.normal.dot(motion_of(e, v_predicted_)));
    e.m_eff = m_eff;
    const Vec3 slip = tangential(motion_of(e, v_start_), c.normal) / h;
    e.slip = slip.norm() <= config_.stick_speed ? Slip::stick : Slip::slide;
    set_friction(e, slip);
    entries_.push_back(e);
  }
}

ResponseTraits ContactForce::traits() const {
  return {"Coulomb friction; the contacts carry and stick as the solved step says",
          "Wriggers, Computational contact mechanics, 2006", true, false, false};
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
    term.matrix = h * h * e.stiffness * nn + h * e.viscosity * (Mat3::Identity() - nn);
    term.rhs = h * push * c.normal - e.viscosity * tangential(e.body_motion, c.normal) + h * e.push;
    terms_.push_back(term);
  }
  return terms_;
}

// By how much the contact's force will differ from what the last solve used, N.
double ContactForce::update(Entry& e, std::span<const Vec3> v) const {
  const ContactPoint& c = e.point;
  const Vec3 u = motion_of(e, v);
  const Vec3 slip = tangential(u, c.normal) / motion_.h;
  const double speed = slip.norm();
  const bool carried = e.load > 0.0;
  const double push = e.stiffness * (e.target - c.gap - c.normal.dot(u));
  e.load = std::max(0.0, push);
  // A contact that was left out shows where the cloth goes freely: its true load stops that motion,
  // the penalty of it is far more.
  if (!carried) e.load /= 1.0 + config_.normal_ratio;
  double normal_change = carried ? e.load - push : e.load;
  // One that should have carried and let the cloth in visibly asks for a solve whatever its load.
  if (!carried && push > kIntrusion * c.rest_gap * e.stiffness)
    normal_change = std::numeric_limits<double>::infinity();
  if (c.friction <= 0.0 || (!carried && e.load <= 0.0)) return normal_change;

  const double limit = c.friction * e.load;  // Coulomb: |f_t| <= μ f_n
  const Vec3 used = carried ? Vec3(e.push - e.viscosity * slip) : Vec3::Zero();
  if (e.slip == Slip::stick && carried && used.norm() > kStickSlack * limit) {
    // The slip of a sticking contact has the direction, not the speed, of what follows. One that
    // the push turned back before is at its limit and neither sticks nor slides: it may creep.
    e.slip = Slip::slide;
    e.viscosity = e.at_limit ? std::min(e.stick, limit / config_.stick_speed) : 0.0;
    e.push = e.at_limit ? Vec3::Zero() : Vec3(-limit * slip / speed);
    return normal_change + (used.norm() - limit);
  }
  if (e.push.dot(slip) > 0.0) {
    e.slip = Slip::stick;
    e.at_limit = true;
  }
  if (limit >= e.stick * speed) e.slip = Slip::stick;
  const bool held = e.push.isZero(0.0) && used.norm() <= limit;
  set_friction(e, slip);
  if (held) return normal_change;  // the slip that is left is creep, not a wrong force
  Vec3 next = e.push - e.viscosity * slip;
  if (const double f = next.norm(); f > limit) next *= limit / f;
  return normal_change + (next - used).norm();
}

// Friction of the next solve from the slip of the last one.
void ContactForce::set_friction(Entry& e, const Vec3& slip) const {
  e.push = Vec3::Zero();
  e.viscosity = 0.0;
  if (e.point.friction <= 0.0) return;
  const double limit = e.point.friction * e.load, speed = slip.norm();
  if (e.slip == Slip::stick)
    e.viscosity = e.stick;
  else if (motion_.h * limit < e.m_eff * speed)  // friction cannot stop it within the step
    e.push = -limit * slip / speed;
  else
    e.viscosity = speed > 0.0 ? std::min(e.stick, limit / speed) : e.stick;
}

bool ContactForce::update(std::span<const Vec3> v) {
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
