// SPDX-License-Identifier: MIT
#include "response_claims.h"

#include "response_scenes.h"

#include <fmt/core.h>
#include <selvedge/core/cloth/measure.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numbers>
#include <random>
#include <vector>

namespace selvedge::bench {
namespace {

using std::numbers::pi;

// Number of bootstrap resamples. It determines the ends of the interval to about a twentieth of its
// width.
constexpr int kResamples = 2000;

struct Interval {
  double median = 0.0, low = 0.0, high = 0.0;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

/// 95 % interval of the median by the percentile bootstrap.
Interval bootstrap(const std::vector<double>& values, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<std::size_t> pick(0, values.size() - 1);
  std::vector<double> medians, sample(values.size());
  for (int k = 0; k < kResamples; ++k) {
    for (double& v : sample) v = values[pick(random)];
    medians.push_back(median(sample));
  }
  std::sort(medians.begin(), medians.end());
  const auto at = [&](double share) {
    return medians[static_cast<std::size_t>(share * (kResamples - 1))];
  };
  return {median(values), at(0.025), at(0.975)};
}

std::string text(const Interval& i) {
  return fmt::format("{:.4g} [{:.4g}, {:.4g}]", i.median, i.low, i.high);
}

// -- C9 -----------------------------------------------------------------------------------------

struct Rival {
  std::string name;
  MethodOptions config;
};

double drape_points(const ResponseCase& c, const std::vector<Vec3>& x) {
  const ClothMesh cloth = build_scene(c.scene).cloth;
  const double flat = projected_area(cloth.surface.vertices, cloth.surface.triangles);
  return 100.0 * projected_area(x, cloth.surface.triangles) / flat;
}

void print_pairs(const ResponseCase& c, const Rival& a, const Rival& b,
                 const ClaimOptions& options) {
  std::vector<double> ratios;
  ResponseRun last_a, last_b;
  for (int k = 0; k < options.repeats; ++k) {  // interleaved: A B, B A, ...
    if (k % 2 == 0) last_a = run(c, a.name, a.config);
    last_b = run(c, b.name, b.config);
    if (k % 2 == 1) last_a = run(c, a.name, a.config);
    ratios.push_back(last_a.seconds / last_b.seconds);
  }
  const auto lack = [](const ResponseRun& r) {
    return 1e3 * r.result.counters.at("max_gap_violation_m");
  };
  double apart = 0.0;
  for (std::size_t i = 0; i < last_a.x.size(); ++i) apart += (last_a.x[i] - last_b.x[i]).norm();
  fmt::print(
      "| {} | {} | {:g} | {:.2f} | {:.2f} | {} | {:.2f} | {:.2f} | {:.1f} | {:.1f} | {:.1f} |\n",
      c.name, last_a.x.size(), b.config["stiffness"], last_a.seconds, last_b.seconds,
      text(bootstrap(ratios, options.seed)), lack(last_a), lack(last_b), drape_points(c, last_a.x),
      drape_points(c, last_b.x), 1e3 * apart / static_cast<double>(last_a.x.size()));
  std::fflush(stdout);
}

void print_c9(const ClaimOptions& options) {
  fmt::print(
      "\n### C9: position_velocity costs 13 % more than penalty and looks the same\n\n"
      "| scene | particles | K, N/m | position_velocity, s | penalty, s | ratio [95 %] | gap "
      "violation, mm | of penalty | shadow, % of flat | of penalty | mean distance, mm |\n"
      "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  for (const double stiffness : {100.0, 1000.0, 10000.0}) {
    MethodOptions config;
    config.set("stiffness", stiffness);
    // The guard cannot act on `penalty`, whose contacts store energy, so neither side has it.
    for (ResponseCase c : {ball(options.cells), table(options.cells)}) {
      c.scene.time.energy_guard = false;
      print_pairs(c, {"position_velocity", {}}, {"penalty", config}, options);
    }
  }
}

// Equal motion: both responses take the same few steps from the same states of a drape.

constexpr int kStates = 12, kStepsFromState = 4;

std::vector<SimulationState> states_of(const ResponseCase& c) {
  Simulation simulation(c.scene, build_scene(c.scene));
  std::vector<SimulationState> states;
  for (int k = 1; k <= kStates; ++k) {
    simulation.advance_to_frame(k * c.frames / kStates);
    states.push_back(simulation.state());
    states.back().contact_memory.clear();  // of a response that neither of both is
  }
  return states;
}

/// Processor time of the steps from each state.
std::vector<double> seconds_from(const ResponseCase& c, const Rival& rival,
                                 const std::vector<SimulationState>& states) {
  Scene scene = c.scene;
  scene.time.frames = 2 * c.frames;
  scene.contact.response = rival.name;
  scene.contact.response_options = rival.config;
  Simulation simulation(scene, build_scene(scene));
  std::vector<double> seconds;
  for (const SimulationState& state : states) {
    simulation.restore(state);
    const std::clock_t start = std::clock();
    for (int k = 0; k < kStepsFromState; ++k) simulation.step();
    seconds.push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return seconds;
}

void print_equal_motion(const ClaimOptions& options) {
  fmt::print(
      "\n{} steps from each of {} states of a drape with contact_force\n\n"
      "| scene | particles | K, N/m | position_velocity over penalty [95 %] |\n|---|--:|--:|--:|\n",
      kStepsFromState, kStates);
  for (const ResponseCase& drape : {ball(options.cells), table(options.cells)}) {
    ResponseCase c = drape;
    c.scene.time.energy_guard = false;
    const std::vector<SimulationState> states = states_of(c);
    for (const double stiffness : {100.0, 1000.0, 10000.0}) {
      MethodOptions config;
      config.set("stiffness", stiffness);
      std::vector<double> ratios;
      for (int k = 0; k < options.repeats; ++k) {
        const auto a = seconds_from(c, {"position_velocity", {}}, states);
        const auto b = seconds_from(c, {"penalty", config}, states);
        for (std::size_t i = 0; i < a.size(); ++i) ratios.push_back(a[i] / b[i]);
      }
      fmt::print("| {} | {} | {:g} | {} |\n", c.name, states[0].x.size(), stiffness,
                 text(bootstrap(ratios, options.seed)));
      std::fflush(stdout);
    }
  }
}

// C10 and C29: one particle on a plane

struct Hit {
  double depth = 0.0, seconds = 0.0, rebound = 0.0;
  bool diverged = false;
};

/// A particle hits a penalty contact at `speed`, in explicit steps of h seconds.
Hit hit(double mass, double speed, double stiffness, double damping, double h) {
  const auto response = responses().at("penalty")({{"stiffness", stiffness}, {"damping", damping}});
  const std::vector<Vec3> body_step{Vec3::Zero()};
  const std::vector<double> masses{mass}, inv_mass{1.0 / mass, 0.0};
  // The rest gap is large enough for any impact; the plane is at the height of the rest gap.
  const double rest = 10.0 * speed * std::sqrt(mass / stiffness) + 10.0 * speed * h;
  std::vector<Vec3> x{Vec3(0, 0, rest), Vec3::Zero()}, v{Vec3(0, 0, -speed)};
  Hit hit;
  do {
    const ContactPoint c{{0, 1, 1, 1}, {1, -1, 0, 0}, Vec3::UnitZ(), x[0].z(), rest, 0.0};
    response->begin({{x, inv_mass, 1, h}, masses, body_step, v, v, false});
    response->add({&c, 1});
    std::vector<Vec3> x_t1 = x;
    x_t1[0] += h * v[0];
    response->correct(x_t1);
    v[0] = (x_t1[0] - x[0]) / h;
    x = x_t1;
    hit.seconds += h;
    hit.depth = std::max(hit.depth, rest - x[0].z());
  } while (x[0].z() < rest && hit.seconds < 1e6 * h);
  hit.rebound = v[0].z() / speed;
  hit.diverged = hit.rebound > 1.1;
  return hit;
}

double root(double mass, double stiffness) { return std::sqrt(mass / stiffness); }

void print_c10(const ClaimOptions& options) {
  std::mt19937 random(options.seed);
  std::uniform_real_distribution<double> exponent(-1.0, 1.0);
  fmt::print(
      "\n### C10: a small K lets cloth penetrate, a large K separates it too strongly\n\n"
      "20 impacts per row, of masses about 0.1 g and speeds about 1 m/s; steps of 0.01 sqrt(m/K), "
      "but "
      "for the last columns, in steps of 1/120 s. Depth and time over v sqrt(m/K) and π "
      "sqrt(m/K).\n\n"
      "| K, N/m | depth at 1 m/s and 0.1 g, mm | depth ratio [95 %] | time ratio [95 %] | rebound "
      "[95 %] | step bound, s | rebound at h = 1/120 s |\n|--:|--:|--:|--:|--:|--:|--:|\n");
  for (double k = 10.0; k <= 1e7; k *= 10.0) {
    std::vector<double> depth, seconds, rebound;
    for (int i = 0; i < 20; ++i) {
      const double mass = 1e-4 * std::pow(10.0, exponent(random));
      const double speed = std::pow(10.0, exponent(random));
      const Hit h = hit(mass, speed, k, 0.0, 0.01 * root(mass, k));
      depth.push_back(h.depth / (speed * root(mass, k)));
      seconds.push_back(h.seconds / (pi * root(mass, k)));
      rebound.push_back(h.rebound);
    }
    const Hit coarse = hit(1e-4, 1.0, k, 0.0, 1.0 / 120.0);
    fmt::print("| {:g} | {:.4g} | {} | {} | {} | {:.3g} | {:.3g} |\n", k, 1e3 * root(1e-4, k),
               text(bootstrap(depth, options.seed)), text(bootstrap(seconds, options.seed)),
               text(bootstrap(rebound, options.seed)), 2.0 * root(1e-4, k), coarse.rebound);
  }
}

void print_c29(const ClaimOptions& options) {
  std::mt19937 random(options.seed + 1);
  std::uniform_real_distribution<double> exponent(-1.0, 1.0);
  fmt::print(
      "\n### C29: penalty is fully elastic; a damper corrects this\n\n"
      "| ζ | rebound [95 %] | damper that cannot pull, exp(-ζ(π - 2 asin ζ)/sqrt(1 - ζ²)) | damper "
      "that pulls, "
      "exp(-πζ/sqrt(1 - ζ²)) |\n|--:|--:|--:|--:|\n");
  for (const double zeta : {0.0, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8}) {
    std::vector<double> rebound;
    for (int i = 0; i < 20; ++i) {
      const double stiffness = 1e3 * std::pow(10.0, exponent(random));
      const double mass = 1e-4 * std::pow(10.0, exponent(random));
      const double damping = 2.0 * zeta * std::sqrt(mass * stiffness);
      rebound.push_back(hit(mass, 1.0, stiffness, damping, 0.002 * root(mass, stiffness)).rebound);
    }
    const double q = std::sqrt(1.0 - zeta * zeta);
    fmt::print("| {} | {} | {:.4f} | {:.4f} |\n", zeta, text(bootstrap(rebound, options.seed)),
               std::exp(-zeta * (pi - 2.0 * std::asin(zeta)) / q), std::exp(-zeta * pi / q));
  }
}

// -- C28 ----------------------------------------------------------------------------------------

/// Largest distance, m, between a drape on a ball at rest and the same drape on a ball, with ball
/// and cloth in motion.
double galilean_error(const std::string& response, const Vec3& drift, int cells) {
  std::vector<Vec3> ends[2];
  for (int k = 0; k < 2; ++k) {
    ResponseCase c = ball(cells);
    c.frames = 20;
    c.scene.solver.tolerance = 1e-10;
    if (k == 1) {
      const double end = c.frames / c.scene.time.fps;
      c.scene.cloths[0].velocity = drift;
      Keyframe start, last;
      last.time = end;
      last.translation = end * drift;
      c.scene.bodies[0].motion = {start, last};
      // A moving body is placed anew in each step, so it may differ from a body at rest in the last
      // bit.
    }
    ends[k] = run(c, response).x;
    if (k == 1)
      for (Vec3& x : ends[k]) x -= c.frames / c.scene.time.fps * drift;
  }
  double largest = 0.0;
  for (std::size_t i = 0; i < ends[0].size(); ++i)
    largest = std::max(largest, (ends[0][i] - ends[1][i]).norm());
  return largest;
}

void print_c28(const ClaimOptions& options) {
  const Vec3 drift(3.0, -2.0, 1.0);
  fmt::print(
      "\n### C28: the moving body's velocity in the reflection (eq. 49)\n\n"
      "A drape of 0.33 s on a ball at rest, and the same of cloth and ball at (3, -2, 1) m/s: the "
      "largest distance between the two.\n\n| response | m |\n|---|--:|\n");
  for (const auto& [name, make] : responses())
    fmt::print("| {} | {:.2g} |\n", name, galilean_error(name, drift, options.cells / 2));
  // As printed: the components of the absolute velocity, with the body's velocity added to them.
  std::mt19937 random(options.seed + 2);
  std::normal_distribution<double> normal;
  std::vector<double> printed, mended;
  constexpr double keep = 0.9, give = 0.5;
  const auto reflect = [=](const Vec3& v, const Vec3& n) {
    const Vec3 vn = n.dot(v) * n;
    return Vec3(keep * (v - vn) - give * vn);
  };
  for (int i = 0; i < 200; ++i) {
    const auto vector = [&] { return Vec3(normal(random), normal(random), normal(random)); };
    const Vec3 v = vector(), n = vector().normalized(), body = vector();
    const Vec3 at_rest = reflect(v, n);
    printed.push_back((reflect(v + body, n) + body - body - at_rest).norm() / body.norm());
    mended.push_back((reflect(v + body - body, n) + body - body - at_rest).norm() / body.norm());
  }
  fmt::print(
      "\nOne particle, 200 random velocities: |error| over the body's speed is {} for eq. 49 as "
      "printed and {} corrected.\n",
      text(bootstrap(printed, options.seed)), text(bootstrap(mended, options.seed)));
}

}  // namespace

void print_claims(const ClaimOptions& options) {
  const auto wanted = [&](const char* claim) {
    return options.only.empty() || options.only == claim;
  };
  if (wanted("C9")) print_equal_motion(options);
  if (wanted("C9")) print_c9(options);
  if (wanted("C10")) print_c10(options);
  if (wanted("C28")) print_c28(options);
  if (wanted("C29")) print_c29(options);
}

}  // namespace selvedge::bench
