// SPDX-License-Identifier: MIT
// The detector of [VassilevSpanlang2000]; survey section 6.1.3 "Image space". Deviations: particles
// beside the outline are answered by further views, and the depth along the axis is turned into a
// distance along the normal, so that a rest gap means the same everywhere. Views and resolution
// follow from the body and the reach unless they are given.
#include <selvedge/broadphase/detail/box_pairs.h>
#include <selvedge/broadphase/detail/collect_pairs.h>
#include <selvedge/broadphase/image_space/image_space.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

/// A particle outside the body is answered by a view if its depth there is at most this multiple of
/// the reach. Far from a steep place the product of depth and cosine is no distance. A normal
/// within 60 degrees of the axis needs no more, and one of three views sees every place so.
constexpr double kDeepest = 2.0;

/// Of the area of a body, the part that enough views show under at most 60 degrees.
constexpr double kShown = 0.99;
constexpr double kSteepestCosine = 0.5;

/// Distances are wrong by sideways_error() at most where a view shows the body under 60 degrees.
/// The chosen resolution makes that an eighth of the reach, which is less than a fifth of the rest
/// gap.
constexpr double kErrorOfReach = 0.125;
constexpr int kLeastTexels = 64, kMostTexels = 4096, kTexelsOfTiles = 64;
/// Without a reach: pairs for a narrow phase.
constexpr int kUsualTexels = 512;

constexpr std::size_t kParticleGrain = 2048;  // particles per range: about 100 µs of work

/// The axes of the world, that of the shortest side of the box first.
std::array<int, 3> axes_by_extent(std::span<const Vec3> x) {
  Vec3 lo = x[0], hi = x[0];
  for (const Vec3& p : x) {
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
  const Vec3 extent = hi - lo;
  std::array<int, 3> axes = {0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](int i, int j) { return extent[i] < extent[j]; });
  return axes;
}

/// How many views, in the order of `axes`, show kShown of the area of the body under at most 60
/// degrees; 3 if it takes all.
int views_for(const SurfaceView& body, const std::array<int, 3>& axes) {
  std::array<double, 3> shown{};
  double whole = 0.0;
  for (const Triangle& t : body.triangles) {
    const Vec3& x = body.x_t1[t[0]];
    const Vec3 area = 0.5 * (body.x_t1[t[1]] - x).cross(body.x_t1[t[2]] - x);
    whole += area.norm();
    bool seen = false;
    for (std::size_t k = 0; k < 3; ++k) {
      seen = seen || std::abs(area[axes[k]]) >= kSteepestCosine * area.norm();
      if (seen) shown[k] += area.norm();
    }
  }
  for (int k = 0; k < 2; ++k)
    if (shown[k] >= kShown * whole) return k + 1;
  return 3;
}

/// Texels along the longer side of a picture of the box [lo, hi] for an error of `error` (m).
int texels_for(std::span<const Vec3> x, double error) {
  Vec3 lo = x[0], hi = x[0];
  for (const Vec3& p : x) {
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
  const double texels = (hi - lo).maxCoeff() / (std::sqrt(2.0) * error);
  const double tiles = std::ceil(std::min(texels, double{kMostTexels}) / kTexelsOfTiles);
  return std::clamp(static_cast<int>(tiles) * kTexelsOfTiles, kLeastTexels, kMostTexels);
}

/// Barycentric coordinates of q in the triangle, both seen along an axis of the world; brought into
/// the triangle, because a texel shows it a little beyond its sides.
Vec3 coordinates_along(int axis, const Vec3& q, const std::array<Vec3, 3>& corner) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const auto area = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    return (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
  };
  const Vec3 part(area(q, corner[1], corner[2]), area(corner[0], q, corner[2]),
                  area(corner[0], corner[1], q));
  const double whole = area(corner[0], corner[1], corner[2]);
  Vec3 weight = (whole == 0.0 ? Vec3::Ones() : Vec3(part / whole)).cwiseMax(0.0);
  const double sum = weight.sum();
  return sum > 0.0 && std::isfinite(sum) ? Vec3(weight / sum) : Vec3(Vec3::Constant(1.0 / 3.0));
}

}  // namespace

struct ParticleMaps::State {
  ParticleMapsConfig config;
  std::array<std::optional<DepthNormalMaps>, 3> maps;  // by axis; drawn when first used
  std::array<int, 3> axes{0, 1, 2};                    // of the views, in the order of their use
  int count = 0;                                       // of the views; 0: not chosen
  int texels = 0;                                      // along a picture; 0: not chosen
  detail::SurfaceBoxes boxes_a, boxes_b;
  std::array<std::vector<ParticleAnswer>, 3> seen;  // by axis, of each particle
  std::vector<ParticleContact> answers;             // of each particle
  std::vector<detail::FoundPairs> parts{detail::kBoxPairParts};
  detail::PairCollector collector;
  BroadPhaseCost cost;

  std::span<const int> views() const { return std::span(axes).first(count); }
  void draw(const SurfaceView& body, double reach);
  ParticleContact answer(std::size_t particle, const SurfaceView& cloth, const SurfaceView& body,
                         double reach) const;
};

void ParticleMaps::State::draw(const SurfaceView& body, double reach) {
  axes = axes_by_extent(body.x_t1);
  if (count == 0) count = config.views > 0 ? config.views : views_for(body, axes);
  if (texels == 0 && config.resolution == 0 && reach > 0.0)
    texels = texels_for(body.x_t1, kErrorOfReach * reach);
  if (texels == 0) texels = config.resolution > 0 ? config.resolution : kUsualTexels;
  for (const int axis : views()) {
    if (!maps[axis])
      maps[axis].emplace(DepthNormalConfig{.resolution = texels, .axis = Vec3::Unit(axis)});
    maps[axis]->update(body);
  }
}

/// The contact of a particle; its distance is infinite if the particle is outside the body by more
/// than a picture can tell.
ParticleContact ParticleMaps::State::answer(std::size_t particle, const SurfaceView& cloth,
                                            const SurfaceView& body, double reach) const {
  ParticleContact best{.pair = {static_cast<std::int32_t>(particle), -1}, .distance = -HUGE_VAL};
  int best_axis = -1;
  double blur = HUGE_VAL;  // m, of the pictures that show the particle outside
  for (const int axis : views()) {
    const ParticleAnswer& one = seen[axis][particle];
    if (!one.covered || -one.depth > kDeepest * reach) {
      blur = std::min(blur, maps[axis]->sideways_error());
      continue;
    }
    const double distance = -one.depth * std::abs(one.normal[axis]);
    if (distance <= best.distance) continue;
    best.distance = distance;
    best_axis = axis;
  }
  if (best_axis < 0 || (blur < HUGE_VAL && best.distance < -blur)) {
    best.distance = HUGE_VAL;
    return best;
  }
  const ParticleAnswer& chosen = seen[best_axis][particle];
  const Triangle& t = body.triangles[chosen.triangle];
  const Vec3& x = cloth.x_t1[particle];
  best.pair.triangle = chosen.triangle;
  best.normal = chosen.normal;
  best.weight =
      coordinates_along(best_axis, x, {body.x_t1[t[0]], body.x_t1[t[1]], body.x_t1[t[2]]});
  return best;
}

ParticleMaps::ParticleMaps(const ParticleMapsConfig& config) : state_(std::make_unique<State>()) {
  state_->config = config;
  if (config.resolution != 0)
    DepthNormalMaps({.resolution = config.resolution});  // refuses a resolution out of range
  if (config.views < 0 || config.views > 3)
    throw std::invalid_argument("depth_normal_maps: " + std::to_string(config.views) +
                                " views; give 1, 2 or 3, or 0 for as many as the body needs");
}
ParticleMaps::~ParticleMaps() = default;

void ParticleMaps::find_particle_contacts(const SurfaceView& a, const SurfaceView& b, double reach,
                                          std::vector<ParticleContact>& out) {
  State& s = *state_;
  out.clear();
  detail::check_shape(a, "first surface");
  detail::check_shape(b, "second surface");
  if (a.x_t1.empty() || b.triangles.empty()) return;
  s.draw(b, reach);
  for (const int axis : s.views()) {
    s.seen[axis].resize(a.x_t1.size());
    s.maps[axis]->answer(a.x_t1, s.seen[axis]);
  }
  s.answers.resize(a.x_t1.size());
  parallel_for(a.x_t1.size(), kParticleGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) s.answers[i] = s.answer(i, a, b, reach);
  });
  std::copy_if(s.answers.begin(), s.answers.end(), std::back_inserter(out),
               [&](const ParticleContact& c) { return c.distance < reach; });
}

void ParticleMaps::find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) {
  State& s = *state_;
  out.clear();
  s.cost = {};
  detail::check_shape(a, "first surface");
  detail::check_shape(b, "second surface");
  const auto begin = std::chrono::steady_clock::now();
  detail::check_indices(a, "first surface");
  detail::check_finite(a, "first surface");
  detail::check_indices(b, "second surface");
  detail::check_finite(b, "second surface");
  if (a.x_t1.empty() || b.triangles.empty()) return;
  const bool is_first = renders() == 0;
  s.draw(b, 0.0);
  (is_first ? s.cost.build_s : s.cost.refit_s) = seconds_since(begin);
  const auto drawn = std::chrono::steady_clock::now();
  s.boxes_a.fit(a);
  s.boxes_b.fit(b);
  detail::PairTally tally(budget(), detail::PairBuffer::kBytesPerPair);
  for (detail::FoundPairs& part : s.parts) part.start(&tally);
  detail::PairParts pairs(s.parts, &detail::FoundPairs::point_triangle, nullptr);
  const std::size_t grain = std::max(kParticleGrain, a.x_t1.size() / detail::kBoxPairParts + 1);
  parallel_for(a.x_t1.size(), grain, [&](std::size_t first, std::size_t last) {
    std::vector<std::int32_t> shown;
    for (std::size_t i = first; i < last; ++i) {
      shown.clear();
      for (const int axis : s.views())
        for (const Vec3& x : {a.x_t0[i], a.x_t1[i]})
          for (const std::int32_t t : s.maps[axis]->triangles_at(x))
            if (t >= 0 && detail::overlap(s.boxes_a.points[i], s.boxes_b.triangles[t]))
              shown.push_back(t);
      std::sort(shown.begin(), shown.end());
      shown.erase(std::unique(shown.begin(), shown.end()), shown.end());
      for (const std::int32_t t : shown) pairs.add(first / grain, static_cast<std::int32_t>(i), t);
    }
  });
  for (detail::FoundPairs& part : s.parts) part.finish();
  s.collector.collect(s.parts, &detail::FoundPairs::point_triangle, a.x_t0.size(),
                      b.triangles.size(), out.point_triangle);
  s.cost.query_s = seconds_since(drawn);
}

void ParticleMaps::find_self_pairs(const SurfaceView&, CandidatePairs& out) {
  out.clear();
  throw std::invalid_argument(
      "depth_normal_maps: does not support a surface with itself, which has no inside; use "
      "bvh_aabb");
}

BroadPhaseTraits ParticleMaps::traits() const {
  return {.guarantee = Guarantee::approximate,
          .self = false,
          .closed_body_only = true,
          .particles = true,
          .source =
              "depth and normal maps of a body, drawn off screen; T. Vassilev, B. Spanlang, "
              "Efficient cloth model for dressing animated virtual people, 2000; with "
              "Y. Chrysanthou, Fast cloth animation on walking avatars, 2001"};
}

BroadPhaseCost ParticleMaps::last_cost() const {
  BroadPhaseCost cost = state_->cost;
  cost.bytes = state_->boxes_a.bytes() + state_->boxes_b.bytes() + state_->collector.bytes() +
               state_->answers.capacity() * sizeof(ParticleContact);
  for (const detail::FoundPairs& part : state_->parts) cost.bytes += part.bytes();
  for (const auto& maps : state_->maps)
    if (maps)
      cost.bytes += 2 * maps->front().triangle.size() *
                    (sizeof(std::int32_t) + sizeof(float) + 2 * sizeof(Eigen::Vector3f));
  return cost;
}

std::size_t ParticleMaps::renders() const {
  return std::accumulate(
      state_->maps.begin(), state_->maps.end(), std::size_t{0},
      [](std::size_t sum, const auto& maps) { return sum + (maps ? maps->renders() : 0); });
}

int ParticleMaps::views() const { return state_->count; }

double ParticleMaps::sideways_error() const {
  double worst = 0.0;
  for (const int axis : state_->views())
    if (state_->maps[axis]) worst = std::max(worst, state_->maps[axis]->sideways_error());
  return worst;
}

void register_particle_maps(BroadPhaseRegistry& registry) {
  constexpr ParticleMapsConfig defaults;
  registry.add("depth_normal_maps",
               {{.name = "resolution",
                 .initial = static_cast<double>(defaults.resolution),
                 .unit = "texels",
                 .least = 0.0,
                 .most = 4096.0,
                 .kind = OptionKind::whole,
                 .meaning = "texels along the longer side of each picture; more: smaller errors, "
                            "slower drawing; 0: for errors of a fifth of the rest gap"},
                {.name = "views",
                 .initial = static_cast<double>(defaults.views),
                 .unit = "1",
                 .least = 0.0,
                 .most = 3.0,
                 .kind = OptionKind::whole,
                 .meaning = "1: front and back of the body; 2: also its sides; 3: also from above "
                            "and below; 0: as many as show its surface under 60 degrees"}},
               [](const MethodOptions& o) {
                 return std::make_unique<ParticleMaps>(ParticleMapsConfig{
                     .resolution = o.whole("resolution"), .views = o.whole("views")});
               });
}

}  // namespace selvedge
