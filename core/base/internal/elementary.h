// SPDX-License-Identifier: MIT
#pragma once

/// The elementary functions with the same bits on every machine. IEEE 754 fixes the results of
/// +, -, *, / and sqrt; it leaves those of sin, exp or atan2 to the C library, and libraries differ
/// in the last bit. These functions use the former alone, so a scene ends in the same state with
/// every compiler, processor and C library. The code that determines states calls no others
/// (`architecture_test` checks it).
///
/// Each is a truncated power series after a reduction of the argument. "ulp" below is the unit in
/// the last place of the exact result; the bounds are tested against `long double`. Special
/// values (NaN, infinities, signed zeros, numbers out of range) give what the C standard says.
namespace selvedge::elementary {

struct SineCosine {
  double sine = 0.0, cosine = 1.0;
};

/// Radians; 1.1 ulp for |x| <= 1e6. Beyond, |x| is first reduced by the double nearest to 2π, which
/// is as if x had a relative error of 4e-17.
SineCosine sin_cos(double x);
double sin(double x);
double cos(double x);
double tan(double x);  ///< 2.5 ulp

/// In [-π/2, π/2]; 1.6 ulp.
double atan(double x);
/// The angle of the point (x, y) in [-π, π]; 1.6 ulp.
double atan2(double y, double x);
double asin(double x);  ///< 3 ulp; NaN beyond [-1, 1]
double acos(double x);  ///< 3 ulp; NaN beyond [-1, 1]

double exp(double x);    ///< 1 ulp
double log(double x);    ///< 1 ulp
double log1p(double x);  ///< log(1 + x), 2 ulp
/// base^exponent = exp(exponent log(base)) for a base >= 0; NaN for a negative one. The error is
/// 1 + 3 |exponent log(base)| ulp.
double pow(double base, double exponent);
double cbrt(double x);             ///< 1 ulp
double hypot(double x, double y);  ///< sqrt(x² + y²) without overflow on the way; 1.2 ulp

}  // namespace selvedge::elementary
