// SPDX-License-Identifier: MIT
//
// Which steps are halved because they end far above the strain limit.
#pragma once

namespace selvedge::detail {

/// An attempt of a step. Strains are measured from their limit, by their limit: 0 is the limit
/// itself, 1 twice the limit.
struct StrainTrial {
  double h = 0.0;                 ///< s, its length
  double start = 0.0, end = 0.0;  ///< largest strain above the limit at both ends; at least 0
  double given = 0.0;             ///< strain that short steps could not avoid; 0: none is known
  bool may_shorten = true;        ///< a shorter attempt is allowed
};

/// A step that ends far above the strain limit is halved while that helps: a limiter and a
/// fail-safe that cannot agree in a long step agree in a short one. It does not help where handles,
/// the start or closing bodies prescribe the strain, which then grows as fast in short steps as in
/// long ones. Such strain is accepted, and steps are halved again only once it has grown.
class StrainGuard {
 public:
  /// Call before the first attempt of a step.
  void begin() { *this = {}; }
  /// Whether a strain is so far above the limit that the guard acts.
  static bool is_far(double end);
  /// An attempt that ends above this is repeated if it is the first one of its step, is allowed to
  /// be shorter and nothing is given: rounds of limiter and fail-safe would be in vain.
  static constexpr double kHopeless = 4.0;
  /// Whether the attempt has to be repeated with half its length.
  bool wants_shorter(const StrainTrial& trial);
  /// Whether shorter attempts of this step helped.
  bool has_shortened() const { return last_rate_ >= 0.0 && !gave_up_; }
  /// The strain that is given, after this attempt was accepted.
  double given_after(const StrainTrial& trial) const;

 private:
  double last_rate_ = -1.0;  // 1/s, growth in the last attempt; negative: there was none
  int in_vain_ = 0;          // halvings in a row that did not help
  bool gave_up_ = false;
};

}  // namespace selvedge::detail
