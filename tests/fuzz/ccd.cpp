// SPDX-License-Identifier: MIT
// Queries against the judge, which shares no code with ccd_exact: the same verdict and time. Each
// byte chooses a coordinate from a table of small integers and numbers of other magnitudes, so that
// degenerate queries are common; 255 takes the next eight bytes as a double.
#include <selvedge/judge/judge.h>
#include <selvedge/narrowphase/ccd_methods.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>

#include "fuzz.h"

namespace {

using namespace selvedge;

class Bytes {
 public:
  Bytes(const std::uint8_t* bytes, std::size_t n) : at_(bytes), left_(n) {}

  std::uint8_t byte() {
    if (left_ == 0) return 0;
    --left_;
    return *at_++;
  }
  double coordinate() {
    constexpr double kOther[] = {5e-324, -5e-324, 1e-310, 1e-160,  -1e-60, 1e-18,
                                 1e18,   1e150,   0.1,    1.0 / 3, -0.7,   0x1p-52};
    const std::uint8_t b = byte();
    if (b < 200) return static_cast<double>(b % 9) - 4.0;
    if (b < 255) return kOther[(b - 200) % std::size(kOther)];
    double value = 0.0;
    std::array<std::uint8_t, sizeof value> raw;
    for (std::uint8_t& r : raw) r = byte();
    std::memcpy(&value, raw.data(), sizeof value);
    return std::isfinite(value) ? value : 0.0;
  }

 private:
  const std::uint8_t* at_;
  std::size_t left_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t n) {
  static const auto method = make_ccd_exact();
  Bytes in(bytes, n);
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
