// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/narrowphase/distance.h>
#include <selvedge/simulation/contacts/detail/contacts.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace selvedge::detail {

// The linearised gap of a pair farther apart would stop cloth that in truth passes beside the other
// primitive.
const double kProximityReach = 4.0;

// More than 1, because its neighbours may pull cloth just outside its rest gap inwards within the
// step.
const double kPointReach = 1.5;

namespace {

// Two contacts of one point whose normals differ by less than this cosine are one contact seen
// through two neighbouring triangles.
constexpr double kSameNormal = 0.95;

// Barycentric share below which the closest point is an end of an edge: the point-triangle pair of
// that end finds the contact as well.
constexpr double kEdgeEnd = 1e-6;

// Where points of the cloth rest on faces, edges and body vertices have nothing to add. They keep
// this share of the rest gap and become contacts only at about that distance, so that one contact
// carries and the others wait for parts that come between the points (a rim, a spike, a fold).
constexpr double kSecondaryShare = 0.5;
constexpr double kSecondaryReach = 1.1;

// Faces without common vertices that are nearer than this share of the rest gap count as one
// surface. Cloth keeps the rest gap from both, so that it cannot feel a smaller gap or step between
// them.
constexpr double kJoinedShare = 0.1;

// Share of its rest gap from which on a point is above a face rather than in front of its hem.
constexpr double kAbove = 0.98;

// Where a point moves along a surface by less than this share of the rest gap, its direction hardly
// changes.
constexpr double kShortWay = 1e-3;

// Cosine of the angle by which the faces of a body turn at least if it turns.
constexpr double kSameFace = 1.0 - 1e-12;

// Least cosine of the angle by which a convex surface turns under a point that slides on over it.
constexpr double kRoundNormal = 0.5;

// Found pairs per task.
constexpr std::size_t kFoundGrain = 128;

// Covers the rounding of a distance and of a gap along its direction.
constexpr double kRoundingReserve = 1.0 + 1e-9;

// Layers of one piece that start nearer than the rest gap keep this share of their distance at the
// start.
constexpr double kStartShare = 0.9;

std::array<Vec3, 4> vertices_of(const ContactPoint& c, std::span<const Vec3> x) {
  return {x[c.vertex[0]], x[c.vertex[1]], x[c.vertex[2]], x[c.vertex[3]]};
}

Vec3 face_normal(const std::array<Vec3, 4>& x) {
  return (x[2] - x[1]).cross(x[3] - x[1]).stableNormalized();
}

std::vector<Triangle> joint_triangles(const SceneMotion& motion) {
  std::vector<Triangle> all = motion.cloth_triangles();
  const auto n = static_cast<std::int32_t>(motion.particles());
  for (const Triangle& t : motion.body_triangles()) all.push_back({t[0] + n, t[1] + n, t[2] + n});
  return all;
}

std::vector<Triangle> joint_body_triangles(const SceneMotion& motion) {
  const std::vector<Triangle> all = joint_triangles(motion);
  return {all.begin() + static_cast<std::ptrdiff_t>(motion.cloth_triangles().size()), all.end()};
}

// For each piece, whether it collides with each surface; empty if all do.
std::vector<std::vector<char>> colliding_surfaces(const Scene& scene, const ContactPairs& pairs) {
  std::vector<std::vector<char>> collides;
  if (pairs.collide_all()) return collides;
  const std::size_t surfaces = scene.cloths.size() + scene.bodies.size();
  for (std::size_t p = 0; p < scene.cloths.size(); ++p) {
    std::vector<char>& row = collides.emplace_back(surfaces);
    for (std::size_t s = 0; s < surfaces; ++s)
      row[s] = pairs.collide(static_cast<std::int32_t>(p), static_cast<std::int32_t>(s)) ? 1 : 0;
  }
  return collides;
}

std::vector<std::int32_t> surface_of_vertices(const Scene& scene, const BuiltScene& built,
                                              const SceneMotion& motion) {
  std::vector<std::int32_t> surface(motion.particles(), 0);
  for (std::size_t p = 0; p + 1 < built.piece_begin.size(); ++p)
    for (std::int32_t i = built.piece_begin[p]; i < built.piece_begin[p + 1]; ++i)
      surface[i] = static_cast<std::int32_t>(p);
  for (std::size_t b = 0; b < built.bodies.size(); ++b)
    surface.resize(motion.particles() + static_cast<std::size_t>(motion.body_begin()[b + 1]),
                   static_cast<std::int32_t>(scene.cloths.size() + b));
  return surface;
}

}  // namespace

Contacts::Contacts(const Scene& scene, const BuiltScene& built, const SceneMotion& motion)
    : motion_(motion),
      pairs_(scene),
      gravity_(scene.gravity),
      filter_(motion.particles() + motion.body_vertices(), joint_triangles(motion)),
      bodies_(joint_body_triangles(motion)),
      cloth_(motion.cloth_triangles()),
      rest_(built.cloth.surface.vertices),
      surface_(surface_of_vertices(scene, built, motion)),
      border_(border_vertices(motion.cloth_triangles(), motion.particles())),
      collides_(colliding_surfaces(scene, pairs_)) {}

void Contacts::set_step(double h) { fall_ = h * h * gravity_; }

double Contacts::largest_rest_gap() const { return pairs_.largest_rest_gap(); }

ContactPoint Contacts::joint(const Contact& contact, bool self) const {
  ContactPoint c;
  c.kind = contact.kind;
  const auto n = static_cast<std::int32_t>(motion_.particles());
  for (int k = 0; k < 4; ++k) {
    bool body = !self;
    if (contact.kind == ContactKind::point_triangle) body = body && k > 0;
    if (contact.kind == ContactKind::triangle_point) body = body && k == 0;
    if (contact.kind == ContactKind::edge_edge) body = body && k > 1;
    c.vertex[k] = contact.vertex[k] + (body ? n : 0);
  }
  c.weight = contact.weight;
  c.normal = contact.normal;
  c.gap = c.normal.dot(relative(c, motion_.x_t0()));
  c.rest_gap = rest_gap(c, self);
  if (contact.kind != ContactKind::point_triangle) c.rest_gap *= kSecondaryShare;
  const auto [piece, other] = surfaces(c);
  c.friction = pairs_.friction(piece, other);
  return c;
}

// The piece and the other surface, as ContactPairs counts them. The first and the last vertex of a
// contact are on its two sides, whatever its kind; pieces come before bodies.
std::pair<std::int32_t, std::int32_t> Contacts::surfaces(const ContactPoint& c) const {
  return std::minmax({surface_[c.vertex[0]], surface_[c.vertex[3]]});
}

double Contacts::pair_rest_gap(const ContactPoint& c) const {
  const auto [piece, other] = surfaces(c);
  return pairs_.rest_gap(piece, other);
}

double Contacts::pair_friction(const ContactPoint& c) const {
  const auto [piece, other] = surfaces(c);
  return pairs_.friction(piece, other);
}

// Particles of one piece that start nearer than the rest gap are neighbours in the cloth.
double Contacts::rest_gap(const ContactPoint& c, bool self) const {
  const auto [piece, other] = surfaces(c);
  const double wanted = pairs_.rest_gap(piece, other);
  if (!self || piece != other) return wanted;
  return std::min(wanted, kStartShare * relative(c, rest_).norm());
}

// Whether a pair, `c` in the joint index space, becomes a contact: it is near enough, and a local
// minimum of the distance.
bool Contacts::is_contact(const Contact& contact, const ContactPoint& c) const {
  if (!is_near(contact, c)) return false;
  if (contact.kind != ContactKind::edge_edge)
    return filter_.is_true_point_contact(c, motion_.x_t0());
  const double s = c.weight[1], t = -c.weight[3];
  if (s <= kEdgeEnd || s >= 1.0 - kEdgeEnd || t <= kEdgeEnd || t >= 1.0 - kEdgeEnd) return false;
  return filter_.is_true_edge_contact(c, motion_.x_t0());
}

// Whether a pair, `c` in the joint index space, is near enough to become a contact.
bool Contacts::is_near(const Contact& contact, const ContactPoint& c) const {
  if (contact.gap > kProximityReach * pair_rest_gap(c)) return false;
  return !(contact.kind == ContactKind::point_triangle
               ? std::min(c.gap, c.normal.dot(relative(c, motion_.x_t1()))) >=
                     kPointReach * c.rest_gap
               : c.gap >= kSecondaryReach * c.rest_gap);
}

// Of the contacts of one point, the nearest of each direction.
void Contacts::append_group(std::vector<ContactPoint>& out) {
  std::stable_sort(group_.begin(), group_.end(),
                   [](const auto& a, const auto& b) { return a.gap < b.gap; });
  const std::size_t first = out.size();
  for (const ContactPoint& c : group_) {
    const auto same = [&](const ContactPoint& d) { return d.normal.dot(c.normal) > kSameNormal; };
    if (std::none_of(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(), same))
      out.push_back(c);
  }
  group_.clear();
}

// Whether a contact is with a wall that the surfaces taken as one do not have. May turn its normal.
bool Contacts::is_wall(bool self, ContactPoint& c) const {
  const std::int32_t piece = surface_[c.vertex[0]];
  const SurfaceUnion::Reach reach{
      .tolerance = kJoinedShare * pair_rest_gap(c),
      .surface = surface_,
      .collides = collides_.empty() ? std::span<const char>() : std::span(collides_[piece]),
      .border = self ? std::span(border_) : std::span<const char>()};
  return !(self ? cloth_ : bodies_).is_true_contact(c, motion_.x_t0(), reach);
}

// Among the found pairs that are kept. Parts of the cloth count as joined only if some are that
// near, which is rare; then a pair of them is among those found.
void Contacts::drop_walls(bool self) {
  if (std::none_of(joined_.begin(), joined_.end(), [](const Joined& j) { return j.kept; })) return;
  if (self) {
    const bool any = std::any_of(found_.begin(), found_.end(), [&](const Contact& c) {
      return c.gap < kJoinedShare * largest_rest_gap();
    });
    if (!any) return;
    cloth_.fit(motion_.x_t0());
  } else if (const std::uint64_t id = motion_.bodies(0.0).static_id; id == 0 || id != fitted_) {
    bodies_.fit(motion_.x_t0());
    fitted_ = id;
  }
  parallel_for(found_.size(), kFoundGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Joined& joined = joined_[i];
      const ContactKind kind = found_[i].kind;
      if (!joined.kept || kind == ContactKind::triangle_point) continue;
      if (self && kind == ContactKind::edge_edge) continue;  // hems of layers cross, seams do not
      joined.kept = !is_wall(self, joined.contact);
    }
  });
}

// A sheet slides over other cloth at the rest gap: the plane between its hem and a point ahead,
// which leans against the way, would stop it. The point keeps its height below the hem, apart from
// what gravity takes and other contacts give back, so that the contact acts along the line between
// both at the end of such a way.
void Contacts::turn_at_hem(ContactPoint& c) const {
  if (c.kind != ContactKind::point_triangle) return;
  int inside = 0;
  for (int k = 1; k < 4; ++k) {
    if (c.weight[k] >= -kBorder) continue;
    if (border_[c.vertex[k]] == 0) return;
    ++inside;
  }
  if (inside == 3) return;
  const auto before = vertices_of(c, motion_.x_t0()), after = vertices_of(c, motion_.x_t1());
  const Vec3 normal = face_normal(before), end_normal = face_normal(after);
  if (!normal.allFinite() || !end_normal.allFinite()) return;
  const double height = normal.dot(before[0] - before[1]);
  if (std::abs(height) < kAbove * c.rest_gap || std::abs(normal.dot(c.normal)) > kSameNormal)
    return;
  const Vec3 end = relative(c, motion_.x_t1());
  if (c.normal.dot(end) >= c.rest_gap) return;
  const double rise = end_normal.dot(after[0] - after[1]) - height;
  const Vec3 way = end - relative(c, motion_.x_t0());
  const double along = (way - normal.dot(way) * normal).norm();
  if (std::abs(rise) > along + std::abs(normal.dot(fall_))) return;
  const ClosestPoints there =
      point_triangle_closest(after[0] - rise * end_normal, after[1], after[2], after[3]);
  c.weight = there.weight;
  c.normal = there.separation / there.distance;
  c.gap = c.normal.dot(relative(c, motion_.x_t0()));
}

// A point that slides over a curved surface leaves the plane in which it starts: against that plane
// it would be braked by the load times half the angle by which the surface turns on its way. The
// contact acts across the chord from where the point starts to where it arrives. A longer way than
// that over which all pairs are found counts as far as that. Not between bodies, which hold the
// point, and not where the body turns: cloth that does not follow it keeps its place and direction.
void Contacts::turn_along_way(std::size_t found, ContactPoint& c) const {
  if (c.kind != ContactKind::point_triangle || c.normal != found_[found].normal) return;
  const Vec3 start = relative(c, motion_.x_t0());
  const Vec3 change = relative(c, motion_.x_t1()) - start;
  Vec3 way = change - c.normal.dot(change) * c.normal;
  const double length = way.norm(), seen = (kProximityReach - kPointReach) * c.rest_gap;
  if (!(length > kShortWay * c.rest_gap)) return;
  const Vec3 face = face_normal(vertices_of(c, motion_.x_t0()));
  if (!(face.dot(face_normal(vertices_of(c, motion_.x_t1()))) > kSameFace)) return;
  way *= std::min(1.0, seen / length);
  // Relative to the surface, at the height at which it starts.
  const Vec3 there = motion_.x_t0()[c.vertex[0]] + way;
  ContactPoint arrival;
  arrival.gap = std::numeric_limits<double>::infinity();
  bool between = false;
  for_each_of_point(found, [&](std::size_t other) {
    between = between || (joined_[other].kept && joined_[other].contact.normal.dot(c.normal) < 0.0);
    ContactPoint d = joint(found_[other], false);
    const auto x = vertices_of(d, motion_.x_t0());
    const ClosestPoints closest = point_triangle_closest(there, x[1], x[2], x[3]);
    if (!(closest.distance < arrival.gap) || !(closest.distance > 0.0)) return;
    d.weight = closest.weight;
    d.gap = closest.distance;
    d.normal = closest.separation / closest.distance;
    arrival = d;
  });
  if (between || !std::isfinite(arrival.gap)) return;
  const bool convex = arrival.normal.dot(way) > 0.0;
  if (!(arrival.normal.dot(c.normal) > (convex ? kRoundNormal : kSameNormal)) ||
      !filter_.is_nearest(arrival, arrival.gap * arrival.normal, motion_.x_t0()))
    return;
  const Vec3 chord = way - (arrival.gap - c.gap) * arrival.normal;
  const Vec3 mean = c.normal + arrival.normal;
  c.normal = (mean - mean.dot(chord) / chord.squaredNorm() * chord).normalized();
  c.gap = c.normal.dot(start);
}

// Calls visit(i) for all found pairs i of the same point.
void Contacts::for_each_of_point(std::size_t found, auto&& visit) const {
  const Contact& own = found_[found];
  const auto same = [&](const Contact& other) {
    return other.kind == own.kind && other.vertex[0] == own.vertex[0];
  };
  std::size_t first = found, end = found + 1;
  while (first > 0 && same(found_[first - 1])) --first;
  while (end < found_.size() && same(found_[end])) ++end;
  for (std::size_t i = first; i < end; ++i) visit(i);
}

// Each pair alone, in parallel; then all pairs of one point in turn.
void Contacts::append_proximities(bool self, std::vector<ContactPoint>& out) {
  joined_.resize(found_.size());
  parallel_for(found_.size(), kFoundGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Joined& joined = joined_[i];
      joined.kept = !(found_[i].gap > kProximityReach * largest_rest_gap());
      if (!joined.kept) continue;
      joined.contact = joint(found_[i], self);
      joined.kept = is_contact(found_[i], joined.contact);
    }
  });
  drop_walls(self);
  ContactKind kind = ContactKind::edge_edge;
  std::int32_t point = -1;
  for (std::size_t i = 0; i < found_.size(); ++i) {
    if (!joined_[i].kept) continue;
    const Contact& contact = found_[i];
    if (contact.kind == ContactKind::edge_edge) {
      append_group(out);
      out.push_back(joined_[i].contact);
      continue;
    }
    if (contact.kind != kind || contact.vertex[0] != point) append_group(out);
    kind = contact.kind;
    point = contact.vertex[0];
    if (self)
      turn_at_hem(joined_[i].contact);
    else
      turn_along_way(i, joined_[i].contact);
    group_.push_back(joined_[i].contact);
  }
  append_group(out);
}

// A particle that starts deep inside a body is in a part of space that the detector cannot see,
// such as a hole; accepted states are outside.
void Contacts::append_particles(std::span<const ParticleContact> contacts,
                                std::vector<ContactPoint>& out) {
  for (const ParticleContact& found : contacts) {
    const Triangle& t = motion_.body_triangles()[found.pair.triangle];
    const ContactPoint c =
        joint({.kind = ContactKind::point_triangle,
               .vertex = {found.pair.point, t[0], t[1], t[2]},
               .weight = {1.0, -found.weight[0], -found.weight[1], -found.weight[2]},
               .normal = found.normal},
              false);
    if (c.gap >= -kProximityReach * pair_rest_gap(c)) out.push_back(c);
  }
}

void Contacts::find_proximities(const SearchContext& context, Candidates& candidates,
                                std::vector<ContactPoint>& out) {
  const auto scope = context.clock.measure("proximity");
  out.clear();
  Certificates& certificates = candidates.certificates();
  certificates.begin(motion_.x_t1());
  const double rest_gap = context.rest_gap;
  const ProximityReach reach{
      .reach = kPointReach * rest_gap,
      .primary_at_start = kRoundingReserve * kProximityReach * rest_gap,
      .secondary_at_start = kRoundingReserve * kSecondaryReach * kSecondaryShare * rest_gap};
  const SurfaceView cloth = motion_.cloth(0.5 * rest_gap), body = motion_.bodies(0.5 * rest_gap);
  if (const auto* contacts = candidates.particle_contacts()) {
    append_particles(*contacts, out);
  } else if (const CandidatePairs* pairs = candidates.with_bodies()) {
    const PhaseClock::Scope busy(context.plan.busy_bodies());
    selvedge::find_proximities(cloth, body, *pairs, reach, found_, certificates.rooms(false));
    append_proximities(false, out);
  }
  if (const CandidatePairs* pairs = candidates.with_self()) {
    const PhaseClock::Scope busy(context.plan.busy_self());
    selvedge::find_proximities(cloth, cloth, *pairs, reach, found_, certificates.rooms(true));
    append_proximities(true, out);
  }
}

}  // namespace selvedge::detail
