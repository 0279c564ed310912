// SPDX-License-Identifier: MIT
//
// The dressed garment on a body that moves from the dressing pose through other poses. Between two
// poses every vertex of the body goes straight; its paths are searched for collisions as all
// others.
#include <fmt/format.h>
#include <selvedge/bodies/driven_body.h>
#include <selvedge/dress/detail/dressing.h>
#include <selvedge/simulation/run_result.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace selvedge::detail {
namespace {

/// The frames of the body, and the number of the one that is the first pose.
struct BodyFrames {
  std::vector<TriangleMesh> list;
  std::size_t first_pose = 0;
};

/// From the dressing pose straight to the first pose, and through the others.
BodyFrames frames_of(const TriangleMesh& body, const BodyMotion& motion) {
  BodyFrames frames;
  const TriangleMesh& first = motion.poses.front();
  if (first.vertices != body.vertices)
    frames.first_pose =
        static_cast<std::size_t>(std::max(1L, std::lround(motion.lead * motion.rate)));
  for (std::size_t k = 0; k < frames.first_pose; ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(frames.first_pose);
    TriangleMesh frame = body;
    for (std::size_t v = 0; v < frame.vertices.size(); ++v)
      frame.vertices[v] += share * (first.vertices[v] - body.vertices[v]);
    frames.list.push_back(std::move(frame));
  }
  frames.list.insert(frames.list.end(), motion.poses.begin(), motion.poses.end());
  return frames;
}

class Posing {
 public:
  Posing(Garment& garment, const Dressing& dressing, const TriangleMesh& body, DressResult& result)
      : garment_(garment), dressing_(dressing), config_(dressing.config), result_(result) {
    BodyFrames frames = frames_of(body, config_.motion);
    first_pose_ = frames.first_pose;
    make_room(frames.list, config_.body_room);
    frames.list.front() = dressing.body;  // on which the garment lies
    frames_ = std::move(frames.list);
    open();
  }

  void run() {
    start_height_ = height();
    show();
    if (first_pose_ == 0) report();
    try {
      while (result_.poses.size() < config_.motion.poses.size()) make_body_frame();
    } catch (const SimulationFailed& failure) {
      stop(failure.what());
    } catch (const DressOverBudget& failure) {
      stop(failure.what());
    }
    add_run(*simulation_, phase_name(DressPhase::move), result_);
    result_.jams = simulation_->result().tangle.jams;
  }

 private:
  void open() {
    const double rate = config_.motion.rate;
    steps_ = std::max(1, static_cast<int>(std::ceil(config_.fps / rate)));
    const PhaseSettings settings{.gravity = Vec3(0.0, 0.0, -kGravity),
                                 .drag = config_.motion.drag,
                                 .friction = config_.body_friction,
                                 .pull = config_.largest_pull,
                                 .moving_fps = steps_ * rate};
    scene_ =
        std::make_unique<DressScene>(make_dress_scene(garment_, dressing_.body, config_, settings));
    driven_ = &drive_body(scene_->built, 0);
    simulation_ = start_simulation(*scene_, dressing_);
    if (dressing_.observer.accepted) dressing_.observer.accepted(*simulation_, DressPhase::move);
  }

  /// Of the garment above the body, m.
  double height() const {
    return garment_height(*simulation_) - mean_height(simulation_->body_positions(), {});
  }

  /// From frame `body_frame_` to the next one.
  void make_body_frame() {
    const std::vector<Vec3>&from = frames_[body_frame_].vertices,
          &to = frames_[body_frame_ + 1].vertices;
    ++body_frame_;
    std::vector<Vec3> x(to.size());
    for (int step = 1; step <= steps_; ++step) {
      const double share = static_cast<double>(step) / steps_;
      for (std::size_t v = 0; v < x.size(); ++v) x[v] = (1.0 - share) * from[v] + share * to[v];
      simulation_->move_body(*driven_, x);
      simulation_->advance_to_frame(++frame_, [&](double) {
        if (dressing_.observer.accepted)
          dressing_.observer.accepted(*simulation_, DressPhase::move);
      });
      show();
    }
    if (body_frame_ >= first_pose_) report();
  }

  void show() {
    if (dressing_.observer.frame)
      dressing_.observer.frame(*simulation_, DressPhase::move, simulation_->time());
  }

  void report() {
    const std::vector<std::uint8_t> flags = simulation_->flags();
    result_.poses.push_back(
        {.time = simulation_->time(),
         .max_stretch = max_stretch(*simulation_, 0),
         .drop = start_height_ - height(),
         .flagged = static_cast<int>(
             std::count_if(flags.begin(), flags.end(), [](std::uint8_t f) { return f != 0; }))});
    if (dressing_.observer.pose) dressing_.observer.pose(*simulation_, result_.poses.size() - 1);
  }

  void stop(const char* reason) {
    result_.motion_fault =
        fmt::format("while the body moves to pose {}: {}", result_.poses.size(), reason);
  }

  Garment& garment_;
  const Dressing& dressing_;
  const DressConfig& config_;
  DressResult& result_;
  std::unique_ptr<DressScene> scene_;
  std::unique_ptr<Simulation> simulation_;
  DrivenBody* driven_ = nullptr;      // of the simulation
  std::vector<TriangleMesh> frames_;  // of the body
  std::size_t first_pose_ = 0;        // the frame of the body that is the first pose
  std::size_t body_frame_ = 0;        // the last one that the body has reached
  int steps_ = 1;                     // frames of the scene for each frame of the body
  int frame_ = 0;                     // of the scene
  double start_height_ = 0.0;         // m
};

}  // namespace

void follow_poses(Garment& garment, const Dressing& dressing, const TriangleMesh& body,
                  DressResult& result) {
  Posing(garment, dressing, body, result).run();
}

}  // namespace selvedge::detail
