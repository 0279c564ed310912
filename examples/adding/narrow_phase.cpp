// SPDX-License-Identifier: MIT
// Takes two primitives for colliding if they nearly touch at one of several instants of the step.
#include "additions.h"

#include <selvedge/narrowphase/distance.h>

namespace adding {
namespace {

using namespace selvedge;

class Sampled final : public NarrowPhase {
 public:
  Sampled(int samples, double tolerance) : samples_(samples), tolerance_(tolerance) {}

  void find_times(std::span<const Query> queries, std::span<double> toi) const override {
    for (std::size_t i = 0; i < queries.size(); ++i) toi[i] = first_time(queries[i]);
  }

  NarrowPhaseTraits traits() const override {
    return {
        .source = "docs/adding.md",
        .limits = "Misses what happens between two samples; reports pairs that only come near."};
  }

 private:
  double first_time(const Query& query) const {
    for (int k = 0; k <= samples_; ++k) {
      const double t = static_cast<double>(k) / samples_;
      std::array<Vec3, 4> x;
      for (int i = 0; i < 4; ++i) x[i] = (1.0 - t) * query.x_t0[i] + t * query.x_t1[i];
      const ClosestPoints closest = query.kind == ContactKind::edge_edge
                                        ? edge_edge_closest(x[0], x[1], x[2], x[3])
                                        : point_triangle_closest(x[0], x[1], x[2], x[3]);
      if (closest.distance <= tolerance_) return t;
    }
    return kNoCollision;
  }

  int samples_;
  double tolerance_;
};

}  // namespace

void register_sampled(NarrowPhaseRegistry& registry) {
  registry.add("sampled",
               {{.name = "samples",
                 .initial = 64.0,
                 .unit = "1",
                 .least = 1.0,
                 .most = 1e6,
                 .kind = OptionKind::whole,
                 .meaning = "instants of a step; more miss less and cost more"},
                {.name = "tolerance",
                 .initial = 1e-3,
                 .unit = "m",
                 .least = 0.0,
                 .meaning = "distance that counts as a collision"}},
               [](const MethodOptions& o) {
                 return std::make_unique<Sampled>(o.whole("samples"), o["tolerance"]);
               });
}

}  // namespace adding
