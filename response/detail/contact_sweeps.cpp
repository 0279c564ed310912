// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/contact_sweeps.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace selvedge::detail {
namespace {

// A gap below the rest gap grows by at most this share of the rest gap per step, so that cloth that
// starts too close does not visibly jump.
constexpr double kRecovery = 0.2;

void push(const ContactPoint& c, std::span<const double> inv_mass, const Vec3& impulse,
          std::span<Vec3> u) {
  for (int k = 0; k < 4; ++k)
    if (const double w = inv_mass[c.vertex[k]]; w > 0.0 && c.weight[k] != 0.0)
      u[c.vertex[k]] += c.weight[k] * w * impulse;
}

// Each of these functions returns by how much it changed the relative u of the contact.
double sweep_normal(std::span<const double> inv_mass, SweptContact& c, std::span<Vec3> u) {
  const double before = c.point.normal.dot(relative(c.point, u));
  const double next = std::max(0.0, c.normal + c.m_eff * (c.target - before));
  const double impulse = next - c.normal;
  if (impulse == 0.0) return 0.0;
  c.normal = next;
  push(c.point, inv_mass, impulse * c.point.normal, u);
  const double change = impulse / c.m_eff;
  c.work_normal += impulse * (before + 0.5 * change);
  return std::abs(change);
}

double sweep_friction(std::span<const double> inv_mass, SweptContact& c, std::span<Vec3> u) {
  if (c.friction <= 0.0 || (c.normal <= 0.0 && c.tangential.isZero(0.0))) return 0.0;
  const Vec3 all = relative(c.point, u);
  const Vec3 slip = all - c.point.normal.dot(all) * c.point.normal;
  Vec3 next = c.tangential - c.m_eff * slip;
  const double limit = c.normal > 0.0 ? c.friction * c.normal : 0.0;  // |f_t| <= μ f_n
  if (const double size = next.norm(); size > limit) next *= limit / size;
  const Vec3 impulse = next - c.tangential;
  c.tangential = next;
  push(c.point, inv_mass, impulse, u);
  c.work_friction += impulse.dot(slip + (0.5 / c.m_eff) * impulse);
  return impulse.norm() / c.m_eff;
}

// Several contacts may stand for one place, so that each bounds the slip and none takes a share of
// what another has left.
double sweep_slip(std::span<const double> inv_mass, SweptContact& c, std::span<Vec3> u) {
  if (std::isinf(c.most_slip)) return 0.0;
  const Vec3 all = relative(c.point, u);
  const Vec3 slip = all - c.point.normal.dot(all) * c.point.normal;
  Vec3 next = slip - c.tangential / c.m_eff;  // without what this contact has done
  if (const double size = next.norm(); size > c.most_slip) next *= c.most_slip / size;
  const Vec3 change = next - slip, impulse = c.m_eff * change;
  c.tangential += impulse;
  push(c.point, inv_mass, impulse, u);
  c.work_friction += impulse.dot(slip + 0.5 * change);
  return change.norm();
}

}  // namespace

void SweptContact::clear() {
  normal = work_normal = work_friction = 0.0;
  tangential.setZero();
}

int sweep_contacts(std::span<const double> inv_mass, std::span<SweptContact> contacts,
                   const SweepConfig& config, std::span<Vec3> u) {
  double first = 0.0;
  for (int sweep = 1; sweep <= config.sweeps; ++sweep) {
    double largest = 0.0;
    for (SweptContact& c : contacts) {
      largest = std::max(largest, sweep_normal(inv_mass, c, u));
      largest = std::max(largest, sweep_friction(inv_mass, c, u));
      largest = std::max(largest, sweep_slip(inv_mass, c, u));
    }
    if (sweep == 1) first = largest;
    if (largest <= config.tolerance * first) return sweep;
  }
  return config.sweeps;
}

void ContactAnswer::begin(const ResponseStep& step) {
  step_ = step;
  contacts_.clear();
  impulses_.clear();
  leftover_.clear();
}

void ContactAnswer::add(std::span<const ContactPoint> contacts) {
  for (const ContactPoint& point : contacts) {
    const double compliance_c = compliance(point, step_.motion.inv_mass);
    if (compliance_c <= 0.0) continue;  // nothing here can move
    SweptContact c;
    c.point = point;
    c.m_eff = 1.0 / compliance_c;
    c.friction = point.friction;
    contacts_.push_back(c);
  }
}

void ContactAnswer::take(std::span<const Vec3> x_t1, double restitution) {
  const ContactMotion& motion = step_.motion;
  const std::size_t n = motion.particles, all = motion.x_t0.size();
  displacement_.resize(all);
  velocity_.resize(all);
  start_.resize(all);
  for (std::size_t i = 0; i < all; ++i) {
    const bool body = i >= n && i - n < step_.body_displacement.size();
    displacement_[i] = i < n  ? Vec3(x_t1[i] - motion.x_t0[i])
                       : body ? step_.body_displacement[i - n]
                              : Vec3(Vec3::Zero());
    velocity_[i] = displacement_[i] / motion.h;
    start_[i] = i < n && motion.inv_mass[i] > 0.0 ? step_.v[i] : velocity_[i];
  }
  for (SweptContact& c : contacts_) {
    c.friction = c.point.friction;
    c.most_slip = kAnySlip;
    c.impact = impact(c, restitution);
  }
}

Impact ContactAnswer::impact(const SweptContact& c, double restitution) const {
  const double h = step_.motion.h;
  const double end = c.point.normal.dot(relative(c.point, velocity_));
  Impact impact;
  impact.meets = c.way() + h * end < 0.0;
  if (!impact.meets) return impact;
  const double start = c.point.normal.dot(relative(c.point, start_));
  impact.time = c.way() / (-h * end);
  // Cloth at rest has no speed at the start of the step. The speed that gravity adds within the
  // step is not an impact and does not bounce [Guendelman2003, section 3].
  const double then = start + impact.time * (end - start);
  impact.speed = std::max(0.0, -then);
  if (restitution > 0.0)
    impact.rebound =
        std::max(0.0, restitution * impact.speed + (1.0 - impact.time) * (end - start));
  return impact;
}

void ContactAnswer::hold_gaps() {
  for (SweptContact& c : contacts_) {
    c.clear();
    c.target = (1.0 - c.impact.time) * h() * c.impact.rebound - c.way();
  }
  sweep_contacts(inv_mass(), contacts_, {}, displacement_);
}

void ContactAnswer::recover_gaps() {
  for (SweptContact& c : contacts_) {
    const ContactPoint& p = c.point;
    const double wanted = std::min(p.rest_gap, std::max(p.gap, 0.0) + kRecovery * p.rest_gap);
    c.clear();
    c.target = std::max(c.target, wanted - p.gap);  // a rebound moves farther
    c.friction = 0.0;
  }
  sweep_contacts(inv_mass(), contacts_, {}, displacement_);
}

// The nearest velocities at which each contact that carries load keeps no more than its share.
void ContactAnswer::retain_slip(double retention) {
  for (SweptContact& c : contacts_) {
    if (c.normal <= 0.0) continue;
    const Vec3 all = relative(c.point, velocity_);
    c.most_slip = retention * (all - c.point.normal.dot(all) * c.point.normal).norm();
  }
  sweep_contacts(inv_mass(), contacts_, {}, velocity_);
}

void ContactAnswer::move_by_velocity() {
  for (std::size_t i = 0; i < displacement_.size(); ++i)
    if (velocity_[i] != displacement_[i] / h()) displacement_[i] = h() * velocity_[i];
}

void ContactAnswer::follow_displacement() {
  for (std::size_t i = 0; i < displacement_.size(); ++i)
    if (inv_mass()[i] > 0.0) velocity_[i] = displacement_[i] / h();
}

void ContactAnswer::give(std::span<Vec3> x_t1) {
  const ContactMotion& motion = step_.motion;
  leftover_.assign(motion.particles, Vec3::Zero());
  for (std::size_t i = 0; i < motion.particles; ++i) {
    if (motion.inv_mass[i] <= 0.0) continue;
    const Vec3 before = x_t1[i] - motion.x_t0[i];
    if (displacement_[i] == before && velocity_[i] == before / motion.h) continue;
    x_t1[i] = motion.x_t0[i] + displacement_[i];
    leftover_[i] = velocity_[i] - displacement_[i] / motion.h;
  }
}

void ContactAnswer::finish(std::span<Vec3> v) const {
  for (std::size_t i = 0; i < leftover_.size(); ++i) v[i] += leftover_[i];
}

void ContactAnswer::keep_impulses(double unit) {
  impulses_.clear();
  for (const SweptContact& c : contacts_) {
    // A contact whose impulse was taken back has still moved energy between others.
    if (c.normal == 0.0 && c.tangential.isZero(0.0) && c.work_normal == 0.0) continue;
    impulses_.push_back({c.point.vertex, c.point.weight,
                         (c.normal * c.point.normal + c.tangential) / unit,
                         c.work_normal / (unit * unit), c.work_friction / (unit * unit)});
  }
}

void ContactAnswer::impulses(std::vector<ContactImpulse>& out) const {
  out.insert(out.end(), impulses_.begin(), impulses_.end());
}

}  // namespace selvedge::detail
