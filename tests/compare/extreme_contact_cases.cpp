// SPDX-License-Identifier: MIT
// Extreme cases of contact: surfaces that the cloth must not pass, and where it must end up.
#include "extreme_cases.h"

#include <fmt/format.h>
#include <selvedge/core/cloth/force.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace selvedge::extreme_test {
namespace {

double lowest(std::span<const Vec3> x) {
  double z = std::numeric_limits<double>::infinity();
  for (const Vec3& p : x) z = std::min(z, p.z());
  return z;
}

double highest(std::span<const Vec3> x) {
  double z = -std::numeric_limits<double>::infinity();
  for (const Vec3& p : x) z = std::max(z, p.z());
  return z;
}

Vec3 mean(std::span<const Vec3> x) {
  return std::accumulate(x.begin(), x.end(), Vec3(Vec3::Zero())) / static_cast<double>(x.size());
}

std::size_t last_frame(const JudgedRun& run) { return run.frames.size() - 1; }

/// Height of the lowest cloth layer above a point of the xy-plane; infinity if there is none.
double height_over(std::span<const Vec3> x, std::span<const Triangle> triangles, double px,
                   double py) {
  double height = std::numeric_limits<double>::infinity();
  const Vec3 p(px, py, 0.0);
  for (const Triangle& t : triangles) {
    const auto flat = [&](int k) { return Vec3(x[t[k]].x(), x[t[k]].y(), 0.0); };
    const double area = (flat(1) - flat(0)).cross(flat(2) - flat(0)).z();
    if (area == 0.0) continue;
    double part[3], z = 0.0;
    for (int k = 0; k < 3; ++k) {
      part[k] = (flat((k + 1) % 3) - p).cross(flat((k + 2) % 3) - p).z() / area;
      z += part[k] * x[t[k]].z();
    }
    if (part[0] >= 0.0 && part[1] >= 0.0 && part[2] >= 0.0) height = std::min(height, z);
  }
  return height;
}

/// Vertical force of the springs on the held particles, N.
double pull_on_held(const JudgedRun& run) {
  const std::size_t n = run.x.size();
  std::vector<Vec3> f(n, Vec3::Zero()), v(n, Vec3::Zero());
  const auto hooke = make_hooke_force(run.cloth.springs, n);
  hooke->add_force({run.x, v, run.cloth.mass, 0.0}, f);
  double sum = 0.0;
  for (const HandleSpec& handle : run.scene.handles)
    for (const std::int32_t i : handle.vertices) sum += f[i].z();
  return sum;
}

// S2: mass ratio

CaseResult button(Trial& trial) {
  const JudgedRun run = trial.run("s02_button");
  if (run.x.empty()) return trial.settle(run, false, "");
  double hanging = 0.0;  // N; weight of all particles except the held row
  for (const double m : run.cloth.mass) hanging += 9.81 * m;
  for (const std::int32_t i : run.scene.handles[0].vertices) hanging -= 9.81 * run.cloth.mass[i];
  const double pull = -pull_on_held(run);
  return trial.settle(run, std::abs(pull / hanging - 1.0) < 0.01,
                      fmt::format("the pins carry {:.5f} of the weight", pull / hanging));
}

CaseResult heavy_on_light(Trial& trial) {
  const JudgedRun run = trial.run("s02_heavy_on_light");
  if (run.x.empty()) return trial.settle(run, false, "");
  const std::size_t end = last_frame(run);
  const double light = mean(run.piece(end, 0)).z(), heavy = mean(run.piece(end, 1)).z();
  const double gap = run.scene.contact.rest_gap;
  // Mean height of the light sheet, which sags under the heavy one.
  return trial.settle(run, heavy > light && light > 0.25 * gap,
                      fmt::format("order kept; at {:.3g} and {:.3g} mm, {:.3g} and {:.3g} by the "
                                  "rest gap",
                                  1e3 * light, 1e3 * heavy, 1e3 * gap, 2e3 * gap));
}

// S4: 1 km/s

CaseResult bullet(Trial& trial) {
  const JudgedRun run = trial.run("s04_bullet");
  if (run.x.empty()) return trial.settle(run, false, "");
  bool in_front = true;
  for (std::size_t f = 0; f < run.frames.size(); ++f) {
    const double at = mean(run.piece(f, 1)).z();
    in_front = in_front && at > lowest(run.piece(f, 0));
  }
  Vec3 before = Vec3::Zero(), after = Vec3::Zero();
  for (std::size_t i = 0; i < run.v.size(); ++i) after += run.cloth.mass[i] * run.v[i];
  for (std::int32_t i = run.piece_begin[1]; i < run.piece_begin[2]; ++i)
    before += run.cloth.mass[i] * run.scene.cloths[1].velocity;
  const double error = (after - before).norm() / before.norm();
  // Springs that stretch to a thousand times their limit in one step have correspondingly large
  // rounding errors.
  constexpr double tolerance = 1e-8;
  return trial.settle(run, in_front && error < tolerance,
                      fmt::format("the sheet stops it; momentum kept to {:.1e}", error));
}

CaseResult plate(Trial& trial) {
  const JudgedRun run = trial.run("s04_plate");
  double least = std::numeric_limits<double>::infinity();
  for (const auto& x : run.frames) least = std::min(least, lowest(x));
  return trial.settle(run, least > 0.5e-4,
                      fmt::format("lowest vertex {:.3g} mm above the plate", 1e3 * (least - 5e-5)));
}

// S5: layers

CaseResult stack(Trial& trial) {
  const JudgedRun run = trial.run("s05_stack");
  if (run.x.empty()) return trial.settle(run, false, "");
  const std::size_t end = last_frame(run), sheets = run.piece_begin.size() - 1;
  bool ordered = true;
  double below = 0.0, worst_gap = 0.0;
  const double gap = run.scene.contact.rest_gap;
  for (std::size_t k = 0; k < sheets; ++k) {
    const double at = mean(run.piece(end, k)).z();
    ordered = ordered && at > below;
    worst_gap = std::max(worst_gap, std::abs(at - below - gap));
    below = at;
  }
  return trial.settle(run, ordered,
                      fmt::format("20 sheets in order, gaps within {:.1f} % of the rest gap, rms "
                                  "speed {:.2g} mm/s",
                                  100.0 * worst_gap / gap, 1e3 * run.rms_speed));
}

// S6: ring

CaseResult ring(Trial& trial, const std::string& name) {
  const JudgedRun run = trial.run(name);
  if (run.x.empty()) return trial.settle(run, false, "");
  const auto& x = run.frames.back();
  const double ring_height = run.scene.bodies[0].placement.translation.z();
  const auto through =
      std::count_if(x.begin(), x.end(), [&](const Vec3& p) { return p.z() < ring_height; });
  const double share = static_cast<double>(through) / static_cast<double>(x.size());
  return trial.settle(run, share > 0.5, fmt::format("{:.0f} % is through", 100.0 * share));
}

// S7: twist

/// Signed solid angle of two segments over 4π, their contribution to the writhe; each pair counts
/// once for both orders (Klenin and Langowski, Computation of writhe in modeling of supercoiled
/// DNA, 2000, 1a).
double writhe_of(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) {
  const Vec3 r13 = b0 - a0, r14 = b1 - a0, r23 = b0 - a1, r24 = b1 - a1;
  Vec3 n[4] = {r13.cross(r14), r14.cross(r24), r24.cross(r23), r23.cross(r13)};
  double angle = 0.0;
  for (Vec3& normal : n) {
    if (normal.squaredNorm() == 0.0) return 0.0;  // coplanar
    normal.normalize();
  }
  for (int k = 0; k < 4; ++k) angle += std::asin(std::clamp(n[k].dot(n[(k + 1) % 4]), -1.0, 1.0));
  const double sign = (b1 - b0).cross(a1 - a0).dot(r13) >= 0.0 ? 1.0 : -1.0;
  return 2.0 * sign * angle / (4.0 * std::numbers::pi);
}

/// Linking number of the two sides of a strip: the turns of its rows relative to frames that do not
/// turn, plus the writhe of its axis (Călugăreanu, White, Fuller), with the axis extended straight
/// at both ends. The number is the same for every shape of the strip and changes only if the strip
/// passes through itself.
double linking_number(std::span<const Vec3> x, int cells_x, int cells_y) {
  const auto at = [&](int i, int j) { return x[static_cast<std::size_t>(j * (cells_x + 1) + i)]; };
  constexpr double far = 1e3;  // m
  std::vector<Vec3> axis, across;
  for (int i = 0; i <= cells_x; ++i) {
    axis.push_back(at(i, cells_y / 2));
    across.push_back(at(i, cells_y) - at(i, 0));
  }
  const auto extend = [&](auto where, const Vec3& direction, const Vec3& from, const Vec3& row,
                          auto where_row) {
    axis.insert(where, from + far * direction);
    across.insert(where_row, row);
  };
  const Vec3 first = axis.front(), last = axis.back(), row_0 = across.front(),
             row_1 = across.back();
  extend(axis.begin(), -Vec3::UnitX(), first, row_0, across.begin());
  extend(axis.end(), Vec3::UnitX(), last, row_1, across.end());
  double turns = 0.0;
  Vec3 tangent = Vec3::Zero(), before = Vec3::Zero();
  for (std::size_t i = 0; i + 1 < axis.size(); ++i) {
    const Vec3 t = (axis[i + 1] - axis[i]).normalized();
    const Vec3 sum = across[i].normalized() + across[i + 1].normalized();
    const Vec3 m = (sum - sum.dot(t) * t).normalized();
    if (i > 0) {
      // Rodrigues' formula. Eigen's FromTwoVectors would compile a singular value decomposition.
      const Vec3 axis_of_turn = tangent.cross(t), turned = axis_of_turn.cross(before);
      const Vec3 carried = before + turned + axis_of_turn.cross(turned) / (1.0 + tangent.dot(t));
      turns += std::atan2(t.dot(carried.cross(m)), carried.dot(m)) / (2.0 * std::numbers::pi);
    }
    tangent = t;
    before = m;
  }
  for (std::size_t i = 0; i + 1 < axis.size(); ++i)
    for (std::size_t j = i + 2; j + 1 < axis.size(); ++j)
      turns += writhe_of(axis[i], axis[i + 1], axis[j], axis[j + 1]);
  return turns;
}

CaseResult twist(Trial& trial) {
  const JudgedRun run = trial.run("s07_twist");
  if (run.x.empty()) return trial.settle(run, false, "");
  const auto& grid = std::get<ClothGrid>(run.scene.cloths[0].shape).grid;
  const double turns = linking_number(run.frames.back(), grid.cells_x, grid.cells_y);
  return trial.settle(
      run, std::abs(turns - 2.0) < 0.02,
      fmt::format("its sides wind around each other {:.4f} times, expected 2", turns));
}

// S8, S9: needle, cone, fin

CaseResult needle(Trial& trial, const std::string& name, const Vec3& tip) {
  const JudgedRun run = trial.run(name);
  if (run.x.empty()) return trial.settle(run, false, "");
  double least = std::numeric_limits<double>::infinity();
  for (const auto& x : run.frames)
    least = std::min(least, height_over(x, run.cloth.surface.triangles, tip.x(), tip.y()));
  return trial.settle(
      run, least >= tip.z(),
      fmt::format("the cloth stays {:.3g} mm above the tip", 1e3 * (least - tip.z())));
}

CaseResult fin(Trial& trial, const std::string& name) {
  const JudgedRun run = trial.run(name);
  if (run.x.empty()) return trial.settle(run, false, "");
  constexpr double top = 0.11;  // m
  double least = std::numeric_limits<double>::infinity();
  for (const auto& x : run.frames)
    least = std::min(least, height_over(x, run.cloth.surface.triangles, 0.0, 0.0));
  return trial.settle(run, least >= top,
                      fmt::format("the cloth stays {:.3g} mm above the fin", 1e3 * (least - top)));
}

// S10: fast body, and the same motion in the frame of the body

CaseResult fast_sphere(Trial& trial) {
  // An impact multiplies what the solver leaves open, so the frames are compared with a tolerance
  // far below the usual one.
  const Override fine{"solver.tolerance", "1e-7"};
  const JudgedRun run = trial.run("s10_fast_sphere");
  const JudgedRun at_rest = trial.run("s10_fast_sphere", {fine});
  const JudgedRun seen =
      trial.run("s10_fast_sphere",
                {fine, {"obstacles.0.motion", "[]"}, {"geometry.0.velocity", "[-10, 0, 0]"}});
  for (const JudgedRun* each : {&run, &at_rest, &seen})
    if (each->x.empty()) return trial.settle(*each, false, "");
  double worst = 0.0;
  for (std::size_t f = 0; f < std::min(at_rest.frames.size(), seen.frames.size()); ++f)
    for (std::size_t i = 0; i < at_rest.x.size(); ++i)
      worst = std::max(worst, (at_rest.frames[f][i] - seen.frames[f][i] -
                               Vec3(10.0 * at_rest.times[f], 0.0, 0.0))
                                  .norm());
  return trial.settle(run, worst < 1e-6,
                      fmt::format("the same within {:.1e} m, seen from the ball", worst));
}

// S11: crossing at the start

CaseResult starts_crossing(Trial& trial, const std::string& name) {
  const JudgedRun run = trial.run(name);
  if (!run.refused.empty() || run.x.empty()) return trial.settle(run, false, "");
  constexpr double fastest = 10.0;  // m/s; an untangling below this speed is not explosive
  if (run.worst_speed > fastest)
    return trial.answer(Answer::failed, fmt::format("untangles at {:.3g} m/s", run.worst_speed));
  return trial.answer(Answer::degraded,
                      fmt::format("starts with {} crossings, {} at the end", run.intersections,
                                  run.result.worst_self_intersections));
}

// S15: 1,000 g

CaseResult thousand_g(Trial& trial) {
  const JudgedRun run = trial.run("s15_thousand_g");
  if (run.x.empty()) return trial.settle(run, false, "");
  double over = std::numeric_limits<double>::infinity();
  for (const auto& x : run.frames)
    over = std::min(over, height_over(x, run.cloth.surface.triangles, 0.01, 0.005));
  return trial.settle(run, over > 0.099,
                      fmt::format("{:.3g} mm over the pole", 1e3 * (over - 0.1)));
}

// S18, S19: rest, friction

CaseResult resting(Trial& trial) {
  const JudgedRun run = trial.run("s18_resting");
  return trial.settle(
      run, run.rms_speed < 1e-4,
      fmt::format("rms speed {:.1e} m/s after 5 s, expected below 1e-4", run.rms_speed));
}

/// Distance slid along the slope of 30 degrees, m.
double slid(const JudgedRun& run) {
  const double angle = std::numbers::pi / 6.0;
  const Vec3 down(std::cos(angle), 0.0, -std::sin(angle));
  return run.x.empty() ? 0.0 : (mean(run.x) - mean(run.frames[0])).dot(down);
}

CaseResult frictionless(Trial& trial) {
  const JudgedRun run =
      trial.run("s19_incline", {{"obstacles.slope.friction", "0"}, {"time.frames", "48"}});
  const double n = run.result.steps, h = run.time / n;
  const double expected =
      9.81 * 0.5 * h * h * n * (n + 1.0) / 2.0;  // sum over the steps of Euler's method
  return trial.settle(run, std::abs(slid(run) / expected - 1.0) < 0.01,
                      fmt::format("slides {:.5f} m, expected {:.5f}", slid(run), expected));
}

CaseResult glued(Trial& trial) {
  const JudgedRun run = trial.run("s19_incline", {{"obstacles.slope.friction", "1e6"}});
  return trial.settle(run, std::abs(slid(run)) < 1e-6,
                      fmt::format("creeps {:.1e} m in 1 s, expected below 1e-6", slid(run)));
}

CaseResult sliding(Trial& trial) {
  const JudgedRun run = trial.run("s19_incline", {{"time.frames", "48"}});
  const double angle = std::numbers::pi / 6.0;
  const double a = 9.81 * (std::sin(angle) - 0.3 * std::cos(angle));
  const double n = run.result.steps, h = run.time / n, expected = a * h * h * n * (n + 1.0) / 2.0;
  return trial.settle(run, std::abs(slid(run) / expected - 1.0) < 0.01,
                      fmt::format("slides {:.5f} m, expected {:.5f}", slid(run), expected));
}

// S20: bodies with faults

CaseResult faulty_body(Trial& trial, const std::string& name, double top) {
  const JudgedRun run = trial.run(name);
  if (run.x.empty()) return trial.settle(run, false, "");
  if (run.warnings.empty()) return trial.answer(Answer::failed, "no warning");
  const double over = height_over(run.x, run.cloth.surface.triangles, -0.099, 0.0);
  const bool stays = over >= top && over < top + 0.05;
  return trial.settle(
      run, stays,
      fmt::format("{:.3g} mm over the rim; {}", 1e3 * (over - top), run.warnings.front()));
}

CaseResult cleaned_body(Trial& trial) {
  const JudgedRun run = trial.run("s03_degenerate_body");
  if (run.x.empty()) return trial.settle(run, false, "");
  const double over = height_over(run.x, run.cloth.surface.triangles, 0.0, 0.0) - 0.1;
  return trial.settle(run, std::abs(over - 0.002) < 0.001,
                      fmt::format("{:.3g} mm over the lid, expected 2", 1e3 * over));
}

// S25: bodies side by side

/// Without friction the sheet keeps its speed of 1 m/s.
CaseResult side_by_side(Trial& trial) {
  const JudgedRun run = trial.run("s25_seams");
  const double slid = run.x.empty() ? 0.0 : (mean(run.x) - mean(run.frames[0])).x();
  return trial.settle(run, std::abs(slid / run.time - 1.0) < 0.02,
                      fmt::format("slides {:.5f} m in {:.5f} s at 1 m/s", slid, run.time));
}

// S23: no solution keeps the limit

CaseResult pins_apart(Trial& trial) {
  const JudgedRun run = trial.run("s23_pins_apart");
  const bool says = run.result.strain_residual > 0.09 && run.result.strain_residual < 0.12;
  return trial.settle(run, says,
                      fmt::format("stretch {:.3f}, drawn to 0.2", run.result.max_stretch));
}

// Held cloth that a body strikes

/// Longer steps damp, so the flag swings on at most as fast as in short ones; one that is torn back
/// is faster.
CaseResult held_hit(Trial& trial) {
  const JudgedRun run = trial.run("held_hit");
  const JudgedRun fine = trial.run("held_hit", {{"time.steps_per_frame", "32"}});
  for (const JudgedRun* each : {&run, &fine})
    if (each->x.empty()) return trial.settle(*each, false, "");
  const double limit = run.scene.materials.at("default").strain_limit;
  const double share = run.result.max_stretch / limit;
  return trial.settle(run, share <= 1.5 && run.rms_speed < 1.1 * fine.rms_speed,
                      fmt::format("stretched to {:.3g} of its limit; {:.2g} m/s at the end, {:.2g} "
                                  "in short steps",
                                  share, run.rms_speed, fine.rms_speed));
}

// Towel, knot, pinch

CaseResult towel(Trial& trial) {
  const JudgedRun run = trial.run("towel");
  if (run.x.empty()) return trial.settle(run, false, "");
  // Centres of the four layers, from below: columns of the grid at 1/8, 3/8, 5/8, 7/8.
  const auto& grid = std::get<ClothGrid>(run.scene.cloths[0].shape).grid;
  double below = 0.0;
  bool ordered = true;
  for (int layer = 0; layer < 4; ++layer) {
    const int column = grid.cells_x * (2 * layer + 1) / 8;
    const int row = grid.cells_y / 2;
    const double z =
        run.frames.back()[static_cast<std::size_t>(row * (grid.cells_x + 1) + column)].z();
    ordered = ordered && z > below;
    below = z;
  }
  return trial.settle(run, ordered,
                      fmt::format("four layers in order, {:.3g} mm high, rms speed {:.2g} mm/s",
                                  1e3 * highest(run.x), 1e3 * run.rms_speed));
}

CaseResult knot(Trial& trial) {
  const JudgedRun run = trial.run("knot");
  if (run.x.empty()) return trial.settle(run, false, "");
  // If the knot came undone, the ends could move apart by the length of the band.
  const GridConfig& grid = std::get<ClothGrid>(run.scene.cloths[0].shape).grid;
  const double ends = (run.x[static_cast<std::size_t>(grid.cells_x)] - run.x[0]).norm();
  return trial.settle(
      run, ends < grid.size_x,
      fmt::format("ends {:.3f} m apart, {:.3f} m of band in the knot", ends, grid.size_x - ends));
}

CaseResult pinch(Trial& trial) {
  const JudgedRun run = trial.run("pinch");
  return trial.settle(run, false, "two bodies that overlap left the cloth somewhere");
}

CaseResult pinch_and_go(Trial& trial) {
  const JudgedRun run = trial.run("pinch_and_go");
  if (run.x.empty()) return trial.settle(run, false, "");
  const double z = height_over(run.x, run.cloth.surface.triangles, 0.0, 0.0);
  return trial.settle(run, std::abs(z) < 0.04,
                      fmt::format("free again, {:.3g} mm from the middle", 1e3 * z));
}

// The strip hangs from the jaws from 0.5 to 0.8 s, and falls once they have parted.
CaseResult grip(Trial& trial) {
  const JudgedRun run = trial.run("grip");
  if (run.frames.size() < 73) return trial.settle(run, false, "");
  constexpr std::size_t in_jaws = 18 * 9 + 4;  // row 18 of 9 vertices, the middle
  const double sunk = (run.frames[47][in_jaws] - run.frames[31][in_jaws]).norm();
  const double fallen = run.frames[31][in_jaws].z() - run.x[in_jaws].z();
  return trial.settle(run, sunk < 1e-9 && fallen > 0.1,
                      fmt::format("sank {:.3g} m in 0.27 s, then fell {:.3g} m", sunk, fallen));
}

}  // namespace

std::vector<ExtremeCase> contact_cases() {
  const Vec3 needle_tip(0.0013, 0.0021, 0.1501), cone_tip(0.0, 0.0, 0.11);
  const auto named = [](auto function, auto... arguments) {
    return [=](Trial& trial) { return function(trial, arguments...); };
  };
  const auto scene = [](const char* name) { return std::string(name); };
  using enum Answer;
  return {
      {"s02_button", correct, false, button},
      {"s02_heavy_on_light", correct, true, heavy_on_light},
      {"s03_degenerate_body", correct, true, cleaned_body},
      {"s04_bullet", correct, true, bullet},
      {"s04_plate", correct, true, plate},
      {"s05_stack", correct, false, stack},
      // One state is 0.05 % above the limit.
      {"s06_ring_3cm", correct, false, named(ring, scene("s06_ring_3cm"))},
      // A spring beside the handle leaps to 11.2 % for one step.
      {"s06_ring_5cm", degraded, false, named(ring, scene("s06_ring_5cm"))},
      {"s07_twist", correct, false, twist},
      {"s08_cone", correct, true, named(needle, scene("s08_cone"), cone_tip)},
      {"s08_needle", degraded, true, named(needle, scene("s08_needle"), needle_tip)},
      {"s09_fin", correct, false, named(fin, scene("s09_fin"))},
      {"s09_rotating_fin", correct, false, named(fin, scene("s09_rotating_fin"))},
      {"s10_fast_sphere", correct, true, fast_sphere},
      {"s11_half_in_sphere", refused, true, named(starts_crossing, scene("s11_half_in_sphere"))},
      {"s11_common_corner", refused, true, named(starts_crossing, scene("s11_common_corner"))},
      {"s11_self_crossed", refused, true, named(starts_crossing, scene("s11_self_crossed"))},
      {"s15_thousand_g", correct, false, thousand_g},
      {"s18_resting", correct, false, resting},
      {"s19_incline_0", correct, true, frictionless},
      {"s19_incline_0.3", correct, true, sliding},
      {"s19_incline_1e6", correct, true, glued},
      {"s20_non_manifold", correct, true, named(faulty_body, scene("s20_non_manifold"), 0.1)},
      {"s20_open", correct, true, named(faulty_body, scene("s20_open"), 0.1)},
      {"s20_reversed", correct, true, named(faulty_body, scene("s20_reversed"), 0.1)},
      {"s23_pins_apart", degraded, true, pins_apart},
      {"s25_seams", correct, true, side_by_side},
      {"towel", correct, false, towel},
      {"knot", correct, false, knot},
      {"held_hit", correct, true, held_hit},
      {"pinch", refused, true, pinch},
      {"pinch_and_go", correct, true, pinch_and_go},
      {"grip", correct, true, grip},
  };
}

}  // namespace selvedge::extreme_test
