// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/triangle_mesh.h>
#include <selvedge/narrowphase/ccd_exact.h>
#include <selvedge/scene/explain_step.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <set>

namespace selvedge {
namespace {

// Two bodies squeeze what is between them if their pushes differ by more than this cosine's angle
// (120 degrees).
constexpr double kOpposed = -0.5;

// So many contacts with bodies are followed back from the particles that collide: those nearest to
// them in the chain of contacts.
constexpr std::size_t kFronts = 400;

// Places where two bodies near each other at this share of the largest speed count as fastest.
constexpr double kAsFast = 0.99;

// A displacement below this share of the largest in the try is rounding, not motion.
constexpr double kStandsStill = 1e-9;

/// 0.00231 m as "2.31 mm".
std::string length(double metres) {
  const double size = std::abs(metres);
  if (size != 0.0 && size < 1e-6) return fmt::format("{:.3g} nm", 1e9 * metres);
  if (size < 1e-3) return fmt::format("{:.3g} um", 1e6 * metres);
  if (size < 1.0) return fmt::format("{:.3g} mm", 1e3 * metres);
  return fmt::format("{:.3g} m", metres);
}

std::string duration(double seconds) { return fmt::format("{:.3g} ms", 1e3 * seconds); }

/// The contact point of the first (0) or second (1) primitive.
Vec3 point_of(const ContactPoint& c, int primitive, const std::vector<Vec3>& x) {
  const int middle = first_count(c);
  Vec3 point = Vec3::Zero();
  for (int k = primitive == 0 ? 0 : middle; k < (primitive == 0 ? middle : 4); ++k)
    point += std::abs(c.weight[k]) * x[c.vertex[k]];
  return point;
}

/// A body that touches cloth somewhere along the chain of contacts.
struct Front {
  ContactPoint contact;
  int body_side;        // primitive of the contact that is the body's
  std::size_t body;     // owner index
  std::int32_t vertex;  // of the cloth, the one with the most weight
  Vec3 towards_cloth;   // unit
  double push;          // m, motion of the body towards the cloth in the try
};

class Inquiry {
 public:
  Inquiry(const Scene& scene, const Simulation& simulation, const RecordedTry& attempt)
      : scene_(scene),
        simulation_(simulation),
        names_(simulation.names()),
        failed_(simulation.failed_try()),
        try_(attempt),
        particles_(simulation.state().x.size()),
        loads_(attempt.loads()) {
    note_handles();
  }

  Explanation explain() {
    Explanation explanation;
    explanation.h = try_.h;
    explanation.colliding_pairs = failed_.pairs.size();
    if (failed_.not_finite >= 0)
      explanation.culprits.push_back(nowhere());
    else
      find_culprits(explanation.culprits);
    for (std::size_t i = 0; i < std::min(failed_.pairs.size(), kExplainedPairs); ++i)
      explanation.pairs.push_back(explain_pair(failed_.pairs[i]));
    return explanation;
  }

 private:
  bool is_cloth(std::int32_t v) const { return static_cast<std::size_t>(v) < particles_; }
  bool is_held(std::int32_t v) const { return is_cloth(v) && try_.inv_mass[v] <= 0.0; }
  Vec3 moved(std::int32_t v) const { return failed_.x_t1[v] - failed_.x_t0[v]; }

  // -- handles and bodies that move ---------------------------------------------------------------

  void note_handles() {
    for (std::size_t h = 0; h < scene_.handles.size(); ++h)
      for (std::size_t p = 0; p < scene_.cloths.size(); ++p) {
        if (scene_.cloths[p].name != scene_.handles[h].geometry) continue;
        for (const std::int32_t v : scene_.handles[h].vertices)
          if (is_held(names_.first(p) + v)) handle_[names_.first(p) + v] = h;
      }
  }

  std::string handle_name(std::int32_t vertex) const {
    const auto handle = handle_.find(vertex);
    if (handle == handle_.end()) return "a handle";
    const std::string& name = scene_.handles[handle->second].name;
    return name.empty() ? fmt::format("handle {}", handle->second)
                        : fmt::format("handle \"{}\"", name);
  }

  // -- the chain of contacts ----------------------------------------------------------------------

  std::set<std::int32_t> offenders() const {
    std::set<std::int32_t> vertices;
    for (const ContactPoint& c : failed_.pairs)
      for (int k = 0; k < 4; ++k)
        if (is_cloth(c.vertex[k])) vertices.insert(c.vertex[k]);
    return vertices;
  }

  std::vector<ContactPoint> all_contacts() const {
    std::vector<ContactPoint> all = failed_.pairs;
    all.insert(all.end(), try_.contacts.begin(), try_.contacts.end());
    return all;
  }

  Front front_of(const ContactPoint& c, int body_side) const {
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

  /// Breadth first from the particles that collide, over contacts, through all layers of cloth.
  std::vector<Front> fronts() const {
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

  // -- culprits -----------------------------------------------------------------------------------

  void find_culprits(std::vector<Culprit>& culprits) const {
    const std::vector<Front> found = fronts();
    add_squeezes(found, culprits);
    add_pushes(found, culprits);
    add_carriers(culprits);
    add_pulls(culprits);
    std::stable_sort(culprits.begin(), culprits.end(),
                     [](const Culprit& a, const Culprit& b) { return a.motion > b.motion; });
    if (culprits.empty() && !failed_.pairs.empty()) culprits.push_back(meeting(failed_.pairs[0]));
    if (culprits.empty())
      culprits.push_back({"meet", "no pair collided in the last try: " + failed_.trouble, {}});
  }

  /// Length that is motion and not rounding.
  double threshold() const {
    double largest = 0.0;
    for (std::size_t i = 0; i < failed_.x_t0.size(); ++i)
      largest = std::max(largest, moved(static_cast<std::int32_t>(i)).norm());
    return kStandsStill * largest;
  }

  /// Contacts at a particle in the last solve, by who is on the other side, and what its
  /// neighbours in the cloth do to it.
  std::vector<Load> loads_at(std::int32_t vertex) const {
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

  /// Two fronts with the cloth between them that come nearer.
  struct Jaws {
    const Front *a, *b;
    double nearing, room;  // m
  };

  std::map<std::pair<std::size_t, std::size_t>, std::vector<Jaws>> closing_jaws(
      const std::vector<Front>& found) const {
    const double least = threshold();
    std::map<std::pair<std::size_t, std::size_t>, std::vector<Jaws>> jaws;
    for (std::size_t i = 0; i < found.size(); ++i)
      for (std::size_t j = i + 1; j < found.size(); ++j) {
        const Front &a = found[i], &b = found[j];
        const double nearing = a.push + b.push;
        if (a.towards_cloth.dot(b.towards_cloth) > kOpposed || nearing <= least) continue;
        const double room = a.towards_cloth.dot(point_of(b.contact, b.body_side, failed_.x_t0) -
                                                point_of(a.contact, a.body_side, failed_.x_t0));
        if (room > 0.0)  // else back to back, and the cloth is not between them
          jaws[std::minmax(a.body, b.body)].push_back({&a, &b, nearing, room});
      }
    return jaws;
  }

  /// Bodies, or parts of one, that come nearer with the cloth between them: of each two owners the
  /// place with the least room among those where they near each other fastest.
  void add_squeezes(const std::vector<Front>& found, std::vector<Culprit>& culprits) const {
    for (const auto& [owners, jaws] : closing_jaws(found)) {
      double fastest = 0.0;
      for (const Jaws& j : jaws) fastest = std::max(fastest, j.nearing);
      const Jaws* tightest = nullptr;
      for (const Jaws& j : jaws)
        if (j.nearing >= kAsFast * fastest && (tightest == nullptr || j.room < tightest->room))
          tightest = &j;
      culprits.push_back(squeeze(*tightest->a, *tightest->b, tightest->nearing, tightest->room));
    }
  }

  Culprit squeeze(const Front& a, const Front& b, double nearing, double room) const {
    const bool one = a.body == b.body;
    const std::string name_a = names_.owner_name(a.body), name_b = names_.owner_name(b.body);
    Culprit culprit;
    culprit.kind = "squeeze";
    culprit.names = one ? std::vector{name_a} : std::vector{name_a, name_b};
    culprit.names.push_back(names_.owner(a.vertex));
    culprit.vertex = a.vertex;
    culprit.motion = nearing;
    culprit.room = room;
    culprit.loads = loads_at(a.vertex);
    culprit.sentence = fmt::format(
        "{} {} {} between them: in this try of {} they come {} nearer to each other ({} by {}, {} "
        "by {}), and {} is all that is between them at {}",
        one ? "two parts of " + name_a : name_a + " and " + name_b, "squeeze",
        names_.owner(a.vertex), duration(try_.h), length(nearing), one ? "one" : name_a,
        length(a.push), one ? "the other" : name_b, length(b.push), length(room),
        names_.vertex(a.vertex));
    return culprit;
  }

  /// Bodies that move into the cloth and squeeze it against no other body.
  void add_pushes(const std::vector<Front>& found, std::vector<Culprit>& culprits) const {
    const double least = threshold();
    std::map<std::size_t, const Front*> hardest;
    for (const Front& f : found) {
      const Front*& known = hardest[f.body];
      if (f.push > least && (known == nullptr || f.push > known->push)) known = &f;
    }
    for (const auto& [body, front] : hardest) {
      const std::string name = names_.owner_name(body);
      const bool told = std::any_of(culprits.begin(), culprits.end(), [&](const Culprit& c) {
        return std::find(c.names.begin(), c.names.end(), name) != c.names.end();
      });
      if (front == nullptr || told) continue;
      culprits.push_back({"push",
                          fmt::format("{} pushes {}: it moves by {} towards {} in this try of {}",
                                      name, names_.owner(front->vertex), length(front->push),
                                      names_.vertex(front->vertex), duration(try_.h)),
                          {name, names_.owner(front->vertex)},
                          front->vertex,
                          front->push,
                          0.0,
                          loads_at(front->vertex)});
    }
  }

  /// Held particles that are carried into something themselves.
  void add_carriers(std::vector<Culprit>& culprits) const {
    std::set<std::string> told;
    for (const ContactPoint& c : failed_.pairs)
      for (int k = 0; k < 4; ++k) {
        const std::int32_t v = c.vertex[k];
        const double distance = moved(v).norm();
        if (!is_held(v) || distance <= threshold() || !told.insert(handle_name(v)).second) continue;
        const std::int32_t other = c.vertex[k < first_count(c) ? 3 : 0];
        culprits.push_back(
            {"carry",
             fmt::format("{} carries {} into {}: it moves it by {} in this try of {}",
                         handle_name(v), names_.vertex(v), names_.owner(other), length(distance),
                         duration(try_.h)),
             {handle_name(v), names_.owner(v), names_.owner(other)},
             v,
             distance});
      }
  }

  // -- handles that pull through the cloth
  // ----------------------------------------------------------

  /// The force that the cloth's own springs and bending put on a particle in the last solve, N:
  /// what mass times acceleration, weight and contacts leave over.
  Vec3 neighbours_force(std::int32_t v) const {
    if (try_.v.empty() || try_.inv_mass[v] <= 0.0) return Vec3::Zero();
    const double mass = 1.0 / try_.inv_mass[v];
    Vec3 force = mass * ((try_.v[v] - simulation_.state().v[v]) / try_.h - scene_.gravity);
    for (const ContactLoad& l : loads_)
      for (int k = 0; k < 4; ++k)
        if (l.contact.vertex[k] == v) force -= l.contact.weight[k] * l.force;
    return force;
  }

  /// The held particle nearest to `start` in edges, and how many; -1 if none is connected.
  std::pair<std::int32_t, int> nearest_held(std::int32_t start) const {
    std::vector<std::vector<std::int32_t>> around(particles_);
    for (const Edge& e : unique_edges(simulation_.cloth_triangles())) {
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

  /// The offender whose neighbours pull it hardest into what it collides with.
  void add_pulls(std::vector<Culprit>& culprits) const {
    double hardest = 0.0;
    std::int32_t pulled = -1, other = -1;
    for (const ContactPoint& c : failed_.pairs)
      for (int k = 0; k < 4; ++k) {
        if (!is_cloth(c.vertex[k]) || is_held(c.vertex[k])) continue;
        const double side = k < first_count(c) ? -1.0 : 1.0;  // into the other primitive
        const double pull = side * c.normal.dot(neighbours_force(c.vertex[k]));
        if (pull <= hardest) continue;
        hardest = pull;
        pulled = c.vertex[k];
        other = c.vertex[k < first_count(c) ? 3 : 0];
      }
    if (pulled < 0) return;
    const auto [held, hops] = nearest_held(pulled);
    if (held < 0 || hops == 0) return;
    const double distance = moved(held).norm();
    if (distance <= threshold()) return;
    culprits.push_back(
        {"pull",
         fmt::format("{} pulls at {}: it moves its end by {} in this try of {}, {} edges from {}, "
                     "which its neighbours pull with {:.3g} N into {}",
                     handle_name(held), names_.owner(held), length(distance), duration(try_.h),
                     hops, names_.vertex(pulled), hardest, names_.owner(other)),
         {handle_name(held), names_.owner(held), names_.owner(other)},
         pulled,
         distance,
         0.0,
         loads_at(pulled)});
  }

  // -- without anybody who moves on purpose
  // ---------------------------------------------------------

  Culprit meeting(const ContactPoint& c) const {
    const double approach =
        -c.normal.dot(relative(c, failed_.x_t1) - relative(c, failed_.x_t0)) / try_.h;
    const PairExplanation told = explain_pair(c);
    const std::int32_t second = c.vertex[first_count(c)];
    return {"meet",
            fmt::format("{} runs into {}: at {} they near each other at {:.3g} m/s, {}",
                        names_.owner(c.vertex[0]), names_.owner(second), names_.pair(c), approach,
                        told.brought_by.empty() ? "and no stage of the step parted them"
                                                : "brought there by: " + told.brought_by),
            {names_.owner(c.vertex[0]), names_.owner(second)},
            c.vertex[0],
            approach * try_.h,
            0.0,
            loads_at(c.vertex[0])};
  }

  Culprit nowhere() const {
    const std::int32_t v = failed_.not_finite;
    std::string stage = "the start of the step";
    for (const RecordedStage& s : try_.stages)
      if (!s.x_t1[v].allFinite()) {
        stage = "\"" + s.name + "\"";
        break;
      }
    const Vec3 velocity = simulation_.state().v[v];
    return {"not finite",
            fmt::format("{} loses its position in {}: it starts at {:.3g} m/s with a mass of "
                        "{:.3g} kg; look for a stiffness, a speed or a time step out of all "
                        "proportion",
                        names_.vertex(v), stage, velocity.norm(),
                        try_.inv_mass[v] > 0.0 ? 1.0 / try_.inv_mass[v] : 0.0),
            {names_.owner(v)},
            v};
  }

  // -- a pair, stage by stage
  // -----------------------------------------------------------------------

  PairExplanation explain_pair(const ContactPoint& c) const {
    PairExplanation told;
    told.pair = c;
    told.name = names_.pair(c);
    const std::vector<Vec3>* before = nullptr;
    std::map<std::string, int> met;
    for (const RecordedStage& s : try_.stages) {
      const int which = ++met[s.name];
      std::string name = which == 1 ? s.name : fmt::format("{} {}", s.name, which);
      if (s.times > 1) name += fmt::format(" ({} times)", s.times);
      told.stages.push_back(pair_stage(c, name, s.x_t1, before));
      before = &s.x_t1;
    }
    told.stages.push_back(pair_stage(c, "last paths tested", failed_.x_t1, before));
    for (auto stage = told.stages.rbegin(); stage != told.stages.rend() && stage->collides; ++stage)
      told.brought_by = stage->stage;
    return told;
  }

  PairStage pair_stage(const ContactPoint& c, const std::string& name, const std::vector<Vec3>& x,
                       const std::vector<Vec3>* before) const {
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

  const Scene& scene_;
  const Simulation& simulation_;
  const VertexNames& names_;
  const FailedTry& failed_;
  const RecordedTry& try_;
  std::size_t particles_;
  std::vector<ContactLoad> loads_;
  std::map<std::int32_t, std::size_t> handle_;  // of held particles
  std::unique_ptr<NarrowPhase> exact_ = make_ccd_exact();
};

}  // namespace

Explanation explain_step(const Scene& scene, const Simulation& simulation,
                         const RecordedTry& attempt) {
  return Inquiry(scene, simulation, attempt).explain();
}

}  // namespace selvedge
