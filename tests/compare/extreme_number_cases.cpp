// SPDX-License-Identifier: MIT
// Extreme cases of numbers: stiffness, scale, time, and rejected input.
#include "extreme_cases.h"

#include <fmt/format.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/solver/integrator.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace selvedge::extreme_test {
namespace {

std::string text(double value) { return fmt::format("{:.17g}", value); }

std::string vector_text(const Vec3& v) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
}

double farthest(std::span<const Vec3> a, std::span<const Vec3> b, const Vec3& shift, double scale) {
  double worst = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    worst = std::max(worst, (scale * b[i] - shift - a[i]).norm());
  return worst;
}

// S1: stiffness against step length

const std::vector<double> stiffnesses = {1.0, 1e2, 1e4, 1e6, 1e8};  // N/m
const std::vector<double> rates = {60.0, 240.0, 1e3, 1e4, 1e5};     // steps per second

std::vector<Override> stiff(double stiffness, double rate, const std::string& integrator) {
  return {{"materials.default.stretch_stiffness", text(stiffness)},
          {"materials.default.shear_stiffness", text(stiffness / 5.0)},
          {"time.fps", text(rate)},
          {"solver.integrator", integrator},
          {"solver.strain_limiter", "false"}};
}

CaseResult stiff_implicit(Trial& trial) {
  double most = 0.0, open = 0.0;
  int runs = 0;
  for (const double stiffness : stiffnesses)
    for (const double rate : rates) {
      const JudgedRun run = trial.run("s01_stiffness", stiff(stiffness, rate, "implicit_euler"));
      if (!run.finite || !run.refused.empty() || !run.stopped.empty())
        return trial.settle(run, false, "");
      const auto& counters = run.result.counters;
      const auto counted = [&](const char* name) {
        return counters.contains(name) ? counters.at(name) : 0.0;
      };
      most = std::max(most, counted("solver_iterations") / std::max(1.0, counted("solves")));
      open += counted("solves_not_converged");
      ++runs;
    }
  return trial.answer(open == 0.0 ? Answer::correct : Answer::degraded,
                      fmt::format("{} of 25 finite, at most {:.0f} iterations a solve, {} solves "
                                  "not converged",
                                  runs, most, open));
}

CaseResult stiff_explicit(Trial& trial) {
  int most = 0, runs = 0;
  for (const double stiffness : stiffnesses)
    for (const double rate : rates) {
      // The stiffest cloth at the longest step would need 12,000 sub-steps a frame.
      std::vector<Override> overrides = stiff(stiffness, rate, "symplectic_euler");
      overrides.push_back({"time.frames", "1"});
      overrides.push_back({"materials.default.spring_damping", "0"});
      overrides.push_back({"materials.default.bending_damping", "0"});
      if (stiffness >= 1e8 && rate < 1e3) continue;
      const JudgedRun run = trial.run("s01_stiffness", overrides);
      if (!run.finite || !run.refused.empty() || !run.stopped.empty() || run.worst_speed > 1.0)
        return trial.settle(run, false, "explosion");
      most = std::max(most, run.result.steps);
      ++runs;
    }
  return trial.answer(
      Answer::correct,
      fmt::format("{} of {} finite, a step of at most {} sub-steps", runs, runs, most));
}

/// True if a slightly perturbed grid becomes unstable within some thousand explicit steps.
bool blows_up(const ClothMesh& cloth, Integrator& integrator, double h) {
  const std::size_t n = cloth.surface.vertices.size();
  Particles p{cloth.surface.vertices, std::vector<Vec3>(n, Vec3::Zero()), cloth.mass, {}};
  for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
  constexpr double shake = 1e-9;  // m; linear, so that the limit is that of the rest shape
  for (std::size_t i = 0; i < n; ++i)
    p.x[i] += shake * Vec3(std::sin(1e3 * i), std::sin(2e3 * i), 0.0);
  std::vector<Vec3> v(n);
  constexpr int steps = 3000;
  for (int k = 0; k < steps; ++k) {
    integrator.begin({p, 0.0, h}, {v, {}});
    p.v = v;
    double largest = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      p.x[i] += h * v[i];
      largest = std::max(largest, (p.x[i] - cloth.surface.vertices[i]).norm());
    }
    if (!(largest < 1e3 * shake)) return true;
  }
  return false;
}

/// 2/√λ of the in-plane stretch. λ comes from power iteration on M⁻¹K, and K from differences of
/// the force.
double exact_limit(const ClothMesh& cloth, const Force& force) {
  const std::size_t n = cloth.surface.vertices.size();
  std::vector<Vec3> direction(n), f(n), zero(n, Vec3::Zero());
  for (std::size_t i = 0; i < n; ++i)
    direction[i] = Vec3(std::sin(1e3 * i), std::sin(2e3 * i), 0.0);
  constexpr double small = 1e-8;  // m
  constexpr int rounds = 400;
  double lambda = 0.0;
  for (int k = 0; k < rounds; ++k) {
    double norm = 0.0;
    for (const Vec3& d : direction) norm += d.squaredNorm();
    for (Vec3& d : direction) d /= std::sqrt(norm);
    std::vector<Vec3> x = cloth.surface.vertices;
    for (std::size_t i = 0; i < n; ++i) x[i] += small * direction[i];
    std::fill(f.begin(), f.end(), Vec3::Zero());
    force.add_force({x, zero, cloth.mass, 0.0}, f);
    lambda = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      direction[i] = -f[i] / (small * cloth.mass[i]);
      lambda += direction[i].squaredNorm();
    }
    lambda = std::sqrt(lambda);
  }
  return 2.0 / std::sqrt(lambda);
}

CaseResult explicit_limit(Trial& trial) {
  Material material;
  material.stretch_stiffness = 1e4;
  material.shear_stiffness = 2e3;
  material.spring_damping = material.bending_damping = material.bending_stiffness = 0.0;
  const ClothMesh cloth = make_rectangular({1.0, 1.0, 20, 20}, material);
  const std::size_t n = cloth.surface.vertices.size();
  const auto force = make_hooke_force(cloth.springs, n);
  std::vector<std::unique_ptr<Force>> forces;
  forces.push_back(make_hooke_force(cloth.springs, n));
  const auto integrator =
      integrators().at("symplectic_euler")(std::move(forces), n, ImplicitConfig{});
  Particles p{cloth.surface.vertices, std::vector<Vec3>(n, Vec3::Zero()), cloth.mass, {}};
  for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
  const double exact = exact_limit(cloth, *force),
               bound = integrator->stable_step(p, 0.0, std::numeric_limits<double>::infinity());
  double low = 0.5 * exact, high = 2.0 * exact;
  constexpr int halvings = 8;
  for (int k = 0; k < halvings; ++k) {
    const double middle = 0.5 * (low + high);
    (blows_up(cloth, *integrator, middle) ? high : low) = middle;
  }
  const bool right = std::abs(low / exact - 1.0) < 0.05 && bound <= exact * 1.0001;
  return trial.answer(
      right ? Answer::correct : Answer::failed,
      fmt::format("blows up above {:.4f} of 2/sqrt(lambda); the step is kept below {:.2f} of it",
                  low / exact, bound / exact));
}

// S3, S12: rejected input

/// The run is refused, and the message names the fault.
CaseResult refused(Trial& trial, const std::string& name, const std::vector<std::string>& words) {
  const JudgedRun run = trial.run(name);
  for (const std::string& word : words)
    if (run.refused.find(word) == std::string::npos)
      return trial.answer(Answer::failed, run.refused.empty() ? "accepted" : run.refused);
  return trial.settle(run, false, "");
}

CaseResult bad_numbers(Trial& trial) {
  const std::vector<Override> bad = {{"materials.default.density", "0"},
                                     {"materials.default.density", "-0.2"},
                                     {"materials.default.stretch_stiffness", "-1"},
                                     {"materials.default.friction", "-0.1"},
                                     {"materials.default.density", "1e999"},
                                     {"materials.default.density", "nan"},
                                     {"contact.rest_gap", "0"},
                                     {"contact.rest_gap", "-0.002"},
                                     {"time.fps", "0"},
                                     {"time.fps", "1e999"},
                                     {"time.fps", "-60"},
                                     {"time.frames", "0"},
                                     {"time.frames", "1.5"},
                                     {"time.steps_per_frame", "0"},
                                     {"gravity", "[0, 0, nan]"},
                                     {"gravity", "[0, 0, 1e999]"},
                                     {"geometry.0.size", "[1, -1]"},
                                     {"geometry.0.cells", "[0, 4]"},
                                     {"geometry.0.velocity", "[inf, 0, 0]"},
                                     {"solver.tolerance", "0"}};
  for (const Override& set : bad) {
    const JudgedRun run = trial.run("s17_no_body", {set});
    const std::string key = set.path.substr(set.path.rfind('.') + 1);
    if (run.refused.find(key) == std::string::npos)
      return trial.answer(Answer::failed,
                          fmt::format("{}={}: {}", set.path, set.value,
                                      run.refused.empty() ? "accepted" : run.refused));
  }
  return trial.answer(Answer::refused, fmt::format("all {} by their key", bad.size()));
}

/// Input without a file: a scene made in code.
CaseResult bad_code(Trial& trial) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Scene good = trial.read("s17_no_body");
  std::vector<std::pair<std::string, Scene>> bad;
  const auto with = [&](const std::string& name, const auto& change) {
    Scene scene = good;
    change(scene);
    bad.emplace_back(name, scene);
  };
  with("velocity", [&](Scene& s) { s.cloths[0].velocity.x() = nan; });
  with("translation", [&](Scene& s) { s.cloths[0].placement.translation.y() = nan; });
  with("density", [&](Scene& s) { s.materials["default"].density = nan; });
  with("gravity", [&](Scene& s) { s.gravity.z() = nan; });
  with("fps", [&](Scene& s) { s.time.fps = nan; });
  with("rest gap", [&](Scene& s) { s.contact.rest_gap = nan; });
  for (const auto& [name, scene] : bad) {
    const JudgedRun run = trial.run(scene);
    if (run.refused.empty())
      return trial.answer(Answer::failed,
                          fmt::format("a {} that is not a number is accepted{}", name,
                                      run.stopped.empty() ? "" : ", then: " + run.stopped));
  }
  return trial.answer(Answer::refused, fmt::format("all {} of a scene made in code", bad.size()));
}

// S13, S14: far from the origin, and tiny

CaseResult far_away(Trial& trial) {
  const Vec3 shift(1e6, -1e6, 1e6 - 1.0);
  const JudgedRun here = trial.run("s13_far_away");
  if (here.x.empty()) return trial.settle(here, false, "");
  const Vec3 at = here.scene.cloths[0].placement.translation + shift;
  const JudgedRun there =
      trial.run("s13_far_away", {{"geometry.0.transformation.translation", vector_text(at)},
                                 {"obstacles.0.transformation.translation", vector_text(shift)}});
  if (there.x.empty()) return trial.settle(there, false, "");
  // At this distance coordinates round to 2^-33 m = 1.2e-10 m in each step; contacts whose outcome
  // depends on the rounding amplify the difference.
  constexpr std::size_t falling = 5;  // the frame before the first contact
  const double free = farthest(here.frames[falling], there.frames[falling], shift, 1.0);
  const double touching = farthest(here.x, there.x, shift, 1.0);
  return trial.settle(there, free < 1e-8 && touching < 1e-4,
                      fmt::format("from the same at the origin: {:.1e} m while it falls, {:.1e} m "
                                  "on the ball",
                                  free, touching));
}

CaseResult tiny_by(Trial& trial, const std::string& friction) {
  const std::vector<Override> set = {{"obstacles.0.friction", friction},
                                     {"materials.default.friction", friction}};
  const JudgedRun large = trial.run("s14_scaled", set), small = trial.run("s14_scaled_tiny", set);
  if (large.x.empty() || small.x.empty())
    return trial.settle(large.x.empty() ? large : small, false, "");
  const double size = std::get<ClothGrid>(large.scene.cloths.at(0).shape).grid.size_x;
  const double worst = farthest(large.x, small.x, Vec3::Zero(), 0x1p20) / size;
  return trial.settle(small, worst < 1e-6,
                      fmt::format("{:.1e} of the size from the large one", worst));
}

CaseResult tiny(Trial& trial) { return tiny_by(trial, "0"); }
CaseResult tiny_with_friction(Trial& trial) { return tiny_by(trial, "0.3"); }

// S15: no gravity

CaseResult no_gravity(Trial& trial) {
  Scene scene = trial.read("s15_no_gravity");
  const JudgedRun run = trial.run(scene);
  if (run.x.empty()) return trial.settle(run, false, "");
  Vec3 momentum = Vec3::Zero();
  double mass = 0.0;
  for (std::size_t i = 0; i < run.v.size(); ++i) {
    momentum += run.cloth.mass[i] * run.v[i];
    mass += run.cloth.mass[i];
  }
  const Vec3 should = mass * scene.cloths[0].velocity;
  const double error = (momentum - should).norm() / should.norm();
  constexpr double a_step = 1e-12;
  return trial.settle(run, error < a_step * run.result.steps,
                      fmt::format("momentum kept to {:.1e} in {} steps", error, run.result.steps));
}

// S16: steps of any length

CaseResult huge_step(Trial& trial) {
  const JudgedRun run = trial.run("s16_huge_step");
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec3& p : run.x) {
    low = std::min(low, p.z());
    high = std::max(high, p.z());
  }
  const double size = std::get<ClothGrid>(run.scene.cloths.at(0).shape).grid.size_x;
  return trial.settle(
      run, low > 0.0 && high < size && run.time == 5.0,
      fmt::format("ends at 5 s; on the floor, {:.3g} to {:.3g} mm high", 1e3 * low, 1e3 * high));
}

/// Height lost by symplectic or implicit Euler in n steps of free fall: g h² n(n+1)/2.
double fallen(double h, double n) { return 9.81 * h * h * n * (n + 1.0) / 2.0; }

CaseResult free_fall(Trial& trial, const std::string& name) {
  const JudgedRun run = trial.run(name);
  if (run.x.empty()) return trial.settle(run, false, "");
  const double n = run.result.steps, end = run.scene.time.frames / run.scene.time.fps;
  double worst = 0.0;
  const double should = fallen(end / n, n);
  for (std::size_t i = 0; i < run.x.size(); ++i)
    worst = std::max(worst, std::abs(run.frames[0][i].z() - run.x[i].z() - should));
  return trial.settle(
      run, run.time == end && worst < 1e-9 * should,
      fmt::format("ends at frames/fps to the bit; falls {:.6f} m, {:.1e} from the sum of its steps",
                  should, worst));
}

// S17: minimal input

CaseResult all_pinned(Trial& trial) {
  const JudgedRun run = trial.run("s17_all_pinned");
  const bool same = !run.x.empty() && run.x == run.frames[0];
  return trial.settle(run, same, "every bit where it was");
}

CaseResult one_triangle(Trial& trial) {
  const JudgedRun run = trial.run("s17_one_triangle");
  double worst = 0.0;
  for (const Vec3& p : run.x) worst = std::max(worst, std::abs(p.z() - run.scene.contact.rest_gap));
  return trial.settle(run, worst < 1e-4,
                      fmt::format("lies at the rest gap within {:.1e} m", worst));
}

// S21: identical bits

CaseResult determinism(Trial& trial) {
  std::vector<std::string> hashes;
  std::string counts;
  JudgedRun run;
  for (const int threads : {1, 2, 8, 1}) {
    const ThreadLimit limit(threads);
    run = trial.run("s21_determinism");
    hashes.push_back(run.result.state_hash);
    counts += fmt::format("{}{}", counts.empty() ? "" : ", ", thread_count());
  }
  const bool same =
      std::all_of(hashes.begin(), hashes.end(), [&](const auto& h) { return h == hashes[0]; });
  return trial.settle(run, same, fmt::format("the same bits on {} threads: {}", counts, hashes[0]));
}

// S22: long rest

CaseResult at_rest(Trial& trial) {
  const JudgedRun run = trial.run("s22_at_rest");
  if (run.x.empty()) return trial.settle(run, false, "");
  // After the first second, during which the cloth settles.
  const double creep = farthest(run.frames[60], run.x, Vec3::Zero(), 1.0);
  return trial.settle(run, creep < 1e-6 && run.worst_speed < 0.1 && run.rms_speed < 1e-6,
                      fmt::format("creeps {:.1e} m in {} steps, rms speed {:.1e} m/s", creep,
                                  run.result.steps, run.rms_speed));
}

// S24: ten times the mass

CaseResult wet(Trial& trial) {
  const JudgedRun wet = trial.run("s24_wet");
  const JudgedRun dry = trial.run("s24_wet", {{"materials.default.density", "0.2"}});
  if (wet.x.empty() || dry.x.empty()) return trial.settle(wet.x.empty() ? wet : dry, false, "");
  const double ratio = static_cast<double>(dry.result.steps) / wet.result.steps;
  // Without damping the step length scales with the root of the mass, up to the rounding to whole
  // sub-steps.
  return trial.settle(wet, std::abs(ratio / std::sqrt(10.0) - 1.0) < 0.1,
                      fmt::format("{} sub-steps wet, {} dry: {:.2f} times", wet.result.steps,
                                  dry.result.steps, ratio));
}

}  // namespace

std::vector<ExtremeCase> number_cases() {
  const auto free = [](const char* name) {
    return [name](Trial& trial) { return free_fall(trial, name); };
  };
  const auto refusing = [](const char* name, std::vector<std::string> words) {
    return [=](Trial& trial) { return refused(trial, name, words); };
  };
  using enum Answer;
  return {
      {"s01_explicit", correct, false, stiff_explicit},
      {"s01_explicit_limit", correct, true, explicit_limit},
      {"s01_implicit", correct, false, stiff_implicit},
      {"s03_degenerate_cloth", Answer::refused, true,
       refusing("s03_degenerate_cloth", {"triangle 1", "no area"})},
      {"s03_duplicate_vertices", Answer::refused, true,
       refusing("s03_duplicate_vertices", {"vertices 2 and 5", "weld"})},
      {"s12_bad_numbers", Answer::refused, true, bad_numbers},
      {"s12_bad_code", Answer::refused, true, bad_code},
      {"s13_far_away", correct, true, far_away},
      {"s14_scaled_friction", correct, false, tiny_with_friction},
      {"s14_scaled_tiny", correct, true, tiny},
      {"s15_no_gravity", correct, true, no_gravity},
      {"s16_huge_step", correct, true, huge_step},
      {"s16_odd_step", correct, true, free("s16_odd_step")},
      {"s17_all_pinned", correct, true, all_pinned},
      {"s17_empty", Answer::refused, true, refusing("s17_empty", {"no triangles"})},
      {"s17_no_body", correct, true, free("s17_no_body")},
      {"s17_one_node", Answer::refused, true, refusing("s17_one_node", {"no triangles"})},
      {"s17_one_triangle", correct, true, one_triangle},
      {"s21_determinism", correct, false, determinism},
      {"s22_at_rest", correct, false, at_rest},
      {"s24_wet", correct, false, wet},
  };
}

}  // namespace selvedge::extreme_test
