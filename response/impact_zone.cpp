// SPDX-License-Identifier: MIT
#include <selvedge/response/impact_zone.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace selvedge {
namespace {

// A rigid displacement x -> c1 + r (x - c0) over the step.
struct RigidStep {
  Mat3 r;
  Vec3 c0, c1;
};

// Anchors farther than this share of their own extent from a rigid motion do not move as one.
constexpr double kRigidTolerance = 1e-6;

// Moments below this share of the largest mark points on a line, whose spin about it is free.
constexpr double kInertiaCut = 1e-10;

// Momentum-keeping rigid motion of free particles: linear and angular momentum of x_t0 -> x_t1.
RigidStep momentum_step(std::span<const std::int32_t> particles, std::span<const double> mass,
                        std::span<const Vec3> x0, std::span<const Vec3> x1, double& angle) {
  double total = 0.0;
  RigidStep step{Mat3::Identity(), Vec3::Zero(), Vec3::Zero()};
  for (const std::int32_t i : particles) {
    total += mass[i];
    step.c0 += mass[i] * x0[i];
    step.c1 += mass[i] * x1[i];
  }
  step.c0 /= total;
  step.c1 /= total;
  Mat3 inertia = Mat3::Zero();
  Vec3 momentum = Vec3::Zero();
  for (const std::int32_t i : particles) {
    const Vec3 r = x0[i] - step.c0;
    inertia += mass[i] * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
    momentum += mass[i] * r.cross(x1[i] - x0[i]);
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(inertia);
  Vec3 spin = Vec3::Zero();
  for (int k = 0; k < 3; ++k)
    if (eigen.eigenvalues()[k] > kInertiaCut * eigen.eigenvalues()[2])
      spin += eigen.eigenvectors().col(k) * eigen.eigenvectors().col(k).dot(momentum) /
              eigen.eigenvalues()[k];
  angle = spin.norm();
  if (angle > 0.0) step.r = Eigen::AngleAxisd(angle, spin / angle).toRotationMatrix();
  return step;
}

// Best rigid fit of the anchors' displacement [Kabsch1976].
RigidStep fit_step(std::span<const std::int32_t> anchors, std::span<const Vec3> x0,
                   std::span<const Vec3> x1, double& error, double& extent) {
  RigidStep step{Mat3::Identity(), Vec3::Zero(), Vec3::Zero()};
  for (const std::int32_t i : anchors) {
    step.c0 += x0[i];
    step.c1 += x1[i];
  }
  step.c0 /= static_cast<double>(anchors.size());
  step.c1 /= static_cast<double>(anchors.size());
  Mat3 covariance = Mat3::Zero();
  for (const std::int32_t i : anchors)
    covariance += (x1[i] - step.c1) * (x0[i] - step.c0).transpose();
  const Eigen::JacobiSVD<Mat3> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 flip = Mat3::Identity();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) flip(2, 2) = -1.0;
  step.r = svd.matrixU() * flip * svd.matrixV().transpose();
  error = extent = 0.0;
  for (const std::int32_t i : anchors) {
    error = std::max(error, (step.c1 + step.r * (x0[i] - step.c0) - x1[i]).norm());
    extent = std::max(extent, (x0[i] - step.c0).norm());
  }
  return step;
}

}  // namespace

void ImpactZones::begin(const ContactMotion& motion) {
  motion_ = motion;
  parent_.resize(motion.particles);
  std::iota(parent_.begin(), parent_.end(), 0);
  in_zone_.assign(motion.particles, 0);
  anchors_.clear();
}

std::int32_t ImpactZones::root(std::int32_t i) const {
  while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
  return i;
}

void ImpactZones::merge(std::span<const ContactPoint> contacts) {
  for (const ContactPoint& c : contacts) {
    std::int32_t first = -1;
    for (const std::int32_t i : c.vertex) {
      if (motion_.inv_mass[i] <= 0.0) continue;
      in_zone_[i] = 1;
      if (first < 0) first = i;
      // The smaller index is the root: the result does not depend on the order of contacts.
      const std::int32_t a = root(first), b = root(i);
      parent_[std::max(a, b)] = std::min(a, b);
    }
    if (first < 0) continue;
    for (const std::int32_t i : c.vertex)
      if (motion_.inv_mass[i] <= 0.0) anchors_.push_back({first, i});
  }
}

std::size_t ImpactZones::members() const {
  return static_cast<std::size_t>(std::count(in_zone_.begin(), in_zone_.end(), 1));
}

std::vector<ImpactZones::Zone> ImpactZones::zones() const {
  std::vector<std::int32_t> index(motion_.particles, -1);
  std::vector<Zone> zones;
  for (std::size_t i = 0; i < motion_.particles; ++i) {
    if (!in_zone_[i]) continue;
    const std::int32_t r = root(static_cast<std::int32_t>(i));
    if (index[r] < 0) {
      index[r] = static_cast<std::int32_t>(zones.size());
      zones.emplace_back();
    }
    zones[index[r]].particles.push_back(static_cast<std::int32_t>(i));
  }
  for (const auto& [particle, anchor] : anchors_)
    zones[index[root(particle)]].anchors.push_back(anchor);
  for (Zone& zone : zones) {
    std::sort(zone.anchors.begin(), zone.anchors.end());
    zone.anchors.erase(std::unique(zone.anchors.begin(), zone.anchors.end()), zone.anchors.end());
  }
  return zones;
}

bool ImpactZones::apply(std::span<const double> mass, std::span<Vec3> x_t1) const {
  const std::span<const Vec3> x0 = motion_.x_t0;
  bool possible = true;
  for (const Zone& zone : zones()) {
    if (!zone.anchors.empty()) {
      const Vec3 shift = x_t1[zone.anchors[0]] - x0[zone.anchors[0]];
      const bool together = std::all_of(zone.anchors.begin(), zone.anchors.end(),
                                        [&](auto i) { return Vec3(x_t1[i] - x0[i]) == shift; });
      if (together) {
        for (const std::int32_t i : zone.particles) x_t1[i] = x0[i] + shift;
        continue;
      }
    }
    double angle = 0.0, error = 0.0, extent = 0.0;
    const RigidStep step = zone.anchors.empty()
                               ? momentum_step(zone.particles, mass, x0, x_t1, angle)
                               : fit_step(zone.anchors, x0, x_t1, error, extent);
    if (angle >= std::numbers::pi || error > kRigidTolerance * extent) possible = false;
    for (const std::int32_t i : zone.particles) x_t1[i] = step.c1 + step.r * (x0[i] - step.c0);
  }
  return possible;
}

}  // namespace selvedge
