// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/body.h>
#include <selvedge/broadphase/broad_phase.h>

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace selvedge {

/// From when to when a step goes, in seconds of the bodies' motions.
struct StepTimes {
  double t0 = 0.0, t1 = 0.0;
};

/// The broad phase of cloth against the bodies of a scene. Bodies are searched in groups, each by a
/// detector of its own: those that never move together, for one tree that is made once; each large
/// one that moves rigidly for itself, in its own frame, so that its tree is made once as well; the
/// others together, whose tree is fitted to each step in which one of them moves. In the frame of a
/// rigid body other boxes overlap than in the world: the pairs are others, and none less that
/// collides or comes near.
class BodySearch {
 public:
  using Make = std::function<std::unique_ptr<BroadPhase>()>;

  /// `bodies` must outlive it. `cloth_triangles`: how many triangles the cloth has.
  BodySearch(std::span<const std::unique_ptr<Body>> bodies, std::size_t cloth_triangles,
             const Make& make);

  /// The step to look at: positions of the vertices of all bodies, one body after another. The
  /// spans must stay alive. `times`: positions are those of the bodies at these times; without them
  /// nothing more is known than that any body may `move`.
  void set_motion(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1, bool move,
                  const std::optional<StepTimes>& times);

  /// Pairs of the cloth and the bodies, indices of vertices, edges and triangles counted over all
  /// bodies (edges as unique_edges lists them). Particles may end off their place by `margin` in
  /// each coordinate; bodies have this `thickness`.
  void find_pairs(const SurfaceView& cloth, double margin, double thickness, CandidatePairs& out);

  /// How many groups there are, and how many of them are one body that moves rigidly.
  std::size_t groups() const { return groups_.size(); }
  std::size_t rigid_groups() const;

 private:
  /// Bodies that are searched together. Their own numbering is by order in the joint one.
  struct Group {
    std::unique_ptr<BroadPhase> detector;
    std::vector<std::size_t> bodies;
    std::vector<std::int32_t> vertices, edges, triangles;  ///< in the joint numbering
    std::vector<Edge> own_edges;
    std::vector<Triangle> own_triangles;
    std::vector<Vec3> x_t0, x_t1;  ///< of own vertices; unused where the group is all there is
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
  static void renumber(const Group& group, CandidatePairs& pairs);

  std::span<const std::unique_ptr<Body>> bodies_;
  std::vector<std::int32_t> vertex_begin_, triangle_begin_;  ///< of each body, plus the total
  std::vector<Edge> joint_edges_;
  std::vector<Group> groups_;
  std::span<const Vec3> x_t0_, x_t1_;
  CandidatePairs found_;
};

}  // namespace selvedge
