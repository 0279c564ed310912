// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/compare/internal/stability.h>
#include <selvedge/core/solver/strain_limiter.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/scene/build.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace selvedge {
namespace {

/// Speed of the kick, m/s; small enough that springs stay linear.
constexpr double kKick = 1e-6;
/// Displacement of the finite differences, m; springs stay linear and rounding stays negligible.
constexpr double kProbe = 1e-7;
/// Power iteration: the largest eigenvalues of a grid are close together, and any of them is
/// accurate enough.
constexpr int kPowerIterations = 300;

Particles particles_of(const StabilitySubject& s) {
  Particles p;
  p.x = s.cloth.surface.vertices;
  p.v = s.kick;
  p.mass = s.cloth.mass;
  p.inv_mass = s.inv_mass;
  return p;
}

std::unique_ptr<Integrator> make(const std::string& name, const StabilitySubject& subject,
                                 const StabilityConfig& config) {
  constexpr ImplicitConfig kSolve{.tolerance = 1e-10};
  const std::size_t n = subject.cloth.surface.vertices.size();
  auto forces = make_internal_forces(subject.cloth);
  if (!config.limiter.empty()) {
    forces.push_back(make_gravity(subject.gravity));
    StrainLimit limit =
        strain_limiters().at(config.limiter)(subject.cloth.springs, subject.cloth.strain_limit, n);
    if (limit.force) forces.push_back(std::move(limit.force));
  }
  // The kick is far below the errors that a method with inner steps allows, so its tolerance is set
  // such that velocities are known to a thousandth of the kick's speed.
  const MethodOptions options =
      config.limiter.empty() ? MethodOptions{{"error", 1e-5 * kKick}} : MethodOptions{};
  const auto method = integrators().at(name);
  return method(known_options(method.options(), options), std::move(forces), n, kSolve);
}

/// Energy that the cloth gains by falling through the diagonal of its box, J.
double energy_of_fall(const StabilitySubject& s) {
  Eigen::AlignedBox3d box;
  for (const Vec3& x : s.cloth.surface.vertices) box.extend(x);
  double mass = 0.0;
  for (const double m : s.cloth.mass) mass += m;
  return mass * s.gravity.norm() * box.diagonal().norm();
}

/// Applies the strain limiter of a trial to a step; does nothing if the trial has none.
class LimiterOfTrial {
 public:
  LimiterOfTrial(const StabilitySubject& subject, const StabilityConfig& config)
      : subject_(subject), max_sweeps_(config.max_sweeps) {
    if (config.limiter.empty()) return;
    method_ = strain_limiters()
                  .at(config.limiter)(subject.cloth.springs, subject.cloth.strain_limit,
                                      subject.kick.size())
                  .method;
  }

  /// Limits the step that starts at x_t0 and ends in p.
  void apply(const std::vector<Vec3>& x_t0, double h, Particles& p) {
    if (!method_) return;
    ends_ = p.x;
    const LimitStep step{
        .x_t0 = x_t0, .inv_mass = subject_.inv_mass, .h = h, .max_sweeps = max_sweeps_};
    method_->limit_ends(step, p.x);
    if (!method_->traits().keeps_velocity)
      for (std::size_t i = 0; i < p.size(); ++i) p.v[i] += (p.x[i] - ends_[i]) / h;
    method_->limit_velocities(step, p.x, p.v);
  }

 private:
  const StabilitySubject& subject_;
  int max_sweeps_;
  std::unique_ptr<StrainLimitMethod> method_;
  std::vector<Vec3> ends_;
};

double kinetic(const Particles& p) {
  double sum = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (p.inv_mass[i] > 0.0) sum += 0.5 * p.mass[i] * p.v[i].squaredNorm();
  return sum;
}

void advance(Integrator& method, LimiterOfTrial& limiter, Particles& p, double time, double h,
             std::vector<Vec3>& mean, std::vector<Vec3>& v, std::vector<Vec3>& x_t0) {
  mean = p.v;
  v = p.v;
  const StepEnd end{mean, v};
  method.begin({p, time, h}, end);
  if (method.traits().is_implicit) method.solve({}, end, 1.0);
  x_t0 = p.x;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (p.inv_mass[i] > 0.0) p.x[i] += h * mean[i];
  p.v = method.traits().ends_with_mean ? mean : v;
  limiter.apply(x_t0, h, p);
  method.accept({p.x, p.v, p.mass, time + h});
}

bool all_finite(const std::vector<Vec3>& x) {
  return std::all_of(x.begin(), x.end(), [](const Vec3& p) { return p.allFinite(); });
}

double norm(const std::vector<Vec3>& x, std::span<const double> mass) {
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += mass[i] * x[i].squaredNorm();
  return std::sqrt(sum);
}

}  // namespace

StabilitySubject::StabilitySubject(const Scene& scene, double stiffness, double mass_ratio,
                                   double damping) {
  BuiltScene built = build_scene(scene);
  cloth = std::move(built.cloth);
  double stiffest = 0.0;
  for (const Spring& spring : cloth.springs) stiffest = std::max(stiffest, spring.stiffness);
  for (Spring& spring : cloth.springs) {
    if (stiffness > 0.0) spring.stiffness *= stiffness / stiffest;
    if (damping >= 0.0) spring.damping = damping;
  }
  for (MembraneTriangle& t : cloth.membranes) {
    for (double* constant : {&t.c11, &t.c22, &t.c12, &t.c33})
      if (stiffness > 0.0) *constant *= stiffness / stiffest;
    if (damping >= 0.0) t.damping = damping;
  }
  for (YarnTriangle& t : cloth.yarns) {
    for (double* constant : {&t.warp, &t.weft, &t.shear})
      if (stiffness > 0.0) *constant *= stiffness / stiffest;
    if (damping >= 0.0) t.damping = damping;
  }
  gravity = scene.gravity;
  for (const double mass : cloth.mass) inv_mass.push_back(1.0 / mass);
  for (const HandleSpec& handle : scene.handles)
    for (std::size_t p = 0; p < scene.cloths.size(); ++p)
      if (scene.cloths[p].name == handle.geometry)
        for (const std::int32_t v : handle.vertices) inv_mass[built.piece_begin[p] + v] = 0.0;
  std::mt19937 random(1);  // every trial uses the same kick
  std::normal_distribution<double> noise(0.0, kKick);
  bool changed = mass_ratio == 1.0;
  for (std::size_t i = 0; i < inv_mass.size(); ++i) {
    const Vec3 kicked(noise(random), noise(random), noise(random));
    kick.push_back(inv_mass[i] > 0.0 ? kicked : Vec3(Vec3::Zero()));
    if (changed || inv_mass[i] == 0.0) continue;
    cloth.mass[i] *= mass_ratio;
    inv_mass[i] /= mass_ratio;
    changed = true;
  }
}

StabilityTrial try_step_length(const std::string& integrator, const StabilitySubject& subject,
                               double h, const StabilityConfig& config) {
  const auto method = make(integrator, subject, config);
  const ForceSum internal(make_internal_forces(subject.cloth), subject.kick.size());
  LimiterOfTrial limiter(subject, config);
  Particles p = particles_of(subject);
  std::vector<Vec3> mean, v, x_t0;
  const double start = config.limiter.empty() ? kinetic(p) : energy_of_fall(subject);
  const int steps = static_cast<int>(std::min<double>(config.steps, std::ceil(config.seconds / h)));
  constexpr int look_every = 8;
  double energy = start;
  for (int step = 0; step < steps; ++step) {
    try {
      advance(*method, limiter, p, step * h, h, mean, v, x_t0);
    } catch (const std::exception&) {  // an inner step would have to become zero
      return {false, energy / start, true};
    }
    if (!all_finite(p.x)) return {false, energy / start, true};
    if (step % look_every != 0 && step + 1 < steps) continue;
    energy = kinetic(p) + internal.energy({p.x, p.v, p.mass, 0.0});
    if (!(energy <= config.growth * start)) return {false, energy / start};
  }
  return {true, energy / start};
}

ModeBound fastest_mode(const StabilitySubject& subject) {
  ForceSum forces(make_internal_forces(subject.cloth), subject.cloth.surface.vertices.size());
  const std::vector<Vec3>& rest = subject.cloth.surface.vertices;
  const std::vector<double>& mass = subject.cloth.mass;
  const std::vector<Vec3> still(rest.size(), Vec3::Zero());
  // -M⁻¹ ∂F/∂x u or -M⁻¹ ∂F/∂v u by differences, which are exact for linear forces.
  const auto apply = [&](const std::vector<Vec3>& u, bool damping) {
    std::vector<Vec3> there = damping ? still : rest, back = there, a(rest.size()), b(rest.size());
    for (std::size_t i = 0; i < u.size(); ++i) {
      there[i] += kProbe * u[i];
      back[i] -= kProbe * u[i];
    }
    const auto state = [&](const std::vector<Vec3>& moved) {
      return damping ? ForceState{rest, moved, mass, 0.0} : ForceState{moved, still, mass, 0.0};
    };
    forces.accelerate(state(there), subject.inv_mass, a);
    forces.accelerate(state(back), subject.inv_mass, b);
    for (std::size_t i = 0; i < a.size(); ++i) a[i] = (b[i] - a[i]) / (2.0 * kProbe);
    return a;
  };
  const auto largest = [&](bool damping) {
    std::vector<Vec3> u = subject.kick;
    double value = 0.0;
    for (int k = 0; k < kPowerIterations; ++k) {
      const double size = norm(u, mass);
      if (!(size > 0.0)) return 0.0;
      for (Vec3& x : u) x /= size;
      u = apply(u, damping);
      value = norm(u, mass);
    }
    return value;
  };
  return {std::sqrt(largest(false)), largest(true)};
}

StabilityRow largest_stable_step(const std::string& integrator, const StabilitySubject& subject,
                                 const StabilityConfig& config) {
  StabilityRow row;
  row.integrator = integrator;
  const auto method = make(integrator, subject, config);
  row.any_step = method->traits().any_step;
  row.bound = method->stable_step(particles_of(subject), 0.0, config.longest);
  const ModeBound mode = fastest_mode(subject);
  row.predicted = row.any_step ? config.longest : method->stable_step(mode, config.longest);
  const auto is_stable = [&](double h) {
    const StabilityTrial trial = try_step_length(integrator, subject, h, config);
    if (trial.stable)
      row.energy_ratio = trial.energy_ratio;
    else  // a method that is stable at any step
      row.rejects_longer = row.any_step && trial.rejected;
    return trial.stable;
  };
  double low = row.predicted > 0.0 ? row.predicted : 0.1 / mode.omega;
  while (!is_stable(low)) {
    low *= 0.5;
    if (low < 1e-6 / mode.omega) return row;  // stable at no step length
  }
  double high = low;
  while (high < config.longest) {
    high = std::min(2.0 * high, config.longest);
    if (!is_stable(high)) break;
    low = high;
  }
  while (low < high && high / low > 1.0 + config.precision) {
    const double middle = std::sqrt(low * high);
    (is_stable(middle) ? low : high) = middle;
  }
  row.measured = low;
  return row;
}

StabilityMap map_stability(const std::string& integrator, const Scene& scene,
                           const std::vector<double>& stiffness, const std::vector<double>& step,
                           const StabilityConfig& config) {
  StabilityMap map{integrator, stiffness, step, {}, {}};
  for (const double k : stiffness) {
    const StabilitySubject subject(scene, k, 1.0, -1.0);
    const auto method = make(integrator, subject, config);
    const double bound = method->stable_step(particles_of(subject), 0.0, config.longest);
    map.bound.push_back(bound);
    for (const double h : step) {
      const StabilityTrial trial = try_step_length(integrator, subject, h, config);
      const bool divided = method->traits().any_step && trial.rejected;
      map.verdict.push_back(trial.stable && h <= bound ? StabilityVerdict::stable
                            : trial.stable || divided  ? StabilityVerdict::refused
                                                       : StabilityVerdict::unstable);
    }
  }
  return map;
}

// -- drawing --------------------------------------------------------------------------------------

namespace {

constexpr int kSquare = 26, kLeft = 74, kTop = 34, kBelow = 52, kGap = 18, kColumns = 3;

const char* colour(StabilityVerdict verdict) {
  switch (verdict) {
    case StabilityVerdict::stable:
      return "#3a9d5d";
    case StabilityVerdict::unstable:
      return "#c8443c";
    case StabilityVerdict::refused:
      return "#e0b545";
  }
  return "";
}

std::string text_at(double x, double y, const char* anchor, const std::string& words) {
  return fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor,
                     words);
}

std::string draw_map(const StabilityMap& map) {
  const std::size_t rows = map.step.size();
  std::string svg = text_at(kLeft, kTop - 12, "start", map.integrator);
  for (std::size_t i = 0; i < map.stiffness.size(); ++i) {
    const double x = kLeft + static_cast<double>(kSquare * i);
    for (std::size_t j = 0; j < rows; ++j)
      svg +=
          fmt::format("<rect x=\"{:.0f}\" y=\"{:.0f}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>\n",
                      x, kTop + static_cast<double>(kSquare * (rows - 1 - j)), kSquare - 1,
                      kSquare - 1, colour(map.verdict[i * rows + j]));
    if (i % 2 == 0)
      svg += text_at(x + 0.5 * kSquare, kTop + static_cast<double>(kSquare * rows) + 14, "middle",
                     fmt::format("{:.0e}", map.stiffness[i]));
  }
  for (std::size_t j = 0; j < rows; ++j)
    svg += text_at(kLeft - 6, kTop + static_cast<double>(kSquare * (rows - 1 - j)) + 17, "end",
                   fmt::format("{:.1e} s", map.step[j]));
  return svg +
         text_at(kLeft, kTop + static_cast<double>(kSquare * rows) + 30, "start", "stiffness, N/m");
}

}  // namespace

std::string draw_maps(const std::vector<StabilityMap>& maps) {
  std::size_t columns = 1, rows = 1;
  for (const StabilityMap& map : maps) {
    columns = std::max(columns, map.stiffness.size());
    rows = std::max(rows, map.step.size());
  }
  const auto wide = kLeft + kGap + kSquare * static_cast<int>(columns);
  const auto high = kTop + kBelow + kSquare * static_cast<int>(rows);
  const int across = std::min<int>(kColumns, static_cast<int>(maps.size()));
  const int down = (static_cast<int>(maps.size()) + kColumns - 1) / kColumns;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
      "height=\"{1}\" font-family=\"sans-serif\" font-size=\"11\">\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      across * wide + kGap, down * high + kTop);
  for (std::size_t k = 0; k < maps.size(); ++k)
    svg += fmt::format("<g transform=\"translate({},{})\">\n{}</g>\n",
                       static_cast<int>(k) % kColumns * wide, static_cast<int>(k) / kColumns * high,
                       draw_map(maps[k]));
  const int y = down * high + kTop - 10;
  const std::pair<StabilityVerdict, const char*> words[] = {
      {StabilityVerdict::stable, "stable"},
      {StabilityVerdict::refused, "stable here, but beyond the bound that is kept"},
      {StabilityVerdict::unstable, "unstable"}};
  int x = kLeft;
  for (const auto& [verdict, word] : words) {
    svg += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"11\" height=\"11\" fill=\"{}\"/>\n", x,
                       y - 10, colour(verdict));
    svg += text_at(x + 16, y, "start", word);
    x += 90;
    if (verdict == StabilityVerdict::refused) x += 210;
  }
  return svg + "</svg>\n";
}

}  // namespace selvedge
