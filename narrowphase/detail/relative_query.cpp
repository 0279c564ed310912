// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/detail/relative_query.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace selvedge::detail {
namespace {

/// Coordinates above this value are divided by kSmaller first, so that their differences are
/// finite.
constexpr double kHuge = 0x1p1000;
constexpr int kSmallerExponent = 4;
constexpr double kSmaller = 0x1p-4;

double largest(const std::array<Vec3, 4>& x) {
  Vec3 m = x[0].cwiseAbs();
  for (int k = 1; k < 4; ++k) m = m.cwiseMax(x[k].cwiseAbs());
  return m.maxCoeff();
}

/// Two factors whose product is 2^-exponent: a single one would overflow for subnormal coordinates.
void scale(RelativeQuery& q, int exponent) {
  const int half = -exponent / 2;
  const double first = std::ldexp(1.0, half), second = std::ldexp(1.0, -exponent - half);
  for (auto* x : {&q.x_t0, &q.x_t1})
    for (Vec3& v : *x) v = (v * first) * second;
}

}  // namespace

RelativeQuery relative_query(const Query& query) {
  RelativeQuery q;
  q.edges = query.kind == ContactKind::edge_edge;
  const bool huge = std::max(largest(query.x_t0), largest(query.x_t1)) > kHuge;
  const double factor = huge ? kSmaller : 1.0;
  for (int k = 0; k < 4; ++k) {
    q.x_t0[k] = factor * query.x_t0[k] - factor * query.x_t0[0];
    q.x_t1[k] = factor * query.x_t1[k] - factor * query.x_t1[0];
  }
  const double size = std::max(largest(q.x_t0), largest(q.x_t1));
  q.one_point = !(size > 0.0);
  if (q.one_point) return q;
  std::frexp(size, &q.exponent);
  scale(q, q.exponent);
  if (huge) q.exponent += kSmallerExponent;
  return q;
}

double scaled_up(double length, const RelativeQuery& query) {
  const double scaled = std::ldexp(length, -query.exponent);
  // Below 2^-1021 ldexp may have rounded.
  return length > 0.0 && scaled < 0x1p-1021 ? scaled + 0x1p-1074 : scaled;
}

std::array<Vec3, 4> places(const RelativeQuery& query, double t) {
  const double s = 1.0 - t;
  std::array<Vec3, 4> x;
  x[0] = Vec3::Zero();
  for (int k = 1; k < 4; ++k) x[k] = s * query.x_t0[k] + t * query.x_t1[k];
  return x;
}

void require_separation(double length, const char* method) {
  if (std::isfinite(length) && length >= 0.0) return;
  throw std::invalid_argument(std::string(method) + ": min_separation is " +
                              std::to_string(length) +
                              "; it must be a finite number of metres, 0 or more");
}

}  // namespace selvedge::detail
