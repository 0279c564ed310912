// SPDX-License-Identifier: MIT
//
// Detection on plain arrays, and queries of single pairs in batches.
#include <selvedge/bindings/c/calls.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/judge/judge.h>

#include <memory>

struct selvedge_detector {
  std::unique_ptr<selvedge::BroadPhase> broad;
  std::unique_ptr<selvedge::NarrowPhase> narrow;
  double min_separation = 0.0;  // m
  std::atomic<bool> busy{false};
};

namespace selvedge::c {
namespace {

template <class Rows>
const auto* column_of(const Rows& rows) {
  using Number = std::remove_cvref_t<decltype(rows.front()[0])>;
  return rows.empty() ? nullptr : reinterpret_cast<const Number*>(rows.data());
}
template <class Number>
const Number* plain_column(const std::vector<Number>& list) {
  return list.empty() ? nullptr : list.data();
}

/// The list behind a selvedge_pairs, which is its first part.
struct Pairs : selvedge_pairs {
  std::vector<std::array<std::int32_t, 2>> list;
};

template <class Pair>
std::unique_ptr<Pairs> pairs_of(const std::vector<Pair>& found) {
  static_assert(sizeof(Pair) == 2 * sizeof(std::int32_t));
  auto pairs = std::make_unique<Pairs>();
  for (const auto& pair : found)
    pairs->list.push_back(*reinterpret_cast<const std::array<std::int32_t, 2>*>(&pair));
  pairs->count = pairs->list.size();
  pairs->index = column_of(pairs->list);
  return pairs;
}

void hand_over(selvedge_pairs** out, std::unique_ptr<Pairs>& pairs) {
  if (out != nullptr) *out = pairs.release();
}

template <class Pair>
void add_primitives(Contacts& lists, const std::vector<Pair>& found) {
  for (const PrimitivePair& pair : found) {
    lists.kinds.push_back(static_cast<std::uint8_t>(pair.kind));
    lists.corners.push_back(pair.vertex);
    lists.shares.push_back(pair.weight);
    lists.normals.push_back(pair.normal);
    lists.sides.push_back({pair.primitive_a, pair.primitive_b});
  }
}

/// A method of a registry by name; null: the default.
template <class Registry>
auto method_of(const Registry& registry, const char* name, const char* usual, const char* key,
               const MethodOptions& options) {
  const std::string chosen = name == nullptr ? usual : name;
  if (const std::string fault = registry.fault(chosen); !fault.empty())
    throw std::invalid_argument(std::string(key) + ": " + fault);
  return registry.at(chosen)(options);
}

std::unique_ptr<NarrowPhase> narrow_phase_of(const char* name, double min_separation) {
  MethodOptions options;
  if (min_separation != 0.0) options.set("min_separation", min_separation);
  return method_of(narrow_phases(), name, "ccd_exact", "narrow_phase", options);
}

constexpr std::size_t kQueryPoints = 8, kGrain = 64;

std::span<const Vec3> points_of(int kind, const double* queries, std::size_t n) {
  if (kind != SELVEDGE_POINT_TRIANGLE && kind != SELVEDGE_EDGE_EDGE)
    throw std::invalid_argument("kind is " + std::to_string(kind) +
                                "; queries have SELVEDGE_POINT_TRIANGLE or SELVEDGE_EDGE_EDGE");
  const auto points = rows<Vec3>(queries, kQueryPoints * n, "queries");
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite())
      throw std::invalid_argument("query " + std::to_string(i / kQueryPoints) + ": point " +
                                  std::to_string(i % kQueryPoints) + " is not finite");
  return points;
}

}  // namespace

selvedge_contacts* Contacts::release(Contacts&& lists) {
  auto out = std::make_unique<Contacts>(std::move(lists));
  out->count = out->kinds.size();
  out->kind = plain_column(out->kinds);
  out->vertices = column_of(out->corners);
  out->weights = column_of(out->shares);
  out->normal = column_of(out->normals);
  out->primitives = column_of(out->sides);
  out->toi = plain_column(out->times);
  out->gap = plain_column(out->gaps);
  out->rest_gap = plain_column(out->rest_gaps);
  out->impulse = column_of(out->impulses);
  return out.release();
}

}  // namespace selvedge::c

using namespace selvedge;  // NOLINT: the functions below are outside of it

void selvedge_contacts_free(selvedge_contacts* contacts) {
  delete static_cast<c::Contacts*>(contacts);
}
void selvedge_pairs_free(selvedge_pairs* pairs) { delete static_cast<c::Pairs*>(pairs); }

int selvedge_detector_create(const char* broad_phase, const char* narrow_phase,
                             double min_separation, selvedge_detector** out) {
  return c::call([&] {
    c::needed(out, "out");
    auto made = std::make_unique<selvedge_detector>();
    made->broad = c::method_of(broad_phases(), broad_phase, "bvh_aabb", "broad_phase", {});
    made->narrow = c::narrow_phase_of(narrow_phase, min_separation);
    made->min_separation = min_separation;
    *out = made.release();
  });
}
void selvedge_detector_free(selvedge_detector* detector) { delete detector; }

int selvedge_find_collisions(selvedge_detector* detector, const selvedge_surface* a,
                             const selvedge_surface* b, selvedge_contacts** out) {
  return c::call([&] {
    const c::OneThread mine(c::needed(detector, "detector").busy, "detector");
    c::needed(out, "out");
    const DetectionMethods methods{*detector->broad, *detector->narrow, detector->min_separation};
    const std::vector<Collision> found =
        b == nullptr ? find_collisions(methods, c::moving(a, "a"))
                     : find_collisions(methods, c::moving(a, "a"), c::moving(b, "b"));
    c::Contacts lists;
    c::add_primitives(lists, found);
    for (const Collision& collision : found) lists.times.push_back(collision.toi);
    *out = c::Contacts::release(std::move(lists));
  });
}

int selvedge_find_candidates(selvedge_detector* detector, const selvedge_surface* a,
                             const selvedge_surface* b, double distance,
                             selvedge_pairs** point_triangle, selvedge_pairs** triangle_point,
                             selvedge_pairs** edge_edge) {
  return c::call([&] {
    const c::OneThread mine(c::needed(detector, "detector").busy, "detector");
    const CandidatePairs found =
        b == nullptr
            ? find_candidates(*detector->broad, c::moving(a, "a"), distance)
            : find_candidates(*detector->broad, c::moving(a, "a"), c::moving(b, "b"), distance);
    auto points = c::pairs_of(found.point_triangle), triangles = c::pairs_of(found.triangle_point),
         edges = c::pairs_of(found.edge_edge);
    c::hand_over(point_triangle, points);
    c::hand_over(triangle_point, triangles);
    c::hand_over(edge_edge, edges);
  });
}

int selvedge_find_meetings(const selvedge_surface* a, const selvedge_surface* b,
                           selvedge_pairs** crossings, selvedge_pairs** touches) {
  return c::call([&] {
    const SurfaceState first = c::state(a, "a");
    const TriangleMeetings found = b == nullptr ? find_meetings(first.x, first.triangles)
                                                : find_meetings(first, c::state(b, "b"));
    auto crossing = c::pairs_of(found.crossings), touching = c::pairs_of(found.touches);
    c::hand_over(crossings, crossing);
    c::hand_over(touches, touching);
  });
}

int selvedge_find_contacts(const selvedge_surface* a, const selvedge_surface* b, double distance,
                           selvedge_contacts** out) {
  return c::call([&] {
    c::needed(out, "out");
    const SurfaceState first = c::state(a, "a");
    const std::vector<Proximity> found = b == nullptr
                                             ? find_contacts(first.x, first.triangles, distance)
                                             : find_contacts(first, c::state(b, "b"), distance);
    c::Contacts lists;
    c::add_primitives(lists, found);
    for (const Proximity& near : found) lists.gaps.push_back(near.gap);
    *out = c::Contacts::release(std::move(lists));
  });
}

int selvedge_edges(const int32_t* triangles, size_t triangle_count, selvedge_pairs** out) {
  return c::call([&] {
    c::needed(out, "out");
    *out = c::pairs_of(unique_edges(c::rows<Triangle>(triangles, triangle_count, "triangles")))
               .release();
  });
}

int selvedge_impact_times(const char* narrow_phase, int kind, const double* queries, size_t n,
                          double* toi) {
  return c::call([&] {
    const std::span<const Vec3> points = c::points_of(kind, queries, n);
    if (n > 0) c::needed(toi, "toi");
    const std::unique_ptr<NarrowPhase> method = c::narrow_phase_of(narrow_phase, 0.0);
    parallel_for(n, c::kGrain, [&](std::size_t begin, std::size_t end) {
      std::array<Query, c::kGrain> batch;
      for (std::size_t i = begin; i < end; ++i) {
        Query& query = batch[i - begin];
        query.kind = static_cast<ContactKind>(kind);
        for (std::size_t k = 0; k < 4; ++k) {
          query.x_t0[k] = points[c::kQueryPoints * i + k];
          query.x_t1[k] = points[c::kQueryPoints * i + k + 4];
        }
      }
      method->find_times(std::span(batch).first(end - begin), {toi + begin, end - begin});
    });
  });
}

int selvedge_touch_times(int kind, const double* queries, size_t n, double* lo, double* hi) {
  return c::call([&] {
    const std::span<const Vec3> points = c::points_of(kind, queries, n);
    if (n > 0) c::needed(lo, "lo"), c::needed(hi, "hi");
    const PathKind path =
        kind == SELVEDGE_POINT_TRIANGLE ? PathKind::point_triangle : PathKind::edge_edge;
    parallel_for(n, c::kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto found = first_touch(
            path, points.subspan(c::kQueryPoints * i).template first<c::kQueryPoints>());
        lo[i] = found ? found->lo : kNoCollision;
        hi[i] = found ? found->hi : kNoCollision;
      }
    });
  });
}
