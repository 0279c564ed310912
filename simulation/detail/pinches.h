// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/simulation/detail/detection.h>
#include <selvedge/simulation/simulation.h>

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
/// friction slips. It is free as soon as the room exceeds a tenth of its rest gap, or it is no
/// longer between the surfaces.
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
  struct End;
  const JointSurface& surface();
  static std::optional<Vec3> rise(const Grip& left, double h);
  static std::optional<Vec3> between(const std::array<Grip, 2>& grip, double share);
  Grip grip_of(const Pinch& pinch, int side, const StepInput& in, std::span<const Vec3> x_t1);
  bool is_over(Pinch pinch, const Vec3& x, std::span<const Vec3> x_t1);
  void enter(const StepInput& in, std::span<const Vec3> x_t1, std::vector<Pinch>& pinches);
  std::optional<Vec3> step_beside(std::int32_t v, const StepInput& in, std::span<const Vec3> x_t1,
                                  std::span<const Pinch> pinches,
                                  const std::map<std::int32_t, Vec3>& rising);
  void slide(const StepInput& in, std::span<Vec3> x_t1, std::span<const Pinch> pinches,
             std::map<std::int32_t, Vec3> rising);
  std::optional<End> end(Pinch& pinch, const StepInput& in, std::span<const Vec3> x_t1);
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

  const Detection& detection_;
  std::optional<JointSurface> surface_;  // made when first needed
};

}  // namespace selvedge::detail
