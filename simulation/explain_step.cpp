// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/simulation/detail/inquiry.h>
#include <selvedge/simulation/internal/explain_step.h>

#include <algorithm>

namespace selvedge {
namespace detail {

Explanation Inquiry::explain() {
  Explanation explanation;
  explanation.h = attempt_.h;
  explanation.colliding_pairs = failed_.pairs.size();
  if (failed_.not_finite >= 0)
    explanation.culprits.push_back(nowhere());
  else
    find_culprits(explanation.culprits);
  for (std::size_t i = 0; i < std::min(failed_.pairs.size(), kExplainedPairs); ++i)
    explanation.pairs.push_back(explain_pair(failed_.pairs[i]));
  return explanation;
}

PairExplanation Inquiry::explain_pair(const ContactPoint& c) const {
  PairExplanation explanation;
  explanation.pair = c;
  explanation.name = names_.pair(c);
  const std::vector<Vec3>* before = nullptr;
  std::map<std::string, int> met;
  for (const RecordedStage& s : attempt_.stages) {
    const int which = ++met[s.name];
    std::string name = which == 1 ? s.name : fmt::format("{} {}", s.name, which);
    if (s.times > 1) name += fmt::format(" ({} times)", s.times);
    explanation.stages.push_back(pair_stage(c, name, s.x_t1, before));
    before = &s.x_t1;
  }
  explanation.stages.push_back(pair_stage(c, "last paths tested", failed_.x_t1, before));
  for (auto stage = explanation.stages.rbegin();
       stage != explanation.stages.rend() && stage->collides; ++stage)
    explanation.brought_by = stage->stage;
  return explanation;
}

PairStage Inquiry::pair_stage(const ContactPoint& c, const std::string& name,
                              const std::vector<Vec3>& x, const std::vector<Vec3>* before) const {
  PairStage stage{name};
  stage.gap = c.normal.dot(relative(c, x));
  Query query;
  query.kind = c.kind == ContactKind::edge_edge ? c.kind : ContactKind::point_triangle;
  bool finite = true;
  for (int k = 0; k < 4; ++k) {
    const std::int32_t v = c.vertex[k];
    stage.moved[k] = (x[v] - (before ? (*before)[v] : failed_.x_t0[v])).norm();
    query.x_t0[k] = failed_.x_t0[v];
    query.x_t1[k] = x[v];
    finite = finite && x[v].allFinite();
  }
  double toi = 0.0;
  stage.collides = finite && exact_->collides(query, toi);
  return stage;
}

}  // namespace detail

Explanation explain_step(const Scene& scene, const Simulation& simulation,
                         const RecordedAttempt& attempt) {
  return detail::Inquiry({scene, simulation.names(), simulation.last_step().rejected, attempt,
                          simulation.state().v, simulation.cloth_triangles()})
      .explain();
}

}  // namespace selvedge
