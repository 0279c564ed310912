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

// Updates after the loads have settled in which friction may ask for another solve. It settles in
// two or three; what then goes on is neighbours that push each other to and fro across the limit,
// by little. In an impact of many layers it takes twice as many, and is seen.
constexpr int kFrictionUpdates = 3, kFrictionUpdatesInImpact = 8;

// A step is an impact if its contacts would on average come nearer than they should by more than
// this share of their rest gaps. Gravity alone makes it a third for 2 mm at 1/120 s.
constexpr double kImpact = 1.0;

// Shear load over μλ above which a sticking contact lets go; covers the error of the linear solve.
constexpr double kStickSlack = 1.01;

// A contact within this share of its rest gap touches: more than a resting one yields, less than
// can be seen when one that should part is held for a solve.
constexpr double kTouch = 0.02;

// How well the least energy along the way from solve to solve is found: what is left of its slope.
constexpr double kLineTolerance = 0.05;
constexpr int kLineIterations = 20;

Vec3 tangential(const Vec3& u, const Vec3& normal) { return u - normal.dot(u) * normal; }

}  // namespace

void ContactForce::begin(const ResponseStep& step) {
  motion_ = step.motion;
  body_displacement_.assign(step.body_displacement.begin(), step.body_displacement.end());
  v_start_.assign(step.v.begin(), step.v.end());
  v_predicted_.assign(step.v_predicted.begin(), step.v_predicted.end());
  entries_.clear();
  friction_updates_ = 0;
  room_ = approach_ = 0.0;
  v_last_.clear();
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
  friction_updates_ = 0;
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
    room_ += m_eff * c.rest_gap;
    approach_ += m_eff * std::max(0.0, e.target - c.gap - c.normal.dot(motion_of(e, v_predicted_)));
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
  const bool carried = e.load > 0.0 || !e.applied.isZero(0.0);
  e.friction_change = 0.0;
  const double push = e.stiffness * (e.target - c.gap - c.normal.dot(u));
  e.load = std::max(0.0, push);
  // A contact that was left out shows where the cloth goes freely: its true load stops that motion,
  // the penalty of it is far more.
  if (!carried) e.load /= 1.0 + config_.normal_ratio;
  double change = std::abs(e.load - c.normal.dot(e.applied) / motion_.h);
  // One that should have carried and let the cloth in visibly asks for a solve whatever its load.
  if (!carried && push > kIntrusion * c.rest_gap * e.stiffness)
    change = std::numeric_limits<double>::infinity();
  if (c.friction <= 0.0 || (!carried && e.load <= 0.0)) return change;
  e.friction_change = update_friction(e, tangential(u, c.normal) / motion_.h, carried);
  return change;
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
  } else if (e.slip == Slip::stick && used.norm() > kStickSlack * limit) {
    next = Slip::slide;
  }
  set_friction(e, next, s);
  return (due - tangential(e.applied, e.point.normal) / motion_.h).norm();
}

// Friction of the next solve from the slip of the last one.
void ContactForce::set_friction(Entry& e, Slip slip, const Vec3& s) const {
  const double limit = e.point.friction * e.load, speed = s.norm();
  e.slip = slip;
  e.limit = limit;
  e.along.setZero();
  e.push = 0.0;
  e.viscosity = 0.0;
  if (e.point.friction <= 0.0) return;
  e.viscosity = slip == Slip::stick ? e.stick : std::min(e.stick, limit / speed);
  if (slip != Slip::slide) return;
  e.along = s / speed;
  e.push = limit;
}

void ContactForce::note_solved(std::span<const Vec3> v) {
  for (Entry& e : entries_) e.solved.setZero();
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const ImplicitTerm& term = terms_[t];
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < 4; ++k)
      if (term.particle[k] >= 0) sum += term.weight[k] * v[term.particle[k]];
    entries_[term_entry_[t]].solved = term.rhs - term.matrix * sum;
  }
}

void ContactForce::find_ways(std::span<const Vec3> v) {
  ways_.clear();
  for (const Entry& e : entries_) {
    const ContactPoint& c = e.point;
    Way way{&e, Vec3::Zero(), 0.0, 0.0, Vec3::Zero(), Vec3::Zero()};
    for (int k = 0; k < 4; ++k)
      if (const auto i = static_cast<std::size_t>(c.vertex[k]); i < motion_.particles)
        way.turn += c.weight[k] * (v[i] - v_last_[i]);
    const Vec3 u = motion_of(e, v_last_);
    way.lack = e.target - c.gap - c.normal.dot(u);
    way.closes = -motion_.h * c.normal.dot(way.turn);
    way.slip = tangential(u, c.normal) / motion_.h;
    way.slips = tangential(way.turn, c.normal);
    ways_.push_back(way);
  }
}

// Derivative of the energy, over the share of the way. The cloth's own part needs no matrix: where
// a solve ended, its gradient is what the contacts of that solve gave, and it is linear between.
double ContactForce::slope(double share) const {
  const double h = motion_.h;
  return parallel_sum(ways_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const Way& w = ways_[i];
      const Entry& e = *w.entry;
      sum += ((1.0 - share) * e.applied + share * e.solved).dot(w.turn);
      sum += e.stiffness * std::max(0.0, w.lack + share * w.closes) * w.closes;
      const Vec3 slip = w.slip + share * w.slips;
      if (const double speed = slip.norm(); speed > 0.0 && e.limit > 0.0)
        sum += h * std::min(e.stick, e.limit / speed) * slip.dot(w.slips);
    }
    return sum;
  });
}

// The share of the way at which the energy is least, by regula falsi on its slope, which only grows
// (Illinois method).
double ContactForce::least_energy() const {
  double low = 0.0, high = 1.0, at_low = slope(low), at_high = slope(high);
  const double enough = kLineTolerance * std::abs(at_low);
  if (at_low >= 0.0 || at_high <= enough) return 1.0;
  for (int k = 0; k < kLineIterations; ++k) {
    const double share = (low * at_high - high * at_low) / (at_high - at_low);
    const double at = slope(share);
    if (std::abs(at) <= enough) return share;
    if (at < 0.0) {
      low = share;
      at_low = at;
      at_high *= 0.5;
    } else {
      high = share;
      at_high = at;
      at_low *= 0.5;
    }
  }
  return low;
}

// Newton steps on contacts that push or do not can run in circles, each contact of a stack letting
// go when its neighbours carry. The energy of the step, convex but for the change of μλ from solve
// to solve, falls along each of them, and least where it is least along the way.
void ContactForce::pull_back(std::span<Vec3> v) {
  note_solved(v);
  double share = 1.0;
  if (!v_last_.empty()) {
    find_ways(v);
    share = least_energy();
  }
  if (share < 1.0)
    for (std::size_t i = 0; i < v.size(); ++i) v[i] = v_last_[i] + share * (v[i] - v_last_[i]);
  for (Entry& e : entries_)
    e.applied = share < 1.0 ? Vec3((1.0 - share) * e.applied + share * e.solved) : e.solved;
  v_last_.assign(v.begin(), v.end());
}

bool ContactForce::update(std::span<Vec3> v) {
  pull_back(v);
  const double change = parallel_sum(entries_.size(), kGrain, [&](std::size_t b, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = b; i < end; ++i) sum += update(entries_[i], v);
    return sum;
  });
  double load = 0.0, limit = 0.0, friction = 0.0;
  for (const Entry& e : entries_) {
    load += e.load;
    limit += e.limit;
    friction += e.friction_change;
  }
  if (change > config_.load_tolerance * load) return true;
  const int most = approach_ > kImpact * room_ ? kFrictionUpdatesInImpact : kFrictionUpdates;
  return friction > config_.load_tolerance * limit && ++friction_updates_ <= most;
}

void ContactForce::correct(std::span<Vec3> x_t1) {
  if (explicit_) explicit_->correct(x_t1);
}

void ContactForce::impulses(std::span<const Vec3> v, std::vector<ContactImpulse>& out) const {
  if (explicit_) return explicit_->impulses(v, out);
  for (const Entry& e : entries_) {
    if (e.applied.isZero(0.0)) continue;
    const ContactPoint& c = e.point;
    const Vec3 motion = motion_of(e, v) / motion_.h;
    const double normal = c.normal.dot(e.applied), parting = c.normal.dot(motion);
    out.push_back({c.vertex, c.weight, e.applied, normal * parting,
                   e.applied.dot(motion) - normal * parting});
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
