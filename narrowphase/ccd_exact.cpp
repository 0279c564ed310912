// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/detail/ccd_filter.h>
#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/detail/exact_query.h>
#include <selvedge/narrowphase/detail/float_paths.h>
#include <selvedge/narrowphase/detail/method_config.h>
#include <selvedge/narrowphase/detail/pair_batches.h>
#include <selvedge/narrowphase/detail/root_isolation.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

// Continuous collision of straight vertex paths after Provot, "Collision and self-collision
// handling in cloth model dedicated to design garments", 1997: colliding vertices must be coplanar,
// which gives a cubic in t. Every result is exact: stages A, B (filter) and C (isolate) use doubles
// with forward error bounds, stages D and E (collides_exactly) use integers. Each file proves its
// stages.

namespace selvedge {
namespace {

using detail::FilterKernel;
using detail::kFilterBlock;
using detail::QueryBlock;

/// Number of queries that run through the filter together.
constexpr std::size_t kBatch = 256;

/// Stages C, D and E.
bool settle(const FilterKernel& kernel, const Query& query, double& toi, CcdExactStages& stages) {
  using detail::ContactDecision;
  bool is_exact = false;
  const ContactDecision decision = detail::isolate_contact(query, toi, is_exact);
  ++(is_exact || decision == ContactDecision::open ? stages.exact : stages.isolated);
  return decision == ContactDecision::open ? detail::collides_exactly(kernel, query, toi)
                                           : decision == ContactDecision::yes;
}

/// The queries of one kind in a batch that no stage has decided yet.
class OpenQueries {
 public:
  OpenQueries(std::span<const Query> queries, bool edges) : queries_(queries) {
    for (std::size_t i = 0; i < queries.size(); ++i) {
      index_[count_] = static_cast<std::uint16_t>(i);
      count_ += (queries[i].kind == ContactKind::edge_edge) == edges;
    }
  }

  /// Removes the queries that `decides(block, indices)`, a mask, marks. Returns their number.
  template <class Decides>
  std::size_t sift(Decides decides) {
    std::size_t kept = 0;
    for (std::size_t at = 0; at < count_; at += kFilterBlock) {
      const std::size_t n = std::min<std::size_t>(kFilterBlock, count_ - at);
      // The last block is padded with copies of its last query.
      QueryBlock block;
      for (std::size_t j = 0; j < kFilterBlock; ++j)
        block[j] = &queries_[index_[at + std::min(j, n - 1)]];
      const std::uint32_t decided = decides(block, std::span(index_).subspan(at, n));
      for (std::size_t j = 0; j < n; ++j) {
        index_[kept] = index_[at + j];
        kept += (decided >> j & 1U) == 0;
      }
    }
    return std::exchange(count_, kept) - kept;
  }

  std::span<const std::uint16_t> indices() const { return std::span(index_).first(count_); }

 private:
  std::span<const Query> queries_;
  std::array<std::uint16_t, kBatch> index_;
  std::size_t count_ = 0;
};

/// Throws if a coordinate of at most kBatch queries of one kind is not finite.
void require_finite(const FilterKernel& kernel, std::span<const Query> queries, bool edges) {
  OpenQueries faulty(queries, edges);
  faulty.sift([&](const QueryBlock& block, auto) { return kernel.finite(block); });
  for (const std::uint16_t i : faulty.indices()) detail::require_finite(queries[i]);
}

/// Runs all stages on at most kBatch queries of one kind with finite coordinates; ignores those of
/// the other kind.
void decide(const FilterKernel& kernel, std::span<const Query> queries, bool edges,
            std::span<double> toi, CcdExactStages& stages) {
  OpenQueries open(queries, edges);
  const auto run = [&](FilterKernel::Test test) {
    return open.sift([&](const QueryBlock& block, auto) { return test(block, edges); });
  };
  stages.separated += run(kernel.separated_on_axes);
  stages.separated += run(kernel.separated_on_diagonals);
  stages.never_coplanar += run(kernel.never_coplanar);
  stages.isolated +=
      open.sift([&](const QueryBlock& block, std::span<const std::uint16_t> indices) {
        std::array<double, kFilterBlock> times;
        const std::uint32_t decided = kernel.decided_at_simple_roots(block, edges, times);
        for (std::size_t j = 0; j < indices.size(); ++j)
          if ((decided >> j & 1U) != 0) toi[indices[j]] = times[j];
        return decided;
      });
  for (const std::uint16_t i : open.indices())
    if (double t = 0.0; settle(kernel, queries[i], t, stages)) toi[i] = t;
}

class CcdExact final : public NarrowPhase {
 public:
  explicit CcdExact(const CcdExactConfig& config) : kernel_(kernel_for(config.vector_width)) {}

  void find_times(std::span<const Query> queries, std::span<double> toi) const override {
    CcdExactStages stages;
    find_times(queries, toi, stages);
  }

  void find_times(std::span<const Query> queries, std::span<double> toi,
                  CcdExactStages& stages) const {
    for (std::size_t at = 0; at < queries.size(); at += kBatch)
      for (const bool edges : {false, true})
        require_finite(kernel_, queries.subspan(at, std::min(kBatch, queries.size() - at)), edges);
    find_times_of_finite(queries, toi, stages);
  }

  /// As the default, but tells most pairs apart in floats before their queries are made.
  void find_contacts(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs,
                     std::vector<Contact>& out) const override {
    const detail::FloatPaths paths(a, b);
    const detail::SurfacePairs in{a, b, pairs};
    detail::find_contacts_among(
        in,
        [&](std::size_t begin, std::size_t end, const auto& add) {
          detail::PairBlock block;
          paths.take_block(in, begin, end, block);
          const std::uint32_t never = paths.never_meet(block);
          for (std::size_t j = 0; j < block.size; ++j)
            if ((never >> j & 1U) == 0) add(block.pairs[j]);
          return block.size;
        },
        [&](std::span<const Query> queries, std::span<double> toi) {
          CcdExactStages stages;
          find_times_of_finite(queries, toi, stages);
        },
        out);
  }

  NarrowPhaseTraits traits() const override {
    return {.misses_nothing = true,
            .no_false_alarm = true,
            .source =
                "X. Provot, Collision and self-collision handling in cloth model dedicated "
                "to design garments, 1997; decided exactly"};
  }

 private:
  void find_times_of_finite(std::span<const Query> queries, std::span<double> toi,
                            CcdExactStages& stages) const {
    std::fill(toi.begin(), toi.end(), kNoCollision);
    for (std::size_t at = 0; at < queries.size(); at += kBatch) {
      const std::size_t n = std::min(kBatch, queries.size() - at);
      for (const bool edges : {false, true})
        decide(kernel_, queries.subspan(at, n), edges, toi.subspan(at, n), stages);
    }
  }

  /// The widest kernel that is not wider than `width` doubles.
  static FilterKernel kernel_for(int width) {
    FilterKernel best = detail::filter_kernels().front();
    for (const FilterKernel& kernel : detail::filter_kernels())
      if (kernel.width <= width) best = kernel;
    return best;
  }

  FilterKernel kernel_;
};

}  // namespace

void find_times_counting_stages(std::span<const Query> queries, std::span<double> toi,
                                CcdExactStages& stages) {
  CcdExact({}).find_times(queries, toi, stages);
}

std::unique_ptr<NarrowPhase> make_ccd_exact(const CcdExactConfig& config) {
  return std::make_unique<CcdExact>(config);
}

void register_ccd_exact(NarrowPhaseRegistry& registry) {
  registry.add("ccd_exact", {detail::min_separation_option()}, [](const MethodOptions& o) {
    const double distance = o["min_separation"];
    return distance == 0.0 ? make_ccd_exact() : make_ccd_separation(distance);
  });
}

}  // namespace selvedge
