// SPDX-License-Identifier: MIT
#include <selvedge/bodies/driven_body.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace selvedge {

DrivenBody::DrivenBody(const Body& start, double time)
    : triangles_(start.triangles()), to_(start.vertex_count()), t0_(time), t1_(time) {
  start.positions(time, to_);
  from_ = to_;
}

void DrivenBody::check(std::span<const Vec3> x) const {
  if (x.size() != to_.size())
    throw std::invalid_argument("the body has " + std::to_string(to_.size()) + " vertices, " +
                                std::to_string(x.size()) + " positions are given");
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!x[i].allFinite())
      throw std::invalid_argument("the position of vertex " + std::to_string(i) +
                                  " of the body is not finite");
}

void DrivenBody::move_to(std::span<const Vec3> x, double t0, double t1) {
  check(x);
  if (!(t0 < t1) || !std::isfinite(t0) || !std::isfinite(t1))
    throw std::invalid_argument("a motion from " + std::to_string(t0) + " s to " +
                                std::to_string(t1) + " s has no length");
  std::vector<Vec3> now(to_.size());
  positions(t0, now);
  from_ = std::move(now);
  to_.assign(x.begin(), x.end());
  t0_ = t0;
  t1_ = t1;
}

void DrivenBody::place(std::span<const Vec3> x, double t) {
  check(x);
  to_.assign(x.begin(), x.end());
  from_ = to_;
  t0_ = t1_ = t;
}

void DrivenBody::positions(double time, std::span<Vec3> x) const {
  if (time >= t1_ || time <= t0_) {
    const std::vector<Vec3>& end = time >= t1_ ? to_ : from_;
    std::copy(end.begin(), end.end(), x.begin());
    return;
  }
  const double s = (time - t0_) / (t1_ - t0_);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = from_[i] + s * (to_[i] - from_[i]);
}

bool DrivenBody::is_static(double t0, double t1) const { return t0 > t1_ && t1 > t1_; }

}  // namespace selvedge
