// SPDX-License-Identifier: MIT
//
// Settling: the sewn garment under gravity and friction, until it is at rest. Pairs that are near
// but could not merge, because something was in the way, are pulled on and merge as soon as they
// can. A garment that is its own mirror image is first kept straight, as hands do it.
#include <fmt/format.h>
#include <selvedge/dress/detail/pulls.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/step_report.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <set>

namespace selvedge::detail {
namespace {

constexpr double kMergeShare = 1.2;    // of the spacing of a seam, where its pairs merge
constexpr double kStraightTime = 2.0;  // s, for which a garment is kept straight, at most

/// The states of a time window, and the motion in it.
class MotionWindow {
 public:
  MotionWindow(double window, double fps)
      : frames_(static_cast<std::size_t>(std::max(1L, std::lround(window * fps)))), fps_(fps) {}

  void add(std::span<const Vec3> x, std::span<const Vec3> v, std::span<const double> mass) {
    State state{{x.begin(), x.end()}, 0.0};
    for (std::size_t i = 0; i < v.size(); ++i) state.energy += 0.5 * mass[i] * v[i].squaredNorm();
    states_.push_back(std::move(state));
    if (states_.size() > frames_ + 1) states_.pop_front();
  }

  void clear() { states_.clear(); }
  bool is_full() const { return states_.size() == frames_ + 1; }

  /// Speeds of the straight way from the first state to the last one, and the mean energy.
  void measure(std::span<const double> mass, double edge_length, DressResult& result) const {
    const std::vector<Vec3>&from = states_.front().x, &to = states_.back().x;
    const double seconds = static_cast<double>(std::max<std::size_t>(1, states_.size() - 1)) / fps_;
    double total = 0.0, sum = 0.0, largest = 0.0, energy = 0.0;
    for (std::size_t i = 0; i < mass.size(); ++i) {
      const double squared = (to[i] - from[i]).squaredNorm();
      total += mass[i];
      sum += mass[i] * squared;
      largest = std::max(largest, squared);
    }
    for (const State& state : states_) energy += state.energy;
    result.rms_speed = std::sqrt(sum / total) / seconds;
    result.max_speed = std::sqrt(largest) / seconds;
    result.energy_share =
        energy / (static_cast<double>(states_.size()) * total * kGravity * edge_length);
  }

 private:
  struct State {
    std::vector<Vec3> x;
    double energy;  // J
  };
  std::size_t frames_;
  double fps_;
  std::deque<State> states_;
};

/// Normal pressure of the body on each vertex in the last step, Pa.
std::vector<double> body_pressure(const Simulation& simulation) {
  const auto x = simulation.positions();
  std::vector<double> pressure(x.size(), 0.0);
  if (simulation.last_step().lengths.empty()) return pressure;
  const auto is_cloth = [&](std::int32_t v) { return static_cast<std::size_t>(v) < x.size(); };
  for (const StepContact& c : simulation.contacts()) {
    if (std::all_of(c.point.vertex.begin(), c.point.vertex.end(), is_cloth)) continue;
    const double impulse = std::abs(c.impulse.dot(c.point.normal));
    for (std::size_t k = 0; k < c.point.vertex.size(); ++k)
      if (is_cloth(c.point.vertex[k]))
        pressure[c.point.vertex[k]] += std::abs(c.point.weight[k]) * impulse;
  }
  const std::vector<double> areas = vertex_areas(x, simulation.cloth_triangles());
  for (std::size_t v = 0; v < pressure.size(); ++v)
    pressure[v] =
        areas[v] > 0.0 ? pressure[v] / (areas[v] * simulation.last_step().lengths.back()) : 0.0;
  return pressure;
}

constexpr int kMoveAfter = 20;  // frames without a merge, after which blocked pairs are moved

class Settling {
 public:
  Settling(Garment& garment, const Dressing& dressing, DressPhase phase, DressResult& result)
      : garment_(garment),
        dressing_(dressing),
        config_(dressing.config),
        phase_(phase),
        result_(result),
        window_(config_.rest.window, config_.fps),
        is_holding_(phase == DressPhase::settle && config_.hold_time > 0.0 &&
                    !garment.held.empty()),
        straightening_(garment, dressing),
        is_straightening_(phase == DressPhase::settle) {
    open();
  }

  void run() {
    result_.at_rest = false;
    const double start = garment_height(*simulation_);
    for (int frame = 1; !result_.at_rest && frame <= config_.settle_time * config_.fps; ++frame)
      make_frame(frame);
    finish(start);
  }

 private:
  void open() {
    simulation_.reset();  // it refers to the former scene
    const PhaseSettings settings{.gravity = Vec3(0.0, 0.0, -kGravity),
                                 .drag = config_.settle_drag,
                                 .friction = config_.body_friction,
                                 .pull = config_.largest_pull,
                                 .merge = kMergeShare};
    scene_ =
        std::make_unique<DressScene>(make_dress_scene(garment_, dressing_.body, config_, settings));
    pulls_.clear();
    if (is_straightening_) straightening_.add_pulls(garment_, pulls_);
    is_straightening_ = !pulls_.empty();
    methods_ = is_straightening_ ? with_pulls(dressing_.methods, pulls_) : dressing_.methods;
    try {
      simulation_ = start_simulation(
          *scene_, {dressing_.body, config_, methods_, dressing_.observer, dressing_.deadline});
    } catch (const std::invalid_argument& error) {
      throw DressFailed(fmt::format("phase {}: {}", phase_name(phase_), error.what()));
    }
    if (is_straightening_) straightening_.aim(simulation_->positions(), pulls_);
    frame_of_simulation_ = 0;
    if (is_holding_) hold();
    if (dressing_.observer.accepted) dressing_.observer.accepted(*simulation_, phase_);
  }

  /// Holds the vertices of labelled edges where they are.
  void hold() {
    std::set<std::int32_t> vertices;
    for (const std::int32_t v : garment_.held) vertices.insert(garment_.corner[v]);
    const std::vector<std::int32_t> list(vertices.begin(), vertices.end());
    std::vector<Vec3> x;
    for (const std::int32_t v : list) x.push_back(garment_.surface.vertices[v]);
    simulation_->hold(list, x);
    result_.held = list.size();
  }

  /// Lets go of them once the rest of the garment has settled.
  void release_when_settled() {
    result_.held_time += 1.0 / config_.fps;
    const double left = config_.hold_time - result_.held_time;  // s, with rounding
    if (!result_.at_rest && left > 0.5 / config_.fps) return;
    is_holding_ = false;
    simulation_->release_all();
    window_.clear();
    result_.at_rest = false;
  }

  /// Lets a garment hang as it wants that was kept straight until it rested.
  void stop_straightening() {
    straight_s_ += 1.0 / config_.fps;
    straightening_.aim(simulation_->positions(), pulls_);
    if (!result_.at_rest && straight_s_ < kStraightTime) return;
    is_straightening_ = false;
    take_state(*simulation_, garment_);
    reopen();
    result_.at_rest = false;
  }

  /// Pairs that were left open. Those that are blocked are moved together first.
  void merge() {
    if (garment_.open_pairs() == 0) return;
    if (frame_of_simulation_ > kMoveAfter &&
        move_together(*simulation_, garment_, dressing_, kMergeShare) > 0)
      reopen();
    if (merge_closed(*scene_, *simulation_, dressing_.methods, garment_, result_) > 0) reopen();
  }

  /// Goes on with the garment as it is now.
  void reopen() {
    add_run(*simulation_, phase_name(phase_), result_);
    open();
    window_.clear();
  }

  void make_frame(int frame) {
    if (frame % kMergeEvery == 0) merge();
    ++frame_of_simulation_;
    try {
      simulation_->advance_to_frame(frame_of_simulation_, [&](double) {
        if (dressing_.observer.accepted) dressing_.observer.accepted(*simulation_, phase_);
      });
    } catch (const SimulationFailed& failure) {
      throw DressFailed(fmt::format("while the garment settles: {}", failure.what()));
    }
    result_.settle_time += 1.0 / config_.fps;
    window_.add(simulation_->positions(), simulation_->velocities(), simulation_->mass());
    window_.measure(simulation_->mass(), config_.edge_length, result_);
    const RestCriterion& rest = config_.rest;
    result_.at_rest = window_.is_full() && result_.rms_speed <= rest.rms_speed &&
                      result_.max_speed <= rest.max_speed &&
                      result_.energy_share <= rest.energy_share;
    if (is_holding_) release_when_settled();
    if (is_straightening_) stop_straightening();
    if (dressing_.observer.frame)
      dressing_.observer.frame(*simulation_, phase_, result_.sew_time + result_.settle_time);
  }

  void finish(double start_height) {
    take_state(*simulation_, garment_);
    add_run(*simulation_, phase_name(phase_), result_);
    result_.state_hash = simulation_->result().state_hash;
    const std::size_t own = garment_.surface.vertices.size();
    result_.flags = simulation_->flags();
    result_.flags.resize(own);
    result_.pressure = body_pressure(*simulation_);
    result_.pressure.resize(own);
    result_.drop += start_height - garment_height(*simulation_);
    result_.max_stretch = max_stretch(*simulation_, 0);
    for (std::size_t k = 0; k < result_.under.size(); ++k)
      result_.under[k].max_stretch = max_stretch(*simulation_, k + 1);
  }

  Garment& garment_;
  const Dressing& dressing_;
  const DressConfig& config_;
  DressPhase phase_;
  DressResult& result_;
  MotionWindow window_;
  bool is_holding_;  // the edges with a label
  Straightening straightening_;
  std::vector<Pull> pulls_;
  Methods methods_;
  bool is_straightening_;
  double straight_s_ = 0.0;  // s, since it began
  std::unique_ptr<DressScene> scene_;
  std::unique_ptr<Simulation> simulation_;
  int frame_of_simulation_ = 0;
};

}  // namespace

void settle(Garment& garment, const Dressing& dressing, DressPhase phase, DressResult& result) {
  Settling(garment, dressing, phase, result).run();
}

}  // namespace selvedge::detail
