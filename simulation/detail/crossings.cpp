// SPDX-License-Identifier: MIT
#include <selvedge/simulation/detail/crossings.h>

#include <algorithm>
#include <stdexcept>

namespace selvedge {
namespace {

bool shares_vertex(const Triangle& a, const Triangle& b) {
  for (const std::int32_t i : a)
    for (const std::int32_t j : b)
      if (i == j) return true;
  return false;
}

std::string count_and_first(const Crossings::Pairs& pairs, const char* second) {
  return std::to_string(pairs.size()) + " pairs of triangles cross, the first is triangle " +
         std::to_string(pairs[0].first) + " of the cloth and triangle " +
         std::to_string(pairs[0].second) + " of " + second;
}

void sort_unique(Crossings::Pairs& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

}  // namespace

std::string Crossings::sentence() const {
  return body.empty() ? count_and_first(self, "the cloth") : count_and_first(body, "the bodies");
}

void refuse_crossings(const Crossings& found, bool self) {
  if (found.body.empty() && (!self || found.self.empty())) return;
  throw std::invalid_argument(
      std::string("the cloth crosses ") + (found.body.empty() ? "itself" : "a body") +
      " at the start: " + found.sentence() +
      "; move the pieces apart, or mend the mesh (`selvedge check` names the pairs)");
}

CrossingSearch::CrossingSearch(const SearchContext& context) : context_(context) {}

SurfaceView CrossingSearch::bodies() const {
  SurfaceView view = context_.motion.bodies(0.0);
  view.static_id = 0;
  return view;
}

void CrossingSearch::find_with_bodies(Crossings::Pairs& pairs) {
  const SceneMotion& motion = context_.motion;
  if (motion.body_triangles().empty() ||
      context_.plan.bodies_are_uncrossed(motion.cloth_t0(), motion.bodies_t0()))
    return;
  const PhaseClock::Scope busy(context_.plan.busy_crossings_bodies());
  const SurfaceView cloth = motion.cloth(0.0);
  test_.find(cloth, bodies(), found_);
  if (!found_.empty()) {
    const TrianglesOfEdges cloth_of(motion.cloth_edges(), motion.cloth_triangles());
    for (const auto& [edge, triangle] : found_)
      for (const std::int32_t t : cloth_of.at(edge)) pairs.emplace_back(t, triangle);
  }
  test_.find(bodies(), cloth, found_);
  if (!found_.empty()) {
    const TrianglesOfEdges body_of(motion.body_edges(), motion.body_triangles());
    for (const auto& [edge, triangle] : found_)
      for (const std::int32_t t : body_of.at(edge)) pairs.emplace_back(triangle, t);
  }
  sort_unique(pairs);
}

void CrossingSearch::find_with_self(Crossings::Pairs& pairs) {
  const SceneMotion& motion = context_.motion;
  if (context_.plan.self_is_uncrossed(motion.cloth_t0())) return;
  const PhaseClock::Scope busy(context_.plan.busy_crossings_self());
  test_.find_self(motion.cloth(0.0), found_);
  if (found_.empty()) return;
  const std::vector<Triangle>& triangles = motion.cloth_triangles();
  const TrianglesOfEdges cloth_of(motion.cloth_edges(), triangles);
  for (const auto& [edge, triangle] : found_)
    for (const std::int32_t t : cloth_of.at(edge))
      if (!shares_vertex(triangles[t], triangles[triangle]))
        pairs.emplace_back(std::min(t, triangle), std::max(t, triangle));
  sort_unique(pairs);
}

Crossings CrossingSearch::find() {
  Crossings crossings;
  find_with_bodies(crossings.body);
  find_with_self(crossings.self);
  return crossings;
}

std::vector<EdgeCrossing> CrossingSearch::find_edges() {
  const SceneMotion& motion = context_.motion;
  std::vector<EdgeCrossing> crossings;
  const auto edges = static_cast<std::int32_t>(motion.cloth_edges().size());
  const auto triangles = static_cast<std::int32_t>(motion.cloth_triangles().size());
  const SurfaceView cloth = motion.cloth(0.0);
  if (!motion.body_triangles().empty()) {
    test_.find(cloth, bodies(), found_);
    for (const auto& [e, t] : found_) crossings.push_back({e, t + triangles});
    test_.find(bodies(), cloth, found_);
    for (const auto& [e, t] : found_) crossings.push_back({e + edges, t});
  }
  if (context_.self) {
    test_.find_self(cloth, found_);
    for (const auto& [e, t] : found_) crossings.push_back({e, t});
  }
  std::sort(crossings.begin(), crossings.end());
  return crossings;
}

}  // namespace selvedge
