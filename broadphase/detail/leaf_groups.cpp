// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/leaf_groups.h>
#include <selvedge/core/base/parallel.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <utility>

namespace selvedge::detail {
namespace {

constexpr std::size_t kScanGrain = 8192;  // edges or triangles per task
constexpr std::size_t kNoEdge = static_cast<std::size_t>(-1);
constexpr std::int32_t kNoGroup = -1, kClaimed = -2;
constexpr std::uint8_t kOpenEdge = 1, kOpenPoint = 2;  // bits of open_
// A chunk has at least this many vertices, and this many rows of a square grid, so that few groups
// touch its border.
constexpr double kLeastChunk = 2048.0, kRowsOfChunk = 16.0;
// Chunks become larger until at most one in kMostCrossing edges joins two of them. A mesh whose
// numbers are in no order thus becomes a single chunk.
constexpr std::size_t kMostCrossing = 8;
constexpr std::uint32_t kManyEdges = 32;  // of a vertex: from here on, binary search is faster

/// The triangle's vertices, the lowest first, the others in ascending order.
Triangle ascending(const Triangle& t) {
  const std::int32_t lo = std::min(t[1], t[2]), hi = std::max(t[1], t[2]);
  return {std::min(t[0], lo), std::max(std::min(t[0], hi), lo), std::max(t[0], hi)};
}

std::int32_t lowest_vertex(const Triangle& t) { return std::min({t[0], t[1], t[2]}); }

}  // namespace

LeafGroups::LeafGroups(const SurfaceView& surface, int most)
    : most_(most),
      vertices_(surface.x_t0.size()),
      triangles_(surface.triangles),
      edges_(surface.edges),
      edge_begin_(vertices_ + 1),
      triangle_group_(triangles_.size()),
      edge_group_(edges_.size()),
      point_group_(vertices_),
      open_(vertices_) {
  shift_ = std::bit_width(static_cast<std::size_t>(
      std::max(kLeastChunk, kRowsOfChunk * std::sqrt(static_cast<double>(vertices_))) - 1.0));
  if (!are_edges_ascending()) sort_edges();
  const std::size_t crossing = index_edges();
  choose_chunks(crossing);
  distribute_triangles();
  parallel_for(chunks_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) grow(c);
  });
  parallel_for(chunks_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) claim_rest(c);
  });
  settle_claims();
}

bool LeafGroups::are_edges_ascending() const {
  std::atomic<bool> ascending = true;
  parallel_for(edges_.size(), kScanGrain, [&](std::size_t begin, std::size_t end) {
    bool all = true;
    Edge last = edges_[begin == 0 ? 0 : begin - 1];
    for (std::size_t p = begin; p < end; ++p) {
      all &= last <= edges_[p] && edges_[p][0] <= edges_[p][1];
      last = edges_[p];
    }
    if (!all) ascending.store(false, std::memory_order_relaxed);
  });
  return ascending;
}

/// Finds where the edges of each lower vertex begin; returns the number of edges between chunks.
std::size_t LeafGroups::index_edges() {
  const std::size_t n = edges_.size();
  std::atomic<std::size_t> crossing = 0;
  parallel_for(n, kScanGrain, [&](std::size_t begin, std::size_t end) {
    std::size_t crosses = 0;
    std::int32_t last = begin == 0 ? -1 : edges_[begin - 1][0];
    for (std::size_t p = begin; p < end; ++p) {
      const Edge edge = edges_[p];
      while (last < edge[0]) edge_begin_[++last] = static_cast<std::uint32_t>(p);
      crosses += edge[0] >> shift_ != edge[1] >> shift_;
    }
    crossing.fetch_add(crosses, std::memory_order_relaxed);
  });
  const std::size_t after = n == 0 ? 0 : static_cast<std::size_t>(edges_[n - 1][0]) + 1;
  std::fill(edge_begin_.begin() + after, edge_begin_.end(), static_cast<std::uint32_t>(n));
  return crossing;
}

/// Copies the edges in ascending order: counts by the lower vertex, then sorts the few of each.
void LeafGroups::sort_edges() {
  const std::span<const Edge> given = edges_;
  std::vector<std::uint32_t> begin(vertices_ + 2, 0);
  for (const Edge& e : given) ++begin[static_cast<std::size_t>(std::min(e[0], e[1])) + 2];
  for (std::size_t v = 2; v < begin.size(); ++v) begin[v] += begin[v - 1];
  edge_id_.resize(given.size());
  for (std::size_t e = 0; e < given.size(); ++e)
    edge_id_[begin[static_cast<std::size_t>(std::min(given[e][0], given[e][1])) + 1]++] =
        static_cast<std::int32_t>(e);
  sorted_edges_.resize(given.size());
  parallel_for(vertices_, kScanGrain, [&](std::size_t first, std::size_t last) {
    const auto upper = [&](std::int32_t e) { return std::max(given[e][0], given[e][1]); };
    for (std::size_t v = first; v < last; ++v) {
      std::sort(edge_id_.begin() + begin[v], edge_id_.begin() + begin[v + 1],
                [&](std::int32_t e, std::int32_t f) {
                  return upper(e) < upper(f) || (upper(e) == upper(f) && e < f);
                });
      for (std::uint32_t p = begin[v]; p < begin[v + 1]; ++p)
        sorted_edges_[p] = {static_cast<std::int32_t>(v), upper(edge_id_[p])};
    }
  });
  edges_ = sorted_edges_;
}

void LeafGroups::choose_chunks(std::size_t crossing) {
  while (crossing > edges_.size() / kMostCrossing && vertices_ >> shift_ > 0) {
    shift_ += 2;
    crossing =
        static_cast<std::size_t>(std::count_if(edges_.begin(), edges_.end(), [&](const Edge& e) {
          return e[0] >> shift_ != e[1] >> shift_;
        }));
  }
  chunks_.resize(vertices_ == 0 ? 0 : ((vertices_ - 1) >> shift_) + 1);
}

/// Sorts the triangles by the chunk of their lowest vertex, unless they are in this order.
void LeafGroups::distribute_triangles() {
  const std::size_t n = triangles_.size(), chunks = chunks_.size();
  const auto chunk_of = [&](std::size_t t) {
    return static_cast<std::size_t>(lowest_vertex(triangles_[t]) >> shift_);
  };
  // start[range · chunks + chunk]: first the number of triangles, then their place.
  std::vector<std::size_t> start((n / kScanGrain + 1) * chunks, 0);
  std::atomic<bool> in_order = true;
  parallel_for(n, kScanGrain, [&](std::size_t begin, std::size_t end) {
    std::size_t* count = start.data() + begin / kScanGrain * chunks;
    std::size_t last = begin == 0 ? 0 : chunk_of(begin - 1);
    bool ascends = true;
    for (std::size_t t = begin; t < end; ++t) {
      const std::size_t chunk = chunk_of(t);
      ++count[chunk];
      ascends &= last <= chunk;
      last = chunk;
    }
    if (!ascends) in_order.store(false, std::memory_order_relaxed);
  });
  triangle_begin_.assign(chunks + 1, n);
  std::size_t sum = 0;
  for (std::size_t c = 0; c < chunks; ++c) {
    triangle_begin_[c] = sum;
    for (std::size_t i = c; i < start.size(); i += chunks) sum += std::exchange(start[i], sum);
  }
  if (in_order) return;
  triangle_order_.reset(n);
  parallel_for(n, kScanGrain, [&](std::size_t begin, std::size_t end) {
    std::size_t* next = start.data() + begin / kScanGrain * chunks;
    for (std::size_t t = begin; t < end; ++t)
      triangle_order_[next[chunk_of(t)]++] = static_cast<std::int32_t>(t);
  });
}

/// The place of an edge; of a repeated one the first.
std::size_t LeafGroups::find_edge(std::int32_t lower, std::int32_t upper) const {
  std::uint32_t p = edge_begin_[lower];
  const std::uint32_t end = edge_begin_[lower + 1];
  if (end - p > kManyEdges)
    p = static_cast<std::uint32_t>(
        std::lower_bound(edges_.begin() + p, edges_.begin() + end, Edge{lower, upper}) -
        edges_.begin());
  while (p < end && edges_[p][1] < upper) ++p;
  return p < end && edges_[p][1] == upper ? p : kNoEdge;
}

/// Makes the groups of a chunk. Each takes the edges and points that have their lowest vertex in
/// common with one of its triangles.
void LeafGroups::grow(std::size_t chunk) {
  const std::size_t first = begin_of(chunk), n = end_of(chunk) - first;
  const std::size_t begin = triangle_begin_[chunk], end = triangle_begin_[chunk + 1];
  std::vector<std::int32_t> weight(n, 0);  // number of triangles with this lowest vertex
  for (std::size_t i = begin; i < end; ++i)
    ++weight[static_cast<std::size_t>(lowest_vertex(triangles_[triangle_at(i)])) - first];

  std::vector<std::int32_t> group(n, kNoGroup), reached;
  std::int32_t groups = 0;
  for (std::size_t seed = 0; seed < n; ++seed) {
    if (group[seed] != kNoGroup || weight[seed] == 0) continue;
    std::int32_t total = weight[seed];
    group[seed] = groups;
    reached.assign(1, static_cast<std::int32_t>(seed));
    for (std::size_t i = 0; i < reached.size() && total < most_; ++i) {
      // The lowest first: rows of a grid then become groups of two rows, without gaps.
      std::iter_swap(
          reached.begin() + static_cast<std::ptrdiff_t>(i),
          std::min_element(reached.begin() + static_cast<std::ptrdiff_t>(i), reached.end()));
      const std::size_t v = first + static_cast<std::size_t>(reached[i]);
      for (std::uint32_t p = edge_begin_[v]; p < edge_begin_[v + 1]; ++p) {
        const std::size_t next = static_cast<std::size_t>(edges_[p][1]) - first;
        if (next >= n) break;
        if (group[next] != kNoGroup || weight[next] == 0 || total + weight[next] > most_) continue;
        group[next] = groups;
        total += weight[next];
        reached.push_back(static_cast<std::int32_t>(next));
      }
    }
    // A vertex with too many triangles for one group has several.
    groups += (total + most_ - 1) / most_;
  }
  chunks_[chunk].groups = groups;

  std::fill_n(edge_group_.data() + edge_begin_[first], edge_begin_[first + n] - edge_begin_[first],
              kNoGroup);
  std::fill_n(point_group_.data() + first, n, kNoGroup);
  const auto own = [](std::int32_t& owner, std::int32_t g) {
    if (owner == kNoGroup) owner = g;
  };
  std::vector<std::int32_t>& seen = reached;
  seen.assign(n, 0);
  for (std::size_t i = begin; i < end; ++i) {
    const Triangle t = ascending(triangles_[triangle_at(i)]);
    const std::size_t v = static_cast<std::size_t>(t[0]) - first;
    const std::int32_t g = group[v] + (weight[v] > most_ ? seen[v]++ / most_ : 0);
    triangle_group_[i] = g;
    own(point_group_[t[0]], g);
    for (const std::int32_t upper : {t[1], t[2]})
      if (const std::size_t p = find_edge(t[0], upper); p != kNoEdge) own(edge_group_[p], g);
  }
  for (std::size_t v = first; v < first + n; ++v) {
    const bool edge =
        std::find(edge_group_.data() + edge_begin_[v], edge_group_.data() + edge_begin_[v + 1],
                  kNoGroup) != edge_group_.data() + edge_begin_[v + 1];
    open_[v] = static_cast<std::uint8_t>((edge ? kOpenEdge : 0) |
                                         (point_group_[v] == kNoGroup ? kOpenPoint : 0));
  }
}

/// Lists what is left among the upper vertices and sides of the chunk's triangles.
void LeafGroups::claim_rest(std::size_t chunk) {
  Chunk& own = chunks_[chunk];
  for (std::size_t i = triangle_begin_[chunk]; i < triangle_begin_[chunk + 1]; ++i) {
    const Triangle t = ascending(triangles_[triangle_at(i)]);
    if ((open_[t[1]] | open_[t[2]]) == 0) continue;
    for (const std::int32_t v : {t[1], t[2]})
      if (open_[v] & kOpenPoint)
        own.points.push_back({static_cast<std::uint32_t>(v), triangle_group_[i]});
    if (!(open_[t[1]] & kOpenEdge)) continue;
    const std::size_t p = find_edge(t[1], t[2]);
    if (p != kNoEdge && edge_group_[p] == kNoGroup)
      own.edges.push_back({static_cast<std::uint32_t>(p), triangle_group_[i]});
  }
}

/// The first claim of an edge or point succeeds.
void LeafGroups::settle_claims() {
  const auto settle = [](std::vector<Claim>& claims, RawArray<std::int32_t>& group) {
    std::erase_if(claims, [&](const Claim& claim) {
      return std::exchange(group[claim.item], kClaimed) == kClaimed;
    });
  };
  for (Chunk& chunk : chunks_) {
    chunk.first_group = static_cast<std::int32_t>(count_);
    count_ += static_cast<std::size_t>(chunk.groups);
    settle(chunk.edges, edge_group_);
    settle(chunk.points, point_group_);
  }
  parallel_for(chunks_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) list_loose(c);
  });
  for (const Chunk& chunk : chunks_) {
    loose_edges_.insert(loose_edges_.end(), chunk.loose_edges.begin(), chunk.loose_edges.end());
    loose_points_.insert(loose_points_.end(), chunk.loose_points.begin(), chunk.loose_points.end());
  }
}

void LeafGroups::list_loose(std::size_t chunk) {
  Chunk& own = chunks_[chunk];
  for (std::size_t v = begin_of(chunk); v < end_of(chunk); ++v) {
    if (point_group_[v] == kNoGroup) own.loose_points.push_back(static_cast<std::int32_t>(v));
    if (!(open_[v] & kOpenEdge)) continue;
    for (std::uint32_t p = edge_begin_[v]; p < edge_begin_[v + 1]; ++p)
      if (edge_group_[p] == kNoGroup) own.loose_edges.push_back(edge_at(p));
  }
}

}  // namespace selvedge::detail
