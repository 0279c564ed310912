// SPDX-License-Identifier: MIT
//
// Landmarks of a body from distances along its skin: the five ends of a person are farthest from
// each other, and levels of the distance from an end are rings around head, arms and legs.
#include <fmt/format.h>
#include <selvedge/dress/detail/skin_distance.h>
#include <selvedge/dress/internal/landmarks.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace selvedge {
namespace {

using detail::SkinLoop;

constexpr double kRingStep = 0.01;  // m, between rings
// Distances along the skin of SMPL's average bodies, of any unit.
constexpr double kHeadHand = 1.14, kHeadFoot = 1.86, kHandHand = 1.69, kFootFoot = 1.75,
                 kSameSide = 2.00, kOtherSide = 2.08;
constexpr double kUnlike = 0.2;     // relative error of one of them at which it is no person
constexpr double kArmShare = 0.75;  // of the distance from hand to head: farther is no arm
// Where neck, wrist and ankle are, in shares of the distance from the end of their part to the head
// (neck: to the feet).
constexpr std::array<double, 2> kNeck = {0.09, 0.22}, kWrist = {0.12, 0.26}, kAnkle = {0.12, 0.22};
constexpr double kShoulderEnd = 0.09;  // m, along the skin above the armpit
constexpr double kNeckBase = 1.2;      // radius of the base of the neck over that of the neck

struct Level {
  double at = 0.0;  // m
  SkinLoop loop;
  double radius = 0.0;  // m, mean distance of its points from their middle
};

double radius_of(const SkinLoop& loop) {
  const Vec3 middle = loop.middle();
  double sum = 0.0;
  for (const Vec3& p : loop.points) sum += (p - middle).norm();
  return sum / static_cast<double>(loop.points.size());
}

class Finder {
 public:
  explicit Finder(const TriangleMesh& body) : mesh_(detail::largest_part(body)), skin_(mesh_) {}

  BodyLandmarks find() {
    find_ends();
    find_neck();
    for (int k = 0; k < 2; ++k) find_arm(k);
    for (int k = 0; k < 2; ++k) find_leg(k);
    find_axes();
    find_trunk();
    marks_.top = mesh_.vertices[ends_[0]];
    return marks_;
  }

 private:
  const std::vector<double>& from_hand(int k) const { return from_[1 + k]; }
  const std::vector<double>& from_foot(int k) const { return from_[3 + k]; }

  std::vector<double> distances(std::int32_t vertex) const {
    return skin_.from(std::span(&vertex, 1));
  }

  /// Head, two hands, two feet: each the point that is farthest from those before.
  void find_ends() {
    const auto farthest = [](const std::vector<double>& d) {
      return static_cast<std::int32_t>(std::max_element(d.begin(), d.end()) - d.begin());
    };
    std::vector<double> nearest = distances(farthest(distances(0)));
    std::vector<std::int32_t> ends = {farthest(distances(0))};
    std::vector<std::vector<double>> from = {nearest};
    while (ends.size() < 5) {
      ends.push_back(farthest(nearest));
      from.push_back(distances(ends.back()));
      for (std::size_t v = 0; v < nearest.size(); ++v)
        nearest[v] = std::min(nearest[v], from.back()[v]);
    }
    std::array<int, 5> order = best_order(ends, from);
    for (int i = 0; i < 5; ++i) {
      ends_[i] = ends[order[i]];
      from_[i] = std::move(from[order[i]]);
    }
  }

  /// Which of the ends are head, hands and feet; hand 0 and foot 0 are of one side.
  static std::array<int, 5> best_order(const std::vector<std::int32_t>& ends,
                                       const std::vector<std::vector<double>>& from) {
    const double person[5][5] = {{0.0, kHeadHand, kHeadHand, kHeadFoot, kHeadFoot},
                                 {kHeadHand, 0.0, kHandHand, kSameSide, kOtherSide},
                                 {kHeadHand, kHandHand, 0.0, kOtherSide, kSameSide},
                                 {kHeadFoot, kSameSide, kOtherSide, 0.0, kFootFoot},
                                 {kHeadFoot, kOtherSide, kSameSide, kFootFoot, 0.0}};
    double all = 0.0, of_person = 0.0;
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < i; ++j) {
        all += from[i][ends[j]];
        of_person += person[i][j];
      }
    std::array<int, 5> order = {0, 1, 2, 3, 4}, best = order;
    double least = std::numeric_limits<double>::infinity(), worst = 0.0;
    do {
      double sum = 0.0, most = 0.0;
      for (int i = 0; i < 5; ++i)
        for (int j = 0; j < i; ++j) {
          const double is = from[order[i]][ends[order[j]]] / all, should = person[i][j] / of_person;
          sum += (is - should) * (is - should);
          most = std::max(most, std::abs(is / should - 1.0));
        }
      if (sum < least) least = sum, best = order, worst = most;
    } while (std::next_permutation(order.begin(), order.end()));
    if (!(worst < kUnlike))
      throw std::invalid_argument(
          "its five ends are not those of a head, two hands and two feet; give the mesh of a whole "
          "person in one part");
    return best;
  }

  Level level(const std::vector<double>& from, double at) const {
    std::vector<SkinLoop> loops = detail::level_loops(mesh_, from, at);
    if (loops.empty())
      throw std::invalid_argument(
          "its skin has no closed line around a limb; give a mesh without holes");
    const double radius = radius_of(loops.front());
    return {at, std::move(loops.front()), radius};
  }

  /// The thinnest ring between two shares of `length`.
  Level thinnest(const std::vector<double>& from, const std::array<double, 2>& shares,
                 double length) const {
    Level best;
    for (double at = shares[0] * length; at <= shares[1] * length; at += kRingStep) {
      Level here = level(from, at);
      if (best.loop.points.empty() || here.radius < best.radius) best = std::move(here);
    }
    return best;
  }

  void find_neck() {
    height_ = 0.5 * (from_[0][ends_[3]] + from_[0][ends_[4]]);
    const Level neck = thinnest(from_[0], kNeck, height_);
    neck_at_ = neck.at;
    Level base = neck;
    while (base.radius < kNeckBase * neck.radius && base.at < 0.5 * height_)
      base = level(from_[0], base.at + kRingStep);
    neck_base_ = base.loop;
    const Level above = level(from_[0], neck.at - kRingStep),
                below = level(from_[0], neck.at + kRingStep);
    const Vec3 axis = (above.loop.middle() - below.loop.middle()).normalized();
    marks_.neck = {neck.loop.middle(), neck.loop.girth(axis)};
    marks_.neck_base = {neck_base_.middle(), neck_base_.girth(axis)};
  }

  /// Below the neck, the levels of the distance from the head part into trunk and arms.
  void find_arm(int k) {
    const double longest = kArmShare * from_hand(k)[ends_[0]];
    for (double at = neck_at_ + kRingStep; at < 0.6 * height_; at += kRingStep)
      for (const SkinLoop& loop : detail::level_loops(mesh_, from_[0], at)) {
        double most = 0.0, sum = 0.0;
        std::size_t lowest = 0;
        for (std::size_t i = 0; i < loop.points.size(); ++i) {
          most = std::max(most, loop.value(from_hand(k), i));
          sum += loop.value(from_hand(k), i);
          if (loop.value(from_foot(k), i) < loop.value(from_foot(k), lowest)) lowest = i;
        }
        if (most > longest) continue;
        arm_at_[k] = sum / static_cast<double>(loop.points.size());
        marks_.armpit[k] = loop.points[lowest];
        add_arm_rings(k);
        return;
      }
    throw std::invalid_argument(
        "no arm parts from its trunk below the neck; give a body whose arms do not grow together "
        "with the trunk");
  }

  void add_arm_rings(int k) {
    BodyLimb& arm = marks_.arms[k];
    const double wrist = thinnest(from_hand(k), kWrist, from_hand(k)[ends_[0]]).at;
    add_rings(arm, from_hand(k), ends_[1 + k], arm_at_[k], wrist);
    arm.upper = arm.rings[std::min<std::size_t>(4, arm.rings.size() - 1)];
    const SkinLoop top = level(from_hand(k), arm_at_[k] + kShoulderEnd).loop;
    std::size_t highest = 0;
    for (std::size_t i = 0; i < top.points.size(); ++i)
      if (top.value(from_foot(k), i) > top.value(from_foot(k), highest)) highest = i;
    marks_.shoulder[k] = top.points[highest];
    marks_.shoulder_to_wrist[k] = arm_at_[k] + kShoulderEnd - wrist;
  }

  /// Where a ring around the leg meets the other leg, the legs begin.
  void find_leg(int k) {
    for (double at = 0.3 * height_; at < 0.7 * height_; at += kRingStep) {
      const SkinLoop loop = level(from_foot(k), at).loop;
      for (std::size_t i = 0; i < loop.points.size(); ++i)
        if (loop.value(from_foot(1 - k), i) < at) {
          marks_.crotch += 0.5 * loop.points[i];
          BodyLimb& leg = marks_.legs[k];
          const double ankle = thinnest(from_foot(k), kAnkle, height_).at;
          add_rings(leg, from_foot(k), ends_[3 + k], at - kRingStep, ankle);
          leg.upper = leg.rings[std::min<std::size_t>(3, leg.rings.size() - 1)];
          leg_at_[k] = at;
          return;
        }
    }
    throw std::invalid_argument("its legs do not part; give a body with two legs");
  }

  /// Rings from the trunk to the tip; `lower`: m, from the tip, of wrist or ankle.
  void add_rings(BodyLimb& limb, const std::vector<double>& from, std::int32_t tip, double upper,
                 double lower) const {
    limb.tip = mesh_.vertices[tip];
    std::vector<SkinLoop> loops;
    std::size_t last = 0;
    for (double at = upper; at > 2.0 * kRingStep; at -= kRingStep) {
      if (at >= lower - 0.5 * kRingStep) last = loops.size();
      loops.push_back(level(from, at).loop);
    }
    std::vector<Vec3> middles;
    for (const SkinLoop& loop : loops) middles.push_back(loop.middle());
    const std::size_t n = loops.size();
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 along = middles[std::min(i + 2, n - 1)] - middles[i < 2 ? 0 : i - 2];
      limb.rings.push_back({middles[i], loops[i].girth(along.normalized())});
    }
    for (std::size_t i = 1; i <= last; ++i) limb.length += (middles[i] - middles[i - 1]).norm();
    limb.lower = limb.rings[last];
  }

  /// The feet show where the front is.
  void find_axes() {
    const auto root = [](const BodyLimb& limb) { return limb.rings.front().middle; };
    const Vec3 hips = 0.5 * (root(marks_.legs[0]) + root(marks_.legs[1]));
    marks_.up = (marks_.neck.middle - hips).normalized();
    const auto across = [&](const Vec3& v) { return Vec3(v - v.dot(marks_.up) * marks_.up); };
    const Vec3 side = across((root(marks_.legs[0]) - root(marks_.legs[1])).normalized() +
                             (root(marks_.arms[0]) - root(marks_.arms[1])).normalized())
                          .normalized();
    Vec3 toes = Vec3::Zero();
    for (const BodyLimb& leg : marks_.legs) toes += across(leg.tip - leg.lower.middle);
    Vec3 forward = side.cross(marks_.up);
    if (std::abs(forward.dot(toes)) < 0.05 * height_)
      throw std::invalid_argument(
          "its feet do not show where its front is; give a body with feet that point forward");
    if (forward.dot(toes) < 0.0) {
      forward = -forward;
      std::swap(marks_.arms[0], marks_.arms[1]);
      std::swap(marks_.legs[0], marks_.legs[1]);
      std::swap(marks_.shoulder[0], marks_.shoulder[1]);
      std::swap(marks_.armpit[0], marks_.armpit[1]);
      std::swap(marks_.shoulder_to_wrist[0], marks_.shoulder_to_wrist[1]);
      std::swap(arm_at_[0], arm_at_[1]);
      std::swap(leg_at_[0], leg_at_[1]);
      std::swap(from_[1], from_[2]);
      std::swap(from_[3], from_[4]);
    }
    marks_.forward = forward;
    marks_.left = marks_.up.cross(forward);
    for (int k = 0; k < 2; ++k) {
      const double sign = k == 0 ? 1.0 : -1.0;
      marks_.neck_side[k] = *std::max_element(
          neck_base_.points.begin(), neck_base_.points.end(), [&](const Vec3& a, const Vec3& b) {
            return sign * marks_.left.dot(a) < sign * marks_.left.dot(b);
          });
    }
  }

  /// The section of the trunk at a height, without arms and legs.
  BodyRing section(std::span<const double> heights, double at) const {
    for (const SkinLoop& loop : detail::level_loops(mesh_, heights, at)) {
      std::size_t beside = 0;
      for (std::size_t i = 0; i < loop.points.size(); ++i)
        for (int k = 0; k < 2; ++k)
          if (loop.value(from_hand(k), i) < arm_at_[k] ||
              loop.value(from_foot(k), i) < leg_at_[k] - 2.0 * kRingStep)
            ++beside;
      if (4 * beside < loop.points.size()) return {loop.middle(), loop.girth(marks_.up)};
    }
    return {};
  }

  void find_trunk() {
    std::vector<double> heights;
    for (const Vec3& x : mesh_.vertices) heights.push_back(marks_.up.dot(x));
    const auto [least, most] = std::minmax_element(heights.begin(), heights.end());
    marks_.height = *most - *least;
    const double low = marks_.up.dot(marks_.crotch),
                 high = 0.5 * marks_.up.dot(marks_.armpit[0] + marks_.armpit[1]) - kRingStep;
    std::vector<BodyRing> rings;
    for (double at = low; at <= high; at += kRingStep)
      if (const BodyRing ring = section(heights, at); ring.girth > 0.0) rings.push_back(ring);
    if (rings.size() < 10)
      throw std::invalid_argument("its trunk has no closed sections; give a mesh without holes");
    const auto less = [](const BodyRing& a, const BodyRing& b) { return a.girth < b.girth; };
    const auto n = static_cast<std::ptrdiff_t>(rings.size());
    const auto waist =
        std::min_element(rings.begin() + 35 * n / 100, rings.begin() + 85 * n / 100, less);
    marks_.waist = *waist;
    marks_.hips = *std::max_element(rings.begin(), waist, less);
    marks_.bust = *std::max_element(waist, rings.end(), less);
  }

  TriangleMesh mesh_;
  detail::SkinDistance skin_;
  std::array<std::int32_t, 5> ends_{};         // head, hands, feet
  std::array<std::vector<double>, 5> from_;    // m, per vertex, from the ends
  double height_ = 0.0;                        // m, from head to feet along the skin
  double neck_at_ = 0.0;                       // m, from the top of the head
  std::array<double, 2> arm_at_{}, leg_at_{};  // m, where the limbs begin, from their tips
  SkinLoop neck_base_;
  BodyLandmarks marks_;
};

}  // namespace

BodyLandmarks find_landmarks(const TriangleMesh& body) {
  if (body.triangles.empty()) throw std::invalid_argument("the body has no triangles");
  try {
    return Finder(body).find();
  } catch (const std::invalid_argument& fault) {
    throw std::invalid_argument(fmt::format("the landmarks of the body: {}", fault.what()));
  }
}

std::string landmark_table(const BodyLandmarks& m) {
  std::string text;
  const auto row = [&](const char* name, const Vec3& at, double girth, const char* what) {
    text += fmt::format("{:<16} {:7.3f} {:7.3f} {:7.3f}", name, at.x(), at.y(), at.z());
    text += girth > 0.0 ? fmt::format("   {} {:.3f} m\n", what, girth) : std::string("\n");
  };
  const auto ring = [&](const char* name, const BodyRing& r) {
    row(name, r.middle, r.girth, "girth");
  };
  row("top of head", m.top, m.height, "height");
  ring("neck", m.neck);
  ring("base of neck", m.neck_base);
  for (int k = 0; k < 2; ++k) row(k == 0 ? "neck left" : "neck right", m.neck_side[k], 0.0, "");
  for (int k = 0; k < 2; ++k)
    row(k == 0 ? "shoulder left" : "shoulder right", m.shoulder[k], 0.0, "");
  for (int k = 0; k < 2; ++k) row(k == 0 ? "armpit left" : "armpit right", m.armpit[k], 0.0, "");
  ring("bust", m.bust);
  ring("waist", m.waist);
  ring("hips", m.hips);
  row("crotch", m.crotch, 0.0, "");
  for (int k = 0; k < 2; ++k) {
    ring(k == 0 ? "upper arm left" : "upper arm right", m.arms[k].upper);
    ring(k == 0 ? "wrist left" : "wrist right", m.arms[k].lower);
    row(k == 0 ? "hand left" : "hand right", m.arms[k].tip, m.arms[k].length, "arm");
    ring(k == 0 ? "thigh left" : "thigh right", m.legs[k].upper);
    ring(k == 0 ? "ankle left" : "ankle right", m.legs[k].lower);
    row(k == 0 ? "foot left" : "foot right", m.legs[k].tip, m.legs[k].length, "leg");
  }
  return text;
}

}  // namespace selvedge
