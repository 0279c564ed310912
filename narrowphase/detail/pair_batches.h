// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/parallel.h>
#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/detail/float_paths.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Number of pairs per task, and of queries per call.
inline constexpr std::size_t kPairGrain = 2048, kQueryBatch = 256;

/// Queries that wait for their times.
class QueryBatch {
 public:
  /// Whether the pairs of another block may not fit.
  bool is_full() const { return size_ + kScreenBlock > kQueryBatch; }
  void add(const SurfacePairs& in, const PairVertices& pair) {
    pairs_[size_] = pair;
    queries_[size_++] = query_of(in.a, in.b, pair);
  }

  /// Appends the contacts of all queries to `out`, by their times, and drops the queries.
  template <class FindTimes>
  void flush(const FindTimes& find_times, std::vector<Contact>& out) {
    find_times(std::span<const Query>(queries_).first(size_), std::span(toi_).first(size_));
    for (std::size_t j = 0; j < size_; ++j) {
      if (toi_[j] == kNoCollision) continue;
      Contact& contact = out.emplace_back();
      contact.kind = pairs_[j].kind;
      contact.vertex = pairs_[j].vertex;
      fill_contact(queries_[j], toi_[j], contact);
    }
    size_ = 0;
  }

 private:
  std::array<PairVertices, kQueryBatch> pairs_;
  std::array<Query, kQueryBatch> queries_;
  std::array<double, kQueryBatch> toi_;
  std::size_t size_ = 0;
};

/// Writes to `out`, in pair order, the contacts of the pairs that `take(begin, end, add)` passes to
/// add(pair): it looks at pairs from `begin` on, passes at most kScreenBlock of them, and returns
/// how many it has looked at. By batches of find_times(queries, toi) on all threads.
template <class Take, class FindTimes>
void find_contacts_among(const SurfacePairs& in, const Take& take, const FindTimes& find_times,
                         std::vector<Contact>& out) {
  const std::size_t n = in.pairs.size();
  std::vector<std::vector<Contact>> found((n + kPairGrain - 1) / kPairGrain);
  parallel_for(n, kPairGrain, [&](std::size_t begin, std::size_t end) {
    QueryBatch batch;
    for (std::size_t i = begin; i < end;) {
      i += take(i, end, [&](const PairVertices& pair) { batch.add(in, pair); });
      if (batch.is_full() || i == end) batch.flush(find_times, found[begin / kPairGrain]);
    }
  });
  out.clear();
  for (const std::vector<Contact>& part : found) out.insert(out.end(), part.begin(), part.end());
}

}  // namespace selvedge::detail
