// SPDX-License-Identifier: MIT
#include "limiter_replay.h"

#include <selvedge/scene/build.h>
#include <selvedge/scene/methods.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "table.h"

namespace selvedge::bench {
namespace {

constexpr int kManySweeps = 1000000;
constexpr double kLimit = 0.1;  // strain

/// The end of a step before a limiter changes it.
struct Ends {
  std::vector<Vec3> x_t0, x_t1;
  double h = 0.0, tolerance = 0.0;
};

/// What the limiter of a run met.
struct Recording {
  std::vector<Spring> springs;
  std::vector<double> limits, inv_mass;
  std::vector<Ends> ends;
  double limiter_share = 0.0;  ///< of the processor time of all phases
};

/// Position correction that keeps ends that it has to change: every one at first, and every second,
/// fourth, ... as they become more than twice as many as wanted, so that they cover the run evenly.
class Recorder final : public StrainLimitMethod {
 public:
  Recorder(std::unique_ptr<StrainLimitMethod> method, std::size_t wanted, Recording& into)
      : method_(std::move(method)), wanted_(wanted), into_(into) {}
  LimiterTraits traits() const override { return method_->traits(); }
  const StrainLimiter* limiter() const override { return method_->limiter(); }
  StrainReport limit_ends(const LimitStep& step, std::span<Vec3> x_t1) override {
    if (method_->limiter()->measure(x_t1).residual > step.tolerance && met_++ % stride_ == 0) {
      into_.inv_mass.assign(step.inv_mass.begin(), step.inv_mass.end());
      into_.ends.push_back({{step.x_t0.begin(), step.x_t0.end()},
                            {x_t1.begin(), x_t1.end()},
                            step.h,
                            step.tolerance});
      if (into_.ends.size() > 2 * wanted_) thin_out();
    }
    return method_->limit_ends(step, x_t1);
  }

 private:
  void thin_out() {
    std::vector<Ends>& ends = into_.ends;
    for (std::size_t k = 1; 2 * k < ends.size(); ++k) ends[k] = std::move(ends[2 * k]);
    ends.resize((ends.size() + 1) / 2);
    stride_ *= 2;
  }

  std::unique_ptr<StrainLimitMethod> method_;
  std::size_t wanted_, met_ = 0, stride_ = 1;
  Recording& into_;
};

Scene table_scene(const ReplayOptions& options, int seed) {
  const double k = options.stiffness;
  Scene scene;
  scene.name = "table";
  Material net;
  net.density = 0.2;
  net.spring_damping = 0.001;
  net.strain_limit = kLimit;
  scene.materials["default"] = net;
  ClothSpec cloth;
  cloth.name = "cloth";
  ClothGrid grid{"rectangular_net", {1.0, 1.0, options.cells, options.cells}};
  grid.pattern_options = {{"structural", k}, {"shear", k}, {"flexion", k}};
  cloth.shape = grid;
  cloth.placement.translation = {0.0, 0.0, 0.503};
  scene.cloths.push_back(cloth);
  BodySpec table;
  table.name = "table";
  table.shape = BodyShape{Cylinder{0.3, 0.02}, 96};
  table.placement.translation = {0.0, 0.0, 0.49};
  table.friction = 0.5;
  scene.bodies.push_back(table);
  scene.air.viscous_drag = 1.6;
  scene.solver.integrator = "implicit_euler";
  scene.solver.limiter = "recorder";
  scene.time.steps_per_frame = 1;
  scene.perturbation = {.speed = 1e-3, .seed = static_cast<std::uint64_t>(seed)};
  return scene;
}

Recording record(const ReplayOptions& options, int seed) {
  Recording recording;
  Methods methods;
  methods.strain_limiters.add(
      "recorder", {},
      [&](const MethodOptions&, std::span<const Spring> springs, std::span<const double> limits,
          std::size_t particles) {
        recording.springs.assign(springs.begin(), springs.end());
        recording.limits.assign(limits.begin(), limits.end());
        StrainLimit limit;
        limit.method =
            std::make_unique<Recorder>(make_position_limiter(springs, limits, particles, true),
                                       static_cast<std::size_t>(options.most), recording);
        limit.max_sweeps = kManySweeps;
        return limit;
      },
      make_position_limiter({}, {}, 0, true)->traits());
  const Scene scene = table_scene(options, seed);
  Simulation simulation(scene, methods);
  simulation.advance_to_frame(static_cast<int>(options.seconds * scene.time.fps));
  double all = 0.0;
  const auto phases = simulation.result().phase_s;
  for (const auto& [phase, seconds] : phases)
    if (phase.find('/') == std::string::npos) all += seconds;
  recording.limiter_share = phases.at("strain") / all;
  // As many as asked for, spread over the drape.
  std::vector<Ends>& ends = recording.ends;
  const std::size_t most = std::min(ends.size(), static_cast<std::size_t>(options.most));
  std::vector<Ends> taken;
  for (std::size_t k = 0; k < most; ++k) taken.push_back(std::move(ends[k * ends.size() / most]));
  ends = std::move(taken);
  return recording;
}

/// One limiter on one end.
struct Outcome {
  double seconds = 0.0;   ///< of the processor
  double residual = 0.0;  ///< strain over the limit that remains
  int sweeps = 0;
};

Outcome limit(StrainLimitMethod& method, const Recording& recording, const Ends& ends,
              double tolerance, int max_sweeps) {
  const LimitStep step{ends.x_t0, recording.inv_mass, ends.h, tolerance, max_sweeps};
  std::vector<Vec3> x = ends.x_t1, v(x.size());
  const std::clock_t start = std::clock();
  const StrainReport report = method.limit_ends(step, x);
  for (std::size_t i = 0; i < x.size(); ++i) v[i] = (x[i] - ends.x_t0[i]) / ends.h;
  method.limit_velocities(step, x, v);
  return {static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, report.residual,
          report.sweeps};
}

/// Sums over the ends of one drape.
struct Sum {
  double seconds = 0.0, sweeps = 0.0, residual = 0.0;  // residual: the largest

  void add(const Outcome& o) {
    seconds += o.seconds;
    sweeps += o.sweeps;
    residual = std::max(residual, o.residual);
  }
};

const std::vector<std::string> kLimiters{"position",
                                         "ordered_position",
                                         "velocity",
                                         "position_velocity",
                                         "ordered_position_velocity",
                                         "position_as_printed",
                                         "priority_position_velocity"};

using Sums = std::map<std::string, Sum>;

std::unique_ptr<StrainLimitMethod> make(const std::string& name, const Recording& recording) {
  return strain_limiters()
      .at(name)(recording.springs, recording.limits, recording.inv_mass.size())
      .method;
}

/// Every limiter on every end until its limits hold. The first pass is not counted.
Sums until_the_limits_hold(const Recording& recording) {
  std::map<std::string, std::unique_ptr<StrainLimitMethod>> methods;
  for (const std::string& name : kLimiters) methods[name] = make(name, recording);
  Sums sums;
  for (const Ends& ends : recording.ends)
    for (const bool counts : {false, true})
      for (auto& [name, method] : methods) {
        const Outcome o = limit(*method, recording, ends, ends.tolerance, kManySweeps);
        if (counts) sums[name].add(o);
      }
  return sums;
}

/// A single sweep of each order, and the other order until it reaches the residual of that sweep.
Sums single_sweeps(const Recording& recording) {
  const auto plain = make("position", recording), ordered = make("ordered_position", recording);
  Sums sums;
  for (const Ends& ends : recording.ends)
    for (const bool counts : {false, true}) {
      const Outcome one = limit(*plain, recording, ends, ends.tolerance, 1);
      const Outcome other = limit(*ordered, recording, ends, one.residual, kManySweeps);
      const Outcome one_ordered = limit(*ordered, recording, ends, ends.tolerance, 1);
      const Outcome as_ordered = limit(*plain, recording, ends, one_ordered.residual, kManySweeps);
      if (!counts) continue;
      sums["1 one sweep of position"].add(one);
      sums["2 ordered_position to its residual"].add(other);
      sums["3 one sweep of ordered_position"].add(one_ordered);
      sums["4 position to its residual"].add(as_ordered);
    }
  return sums;
}

std::string median_and_range(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return fmt::format("{:.3f} ({:.3f} to {:.3f})", values[values.size() / 2], values.front(),
                     values.back());
}

/// A row for each name; times over those of the row `base(name)` of the same drape.
template <class Base>
std::string rows(const std::vector<std::vector<Sums>>& of_drapes, std::size_t which,
                 const std::vector<std::size_t>& ends, Base base) {
  Table table({"limiter", "time over the first", "sweeps a step", "ms a step", "residual %"});
  for (const auto& [name, first] : of_drapes[0][which]) {
    std::vector<double> ratios;
    for (const auto& drape : of_drapes)
      ratios.push_back(drape[which].at(name).seconds / drape[which].at(base(name)).seconds);
    const auto steps = static_cast<double>(ends[0]);
    table.add({name, median_and_range(ratios), fmt::format("{:.1f}", first.sweeps / steps),
               fmt::format("{:.3f}", 1e3 * first.seconds / steps),
               fmt::format("{:.3f}", 100.0 * first.residual)});
  }
  return table.text();
}

}  // namespace

std::string replay_limiters(const ReplayOptions& options) {
  std::vector<std::vector<Sums>> of_drapes;
  std::vector<std::size_t> ends;
  std::vector<double> shares;
  for (int seed = 1; seed <= options.seeds; ++seed) {
    const Recording recording = record(options, seed);
    if (recording.ends.empty()) return "No step of the drape stretches a spring over its limit.\n";
    of_drapes.push_back({until_the_limits_hold(recording), single_sweeps(recording)});
    ends.push_back(recording.ends.size());
    shares.push_back(recording.limiter_share);
  }
  std::string text = fmt::format(
      "{} x {} particles, springs of {:g} N/m, {} drapes over a table for {:g} s; {} steps of the "
      "first. The limiter took a share of {} of a run.\nUntil the limits hold; times over "
      "position\n",
      options.cells + 1, options.cells + 1, options.stiffness, options.seeds, options.seconds,
      ends[0], median_and_range(shares));
  text += rows(of_drapes, 0, ends, [](const std::string&) { return std::string("position"); });
  text += "\nSingle sweeps; times over the one sweep whose residual is reached\n";
  text += rows(of_drapes, 1, ends, [](const std::string& name) {
    return std::string(name[0] <= '2' ? "1 one sweep of position"
                                      : "3 one sweep of ordered_position");
  });
  return text;
}

}  // namespace selvedge::bench
