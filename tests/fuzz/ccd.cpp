// SPDX-License-Identifier: MIT
// Queries against the judge, which shares no code with ccd_exact: the same verdict and time.
#include <selvedge/judge/judge.h>
#include <selvedge/narrowphase/ccd_methods.h>

#include <array>
#include <cstdlib>
#include <optional>

#include "fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t n) {
  using namespace selvedge;
  static const auto method = make_ccd_exact();
  fuzz::Bytes in(bytes, n);
  Query query;
  const bool edges = in.byte() % 2 == 1;
  query.kind = edges ? ContactKind::edge_edge : ContactKind::point_triangle;
  std::array<Vec3, 8> points;
  for (std::size_t k = 0; k < 8; ++k) {
    for (int i = 0; i < 3; ++i) points[k][i] = in.coordinate();
    (k < 4 ? query.x_t0 : query.x_t1)[k % 4] = points[k];
  }
  double toi = kNoCollision;
  if (!method->collides(query, toi)) toi = kNoCollision;
  const std::optional<TouchTime> truth =
      first_touch(edges ? PathKind::edge_edge : PathKind::point_triangle, points);
  if (toi != (truth ? truth->lo : kNoCollision)) std::abort();
  return 0;
}
