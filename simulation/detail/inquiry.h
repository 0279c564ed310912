// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/internal/explain_step.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/step_report.h>

#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace selvedge::detail {

/// A contact of a body with the cloth somewhere along the chain of contacts.
struct Front {
  ContactPoint contact;
  int body_side;        ///< primitive of the contact, 0 or 1, that belongs to the body
  std::size_t body;     ///< owner index
  std::int32_t vertex;  ///< the cloth vertex with the largest weight in the contact
  Vec3 towards_cloth;   ///< unit
  double push;          ///< m, motion of the body towards the cloth in the attempt
};

/// Two fronts that approach each other with the cloth between them.
struct Jaws {
  const Front *a, *b;
  double nearing, room;  ///< m
};

/// What an inquiry reads. `attempt` may lack its stages and its solve: then forces are unknown.
struct InquiryFacts {
  const Scene& scene;
  const VertexNames& names;
  const RejectedAttempt& failed;
  const RecordedAttempt& attempt;
  std::span<const Vec3> v;  ///< m/s, of the particles at the start of the step
  std::span<const Triangle> triangles;
};

/// Finds the causes of a rejected attempt. inquiry.cpp follows the contacts and the forces,
/// inquiry_culprits.cpp names the causes, explain_step.cpp follows single pairs through the stages.
class Inquiry {
 public:
  explicit Inquiry(const InquiryFacts& facts);

  Explanation explain();
  /// The first cause and what helps, in one sentence. For an attempt with colliding pairs.
  std::string blame() const;

 private:
  bool is_cloth(std::int32_t v) const { return static_cast<std::size_t>(v) < particles_; }
  bool is_held(std::int32_t v) const { return is_cloth(v) && attempt_.inv_mass[v] <= 0.0; }
  Vec3 moved(std::int32_t v) const { return failed_.x_t1[v] - failed_.x_t0[v]; }

  void note_handles();
  std::string handle_name(std::int32_t vertex) const;
  std::set<std::int32_t> offenders() const;
  std::vector<ContactPoint> all_contacts() const;
  Front front_of(const ContactPoint& c, int body_side) const;
  /// Contacts of bodies with the chain of contacts, breadth first from the particles that collide,
  /// through all layers of cloth.
  std::vector<Front> fronts() const;
  /// Displacement, m, above which a particle counts as moved; smaller ones are rounding errors.
  double threshold() const;
  /// Forces on a particle in the last solve: the contact forces, summed for each owner of the other
  /// side, and the force of its neighbours in the cloth.
  std::vector<Load> loads_at(std::int32_t vertex) const;
  /// Force, N, of the cloth's own springs and bending on a particle in the last solve: mass times
  /// acceleration minus weight and contact forces.
  Vec3 neighbours_force(std::int32_t v) const;
  /// The held particle that is the fewest edges away from `start`, and the number of edges; -1 if
  /// no held particle is connected.
  std::pair<std::int32_t, int> nearest_held(std::int32_t start) const;

  void find_culprits(std::vector<Culprit>& culprits) const;
  std::map<std::pair<std::size_t, std::size_t>, std::vector<Jaws>> closing_jaws(
      const std::vector<Front>& found) const;
  /// Bodies, or parts of one body, that approach each other with the cloth between them. For each
  /// pair of owners, reports the place with the least room among those of the fastest approach.
  void add_squeezes(const std::vector<Front>& found, std::vector<Culprit>& culprits) const;
  Culprit squeeze(const Front& a, const Front& b, double nearing, double room) const;
  /// Bodies that move into the cloth and do not squeeze it against another body.
  void add_pushes(const std::vector<Front>& found, std::vector<Culprit>& culprits) const;
  /// Held particles that their own handle carries into another primitive.
  void add_carriers(std::vector<Culprit>& culprits) const;
  /// A colliding particle, a vertex of the other primitive, and the force, N, with which its
  /// neighbours pull it there.
  struct Pulled {
    std::int32_t vertex = -1, other = -1;
    double force = 0.0;
  };
  /// The one that its neighbours pull hardest into the other primitive.
  Pulled hardest_pulled() const;
  /// The handle at that particle.
  void add_pulls(std::vector<Culprit>& culprits) const;
  /// A pair that collides although no body and no handle moves.
  Culprit meeting(const ContactPoint& c) const;
  Culprit nowhere() const;

  PairExplanation explain_pair(const ContactPoint& c) const;
  PairStage pair_stage(const ContactPoint& c, const std::string& name, const std::vector<Vec3>& x,
                       const std::vector<Vec3>* before) const;

  const Scene& scene_;
  const VertexNames& names_;
  const RejectedAttempt& failed_;
  const RecordedAttempt& attempt_;
  std::span<const Vec3> v_;  // m/s
  std::span<const Triangle> triangles_;
  std::size_t particles_;
  std::vector<ContactLoad> loads_;
  std::map<std::int32_t, std::size_t> handle_;  // of held particles
  std::unique_ptr<NarrowPhase> exact_ = make_ccd_exact();
};

/// The contact point of the first (0) or second (1) primitive.
Vec3 point_of(const ContactPoint& c, int primitive, const std::vector<Vec3>& x);

}  // namespace selvedge::detail
