// SPDX-License-Identifier: MIT
// The reader of query files. What it reads is finite and has a verdict for each query.
#include <selvedge/narrowphase/query_file.h>

#include <cstdlib>
#include <cstring>

#include "fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t n) {
  using namespace selvedge;
  static const fuzz::InputFile input(".csv");
  try {
    const QuerySet set = read_queries(input.holding(bytes, n), ContactKind::edge_edge);
    if (set.truth.size() != set.queries.size()) std::abort();
    for (const Query& q : set.queries)
      for (const auto* x : {&q.x_t0, &q.x_t1})
        for (const Vec3& v : *x)
          if (!v.allFinite()) std::abort();
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
