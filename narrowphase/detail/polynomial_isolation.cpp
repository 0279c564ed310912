// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/check.h>
#include <selvedge/narrowphase/detail/polynomial_box.h>
#include <selvedge/narrowphase/detail/polynomial_division.h>
#include <selvedge/narrowphase/detail/polynomial_sign.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace selvedge::detail {
namespace {

/// The extremum of a cubic or quadratic with two sign changes, computed in doubles as a position in
/// the box. Accuracy does not matter.
template <class Int>
double guess_extremum(const Polynomial<Int>& local) {
  std::array<double, Polynomial<Int>::kMaxDegree + 1> c{};
  to_doubles(local, c);
  const int n = local.degree;
  const auto slope = [&](double s) {
    // d/ds of sum c[i] (1-s)^(n-i) s^i has the coefficients (i+1) c[i+1] - (n-i) c[i].
    double v = 0.0, power = 1.0;
    for (int i = n; i-- > 0;) {
      v = v * s + ((i + 1) * c[i + 1] - (n - i) * c[i]) * power;
      power *= 1.0 - s;
    }
    return v;
  };
  double lo = 0.0, hi = 1.0;
  const bool rising = slope(lo) < 0.0;
  constexpr int kSteps = 52;
  for (int step = 0; step < kSteps; ++step) {
    const double s = 0.5 * (lo + hi);
    ((slope(s) < 0.0) == rising ? lo : hi) = s;
  }
  return lo;
}

/// Separates two close roots by a point near the extremum between them, if the exact sign there
/// confirms it.
template <class Int>
bool separate_pair(const Polynomial<Int>& p, const Box<Int>& box, const Polynomial<Int>& local,
                   std::vector<Root<Int>>& roots) {
  constexpr std::int64_t kCells = std::int64_t{1} << kGuessedBits;
  const auto cell = static_cast<std::int64_t>(std::ldexp(guess_extremum(local), kGuessedBits));
  if (cell <= 0 || cell >= kCells) return false;
  Box<Int> left = part_of(box, kGuessedBits, 0, cell),
           right = part_of(box, kGuessedBits, cell, kCells);
  const int outer = first_sign(local);
  if (sign_at(p, right.k, right.m) != -outer) return false;
  roots.push_back(Root<Int>::isolated(p, std::move(left), outer));
  roots.push_back(Root<Int>::isolated(p, std::move(right), -outer));
  return true;
}

/// The zero of the second derivative of a cubic, as a position in the box. Accuracy does not
/// matter.
template <class Int>
double guess_inflection(const Polynomial<Int>& local) {
  std::array<double, Polynomial<Int>::kMaxDegree + 1> c{};
  to_doubles(local, c);
  const double at_lo = c[0] - 2.0 / 3.0 * c[1] + c[2] / 3.0;
  const double at_hi = c[1] / 3.0 - 2.0 / 3.0 * c[2] + c[3];
  const double place = at_lo / (at_lo - at_hi);
  return place > 0.0 && place < 1.0 ? place : 0.0;
}

/// A part of [0, 1] that may have roots.
template <class Int>
struct OpenBox {
  Box<Int> box;
  Polynomial<Int> local;    ///< the polynomial restricted to the box, times a power of two
  bool is_start = false;    ///< only the start of the box, which is a root
  int bits = kGuessedBits;  ///< of the next zoom
  bool grows = true;        ///< no zoom of this box has failed
};

/// num / den times 2^bits for num and den > 0, off by less than 1.
template <class Int>
Int scaled_quotient(const Int& num, const Int& den, int bits) {
  constexpr int kDigitBits =
      50;  // of a quotient of two mantissas that are certain but for the last
  Int rest = num << bits, quotient;
  while ((magnitude(rest) - den).sign() >= 0) {
    int e_rest = 0, e_den = 0;
    const double digit = rest.mantissa(e_rest) / den.mantissa(e_den);  // 0.5 to 2
    const int shift = e_rest - e_den - kDigitBits;
    Int part = Int(static_cast<std::int64_t>(std::ldexp(digit, kDigitBits)));
    part = shift >= 0 ? part << shift : part >> -shift;
    if (part.is_zero()) part = Int(rest.sign());
    rest = rest - part * den;
    quotient = quotient + part;
  }
  return quotient;
}

/// A rational u = num / den > 0 between two close roots of a cubic or quadratic, or in the middle
/// of three; false if there is none. Two roots of a cubic are at c - d and c + d, the third at a
/// distance of 1 from c: then the zero of the remainder p mod p' is about 4 d^2 from c.
template <class Int>
bool middle_of_close_roots(const Polynomial<Int>& p, int roots, Int& num, Int& den) {
  Polynomial<Int> line = derivative(p);
  if (p.degree == 3) line = roots == 3 ? derivative(line) : remainder(p, line);
  if (line.degree != 1 || line.c[0].sign() * line.c[1].sign() >= 0) return false;
  num = magnitude(line.c[0]);
  den = magnitude(line.c[1]);
  return true;
}

/// The cell of the box, divided into 2^bits, that has the middle of its roots in doubles, or for
/// more bits exactly; false if that is not in the box.
template <class Int>
bool cell_of_roots(const Polynomial<Int>& p, int changes, const OpenBox<Int>& part, Int& cell) {
  if (part.bits == kGuessedBits) {
    const double place = changes == 2 ? guess_extremum(part.local) : guess_inflection(part.local);
    constexpr std::int64_t kCells = std::int64_t{1} << kGuessedBits;
    cell = Int(std::clamp<std::int64_t>(static_cast<std::int64_t>(std::ldexp(place, kGuessedBits)),
                                        1, kCells - 1));
    return true;
  }
  Int num, den;
  if (!middle_of_close_roots(p, changes, num, den)) return false;
  const Int sum = num + den;
  const Int from_start = (num << part.box.m) - part.box.k * sum, width = part.box.width * sum;
  if (from_start.sign() <= 0 || (width - from_start).sign() <= 0) return false;
  cell = scaled_quotient(from_start, width, part.bits);
  return cell.sign() > 0 && (power_of_two<Int>(part.bits) - cell).sign() > 0;
}

/// Shrinks a box with several sign changes to two neighbouring cells of 2^part.bits if all changes
/// are in them. The box then has no root elsewhere, because the parts of a box together have at
/// most as many changes as the whole. Each zoom that succeeds doubles the bits of the next one, and
/// after the first that fails, each halves them: roots that are 2^-n apart take about log n zooms.
template <class Int>
bool zoom(const Polynomial<Int>& p, int changes, OpenBox<Int>& part) {
  for (; part.bits >= kGuessedBits; part.bits /= 2, part.grows = false) {
    Int cell;
    if (!cell_of_roots(p, changes, part, cell)) continue;
    const Box<Int>& box = part.box;
    Box<Int> cells{(box.k << part.bits) + box.width * (cell - Int(1)), box.width << 1,
                   box.m + part.bits};
    Polynomial<Int> local = restrict_to(p, cells);
    if (sign_changes(local) != changes) continue;
    part.box = std::move(cells);
    part.local = std::move(local);
    part.bits = part.grows ? 2 * part.bits : part.bits / 2;
    return true;
  }
  return false;
}

/// The magnitudes of the roots of sum of c[i] w^i, as powers of two, in ascending order: the slopes
/// of the upper hull of the points (i, log2 |c[i]|). The true ones differ by a few bits (Ostrowski
/// 1940). Returns their number.
template <class Int>
int root_scales(const Polynomial<Int>& p, std::array<int, Polynomial<Int>::kMaxDegree>& scales) {
  int count = 0;
  for (int i = 0; i < p.degree;) {
    int next = 0;
    double steepest = 0.0;
    for (int j = i + 1; j <= p.degree; ++j) {
      if (p.c[j].is_zero() || p.c[i].is_zero()) continue;
      const double slope = double(p.c[j].bit_length() - p.c[i].bit_length()) / (j - i);
      if (next == 0 || slope >= steepest) next = j, steepest = slope;
    }
    if (next == 0) {
      ++i;
      continue;
    }
    scales[count++] = -static_cast<int>(std::floor(steepest));
    i = next;
  }
  return count;
}

/// A cut of a box: into its first 2^-bits and the rest, or into its last 2^-bits and the rest.
struct Cut {
  int bits = 1;
  bool at_end = false;
};

/// A cut that parts roots of very different size, or from the ends of the box roots that are much
/// smaller than it; otherwise the middle.
template <class Int>
Cut cut_between_scales(const Polynomial<Int>& local) {
  constexpr int kFar = 10, kRoom = 5;  // bits
  std::array<int, Polynomial<Int>::kMaxDegree> scales{};
  const int n = root_scales(local, scales);
  if (n == 0) return {};
  if (scales[n - 1] < -kFar) return {-scales[n - 1] - kRoom, false};
  if (scales[0] > kFar) return {scales[0] - kRoom, true};
  for (int i = 0; i + 1 < n; ++i) {
    if (scales[i + 1] - scales[i] <= 2 * kFar) continue;
    const int middle = scales[i] + (scales[i + 1] - scales[i]) / 2;
    return {std::max(std::abs(middle), 1), middle > 0};
  }
  return {};
}

/// The two parts of a box. Their polynomials are made from that of the box, of whose coordinates
/// the cut is a power of two, rather than from p, whose coordinates may have hundreds of bits.
template <class Int>
std::array<OpenBox<Int>, 2> parts_of(const OpenBox<Int>& part, const Cut& cut) {
  const Int cells = power_of_two<Int>(cut.bits), at = cut.at_end ? cells - Int(1) : Int(1);
  const auto make = [&](const Int& begin, const Int& width) {
    const Box<Int>& box = part.box;
    Polynomial<Int> local = restrict_to(part.local, Box<Int>{begin, width, cut.bits});
    drop_content(local);
    return OpenBox<Int>{
        {(box.k << cut.bits) + box.width * begin, box.width * width, box.m + cut.bits},
        std::move(local)};
  };
  return {make(Int(), at), make(at, cells - at)};
}

/// Roots of a square-free p strictly inside (0, 1), in ascending order. Terminates by the
/// two-circle theorem of Obreshkoff: small boxes have at most one sign change.
template <class Int>
void bisect_box(const Polynomial<Int>& p, std::vector<Root<Int>>& roots) {
  std::vector<OpenBox<Int>> open{{Box<Int>(), p}};
  while (!open.empty()) {
    OpenBox<Int> part = std::move(open.back());
    open.pop_back();
    const Box<Int>& box = part.box;
    if (part.is_start) {
      roots.push_back(Root<Int>::rational(box.k, power_of_two<Int>(box.m) - box.k));
      continue;
    }
    const int changes = sign_changes(part.local);
    if (changes == 0) continue;
    if (changes == 1) {
      roots.push_back(Root<Int>::isolated(p, box, first_sign(part.local)));
      continue;
    }
    const Cut cut = cut_between_scales(part.local);
    if (cut.bits == 1 && changes == 2 && separate_pair(p, box, part.local, roots)) continue;
    if (cut.bits == 1 && zoom(p, changes, part)) {
      open.push_back(std::move(part));
      continue;
    }
    auto [left, right] = parts_of(part, cut);
    OpenBox<Int> start{right.box, {}, true};
    const bool starts_with_root = right.local.c[0].is_zero();
    open.push_back(std::move(right));
    if (starts_with_root) open.push_back(std::move(start));
    open.push_back(std::move(left));
  }
}

template <class Int>
void push_if_positive(const Int& num, const Int& den, int multiplicity,
                      std::vector<Root<Int>>& roots) {
  if (num.sign() * den.sign() <= 0) return;
  roots.push_back(Root<Int>::rational(magnitude(num), magnitude(den)));
  roots.back().multiplicity = multiplicity;
}

/// Roots u > 0 of a quadratic or cubic p that has a multiple root: all of them are rational.
/// `common` is gcd(p, p').
template <class Int>
void multiple_roots(const Polynomial<Int>& p, const Polynomial<Int>& common,
                    std::vector<Root<Int>>& roots) {
  if (common.degree == 2) {  // (u - r)^3
    push_if_positive(-common.c[1], common.c[2] << 1, 3, roots);
    return;
  }
  // common = h1 u + h0 and p = (h1 u + h0)^2 (m1 u + m0) / w: the other root is -m0 / m1.
  const Int& h0 = common.c[0];
  const Int& h1 = common.c[1];
  push_if_positive(-h0, h1, 2, roots);
  if (p.degree < 3) return;
  const Int num = -(p.c[0] * h1 * h1);
  const Int den = p.c[3] * h0 * h0;
  const std::size_t n = roots.size();
  const bool had_double = h0.sign() * h1.sign() < 0;
  push_if_positive(num, den, 1, roots);
  if (!had_double || roots.size() == n) return;
  // Ascending: -h0 / h1 against num / den.
  if ((magnitude(num) * magnitude(h1) - magnitude(h0) * magnitude(den)).sign() < 0)
    std::swap(roots[n - 1], roots[n]);
}

/// The sign of the discriminant of a cubic a u³ + b u² + c u + d: positive if it has three real
/// roots, 0 if it has a multiple one.
template <class Int>
int cubic_discriminant_sign(const Polynomial<Int>& p) {
  {
    const Scaled a = scaled(p.c[3]), b = scaled(p.c[2]), c = scaled(p.c[1]), d = scaled(p.c[0]);
    const Scaled bb = b * b, cc = c * c, ad = a * d;
    if (const int s = certain_sign(std::array{bb * cc, -4.0 * (a * (cc * c)), -4.0 * (bb * (b * d)),
                                              -27.0 * (ad * ad), 18.0 * (ad * (b * c))});
        s != 0)
      return s;
  }
  // b²c² - 4ac³ - 4b³d - 27a²d² + 18abcd = (bc)² + 18 bc ad - 27 (ad)² - 4 (ac c² + bd b²)
  const Int &a = p.c[3], &b = p.c[2], &c = p.c[1], &d = p.c[0];
  const Int bc = b * c, ad = a * d;
  Int exact = bc * bc;
  exact.add_product(bc * Int(18), ad);
  exact.add_product(ad * Int(27), ad, true);
  exact.add_product((a * c) << 2, c * c, true);
  exact.add_product((b * d) << 2, b * b, true);
  return exact.sign();
}

/// Roots in the open interval (0, 1) of p with nonzero outer coefficients.
template <class Int>
void interior_roots(const Polynomial<Int>& p, std::vector<Root<Int>>& roots) {
  const int changes = sign_changes(p);
  if (changes == 0) return;
  if (p.degree == 1) {
    push_if_positive(-p.c[0], p.c[1], 1, roots);
    return;
  }
  if (changes == 1) {
    roots.push_back(Root<Int>::isolated(p, Box<Int>(), p.c[0].sign()));
    return;
  }
  // Roots u > 0 of p. If all roots are real, there are as many as sign changes (Descartes).
  const int discriminant = p.degree == 2 ? discriminant_sign(p) : cubic_discriminant_sign(p);
  if (discriminant == 0) {
    Polynomial<Int> slope = derivative(p);
    const Polynomial<Int> common = p.degree == 2 ? slope : remainder(p, slope);
    multiple_roots(p, common.is_zero() ? slope : common, roots);
  } else if (discriminant > 0) {
    bisect_box(p, roots);
  } else if (changes == 3) {  // the other two roots are not real
    roots.push_back(Root<Int>::isolated(p, Box<Int>(), p.c[0].sign()));
  }
}

}  // namespace

template <class Int>
void isolate_roots(const Polynomial<Int>& p, std::vector<Root<Int>>& roots) {
  SELVEDGE_ASSERT(!p.is_zero());
  Polynomial<Int> inner = p;
  drop_content(inner);
  int zeros = 0;
  while (inner.c[zeros].is_zero()) ++zeros;
  for (int i = 0; i + zeros <= inner.degree; ++i) inner.c[i] = inner.c[i + zeros];
  inner.degree -= zeros;
  const int before = inner.degree;
  drop_leading_zeros(inner);
  for (int i = inner.degree + 1; i <= Polynomial<Int>::kMaxDegree; ++i) inner.c[i] = Int();
  if (zeros > 0) {
    roots.push_back(Root<Int>::rational(Int(), Int(1)));
    roots.back().multiplicity = zeros;
  }
  if (inner.degree > 0) interior_roots(inner, roots);
  if (before > inner.degree) {
    roots.push_back(Root<Int>::rational(Int(1), Int()));
    roots.back().multiplicity = before - inner.degree;
  }
}

template void isolate_roots(const Polynomial<BigInt>&, std::vector<Root<BigInt>>&);
template void isolate_roots(const Polynomial<SmallInt>&, std::vector<Root<SmallInt>>&);

}  // namespace selvedge::detail
