// SPDX-License-Identifier: MIT
#include <selvedge/core/parallel.h>
#include <selvedge/narrowphase/ccd_exact.h>
#include <selvedge/narrowphase/distance.h>
#include <selvedge/scene/detection.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace selvedge {
namespace {

// A pair farther apart than this many rest gaps at the start of a step is left to the collision
// test: its linearised gap would stop cloth that in truth passes beside.
constexpr double kProximityReach = 4.0;

// A point takes part from this many rest gaps on: cloth just outside its rest gap may be pulled in
// by its neighbours within the step.
constexpr double kPointReach = 1.5;

// Two contacts of one point whose normals differ by less than this cosine are one contact seen
// through two neighbouring triangles.
constexpr double kSameNormal = 0.95;

// Barycentric share below which the closest point lies on an end of an edge: that contact is found
// by the point-triangle pair of the end as well.
constexpr double kEdgeEnd = 1e-6;

// Where points of the cloth rest on faces, edges and body vertices have nothing to add: they keep
// this share of the rest gap, and take part only once they are about that near, so that one contact
// carries and the others stand by for what comes between the points (a rim, a spike, a fold).
constexpr double kSecondaryShare = 0.5;
constexpr double kSecondaryReach = 1.1;

// Cloth whose layers start nearer than the thickness keeps this share of their starting distance.
constexpr double kStartShare = 0.9;

// A slab of this share of the thickness is as good as a wider one.
constexpr double kWideEnough = 0.05;

constexpr const char* kBroadPhaseKey = "contact.broad_phase";

bool is_exact(const NarrowPhaseTraits& traits) {
  return traits.misses_nothing && traits.no_false_alarm;
}

bool shares_vertex(const Triangle& a, const Triangle& b) {
  for (const std::int32_t i : a)
    for (const std::int32_t j : b)
      if (i == j) return true;
  return false;
}

// The triangles of each edge of `edges` (sorted, as unique_edges makes them), listed when they are
// first asked for: most states have no crossing.
class EdgeTriangles {
 public:
  EdgeTriangles(std::span<const Edge> edges, std::span<const Triangle> triangles)
      : edges_(edges), triangles_(triangles) {}

  template <class Visit>
  void visit(std::int32_t edge, Visit visit) {
    if (list_.empty()) make_list();
    auto at = std::lower_bound(list_.begin(), list_.end(), std::array<std::int32_t, 2>{edge, 0});
    for (; at != list_.end() && (*at)[0] == edge; ++at) visit((*at)[1]);
  }

 private:
  void make_list() {
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const std::int32_t i = triangles_[t][k], j = triangles_[t][(k + 1) % 3];
        const Edge edge{std::min(i, j), std::max(i, j)};
        const auto at = std::lower_bound(edges_.begin(), edges_.end(), edge);
        list_.push_back(
            {static_cast<std::int32_t>(at - edges_.begin()), static_cast<std::int32_t>(t)});
      }
    std::sort(list_.begin(), list_.end());
  }

  std::span<const Edge> edges_;
  std::span<const Triangle> triangles_;
  std::vector<std::array<std::int32_t, 2>> list_;  // (edge, triangle)
};

std::string sentence(const std::vector<std::pair<std::int32_t, std::int32_t>>& pairs,
                     const char* second) {
  return std::to_string(pairs.size()) + " pairs of triangles cross, the first is triangle " +
         std::to_string(pairs[0].first) + " of the cloth and triangle " +
         std::to_string(pairs[0].second) + " of " + second;
}

}  // namespace

std::string Crossings::sentence() const {
  return body.empty() ? selvedge::sentence(self, "the cloth")
                      : selvedge::sentence(body, "the bodies");
}

void refuse_crossings(const Crossings& found, bool self) {
  if (found.body.empty() && (!self || found.self.empty())) return;
  throw std::invalid_argument(
      std::string("the cloth crosses ") + (found.body.empty() ? "itself" : "a body") +
      " at the start: " + found.sentence() +
      "; move the pieces apart, or mend the mesh (`selvedge check` names the pairs)");
}

Detection::Detection(const Scene& scene, const BuiltScene& built, const Methods& methods,
                     PhaseClock& clock)
    : clock_(clock),
      particles_(built.cloth.surface.vertices.size()),
      pairs_(scene),
      thickness_(pairs_.largest_thickness()),
      margin_(thickness_),
      self_(scene.contact.self),
      broad_self_(make_method(methods.broad_phases, scene.contact.broad_phase, kBroadPhaseKey)),
      broad_crossings_(make_bvh_aabb()),
      body_search_(built.bodies, built.cloth.surface.triangles.size(),
                   [&] {
                     return make_method(methods.broad_phases, scene.contact.broad_phase,
                                        kBroadPhaseKey);
                   }),
      narrow_(make_method(methods.narrow_phases, scene.contact.narrow_phase, "contact.narrow_phase",
                          NarrowPhaseConfig{})),
      exact_(make_ccd_exact()),
      cloth_edges_(built.cloth.edges),
      cloth_triangles_(built.cloth.surface.triangles),
      rest_(built.cloth.surface.vertices),
      surface_(particles_, 0),
      plan_(scene, built, {kProximityReach * thickness_, margin_, kPointReach * thickness_},
            is_exact(narrow_->traits())) {
  if (!broad_self_->traits().self) broad_self_ = make_bvh_aabb();
  for (std::size_t p = 0; p + 1 < built.piece_begin.size(); ++p)
    for (std::int32_t i = built.piece_begin[p]; i < built.piece_begin[p + 1]; ++i)
      surface_[i] = static_cast<std::int32_t>(p);
  body_begin_.push_back(0);
  for (std::size_t b = 0; b < built.bodies.size(); ++b) {
    const std::int32_t first = body_begin_.back();
    for (const Triangle& t : built.bodies[b]->triangles())
      body_triangles_.push_back({t[0] + first, t[1] + first, t[2] + first});
    body_begin_.push_back(first + static_cast<std::int32_t>(built.bodies[b]->vertex_count()));
    surface_.resize(particles_ + static_cast<std::size_t>(body_begin_.back()),
                    static_cast<std::int32_t>(scene.cloths.size() + b));
  }
  body_edges_ = unique_edges(body_triangles_);
  std::vector<Triangle> all = cloth_triangles_;
  const auto n = static_cast<std::int32_t>(particles_);
  for (const Triangle& t : body_triangles_) all.push_back({t[0] + n, t[1] + n, t[2] + n});
  filter_ = ContactFilter(surface_.size(), all);
  loose_.assign(particles_, 1);
  for (const Triangle& t : cloth_triangles_)
    for (const std::int32_t i : t) loose_[i] = 0;
  if (std::find(loose_.begin(), loose_.end(), 1) == loose_.end()) loose_.clear();
}

void Detection::set_motion(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1, bool bodies_move,
                           const std::optional<StepTimes>& times) {
  x_t0_ = x_t0;
  x_t1_ = x_t1;
  body_search_.set_motion(x_t0.subspan(particles_), x_t1.subspan(particles_), bodies_move, times);
  if (bodies_move || bodies_moved_) ++body_id_;  // the step after a motion starts elsewhere
  bodies_moved_ = bodies_move;
}

SurfaceView Detection::cloth_view(double inflation) const {
  return {x_t0_.first(particles_),
          x_t1_.first(particles_),
          cloth_edges_,
          cloth_triangles_,
          inflation,
          0};
}

SurfaceView Detection::body_view(double inflation) const {
  return {x_t0_.subspan(particles_),
          x_t1_.subspan(particles_),
          body_edges_,
          body_triangles_,
          inflation,
          bodies_moved_ ? 0 : body_id_};
}

// Particles may end off their place by the margin in each coordinate. That is what boxes are
// inflated by; a detector that culls by distance has to reckon with the diagonal.
double Detection::inflation(const BroadPhase& broad) const {
  return broad.traits().pairs == PairSet::culled ? std::numbers::sqrt3 * margin_ : margin_;
}

void Detection::prove_idle() {
  const auto scope = clock_.measure("plan");
  const auto cloth_t0 = x_t0_.first(particles_), cloth_t1 = x_t1_.first(particles_);
  bodies_idle_ = plan_.bodies_are_idle(cloth_t0, cloth_t1, x_t0_.subspan(particles_),
                                       x_t1_.subspan(particles_), bodies_moved_);
  self_idle_ = !self_ || plan_.self_is_idle(cloth_t0, cloth_t1);
}

void Detection::search_bodies() {
  body_pairs_.clear();
  if (bodies_idle_) return;
  const auto scope = clock_.measure("broad_phase");
  const PhaseClock::Scope busy(plan_.busy_bodies());
  // Every cloth box grows by the margin on each side; two cloth particles may both use theirs.
  body_search_.find_pairs(cloth_view(0.0), margin_, 0.5 * thickness_, body_pairs_);
  drop_loose(body_pairs_);
  drop_excluded(body_pairs_, false);
}

void Detection::search_self() {
  self_pairs_.clear();
  if (self_idle_) return;
  const auto scope = clock_.measure("broad_phase");
  const PhaseClock::Scope busy(plan_.busy_self());
  broad_self_->find_self_pairs(drifting_view(), self_pairs_);
  drop_loose(self_pairs_);
  drop_excluded(self_pairs_, true);
}

void Detection::find_candidates() {
  prove_idle();
  search_bodies();
  search_self();
  note_covered();
}

void Detection::note_covered() {
  covered_.assign(x_t1_.begin(), x_t1_.begin() + static_cast<std::ptrdiff_t>(particles_));
}

// Particles of no triangle (the middle of a supported body, a sparse layer) are no surface. Some
// broad phases leave them out, others do not know.
void Detection::drop_loose(CandidatePairs& pairs) const {
  if (loose_.empty()) return;
  std::erase_if(pairs.point_triangle,
                [&](const PointTrianglePair& pair) { return loose_[pair.point] != 0; });
}

void Detection::drop_excluded(CandidatePairs& pairs, bool self) const {
  if (excluded_ == nullptr || excluded_->empty()) return;
  if (self)
    excluded_->drop_from_self(pairs);
  else
    excluded_->drop_from_body(pairs);
}

// The cloth without the displacement that all its particles share: two of them meet or not whatever
// the whole does, and the boxes of a fast sheet do not all overlap. The subtraction rounds by parts
// of the position in 10^16, which the margin covers.
SurfaceView Detection::drifting_view() {
  Vec3 drift = Vec3::Zero();
  for (std::size_t i = 0; i < particles_; ++i) drift += x_t1_[i] - x_t0_[i];
  drift /= static_cast<double>(std::max<std::size_t>(particles_, 1));
  drifting_.resize(particles_);
  for (std::size_t i = 0; i < particles_; ++i) drifting_[i] = x_t1_[i] - drift;
  SurfaceView view = cloth_view(inflation(*broad_self_));
  view.x_t1 = drifting_;
  return view;
}

bool Detection::candidates_cover() const {
  if (self_idle_ && body_vertices() == 0) return true;  // find_collisions looks for itself
  constexpr std::size_t kGrain = 8192;
  const double outside = parallel_sum(particles_, kGrain, [&](std::size_t b, std::size_t e) {
    double count = 0.0;
    for (std::size_t i = b; i < e; ++i)
      if (!((x_t1_[i] - covered_[i]).lpNorm<Eigen::Infinity>() <= margin_)) count += 1.0;
    return count;
  });
  return outside == 0.0;
}

ContactPoint Detection::joint(const Contact& contact, bool self) const {
  ContactPoint c;
  c.kind = contact.kind;
  const auto n = static_cast<std::int32_t>(particles_);
  for (int k = 0; k < 4; ++k) {
    bool body = !self;
    if (contact.kind == ContactKind::point_triangle) body = body && k > 0;
    if (contact.kind == ContactKind::triangle_point) body = body && k == 0;
    if (contact.kind == ContactKind::edge_edge) body = body && k > 1;
    c.vertex[k] = contact.vertex[k] + (body ? n : 0);
  }
  c.weight = contact.weight;
  c.normal = contact.normal;
  c.gap = c.normal.dot(relative(c, x_t0_));
  c.rest_gap = rest_gap(c, self);
  if (contact.kind != ContactKind::point_triangle) c.rest_gap *= kSecondaryShare;
  const auto [piece, other] = surfaces(c);
  c.friction = pairs_.friction(piece, other);
  return c;
}

// The first and the last vertex of a contact are on its two sides, whatever its kind; a primitive
// lies in one surface, and pieces come before bodies.
std::pair<std::int32_t, std::int32_t> Detection::surfaces(const ContactPoint& c) const {
  return std::minmax({surface_[c.vertex[0]], surface_[c.vertex[3]]});
}

double Detection::thickness(const ContactPoint& c) const {
  const auto [piece, other] = surfaces(c);
  return pairs_.thickness(piece, other);
}

// Particles of one piece that start nearer than the thickness are neighbours in the cloth.
double Detection::rest_gap(const ContactPoint& c, bool self) const {
  const auto [piece, other] = surfaces(c);
  const double thickness = pairs_.thickness(piece, other);
  if (!self || piece != other) return thickness;
  return std::min(thickness, kStartShare * relative(c, rest_).norm());
}

void Detection::append_proximities(const std::vector<Contact>& found, bool self,
                                   std::vector<ContactPoint>& out) const {
  std::vector<ContactPoint> group;  // of one point, nearest first
  const auto flush = [&] {
    std::stable_sort(group.begin(), group.end(),
                     [](const auto& a, const auto& b) { return a.gap < b.gap; });
    const std::size_t first = out.size();
    for (const ContactPoint& c : group) {
      const auto same = [&](const ContactPoint& d) { return d.normal.dot(c.normal) > kSameNormal; };
      if (std::none_of(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(), same))
        out.push_back(c);
    }
    group.clear();
  };
  ContactKind kind = ContactKind::edge_edge;
  std::int32_t point = -1;
  for (const Contact& contact : found) {
    if (contact.gap > kProximityReach * thickness_) continue;
    ContactPoint c = joint(contact, self);
    if (contact.gap > kProximityReach * thickness(c)) continue;
    if (contact.kind == ContactKind::point_triangle
            ? std::min(c.gap, c.normal.dot(relative(c, x_t1_))) >= kPointReach * c.rest_gap
            : c.gap >= kSecondaryReach * c.rest_gap)
      continue;
    if (contact.kind == ContactKind::edge_edge) {
      const double s = c.weight[1], t = -c.weight[3];
      if (s <= kEdgeEnd || s >= 1.0 - kEdgeEnd || t <= kEdgeEnd || t >= 1.0 - kEdgeEnd) continue;
      if (!filter_.is_true_edge_contact(c, x_t0_)) continue;
      flush();
      out.push_back(c);
      continue;
    }
    if (!filter_.is_true_point_contact(c, x_t0_)) continue;
    if (contact.kind != kind || contact.vertex[0] != point) flush();
    kind = contact.kind;
    point = contact.vertex[0];
    group.push_back(c);
  }
  flush();
}

void Detection::find_proximities(std::vector<ContactPoint>& out) {
  const auto scope = clock_.measure("narrow_phase");
  out.clear();
  const SurfaceView cloth = cloth_view(0.5 * thickness_), body = body_view(0.5 * thickness_);
  if (!bodies_idle_) {
    const PhaseClock::Scope busy(plan_.busy_bodies());
    selvedge::find_proximities(cloth, body, body_pairs_, kPointReach * thickness_, found_);
    append_proximities(found_, false, out);
  }
  if (!self_idle_) {
    const PhaseClock::Scope busy(plan_.busy_self());
    selvedge::find_proximities(cloth, cloth, self_pairs_, kPointReach * thickness_, found_);
    append_proximities(found_, true, out);
  }
}

// What was proved of the motion that candidates are for is looked at again for the present end.
void Detection::prove_again() {
  if (!self_ || !self_idle_) return;
  {
    const auto scope = clock_.measure("plan");
    self_idle_ = plan_.self_stays_idle(x_t0_.first(particles_), x_t1_.first(particles_));
  }
  if (self_idle_) return;
  search_bodies();
  search_self();
  note_covered();
}

void Detection::find_collisions(std::vector<ContactPoint>& out) {
  prove_again();
  const auto scope = clock_.measure("narrow_phase");
  out.clear();
  const SurfaceView cloth = cloth_view(0.0), body = body_view(0.0);
  std::vector<std::pair<double, ContactPoint>> timed;
  if (!bodies_idle_) {
    const PhaseClock::Scope busy(plan_.busy_bodies());
    narrow_->find_contacts(cloth, body, body_pairs_, found_);
    for (const Contact& c : found_) timed.emplace_back(c.toi, joint(c, false));
  }
  if (!self_idle_) {
    const PhaseClock::Scope busy(plan_.busy_self());
    narrow_->find_contacts(cloth, cloth, self_pairs_, found_);
    for (const Contact& c : found_) timed.emplace_back(c.toi, joint(c, true));
  }
  std::stable_sort(timed.begin(), timed.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [toi, c] : timed) out.push_back(c);
}

std::map<std::string, PlanFigures> Detection::plan_figures() const {
  std::map<std::string, PlanFigures> figures;
  for (const auto& [part, count] : plan_.counts())
    figures[part] = {count.asked, count.idle, count.saved_s()};
  return figures;
}

void Detection::at_start(std::span<const ContactPoint> hits, std::vector<ContactPoint>& out) {
  out.assign(hits.begin(), hits.end());
  for (ContactPoint& c : out) {
    std::array<Vec3, 4> x;
    for (int k = 0; k < 4; ++k) x[k] = x_t0_[c.vertex[k]];
    SeparatingSlab slab = separating_slab(c.kind, x);
    // A pair that meets far from where it starts is often wide apart across the motion: a slab
    // there would stop what slides by. That of the impact does not, if it is wide enough.
    const double width = slab_width(c.kind, x, c.normal);
    if (width > kWideEnough * std::min(slab.width, thickness(c))) slab = {c.normal, width};
    c.normal = slab.normal;
    c.gap = slab.width;
    c.weight = (c.kind == ContactKind::edge_edge ? edge_edge_closest(x[0], x[1], x[2], x[3])
                                                 : point_triangle_closest(x[0], x[1], x[2], x[3]))
                   .weight;
  }
}

void Detection::all(const Vec3& shift, std::vector<ContactPoint>& out) {
  out.clear();
  std::vector<Vec3> end(x_t1_.begin(), x_t1_.end());
  for (Vec3& x : end) x -= shift;  // rounds by far less than the boxes are inflated
  const auto view = [&](SurfaceView v, std::size_t first, std::size_t count) {
    v.x_t1 = std::span<const Vec3>(end).subspan(first, count);
    v.static_id = 0;
    return v;
  };
  const SurfaceView cloth = view(cloth_view(0.5 * thickness_), 0, particles_);
  const SurfaceView body = view(body_view(0.5 * thickness_), particles_, body_vertices());
  CandidatePairs pairs;
  const auto append = [&](const SurfaceView& other, bool self) {
    drop_excluded(pairs, self);
    find_separations(cloth, other, pairs, found_);
    for (const Contact& contact : found_) {
      out.push_back(joint(contact, self));
      out.back().gap = contact.gap;
    }
  };
  if (!body_triangles_.empty()) {
    broad_crossings_->find_pairs(cloth, body, pairs);
    append(body, false);
  }
  if (!self_) return;
  broad_crossings_->find_self_pairs(cloth, pairs);
  append(cloth, true);
}

namespace {

// Pairs of triangles of two surfaces (or one) of which an edge of the first meets the second.
class EdgeTriangleTest {
 public:
  EdgeTriangleTest(BroadPhase& broad, const NarrowPhase& narrow) : broad_(broad), narrow_(narrow) {}

  template <class Emit>
  void run(std::span<const Vec3> x_a, std::span<const Edge> edges_a, std::span<const Vec3> x_b,
           std::span<const Edge> edges_b, std::span<const Triangle> triangles_b, Emit emit) {
    from_.clear();
    to_.clear();
    for (const Edge& e : edges_a) {
      from_.push_back(x_a[e[0]]);
      to_.push_back(x_a[e[1]]);
    }
    const SurfaceView runners{from_, to_, {}, {}, 0.0, 0};
    const SurfaceView surface{x_b, x_b, edges_b, triangles_b, 0.0, 0};
    broad_.find_pairs(runners, surface, pairs_);
    pairs_.triangle_point.clear();
    pairs_.edge_edge.clear();
    if (x_a.data() == x_b.data())  // one surface: an edge touches the triangles at its own ends
      std::erase_if(pairs_.point_triangle, [&](const PointTrianglePair& p) {
        const Edge& e = edges_a[p.point];
        const Triangle& t = triangles_b[p.triangle];
        return std::any_of(t.begin(), t.end(), [&](auto v) { return v == e[0] || v == e[1]; });
      });
    narrow_.find_contacts(runners, surface, pairs_, found_);
    if (found_.empty()) return;
    // A contact names the triangle's corners, not the triangle; contacts come in pair order.
    auto found = found_.begin();
    for (const PointTrianglePair& p : pairs_.point_triangle) {
      const Triangle& t = triangles_b[p.triangle];
      if (found == found_.end()) return;
      if (found->vertex != std::array<std::int32_t, 4>{p.point, t[0], t[1], t[2]}) continue;
      emit(p.point, p.triangle);
      ++found;
    }
  }

 private:
  std::vector<Contact> found_;
  BroadPhase& broad_;
  const NarrowPhase& narrow_;
  std::vector<Vec3> from_, to_;
  CandidatePairs pairs_;
};

void sort_unique(std::vector<std::pair<std::int32_t, std::int32_t>>& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

}  // namespace

void Detection::find_body_crossings(Crossings& crossings) {
  const auto cloth = x_t0_.first(particles_), body = x_t0_.subspan(particles_);
  if (body_triangles_.empty() || plan_.bodies_are_uncrossed(cloth, body)) return;
  const PhaseClock::Scope busy(plan_.busy_crossings_bodies());
  EdgeTriangles cloth_of(cloth_edges_, cloth_triangles_), body_of(body_edges_, body_triangles_);
  EdgeTriangleTest test(*broad_crossings_, *exact_);
  test.run(cloth, cloth_edges_, body, body_edges_, body_triangles_, [&](auto edge, auto triangle) {
    cloth_of.visit(edge, [&](auto t) { crossings.body.emplace_back(t, triangle); });
  });
  test.run(body, body_edges_, cloth, cloth_edges_, cloth_triangles_, [&](auto edge, auto triangle) {
    body_of.visit(edge, [&](auto t) { crossings.body.emplace_back(triangle, t); });
  });
  sort_unique(crossings.body);
}

void Detection::find_self_crossings(Crossings& crossings) {
  const auto cloth = x_t0_.first(particles_);
  if (plan_.self_is_uncrossed(cloth)) return;
  const PhaseClock::Scope busy(plan_.busy_crossings_self());
  EdgeTriangles cloth_of(cloth_edges_, cloth_triangles_);
  EdgeTriangleTest test(*broad_crossings_, *exact_);
  test.run(cloth, cloth_edges_, cloth, cloth_edges_, cloth_triangles_,
           [&](auto edge, auto triangle) {
             cloth_of.visit(edge, [&](auto t) {
               if (!shares_vertex(cloth_triangles_[t], cloth_triangles_[triangle]))
                 crossings.self.emplace_back(std::min(t, triangle), std::max(t, triangle));
             });
           });
  sort_unique(crossings.self);
}

Crossings Detection::find_crossings() {
  Crossings crossings;
  find_body_crossings(crossings);
  find_self_crossings(crossings);
  return crossings;
}

std::vector<EdgeCrossing> Detection::find_edge_crossings() {
  std::vector<EdgeCrossing> crossings;
  const auto cloth = x_t0_.first(particles_), body = x_t0_.subspan(particles_);
  const auto edges = static_cast<std::int32_t>(cloth_edges_.size());
  const auto triangles = static_cast<std::int32_t>(cloth_triangles_.size());
  EdgeTriangleTest test(*broad_crossings_, *exact_);
  if (!body_triangles_.empty()) {
    test.run(cloth, cloth_edges_, body, body_edges_, body_triangles_, [&](auto e, auto t) {
      crossings.push_back({e, t + triangles});
    });
    test.run(body, body_edges_, cloth, cloth_edges_, cloth_triangles_, [&](auto e, auto t) {
      crossings.push_back({e + edges, t});
    });
  }
  if (self_)
    test.run(cloth, cloth_edges_, cloth, cloth_edges_, cloth_triangles_, [&](auto e, auto t) {
      crossings.push_back({e, t});
    });
  std::sort(crossings.begin(), crossings.end());
  return crossings;
}

JointSurface Detection::joint_surface() const {
  return {particles_,       body_vertices(), cloth_edges_,
          cloth_triangles_, body_edges_,     body_triangles_};
}

}  // namespace selvedge
