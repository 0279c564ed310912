// SPDX-License-Identifier: MIT
// Pairs from index buffers. The maps of [Vassilev2001] answer particle queries. Storing triangle
// indices in the texels, which yields pairs for a narrow phase, is our addition.
#include <selvedge/broadphase/detail/box_pairs.h>
#include <selvedge/broadphase/detail/drawn_copy.h>
#include <selvedge/broadphase/image_space/detail/index_tiles.h>
#include <selvedge/broadphase/image_space/detail/offscreen.h>
#include <selvedge/broadphase/image_space/image_space.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

using detail::DoubleBox;
using detail::FoundPairs;
using detail::SurfaceBoxes;

/// Up to this many triangles are tested against everything instead of being drawn: a few spikes
/// should make neither the texels coarse nor the windows wide for all others.
constexpr std::size_t kMostUnruly = 32;
/// Only triangles this many times larger, motion included, than the largest of the others.
constexpr double kUnruly = 4.0;

/// Minimum number of primitives per range, so that clearing a mark per triangle costs little in
/// comparison.
constexpr std::size_t kLeastGrain = 1024;

double extent(const DoubleBox& box) {
  return std::max({box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2]});
}

/// The edges of each triangle in a surface's list of edges.
struct TriangleEdges {
  std::vector<std::uint32_t> begin;
  std::vector<std::int32_t> edge;

  void find(std::span<const Triangle> triangles, std::span<const Edge> edges) {
    struct Named {
      Edge vertices;
      std::int32_t index;
      bool operator<(const Named& other) const { return vertices < other.vertices; }
    };
    std::vector<Named> sorted(edges.size());
    for (std::size_t e = 0; e < edges.size(); ++e)
      sorted[e] = {{std::min(edges[e][0], edges[e][1]), std::max(edges[e][0], edges[e][1])},
                   static_cast<std::int32_t>(e)};
    std::sort(sorted.begin(), sorted.end());
    begin.clear();
    edge.clear();
    for (const Triangle& t : triangles) {
      begin.push_back(static_cast<std::uint32_t>(edge.size()));
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t v = t[k], w = t[(k + 1) % 3];
        const auto [first, last] = std::equal_range(sorted.begin(), sorted.end(),
                                                    Named{{std::min(v, w), std::max(v, w)}, 0});
        for (auto at = first; at != last; ++at) edge.push_back(at->index);
      }
    }
    begin.push_back(static_cast<std::uint32_t>(edge.size()));
  }
  std::span<const std::int32_t> of(std::int32_t t) const {
    return {edge.data() + begin[t], begin[t + 1] - begin[t]};
  }
  std::size_t bytes() const {
    return begin.capacity() * sizeof(std::uint32_t) + edge.capacity() * sizeof(std::int32_t);
  }
};

/// Indices of the triangles that are not drawn, ascending.
std::vector<std::int32_t> unruly_triangles(const std::vector<DoubleBox>& boxes, double thickness) {
  std::vector<std::pair<double, std::int32_t>> by_size(boxes.size());
  for (std::size_t t = 0; t < boxes.size(); ++t)
    by_size[t] = {extent(boxes[t]) - 2.0 * thickness, static_cast<std::int32_t>(t)};
  const std::size_t most = std::min(kMostUnruly, boxes.size());
  double largest_of_others = -1.0;
  if (boxes.size() > kMostUnruly) {
    const auto next = by_size.begin() + kMostUnruly;
    std::nth_element(by_size.begin(), next, by_size.end(), std::greater<>());
    largest_of_others = std::max(0.0, next->first);
  }
  std::vector<std::int32_t> unruly;
  for (std::size_t i = 0; i < most; ++i)
    if (by_size[i].first > kUnruly * largest_of_others) unruly.push_back(by_size[i].second);
  std::sort(unruly.begin(), unruly.end());
  return unruly;
}

/// A surface viewed from its six sides.
class SixSides {
 public:
  void draw(const SurfaceView& s, std::span<const std::int32_t> unruly, int resolution,
            std::optional<detail::OffscreenRenderer>& renderer, const std::string& name) {
    take_positions(s, unruly);
    if (drawn_.empty()) return;
    if (!renderer) renderer.emplace();
    std::array<std::array<detail::Layer, 2>, 3> layers;
    for (int k = 0; k < 3; ++k) {
      const detail::MapAxes axes{Vec3::Unit(right(k)), Vec3::Unit(up(k)), Vec3::Unit(k)};
      frames_[k] = detail::frame_around(x_, drawn_, axes, resolution, name);
      renderer->draw(frames_[k], x_, all_, {}, layers[k][0], layers[k][1]);
    }
    parallel_for(3, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const std::vector<detail::Interval> depths = depths_along(static_cast<int>(k));
        for (std::size_t side = 0; side < 2; ++side)
          tiles_[k][side].gather(frames_[k], layers[k][side], depths);
      }
    });
    count_unseen();
  }

  /// Calls f for every triangle that may be visible within `reach` of the box; returns false if
  /// that is as much work as testing all triangles.
  template <class F>
  bool visit(const DoubleBox& box, double thickness, F f) const {
    if (drawn_.empty()) return true;
    std::array<detail::TileWindow, 3> windows;
    std::size_t count = 0;
    for (int k = 0; k < 3; ++k) {
      windows[k] = window(k, box, thickness);
      for (const detail::IndexTiles& side : tiles_[k]) count += side.count(windows[k]);
    }
    if (count >= all_.size()) return false;
    for (int k = 0; k < 3; ++k) {
      const double far = reach_[k] + thickness;
      const detail::Interval depth{box.lo[k] - far, box.hi[k] + far};
      for (const detail::IndexTiles& side : tiles_[k]) side.visit(windows[k], depth, f);
    }
    return true;
  }

  std::size_t unseen() const { return unseen_; }
  std::size_t bytes() const {
    std::size_t total =
        x_.capacity() * sizeof(Vec3) + (all_.capacity() + drawn_.capacity()) * sizeof(Triangle);
    for (const auto& sides : tiles_)
      for (const detail::IndexTiles& side : sides) total += side.bytes();
    return total;
  }

 private:
  static int right(int k) { return (k + 1) % 3; }
  static int up(int k) { return (k + 2) % 3; }

  /// Computes positions at the middle of the step, and how far from there the drawn triangles move.
  void take_positions(const SurfaceView& s, std::span<const std::int32_t> unruly) {
    x_.resize(s.x_t0.size());
    for (std::size_t i = 0; i < x_.size(); ++i) x_[i] = 0.5 * s.x_t0[i] + 0.5 * s.x_t1[i];
    all_.assign(s.triangles.begin(), s.triangles.end());
    for (const std::int32_t t : unruly) all_[t] = {0, 0, 0};  // not drawn, but keeps its index
    drawn_.clear();
    reach_ = Vec3::Zero();
    for (std::size_t t = 0, next = 0; t < all_.size(); ++t) {
      if (next < unruly.size() && static_cast<std::size_t>(unruly[next]) == t) {
        ++next;
        continue;
      }
      drawn_.push_back(all_[t]);
      for (const std::int32_t v : all_[t])
        reach_ = reach_.cwiseMax((0.5 * s.x_t1[v] - 0.5 * s.x_t0[v]).cwiseAbs());
    }
    unseen_ = 0;
  }

  /// The extent of each triangle along axis k, at the middle of the step.
  std::vector<detail::Interval> depths_along(int k) const {
    std::vector<detail::Interval> depths(all_.size());
    for (std::size_t t = 0; t < all_.size(); ++t) {
      const double a = x_[all_[t][0]][k], b = x_[all_[t][1]][k], c = x_[all_[t][2]][k];
      depths[t] = {std::min({a, b, c}), std::max({a, b, c})};
    }
    return depths;
  }

  detail::TileWindow window(int k, const DoubleBox& box, double thickness) const {
    const detail::MapFrame& f = frames_[k];
    const auto texel = [&](double x, int axis, double half_width) {
      return (x - f.center[axis]) / f.texel + half_width;
    };
    const int u = right(k), v = up(k);
    const double du = reach_[u] + thickness, dv = reach_[v] + thickness;
    return tiles_[k][0].window(
        texel(box.lo[u] - du, u, 0.5 * f.width), texel(box.hi[u] + du, u, 0.5 * f.width),
        texel(box.lo[v] - dv, v, 0.5 * f.height), texel(box.hi[v] + dv, v, 0.5 * f.height));
  }

  void count_unseen() {
    std::vector<std::uint8_t> seen(all_.size(), 0);
    for (const auto& sides : tiles_)
      for (const detail::IndexTiles& side : sides)
        for (const std::int32_t t : side.triangles()) seen[t] = 1;
    unseen_ = drawn_.size() - static_cast<std::size_t>(std::count(seen.begin(), seen.end(), 1));
  }

  std::vector<Vec3> x_;
  std::vector<Triangle> all_, drawn_;
  Vec3 reach_ = Vec3::Zero();
  std::array<detail::MapFrame, 3> frames_;
  std::array<std::array<detail::IndexTiles, 2>, 3> tiles_;  // along each axis, front and back
  std::size_t unseen_ = 0;
};

using Clock = std::chrono::steady_clock;

}  // namespace

struct ImageSpacePairs::State {
  /// The querying surface, and the surface that is drawn.
  using Asking = detail::KeptBoxes;
  struct Drawn : detail::KeptBoxes {
    detail::DrawnCopy copy;
    SixSides sides;
    TriangleEdges edges;
    std::vector<std::int32_t> unruly;
    std::vector<Edge> edge_list;
  };

  using PairBuffer = detail::PairBuffer;

  int resolution = 0;
  double thickness = 0.0;                             ///< m, of the drawn surface
  std::optional<detail::OffscreenRenderer> renderer;  // created when there is something to draw
  Asking asking;
  Drawn drawn;
  std::vector<FoundPairs> parts{detail::kBoxPairParts};
  detail::PairCollector collector;
  BroadPhaseCost cost;
  std::size_t renders = 0;

  void fit_asking(const SurfaceView& s, const char* name);
  void fit_drawn(const SurfaceView& s, const char* name);
  void draw(const SurfaceView& s, const char* name);
  void find(const SurfaceView& drawn_view, bool first_is_drawn);
  template <class Expand>
  void search(const std::vector<DoubleBox>& queries, const std::vector<DoubleBox>& targets,
              PairBuffer FoundPairs::*list, bool target_first, Expand expand);
  template <class F>
  void visit_triangles(const DoubleBox& box, F f) const;
  std::size_t bytes() const;
};

void ImageSpacePairs::State::fit_asking(const SurfaceView& s, const char* name) {
  if (asking.fit(s, name)) asking.keep(s);
}

void ImageSpacePairs::State::fit_drawn(const SurfaceView& s, const char* name) {
  const bool same_boxes = !drawn.fit(s, name);
  const bool same_edges =
      std::equal(s.edges.begin(), s.edges.end(), drawn.edge_list.begin(), drawn.edge_list.end());
  if (!same_boxes && !(same_edges && drawn.copy.same_triangles(s))) {
    drawn.edges.find(s.triangles, s.edges);
    drawn.edge_list.assign(s.edges.begin(), s.edges.end());
  }
  thickness = s.thickness;
  if (!drawn.copy.is(s)) draw(s, name);
  drawn.keep(s);
}

void ImageSpacePairs::State::draw(const SurfaceView& s, const char* name) {
  drawn.copy.forget();
  drawn.unruly = unruly_triangles(drawn.boxes.triangles, s.thickness);
  drawn.sides.draw(s, drawn.unruly, resolution, renderer, name);
  drawn.copy.set(s);
  ++renders;
}

/// Calls f for each triangle of the drawn surface that might meet the box, some more than once.
template <class F>
void ImageSpacePairs::State::visit_triangles(const DoubleBox& box, F f) const {
  if (drawn.sides.visit(box, thickness, f)) {
    for (const std::int32_t t : drawn.unruly) f(t);
    return;
  }
  const auto n = static_cast<std::int32_t>(drawn.boxes.triangles.size());
  for (std::int32_t t = 0; t < n; ++t) f(t);
}

/// Tests every box of `queries` against those of `targets` that belong to the triangles it finds:
/// expand(triangle, g) calls g(target).
template <class Expand>
void ImageSpacePairs::State::search(const std::vector<DoubleBox>& queries,
                                    const std::vector<DoubleBox>& targets,
                                    PairBuffer FoundPairs::*list, bool target_first,
                                    Expand expand) {
  detail::PairParts out(parts, list, nullptr);
  const std::size_t grain = std::max(kLeastGrain, queries.size() / detail::kBoxPairParts + 1);
  parallel_for(queries.size(), grain, [&](std::size_t begin, std::size_t end) {
    std::vector<std::int32_t> hits;
    // The last query that found each triangle, because a triangle appears in several tiles and
    // pictures.
    std::vector<std::int32_t> met(drawn.boxes.triangles.size(), -1);
    for (std::size_t i = begin; i < end; ++i) {
      const DoubleBox& box = queries[i];
      const auto query = static_cast<std::int32_t>(i);
      hits.clear();
      const auto keep = [&](std::int32_t target) {
        if (detail::overlap(box, targets[target])) hits.push_back(target);
      };
      visit_triangles(box, [&](std::int32_t t) {
        if (met[t] == query) return;
        met[t] = query;
        if (detail::overlap(box, drawn.boxes.triangles[t])) expand(t, keep);
      });
      std::sort(hits.begin(), hits.end());
      const auto last = std::unique(hits.begin(), hits.end());
      for (auto hit = hits.begin(); hit != last; ++hit)
        target_first ? out.add(begin / grain, *hit, query) : out.add(begin / grain, query, *hit);
    }
  });
}

void ImageSpacePairs::State::find(const SurfaceView& drawn_view, bool first_is_drawn) {
  const SurfaceBoxes &q = asking.boxes, &d = drawn.boxes;
  // Points of the querying surface against triangles of the drawn one, and vice versa.
  PairBuffer FoundPairs::*asking_points =
      first_is_drawn ? &FoundPairs::triangle_point : &FoundPairs::point_triangle;
  PairBuffer FoundPairs::*drawn_points =
      first_is_drawn ? &FoundPairs::point_triangle : &FoundPairs::triangle_point;
  search(q.points, d.triangles, asking_points, false, [](std::int32_t t, auto keep) { keep(t); });
  search(q.triangles, d.points, drawn_points, true, [&](std::int32_t t, auto keep) {
    for (const std::int32_t v : drawn_view.triangles[t]) keep(v);
  });
  search(q.edges, d.edges, &FoundPairs::edge_edge, first_is_drawn, [&](std::int32_t t, auto keep) {
    for (const std::int32_t e : drawn.edges.of(t)) keep(e);
  });
}

std::size_t ImageSpacePairs::State::bytes() const {
  std::size_t total = asking.boxes.bytes() + drawn.boxes.bytes() + drawn.copy.bytes() +
                      drawn.sides.bytes() + drawn.edges.bytes() + collector.bytes() +
                      drawn.edge_list.capacity() * sizeof(Edge);
  for (const FoundPairs& part : parts) total += part.bytes();
  return total;
}

ImageSpacePairs::ImageSpacePairs(const ImageSpacePairsConfig& config)
    : state_(std::make_unique<State>()) {
  state_->resolution = detail::checked_resolution(config.resolution, "image_space_pairs");
}
ImageSpacePairs::~ImageSpacePairs() = default;

void ImageSpacePairs::find_pairs(const SurfaceView& a, const SurfaceView& b, CandidatePairs& out) {
  State& s = *state_;
  out.clear();
  s.cost = {};
  detail::check_shape(a, "first surface");
  detail::check_shape(b, "second surface");
  const bool first_is_drawn = a.static_id != 0 && b.static_id == 0;
  const SurfaceView& drawn_view = first_is_drawn ? a : b;
  const auto begin = Clock::now();
  const bool known = s.drawn.copy.same_triangles(drawn_view);
  s.fit_asking(first_is_drawn ? b : a, first_is_drawn ? "second surface" : "first surface");
  s.fit_drawn(drawn_view, first_is_drawn ? "first surface" : "second surface");
  (known ? s.cost.refit_s : s.cost.build_s) = seconds_since(begin);

  const auto built = Clock::now();
  detail::PairTally tally(budget(), detail::PairBuffer::kBytesPerPair);
  for (FoundPairs& part : s.parts) part.start(&tally);
  s.find(drawn_view, first_is_drawn);
  for (FoundPairs& part : s.parts) part.finish();
  s.collector.collect(s.parts, a, &b, out);
  s.cost.query_s = seconds_since(built);
}

void ImageSpacePairs::find_self_pairs(const SurfaceView&, CandidatePairs& out) {
  out.clear();
  throw std::invalid_argument(
      "image_space_pairs: does not support a surface with itself, whose folds hide each other; use "
      "bvh_aabb");
}

BroadPhaseTraits ImageSpacePairs::traits() const {
  return {.guarantee = Guarantee::approximate,
          .self = false,
          .source =
              "triangle indices drawn off screen from six sides; after T. Vassilev, B. Spanlang, "
              "Y. Chrysanthou, Fast cloth animation on walking avatars, 2001"};
}

BroadPhaseCost ImageSpacePairs::last_cost() const {
  BroadPhaseCost cost = state_->cost;
  cost.bytes = state_->bytes();
  return cost;
}

std::size_t ImageSpacePairs::renders() const { return state_->renders; }
std::size_t ImageSpacePairs::unseen() const { return state_->drawn.sides.unseen(); }

void register_particle_maps(BroadPhaseRegistry& registry);

void register_image_space(BroadPhaseRegistry& registry) {
  register_particle_maps(registry);
  registry.add("image_space_pairs",
               {{.name = "resolution",
                 .initial = static_cast<double>(ImageSpacePairsConfig{}.resolution),
                 .unit = "texels",
                 .least = 16.0,
                 .most = 4096.0,
                 .kind = OptionKind::whole,
                 .meaning = "texels along the longer side of each picture; more: fewer missed "
                            "triangles, slower drawing"}},
               [](const MethodOptions& o) {
                 return std::make_unique<ImageSpacePairs>(
                     ImageSpacePairsConfig{.resolution = o.whole("resolution")});
               });
}

}  // namespace selvedge
