// SPDX-License-Identifier: MIT
//
// Gusts are a sum of random waves whose velocity is that of isotropic turbulence with the
// longitudinal correlation exp(-r² k0²/2) [Kraichnan1970]: wave vectors are normal with the
// deviation k0 in each direction, rates with k0 times the speed of the gusts, and the wind carries
// the waves along [Taylor1938]. The correlation length ∫ exp(-r² k0²/2) dr = sqrt(π/2)/k0 gives k0.
//
// A jet is a round turbulent one far from walls [Pope2000, section 5.1]. At the distance s along
// its axis the speed in the middle is u0/g with g = max(1, s/(B D)), B = 5.8; across it the profile
// is 1/(1 + r²/b²)². The width b = sqrt(3/4) g D keeps the momentum π u0² D²/4 of the nozzle at
// every s; far away, b/s = 0.149 agrees with the measured half-width of 0.096 s.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/air_flow.h>
#include <selvedge/core/cloth/detail/force_checks.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <stdexcept>

namespace selvedge::detail {
namespace {

constexpr int kModes = 32;
constexpr double kDecay = 5.8;  // B

/// Normally distributed numbers, the same with every standard library [BoxMuller1958].
class NormalNumbers {
 public:
  explicit NormalNumbers(std::uint64_t seed) : random_(seed) {}

  double operator()() {
    const double radius = std::sqrt(-2.0 * elementary::log(uniform()));
    return radius * elementary::cos(2.0 * std::numbers::pi * uniform());
  }
  Vec3 vector() {
    Vec3 v;
    for (int i = 0; i < 3; ++i) v[i] = (*this)();
    return v;
  }

 private:
  /// In (0, 1].
  double uniform() { return 0x1p-53 * static_cast<double>((random_() >> 11) + 1); }

  std::mt19937_64 random_;
};

}  // namespace

AirFlow::AirFlow(const AirConfig& config) : wind_(config.wind), jets_(config.jets) {
  if (!wind_.allFinite()) throw std::invalid_argument("wind is not finite");
  const AirGusts& gusts = config.gusts;
  require_number("speed of the gusts", gusts.speed);
  for (AirJet& jet : jets_) {
    require_number("speed of a jet", jet.speed);
    require_number("diameter of a jet", jet.diameter, false);
    const double length = jet.direction.norm();
    if (!jet.position.allFinite() || !std::isfinite(length) || !(length > 0.0))
      throw std::invalid_argument("a jet has no position or no direction");
    jet.direction /= length;
  }
  if (gusts.speed <= 0.0) return;
  require_number("length of the gusts", gusts.length, false);
  const double k0 = std::sqrt(0.5 * std::numbers::pi) / gusts.length;
  NormalNumbers normal(gusts.seed);
  double energy = 0.0;  // mean of |u|²
  for (int n = 0; n < kModes; ++n) {
    Mode mode;
    mode.wave = k0 * normal.vector();
    mode.rate = k0 * gusts.speed * normal();
    mode.cosine = normal.vector().cross(mode.wave);
    mode.sine = normal.vector().cross(mode.wave);
    energy += 0.5 * (mode.cosine.squaredNorm() + mode.sine.squaredNorm());
    modes_.push_back(mode);
  }
  const double scale = std::sqrt(3.0 / energy) * gusts.speed;
  for (Mode& mode : modes_) mode.cosine *= scale, mode.sine *= scale;
}

Vec3 AirFlow::velocity(const Vec3& x, double time) const {
  Vec3 u = wind_;
  const Vec3 carried = x - time * wind_;
  for (const Mode& mode : modes_) {
    const auto [sine, cosine] = elementary::sin_cos(mode.wave.dot(carried) + mode.rate * time);
    u += cosine * mode.cosine + sine * mode.sine;
  }
  for (const AirJet& jet : jets_) {
    const Vec3 from = x - jet.position;
    const double s = from.dot(jet.direction);
    if (s < 0.0) continue;  // behind the nozzle
    const double g = std::max(1.0, s / (kDecay * jet.diameter));
    const double r2 = (from - s * jet.direction).squaredNorm();
    const double profile = 1.0 + r2 / (0.75 * g * g * jet.diameter * jet.diameter);
    u += jet.speed / (g * profile * profile) * jet.direction;
  }
  return u;
}

}  // namespace selvedge::detail
