// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/response/detail/contact_force.h>
#include <selvedge/response/detail/rigid_corners.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace selvedge::detail {
namespace {

// Contacts per range: of sums, and of work on each contact alone.
constexpr std::size_t kGrain = 1024, kEach = 256;

// A contact whose guessed friction has this share of its limit starts to slide.
constexpr double kSliding = 0.999;

// How far cloth may intrude into a rest gap, as a share of it, because its contact was left out of
// the solve.
constexpr double kIntrusion = 0.05;

// Number of updates, after the loads have settled, in which friction may ask for another solve.
// Friction settles in two or three. After that, only neighbours that push each other back and forth
// across the friction limit still change, and only slightly. In an impact of many layers friction
// takes twice as many updates, and stopping early would be visible.
constexpr int kFrictionUpdates = 3, kFrictionUpdatesInImpact = 8;

// A step is an impact if the velocities at its start would, on average, make its contacts violate
// their rest gaps by more than this share of them: 0.16 m/s for 2 mm at 1/120 s. What gravity adds
// within the step does not count, because that grows with the square of the step: 1.4 times a rest
// gap of 2 mm at 1/60 s.
constexpr double kImpact = 2.0 / 3.0;

// In place of the option load_tolerance where bodies press cloth: what holds between them holds by
// the last hundredth of its friction.
constexpr double kRigidTolerance = 0.005;

// A contact within this share of its rest gap counts as touching. The value exceeds the yield of a
// resting contact, and is too small to be visible when a contact that should part is held for one
// solve.
constexpr double kTouch = 0.02;

// The line search for the least energy stops when the slope has dropped to this share of its
// initial value.
constexpr double kLineTolerance = 0.05;
constexpr int kLineIterations = 20;

}  // namespace

void ContactForce::begin(const ResponseStep& step) {
  motion_ = step.motion;
  mass_ = step.mass;
  load_tolerance_ = step.settles ? config_.settled_tolerance : config_.load_tolerance;
  const double parts = step.stiffness_h > 0.0 ? step.motion.h / step.stiffness_h : 1.0;
  normal_ratio_ = config_.normal_ratio * parts * parts;
  stick_scale_ = parts * parts * parts;
  body_displacement_.assign(step.body_displacement.begin(), step.body_displacement.end());
  v_start_.assign(step.v.begin(), step.v.end());
  v_predicted_.assign(step.v_predicted.begin(), step.v_predicted.end());
  entries_.clear();
  set_balanced(step);
  friction_updates_ = 0;
  room_ = approach_ = 0.0;
  v_last_.clear();
  terms_.clear();
  term_entry_.clear();
  if (step.implicit) {
    explicit_.reset();
    return;
  }
  if (!explicit_) explicit_ = responses().at("impulse")();
  explicit_->begin(step);
}

// m/s
double ContactForce::stick_speed(const ContactPoint& c) const {
  return config_.stick_slip * c.rest_gap / motion_.h;
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
  const std::size_t first = entries_.size();
  for (const ContactPoint& c : contacts) {
    const double free = true_compliance(c, motion_);
    if (free <= 0.0) continue;  // nothing here can move
    Entry& e = entries_.emplace_back();
    const double held = held_compliance(c);
    e.point = c;
    e.m_eff = 1.0 / (free + held);
    e.free_share = held > 0.0 ? free / (free + held) : 1.0;
    if (c.friction > 0.0 && !memory_.empty()) recall(e);
  }
  const std::span<Entry> added = std::span(entries_).subspan(first);
  parallel_for(added.size(), kEach, [&](std::size_t begin, std::size_t end) {
    for (Entry& e : added.subspan(begin, end - begin)) start(e);
  });
  for (const Entry& e : added) {
    room_ += e.m_eff * e.point.rest_gap;
    approach_ += e.approach;
  }
  // Contacts that are added later are collisions of the velocities that the solves found. In an
  // impact the cloth does not keep its velocities, so that the forces which would keep them
  // mislead.
  const bool guesses = !v_guess_.empty() && v_last_.empty() && !is_impact();
  const bool rigid = motion_.followers != nullptr && motion_.followers->has_rigid();
  const bool pressed = rigid && !v_guess_.empty() && v_last_.empty();
  if (pressed) v_unpushed_ = v_guess_;
  if (guesses) guess_forces(added);
  if (pressed) press_loads(added);
  if (guesses || pressed) bear_loads(added, rigid);
  const double ratio =
      stick_scale_ * (is_impact() ? config_.impact_stick_ratio : config_.stick_ratio);
  parallel_for(added.size(), kEach, [&](std::size_t begin, std::size_t end) {
    for (Entry& e : added.subspan(begin, end - begin)) {
      e.stick = ratio * e.m_eff / h;
      const double load =
          rigid ? std::max(e.load, e.load_before) : e.one_sided * std::min(e.load, e.load_before);
      e.stick = std::max(e.stick, std::min(bearing_stick(e.point, load), kStiffest * e.stick));
      if (!guesses) {
        e.remembers = false;
        e.friction = first_friction(e);
      }
      start_friction(e);
    }
  });
}

// kg/s. Cloth that is taut or pressed is light by its loads: its friction must reach its limit
// before the contact counts as sliding. Else contacts that hold forget their friction because the
// cloth trembles, guess it anew, let the cloth tremble by that, and creep: 60 µm/s around a
// cylinder. Not by the load of an impact that is over: bodies of another engine would be thrown by
// it.
double ContactForce::bearing_stick(const ContactPoint& c, double load) const {
  return c.friction * load / stick_speed(c);
}

// A contact that rested in the last step begins with its friction.
void ContactForce::recall(Entry& e) const {
  const ContactMemory::Past* past = memory_.find(e.point, motion_.particles);
  if (past == nullptr) return;
  e.remembers = past->rested;
  e.load_before = past->load;
  e.friction = tangential(past->friction, e.point.normal);
}

// Load that a contact has, as a share of the load that would keep it exactly at its target: λ
// satisfies λ = k (violation - h² λ/m).
double ContactForce::yielding() const { return normal_ratio_ / (1.0 + normal_ratio_); }

// The gap that a contact without load recovers by the end of the step, m.
double ContactForce::recovered(const ContactPoint& c) const {
  return std::min(c.rest_gap, std::max(c.gap, 0.0) + config_.recovery * c.rest_gap);
}

// Compliance that the held particles of a contact would have if they were free, 1/kg.
double ContactForce::held_compliance(const ContactPoint& c) const {
  double sum = 0.0;
  for (int k = 0; k < 4; ++k)
    if (const auto i = static_cast<std::size_t>(c.vertex[k]);
        i < motion_.particles && motion_.inv_mass[i] <= 0.0)
      sum += c.weight[k] * c.weight[k] / mass_[i];
  return sum;
}

// Beside a held particle, the free particles of a contact recover their own share of a violation.
// They would have to move by violation/weight for all of it: out of all bounds where the touch is
// almost on the held particle.
double ContactForce::shared_target(const Entry& e) const {
  const ContactPoint& c = e.point;
  Vec3 u = e.body_motion;
  for (int k = 0; k < 4; ++k)
    if (const auto i = static_cast<std::size_t>(c.vertex[k]);
        i < motion_.particles && motion_.inv_mass[i] <= 0.0)
      u += c.weight[k] * motion_.h * v_predicted_[i];
  const double prescribed = c.gap + c.normal.dot(u);
  return prescribed + e.free_share * std::max(0.0, e.target - prescribed);
}

// What does not depend on the other contacts.
void ContactForce::start(Entry& e) const {
  const ContactPoint& c = e.point;
  e.body_motion = Vec3::Zero();
  for (int k = 0; k < 4; ++k)
    if (const auto i = static_cast<std::size_t>(c.vertex[k]); i >= motion_.particles)
      e.body_motion += c.weight[k] * body_displacement_[i - motion_.particles];
  e.target = recovered(c);
  if (e.free_share < 1.0) e.target = std::min(e.target, shared_target(e));
  e.stiffness = normal_ratio_ * e.m_eff / (motion_.h * motion_.h);
  e.near = comes_near(e);
  e.load = first_load(e);
  const double end = c.normal.dot(motion_of(e, v_predicted_));
  const double coasting = c.normal.dot(motion_of(e, v_start_));
  e.approach = e.m_eff * std::max(0.0, e.target - c.gap - std::max(end, coasting));
}

bool ContactForce::is_impact() const { return approach_ > kImpact * room_; }

ResponseTraits ContactForce::traits() const {
  return {.promise =
              "Coulomb friction; the solve of the step decides which contacts carry load and stick",
          .source = "Wriggers, Computational contact mechanics, 2006",
          .keeps_momentum = true};
}

bool ContactForce::comes_near(const Entry& e) const {
  const ContactPoint& c = e.point;
  return c.gap + c.normal.dot(motion_of(e, v_start_)) < e.target + kTouch * c.rest_gap;
}

// Initial guess of the load where the other forces are unknown. A contact carries load at first if
// it comes near. At rest its load follows from its penetration; otherwise the guess is the load
// that stops the predicted approach. A wrong guess costs one solve.
double ContactForce::first_load(const Entry& e) const {
  if (!e.near) return 0.0;
  const ContactPoint& c = e.point;
  const Vec3 u = motion_of(e, v_start_);
  const double coasting = c.gap + c.normal.dot(u);
  const double h = motion_.h;
  const double stopping =
      yielding() * e.m_eff / (h * h) *
      std::max(0.0, e.target - c.gap - c.normal.dot(motion_of(e, v_predicted_)));
  const bool rests = u.norm() <= stick_speed(c) * h && c.gap <= c.rest_gap;
  return rests ? std::max(stopping, e.stiffness * (e.target - coasting)) : stopping;
}

std::span<const ImplicitTerm> ContactForce::terms() {
  term_entry_.clear();
  for (std::size_t i = 0; i < entries_.size(); ++i)
    if (entries_[i].load > 0.0) term_entry_.push_back(i);
  terms_.resize(term_entry_.size());
  parallel_for(terms_.size(), kEach, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) terms_[t] = term_of(entries_[term_entry_[t]]);
  });
  return terms_;
}

ImplicitTerm ContactForce::term_of(const Entry& e) const {
  const double h = motion_.h;
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
  term.rhs = h * push * c.normal - e.viscosity * (across * e.body_motion) + h * e.offset;
  return term;
}

// Updates the load and friction of the contact; returns by how much its force will differ from the
// one in the last solve, N.
double ContactForce::update(Entry& e, std::span<const Vec3> v) const {
  const ContactPoint& c = e.point;
  const Vec3 u = motion_of(e, v);
  const bool carried = e.load > 0.0 || !e.applied.isZero(0.0);
  e.friction_change = 0.0;
  const double push = e.stiffness * (e.target - c.gap - c.normal.dot(u));
  e.load = std::max(0.0, push);
  // A contact that was left out of the solve shows where the cloth would go freely. Its true load
  // stops that motion; its penalty would be far larger.
  if (!carried) e.load /= 1.0 + normal_ratio_;
  double change = std::abs(e.load - c.normal.dot(e.applied) / motion_.h);
  // A contact that should have carried load and visibly let the cloth in asks for a solve, whatever
  // its load.
  if (!carried && push > kIntrusion * c.rest_gap * e.stiffness)
    change = std::numeric_limits<double>::infinity();
  if (c.friction <= 0.0 || (!carried && e.load <= 0.0)) return change;
  e.friction_change = update_friction(e, tangential(u, c.normal) / motion_.h, carried);
  return change;
}

// Where the other forces are unknown: the friction that stops the slip which gravity would cause.
Vec3 ContactForce::first_friction(const Entry& e) const {
  const Vec3 slip = tangential(motion_of(e, v_predicted_), e.point.normal);
  return within(-e.m_eff / (motion_.h * motion_.h) * slip, e.point.friction * e.load);
}

// N. Loads by which two bodies press cloth from both sides balance each other. No guess finds them.
double ContactForce::first_limit(const Entry& e) const {
  return e.point.friction * std::max(e.load, e.load_before);
}

// Friction of the first solve. A contact that slides goes on sliding; one that rests has the
// friction that was guessed.
void ContactForce::start_friction(Entry& e) const {
  const ContactPoint& c = e.point;
  e.limit = first_limit(e);
  if (c.friction <= 0.0) return;
  const Vec3 slip = tangential(motion_of(e, v_start_), c.normal) / motion_.h;
  const bool slides = slip.norm() > stick_speed(c);
  if (slides) {
    e.remembers = false;
    e.friction = within(-e.stick * slip, e.limit);
  }
  const bool yields = slides || e.friction.norm() > kSliding * e.limit;
  linearise_friction(e, yields ? slip : Vec3(Vec3::Zero()));
}

// Sets the friction of the next solve: its law at the slip `s` and the derivative there.
void ContactForce::linearise_friction(Entry& e, const Vec3& s) const {
  const Vec3 trial = e.friction - e.stick * s;
  const double size = trial.norm();
  e.along.setZero();
  if (size <= e.limit || size == 0.0) {
    e.viscosity = e.stick;
    e.offset = e.friction;
    return;
  }
  e.along = trial / size;
  const Vec3 across = e.friction - e.along.dot(e.friction) * e.along;
  e.viscosity = e.stick * e.limit / size;
  e.offset = e.limit * e.along + (e.limit / size) * across;
}

double ContactForce::update_friction(Entry& e, const Vec3& s, bool carried) const {
  e.limit = e.point.friction * e.load;
  if (!carried) {
    const bool rests = s.norm() <= stick_speed(e.point);
    e.remembers = false;
    e.friction = rests ? Vec3(Vec3::Zero()) : within(-e.stick * s, e.limit);
    linearise_friction(e, s);
    return e.friction.norm();
  }
  const Vec3 trial = e.friction - e.stick * s;
  const Vec3 due = within(trial, e.limit);
  const Vec3 applied = tangential(e.applied, e.point.normal) / motion_.h;
  double change = (due - applied).norm();
  if (!e.remembers) {
    change = std::max(change, (due - e.friction).norm());
    e.friction = due;
  }
  linearise_friction(e, trial.norm() <= e.limit ? Vec3(Vec3::Zero()) : s);
  return change;
}

template <class Body>
void ContactForce::for_each_entry(const Body& body) {
  parallel_for(entries_.size(), kEach, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(entries_[i]);
  });
}

void ContactForce::note_solved(std::span<const Vec3> v) {
  for_each_entry([](Entry& e) { e.solved.setZero(); });
  parallel_for(terms_.size(), kEach, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const ImplicitTerm& term = terms_[t];
      Vec3 sum = Vec3::Zero();
      for (int k = 0; k < 4; ++k)
        if (term.particle[k] >= 0) sum += term.weight[k] * v[term.particle[k]];
      entries_[term_entry_[t]].solved = term.rhs - term.matrix * sum;
    }
  });
}

void ContactForce::find_line_contacts(std::span<const Vec3> v) {
  line_contacts_.resize(entries_.size());
  parallel_for(entries_.size(), kEach, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) line_contacts_[i] = line_contact(entries_[i], v);
  });
}

ContactForce::LineContact ContactForce::line_contact(const Entry& e,
                                                     std::span<const Vec3> v) const {
  const ContactPoint& c = e.point;
  LineContact contact{&e, Vec3::Zero(), 0.0, 0.0, Vec3::Zero(), Vec3::Zero()};
  for (int k = 0; k < 4; ++k)
    if (const auto i = static_cast<std::size_t>(c.vertex[k]); i < motion_.particles)
      contact.velocity_change += c.weight[k] * (v[i] - v_last_[i]);
  const Vec3 u = motion_of(e, v_last_);
  contact.violation = e.target - c.gap - c.normal.dot(u);
  contact.violation_change = -motion_.h * c.normal.dot(contact.velocity_change);
  contact.slip = tangential(u, c.normal) / motion_.h;
  contact.slip_change = tangential(contact.velocity_change, c.normal);
  return contact;
}

// Derivative of the energy with respect to the share of the path. The cloth's own part needs no
// matrix: at the end of a solve, its gradient equals the contact forces of that solve, and it is
// linear in between.
double ContactForce::slope(double share) const {
  const double h = motion_.h;
  return parallel_sum(line_contacts_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const LineContact& w = line_contacts_[i];
      const Entry& e = *w.entry;
      sum += ((1.0 - share) * e.applied + share * e.solved).dot(w.velocity_change);
      sum += e.stiffness * std::max(0.0, w.violation + share * w.violation_change) *
             w.violation_change;
      const Vec3 slip = w.slip + share * w.slip_change;
      if (e.limit > 0.0) sum -= h * within(e.friction - e.stick * slip, e.limit).dot(w.slip_change);
    }
    return sum;
  });
}

// The share of the path at which the energy is least. Finds the root of the slope, which increases
// monotonically, by regula falsi (Illinois method).
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

// Newton steps on contacts that switch between pushing and not pushing can cycle: each contact of a
// stack lets go when its neighbours carry the load. The energy of the step is convex, apart from
// the change of μλ from solve to solve. It decreases along each Newton step, so the minimum along
// the step makes progress.
void ContactForce::pull_back(std::span<Vec3> v) {
  note_solved(v);
  double share = 1.0;
  if (!v_last_.empty()) {
    find_line_contacts(v);
    share = least_energy();
  }
  for_each_entry([&](Entry& e) {
    e.applied = share < 1.0 ? Vec3((1.0 - share) * e.applied + share * e.solved) : e.solved;
  });
  v_last_.resize(v.size());
  parallel_for(v.size(), kContactVertexGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (share < 1.0) v[i] = v_last_[i] + share * (v[i] - v_last_[i]);
      v_last_[i] = v[i];
    }
  });
}

void ContactForce::Change::add(const Change& other) {
  force += other.force;
  load += other.load;
  friction += other.friction;
  limit += other.limit;
}

bool ContactForce::update(std::span<Vec3> v) {
  pull_back(v);
  changes_.assign((entries_.size() + kEach - 1) / kEach, {});
  parallel_for(entries_.size(), kEach, [&](std::size_t begin, std::size_t end) {
    Change& own = changes_[begin / kEach];
    for (Entry& e : std::span(entries_).subspan(begin, end - begin)) {
      const double force = update(e, v);
      own.add({force, e.load, e.friction_change, e.limit});
    }
  });
  Change all;
  for (const Change& part : changes_) all.add(part);
  const bool rigid = motion_.followers != nullptr && motion_.followers->has_rigid();
  const double tolerance = rigid ? std::min(kRigidTolerance, load_tolerance_) : load_tolerance_;
  if (all.force > tolerance * all.load) return true;
  const int most = is_impact() || rigid ? kFrictionUpdatesInImpact : kFrictionUpdates;
  return all.friction > tolerance * all.limit && ++friction_updates_ <= most;
}

void ContactForce::correct(std::span<Vec3> x_t1) {
  if (explicit_) explicit_->correct(x_t1);
}

void ContactForce::accept(std::span<const Vec3> x_t1) {
  memory_.clear();
  if (explicit_) return;
  for (const Entry& e : entries_) {
    const ContactPoint& c = e.point;
    if (e.load <= 0.0 || c.friction <= 0.0) continue;
    const Vec3 moved = tangential(relative(c, x_t1) - relative(c, motion_.x_t0), c.normal);
    const bool rested = moved.norm() <= stick_speed(c) * motion_.h;
    const Vec3 friction = within(tangential(e.applied, c.normal) / motion_.h, e.limit);
    memory_.add(
        {c.kind, c.vertex, c.normal, rested ? friction : Vec3(Vec3::Zero()), e.load, rested});
  }
}

void ContactForce::save_memory(std::vector<double>& memory) const { memory_.save(memory); }

void ContactForce::restore_memory(std::span<const double> memory, std::size_t vertices) {
  memory_.restore(memory, vertices);
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
  finish(v, [](const ContactPoint&, const Vec3&) {});
}

void ContactForce::finish_impulses(std::span<const Vec3> v,
                                   std::vector<ContactImpulse>& out) const {
  if (explicit_) return explicit_->finish_impulses(v, out);
  std::vector<Vec3> finished(v.begin(), v.end());
  finish(finished, [&](const ContactPoint& c, const Vec3& impulse) {
    out.push_back({.vertex = c.vertex, .weight = c.weight, .impulse = impulse});
  });
}

// Calls note(contact, impulse) for each contact that changes velocities.
template <class Note>
void ContactForce::finish(std::span<Vec3> v, const Note& note) const {
  for (const Entry& e : entries_) {
    const ContactPoint& c = e.point;
    const double recovery = recovered(c) - c.gap;
    if (e.load <= 0.0 || recovery <= 0.0) continue;
    const double parting = c.normal.dot(motion_of(e, v)) / motion_.h;
    const double speed = std::min(parting, recovery / motion_.h);
    if (speed <= 0.0) continue;
    note(c, -e.m_eff * speed * c.normal);
    for (int k = 0; k < 4; ++k)
      if (const auto i = static_cast<std::size_t>(c.vertex[k]); i < motion_.particles)
        v[i] -= c.weight[k] * motion_.inv_mass[i] * e.m_eff * speed * c.normal;
  }
}

}  // namespace selvedge::detail

namespace selvedge {

void register_contact_force(ResponseRegistry& registry) {
  registry.add("contact_force", {},
               [](const MethodOptions&) { return std::make_unique<detail::ContactForce>(); });
}

}  // namespace selvedge
