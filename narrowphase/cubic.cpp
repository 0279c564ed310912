// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/cubic.h>
#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/detail/cubic_solver.h>
#include <selvedge/narrowphase/detail/exact_query.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

using Polynomial = detail::Polynomial<BigInt>;
using Root = detail::Root<BigInt>;

CubicRoots enclose(const Polynomial& p) {
  CubicRoots result;
  result.identically_zero = p.is_zero();
  if (result.identically_zero) return result;
  std::vector<Root> roots;
  detail::isolate_roots(p, roots);
  for (const Root& root : roots) {
    bool exact = false;
    const double lo = root.floor(exact);
    result.roots.push_back({lo, exact ? lo : std::nextafter(lo, 2.0), root.multiplicity});
  }
  return result;
}

void require_finite(const std::array<double, 4>& c) {
  for (int i = 0; i < 4; ++i)
    if (!std::isfinite(c[i]))
      throw std::invalid_argument("cubic: coefficient " + std::to_string(i) +
                                  " is not a finite number");
}

}  // namespace

CubicRoots cubic_roots(const std::array<double, 4>& c) {
  require_finite(c);
  int exponent = std::numeric_limits<int>::max();
  for (const double a : c)
    if (a != 0.0) exponent = std::min(exponent, lowest_bit(a));
  // t^i = sum over j >= i of binomial(3 - i, j - i) (1 - t)^(3 - j) t^j.
  constexpr int kBinomial[4][4] = {{1, 3, 3, 1}, {0, 1, 2, 1}, {0, 0, 1, 1}, {0, 0, 0, 1}};
  Polynomial p;
  p.degree = 3;
  for (int i = 0; i < 4; ++i) {
    const BigInt a = BigInt::from_double(c[i], exponent);
    for (int j = i; j < 4; ++j) p.c[j].add_product(a, BigInt(kBinomial[i][j]));
  }
  return enclose(p);
}

CubicRoots coplanarity_roots(const Query& query) {
  detail::require_finite(query);
  return enclose(detail::coplanarity_cubic(query));
}

CubicRootEstimates estimate_cubic_roots(const std::array<double, 4>& c, double touching) {
  require_finite(c);
  const double largest = std::max({std::abs(c[0]), std::abs(c[1]), std::abs(c[2]), std::abs(c[3])});
  int exponent = 0;
  std::frexp(largest, &exponent);
  std::array<double, 4> scaled;
  for (int i = 0; i < 4; ++i) scaled[i] = std::ldexp(c[i], -exponent);
  CubicRootEstimates roots;
  detail::estimate_roots(scaled, std::ldexp(touching, -exponent), roots);
  return roots;
}

}  // namespace selvedge
