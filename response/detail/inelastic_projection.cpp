// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/inelastic_projection.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace selvedge::detail {
namespace {

// A contact cannot be opened with both momenta kept if its impulse hardly moves anything but its
// group as a whole, as when both sides slide along one line. Below this share of its own mobility
// the contact is left to the next layer.
constexpr double kLeastMobility = 1e-6;

// Moments of inertia below this share of the largest correspond to no rotation.
constexpr double kLeastInertia = 1e-10;

Mat3 inverse_inertia(std::span<const std::int32_t> particles, std::span<const double> mass,
                     std::span<const Vec3> x, const Vec3& centre) {
  Mat3 inertia = Mat3::Zero();
  for (const std::int32_t i : particles) {
    const Vec3 r = x[i] - centre;
    inertia += mass[i] * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
  }
  return pseudo_inverse(inertia, kLeastInertia);
}

Mat3 frame_of(const Vec3& n) {
  const Vec3 u = n.unitOrthogonal();
  Mat3 frame;
  frame << n, u, n.cross(u);
  return frame;
}

std::array<std::int32_t, 4> key_of(const ContactPoint& c) {
  std::array<std::int32_t, 4> key = c.vertex;
  // A point with a triangle and two edges may have the same four vertices but are different pairs.
  if (c.kind == ContactKind::edge_edge) key[0] = -1 - key[0];
  return key;
}

}  // namespace

void InelasticProjection::begin(const ResponseStep& step, std::span<const Vec3> x_t1) {
  step_ = step;
  contacts_.begin(step.motion);
  seen_.clear();
  rows_.clear();
  desired_.resize(step.motion.particles);
  moving_.resize(desired_.size());
  for (std::size_t i = 0; i < desired_.size(); ++i) desired_[i] = x_t1[i] - step.motion.x_t0[i];
}

void InelasticProjection::add(std::span<const ContactPoint> hits) {
  contacts_.merge(hits);
  count_.assign(desired_.size(), 0);
  for (const ContactPoint& c : hits) {
    int least = config_.contacts_of_particle;
    for (const std::int32_t i : c.vertex)
      if (step_.motion.inv_mass[i] > 0.0) least = std::min(least, count_[i]++);
    if (least >= config_.contacts_of_particle) continue;
    Row row;
    row.point = c;
    row.direction = frame_of(c.normal);
    row.repeats = seen_[key_of(c)]++;
    rows_.push_back(row);
  }
}

void InelasticProjection::make_groups() {
  const std::span<const Vec3> x0 = step_.motion.x_t0;
  const std::size_t n = desired_.size();
  std::vector<Vec3>& end = moving_;
  for (std::size_t i = 0; i < n; ++i) end[i] = x0[i] + desired_[i];
  groups_.clear();
  for (const ContactGroup& g : contacts_.groups()) {
    Group group;
    if (g.anchors.empty()) {
      group.motion = momentum_motion(g.particles, step_.mass, x0, end);
      group.mobility = inverse_inertia(g.particles, step_.mass, x0, group.motion.centre);
    }
    groups_.push_back(group);
  }
}

void InelasticProjection::prepare(Row& row) const {
  const ContactMotion& motion = step_.motion;
  const ContactPoint& c = row.point;
  row.group = contacts_.group_of(c);
  const Group& group = groups_[row.group];
  const Vec3 start = relative(c, motion.x_t0);
  const double free = compliance(c, motion.inv_mass);
  for (int axis = 0; axis < 3; ++axis) {
    row.torque.col(axis) = start.cross(Vec3(row.direction.col(axis)));
    row.spin.col(axis) = -(group.mobility * row.torque.col(axis));
    // cᵀM⁻¹c without the part that moves the group as a whole.
    row.yielding[axis] = free + row.torque.col(axis).dot(row.spin.col(axis));
    if (row.yielding[axis] < kLeastMobility * free) row.yielding[axis] = 0.0;
  }
  Vec3 piece = Vec3::Zero();
  row.anchors = Vec3::Zero();
  for (int k = 0; k < 4; ++k) {
    const std::int32_t i = c.vertex[k];
    const Vec3 y = group.motion.displacement(motion.x_t0[i]);
    piece += c.weight[k] * y;
    if (motion.inv_mass[i] > 0.0) continue;
    const Vec3 d = static_cast<std::size_t>(i) < motion.particles
                       ? desired_[i]
                       : step_.body_displacement[i - static_cast<std::int32_t>(motion.particles)];
    row.anchors += c.weight[k] * (d - y);
  }
  const double gap = c.normal.dot(start);
  const double spare =
      row.repeats > config_.lenient ? 0.0 : gap - std::min(gap, config_.end_gap * c.rest_gap);
  row.allowed = spare + c.normal.dot(piece);
  if (group.at_rest) row.allowed = std::max(row.allowed, 0.0);
}

void InelasticProjection::push(Row& row, int axis, double impulse) {
  const ContactPoint& c = row.point;
  for (int k = 0; k < 4; ++k) {
    const double w = step_.motion.inv_mass[c.vertex[k]];
    if (w > 0.0) moving_[c.vertex[k]] += c.weight[k] * w * impulse * row.direction.col(axis);
  }
  groups_[row.group].spin += impulse * row.spin.col(axis);
}

// Σ weight·(d - y) along a direction, including the spin of the group.
double InelasticProjection::speed(const Row& row, int axis) const {
  const ContactPoint& c = row.point;
  Vec3 sum = row.anchors;
  for (int k = 0; k < 4; ++k)
    if (step_.motion.inv_mass[c.vertex[k]] > 0.0) sum += c.weight[k] * moving_[c.vertex[k]];
  return row.direction.col(axis).dot(sum) + groups_[row.group].spin.dot(row.torque.col(axis));
}

// One sweep over all contacts. Returns the largest change of a gap, as a share of the target end
// gap.
double InelasticProjection::sweep() {
  double largest = 0.0;
  for (Row& row : rows_) {
    if (row.yielding[0] <= 0.0) continue;
    const double before = row.impulse[0];
    row.impulse[0] = std::max(0.0, before - (speed(row, 0) + row.allowed) / row.yielding[0]);
    const double change = row.impulse[0] - before;
    if (change != 0.0) push(row, 0, change);
    largest = std::max(largest,
                       std::abs(change) * row.yielding[0] / (config_.end_gap * row.point.rest_gap));
    if (row.point.friction <= 0.0) continue;
    Vec3 wanted = row.impulse;
    for (const int axis : {1, 2})
      if (row.yielding[axis] > 0.0) wanted[axis] -= speed(row, axis) / row.yielding[axis];
    const double size = wanted.tail<2>().norm();
    const double limit = row.point.friction * row.impulse[0];
    if (size > limit) wanted.tail<2>() *= limit / size;
    for (const int axis : {1, 2}) {
      push(row, axis, wanted[axis] - row.impulse[axis]);
      row.impulse[axis] = wanted[axis];
    }
  }
  return largest;
}

// Sweeps that stop early, or friction impulses that work against each other, may increase Σ m|d -
// y|². In that case d - y is scaled down as a whole. This keeps the momenta, because d - y has
// none.
void InelasticProjection::take_back_gains() {
  const std::vector<ContactGroup>& contacts = contacts_.groups();
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    double before = 0.0, after = 0.0;
    for (const std::int32_t i : contacts[g].particles) {
      const Vec3& x = step_.motion.x_t0[i];
      moving_[i] += group.spin.cross(x - group.motion.centre);
      before += step_.mass[i] * (desired_[i] - group.motion.displacement(x)).squaredNorm();
      after += step_.mass[i] * moving_[i].squaredNorm();
    }
    if (!group.at_rest || after <= before) continue;
    const double share = std::sqrt(before / after);
    for (const std::int32_t i : contacts[g].particles) moving_[i] *= share;
  }
}

void InelasticProjection::apply(std::span<Vec3> x_t1) {
  const std::span<const Vec3> x0 = step_.motion.x_t0;
  make_groups();
  const std::vector<ContactGroup>& contacts = contacts_.groups();
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    Group& group = groups_[g];
    if (!contacts[g].anchors.empty()) {
      group.motion = anchor_motion(contacts[g].anchors, x0, x_t1);
      group.at_rest = group.motion.residual <= kRigidResidual;
    }
    for (const std::int32_t i : contacts[g].particles)
      moving_[i] = desired_[i] - group.motion.displacement(x0[i]);
  }
  for (Row& row : rows_) {
    prepare(row);
    for (const int axis : {0, 1, 2})
      // restores the previous impulse
      if (row.impulse[axis] != 0.0) push(row, axis, row.impulse[axis]);
  }
  for (int k = 0; k < config_.sweeps; ++k)
    if (sweep() < config_.tolerance) break;
  take_back_gains();
  for (std::size_t g = 0; g < groups_.size(); ++g)
    for (const std::int32_t i : contacts[g].particles)
      x_t1[i] = x0[i] + groups_[g].motion.displacement(x0[i]) + moving_[i];
}

}  // namespace selvedge::detail
