// SPDX-License-Identifier: MIT
#include <selvedge/simulation/internal/explain_step.h>

#include <algorithm>
#include <map>
#include <utility>

namespace selvedge {
namespace {

/// Identifies both a term and the contact that it comes from.
using TermKey = std::pair<std::array<std::int32_t, 4>, std::array<double, 4>>;

TermKey key_of(const ContactPoint& c, std::size_t particles) {
  TermKey key{c.vertex, c.weight};
  for (std::int32_t& v : key.first)
    if (static_cast<std::size_t>(v) >= particles) v = -1;
  return key;
}

}  // namespace

StepRecording::StepRecording()
    : trace_{[this](const TracedAttempt& attempt) { begin(attempt); },
             [this](const TracedStage& s) { stage(s); }} {}

void StepRecording::begin(const TracedAttempt& attempt) {
  before_ = std::move(last_);
  last_ = {};
  last_.h = attempt.h;
  last_.x_t0.assign(attempt.x_t0.begin(), attempt.x_t0.end());
  last_.inv_mass.assign(attempt.inv_mass.begin(), attempt.inv_mass.end());
  last_.contacts.assign(attempt.contacts.begin(), attempt.contacts.end());
  last_.stages.push_back({"coasting", 1, {attempt.x_t1.begin(), attempt.x_t1.end()}});
}

void StepRecording::stage(const TracedStage& stage) {
  std::vector<RecordedStage>& stages = last_.stages;
  if (stages.back().name == stage.name)
    ++stages.back().times;
  else
    stages.push_back({stage.name, 1, {}});
  stages.back().x_t1.assign(stage.x_t1.begin(), stage.x_t1.end());
  if (stage.terms.empty()) return;
  last_.contacts.insert(last_.contacts.end(), stage.hits.begin(), stage.hits.end());
  last_.terms.assign(stage.terms.begin(), stage.terms.end());
  last_.v.assign(stage.v.begin(), stage.v.end());
}

std::vector<ContactLoad> RecordedAttempt::loads() const {
  std::map<TermKey, const ContactPoint*> known;
  for (const ContactPoint& c : contacts) known[key_of(c, v.size())] = &c;
  std::vector<ContactLoad> carried;
  for (const ImplicitTerm& term : terms) {
    const auto contact = known.find({term.particle, term.weight});
    if (contact == known.end()) continue;
    Vec3 motion = Vec3::Zero();
    for (int k = 0; k < 4; ++k)
      if (term.particle[k] >= 0) motion += term.weight[k] * v[term.particle[k]];
    carried.push_back({*contact->second, (term.rhs - term.matrix * motion) / h});
  }
  return carried;
}

}  // namespace selvedge
