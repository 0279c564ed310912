// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/follow.h>
#include <selvedge/response/detail/separating_planes.h>

#include <Eigen/LU>
#include <algorithm>
#include <limits>

namespace selvedge::detail {
namespace {

// Distance that the two sides keep from each other at the end, as a share of the rest gap: it
// leaves room for the next step and is too small to be visible. Sides that start closer keep their
// distance.
constexpr double kPlaneGap = 0.1;

// Share of that distance that the projections may leave unresolved on each side. A pair that is
// pressed together in every step loses at most twice this share of its gap per step.
constexpr double kSlack = 0.02;

// Sweeps over the planes of one particle; a corner of three planes settles in about ten.
constexpr int kSweeps = 32;

constexpr double kNowhere = std::numeric_limits<double>::infinity();

}  // namespace

void SeparatingPlanes::begin(const ResponseStep& step, std::span<const Vec3> x_t1) {
  step_ = step;
  groups_.begin(step.motion);
  pairs_.clear();
  shift_.reset();
  desired_.assign(x_t1.begin(), x_t1.begin() + static_cast<std::ptrdiff_t>(step.motion.particles));
  delta_.resize(desired_.size());
}

void SeparatingPlanes::add(std::span<const ContactPoint> pairs) {
  groups_.merge(pairs);
  for (const ContactPoint& c : pairs)
    if (groups_.group_of(c) >= 0) pairs_.push_back(c);
}

void SeparatingPlanes::make_references(std::span<const Vec3> x_t1) {
  const std::span<const Vec3> x0 = step_.motion.x_t0;
  references_.clear();
  inverse_.clear();
  for (const ContactGroup& group : groups_.groups()) {
    ReferenceMotion reference;
    if (shift_) {
      reference.shift = *shift_;
    } else if (group.anchors.empty()) {
      double total = 0.0;
      for (const std::int32_t i : group.particles) {
        total += step_.mass[i];
        reference.shift += step_.mass[i] * (desired_[i] - x0[i]);
      }
      reference.shift /= total;
    } else {
      reference = anchor_motion(group.anchors, x0, x_t1);
      if (reference.residual > kRigidResidual) reference.turn.setZero();
    }
    references_.push_back(reference);
    inverse_.push_back(reference.turn.isZero(0.0) ? Mat3(Mat3::Identity())
                                                  : (Mat3::Identity() + reference.turn).inverse());
    for (const std::int32_t i : group.particles)
      delta_[i] = beyond(i, reference, inverse_.back(), desired_);
  }
}

// x_t1 = x_t0 + d(x_t0) + (I + turn) δ.
Vec3 SeparatingPlanes::beyond(std::int32_t i, const ReferenceMotion& reference, const Mat3& inverse,
                              std::span<const Vec3> x_t1) const {
  const Vec3& x = step_.motion.x_t0[i];
  return inverse * (x_t1[i] - x - reference.displacement(x));
}

// Places the plane of a pair and adds its half-spaces. Heights are measured along the pair's normal
// from its first vertex. Returns false if the plane has no room.
bool SeparatingPlanes::cut(const ContactPoint& pair, std::span<const Vec3> x_t1) {
  const ContactMotion& motion = step_.motion;
  const std::int32_t g = groups_.group_of(pair);
  const int first = first_count(pair);
  std::array<double, 4> height;
  double low = -kNowhere, high = kNowhere;         // range of heights for the plane
  std::array<double, 2> end{kNowhere, -kNowhere};  // heights that the free vertices of each side
                                                   // would reach
  std::array<double, 2> mass{0.0, 0.0};
  for (int k = 0; k < 4; ++k) {
    const std::int32_t i = pair.vertex[k];
    const bool is_free = motion.inv_mass[i] > 0.0, above = k < first;
    height[k] = pair.normal.dot(motion.x_t0[i] - motion.x_t0[pair.vertex[0]]);
    const Vec3 delta = is_free ? delta_[i] : beyond(i, references_[g], inverse_[g], x_t1);
    const double there = height[k] + pair.normal.dot(delta);
    const double bound = is_free ? height[k]
                         : above ? std::min(height[k], there)
                                 : std::max(height[k], there);
    if (above)
      high = std::min(high, bound);
    else
      low = std::max(low, bound);
    if (!is_free) continue;
    mass[above ? 0 : 1] += step_.mass[i];
    end[above ? 0 : 1] = above ? std::min(end[0], there) : std::max(end[1], there);
  }
  const double keep = std::min(kPlaneGap * pair.rest_gap, high - low);
  const bool room = high > low && pair.gap > 0.0;
  // The sides meet where their common momentum would bring both.
  const double wanted = mass[0] <= 0.0 ? kNowhere
                        : mass[1] <= 0.0
                            ? -kNowhere
                            : (mass[0] * end[0] + mass[1] * end[1]) / (mass[0] + mass[1]);
  // Where rounding puts the upper bound below the lower one, std::clamp is not defined.
  const double plane = room ? std::min(std::max(wanted, low + 0.5 * keep), high - 0.5 * keep) : 0.0;
  for (int k = 0; k < 4; ++k) {
    const std::int32_t i = pair.vertex[k];
    if (motion.inv_mass[i] <= 0.0) continue;
    const double side = k < first ? 1.0 : -1.0;
    const double bound = side * (plane - height[k]) + 0.5 * keep;
    half_spaces_.push_back({i, side * pair.normal, room ? std::min(bound, 0.0) : 0.0,
                            room ? kSlack * keep : 0.0, pair.friction});
  }
  return room;
}

// Projects δ onto the half-spaces of its particle [Hildreth1957], shortens it by friction and then
// until it lies in all of them. The reference motion represents whatever is behind a plane: an
// amount that the planes remove from δ removes μ times as much of the sliding part.
void SeparatingPlanes::clip(std::span<const HalfSpace> planes, Vec3& delta) {
  const double size = delta.norm();
  multiplier_.assign(planes.size(), 0.0);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool settled = true;
    for (std::size_t k = 0; k < planes.size(); ++k) {
      const double violation = planes[k].bound - planes[k].normal.dot(delta);
      const double change = std::max(violation, -multiplier_[k]);
      settled = settled && std::abs(change) <= 0.5 * planes[k].slack;
      multiplier_[k] += change;
      delta += change * planes[k].normal;
    }
    if (settled) break;
  }
  double share = delta.norm() > size ? size / delta.norm() : 1.0;
  for (const HalfSpace& plane : planes) {
    const double height = plane.normal.dot(delta), least = plane.bound - plane.slack;
    if (share * height < least) share = least / height;
  }
  delta *= share;
  double friction = 0.0;
  for (std::size_t k = 0; k < planes.size(); ++k) friction += planes[k].friction * multiplier_[k];
  const double left = delta.norm();
  if (friction > 0.0) delta *= left > friction ? 1.0 - friction / left : 0.0;
}

void SeparatingPlanes::clip() {
  std::stable_sort(half_spaces_.begin(), half_spaces_.end(),
                   [](const auto& a, const auto& b) { return a.particle < b.particle; });
  for (std::size_t begin = 0; begin < half_spaces_.size();) {
    std::size_t end = begin;
    const std::int32_t i = half_spaces_[begin].particle;
    while (end < half_spaces_.size() && half_spaces_[end].particle == i) ++end;
    clip(std::span(half_spaces_).subspan(begin, end - begin), delta_[i]);
    begin = end;
  }
}

/// Followers stay the means of their leaders. 0 lies in every half-space.
void SeparatingPlanes::keep_followers(std::span<const Vec3> x_t1) {
  if (step_.motion.followers == nullptr) return;
  const Followers& followers = *step_.motion.followers;
  for (std::size_t g = 0; g < references_.size(); ++g)
    for (const std::int32_t i : groups_.groups()[g].particles)
      for (const Followers::Share& s : followers.shares(i))
        if (const std::int32_t leader = followers.leaders()[s.leader];
            step_.motion.inv_mass[leader] <= 0.0)
          delta_[leader] = beyond(leader, references_[g], inverse_[g], x_t1);
  const auto before = [](const HalfSpace& plane, std::int32_t i) { return plane.particle < i; };
  follow(step_.motion, delta_, [&](std::int32_t i, const Vec3& delta) {
    double share = 1.0;
    if (!groups_.contains(i)) return share;
    for (auto plane = std::lower_bound(half_spaces_.begin(), half_spaces_.end(), i, before);
         plane != half_spaces_.end() && plane->particle == i; ++plane) {
      const double height = plane->normal.dot(delta), least = plane->bound - plane->slack;
      if (share * height < least) share = least / height;
    }
    return share;
  });
}

void SeparatingPlanes::write(std::span<Vec3> x_t1) {
  const std::span<const Vec3> x0 = step_.motion.x_t0;
  const bool anchored = std::any_of(step_.motion.inv_mass.begin(), step_.motion.inv_mass.end(),
                                    [](double w) { return w <= 0.0; });
  const std::vector<ContactGroup>& groups = groups_.groups();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const ReferenceMotion& reference = references_[g];
    // A group without anchors keeps its momentum. With a common reference motion all groups are
    // near each other, and only the whole scene may be moved, if nothing in it is held.
    Vec3 lost = Vec3::Zero();
    if (groups[g].anchors.empty() && !shift_) {
      double total = 0.0;
      for (const std::int32_t i : groups[g].particles) {
        total += step_.mass[i];
        lost += step_.mass[i] * (desired_[i] - x0[i] - reference.shift - delta_[i]);
      }
      lost /= total;
    }
    for (const std::int32_t i : groups[g].particles)
      x_t1[i] =
          x0[i] + reference.displacement(x0[i]) + delta_[i] + reference.turn * delta_[i] + lost;
  }
  if (!shift_ || anchored) return;
  Vec3 lost = Vec3::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < desired_.size(); ++i) {
    total += step_.mass[i];
    lost += step_.mass[i] * (desired_[i] - x_t1[i]);
  }
  for (std::size_t i = 0; i < desired_.size(); ++i) x_t1[i] += lost / total;
}

bool SeparatingPlanes::apply(std::span<Vec3> x_t1) {
  failure_reason_.clear();
  make_references(x_t1);
  half_spaces_.clear();
  for (const ContactPoint& pair : pairs_) {
    const bool held = std::any_of(pair.vertex.begin(), pair.vertex.end(),
                                  [&](auto i) { return step_.motion.inv_mass[i] <= 0.0; });
    if (cut(pair, x_t1) || !held || !failure_reason_.empty()) continue;
    const std::int32_t g = groups_.group_of(pair);
    if (references_[g].residual > kRigidResidual || shift_)
      failure_reason_ = jam_sentence(groups_.groups()[g], step_.motion, x_t1);
  }
  clip();
  keep_followers(x_t1);
  write(x_t1);
  return failure_reason_.empty();
}

}  // namespace selvedge::detail
