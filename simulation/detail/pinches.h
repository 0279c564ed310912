// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/solver/strain_limiter.h>
#include <selvedge/simulation/contacts/detail/detection.h>
#include <selvedge/simulation/simulation_state.h>

#include <map>
#include <optional>
#include <span>
#include <vector>

namespace selvedge::detail {

struct StepInput;

/// Throws std::invalid_argument for a pinch of a vertex or a triangle that does not exist.
void refuse_bad_pinches(std::span<const Pinch> pinches, std::size_t vertices,
                        std::size_t triangles);

/// Cloth between surfaces of bodies that leave it less than a tenth of its rest gap. No contact can
/// keep it apart from both, and how hard they press it is not known: it depends on the gap alone.
/// Such a vertex is held between the two surfaces as if it were a handle, so that it carries all
/// that hangs from it. Across the surfaces it keeps its share of the room. Along them it follows
/// the surface with the greater friction, or the mean of both: where they shear, the weaker
/// friction slips. Where this would take the cloth far beyond its strain limit, as in the bend of
/// an elbow whose skin folds inwards, it slips along them. It is free as soon as the room exceeds a
/// tenth of its rest gap, or it is no longer between the surfaces.
class Pinches {
 public:
  explicit Pinches(const Detection& detection) : detection_(detection) {}

  /// Holds the pinched vertices of a step: as held particles of `in`, with their ends in x_t1, m,
  /// joint. Removes from `pinches` those that the step frees.
  void hold(StepInput& in, std::span<Vec3> x_t1, std::vector<Pinch>& pinches);
  /// Adds the free vertices that bodies come to pinch by the end of the step, from the contacts at
  /// its start, and, if bodies may cross the triangles around pinched vertices, those that bodies
  /// run over. Returns whether there are any.
  bool add(const StepInput& in, std::span<const ContactPoint> contacts, std::span<const Vec3> x_t1,
           std::vector<Pinch>& pinches, bool may_cross);

  /// Before the first attempt of a length: nothing slips.
  void begin_attempt();
  /// After an attempt whose held pinches strain springs far beyond their limits: finds how far they
  /// slip along the surfaces by the end of the step, x_t1 in m, joint. Returns whether any does;
  /// then the attempt has to begin again.
  bool slip(const StrainLimiter& measures, const StepInput& in, std::span<const Vec3> x_t1);

  /// After a rejected attempt with these pairs that still collide: layers of cloth whose held
  /// pinches would pass through each other move together. Returns whether there are any; then the
  /// attempt has to begin again.
  bool join(std::span<const ContactPoint> collisions, const StepInput& in,
            std::span<const Vec3> x_t1);

  /// Drops contacts of the neighbours of pinched vertices with points of a body that the cloth
  /// between both passes far nearer: they push along the cloth, away from a rim that it leaves, and
  /// would stretch it.
  void drop_along(const StepInput& in, std::span<const Pinch> pinches,
                  std::vector<ContactPoint>& contacts);
  /// The rest gap from bodies grows along the cloth from nothing at a pinched vertex, with a slope
  /// that hardly stretches the cloth. With a whole rest gap right beside the pinch it would be bent
  /// there.
  void taper(const StepInput& in, std::span<const Pinch> pinches,
             std::vector<ContactPoint>& contacts);

  /// Where bodies may cross the triangles around pinched vertices, the cloth leaves the surfaces
  /// straight, as from a clamp: appends contacts of the neighbours of pinched vertices with the
  /// planes of the two surfaces, if neither reaches to them. Otherwise a neighbour would
  /// bend around the rim of a surface that its triangles pass through, and cross it for good.
  void guide(const StepInput& in, std::span<const Pinch> pinches, std::vector<ContactPoint>& out);

 private:
  struct Grip;
  /// Where the surfaces take a vertex.
  struct Place {
    Vec3 point;          // m
    Vec3 across;         // the direction across the surfaces
    bool rises = false;  // out of one of them, that the other has lost
  };
  struct Held {
    std::int32_t vertex;
    Vec3 across;
    double rest_gap;  // m
  };
  struct Slip {
    std::int32_t vertex;
    Vec3 way;  // m
  };
  const JointSurface& surface();
  static std::optional<Place> rise(const Grip& left, double h);
  static std::optional<Place> between(const std::array<Grip, 2>& grip, double share);
  Grip grip_of(const Pinch& pinch, int side, const StepInput& in, std::span<const Vec3> x_t1);
  bool is_over(Pinch pinch, const Vec3& x, std::span<const Vec3> x_t1);
  void enter(const StepInput& in, std::span<const Vec3> x_t1, std::vector<Pinch>& pinches);
  std::optional<Vec3> step_beside(std::int32_t v, const StepInput& in, std::span<const Vec3> x_t1,
                                  std::span<const Pinch> pinches,
                                  const std::map<std::int32_t, Vec3>& rising);
  void slide(const StepInput& in, std::span<Vec3> x_t1, std::span<const Pinch> pinches,
             std::map<std::int32_t, Vec3> rising);
  std::optional<Place> end(Pinch& pinch, const StepInput& in, std::span<const Vec3> x_t1);
  bool find_foot(Pinch& pinch, int side, const Vec3& x, std::span<const Vec3> x_t0);
  std::int32_t nearest_around(std::int32_t triangle, const Vec3& x, const Vec3& normal,
                              std::span<const Vec3> x_t0);
  std::map<std::int32_t, double> distances(const StepInput& in, std::span<const Pinch> pinches,
                                           double reach);
  bool passes_nearer(const ContactPoint& c, int particles, const StepInput& in,
                     std::span<const Pinch> pinches);
  void guide(std::int32_t neighbour, const Pinch& pinch, const StepInput& in,
             std::vector<ContactPoint>& out);
  std::int32_t triangle_of(const ContactPoint& c);
  std::optional<Pinch> pinch_of(std::span<const ContactPoint> contacts, const StepInput& in,
                                std::span<const Vec3> x_t1);
  bool slip_to(std::span<const Vec3> x, const StepInput& in, std::span<const Vec3> x_t1);
  std::int32_t group_of(std::int32_t vertex) const;
  void unite(std::span<const ContactPoint> collisions, std::size_t n);
  const Vec3* slip_of(std::int32_t vertex) const;
  bool strains_far(const StrainLimiter& measures, std::span<const Vec3> x) const;
  bool slip_once(const StrainLimiter& measures, std::span<const double> inv_mass,
                 std::span<Vec3> x) const;

  const Detection& detection_;
  std::optional<JointSurface> surface_;  // made when first needed
  std::vector<Held> held_;               // of the present attempt, by vertex
  std::vector<Slip> slips_;              // by vertex
  std::vector<Vec3> across_;             // of each particle; zero: not pinched
  std::vector<std::int32_t> group_;      // of each particle; empty: each one is alone
  int slipped_ = 0;                      // times, in attempts of the present length
};

}  // namespace selvedge::detail
