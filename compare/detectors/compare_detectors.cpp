// SPDX-License-Identifier: MIT
#include <selvedge/bodies/mesh_report.h>
#include <selvedge/compare/detectors/compare_detectors.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/system/internal/memory.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/distance.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <iterator>
#include <numbers>
#include <tuple>
#include <utility>

namespace selvedge {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kMilli = 1e3;
/// A measurement that took this long is not repeated.
constexpr double kBudget_ms = 5e3;
constexpr std::size_t kGrain = 2048;

template <class Call>
double milliseconds_of(const Call& call) {
  const Clock::time_point begin = Clock::now();
  call();
  return kMilli * seconds_since(begin);
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void find(BroadPhase& detector, const DetectionCase& c, CandidatePairs& pairs) {
  if (c.self)
    detector.find_self_pairs(c.a, pairs);
  else
    detector.find_pairs(c.a, c.b, pairs);
}

DetectionCase backwards(const DetectionCase& c) {
  DetectionCase back = c;
  std::swap(back.a.x_t0, back.a.x_t1);
  std::swap(back.b.x_t0, back.b.x_t1);
  return back;
}

// -- exact pairs ----------------------------------------------------------------------------------

Query point_query(const SurfaceView& points, const SurfaceView& triangles,
                  const PointTrianglePair& pair) {
  const Triangle& t = triangles.triangles[pair.triangle];
  return {
      ContactKind::point_triangle,
      {points.x_t0[pair.point], triangles.x_t0[t[0]], triangles.x_t0[t[1]], triangles.x_t0[t[2]]},
      {points.x_t1[pair.point], triangles.x_t1[t[0]], triangles.x_t1[t[1]], triangles.x_t1[t[2]]}};
}

Query edge_query(const SurfaceView& a, const SurfaceView& b, const EdgeEdgePair& pair) {
  const Edge &ea = a.edges[pair.edge_a], &eb = b.edges[pair.edge_b];
  return {ContactKind::edge_edge,
          {a.x_t0[ea[0]], a.x_t0[ea[1]], b.x_t0[eb[0]], b.x_t0[eb[1]]},
          {a.x_t1[ea[0]], a.x_t1[ea[1]], b.x_t1[eb[0]], b.x_t1[eb[1]]}};
}

/// The pairs that collide, in their original order.
template <class Pair, class ToQuery>
std::vector<Pair> colliding(const std::vector<Pair>& pairs, const ToQuery& to_query) {
  const std::unique_ptr<NarrowPhase> exact = make_ccd_exact();
  std::vector<std::vector<Pair>> found((pairs.size() + kGrain - 1) / kGrain);
  parallel_for(pairs.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<Query> queries;
    for (std::size_t i = begin; i < end; ++i) queries.push_back(to_query(pairs[i]));
    std::vector<double> toi(queries.size());
    exact->find_times(queries, toi);
    for (std::size_t i = begin; i < end; ++i)
      if (toi[i - begin] != kNoCollision) found[begin / kGrain].push_back(pairs[i]);
  });
  std::vector<Pair> all;
  for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
  return all;
}

CandidatePairs colliding(const DetectionCase& c, const CandidatePairs& boxes) {
  CandidatePairs pairs;
  pairs.point_triangle = colliding(
      boxes.point_triangle, [&](const PointTrianglePair& p) { return point_query(c.a, c.b, p); });
  pairs.triangle_point = colliding(
      boxes.triangle_point, [&](const PointTrianglePair& p) { return point_query(c.b, c.a, p); });
  pairs.edge_edge =
      colliding(boxes.edge_edge, [&](const EdgeEdgePair& p) { return edge_query(c.a, c.b, p); });
  return pairs;
}

// -- sets of pairs --------------------------------------------------------------------------------

/// Output iterator that counts the values written to it.
struct Counter {
  using iterator_category = std::output_iterator_tag;
  using value_type = void;
  using difference_type = std::ptrdiff_t;
  using pointer = void;
  using reference = void;
  std::size_t* count;
  Counter& operator*() { return *this; }
  Counter& operator++() { return *this; }
  Counter operator++(int) { return *this; }
  template <class T>
  Counter& operator=(const T&) {
    ++*count;
    return *this;
  }
};

template <class T>
std::size_t count_missing(const std::vector<T>& wanted, const std::vector<T>& there) {
  std::size_t count = 0;
  std::set_difference(wanted.begin(), wanted.end(), there.begin(), there.end(), Counter{&count});
  return count;
}

/// Number of `wanted` pairs that are missing in `there`; all lists are sorted.
std::size_t count_missing(const CandidatePairs& wanted, const CandidatePairs& there) {
  return count_missing(wanted.point_triangle, there.point_triangle) +
         count_missing(wanted.triangle_point, there.triangle_point) +
         count_missing(wanted.edge_edge, there.edge_edge);
}

std::string failure_of(const BroadPhaseTraits& traits, const DetectorScore& s) {
  if (traits.guarantee != Guarantee::conservative) return {};
  if (s.missed > 0) return "is to miss nothing, and missed " + std::to_string(s.missed);
  if (traits.pairs != PairSet::culled && s.boxes_missed > 0)
    return "is to report all overlapping boxes, and left out " + std::to_string(s.boxes_missed);
  if (traits.pairs == PairSet::boxes && s.beyond_boxes > 0)
    return "is to report overlapping boxes only, and reported " + std::to_string(s.beyond_boxes) +
           " more pairs";
  return {};
}

bool moves(const SurfaceView& surface) {
  return !std::equal(surface.x_t0.begin(), surface.x_t0.end(), surface.x_t1.begin(),
                     surface.x_t1.end());
}

/// True if every edge belongs to two triangles.
bool is_closed(const SurfaceView& surface) {
  std::vector<Edge> sides;
  for (const Triangle& t : surface.triangles)
    for (int k = 0; k < 3; ++k)
      sides.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
  std::sort(sides.begin(), sides.end());
  for (auto begin = sides.begin(); begin != sides.end();) {
    const auto end = std::upper_bound(begin, sides.end(), *begin);
    if (end - begin != 2) return false;
    begin = end;
  }
  return true;
}

}  // namespace

double brute_force_tests(const DetectionCase& c) {
  const auto product = [](std::size_t m, std::size_t n) {
    return static_cast<double>(m) * static_cast<double>(n);
  };
  const double one_way = product(c.a.x_t0.size(), c.b.triangles.size()) +
                         product(c.a.edges.size(), c.b.edges.size()) * (c.self ? 0.5 : 1.0);
  return one_way + (c.self ? 0.0 : product(c.b.x_t0.size(), c.a.triangles.size()));
}

ReferencePairs reference_pairs(const DetectionCase& c, double most_tests,
                               const std::string& judged) {
  ReferencePairs reference;
  // A detector must not be its own reference.
  const std::array<std::string, 2> fast{"bvh_aabb", "sweep_and_prune"};
  reference.boxes_from = brute_force_tests(c) <= most_tests
                             ? "brute_force"
                             : *std::find_if(fast.begin(), fast.end(),
                                             [&](const auto& name) { return name != judged; });
  find(*broad_phases().at(reference.boxes_from)(), c, reference.boxes);
  reference.colliding = colliding(c, reference.boxes);
  return reference;
}

std::string why_not(const BroadPhaseTraits& traits, const DetectionCase& c) {
  if (c.self && !traits.self) return "does not serve a surface against itself";
  if (!traits.deforming && moves(c.b)) return "serves bodies at rest only, and this one moves";
  if (traits.closed_body_only && !is_closed(c.b))
    return "serves closed bodies only, and this surface is open";
  return {};
}

// -- detectors ------------------------------------------------------------------------------------

DetectorTrial::DetectorTrial(Factory make, const DetectionCase& c, const ReferencePairs& reference)
    : make_(std::move(make)), case_(&c), reference_(&reference) {}

void DetectorTrial::measure() {
  CandidatePairs first, second;
  const bool judged = !wall_ms_.empty();
  const std::unique_ptr<BroadPhase> detector = make_();
  PeakMemory memory(!judged);
  wall_ms_.push_back(milliseconds_of([&] { find(*detector, *case_, first); }));
  const std::optional<std::size_t> peak = memory.grown_by();
  const BroadPhaseCost cost = detector->last_cost();
  const bool measures = cost.build_s + cost.refit_s + cost.query_s > 0.0;
  build_ms_.push_back(kMilli * (cost.build_s + cost.refit_s));
  query_ms_.push_back(measures ? kMilli * cost.query_s : wall_ms_.back());
  find(*detector, backwards(*case_), second);
  const BroadPhaseCost again = detector->last_cost();
  refit_ms_.push_back(kMilli * (again.build_s + again.refit_s));
  if (judged) return;
  score_.peak_bytes = std::max(cost.bytes, peak.value_or(0));
  judge(first, second);
  if (detector->traits().particles)
    score_.particles = score_particles(*detector, case_->a, case_->b);
  score_.failure = failure_of(detector->traits(), score_);
}

void DetectorTrial::judge(const CandidatePairs& first, const CandidatePairs& second) {
  DetectorScore& s = score_;
  s.triangle_point = first.triangle_point.size();
  s.point_triangle = first.point_triangle.size() + s.triangle_point;
  s.edge_edge = first.edge_edge.size();
  s.missed = std::max(count_missing(reference_->colliding, first),
                      count_missing(reference_->colliding, second));
  const std::size_t all = reference_->colliding.size();
  s.recall = all == 0 ? 1.0 : static_cast<double>(all - s.missed) / static_cast<double>(all);
  s.boxes_missed = count_missing(reference_->boxes, first);
  s.beyond_boxes = count_missing(first, reference_->boxes);
}

bool DetectorTrial::slow() const {
  double spent = 0.0;
  for (const double ms : wall_ms_) spent += ms;
  return spent > kBudget_ms;
}

DetectorScore DetectorTrial::score() const {
  DetectorScore s = score_;
  s.build_ms = median(build_ms_);
  s.refit_ms = median(refit_ms_);
  s.query_ms = median(query_ms_);
  s.wall_ms = median(wall_ms_);
  return s;
}

// -- particles ------------------------------------------------------------------------------------

namespace {

/// The nearest point of a body as a particle sees it.
struct ExactDistance {
  double distance = HUGE_VAL;  ///< m; negative: inside
  Vec3 normal = Vec3::Zero();  ///< unit, away from the body; zero on its surface
};

ExactDistance exact_distance(const Vec3& x, const SurfaceView& body, const ClosedParts& parts) {
  ExactDistance exact;
  Vec3 separation = Vec3::Zero();
  for (const Triangle& t : body.triangles) {
    const ClosestPoints closest =
        point_triangle_closest(x, body.x_t1[t[0]], body.x_t1[t[1]], body.x_t1[t[2]]);
    if (closest.distance >= exact.distance) continue;
    exact.distance = closest.distance;
    separation = closest.separation;
  }
  const double side = parts.may_contain(x) && parts.part_around(x) >= 0 ? -1.0 : 1.0;
  if (exact.distance > 0.0) exact.normal = side / exact.distance * separation;
  exact.distance *= side;
  return exact;
}

}  // namespace

ParticleScore score_particles(BroadPhase& detector, const SurfaceView& a, const SurfaceView& b) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  ParticleScore score;
  score.reach = a.thickness + b.thickness;
  std::vector<ParticleContact> contacts;
  detector.find_particle_contacts(a, b, score.reach, contacts);
  std::vector<const ParticleContact*> of(a.x_t1.size(), nullptr);
  for (const ParticleContact& c : contacts) of[c.pair.point] = &c;

  const ClosedParts parts({.vertices = {b.x_t1.begin(), b.x_t1.end()},
                           .triangles = {b.triangles.begin(), b.triangles.end()}});
  std::vector<ExactDistance> exact(a.x_t1.size());
  constexpr std::size_t kFew = 8;
  parallel_for(exact.size(), kFew, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) exact[i] = exact_distance(a.x_t1[i], b, parts);
  });

  std::size_t right = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const bool touches = exact[i].distance < score.reach || exact[i].distance < 0.0;
    score.touching += touches ? 1 : 0;
    if (of[i] == nullptr || !touches) {
      (touches ? score.missed : score.false_alarms) += touches || of[i] != nullptr ? 1 : 0;
      continue;
    }
    ++right;
    const double error = std::abs(of[i]->distance - exact[i].distance);
    score.max_depth_error = std::max(score.max_depth_error, error);
    score.mean_depth_error += error;
    const double cosine = std::clamp(of[i]->normal.dot(exact[i].normal), -1.0, 1.0);
    if (!exact[i].normal.isZero(0.0))
      score.max_normal_error = std::max(score.max_normal_error, kDegrees * std::acos(cosine));
  }
  if (right > 0) score.mean_depth_error /= static_cast<double>(right);
  return score;
}

// -- contacts -------------------------------------------------------------------------------------

namespace {

using ContactKey = std::pair<ContactKind, std::array<std::int32_t, 4>>;

std::vector<ContactKey> keys_of(const std::vector<Contact>& contacts) {
  std::vector<ContactKey> keys;
  for (const Contact& c : contacts) keys.emplace_back(c.kind, c.vertex);
  std::sort(keys.begin(), keys.end());
  return keys;
}

std::vector<ContactKey> keys_of(const DetectionCase& c, const CandidatePairs& pairs) {
  std::vector<ContactKey> keys;
  const auto add_points = [&](ContactKind kind, const SurfaceView& surface, const auto& list) {
    for (const PointTrianglePair& p : list) {
      const Triangle& t = surface.triangles[p.triangle];
      keys.push_back({kind, {p.point, t[0], t[1], t[2]}});
    }
  };
  add_points(ContactKind::point_triangle, c.b, pairs.point_triangle);
  add_points(ContactKind::triangle_point, c.a, pairs.triangle_point);
  for (const EdgeEdgePair& p : pairs.edge_edge) {
    const Edge &ea = c.a.edges[p.edge_a], &eb = c.b.edges[p.edge_b];
    keys.push_back({ContactKind::edge_edge, {ea[0], ea[1], eb[0], eb[1]}});
  }
  std::sort(keys.begin(), keys.end());
  return keys;
}

}  // namespace

ContactScore score_contacts(const NarrowPhase& method, const DetectionCase& c,
                            const ReferencePairs& reference, int repeats) {
  ContactScore score;
  std::vector<Contact> contacts;
  const SurfaceView& b = c.self ? c.a : c.b;  // self pairs require the same view twice
  std::vector<double> ms;
  double spent = 0.0;
  for (int r = 0; r < repeats && spent < kBudget_ms; ++r) {
    ms.push_back(milliseconds_of([&] { method.find_contacts(c.a, b, reference.boxes, contacts); }));
    spent += ms.back();
  }
  score.ms = median(ms);
  score.contacts = contacts.size();
  if (method.traits().gives_time)
    for (const Contact& contact : contacts)
      score.first_toi = std::min(score.first_toi.value_or(contact.toi), contact.toi);
  const std::vector<ContactKey> found = keys_of(contacts), truth = keys_of(c, reference.colliding);
  score.missed = count_missing(truth, found);
  score.false_alarms = count_missing(found, truth);
  return score;
}

}  // namespace selvedge
