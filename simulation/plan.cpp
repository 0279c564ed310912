// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/simulation/contacts/detail/excluded_surfaces.h>
#include <selvedge/simulation/contacts/detail/idle_proofs.h>
#include <selvedge/simulation/internal/plan.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace selvedge {
namespace {

using Status = PlanItem::Status;

/// Bounding box of a body at one time.
detail::SweptBox body_box(const Body& body, double time) {
  std::vector<Vec3> x(body.vertex_count());
  body.positions(time, x);
  return detail::swept_box(x, x);
}

double gap(const detail::SweptBox& a, const detail::SweptBox& b) {
  const Vec3 apart = (a.low - b.high).cwiseMax(b.low - a.high).cwiseMax(0.0);
  return apart.norm();
}

class ScenePlan {
 public:
  ScenePlan(const Scene& scene, const BuiltScene& built, const Methods& methods)
      : scene_(scene), built_(built), methods_(methods) {}

  std::vector<PlanItem> make() {
    add_forces();
    add_limits();
    add_self();
    add_bodies();
    add_contact();
    add_output();
    return std::move(items_);
  }

 private:
  void add(const std::string& part, Status status, const std::string& why) {
    items_.push_back({part, status, why});
  }

  void add_forces() {
    const ClothMesh& cloth = built_.cloth;
    add("springs", Status::runs, fmt::format("{} springs", cloth.springs.size()));
    if (!cloth.membranes.empty())
      add("finite elements", Status::runs,
          fmt::format("{} triangles carry stretch and shear; springs only measure strain",
                      cloth.membranes.size()));
    if (!cloth.yarns.empty())
      add("yarns", Status::runs,
          fmt::format("warp and weft of {} triangles carry stretch and shear; springs only measure "
                      "strain",
                      cloth.yarns.size()));
    const std::size_t bends = cloth.hinges.size() + cloth.links.size() + cloth.twists.size() +
                              cloth.beams.size() + cloth.of_laws.size();
    add("bending", bends > 0 ? Status::runs : Status::never,
        bends > 0 ? fmt::format("{} hinges, links, twists and beams", bends)
                  : "no bending stiffness: no hinges are built");
    if (!cloth.crossings.empty())
      add("yarns", Status::runs,
          fmt::format("{} right angles between crossing yarns", cloth.crossings.size()));
    const bool gravity = !scene_.gravity.isZero(0.0);
    add("gravity", gravity ? Status::runs : Status::never,
        gravity ? fmt::format("{:.4g} m/s²", scene_.gravity.norm()) : "gravity is zero");
    const bool air = scene_.air.normal_drag > 0.0 || scene_.air.viscous_drag > 0.0;
    add("wind and drag", air ? Status::runs : Status::never,
        air ? "a drag coefficient is above 0; triangle normals are computed for it"
            : "both drag coefficients are 0: wind exerts no force, and no normals are computed");
  }

  void add_limits() {
    if (!scene_.solver.strain_limiter)
      add("strain limit", Status::never, "solver.strain_limiter is off");
    else if (!scene_.plan.proofs)
      add("strain limit", Status::runs, "no proofs: plan.proofs is off");
    else
      add("strain limit", Status::when_needed,
          "left out while the particles have moved too little relative to each other, since the "
          "last measurement of the springs, to reach it");
    add("handles", scene_.handles.empty() ? Status::never : Status::runs,
        scene_.handles.empty() ? "no vertex is held"
                               : fmt::format("{} handle{}", scene_.handles.size(),
                                             scene_.handles.size() == 1 ? "" : "s"));
  }

  bool exact() const {
    const auto traits =
        methods_.narrow_phases.at(scene_.contact.narrow_phase)(scene_.contact.narrow_phase_options)
            ->traits();
    return traits.misses_nothing && traits.no_false_alarm;
  }

  /// Reason why the simulation makes no proofs; empty if it makes them.
  std::string unproved() const {
    if (!scene_.plan.proofs) return "plan.proofs is off";
    if (!exact())
      return scene_.contact.narrow_phase + " may raise false alarms, which belong to its result";
    return {};
  }

  void add_self() {
    const char* part = "cloth with itself";
    if (!scene_.contact.self) return add(part, Status::never, "contact.self is off");
    if (!detail::searches_self(scene_))
      return add(part, Status::never, "contact.pairs excludes all of it");
    if (const std::string why = unproved(); !why.empty())
      return add(part, Status::runs, "no proofs: " + why);
    for (std::size_t p = 0; p + 1 < built_.piece_begin.size(); ++p)
      if (const std::string why = unsuited(p); !why.empty())
        return add(part, Status::runs,
                   fmt::format("no proofs: piece {} {}", scene_.cloths[p].name, why));
    add(part, Status::when_needed,
        "left out of every step in which each piece is a height field whose points keep their "
        "distance, and pieces do not meet");
  }

  std::string unsuited(std::size_t piece) const {
    const std::int32_t begin = built_.piece_begin[piece], end = built_.piece_begin[piece + 1];
    std::vector<Triangle> triangles;
    for (const Triangle& t : built_.cloth.surface.triangles)
      if (t[0] >= begin && t[0] < end)
        triangles.push_back({t[0] - begin, t[1] - begin, t[2] - begin});
    const detail::SheetProof proof(
        std::span(built_.cloth.surface.vertices).subspan(begin, end - begin), triangles);
    if (!proof.applies()) return "is not flat and convex at its start";
    const double needed = 1.5 * scene_.contact.rest_gap;
    if (proof.nearest() <= needed)
      return fmt::format("has primitives {:.3g} m apart, too near for a rest gap of {:.3g} m",
                         proof.nearest(), scene_.contact.rest_gap);
    return {};
  }

  void add_bodies() {
    if (built_.bodies.empty()) return add("bodies", Status::never, "there are none");
    const auto& x = built_.cloth.surface.vertices;
    const detail::SweptBox cloth = detail::swept_box(x, x);
    const double end = scene_.time.frames / scene_.time.fps;
    for (std::size_t b = 0; b < built_.bodies.size(); ++b) {
      const Body& body = *built_.bodies[b];
      const bool still = body.is_static(0.0, end);
      const double apart = gap(cloth, body_box(body, 0.0));
      const std::string proof = unproved().empty()
                                    ? fmt::format(
                                          "left out while its swept box does not meet the cloth's "
                                          "({:.3g} m apart at the start{})",
                                          apart, still ? first_reach(apart, end) : "")
                                    : "no proofs: " + unproved();
      add("body " + scene_.bodies[b].name, unproved().empty() ? Status::when_needed : Status::runs,
          proof);
      add("tree of " + scene_.bodies[b].name, still ? Status::never : Status::runs,
          still ? "it never moves: its tree is built once and never refitted"
                : "it moves: a rigid body keeps its tree in its own frame, others are refitted");
    }
  }

  /// Time at which cloth in free fall could reach the body. This is no proof, since springs and air
  /// also drive cloth; every step makes its own proof.
  std::string first_reach(double apart, double end) const {
    const double g = scene_.gravity.norm();
    double v = 0.0;
    for (const Vec3& u : built_.velocity) v = std::max(v, u.norm());
    if (g == 0.0 && v == 0.0) return ", free flight never reaches it";
    if (apart == 0.0) return "";  // the boxes meet
    // apart = v t + ½ g t²
    const double t = 2.0 * apart / (v + std::sqrt(v * v + 2.0 * g * apart));
    return fmt::format(", free flight takes {:.2g} s of {:.3g} s", t, end);
  }

  /// Does nothing in scenes that exclude no pair.
  void add_excluded() {
    const ContactPairs pairs(scene_);
    if (!pairs.excluded().empty())
      add("excluded pairs of surfaces", Status::never,
          fmt::format("contact.pairs excludes {} of {}", pairs.excluded().size(), pairs.count()));
  }

  void add_contact() {
    add_excluded();
    const bool possible = scene_.contact.self || !built_.bodies.empty();
    add("response and friction", possible ? Status::when_needed : Status::never,
        possible ? "without contacts the solve has no contact terms"
                 : "there is nothing that the cloth could touch");
    add("fail-safe", possible ? Status::when_needed : Status::never,
        possible ? "runs only if pairs still collide after the response"
                 : "there is nothing that the cloth could touch");
    add("new candidates in a step", Status::when_needed,
        "candidates stay valid while particles end within the margin of the predicted motion");
    add("check of every frame", scene_.plan.proofs ? Status::when_needed : Status::runs,
        scene_.plan.proofs ? "its two searches are left out if the same proofs hold for the frame"
                           : "no proofs: plan.proofs is off");
    add("untangling", scene_.contact.untangle_start ? Status::when_needed : Status::never,
        scene_.contact.untangle_start ? "contact.start is \"untangle\""
                                      : "contact.start is \"refuse\"");
  }

  void add_output() {
    const std::vector<std::string> formats = scene_.output.all_formats();
    std::string names;
    for (const std::string& name : formats) names += (names.empty() ? "" : ", ") + name;
    add("other output formats", formats.empty() ? Status::never : Status::runs,
        formats.empty() ? "output.formats is empty" : "output: " + names);
  }

  const Scene& scene_;
  const BuiltScene& built_;
  const Methods& methods_;
  std::vector<PlanItem> items_;
};

}  // namespace

std::vector<PlanItem> plan_scene(const Scene& scene, const BuiltScene& built,
                                 const Methods& methods) {
  return ScenePlan(scene, built, methods).make();
}

namespace {

/// Below this speed, m/s, cloth that sleeps hardly moves on (docs/integrators.md, Sleep).
constexpr const char* kSlow = "0.02";

std::vector<Override> without_bending(const Scene& scene) {
  std::vector<Override> zeros;
  for (const auto& [name, material] : scene.materials) {
    if (material.bending_stiffness > 0.0)
      zeros.push_back({"materials." + name + ".bending_stiffness", "0"});
    if (material.bending_weft.value_or(0.0) > 0.0)
      zeros.push_back({"materials." + name + ".bending_weft", "0"});
  }
  return zeros;
}

std::vector<Override> without_shear(const Scene& scene) {
  std::vector<Override> zeros;
  for (const auto& [name, material] : scene.materials)
    if (material.shear_stiffness > 0.0)
      zeros.push_back({"materials." + name + ".shear_stiffness", "0"});
  return zeros;
}

std::vector<Override> without_friction(const Scene& scene) {
  std::vector<Override> zeros;
  const auto add = [&](const std::string& of) { zeros.push_back({of + ".friction", "0"}); };
  for (const auto& [name, material] : scene.materials)
    if (scene.contact.self && material.friction > 0.0) add("materials." + name);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    if (scene.bodies[b].friction > 0.0) add(fmt::format("obstacles.{}", b));
  for (std::size_t p = 0; p < scene.contact.pairs.size(); ++p)
    if (scene.contact.pairs[p].friction.value_or(0.0) > 0.0)
      add(fmt::format("contact.pairs.{}", p));
  return zeros;
}

}  // namespace

std::vector<OptionalPart> optional_parts(const Scene& scene) {
  std::vector<OptionalPart> parts;
  const auto add = [&](const char* part, std::vector<Override> overrides) {
    if (!overrides.empty()) parts.push_back({part, std::move(overrides)});
  };
  const bool collides = scene.contact.self || !scene.bodies.empty();
  if (scene.contact.self) add("self_collision", {{"contact.self", "false"}});
  if (collides) {
    add("friction", without_friction(scene));
    parts.push_back({"response", {}, true});
    parts.push_back({"frame_check", {}, true});
  }
  if (scene.solver.strain_limiter) add("strain_limit", {{"solver.strain_limiter", "false"}});
  add("shear", without_shear(scene));
  add("bending", without_bending(scene));
  if (scene.air.normal_drag > 0.0 || scene.air.viscous_drag > 0.0)
    add("air", {{"air.normal_drag", "0"}, {"air.viscous_drag", "0"}});
  if (scene.time.sleep_speed == 0.0) add("steps_at_rest", {{"time.sleep_speed", kSlow}});
  if (scene.time.step_error > 0.0) add("joined_steps", {{"time.step_error", "0"}});
  return parts;
}

}  // namespace selvedge
