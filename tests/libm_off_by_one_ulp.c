// SPDX-License-Identifier: MIT
// Preloaded by same_bits.sh: the transcendental functions of the C library, each result off by one unit in the last
// place. A result of selvedge that depends on the library's own last bits changes with it.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>

static double off(double y) { return y == 0.0 || y == 1.0 || y == -1.0 ? y : nextafter(y, INFINITY); }

#define ONE(name)                                                              \
  double name(double x) {                                                      \
    static double (*real)(double);                                             \
    if (!real) *(void**)&real = dlsym(RTLD_NEXT, #name);                       \
    return off(real(x));                                                       \
  }
#define TWO(name)                                                              \
  double name(double x, double y) {                                            \
    static double (*real)(double, double);                                     \
    if (!real) *(void**)&real = dlsym(RTLD_NEXT, #name);                       \
    return off(real(x, y));                                                    \
  }
ONE(sin) ONE(cos) ONE(tan) ONE(asin) ONE(acos) ONE(atan) ONE(exp) ONE(exp2) ONE(expm1) ONE(log) ONE(log2) ONE(log10)
ONE(log1p) ONE(cbrt) ONE(sinh) ONE(cosh) ONE(tanh) TWO(atan2) TWO(pow) TWO(hypot)
void sincos(double x, double* s, double* c) {
  *s = sin(x);
  *c = cos(x);
}
