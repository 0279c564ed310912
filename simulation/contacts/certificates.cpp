// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/simulation/contacts/detail/certificates.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

constexpr std::size_t kVertexGrain = 2048, kPairGrain = 2048;
// Pairs that are passed over together.
constexpr std::size_t kBlock = 64;

// Covers the rounding of a difference, of its conversion to float and of the sum of two.
constexpr double kRoundedUp = 1.0 + 0x1p-20;
// Covers, as a share of the shift, the rounding of a difference that loses digits to it.
constexpr double kOfShift = 0x1p-50;

/// Whether the room of any pair is at most `enough`.
bool any_within(std::span<const float> rooms, float enough) {
  int count = 0;
  for (const float room : rooms) count += room > enough ? 0 : 1;
  return count > 0;
}

/// Appends the pairs whose room does not exceed what their vertices moved, in order: blocks of
/// pairs whose rooms exceed twice the most that any vertex moved are passed over without a look at
/// them.
template <class Pair, class Moved>
void append_open(const std::vector<Pair>& pairs, std::span<const float> rooms, float most,
                 const Moved& moved, std::vector<Pair>& out) {
  const std::size_t n = pairs.size();
  std::vector<std::vector<Pair>> parts((n + kPairGrain - 1) / kPairGrain);
  const float enough = 2.0F * most;
  parallel_for(n, kPairGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<Pair>& part = parts[begin / kPairGrain];
    for (std::size_t first = begin; first < end; first += kBlock) {
      const std::size_t last = std::min(end, first + kBlock);
      if (!any_within(rooms.subspan(first, last - first), enough)) continue;
      for (std::size_t i = first; i < last; ++i)
        if (!(rooms[i] > enough) && !(rooms[i] > moved(pairs[i]))) part.push_back(pairs[i]);
    }
  });
  out.clear();
  for (const std::vector<Pair>& part : parts) out.insert(out.end(), part.begin(), part.end());
}

}  // namespace

void Certificates::begin(std::span<const Vec3> x_t1) {
  clear();
  x_t1_.assign(x_t1.begin(), x_t1.end());
}

// A change that all vertices share moves no two of them towards each other.
void Certificates::measure(List& list, std::span<const Vec3> x_t1, const Vec3& shift) const {
  const double lost = kOfShift * shift.lpNorm<Eigen::Infinity>();
  list.moved.resize(x_t1.size());
  parallel_for(x_t1.size(), kVertexGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const double moved = (x_t1[i] - x_t1_[i] - shift).lpNorm<Eigen::Infinity>();
      list.moved[i] = static_cast<float>(kRoundedUp * (moved + lost));
    }
  });
  list.most = 0.0F;
  for (const float moved : list.moved) list.most = std::max(list.most, moved);
}

void Certificates::measure(std::span<const Vec3> x_t1, std::size_t particles) {
  if (!bodies_.rooms.empty()) measure(bodies_, x_t1, Vec3::Zero());
  if (self_.rooms.empty()) return;
  Vec3 shared = Vec3::Zero();
  for (std::size_t i = 0; i < particles; ++i) shared += x_t1[i] - x_t1_[i];
  shared /= static_cast<double>(std::max<std::size_t>(particles, 1));
  measure(self_, x_t1.first(particles), shared);
}

const CandidatePairs& Certificates::open(bool self, const SurfaceView& a, const SurfaceView& b,
                                         const CandidatePairs& all) {
  List& list = of(self);
  if (list.rooms.empty() || list.rooms.size() != all.size()) return all;
  const float* of_a = list.moved.data();
  const float* of_b = self ? of_a : of_a + a.x_t1.size();
  const auto of_triangle = [](const float* moved, const Triangle& t) {
    return std::max({moved[t[0]], moved[t[1]], moved[t[2]]});
  };
  const auto of_edge = [](const float* moved, const Edge& e) {
    return std::max(moved[e[0]], moved[e[1]]);
  };
  const std::span<const float> rooms(list.rooms);
  const std::size_t first = all.point_triangle.size(), second = all.triangle_point.size();
  append_open(
      all.point_triangle, rooms.first(first), list.most,
      [&](const auto& p) { return of_a[p.point] + of_triangle(of_b, b.triangles[p.triangle]); },
      list.open.point_triangle);
  append_open(
      all.triangle_point, rooms.subspan(first, second), list.most,
      [&](const auto& p) { return of_b[p.point] + of_triangle(of_a, a.triangles[p.triangle]); },
      list.open.triangle_point);
  append_open(
      all.edge_edge, rooms.subspan(first + second), list.most,
      [&](const auto& p) {
        return of_edge(of_a, a.edges[p.edge_a]) + of_edge(of_b, b.edges[p.edge_b]);
      },
      list.open.edge_edge);
  return list.open;
}

}  // namespace selvedge::detail
