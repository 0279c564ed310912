// SPDX-License-Identifier: MIT
#include <selvedge/data/makers/detail/mannequin_bones.h>
#include <selvedge/data/makers/mannequin.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace selvedge {

namespace {

using detail::BoneFrame;

// Distance over which the influence of a bone on the skin decreases to 1/e; a larger value makes
// joints rounder and thinner.
constexpr double kReach = 0.02;  // m

// Rounds of averaging the weights with the neighbours: enough that no fold is sharper than a few
// triangles, which have sides of about 2 cm.
constexpr int kSmoothingRounds = 12;

// The next bone towards the trunk.
constexpr std::size_t kParent[detail::bone_count] = {
    detail::trunk,          detail::trunk,       detail::left_thigh,     detail::left_shank,
    detail::trunk,          detail::right_thigh, detail::right_shank,    detail::trunk,
    detail::left_upper_arm, detail::trunk,       detail::right_upper_arm};

bool adjacent(std::size_t a, std::size_t b) { return a == b || kParent[a] == b || kParent[b] == a; }

// Weights by distance, restricted to the nearest bone and its neighbours: a hand that hangs beside
// the thigh does not move the thigh.
std::vector<double> first_weights(const std::vector<double>& distance) {
  const auto nearest = static_cast<std::size_t>(std::min_element(distance.begin(), distance.end()) -
                                                distance.begin());
  std::vector<double> weights(distance.size(), 0.0);
  for (std::size_t b = 0; b < weights.size(); ++b)
    if (adjacent(nearest, b)) weights[b] = std::exp((distance[nearest] - distance[b]) / kReach);
  return weights;
}

void normalise(std::vector<double>& weights) {
  double sum = 0.0;
  for (const double w : weights) sum += w;
  for (double& w : weights) w /= sum;
}

std::vector<std::vector<double>> smoothed(std::vector<std::vector<double>> weights,
                                          std::span<const Triangle> triangles) {
  const std::vector<Edge> edges = unique_edges(triangles);
  for (int round = 0; round < kSmoothingRounds; ++round) {
    std::vector<std::vector<double>> next = weights;
    for (const Edge& e : edges)
      for (std::size_t b = 0; b < detail::bone_count; ++b) {
        next[e[0]][b] += weights[e[1]][b];
        next[e[1]][b] += weights[e[0]][b];
      }
    for (auto& w : next) normalise(w);
    weights = std::move(next);
  }
  return weights;
}

double smooth_step(double t) {
  const double s = std::clamp(t, 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

// One leg and the arm of the same side, which swings in the opposite direction. The knee bends
// while the thigh moves forward.
LimbPose limb(double phase, double share, double stride) {
  constexpr double knee_lift = 0.75, knee_rest = 0.08, knee_lead = 0.5;  // rad
  constexpr double arm_share = 0.8, elbow_rest = 0.3, elbow_swing = 0.15;
  LimbPose pose;
  const double lift = std::max(0.0, std::cos(phase + knee_lead));
  pose.hip_swing = share * stride * std::sin(phase);
  pose.knee = share * (knee_rest + knee_lift * lift * lift);
  pose.shoulder_swing = -share * arm_share * stride * std::sin(phase);
  pose.elbow += share * (elbow_rest - elbow_swing * std::sin(phase));
  return pose;
}

}  // namespace

BendingMannequin::BendingMannequin(const MannequinConfig& config)
    : config_(config), surface_(detail::mannequin_surface(config)) {
  std::vector<std::vector<double>> weights;
  for (const auto& distance : detail::bone_distances(config, surface_.vertices)) {
    weights.push_back(first_weights(distance));
    normalise(weights.back());
  }
  weights_ = smoothed(std::move(weights), surface_.triangles);
}

std::vector<Vec3> BendingMannequin::bent(const LimbPose& left, const LimbPose& right) const {
  MannequinConfig config = config_;
  config.left = left;
  config.right = right;
  const std::vector<BoneFrame> from = detail::mannequin_bones(config_),
                               to = detail::mannequin_bones(config);
  std::vector<Vec3> x(surface_.vertices.size(), Vec3::Zero());
  for (std::size_t b = 0; b < detail::bone_count; ++b) {
    const Mat3 turn = to[b].rotation * from[b].rotation.transpose();
    for (std::size_t i = 0; i < x.size(); ++i)
      if (weights_[i][b] > 0.0)
        x[i] += weights_[i][b] * (turn * (surface_.vertices[i] - from[b].origin) + to[b].origin);
  }
  detail::stand(x, config_.height);
  return x;
}

WalkPose walk_at(double time, const WalkConfig& config) {
  if (!(config.cycle > 0.0) || !(config.start > 0.0))
    throw std::invalid_argument("walk: cycle and start must be positive");
  const double most = 0.45;  // rad; beyond it the seat folds into the thighs
  if (!(config.stride >= 0.0 && config.stride <= most))
    throw std::invalid_argument("walk: stride is " + std::to_string(config.stride) +
                                ", but must lie between 0 and 0.45 rad");
  const double share = smooth_step(time / config.start);
  const double phase = 2.0 * std::numbers::pi * std::max(time, 0.0) / config.cycle;
  WalkPose walk;
  walk.left = limb(phase, share, config.stride);
  walk.right = limb(phase + std::numbers::pi, share, config.stride);
  // Two steps per cycle, each as long as the distance between the feet. The integral of smooth_step
  // comes first.
  constexpr double leg = 0.88;  // m
  const double speed = 4.0 * leg * std::sin(config.stride) / config.cycle;
  const double s = std::clamp(time / config.start, 0.0, 1.0);
  const double starting = config.start * s * s * s * (1.0 - 0.5 * s);
  walk.way = speed * (starting + std::max(0.0, time - config.start));
  return walk;
}

}  // namespace selvedge
