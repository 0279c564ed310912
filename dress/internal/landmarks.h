// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <array>
#include <string>
#include <vector>

namespace selvedge {

/// A section of a body: its middle, and the length of a tape around it.
struct BodyRing {
  Vec3 middle = Vec3::Zero();  ///< m
  double girth = 0.0;          ///< m
};

/// An arm or a leg.
struct BodyLimb {
  Vec3 tip = Vec3::Zero();      ///< m, of the longest finger or toe
  std::vector<BodyRing> rings;  ///< 1 cm apart along the skin, from the trunk to the tip
  BodyRing upper, lower;        ///< upper arm and wrist, thigh and ankle
  double length = 0.0;          ///< m, along the middles of the rings to `lower`
};

/// Where the parts of a person's body are, in any pose.
struct BodyLandmarks {
  Vec3 up = Vec3::Zero(), left = Vec3::Zero(), forward = Vec3::Zero();  ///< unit, of the trunk
  double height = 0.0;      ///< m, extent of the body along `up`
  Vec3 top = Vec3::Zero();  ///< m, of the head
  BodyRing neck, neck_base, bust, waist, hips;
  Vec3 crotch = Vec3::Zero();  ///< m
  /// m, left and right: where neck and shoulder meet, the end of the shoulder, the armpit
  std::array<Vec3, 2> neck_side, shoulder, armpit;
  std::array<double, 2> shoulder_to_wrist{};  ///< m, along the skin
  std::array<BodyLimb, 2> arms, legs;         ///< left, right
};

/// Finds the landmarks from distances along the skin, which hardly change with the pose: head,
/// hands and feet are the points farthest from each other [LazarusVerroust1999]; the rings are
/// levels of the distance from them. The body, m, has head, arms, legs and feet, and its largest
/// connected part is the person. Throws std::invalid_argument that says what is missing.
BodyLandmarks find_landmarks(const TriangleMesh& body);

/// A measure of a body as a tailor takes it.
struct BodyMeasure {
  std::string name;    ///< of FreeSewing, such as hpsToWaistBack
  double value = 0.0;  ///< m; rad of an angle
  bool is_angle = false;
};
/// The measures that patterns for the trunk, sleeves, skirts and trousers need. Tapes lie on convex
/// hulls of sections. The body, m, is that of the landmarks.
std::vector<BodyMeasure> body_measures(const TriangleMesh& body, const BodyLandmarks& landmarks);

/// A table of them: name, place and girth, one in each line.
std::string landmark_table(const BodyLandmarks& landmarks);

}  // namespace selvedge
