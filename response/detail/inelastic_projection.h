// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/detail/reference_motion.h>
#include <selvedge/response/response.h>

#include <map>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Options of InelasticProjection.
struct InelasticProjectionConfig {
  /// Gap that must remain at the end of a step, as a share of the rest gap; contacts that start
  /// closer keep their gap. Higher values leave the next step more room and stop cloth earlier.
  double end_gap = 0.1;
  /// Maximum number of Gauss-Seidel sweeps per projection.
  int sweeps = 100;
  /// Sweeping stops when no gap changes by more than this share of end_gap.
  double tolerance = 0.01;
  /// Maximum number of contacts per particle that one call of `add` takes, earliest first. After so
  /// many collisions a particle no longer follows the path on which the later ones were found.
  int contacts_of_particle = 16;
  /// A pair that returns more often than this may not approach at all.
  int lenient = 2;
};

/// Inelastic projection [Harmon2008, section 3]. Changes the displacements of all colliding
/// particles as little as possible, in the norm of their masses, so that no collision of the step
/// approaches by more than its gap allows. Tangential motion stays free except for the Coulomb
/// friction of the impulses. With d the displacement of x_t0 -> x_t1, c_k the row of contact k
/// (normal times weights, at its time of impact) and y the motion of its group as one piece
/// (reference_motion.h), it solves
///   min ½ (d - d*)ᵀ M (d - d*)   with   c_k·(d - y) >= -β_k,  β_k >= 0,
/// by projected Gauss-Seidel on accumulated impulses λ_k >= 0, |λ_t| <= μ λ_n.
///
/// Keeps the linear momentum of free particles and Σ m x_t0 × d: a contact's impulse at its time of
/// impact has a torque about x_t0, rel(x_t0) × n, which the group absorbs as a whole. Σ m|d|² never
/// grows; where anchors move, Σ m|d - y|² does not.
///
/// Deviations: [Harmon2008] requires c·d = 0 for all contacts of a zone; here contacts may open,
/// and may close by the spare part of their gap. The paper has neither friction nor the term for
/// the torque.
class InelasticProjection {
 public:
  explicit InelasticProjection(const InelasticProjectionConfig& config = {}) : config_(config) {}

  /// Starts a step. `x_t1`: end positions of the particles before the projection, metres.
  void begin(const ResponseStep& step, std::span<const Vec3> x_t1);
  /// Adds collisions to be resolved; those of earlier calls in this step remain.
  void add(std::span<const ContactPoint> hits);
  /// Writes the end positions of all particles in collisions added so far. If new collisions
  /// appear, pass them to another `add`.
  void apply(std::span<Vec3> x_t1);

 private:
  struct Row {
    ContactPoint point;
    Mat3 direction = Mat3::Zero();     // columns: normal, then two tangents
    Mat3 torque = Mat3::Zero();        // rel(x_t0) × direction
    Mat3 spin = Mat3::Zero();          // spin of the group per unit impulse
    std::array<double, 3> yielding{};  // displacement of the contact per unit impulse
    Vec3 impulse = Vec3::Zero();       // accumulated, along the directions
    Vec3 anchors = Vec3::Zero();       // Σ weight·(d - y) of its anchors
    double allowed = 0.0;              // β
    int repeats = 0;
    std::int32_t group = -1;
  };
  struct Group {
    ReferenceMotion motion;
    Mat3 mobility = Mat3::Zero();  // inverse inertia of a free group, 0 for a group with anchors
    Vec3 spin = Vec3::Zero();      // Ω caused by the torques
    bool at_rest = true;           // β is relative to y: the anchors move as one rigid piece
  };

  void make_groups();
  void prepare(Row& row) const;
  void push(Row& row, int axis, double impulse);
  double speed(const Row& row, int axis) const;
  double sweep();
  void take_back_gains();

  InelasticProjectionConfig config_;
  ResponseStep step_;
  ContactGroups contacts_;
  std::map<std::array<std::int32_t, 4>, int> seen_;
  std::vector<int> count_;     // contacts per particle in this call of add
  std::vector<Vec3> desired_;  // d* of the particles
  std::vector<Vec3> moving_;   // d - y without the spin of the groups
  std::vector<Row> rows_;
  std::vector<Group> groups_;
};

}  // namespace selvedge::detail
