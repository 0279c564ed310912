// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/distance.h>
#include <selvedge/simulation/detail/pinches.h>
#include <selvedge/simulation/detail/step.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <queue>
#include <stdexcept>
#include <string>
#include <utility>

namespace selvedge::detail {
namespace {

// Share of the rest gap below which cloth has no room of its own.
constexpr double kRoom = 0.1;

// Share of the rest gap at which layers of cloth keep their order while the surfaces overlap.
constexpr double kOverlapRoom = 1e-3;

// Cosine below which two contacts push against each other.
constexpr double kOpposite = -0.5;

// Cosine of the angle between the line to the nearest point of a body and its contact normal above
// which a vertex faces the body; below it, it lies beside a rim.
constexpr double kFaces = 0.7;

// Share of the rest gap by which a vertex may lie beside a triangle and still be over it.
constexpr double kBeside = 0.1;

// A vertex that one surface has lost, and that lies inside the other, rises out of it by this share
// of the rest gap in a step of 1/120 s, up to that share above it.
constexpr double kRise = 0.02, kRiseTime = 1.0 / 120.0, kRisen = 0.02;
constexpr double kAboveRisen = 1.01;  // so that rounding does not keep it

// Share of its distance within which the cloth beside a vertex must pass a point of a body, so that
// the vertex has no contact with that point.
constexpr double kPassesNearer = 0.5;

// By how much the rest gap grows per length of cloth from a pinched vertex on. It stretches flat
// cloth by half of its square, 0.5 %.
constexpr double kTaper = 0.1;

// Cosine above which a contact acts across a surface.
constexpr double kActsAcross = 0.3;

// Triangles that a surface may slide in a step.
constexpr int kLongestWalk = 8;

using Corners = std::array<Vec3, 3>;

Corners corners(const Triangle& t, std::span<const Vec3> x) { return {x[t[0]], x[t[1]], x[t[2]]}; }

Vec3 normal_of(const Corners& c, bool reversed) {
  const Vec3 n = (c[1] - c[0]).cross(c[2] - c[0]).stableNormalized();
  return reversed ? Vec3(-n) : n;
}

/// Barycentric coordinates of the foot of x in the plane of the triangle.
Vec3 foot_weights(const Vec3& x, const Corners& c) {
  const Vec3 n = (c[1] - c[0]).cross(c[2] - c[0]);
  const double area = n.squaredNorm();
  const auto part = [&](int k) {
    return (c[(k + 2) % 3] - c[(k + 1) % 3]).cross(x - c[(k + 1) % 3]).dot(n) / area;
  };
  return {part(0), part(1), part(2)};
}

bool covers(const Vec3& x, const Corners& c) { return foot_weights(x, c).minCoeff() >= 0.0; }

Vec3 at(const Vec3& weights, const Corners& c) {
  return weights[0] * c[0] + weights[1] * c[1] + weights[2] * c[2];
}

bool holds(std::span<const Pinch> sorted, std::int32_t vertex) {
  const auto at = std::lower_bound(sorted.begin(), sorted.end(), vertex,
                                   [](const Pinch& p, std::int32_t v) { return p.vertex < v; });
  return at != sorted.end() && at->vertex == vertex;
}

// Rims of surfaces that overlap lie behind the cloth beside them, on its wrong sides: of the first
// `found` contacts, drops those across the cloth of vertices that two planes guide.
void drop_behind(std::vector<ContactPoint>& contacts, std::size_t found, std::size_t particles) {
  std::map<std::int32_t, Vec3> across;
  for (std::size_t i = found + 1; i < contacts.size(); ++i)
    if (contacts[i].vertex[0] == contacts[i - 1].vertex[0])
      across[contacts[i].vertex[0]] = contacts[i].normal;
  const auto is_behind = [&](const ContactPoint& c) {
    const auto is_body = [&](int k) { return static_cast<std::size_t>(c.vertex[k]) >= particles; };
    if (!is_body(0) && !is_body(3)) return false;
    bool guided = true, acts_across = false;
    for (int k = 0; k < 4; ++k) {
      if (is_body(k) || c.weight[k] == 0.0) continue;
      const auto at = across.find(c.vertex[k]);
      if (at == across.end())
        guided = false;
      else
        acts_across = acts_across || std::abs(at->second.dot(c.normal)) > kActsAcross;
    }
    return guided && acts_across;
  };
  const auto end = contacts.begin() + static_cast<std::ptrdiff_t>(found);
  contacts.erase(std::remove_if(contacts.begin(), end, is_behind), end);
}

}  // namespace

void refuse_bad_pinches(std::span<const Pinch> pinches, std::size_t vertices,
                        std::size_t triangles) {
  const auto within = [](std::int32_t i, std::size_t count) {
    return i >= 0 && static_cast<std::size_t>(i) < count;
  };
  for (const Pinch& p : pinches)
    if (!within(p.vertex, vertices) || !within(p.triangle[0], triangles) ||
        !within(p.triangle[1], triangles) || !(p.share >= 0.0 && p.share <= 1.0))
      throw std::invalid_argument("the saved state pinches vertex " + std::to_string(p.vertex) +
                                  " of " + std::to_string(vertices) +
                                  ", which does not fit; resume with the scene that was run");
}

// A surface at a pinched vertex at the end of a step.
struct Pinches::Grip {
  Vec3 point;   // m, that was at its foot at the start
  Vec3 normal;  // towards the vertex
  double friction;
  double height;    // m, of the vertex above it at the start
  double rest_gap;  // m
};

const JointSurface& Pinches::surface() {
  if (!surface_) surface_ = detection_.joint_surface();
  return *surface_;
}

// The nearest triangle to x among those around this one that face the same way.
std::int32_t Pinches::nearest_around(std::int32_t triangle, const Vec3& x, const Vec3& normal,
                                     std::span<const Vec3> x_t0) {
  const std::vector<Triangle>& all = surface().triangles();
  const auto distance = [&](std::int32_t t) {
    const Corners c = corners(all[t], x_t0);
    return point_triangle_closest(x, c[0], c[1], c[2]).distance;
  };
  std::int32_t nearest = triangle;
  double least = distance(triangle);
  for (const std::int32_t v : all[triangle])
    for (const std::int32_t t : surface().triangles_of_vertex(v)) {
      if (normal_of(corners(all[t], x_t0), false).dot(normal) < -kOpposite) continue;
      const double there = distance(t);
      if (there < least || (there == least && t < nearest)) {
        least = there;
        nearest = t;
      }
    }
  return nearest;
}

// Walks to the triangle that x lies over; false if it lies over none.
bool Pinches::find_foot(Pinch& pinch, int side, const Vec3& x, std::span<const Vec3> x_t0) {
  const auto first = static_cast<std::int32_t>(surface().cloth_triangles());
  std::int32_t t = pinch.triangle[side] + first;
  const std::vector<Triangle>& all = surface().triangles();
  for (int step = 0; step < kLongestWalk; ++step) {
    const Corners c = corners(all[t], x_t0);
    if (foot_weights(x, c).minCoeff() >= 0.0) break;
    const std::int32_t next = nearest_around(t, x, normal_of(c, false), x_t0);
    if (next == t) break;
    t = next;
  }
  pinch.triangle[side] = t - first;
  const Corners c = corners(all[t], x_t0);
  const Vec3 foot = at(foot_weights(x, c), c);
  if (!foot.allFinite()) return false;
  const double beside = point_triangle_closest(foot, c[0], c[1], c[2]).distance;
  return beside <= kBeside * detection_.rest_gap(pinch.vertex, all[t][0]);
}

// Where the surface takes the vertex that is left of the two; none if it lies outside of it.
std::optional<Pinches::Place> Pinches::rise(const Grip& left, double h) {
  if (!(left.height < kRisen * left.rest_gap)) return std::nullopt;
  const double end = left.height + kRise * left.rest_gap * h / kRiseTime;
  return Place{left.point + std::min(end, kAboveRisen * kRisen * left.rest_gap) * left.normal,
               left.normal, true};
}

// The surface on one side of a vertex, taken beyond the border of its triangle.
Pinches::Grip Pinches::grip_of(const Pinch& pinch, int side, const StepInput& in,
                               std::span<const Vec3> x_t1) {
  const Vec3& x = in.x_t0[pinch.vertex];
  const Triangle& t = surface().triangles()[surface().cloth_triangles() + pinch.triangle[side]];
  const Corners before = corners(t, in.x_t0), after = corners(t, x_t1);
  const Vec3 weights = foot_weights(x, before);
  return {at(weights, after), normal_of(after, pinch.reversed[side]),
          detection_.friction(pinch.vertex, t[0]),
          (x - at(weights, before)).dot(normal_of(before, pinch.reversed[side])),
          detection_.rest_gap(pinch.vertex, t[0])};
}

// Where two surfaces take the vertex between them; none if they leave it room.
std::optional<Pinches::Place> Pinches::between(const std::array<Grip, 2>& grip, double share) {
  if (!(grip[0].normal.dot(grip[1].normal) < kOpposite)) return std::nullopt;
  const Vec3 across = (grip[0].normal - grip[1].normal).normalized();
  const double room = across.dot(grip[1].point - grip[0].point);
  // The heights of the start add up to the room there. A vertex that starts without room is between
  // the surfaces at the end only if they take it there.
  const double rest_gap = std::max(grip[0].rest_gap, grip[1].rest_gap), most = kRoom * rest_gap;
  if (room > most && grip[0].height + grip[1].height > most) return std::nullopt;
  const double lead = grip[0].friction - grip[1].friction;
  const Vec3 along = lead > 0.0   ? grip[0].point
                     : lead < 0.0 ? grip[1].point
                                  : Vec3(0.5 * (grip[0].point + grip[1].point));
  const double height = 0.5 * room + (share - 0.5) * std::max(room, kOverlapRoom * rest_gap);
  return Place{along + (across.dot(grip[0].point - along) + height) * across, across, false};
}

// Whether x lies over both surfaces at the end of the step.
bool Pinches::is_over(Pinch pinch, const Vec3& x, std::span<const Vec3> x_t1) {
  return find_foot(pinch, 0, x, x_t1) && find_foot(pinch, 1, x, x_t1);
}

// Where the surfaces take the vertex; none if they free it.
std::optional<Pinches::Place> Pinches::end(Pinch& pinch, const StepInput& in,
                                           std::span<const Vec3> x_t1) {
  const Vec3& x = in.x_t0[pinch.vertex];
  std::array<Grip, 2> grip;
  std::array<bool, 2> over{};
  for (const int side : {0, 1}) {
    over[side] = find_foot(pinch, side, x, in.x_t0);
    grip[side] = grip_of(pinch, side, in, x_t1);
  }
  const std::optional<Place> there = between(grip, pinch.share);
  if (there && ((over[0] && over[1]) || is_over(pinch, there->point, x_t1))) return there;
  if (over[0] == over[1]) return std::nullopt;
  return rise(grip[over[0] ? 0 : 1], in.h);
}

// The mean displacement of the neighbours of v that both surfaces hold, or that slide with such.
std::optional<Vec3> Pinches::step_beside(std::int32_t v, const StepInput& in,
                                         std::span<const Vec3> x_t1, std::span<const Pinch> pinches,
                                         const std::map<std::int32_t, Vec3>& rising) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (const std::int32_t e : surface().edges_of_vertex(v)) {
    const std::int32_t w = surface().other_end(e, v);
    if (!holds(pinches, w) || rising.contains(w)) continue;
    sum += x_t1[w] - in.x_t0[w];
    ++count;
  }
  if (count == 0) return std::nullopt;
  return Vec3(sum / count);
}

// Cloth that rises out of a surface slides along it with the cloth beside it that both surfaces
// hold; with that surface alone it would be torn from the rest. `rising`: the normals.
void Pinches::slide(const StepInput& in, std::span<Vec3> x_t1, std::span<const Pinch> pinches,
                    std::map<std::int32_t, Vec3> rising) {
  for (bool found = true; std::exchange(found, false);) {
    std::vector<std::pair<std::int32_t, Vec3>> moved;
    for (const auto& [v, normal] : rising)
      if (const auto step = step_beside(v, in, x_t1, pinches, rising)) {
        const Vec3 more = *step - (x_t1[v] - in.x_t0[v]);
        moved.emplace_back(v, more - normal.dot(more) * normal);
      }
    for (const auto& [v, more] : moved) {
      x_t1[v] += more;
      rising.erase(v);
      found = true;
    }
  }
}

void Pinches::hold(StepInput& in, std::span<Vec3> x_t1, std::vector<Pinch>& pinches) {
  held_.clear();
  std::map<std::int32_t, Vec3> rising;
  std::erase_if(pinches, [&](Pinch& pinch) {
    const std::int32_t i = pinch.vertex;
    if (!(in.inv_mass[i] > 0.0)) return true;  // a handle has taken it
    const std::optional<Place> there = end(pinch, in, x_t1);
    if (!there) return true;
    held_.push_back(
        {i, there->across,
         detection_.rest_gap(
             i, surface().triangles()[surface().cloth_triangles() + pinch.triangle[0]][0])});
    in.particles.inv_mass[i] = in.inv_mass[i] = 0.0;
    x_t1[i] = there->point;
    if (there->rises) rising.emplace(i, there->across);
    return false;
  });
  slide(in, x_t1, pinches, std::move(rising));
  for (const Pinch& pinch : pinches) {
    const std::int32_t i = pinch.vertex;
    if (const Vec3* slip = slip_of(i)) x_t1[i] += *slip;
    in.v_coasting[i] = (x_t1[i] - in.x_t0[i]) / in.h;
  }
}

// Surfaces that overlap and slide along each other run over the cloth beside their rims. It cannot
// enter by contacts, which would push it along with the rim: a neighbour of a pinched vertex is
// pinched in the step in which both surfaces come to lie over it.
void Pinches::enter(const StepInput& in, std::span<const Vec3> x_t1, std::vector<Pinch>& pinches) {
  std::map<std::int32_t, Pinch> entering;
  for (const Pinch& pinch : pinches)
    for (const std::int32_t e : surface().edges_of_vertex(pinch.vertex)) {
      const std::int32_t v = surface().other_end(e, pinch.vertex);
      if (!(in.inv_mass[v] > 0.0) || entering.contains(v) || holds(pinches, v)) continue;
      Pinch next = pinch;
      next.vertex = v;
      for (const int side : {0, 1}) find_foot(next, side, in.x_t0[v], in.x_t0);
      const std::array<Grip, 2> grip = {grip_of(next, 0, in, x_t1), grip_of(next, 1, in, x_t1)};
      const double room = grip[0].height + grip[1].height;
      if (!(std::abs(grip[0].height) < grip[0].rest_gap) ||
          !(std::abs(grip[1].height) < grip[1].rest_gap))
        continue;
      next.share = room > 0.0 ? std::clamp(grip[0].height / room, 0.0, 1.0) : 0.5;
      const std::optional<Place> there = between(grip, next.share);
      if (there && is_over(next, there->point, x_t1)) entering.emplace(v, next);
    }
  for (const auto& [v, pinch] : entering) pinches.push_back(pinch);
}

// Whether a triangle between pinched vertices and the first particles of a contact with a body
// passes the body far nearer than they do.
bool Pinches::passes_nearer(const ContactPoint& c, int particles, const StepInput& in,
                            std::span<const Pinch> pinches) {
  Vec3 foot = Vec3::Zero();
  for (int i = particles; i < 4; ++i) foot -= c.weight[i] * in.x_t0[c.vertex[i]];
  const double near = kPassesNearer * relative(c, in.x_t0).norm();
  for (int k = 0; k < particles; ++k)
    for (const std::int32_t t : surface().triangles_of_vertex(c.vertex[k])) {
      const Triangle& triangle = surface().triangles()[t];
      if (std::none_of(triangle.begin(), triangle.end(), [&](auto v) { return holds(pinches, v); }))
        continue;
      const Corners at = corners(triangle, in.x_t0);
      if (point_triangle_closest(foot, at[0], at[1], at[2]).distance < near) return true;
    }
  return false;
}

void Pinches::drop_along(const StepInput& in, std::span<const Pinch> pinches,
                         std::vector<ContactPoint>& contacts) {
  if (pinches.empty()) return;
  std::erase_if(contacts, [&](const ContactPoint& c) {
    const auto is_free = [&](int k) { return in.inv_mass[c.vertex[k]] > 0.0; };
    if (static_cast<std::size_t>(c.vertex[3]) < in.n()) return false;
    if (c.kind == ContactKind::point_triangle)
      return is_free(0) && passes_nearer(c, 1, in, pinches);
    return c.kind == ContactKind::edge_edge && is_free(0) && is_free(1) &&
           passes_nearer(c, 2, in, pinches);
  });
}

// Distances along edges to the nearest pinched vertex, up to `reach`, m.
std::map<std::int32_t, double> Pinches::distances(const StepInput& in,
                                                  std::span<const Pinch> pinches, double reach) {
  using Entry = std::pair<double, std::int32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (const Pinch& pinch : pinches) queue.emplace(0.0, pinch.vertex);
  std::map<std::int32_t, double> done;
  while (!queue.empty()) {
    const auto [distance, v] = queue.top();
    queue.pop();
    if (!done.emplace(v, distance).second) continue;
    for (const std::int32_t e : surface().edges_of_vertex(v)) {
      const std::int32_t w = surface().other_end(e, v);
      const double there = distance + (in.x_t0[w] - in.x_t0[v]).norm();
      if (there < reach && !done.contains(w)) queue.emplace(there, w);
    }
  }
  return done;
}

void Pinches::taper(const StepInput& in, std::span<const Pinch> pinches,
                    std::vector<ContactPoint>& contacts) {
  if (pinches.empty()) return;
  const auto is_body = [&](std::int32_t v) { return static_cast<std::size_t>(v) >= in.n(); };
  double largest = 0.0;
  for (const ContactPoint& c : contacts) largest = std::max(largest, c.rest_gap);
  const std::map<std::int32_t, double> from = distances(in, pinches, largest / kTaper);
  for (ContactPoint& c : contacts) {
    if (std::none_of(c.vertex.begin(), c.vertex.end(), is_body)) continue;
    for (int k = 0; k < 4; ++k)
      if (const auto at = from.find(c.vertex[k]); at != from.end() && c.weight[k] != 0.0)
        c.rest_gap = std::min(c.rest_gap, kTaper * at->second);
  }
}

void Pinches::guide(std::int32_t neighbour, const Pinch& pinch, const StepInput& in,
                    std::vector<ContactPoint>& out) {
  const Vec3& x = in.x_t0[neighbour];
  Pinch reached = pinch;
  reached.vertex = neighbour;
  const std::vector<Triangle>& all = surface().triangles();
  for (const int side : {0, 1})
    if (find_foot(reached, side, x, in.x_t0) &&
        covers(x, corners(all[surface().cloth_triangles() + reached.triangle[side]], in.x_t0)))
      return;
  for (const int side : {0, 1}) {
    const Triangle& t = surface().triangles()[surface().cloth_triangles() + pinch.triangle[side]];
    const Corners c = corners(t, in.x_t0);
    const Vec3 weights = foot_weights(x, c);
    ContactPoint contact;
    contact.vertex = {neighbour, t[0], t[1], t[2]};
    contact.weight = {1.0, -weights[0], -weights[1], -weights[2]};
    contact.normal = normal_of(c, pinch.reversed[side]);
    contact.gap = contact.normal.dot(x - at(weights, c));
    contact.rest_gap = kRoom * detection_.rest_gap(neighbour, t[0]);
    if (contact.gap < contact.rest_gap) out.push_back(contact);
  }
}

void Pinches::guide(const StepInput& in, std::span<const Pinch> pinches,
                    std::vector<ContactPoint>& out) {
  std::vector<std::pair<std::int32_t, std::size_t>> neighbours;  // and a pinch beside it
  for (std::size_t k = 0; k < pinches.size(); ++k)
    for (const std::int32_t e : surface().edges_of_vertex(pinches[k].vertex))
      if (const std::int32_t v = surface().other_end(e, pinches[k].vertex); in.inv_mass[v] > 0.0)
        neighbours.emplace_back(v, k);
  std::sort(neighbours.begin(), neighbours.end());
  const std::size_t found = out.size();
  std::int32_t last = -1;
  for (const auto& [v, k] : neighbours)
    if (std::exchange(last, v) != v) guide(v, pinches[k], in, out);
  drop_behind(out, found, in.n());
}

// Of all bodies, counted from 0.
std::int32_t Pinches::triangle_of(const ContactPoint& c) {
  const Triangle wanted{c.vertex[1], c.vertex[2], c.vertex[3]};
  for (const std::int32_t t : surface().triangles_of_vertex(c.vertex[1]))
    if (surface().triangles()[t] == wanted)
      return t - static_cast<std::int32_t>(surface().cloth_triangles());
  return -1;
}

// Of all contacts of one vertex with bodies.
std::optional<Pinch> Pinches::pinch_of(std::span<const ContactPoint> contacts, const StepInput& in,
                                       std::span<const Vec3> x_t1) {
  const auto faces = [&](const ContactPoint& c) {
    const Vec3 d = relative(c, in.x_t0);
    return d.dot(c.normal) >= kFaces * d.norm();
  };
  for (std::size_t i = 0; i < contacts.size(); ++i)
    for (std::size_t j = i + 1; j < contacts.size(); ++j) {
      const ContactPoint &a = contacts[i], &b = contacts[j];
      if (!(a.normal.dot(b.normal) < kOpposite) || !faces(a) || !faces(b)) continue;
      Pinch pinch;
      pinch.vertex = a.vertex[0];
      pinch.triangle = {triangle_of(a), triangle_of(b)};
      if (pinch.triangle[0] < 0 || pinch.triangle[1] < 0) continue;
      for (const int k : {0, 1}) {
        const ContactPoint& c = k == 0 ? a : b;
        const Corners t = {in.x_t0[c.vertex[1]], in.x_t0[c.vertex[2]], in.x_t0[c.vertex[3]]};
        pinch.reversed[k] = normal_of(t, false).dot(c.normal) < 0.0;
      }
      const double room = a.gap + b.gap;
      pinch.share = room > 0.0 ? std::clamp(a.gap / room, 0.0, 1.0) : 0.5;
      Pinch moved = pinch;
      const Vec3& x = in.x_t0[pinch.vertex];
      if (!find_foot(moved, 0, x, in.x_t0) || !find_foot(moved, 1, x, in.x_t0)) continue;
      if (end(moved, in, x_t1)) return pinch;
    }
  return std::nullopt;
}

bool Pinches::add(const StepInput& in, std::span<const ContactPoint> contacts,
                  std::span<const Vec3> x_t1, std::vector<Pinch>& pinches, bool may_cross) {
  if (in.followers != nullptr) return false;
  const std::size_t before = pinches.size();
  if (may_cross) enter(in, x_t1, pinches);
  const auto is_of_point = [&](const ContactPoint& c) {
    return c.kind == ContactKind::point_triangle &&
           static_cast<std::size_t>(c.vertex[1]) >= in.n() && in.inv_mass[c.vertex[0]] > 0.0 &&
           std::none_of(pinches.begin() + static_cast<std::ptrdiff_t>(before), pinches.end(),
                        [&](const Pinch& p) { return p.vertex == c.vertex[0]; });
  };
  for (std::size_t i = 0; i < contacts.size();) {
    std::size_t last = i + 1;
    if (is_of_point(contacts[i])) {
      while (last < contacts.size() && is_of_point(contacts[last]) &&
             contacts[last].vertex[0] == contacts[i].vertex[0])
        ++last;
      if (last - i > 1)
        if (const auto pinch = pinch_of(contacts.subspan(i, last - i), in, x_t1))
          pinches.push_back(*pinch);
    }
    i = last;
  }
  if (pinches.size() == before) return false;
  std::sort(pinches.begin(), pinches.end(),
            [](const Pinch& a, const Pinch& b) { return a.vertex < b.vertex; });
  return true;
}

}  // namespace selvedge::detail
