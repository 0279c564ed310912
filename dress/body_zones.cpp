// SPDX-License-Identifier: MIT
//
// Where a tailor measures a body. Horizontal sections find the trunk: below the crotch it becomes
// two legs, at the armpits it becomes wider all at once. Between them are the smallest and the
// largest girths; an arm goes from the shoulder to the point farthest to the side.
#include <selvedge/dress/detail/fit.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace selvedge::detail {
namespace {

constexpr int kLevels = 200;         // sections of the body
constexpr double kTrunkOff = 0.2;    // of its width, by which the trunk may be off the middle
constexpr double kMidTrunk = 0.6;    // of the height, where every body has a trunk
constexpr double kArmpitJump = 1.2;  // factor of the width from one level to the next
constexpr double kHighestArmpit = 0.87, kLowestCrotch = 0.3;  // of the height
constexpr double kHead = 0.15;         // of the height, from the top, where the head is widest
constexpr double kAboveCrotch = 0.06;  // of the height, from where the waist is looked for
constexpr double kBelowCrotch = 0.02, kAlongThigh = 0.1;  // of the height
constexpr double kShoulder = 0.035;  // of the height, from the armpit up to the axis of the arm
constexpr double kUpperArm = 0.15;   // of the way from the shoulder to the end of the hand
constexpr double kAlongArm = 0.1;    // of the same, to a second section of the arm
constexpr double kReaches = 1.3;     // half widths of the trunk that an arm has to reach

/// The largest part of a horizontal section that lies about the middle of the body.
struct Trunk {
  double height = 0.0;              // m
  Vec3 middle = Vec3::Zero();       // m
  double width = 0.0, depth = 0.0;  // m, along x and y
  double tape = 0.0;                // m; 0: there is no such part
};

class ZoneFinder {
 public:
  explicit ZoneFinder(const TriangleMesh& body) : body_(body) {
    low_ = top_ = body.vertices.front().z();
    std::vector<double> x;
    for (const Vec3& p : body.vertices) {
      low_ = std::min(low_, p.z());
      top_ = std::max(top_, p.z());
      x.push_back(p.x());
    }
    const auto middle = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
    std::nth_element(x.begin(), middle, x.end());
    middle_ = *middle;
    for (int k = 0; k < kLevels; ++k) trunk_.push_back(trunk_at((k + 0.5) / kLevels));
  }

  std::vector<BodyZone> find() {
    const int start = level(kMidTrunk);
    if (trunk_[start].tape == 0.0) return {};
    int crotch = start, armpit = start;
    while (crotch > level(kLowestCrotch) && trunk_[crotch - 1].tape > 0.0) --crotch;
    while (armpit < level(kHighestArmpit) && !is_armpit(armpit + 1)) ++armpit;
    add_neck(armpit);
    const int bust = most(start, armpit - 1, [](const Trunk& t) { return t.depth; });
    const int waist =
        most(crotch + level(kAboveCrotch), bust, [](const Trunk& t) { return -t.tape; });
    add("bust", bust);
    add("waist", waist);
    add("hip", most(crotch, waist, [](const Trunk& t) { return t.tape; }));
    if (crotch > level(kLowestCrotch)) add_thighs(trunk_[crotch].height);
    if (armpit < level(kHighestArmpit)) add_arms(trunk_[armpit]);
    return std::move(zones_);
  }

 private:
  double size() const { return top_ - low_; }
  int level(double share) const { return static_cast<int>(share * kLevels); }
  bool is_armpit(int k) const { return trunk_[k].width > kArmpitJump * trunk_[k - 1].width; }

  Trunk trunk_at(double share) const {
    const CutPlane plane(Vec3(middle_, 0.0, low_ + share * size()), Vec3::UnitZ());
    Trunk trunk{.height = plane.point().z()};
    for (const Section::Part& part : section_of(body_, plane).parts) {
      if (part.tape <= trunk.tape) continue;
      const Vec3 middle = plane.in_space(part.middle);
      Vec3 low = middle, high = middle;
      for (const Eigen::Vector2d& p : part.hull) {
        low = low.cwiseMin(plane.in_space(p));
        high = high.cwiseMax(plane.in_space(p));
      }
      const Vec3 extent = high - low;
      if (std::abs(middle.x() - middle_) > kTrunkOff * extent.x()) continue;
      trunk = {trunk.height, middle, extent.x(), extent.y(), part.tape};
    }
    return trunk;
  }

  /// The level from `first` to `last` where a measure of the trunk is largest.
  template <class Measure>
  int most(int first, int last, Measure&& measure) const {
    int best = std::min(first, last);
    for (int k = best; k <= last; ++k)
      if (trunk_[k].tape > 0.0 && measure(trunk_[k]) > measure(trunk_[best])) best = k;
    return best;
  }

  void add(const std::string& name, int k) {
    if (trunk_[k].tape > 0.0) zones_.push_back({name, CutPlane(trunk_[k].middle, Vec3::UnitZ())});
  }

  void add_neck(int armpit) {
    const int head = most(level(1.0 - kHead), kLevels - 1, [](const Trunk& t) { return t.tape; });
    if (head <= armpit + 1) return;
    const int neck = most(armpit + 1, head, [](const Trunk& t) { return -t.tape; });
    if (neck > armpit + 1 && neck < head) add("neck", neck);
  }

  /// The part of a section that is nearest to the point of its plane, by its middle.
  std::optional<Vec3> part_near(const CutPlane& plane) const {
    std::optional<Vec3> nearest;
    double least = 0.0;
    for (const Section::Part& part : section_of(body_, plane).parts) {
      if (!contains(part.hull, Eigen::Vector2d::Zero())) continue;
      if (nearest && part.middle.norm() >= least) continue;
      least = part.middle.norm();
      nearest = plane.in_space(part.middle);
    }
    return nearest;
  }

  /// A zone across the line through the middles of the sections at two points.
  void add_across(const std::string& name, const CutPlane& at, const CutPlane& farther) {
    const std::optional<Vec3> middle = part_near(at), next = part_near(farther);
    if (!middle || !next || (*next - *middle).isZero(0.0)) return;
    const CutPlane across(*middle, *next - *middle);
    if (const std::optional<Vec3> exact = part_near(across))
      zones_.push_back({name, CutPlane(*exact, across.normal())});
  }

  void add_thighs(double crotch) {
    const double height = crotch - kBelowCrotch * size();
    const CutPlane plane(Vec3(middle_, 0.0, height), Vec3::UnitZ());
    for (const double side : {1.0, -1.0}) {
      const Section::Part* leg = nullptr;
      const Section section = section_of(body_, plane);
      for (const Section::Part& part : section.parts) {
        const double x = side * (plane.in_space(part.middle).x() - middle_);
        if (x > 0.0 && x < 0.5 * trunk_[level(kMidTrunk)].width + 0.1 * size() &&
            (!leg || part.tape > leg->tape))
          leg = &part;
      }
      if (!leg) continue;
      const Vec3 middle = plane.in_space(leg->middle);
      add_across(side > 0.0 ? "left thigh" : "right thigh", CutPlane(middle, Vec3::UnitZ()),
                 CutPlane(middle - kAlongThigh * size() * Vec3::UnitZ(), Vec3::UnitZ()));
    }
  }

  void add_arms(const Trunk& below) {
    for (const double side : {1.0, -1.0}) {
      const Vec3 shoulder = below.middle + Vec3(side * 0.5 * below.width, 0.0, kShoulder * size());
      Vec3 hand = shoulder;
      for (const Vec3& p : body_.vertices)
        if (side * (p.x() - hand.x()) > 0.0) hand = p;
      if (side * (hand.x() - middle_) < kReaches * 0.5 * below.width) continue;
      const Vec3 arm = hand - shoulder;
      add_across(side > 0.0 ? "left upper arm" : "right upper arm",
                 CutPlane(shoulder + kUpperArm * arm, arm),
                 CutPlane(shoulder + (kUpperArm + kAlongArm) * arm, arm));
    }
  }

  const TriangleMesh& body_;
  double low_ = 0.0, top_ = 0.0, middle_ = 0.0;  // m; heights, and x
  std::vector<Trunk> trunk_;                     // from below
  std::vector<BodyZone> zones_;
};

}  // namespace

std::vector<BodyZone> body_zones(const TriangleMesh& body) {
  if (body.vertices.empty()) return {};
  return ZoneFinder(body).find();
}

}  // namespace selvedge::detail
