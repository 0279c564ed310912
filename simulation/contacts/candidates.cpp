// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/simulation/contacts/detail/candidates.h>
#include <selvedge/simulation/contacts/detail/contacts.h>

#include <algorithm>
#include <limits>
#include <numbers>

namespace selvedge::detail {
namespace {

constexpr const char* kBroadPhaseKey = "contact.broad_phase";

std::unique_ptr<BroadPhase> make_broad_phase(const Scene& scene, const Methods& methods) {
  return make_method(methods.broad_phases, scene.contact.broad_phase, kBroadPhaseKey,
                     scene.contact.broad_phase_options);
}

constexpr std::size_t kCoverGrain = 2048;  // particles per task

// Share of the margin that ends may use; the rest is for rounding.
constexpr double kOfMargin = 1.0 - 0x1p-20;

/// How far particles end beyond what was searched, per coordinate, at most, m.
struct Beyond {
  Vec3 low = Vec3::Constant(-std::numeric_limits<double>::infinity()), high = low;
};

// Beyond the ends `searched`, or, if boxes were compared, beyond the boxes of the starts and these
// ends: a particle that ends in its box, grown by the margin, has its own box in it, and so have
// edges and triangles.
Beyond beyond(const SceneMotion& motion, std::span<const Vec3> searched, bool boxes) {
  const auto x_t0 = motion.cloth_t0(), x_t1 = motion.cloth_t1();
  std::vector<Beyond> parts((x_t1.size() + kCoverGrain - 1) / kCoverGrain);
  parallel_for(x_t1.size(), kCoverGrain, [&](std::size_t begin, std::size_t end) {
    Beyond& most = parts[begin / kCoverGrain];
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 low = boxes ? searched[i].cwiseMin(x_t0[i]) : searched[i];
      const Vec3 high = boxes ? searched[i].cwiseMax(x_t0[i]) : searched[i];
      most.low = most.low.cwiseMax(low - x_t1[i]);
      most.high = most.high.cwiseMax(x_t1[i] - high);
      if (!x_t1[i].allFinite()) most.low.setConstant(std::numeric_limits<double>::infinity());
    }
  });
  Beyond most;
  for (const Beyond& part : parts) {
    most.low = most.low.cwiseMax(part.low);
    most.high = most.high.cwiseMax(part.high);
  }
  return most;
}

}  // namespace

Candidates::Candidates(const SearchContext& context, const Scene& scene, const BuiltScene& built,
                       const Methods& methods)
    : context_(context),
      margin_(context.rest_gap),
      self_margin_(0.5 * kPointReach * context.rest_gap),
      broad_self_(make_broad_phase(scene, methods)),
      body_search_(built.bodies, built.cloth.surface.triangles.size(),
                   [&] { return make_broad_phase(scene, methods); }),
      excluded_surfaces_(scene, built, context.motion) {
  const BroadPhaseTraits traits = broad_self_->traits();
  has_all_pairs_ = traits.guarantee == Guarantee::conservative && !traits.closed_body_only;
  answers_particles_ = traits.particles;
  substitutes_self_ = !traits.self;
  if (substitutes_self_) broad_self_ = selvedge::make_bvh_aabb();
  loose_.assign(context.motion.particles(), 1);
  for (const Triangle& t : context.motion.cloth_triangles())
    for (const std::int32_t i : t) loose_[i] = 0;
  if (std::find(loose_.begin(), loose_.end(), 1) == loose_.end()) loose_.clear();
}

void Candidates::set_motion(const std::optional<StepTimes>& times) {
  certificates_.clear();
  const SceneMotion& motion = context_.motion;
  body_search_.set_motion(motion.bodies_t0(), motion.bodies_t1(), motion.bodies_move(), times);
}

// Particles may end up to the margin from the searched end in each coordinate. Boxes are inflated
// by that; a detector that culls by distance must be given the diagonal.
double Candidates::self_inflation() const {
  return broad_self_->traits().pairs == PairSet::culled ? std::numbers::sqrt3 * self_margin_
                                                        : self_margin_;
}

void Candidates::find_with_bodies() {
  const SceneMotion& motion = context_.motion;
  {
    const auto scope = context_.clock.measure("plan");
    bodies_idle_ =
        excluded_surfaces_.all_bodies() ||
        context_.plan.bodies_are_idle(motion.cloth_t0(), motion.cloth_t1(), motion.bodies_t0(),
                                      motion.bodies_t1(), motion.bodies_move());
  }
  searched_.assign(motion.cloth_t1().begin(), motion.cloth_t1().end());
  search_bodies();
}

void Candidates::find_with_self() {
  const SceneMotion& motion = context_.motion;
  {
    const auto scope = context_.clock.measure("plan");
    self_idle_ = !context_.self || context_.plan.self_is_idle(motion.cloth_t0(), motion.cloth_t1());
  }
  search_self();
}

void Candidates::search_bodies() {
  certificates_.clear(false);
  body_pairs_.clear();
  particle_contacts_.clear();
  if (bodies_idle_) return;
  const auto scope = context_.clock.measure("broad_phase");
  const PhaseClock::Scope busy(context_.plan.busy_bodies());
  // Every cloth box grows by the margin on each side; two cloth particles may both use theirs.
  body_search_.find_pairs(context_.motion.cloth(0.0), margin_, 0.5 * context_.rest_gap,
                          body_pairs_);
  drop_loose(body_pairs_);
  drop_excluded(body_pairs_, false);
  if (answers_particles_) search_particles();
}

// The pairs of the contacts pass the same filters as all other pairs.
void Candidates::search_particles() {
  body_search_.find_particle_contacts(context_.motion.cloth(0.0), kPointReach * context_.rest_gap,
                                      particle_contacts_);
  CandidatePairs kept;
  for (const ParticleContact& c : particle_contacts_) kept.point_triangle.push_back(c.pair);
  std::sort(kept.point_triangle.begin(), kept.point_triangle.end());
  drop_loose(kept);
  drop_excluded(kept, false);
  std::erase_if(particle_contacts_, [&](const ParticleContact& c) {
    return !std::binary_search(kept.point_triangle.begin(), kept.point_triangle.end(), c.pair);
  });
}

void Candidates::search_self() {
  certificates_.clear(true);
  self_pairs_.clear();
  if (self_idle_) return;
  const auto scope = context_.clock.measure("broad_phase");
  const PhaseClock::Scope busy(context_.plan.busy_self());
  broad_self_->find_self_pairs(drifting_view(), self_pairs_);
  if (substitutes_self_) ++substituted_self_searches_;
  drop_loose(self_pairs_);
  drop_excluded(self_pairs_, true);
}

void Candidates::find() {
  find_with_bodies();
  find_with_self();
}

bool Candidates::renew() {
  const bool bodies = cover_bodies(), self = cover_self();
  if (!bodies) find_with_bodies();
  if (!self) find_with_self();
  return !bodies || !self;
}

// Particles of no triangle (the centre of a supported body, a sparse layer) are not part of a
// surface. Only some broad phases leave them out.
void Candidates::drop_loose(CandidatePairs& pairs) const {
  if (loose_.empty()) return;
  std::erase_if(pairs.point_triangle,
                [&](const PointTrianglePair& pair) { return loose_[pair.point] != 0; });
}

void Candidates::drop_excluded(CandidatePairs& pairs, bool self) const {
  excluded_surfaces_.drop(pairs, self);
  if (excluded_ == nullptr || excluded_->empty()) return;
  if (self)
    excluded_->drop_from_self(pairs);
  else
    excluded_->drop_from_body(pairs);
}

// The cloth without the displacement that all its particles share. Whether two of them meet does
// not depend on that displacement, and without it the boxes of a fast sheet do not all overlap. The
// subtraction rounds by parts of the position in 10^16, which the margin covers.
SurfaceView Candidates::drifting_view() {
  const auto x_t0 = context_.motion.cloth_t0(), x_t1 = context_.motion.cloth_t1();
  const std::size_t particles = x_t0.size();
  Vec3 drift = Vec3::Zero();
  for (std::size_t i = 0; i < particles; ++i) drift += x_t1[i] - x_t0[i];
  drift /= static_cast<double>(std::max<std::size_t>(particles, 1));
  drifting_.resize(particles);
  for (std::size_t i = 0; i < particles; ++i) drifting_[i] = x_t1[i] - drift;
  SurfaceView view = context_.motion.cloth(self_inflation());
  view.x_t1 = drifting_;
  return view;
}

bool Candidates::cover_bodies() const {
  if (context_.motion.body_vertices() == 0) return true;
  const bool boxes = bodies_idle_ || body_search_.compares_boxes();
  const Beyond most = beyond(context_.motion, searched_, boxes);
  return (most.low.cwiseMax(most.high).array() <= kOfMargin * margin_).all();
}

// There is a displacement of all particles together after which each is within the margin.
bool Candidates::cover_self() const {
  if (self_idle_) return true;  // see prove_again
  const bool boxes = broad_self_->traits().pairs != PairSet::culled;
  const Beyond most = beyond(context_.motion, drifting_, boxes);
  return ((most.low + most.high).array() <= 2.0 * kOfMargin * self_margin_).all();
}

void Candidates::prove_again() {
  if (!context_.self || !self_idle_) return;
  {
    const auto scope = context_.clock.measure("plan");
    self_idle_ =
        context_.plan.self_stays_idle(context_.motion.cloth_t0(), context_.motion.cloth_t1());
  }
  search_self();
}

}  // namespace selvedge::detail
