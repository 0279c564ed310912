// SPDX-License-Identifier: MIT
//
// The facts of an inquiry: handles, the chain of contacts, and the forces on a particle.
#include <fmt/format.h>
#include <selvedge/core/base/types.h>
#include <selvedge/simulation/detail/inquiry.h>

#include <algorithm>
#include <cmath>
#include <deque>

namespace selvedge::detail {
namespace {

// Maximum number of contacts with bodies that the search collects. It starts at the colliding
// particles, so it finds the contacts nearest to them in the chain of contacts.
constexpr std::size_t kFronts = 400;

// A displacement below this fraction of the largest one in the attempt counts as a rounding error,
// not as motion.
constexpr double kStandsStill = 1e-9;

}  // namespace

Vec3 point_of(const ContactPoint& c, int primitive, const std::vector<Vec3>& x) {
  const int middle = first_count(c);
  Vec3 point = Vec3::Zero();
  for (int k = primitive == 0 ? 0 : middle; k < (primitive == 0 ? middle : 4); ++k)
    point += std::abs(c.weight[k]) * x[c.vertex[k]];
  return point;
}

Inquiry::Inquiry(const InquiryFacts& facts)
    : scene_(facts.scene),
      names_(facts.names),
      failed_(facts.failed),
      attempt_(facts.attempt),
      v_(facts.v),
      triangles_(facts.triangles),
      particles_(facts.v.size()),
      loads_(facts.attempt.loads()) {
  note_handles();
}

void Inquiry::note_handles() {
  for (std::size_t h = 0; h < scene_.handles.size(); ++h)
    for (std::size_t p = 0; p < scene_.cloths.size(); ++p) {
      if (scene_.cloths[p].name != scene_.handles[h].geometry) continue;
      for (const std::int32_t v : scene_.handles[h].vertices)
        if (is_held(names_.first(p) + v)) handle_[names_.first(p) + v] = h;
    }
}

std::string Inquiry::handle_name(std::int32_t vertex) const {
  const auto handle = handle_.find(vertex);
  if (handle == handle_.end()) return "a handle";
  const std::string& name = scene_.handles[handle->second].name;
  return name.empty() ? fmt::format("handle {}", handle->second)
                      : fmt::format("handle \"{}\"", name);
}

std::set<std::int32_t> Inquiry::offenders() const {
  std::set<std::int32_t> vertices;
  for (const ContactPoint& c : failed_.pairs)
    for (int k = 0; k < 4; ++k)
      if (is_cloth(c.vertex[k])) vertices.insert(c.vertex[k]);
  return vertices;
}

std::vector<ContactPoint> Inquiry::all_contacts() const {
  std::vector<ContactPoint> all = failed_.pairs;
  all.insert(all.end(), attempt_.contacts.begin(), attempt_.contacts.end());
  return all;
}

Front Inquiry::front_of(const ContactPoint& c, int body_side) const {
  const int middle = first_count(c);
  Front front;
  front.contact = c;
  front.body_side = body_side;
  front.body = names_.owner_index(c.vertex[body_side == 0 ? 0 : middle]);
  const int begin = body_side == 0 ? middle : 0, end = body_side == 0 ? 4 : middle;
  int most = begin;
  for (int k = begin; k < end; ++k)
    if (std::abs(c.weight[k]) > std::abs(c.weight[most])) most = k;
  front.vertex = c.vertex[most];
  front.towards_cloth = body_side == 0 ? Vec3(-c.normal) : c.normal;
  front.push = front.towards_cloth.dot(point_of(c, body_side, failed_.x_t1) -
                                       point_of(c, body_side, failed_.x_t0));
  return front;
}

std::vector<Front> Inquiry::fronts() const {
  const std::vector<ContactPoint> contacts = all_contacts();
  std::vector<std::vector<std::size_t>> at(particles_);
  for (std::size_t i = 0; i < contacts.size(); ++i)
    for (const std::int32_t v : contacts[i].vertex)
      if (is_cloth(v)) at[v].push_back(i);
  std::vector<bool> seen(particles_, false), used(contacts.size(), false);
  std::deque<std::int32_t> queue;
  const auto visit = [&](std::int32_t v) {
    if (is_cloth(v) && !seen[v]) seen[v] = true, queue.push_back(v);
  };
  for (const std::int32_t v : offenders()) visit(v);
  std::vector<Front> found;
  for (; !queue.empty() && found.size() < kFronts; queue.pop_front())
    for (const std::size_t i : at[queue.front()]) {
      if (used[i]) continue;
      used[i] = true;
      const ContactPoint& c = contacts[i];
      for (const std::int32_t v : c.vertex) visit(v);
      if (!is_cloth(c.vertex[0])) found.push_back(front_of(c, 0));
      if (!is_cloth(c.vertex[3])) found.push_back(front_of(c, 1));
    }
  return found;
}

double Inquiry::threshold() const {
  double largest = 0.0;
  for (std::size_t i = 0; i < failed_.x_t0.size(); ++i)
    largest = std::max(largest, moved(static_cast<std::int32_t>(i)).norm());
  return kStandsStill * largest;
}

std::vector<Load> Inquiry::loads_at(std::int32_t vertex) const {
  std::map<std::string, double> by_owner;
  for (const ContactLoad& l : loads_)
    for (int k = 0; k < 4; ++k)
      if (l.contact.vertex[k] == vertex) {
        const int other = k < first_count(l.contact) ? 3 : 0;
        by_owner[names_.owner(l.contact.vertex[other])] +=
            std::abs(l.contact.weight[k]) * l.force.norm();
      }
  std::vector<Load> loads;
  for (const auto& [name, force] : by_owner) loads.push_back({name, force});
  if (const double pull = neighbours_force(vertex).norm(); pull > 0.0)
    loads.push_back({"its neighbours in the cloth", pull});
  return loads;
}

Vec3 Inquiry::neighbours_force(std::int32_t v) const {
  if (attempt_.v.empty() || attempt_.inv_mass[v] <= 0.0) return Vec3::Zero();
  const double mass = 1.0 / attempt_.inv_mass[v];
  Vec3 force = mass * ((attempt_.v[v] - v_[v]) / attempt_.h - scene_.gravity);
  for (const ContactLoad& l : loads_)
    for (int k = 0; k < 4; ++k)
      if (l.contact.vertex[k] == v) force -= l.contact.weight[k] * l.force;
  return force;
}

std::pair<std::int32_t, int> Inquiry::nearest_held(std::int32_t start) const {
  std::vector<std::vector<std::int32_t>> around(particles_);
  for (const Edge& e : unique_edges(triangles_)) {
    around[e[0]].push_back(e[1]);
    around[e[1]].push_back(e[0]);
  }
  std::vector<int> hops(particles_, -1);
  std::deque<std::int32_t> queue{start};
  hops[start] = 0;
  for (; !queue.empty(); queue.pop_front()) {
    const std::int32_t v = queue.front();
    if (is_held(v)) return {v, hops[v]};
    for (const std::int32_t u : around[v])
      if (hops[u] < 0) hops[u] = hops[v] + 1, queue.push_back(u);
  }
  return {-1, 0};
}

}  // namespace selvedge::detail
