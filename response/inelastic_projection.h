// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/reference_motion.h>
#include <selvedge/response/response.h>

#include <map>
#include <span>
#include <vector>

namespace selvedge {

struct InelasticProjectionConfig {
  /// Gap that may remain at the end of a step, as a share of the rest gap; contacts that start
  /// nearer keep what they have. More leaves the next step more room and stops cloth earlier.
  double end_gap = 0.1;
  /// Gauss-Seidel sweeps of one projection at most.
  int sweeps = 100;
  /// Change of a gap, as a share of end_gap, below which sweeping stops.
  double tolerance = 0.01;
  /// Contacts of a particle that one call of `add` takes, earliest first: what a particle would
  /// have met after so many others it will not meet.
  int contacts_of_particle = 16;
  /// Times that a pair may come back before it may not approach at all.
  int lenient = 2;
};

/// Inelastic projection [Harmon2008, section 3]: the displacements of all particles that collide
/// are changed as little as possible, in the norm of their masses, so that none of the collisions
/// of the step approaches any more than its gap allows; what is tangential stays free but for
/// Coulomb friction of the impulses. With d the displacement of x_t0 -> x_t1, c_k the row of
/// contact k (normal times weights, at its time of impact) and y the motion of its group as one
/// piece (reference_motion.h),
///   min ½ (d - d*)ᵀ M (d - d*)   with   c_k·(d - y) >= -β_k,  β_k >= 0,
/// by projected Gauss-Seidel on accumulated impulses λ_k >= 0, |λ_t| <= μ λ_n.
///
/// Linear momentum of free particles is kept, and Σ m x_t0 × d too: a contact's impulse at its time
/// of impact has a torque about x_t0, rel(x_t0) × n, which the group takes up as a whole. Σ m|d|²
/// never grows; where anchors move, Σ m|d - y|² does not.
///
/// Deviations: [Harmon2008] asks for c·d = 0 of all contacts of a zone; here contacts may open, and
/// may close by what their gap can spare. The paper has neither friction nor the term for torque.
class InelasticProjection {
 public:
  explicit InelasticProjection(const InelasticProjectionConfig& config = {}) : config_(config) {}

  /// `x_t1`: where the particles would end.
  void begin(const ResponseStep& step, std::span<const Vec3> x_t1);
  /// Collisions that are to be undone; those of earlier calls stay.
  void add(std::span<const ContactPoint> hits);
  /// Writes where the particles of all collisions so far end. What collides then is for another
  /// add.
  void apply(std::span<Vec3> x_t1);

 private:
  struct Row {
    ContactPoint point;
    Mat3 direction = Mat3::Zero();     // columns: normal, then two tangents
    Mat3 torque = Mat3::Zero();        // rel(x_t0) × direction
    Mat3 spin = Mat3::Zero();          // what the group takes up of a unit impulse
    std::array<double, 3> yielding{};  // how far a unit impulse moves the contact
    Vec3 impulse = Vec3::Zero();       // accumulated, along the directions
    Vec3 anchors = Vec3::Zero();       // Σ weight·(d - y) of its anchors
    double allowed = 0.0;              // β
    int repeats = 0;
    std::int32_t group = -1;
  };
  struct Group {
    ReferenceMotion motion;
    Mat3 mobility = Mat3::Zero();  // inverse inertia of a free group, 0 of one with anchors
    Vec3 spin = Vec3::Zero();      // Ω that torques have made
    bool at_rest = true;           // β counts from y: its parts move as one piece
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
  std::vector<int> count_;    // contacts of a particle in this call of add
  std::vector<Vec3> wish_;    // d*, of the particles
  std::vector<Vec3> moving_;  // d - y without the groups' spin
  std::vector<Row> rows_;
  std::vector<Group> groups_;
};

}  // namespace selvedge
