// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/simulation/detail/validate_step.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace selvedge::detail {
namespace {

std::vector<char> on_surface(std::size_t vertices, std::span<const Triangle> triangles) {
  std::vector<char> on(vertices, 0);
  for (const Triangle& t : triangles)
    for (const std::int32_t v : t) on[v] = 1;
  return on;
}

SurfaceView cloth_view(const SearchedMotion& m, double thickness) {
  return {.x_t0 = m.x_t0.first(m.particles),
          .x_t1 = m.x_t1.first(m.particles),
          .edges = m.cloth_edges,
          .triangles = m.cloth_triangles,
          .thickness = thickness};
}

SurfaceView body_view(const SearchedMotion& m, double thickness) {
  return {.x_t0 = m.x_t0.subspan(m.particles),
          .x_t1 = m.x_t1.subspan(m.particles),
          .edges = m.body_edges,
          .triangles = m.body_triangles,
          .thickness = thickness};
}

ContactPoint joint(const Contact& contact, bool self, std::size_t particles) {
  ContactPoint c;
  c.kind = contact.kind;
  c.vertex = contact.vertex;
  c.weight = contact.weight;
  c.normal = contact.normal;
  c.gap = contact.gap;
  if (self) return c;
  const auto n = static_cast<std::int32_t>(particles);
  const int first = first_count(c);
  const bool point_of_body = contact.kind == ContactKind::triangle_point;
  for (int k = 0; k < 4; ++k)
    if ((k >= first) != point_of_body) c.vertex[k] += n;
  return c;
}

template <class Pair>
void subtract(std::vector<Pair>& from, const std::vector<Pair>& taken) {
  auto next = taken.begin();
  std::erase_if(from, [&](const Pair& pair) {
    next = std::lower_bound(next, taken.end(), pair);
    return next != taken.end() && *next == pair;
  });
}

void subtract(CandidatePairs& from, const CandidatePairs* taken) {
  if (taken == nullptr) return;
  subtract(from.point_triangle, taken->point_triangle);
  subtract(from.triangle_point, taken->triangle_point);
  subtract(from.edge_edge, taken->edge_edge);
}

void stop_if_any(const std::vector<ContactPoint>& pairs, const char* fault,
                 const VertexNames& names, long long step) {
  if (pairs.empty()) return;
  std::fprintf(stderr, "selvedge invariant broken in step %lld: %s: %zu, the first is %s\n", step,
               fault, pairs.size(), names.pair(pairs.front()).c_str());
  std::abort();
}

}  // namespace

StepValidator::StepValidator(const std::string& scene_broad_phase)
    : StepValidator(scene_broad_phase == "sweep_and_prune" ? make_uniform_grid()
                                                           : make_sweep_and_prune()) {}

StepValidator::StepValidator(std::unique_ptr<BroadPhase> broad)
    : broad_(std::move(broad)), exact_(make_ccd_exact()) {}

void StepValidator::find_pairs(const SearchedMotion& motion, double thickness, FreshPairs& out) {
  const SurfaceView cloth = cloth_view(motion, thickness), body = body_view(motion, thickness);
  const std::vector<char> of_cloth = on_surface(cloth.x_t0.size(), cloth.triangles);
  const std::vector<char> of_body = on_surface(body.x_t0.size(), body.triangles);
  out.body.clear();
  out.self.clear();
  if (!body.triangles.empty()) broad_->find_pairs(cloth, body, out.body);
  if (motion.self) broad_->find_self_pairs(cloth, out.self);
  for (CandidatePairs* pairs : {&out.body, &out.self})
    std::erase_if(pairs->point_triangle, [&](const auto& p) { return of_cloth[p.point] == 0; });
  std::erase_if(out.body.triangle_point, [&](const auto& p) { return of_body[p.point] == 0; });
  if (motion.excluded_surfaces != nullptr) {
    motion.excluded_surfaces->drop(out.body, false);
    motion.excluded_surfaces->drop(out.self, true);
  }
  if (motion.excluded == nullptr || motion.excluded->empty()) return;
  motion.excluded->drop_from_body(out.body);
  motion.excluded->drop_from_self(out.self);
}

std::vector<ContactPoint> StepValidator::colliding(const SearchedMotion& motion,
                                                   const FreshPairs& pairs) {
  const SurfaceView cloth = cloth_view(motion, 0.0), body = body_view(motion, 0.0);
  std::vector<ContactPoint> out;
  if (pairs.body.size() > 0) {
    exact_->find_contacts(cloth, body, pairs.body, found_);
    for (const Contact& c : found_) out.push_back(joint(c, false, motion.particles));
  }
  if (pairs.self.size() > 0) {
    exact_->find_contacts(cloth, cloth, pairs.self, found_);
    for (const Contact& c : found_) out.push_back(joint(c, true, motion.particles));
  }
  return out;
}

/// The last attempt of a step is nearly always the motion that is accepted: it is searched once.
void StepValidator::search(const SearchedMotion& motion) {
  if (motion.excluded == excluded_ && std::ranges::equal(motion.x_t0, x_t0_) &&
      std::ranges::equal(motion.x_t1, x_t1_))
    return;
  find_pairs(motion, 0.0, pairs_);
  x_t0_.assign(motion.x_t0.begin(), motion.x_t0.end());
  x_t1_.assign(motion.x_t1.begin(), motion.x_t1.end());
  excluded_ = motion.excluded;
}

std::vector<ContactPoint> StepValidator::collisions(const SearchedMotion& motion) {
  search(motion);
  return colliding(motion, pairs_);
}

std::vector<ContactPoint> StepValidator::missed(const SearchedMotion& motion) {
  search(motion);
  FreshPairs rest = pairs_;
  remove_candidates(motion, rest);
  return colliding(motion, rest);
}

void remove_candidates(const SearchedMotion& motion, FreshPairs& pairs) {
  subtract(pairs.body, motion.body_pairs);
  subtract(pairs.self, motion.self_pairs);
}

void validate_attempt(StepValidator& validator, const SearchedMotion& motion,
                      const VertexNames& names, long long step) {
  if (!motion.has_all_pairs) return;
  stop_if_any(validator.missed(motion), "pairs that collide are not among the candidates", names,
              step);
}

void validate_accepted(StepValidator& validator, const SearchedMotion& motion,
                       const VertexNames& names, long long step) {
  if (!motion.finds_all_collisions) return;
  stop_if_any(validator.collisions(motion), "pairs collide on the way of an accepted step", names,
              step);
}

}  // namespace selvedge::detail
