// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>
#include <selvedge/simulation/contacts/detail/detection.h>
#include <selvedge/simulation/run_result.h>

#include <memory>
#include <string>
#include <vector>

namespace selvedge::detail {

/// Whether every step is searched again (CMake option SELVEDGE_VALIDATION).
#ifdef SELVEDGE_VALIDATION
inline constexpr bool kValidatesSteps = true;
#else
inline constexpr bool kValidatesSteps = false;
#endif

/// Candidate pairs of the cloth with the bodies and with itself.
struct FreshPairs {
  CandidatePairs body, self;
};

/// Searches a motion again, independently of Detection: the boxes are those of the motion itself,
/// without margin and thickness, and nothing is kept between calls. Collisions are decided by the
/// exact narrow phase.
class StepValidator {
 public:
  /// A detector other than the scene's, to which the scene's own name is given.
  explicit StepValidator(const std::string& scene_broad_phase);
  /// `broad` must be conservative.
  explicit StepValidator(std::unique_ptr<BroadPhase> broad);

  /// The pairs whose boxes, each grown by `thickness` (m), overlap. Without excluded pairs and
  /// without vertices of no triangle.
  void find_pairs(const SearchedMotion& motion, double thickness, FreshPairs& out);
  /// The pairs that collide, whatever the candidates are.
  std::vector<ContactPoint> collisions(const SearchedMotion& motion);
  /// The pairs that the motions leave out have changed: the last motion is searched again.
  void forget() { excluded_ = nullptr, x_t0_.clear(), x_t1_.clear(); }
  /// The pairs that collide but are not among the candidates. Empty in a correct program.
  std::vector<ContactPoint> missed(const SearchedMotion& motion);

 private:
  void search(const SearchedMotion& motion);
  std::vector<ContactPoint> colliding(const SearchedMotion& motion, const FreshPairs& pairs);

  std::unique_ptr<BroadPhase> broad_;
  std::unique_ptr<NarrowPhase> exact_;
  FreshPairs pairs_;                // of the last motion
  std::vector<Vec3> x_t0_, x_t1_;   // the last motion, m
  const void* excluded_ = nullptr;  // and what it left out
  std::vector<Contact> found_;
};

/// Removes the candidates of `motion` from `pairs`.
void remove_candidates(const SearchedMotion& motion, FreshPairs& pairs);

/// Aborts with the first missed pair if candidates of an attempt missed a collision.
void validate_attempt(StepValidator& validator, const SearchedMotion& motion,
                      const VertexNames& names, long long step);
/// Aborts with the first pair if an accepted step has a collision on a path.
void validate_accepted(StepValidator& validator, const SearchedMotion& motion,
                       const VertexNames& names, long long step);

}  // namespace selvedge::detail
