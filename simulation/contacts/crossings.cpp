// SPDX-License-Identifier: MIT
#include <selvedge/simulation/contacts/detail/crossings.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace selvedge::detail {
namespace {

/// A way in which the cloth meets a body or itself.
struct Fault {
  const Crossings::Pairs* pairs;
  bool cross, body;
};

/// The first list with a pair; crossings come before touches, and bodies before the cloth itself.
Fault worst_of(const Crossings& found) {
  const std::array<Fault, 4> faults{{{&found.body.crossings, true, true},
                                     {&found.self.crossings, true, false},
                                     {&found.body.touches, false, true},
                                     {&found.self.touches, false, false}}};
  return *std::find_if(faults.begin(), faults.end() - 1,
                       [](const Fault& f) { return !f.pairs->empty(); });
}

std::string count_and_first(const Fault& fault) {
  const Crossings::Pairs& pairs = *fault.pairs;
  const std::string verb = fault.cross ? "cross" : "touch";
  return (pairs.size() == 1 ? "1 pair of triangles " + verb + "es"
                            : std::to_string(pairs.size()) + " pairs of triangles " + verb) +
         ", the first is triangle " + std::to_string(pairs[0].triangle_a) +
         " of the cloth and triangle " + std::to_string(pairs[0].triangle_b) + " of " +
         (fault.body ? "the bodies" : "the cloth");
}

bool have_common_edge(const Triangle& a, const Triangle& b) {
  return std::count_if(a.begin(), a.end(), [&](std::int32_t v) {
           return std::find(b.begin(), b.end(), v) != b.end();
         }) >= 2;
}

}  // namespace

std::string Crossings::sentence() const { return count_and_first(worst_of(*this)); }

void refuse_crossings(const Crossings& found, bool self) {
  Crossings refused = found;
  if (!self) refused.self = {};
  if (refused.empty()) return;
  const Fault fault = worst_of(refused);
  throw std::invalid_argument(
      std::string("the cloth ") + (fault.cross ? "crosses " : "touches ") +
      (fault.body ? "a body" : "itself") + " at the start: " + count_and_first(fault) +
      "; move the pieces apart, or mend the mesh (`selvedge check` names the pairs)");
}

void refuse_folded(const Crossings& found, std::span<const Triangle> cloth) {
  for (const Crossings::Pairs* pairs : {&found.self.crossings, &found.self.touches})
    for (const auto& [a, b] : *pairs)
      if (have_common_edge(cloth[a], cloth[b]))
        throw std::invalid_argument(
            "triangles " + std::to_string(a) + " and " + std::to_string(b) +
            " of the cloth have an edge in common and lie on each other at the start, so nothing "
            "can untangle them; mend the mesh");
}

CrossingSearch::CrossingSearch(const SearchContext& context) : context_(context) {}

SurfaceView CrossingSearch::bodies() const {
  SurfaceView view = context_.motion.bodies(0.0);
  view.static_id = 0;
  return view;
}

void CrossingSearch::find_with_bodies(TriangleMeetings& found) {
  const SceneMotion& motion = context_.motion;
  if (motion.body_triangles().empty() ||
      context_.plan.bodies_are_uncrossed(motion.cloth_t0(), motion.bodies_t0()))
    return;
  const PhaseClock::Scope busy(context_.plan.busy_crossings_bodies());
  triangles_.find(motion.cloth(0.0), bodies(), found);
}

// The proof is about primitives without a common vertex. It says nothing of doubled triangles,
// which have none.
void CrossingSearch::find_with_self(TriangleMeetings& found) {
  const SceneMotion& motion = context_.motion;
  const SurfaceView cloth = motion.cloth(0.0);
  if (context_.plan.self_is_uncrossed(motion.cloth_t0())) {
    triangles_.find_folded(cloth, found);
    return;
  }
  const PhaseClock::Scope busy(context_.plan.busy_crossings_self());
  triangles_.find_self(cloth, found);
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

}  // namespace selvedge::detail
