// SPDX-License-Identifier: MIT
//
// Penalty forces, survey eq. 42 and 43: a spring at the point of penetration, which the survey
// discusses after Y. Chen, Q. Zhu, A. Kaufman, "Physically based animation", 1998
// [ChenZhuKaufman1998], and a damper beside it, after J. Yang, S. Shang, "Cloth modeling simulation
// based on mass spring model", 2013 [YangShang2013]. A gap that is δ below the rest gap is pushed
// apart by
//   F_n = max(0, K δ + D δ') n,  δ >= 0.
// Corrected: the survey omits the clamp, without which the damper pulls on separating surfaces, and
// its sign convention. Friction is regularised Coulomb friction: |F_t| = μ F_n
// min(|slip|/slip_speed, 1), so that a contact that should stick creeps, at slip_speed at most.
// Implicit step: gap and slip are taken at the end of the step, δ⁺ = rest - gap - n·Σ w h v⁺, as a
// term of the solve with its Jacobian h² K + h D. Repeated solves find which contacts push.
// Explicit step: gap and slip are taken at the start. The step must be below 2/sqrt(K/m), or less
// with damping, and friction at most stops the slip within the step.
//
// An undamped impact of mass m at speed v penetrates v sqrt(m/K) and lasts π sqrt(m/K). With
// damping ζ = D/(2 sqrt(K m)) and the clamp, its rebound speed is exp(-ζ (π - 2 asin ζ)/sqrt(1 -
// ζ²)) of v, slightly more than the exp(-π ζ/sqrt(1 - ζ²)) of a damper that pulls
// [SchwagerPoeschel2007].
//
// Guarantee: momentum is kept. In an implicit step it returns no more energy than it has stored; in
// an explicit step the same holds except for the part O(h sqrt(K/m)) by which the energy of
// symplectic Euler oscillates. It does not guarantee that nothing passes through: deep penetrations
// are left to the fail-safe.
#include <selvedge/response/response.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace selvedge::detail {
namespace {

// No further solve is requested once the forces change by at most this share of the total load.
constexpr double kLoadTolerance = 0.01;

class Penalty final : public Response {
 public:
  explicit Penalty(const MethodOptions& options)
      : stiffness_(options["stiffness"]),
        damping_(options["damping"]),
        slip_speed_(options["slip_speed"]) {}

  void begin(const ResponseStep& step) override;
  void add(std::span<const ContactPoint> contacts) override;
  std::span<const ImplicitTerm> terms() override;
  bool update(std::span<Vec3> v) override;
  void correct(std::span<Vec3> x_t1) override;
  void impulses(std::span<const Vec3> v, std::vector<ContactImpulse>& out) const override;
  double stable_step() const override;
  double stable_step(double inv_mass) const override;
  ResponseTraits traits() const override {
    return {
        .promise =
            "penalty forces: an impact at speed v penetrates by v sqrt(m/K); regularised Coulomb "
            "friction; momentum is kept",
        .source =
            "Yang, Shang, Cloth modeling simulation based on mass spring model, 2013; survey eq. "
            "42 and 43 corrected",
        .keeps_momentum = true,
        .stores_energy = true};
  }

 private:
  struct Entry {
    ContactPoint point;
    Vec3 body_motion = Vec3::Zero();  // Σ weight·displacement of the body vertices, m
    double force = 0.0;               // N, in the next solve or in the explicit step
    double viscosity = 0.0;           // kg/s, of friction that can stop the slip within the step
    Vec3 drag = Vec3::Zero();         // N, friction that cannot
    bool pushes = false;
    bool pulled = false;          // a solve of the step let go of it because its damper pulled
    bool undamped = false;        // and it came back: neither with its damper nor without a force
    Vec3 impulse = Vec3::Zero();  // N·s, in an explicit step
    Vec3 unanswered = Vec3::Zero();  // m, relative motion in an explicit step without contacts
  };

  Vec3 motion_of(const Entry& e, std::span<const Vec3> v) const;
  double end_force(const Entry& e, const Vec3& motion, double& depth) const;
  double start_depth(const Entry& e) const { return e.point.rest_gap - e.point.gap; }
  double damping_of(const Entry& e) const { return e.undamped ? 0.0 : damping_; }
  double load_of(const Entry& e, double force) const;
  void set_friction(Entry& e, const Vec3& slip) const;
  void push_explicitly(Entry& e, std::span<const Vec3> x_t1);
  ContactImpulse reported(const Entry& e, const Vec3& impulse, const Vec3& end) const;

  const double stiffness_, damping_, slip_speed_;  // N/m, N·s/m, m/s
  ResponseStep step_;
  std::vector<Entry> entries_;
  std::vector<ImplicitTerm> terms_;
  std::vector<std::size_t> term_entry_;  // entry of each term
  mutable std::vector<double> rows_;     // scratch of stable_step, 1/s²
};

Vec3 slip_of(const ContactPoint& c, const Vec3& motion) {
  return motion - c.normal.dot(motion) * c.normal;
}

// Σ |weight_i| over free vertices: the contribution of one contact to a Gershgorin row.
double free_weight(const ContactPoint& c, std::span<const double> inv_mass) {
  double sum = 0.0;
  for (int k = 0; k < 4; ++k)
    if (inv_mass[c.vertex[k]] > 0.0) sum += std::abs(c.weight[k]);
  return sum;
}

// Stability limit, s, of a mode x'' = -ω² x - c x' whose damping is evaluated at the start of the
// step: 4/(c + sqrt(c² + 4ω²)).
double bound(double omega_squared, double rate) {
  const double denominator = rate + std::sqrt(rate * rate + 4.0 * omega_squared);
  return denominator > 0.0 ? 4.0 / denominator : std::numeric_limits<double>::infinity();
}

void Penalty::begin(const ResponseStep& step) {
  step_ = step;
  entries_.clear();
  terms_.clear();
  term_entry_.clear();
}

// Relative displacement of the two contact points over the step, m.
Vec3 Penalty::motion_of(const Entry& e, std::span<const Vec3> v) const {
  Vec3 motion = e.body_motion;
  for (int k = 0; k < 4; ++k)
    if (const auto i = static_cast<std::size_t>(e.point.vertex[k]); i < step_.motion.particles)
      motion += e.point.weight[k] * step_.motion.h * v[i];
  return motion;
}

// K δ + D δ' at the end of the step, not clamped, N.
double Penalty::end_force(const Entry& e, const Vec3& motion, double& depth) const {
  const double parting = e.point.normal.dot(motion);
  depth = start_depth(e) - parting;
  return stiffness_ * depth - damping_of(e) * parting / step_.motion.h;
}

void Penalty::add(std::span<const ContactPoint> contacts) {
  for (const ContactPoint& c : contacts) {
    if (compliance(c, step_.motion.inv_mass) <= 0.0) continue;  // nothing here can move
    Entry e;
    e.point = c;
    for (int k = 0; k < 4; ++k)
      if (const auto i = static_cast<std::size_t>(c.vertex[k]); i >= step_.motion.particles)
        e.body_motion += c.weight[k] * step_.body_displacement[i - step_.motion.particles];
    // Initial guess: the contact pushes with the force of the current gap if the cloth, moving
    // freely, ends inside it.
    double depth = 0.0;
    const double force = end_force(e, motion_of(e, step_.v_predicted), depth);
    e.pushes = depth > 0.0 && force > 0.0;
    e.force = stiffness_ * std::clamp(depth, 0.0, std::max(0.0, start_depth(e)));
    const Vec3 slip = slip_of(c, motion_of(e, step_.v)) / step_.motion.h;
    set_friction(e, slip);
    entries_.push_back(e);
  }
}

std::span<const ImplicitTerm> Penalty::terms() {
  terms_.clear();
  term_entry_.clear();
  if (!step_.implicit) return {};
  const double h = step_.motion.h, k = stiffness_;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const Entry& e = entries_[i];
    if (!e.pushes) continue;
    const ContactPoint& c = e.point;
    const Mat3 nn = c.normal * c.normal.transpose();
    ImplicitTerm term;
    for (int j = 0; j < 4; ++j) {
      const bool particle = static_cast<std::size_t>(c.vertex[j]) < step_.motion.particles;
      term.particle[j] = particle ? c.vertex[j] : -1;
      term.weight[j] = c.weight[j];
    }
    const double body = c.normal.dot(e.body_motion), d = damping_of(e);
    term.matrix = (h * h * k + h * d) * nn + h * e.viscosity * (Mat3::Identity() - nn);
    term.rhs = (h * k * (start_depth(e) - body) - d * body) * c.normal -
               e.viscosity * slip_of(c, e.body_motion) + h * e.drag;
    terms_.push_back(term);
    term_entry_.push_back(i);
  }
  return terms_;
}

// Sets the friction of the next solve from the slip of the last one: a viscosity where it could
// stop the slip within the step, otherwise a prescribed force, which does not depend on a lagged
// speed.
void Penalty::set_friction(Entry& e, const Vec3& slip) const {
  const double speed = slip.norm(), limit = e.point.friction * e.force;
  const double m_eff = 1.0 / compliance(e.point, step_.motion.inv_mass);
  const bool stops = speed <= slip_speed_ || step_.motion.h * limit >= m_eff * speed;
  e.viscosity = stops ? limit / std::max(speed, slip_speed_) : 0.0;
  e.drag = stops ? Vec3(Vec3::Zero()) : Vec3(-limit / speed * slip);
}

// The load of a contact from its force at the end of a solve. One that was left out shows where the
// cloth goes freely: its load stops that motion, whereas its penalty would be far larger.
double Penalty::load_of(const Entry& e, double force) const {
  if (e.pushes) return force;
  const double h = step_.motion.h, rate = compliance(e.point, step_.motion.inv_mass);
  return force / (1.0 + rate * h * (h * stiffness_ + damping_of(e)));
}

bool Penalty::update(std::span<Vec3> v) {
  double change = 0.0, load = 0.0;
  for (Entry& e : entries_) {
    const Vec3 motion = motion_of(e, v);
    double depth = 0.0;
    const double force = end_force(e, motion, depth);
    const bool pushes = depth > 0.0 && force > 0.0;
    if (pushes != e.pushes) change += std::abs(force);
    if (pushes && !e.pushes && e.pulled) e.undamped = true;
    e.pulled = e.pulled || (e.pushes && !pushes && depth > 0.0);
    e.force = pushes ? load_of(e, force) : 0.0;
    e.pushes = pushes;
    const Vec3 slip = slip_of(e.point, motion) / step_.motion.h;
    const Vec3 used = e.drag - e.viscosity * slip;
    set_friction(e, slip);
    change += (e.drag - e.viscosity * slip - used).norm();
    load += e.force;
  }
  return change > kLoadTolerance * load;
}

// Uses the forces at the start of the step. Only the slip is taken from the end of the step without
// contacts.
void Penalty::push_explicitly(Entry& e, std::span<const Vec3> x_t1) {
  const ContactPoint& c = e.point;
  const double h = step_.motion.h, depth = start_depth(e);
  e.impulse.setZero();
  e.force = 0.0;
  if (depth <= 0.0) return;
  Vec3 start = e.body_motion;
  for (int k = 0; k < 4; ++k)
    if (const auto i = static_cast<std::size_t>(c.vertex[k]); i < step_.motion.particles)
      start +=
          c.weight[k] * (step_.motion.inv_mass[i] > 0.0 ? Vec3(h * step_.v[i])
                                                        : Vec3(x_t1[i] - step_.motion.x_t0[i]));
  const double approach = -c.normal.dot(start) / h;
  e.force = std::max(0.0, stiffness_ * depth + damping_ * approach);
  e.impulse = h * e.force * c.normal;
  e.unanswered = relative(c, x_t1) - relative(c, step_.motion.x_t0);
  const Vec3 slip = slip_of(c, e.unanswered) / h;
  if (c.friction <= 0.0 || e.force <= 0.0) return;
  const double speed = slip.norm();
  const double wanted = c.friction * e.force / std::max(speed, slip_speed_);
  const double stopping = 1.0 / (compliance(c, step_.motion.inv_mass) * h);
  e.impulse -= h * std::min(wanted, stopping) * slip;
}

void Penalty::correct(std::span<Vec3> x_t1) {
  if (step_.implicit) return;
  const ContactMotion& motion = step_.motion;
  for (Entry& e : entries_) push_explicitly(e, x_t1);
  for (const Entry& e : entries_) {
    for (int k = 0; k < 4; ++k)
      if (const double w = motion.inv_mass[e.point.vertex[k]]; w > 0.0)
        x_t1[e.point.vertex[k]] += motion.h * e.point.weight[k] * w * e.impulse;
  }
}

// Work of the contact and the energy that it stored meanwhile. The work of a force depends on the
// integrator: it uses the velocity at the end of an implicit step and the mean velocity of an
// explicit step.
ContactImpulse Penalty::reported(const Entry& e, const Vec3& impulse, const Vec3& end) const {
  const Vec3& n = e.point.normal;
  const double parting = n.dot(end), normal = n.dot(impulse);
  const Vec3 u = (step_.implicit ? end : Vec3(0.5 * (e.unanswered + end))) / step_.motion.h;
  const double before = std::max(0.0, start_depth(e));
  const double after = std::max(0.0, start_depth(e) - parting);
  const double stored = 0.5 * stiffness_ * (after * after - before * before);
  return {e.point.vertex, e.point.weight, impulse, normal * n.dot(u) + stored,
          (impulse - normal * n).dot(u)};
}

void Penalty::impulses(std::span<const Vec3> v, std::vector<ContactImpulse>& out) const {
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < 4; ++k)
      if (terms_[t].particle[k] >= 0) sum += terms_[t].weight[k] * v[terms_[t].particle[k]];
    const Entry& e = entries_[term_entry_[t]];
    out.push_back(reported(e, terms_[t].rhs - terms_[t].matrix * sum, motion_of(e, v)));
  }
  if (step_.implicit) return;
  for (const Entry& e : entries_)
    if (e.force > 0.0) out.push_back(reported(e, e.impulse, motion_of(e, v)));
}

double Penalty::stable_step() const {
  const ContactMotion& motion = step_.motion;
  rows_.assign(motion.particles, 0.0);
  for (const Entry& e : entries_) {
    if (start_depth(e) <= 0.0) continue;
    const double all = free_weight(e.point, motion.inv_mass);
    for (int k = 0; k < 4; ++k)
      if (const double w = motion.inv_mass[e.point.vertex[k]]; w > 0.0)
        rows_[e.point.vertex[k]] += w * std::abs(e.point.weight[k]) * all;
  }
  double largest = 0.0;
  for (const double row : rows_) largest = std::max(largest, row);
  return stable_step(largest);
}

double Penalty::stable_step(double inv_mass) const {
  return bound(stiffness_ * inv_mass, damping_ * inv_mass);
}

}  // namespace
}  // namespace selvedge::detail

namespace selvedge {

void register_penalty(ResponseRegistry& registry) {
  registry.add("penalty",
               {{.name = "stiffness",
                 .initial = 1000.0,
                 .unit = "N/m",
                 .least = 0.0,
                 .most = 1e12,
                 .meaning = "force by depth of a contact; higher: less penetration, shorter "
                            "explicit steps"},
                {.name = "damping",
                 .initial = 0.1,
                 .unit = "N·s/m",
                 .least = 0.0,
                 .most = 1e9,
                 .meaning = "force by speed of approach of a contact; higher: less rebound"},
                {.name = "slip_speed",
                 .initial = 1e-4,
                 .unit = "m/s",
                 .least = 0.0,
                 .most = 10.0,
                 .above_least = true,
                 .meaning = "slip below which friction is a viscosity; lower: less creep, shorter "
                            "explicit steps"}},
               [](const MethodOptions& o) { return std::make_unique<detail::Penalty>(o); });
}

}  // namespace selvedge
