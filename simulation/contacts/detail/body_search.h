// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/body.h>
#include <selvedge/broadphase/broad_phase.h>

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Start and end of a step in the time of the bodies' motions, s.
struct StepTimes {
  double t0 = 0.0, t1 = 0.0;
};

/// The broad phase of cloth against the bodies of a scene. It searches the bodies in groups, each
/// with a detector of its own. A detector that answers particles gets one body, because one body
/// hides another in its pictures. For the others, all bodies that never move form one group, whose
/// tree is built once. Each large body that moves rigidly is a group, searched in its own frame, so
/// that its tree is built once as well. The other bodies form one group, whose tree is refitted in
/// each step in which one of them moves. The boxes that overlap in the frame of a rigid body differ
/// from those in the world, and so do the pairs; no pair that collides or comes near is lost.
class BodySearch {
 public:
  using Make = std::function<std::unique_ptr<BroadPhase>()>;

  /// `bodies` must outlive it. `cloth_triangles`: how many triangles the cloth has.
  BodySearch(std::span<const std::unique_ptr<Body>> bodies, std::size_t cloth_triangles,
             const Make& make);

  /// The step to search: positions of the vertices of all bodies, one body after another. The spans
  /// must stay alive. `times`: the bodies are where their motion has them at these times. Without
  /// times, any body may move if `move` is true.
  void set_motion(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1, bool move,
                  const std::optional<StepTimes>& times);

  /// Candidate pairs of the cloth and the bodies. Indices of vertices, edges and triangles count
  /// over all bodies (edges as unique_edges lists them). Particles may end up to `margin`, per
  /// coordinate, from their given ends; bodies have this `thickness`. Both in metres.
  void find_pairs(const SurfaceView& cloth, double margin, double thickness, CandidatePairs& out);

  /// Whether find_pairs compares boxes in the frame of the world in this step, not distances or
  /// boxes in the frame of a body.
  bool compares_boxes() const;

  /// Contacts of the cloth's particles, from detectors with traits().particles; indices as above.
  /// Sorted by body group, then by particle.
  void find_particle_contacts(const SurfaceView& cloth, double reach,
                              std::vector<ParticleContact>& out);

  /// Number of groups, and of those that are one rigidly moving body.
  std::size_t groups() const { return groups_.size(); }
  std::size_t rigid_groups() const;

 private:
  /// Bodies that are searched together. Own indices keep the order of the joint ones.
  struct Group {
    std::unique_ptr<BroadPhase> detector;
    std::vector<std::size_t> bodies;
    std::vector<std::int32_t> vertices, edges, triangles;  ///< in the joint numbering
    std::vector<Edge> own_edges;
    std::vector<Triangle> own_triangles;
    std::vector<Vec3> x_t0, x_t1;  ///< of own vertices; unused if there is only one group
    RigidMotion motion;
    std::uint64_t static_id = 1;
    bool is_rigid = false;  ///< one body that moves rigidly
    bool moves = true;      ///< in this step
    bool promises = false;  ///< `motion` is that of this step
  };

  void add_group(const Make& make, std::vector<std::size_t> bodies, bool is_rigid);
  void set_motion(Group& group, bool move, const std::optional<StepTimes>& times);
  void gather(Group& group) const;
  SurfaceView view(const Group& group, double thickness) const;
  static bool by_distance(const Group& group);
  static void renumber(const Group& group, CandidatePairs& pairs);

  std::span<const std::unique_ptr<Body>> bodies_;
  std::vector<std::int32_t> vertex_begin_, triangle_begin_;  ///< of each body, plus the total
  std::vector<Edge> joint_edges_;
  std::vector<Group> groups_;
  std::span<const Vec3> x_t0_, x_t1_;
  CandidatePairs found_;
  std::vector<ParticleContact> found_contacts_;
};

}  // namespace selvedge::detail
