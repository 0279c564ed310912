// SPDX-License-Identifier: MIT
#include <selvedge/core/parallel.h>
#include <selvedge/narrowphase/ccd_exact.h>
#include <selvedge/narrowphase/detail/ccd_filter.h>
#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/detail/exact_query.h>
#include <selvedge/narrowphase/detail/root_floor.h>

#include <algorithm>
#include <memory>

// Continuous collision of straight vertex paths after Provot, "Collision and self-collision
// handling in cloth model dedicated to design garments", 1997: the vertices must be coplanar, a
// cubic in t. Every verdict is exact: stages A, B (filter) and C (isolate) in doubles with forward
// error bounds, D and E (collides_exactly) in integers. Each file proves its stages.

namespace selvedge {
namespace {

using narrowphase_detail::PairVertices;
using narrowphase_detail::QueryBlock;

/// Pairs that one task handles; a multiple of the block size.
constexpr std::size_t kGrain = 4096;

/// Stages C, D and E.
bool settle(const Query& query, double& toi, CcdExactStages& stages) {
  narrowphase_detail::TimeBox box;
  const narrowphase_detail::Verdict verdict = narrowphase_detail::isolate(query, box);
  if (verdict == narrowphase_detail::Verdict::no) {
    ++stages.isolated;
    return false;
  }
  if (verdict == narrowphase_detail::Verdict::yes &&
      ((box.monotonic && narrowphase_detail::floor_of_root(query, box.k, box.m, toi)) ||
       narrowphase_detail::root_in_box(query, box.k, box.m, toi))) {
    ++stages.isolated;
    return true;
  }
  ++stages.exact;
  return narrowphase_detail::collides_exactly(query, toi);
}

void store(const Query& query, QueryBlock& block, int column) {
  for (int v = 0; v < 4; ++v) {
    for (int i = 0; i < 3; ++i) {
      block.x_t0[3 * v + i][column] = query.x_t0[v][i];
      block.x_t1[3 * v + i][column] = query.x_t1[v][i];
    }
  }
}

/// Pairs of the three lists, handled in their order.
class Batch {
 public:
  Batch(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs,
        std::vector<Contact>& out)
      : a_(a), b_(b), pairs_(pairs), out_(out) {}

  void run(std::size_t begin, std::size_t end) {
    const std::size_t edges_from = pairs_.point_triangle.size() + pairs_.triangle_point.size();
    if (begin < edges_from) run_kind(begin, std::min(end, edges_from), false);
    if (end > edges_from) run_kind(std::max(begin, edges_from), end, true);
  }

 private:
  void run_kind(std::size_t begin, std::size_t end, bool edges) {
    for (std::size_t i = begin; i < end; i += QueryBlock::kSize) {
      const int n = static_cast<int>(std::min<std::size_t>(QueryBlock::kSize, end - i));
      for (int j = 0; j < n; ++j) store(query_at(i + j), block_, j);
      // The last block repeats its last pair.
      for (int j = n; j < QueryBlock::kSize; ++j) store(query_at(i + n - 1), block_, j);
      const narrowphase_detail::FilterVerdict verdict = narrowphase_detail::filter(block_, edges);
      const std::uint32_t decided = verdict.separated | verdict.never_coplanar;
      for (int j = 0; j < n; ++j)
        if ((decided >> j & 1U) == 0) settle_pair(i + j);
    }
  }

  Query query_at(std::size_t i) const {
    return narrowphase_detail::query_of(a_, b_, narrowphase_detail::pair_at(a_, b_, pairs_, i));
  }

  void settle_pair(std::size_t i) {
    const PairVertices pair = narrowphase_detail::pair_at(a_, b_, pairs_, i);
    const Query query = narrowphase_detail::query_of(a_, b_, pair);
    double toi = 0.0;
    if (!settle(query, toi, stages_)) return;
    Contact contact;
    contact.kind = pair.kind;
    contact.vertex = pair.vertex;
    narrowphase_detail::fill_contact(query, toi, contact);
    out_.push_back(contact);
  }

  const SurfaceView& a_;
  const SurfaceView& b_;
  const CandidatePairs& pairs_;
  std::vector<Contact>& out_;
  QueryBlock block_;
  CcdExactStages stages_;
};

class CcdExact final : public NarrowPhase {
 public:
  void find_contacts(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs,
                     std::vector<Contact>& out) const override {
    narrowphase_detail::require_finite(a, "a");
    if (&a != &b) narrowphase_detail::require_finite(b, "b");
    const std::size_t n = pairs.size();
    std::vector<std::vector<Contact>> found((n + kGrain - 1) / kGrain);
    parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
      Batch(a, b, pairs, found[begin / kGrain]).run(begin, end);
    });
    out.clear();
    for (const std::vector<Contact>& part : found) out.insert(out.end(), part.begin(), part.end());
  }

  void find_times(std::span<const Query> queries, std::span<double> toi) const override {
    CcdExactStages stages;
    for (std::size_t i = 0; i < queries.size(); ++i)
      if (!collides_counting_stages(queries[i], toi[i], stages)) toi[i] = kNoCollision;
  }

  NarrowPhaseTraits traits() const override {
    return {.misses_nothing = true,
            .no_false_alarm = true,
            .source =
                "X. Provot, Collision and self-collision handling in cloth model dedicated "
                "to design garments, 1997; decided exactly"};
  }
};

}  // namespace

bool collides_counting_stages(const Query& query, double& toi, CcdExactStages& stages) {
  narrowphase_detail::require_finite(query);
  QueryBlock block;
  for (int j = 0; j < QueryBlock::kSize; ++j) store(query, block, j);
  const narrowphase_detail::FilterVerdict verdict =
      narrowphase_detail::filter(block, query.kind == ContactKind::edge_edge);
  if ((verdict.separated & 1U) != 0) return ++stages.separated, false;
  if ((verdict.never_coplanar & 1U) != 0) return ++stages.never_coplanar, false;
  return settle(query, toi, stages);
}

std::unique_ptr<NarrowPhase> make_ccd_exact() { return std::make_unique<CcdExact>(); }

}  // namespace selvedge
