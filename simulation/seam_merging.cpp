// SPDX-License-Identifier: MIT
//
// Seams that have closed: the particles of a pair become one, the last step of sewing by Y. Zhong,
// B. Xu, "Three-dimensional garment dressing simulation", Textile Research Journal 2009.
#include <fmt/format.h>
#include <selvedge/scene/internal/adaptive_cloth.h>
#include <selvedge/simulation/detail/way_collisions.h>
#include <selvedge/simulation/internal/mesh_change.h>
#include <selvedge/simulation/internal/seam_merging.h>
#include <selvedge/simulation/simulation_state.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <stdexcept>

namespace selvedge {
namespace {

/// Pairs that are tried one by one where all at once collide; each takes one search.
constexpr std::size_t kMostSingleTries = 16;

void refuse_what_merging_cannot_keep(const Scene& scene, const BuiltScene& built,
                                     const SeamSpec& seam) {
  const char* fault = nullptr;
  if (std::any_of(scene.cloths.begin(), scene.cloths.end(), refine_of))
    fault = "\"refine\" splits the cells that there are";
  if (scene.water) fault = "\"water\" wets the vertices that there are";
  if (scene.contact.untangle_start)
    fault = "contact.start \"untangle\" counts on its vertices; untangle it in a run of its own";
  if (scene.contact.carry_tangled) fault = "contact.still_tangled \"carry\" counts on its vertices";
  if (!built.virtual_springs.empty())
    fault = "\"virtual_springs\" hold the vertices that there are";
  if (fault != nullptr)
    throw std::invalid_argument(
        fmt::format("seam \"{}\": \"merge\" changes the mesh, but {}; leave one of them out",
                    seam.name, fault));
}

std::size_t piece_of(const Scene& scene, const std::string& name) {
  const auto piece = std::find_if(scene.cloths.begin(), scene.cloths.end(),
                                  [&](const ClothSpec& c) { return c.name == name; });
  return static_cast<std::size_t>(piece - scene.cloths.begin());
}

void refuse_bad_distance(const Scene& scene, const ContactPairs& pairs, const SeamSpec& seam) {
  if (!(seam.merge >= 0.0))
    throw std::invalid_argument(fmt::format("seam \"{}\": \"merge\" is {} m; it must be at least 0",
                                            seam.name, seam.merge));
  if (!scene.contact.self) return;
  const double gap = pairs.rest_gap(static_cast<std::int32_t>(piece_of(scene, seam.geometry[0])),
                                    static_cast<std::int32_t>(piece_of(scene, seam.geometry[1])));
  if (seam.merge <= gap)
    throw std::invalid_argument(
        fmt::format("seam \"{}\": \"merge\" is {:g} m, but contacts keep its sides {:g} m apart; "
                    "use at least {:g} m, or a smaller contact.rest_gap",
                    seam.name, seam.merge, gap, 1.5 * gap));
}

bool has_twice(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

}  // namespace

SeamMerging::SeamMerging(const Scene& scene, const BuiltScene& built,
                         const ClothPatternRegistry& patterns)
    : scene_(&scene), patterns_(patterns) {
  const ContactPairs pairs(scene);
  for (std::size_t s = 0; s < scene.seams.size(); ++s) {
    const SeamSpec& seam = scene.seams[s];
    if (seam.merge == 0.0) continue;
    refuse_bad_distance(scene, pairs, seam);
    refuse_what_merging_cannot_keep(scene, built, seam);
    for (const Edge& pair : built.seams[s]) pairs_.push_back({pair, seam.merge});
  }
  if (!active()) return;
  mass_ = built.cloth.mass;
  begin_ = built.piece_begin;
  triangles_ = built.cloth.surface.triangles;
  around_.resize(mass_.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for (const std::int32_t v : triangles_[t]) around_[v].push_back(static_cast<std::int32_t>(t));
  held_.assign(mass_.size(), 0);
  for (const HandleSpec& handle : scene.handles)
    for (const std::int32_t v : handle.vertices)
      held_[begin_[piece_of(scene, handle.geometry)] + v] = 1;
  owner_.resize(mass_.size());
  std::iota(owner_.begin(), owner_.end(), 0);
}

// The vertices in one: the held one represents them, or the one with the smallest index.
void SeamMerging::unite(const Edge& pair, Owners& owner) const {
  const std::int32_t a = owner[pair[0]], b = owner[pair[1]];
  const std::int32_t kept = held_[b] || (!held_[a] && b < a) ? b : a, gone = kept == a ? b : a;
  std::replace(owner.begin(), owner.end(), gone, kept);
}

// New index of every vertex of the scene as it was built.
std::vector<std::int32_t> SeamMerging::numbers(const Owners& owner) {
  std::vector<std::int32_t> rank(owner.size(), 0);
  std::int32_t count = 0;
  for (std::size_t v = 0; v < owner.size(); ++v)
    if (owner[v] == static_cast<std::int32_t>(v)) rank[v] = count++;
  std::vector<std::int32_t> number(owner.size());
  for (std::size_t v = 0; v < owner.size(); ++v) number[v] = rank[owner[v]];
  return number;
}

// Whether the triangles stay triangles, and no two of them become the same.
bool SeamMerging::keeps_surface(const Edge& pair, const Owners& before) const {
  Owners owner = before;
  unite(pair, owner);
  std::set<std::int32_t> around;
  for (std::size_t v = 0; v < owner.size(); ++v)
    if (owner[v] == owner[pair[0]]) around.insert(around_[v].begin(), around_[v].end());
  std::set<Triangle> known;
  for (const std::int32_t t : around) {
    Triangle now = triangles_[t];
    for (std::int32_t& v : now) v = owner[v];
    std::sort(now.begin(), now.end());
    if (has_twice(now) || !known.insert(now).second) return false;
  }
  return true;
}

// The pairs that are near enough and can become one vertex.
std::vector<Edge> SeamMerging::closed(std::span<const Vec3> x) const {
  const std::vector<std::int32_t> now = numbers(owner_);
  std::vector<Edge> closed;
  Owners owner = owner_;
  for (const auto& [pair, distance] : pairs_) {
    if (owner[pair[0]] == owner[pair[1]]) continue;
    if ((x[now[pair[1]]] - x[now[pair[0]]]).norm() > distance) continue;
    if (held_[owner[pair[0]]] && held_[owner[pair[1]]]) continue;
    if (!keeps_surface(pair, owner)) continue;
    unite(pair, owner);
    closed.push_back(pair);
  }
  return closed;
}

SeamMerging::Change SeamMerging::change_to(const Owners& owner) const {
  const std::vector<std::int32_t> before = numbers(owner_), after = numbers(owner);
  Change change;
  change.count = static_cast<std::size_t>(*std::max_element(after.begin(), after.end())) + 1;
  change.after.resize(static_cast<std::size_t>(*std::max_element(before.begin(), before.end())) +
                      1);
  change.mass.assign(change.after.size(), 0.0);
  change.held.assign(change.after.size(), 0);
  for (std::size_t v = 0; v < owner.size(); ++v) {
    change.after[before[v]] = after[v];
    change.mass[before[v]] += mass_[v];
    if (held_[v]) change.held[before[v]] = 1;
  }
  return change;
}

// Σ m u / Σ m of the vertices that become one; exactly u of a vertex that stays alone or is held.
std::vector<Vec3> SeamMerging::Change::means(std::span<const Vec3> u) const {
  std::vector<Vec3> mean(count, Vec3::Zero());
  std::vector<double> total(count, 0.0);
  std::vector<std::int32_t> only(count, -1), parts(count, 0);
  for (std::size_t p = 0; p < after.size(); ++p) {
    const std::int32_t j = after[p];
    mean[j] += mass[p] * u[p];
    total[j] += mass[p];
    if (++parts[j] == 1 || held[p]) only[j] = static_cast<std::int32_t>(p);
  }
  for (std::size_t j = 0; j < count; ++j)
    mean[j] = parts[j] == 1 || held[only[j]] ? u[only[j]] : Vec3(mean[j] / total[j]);
  return mean;
}

// The vertices that collide on the straight way to their common place, as they are numbered after
// the merge.
std::set<std::int32_t> SeamMerging::colliding(const Simulation& simulation,
                                              const Change& change) const {
  const std::span<const Vec3> x = simulation.positions();
  const std::vector<Vec3> place = change.means(x);
  std::vector<Vec3> x_t1;
  for (const std::int32_t j : change.after) x_t1.push_back(place[j]);
  return detail::colliding_on_way({simulation, *scene_, x_t1, change.after});
}

// Removes the pairs that collide if all of the list merge at once, and returns their number.
std::size_t SeamMerging::remove_colliding(const Simulation& simulation,
                                          std::vector<Edge>& pairs) const {
  Owners owner = owner_;
  for (const Edge& pair : pairs) unite(pair, owner);
  const std::set<std::int32_t> found = colliding(simulation, change_to(owner));
  if (found.empty()) return 0;
  const std::vector<std::int32_t> after = numbers(owner);
  const auto removed =
      std::erase_if(pairs, [&](const Edge& pair) { return found.contains(after[pair[0]]); });
  if (removed > 0) return removed;
  const std::size_t all = pairs.size();  // what collides did not move: another frame will show why
  pairs.clear();
  return all;
}

// First all pairs at once, less those that collide until none does. A removed pair may have
// collided only with another removed one, so these are then tried one by one, the nearest first.
SeamMerging::Due SeamMerging::due(const Simulation& simulation) const {
  const std::vector<Edge> all = closed(simulation.positions());
  std::vector<Edge> merged = all;
  while (!merged.empty() && remove_colliding(simulation, merged) > 0) continue;
  std::vector<Edge> rest;
  const std::set<Edge> known(merged.begin(), merged.end());
  for (const Edge& pair : all)
    if (!known.contains(pair)) rest.push_back(pair);
  const std::vector<std::int32_t> now = numbers(owner_);
  const std::span<const Vec3> x = simulation.positions();
  const auto distance = [&](const Edge& pair) {
    return (x[now[pair[1]]] - x[now[pair[0]]]).norm();
  };
  std::stable_sort(rest.begin(), rest.end(),
                   [&](const Edge& a, const Edge& b) { return distance(a) < distance(b); });
  for (std::size_t i = 0; i < std::min(rest.size(), kMostSingleTries); ++i) {
    std::vector<Edge> more = merged;
    more.push_back(rest[i]);
    if (remove_colliding(simulation, more) == 0) merged = std::move(more);
  }
  Due due;
  due.event.time = simulation.time();
  due.postponed = all.size() - merged.size();
  due.event.pairs = std::move(merged);
  return due;
}

void SeamMerging::merge(const MergeEvent& event) {
  const auto n = static_cast<std::int32_t>(owner_.size());
  for (const Edge& pair : event.pairs) {
    if (std::min(pair[0], pair[1]) < 0 || std::max(pair[0], pair[1]) >= n)
      throw std::invalid_argument(
          fmt::format("merge of the vertices {} and {}: the scene has {}", pair[0], pair[1], n));
    unite(pair, owner_);
  }
}

void SeamMerging::merge(const MergeEvent& event, SimulationState& state) {
  Owners owner = owner_;
  for (const Edge& pair : event.pairs) unite(pair, owner);
  const Change change = change_to(owner);
  state.x = change.means(state.x);
  state.v = change.means(state.v);
  state.merges.push_back(event);
  owner_ = std::move(owner);
}

Scene SeamMerging::scene() const {
  Scene scene = with_fixed_mesh(*scene_);
  if (!active()) return scene;
  const std::vector<std::int32_t> number = numbers(owner_);
  for (HandleSpec& handle : scene.handles) {
    const std::int32_t begin = begin_[piece_of(scene, handle.geometry)];
    // The first vertex of a piece may be gone: its rank is that of the first one that is left.
    std::int32_t first = 0;
    for (std::int32_t v = 0; v < begin; ++v) first += owner_[v] == v ? 1 : 0;
    for (std::int32_t& v : handle.vertices) v = number[begin + v] - first;
  }
  return scene;
}

BuiltScene SeamMerging::build() const {
  Methods methods;
  methods.patterns = patterns_;
  BuiltScene built = build_scene(*scene_, methods);
  if (std::none_of(pairs_.begin(), pairs_.end(), [&](const Pair& pair) {
        return owner_[pair.vertices[0]] == owner_[pair.vertices[1]];
      }))
    return built;
  built.merged_areas = start_areas(built);
  const std::vector<std::int32_t> number = numbers(owner_);
  std::vector<std::int32_t> kept;
  std::vector<std::int32_t> begin(built.piece_begin.size(), 0);
  std::vector<Vec3> velocity;
  for (std::size_t v = 0; v < owner_.size(); ++v) {
    if (owner_[v] != static_cast<std::int32_t>(v)) continue;
    kept.push_back(owner_[v]);
    velocity.push_back(built.velocity[v]);
    for (std::size_t p = 0; p < begin.size(); ++p)
      if (static_cast<std::int32_t>(v) < built.piece_begin[p]) ++begin[p];
  }
  built.cloth = merge_vertices(built.cloth, number, kept);
  built.piece_begin = std::move(begin);
  built.velocity = std::move(velocity);
  for (BuiltVolume& volume : built.volumes) {
    volume.centre = number[volume.centre];
    for (Triangle& t : volume.triangles)
      for (std::int32_t& v : t) v = number[v];
  }
  for (BuiltSolid& solid : built.solids) solid.leader = number[solid.leader];
  for (std::vector<Edge>& seam : built.seams) {
    for (Edge& pair : seam) pair = {number[pair[0]], number[pair[1]]};
    std::erase_if(seam, [](const Edge& pair) { return pair[0] == pair[1]; });
  }
  return built;
}

}  // namespace selvedge
