// SPDX-License-Identifier: MIT
//
// Sewing: without weight and friction, seams pull their sides together until all of their pairs
// have met and merged [ZhongXu2009]. The pull starts gently, because fast panels need short steps,
// and doubles where the seams stop to close, as around a tight waist.
#include <fmt/format.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/dress/detail/deformation.h>
#include <selvedge/dress/detail/dressing.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

namespace selvedge::detail {
namespace {

constexpr double kReachOut =
    1.5;  // factor of the merge distance where seams stop at the largest pull
constexpr double kFarthest = 1.2;   // of the spacing of the finest seam, the largest merge distance
constexpr int kStallFrames = 12;    // frames over which progress is measured
constexpr double kProgress = 0.05;  // of the mean opening, within that many frames
// The last open pairs may hold a fold of cloth between them. It slides out when they let go of it.
constexpr int kMostReleases = 3;        // of an attempt
constexpr int kUnpicked = 3;            // pairs beside open ones, more of them each time
constexpr double kReleaseTime = 0.3;    // s, without a pull
constexpr double kReleaseLonger = 1.5;  // s, by which each release lengthens the sewing
// Soft panels that meet at their edges may fold into the seams, and no pull brings a fold out
// again. Panels as stiff as card slide past each other; but a stiff bodice may close below the
// shoulders.
constexpr double kCard = 3e-3;          // N·m, bending stiffness, 300 times that of a knit
constexpr double kAroundOpening = 0.1;  // m, in which the stretch beside an open pair is measured
/// Share of their first opening at which seams that span the body enclose it.
constexpr double kEnclosing = 0.1;

class Sewing {
 public:
  Sewing(Garment& garment, const Dressing& dressing, DressPhase phase, const SewAttempt& attempt,
         DressResult& result)
      : garment_(garment),
        phase_(phase),
        dressing_(dressing),
        config_(dressing.config),
        result_(result),
        merge_share_(attempt.merge_share),
        stages_(attempt.stages),
        is_stiff_(attempt.is_stiff),
        gives_up_(attempt.gives_up),
        pull_(config_.pull),
        longest_s_(config_.sew_time) {}

  void run() {
    note_start();
    skip_closed_stages();
    open();
    show();
    while (garment_.open_pairs() > 0 && sewn_s_ < longest_s_ && !is_stuck_) {
      make_frame();
      if (frame_ % kMergeEvery == 0) merge();
      if (!is_last_stage() && is_stage_done())
        go_on();
      else
        adapt_pull();
    }
    merge();
    take_state(*simulation_, garment_);
    add_run(*simulation_, phase_name(phase_), result_);
    return_to_best();
    if (garment_.largest_opening() > config_.sewing_edge_length) refuse_open_seam();
  }

 private:
  void open() {
    simulation_.reset();  // it refers to the former scene
    const PhaseSettings settings{.drag = config_.sew_drag,
                                 .pull = is_released_ ? 0.0 : pull_,
                                 .least_bending = is_stiff_ || releases_ > 0 ? kCard : 0.0,
                                 .merge = merge_share_,
                                 .limit_strain = false,
                                 .with_elastics = false,
                                 .hold_under = true,
                                 .seams = stage()};
    scene_ =
        std::make_unique<DressScene>(make_dress_scene(garment_, dressing_.body, config_, settings));
    simulation_ = start_simulation(*scene_, dressing_);
    frame_of_simulation_ = 0;
    if (dressing_.observer.accepted) dressing_.observer.accepted(*simulation_, phase_);
  }

  SeamChoice stage() const { return stages_[stage_]; }
  bool is_last_stage() const { return stage_ + 1 == stages_.size(); }

  /// Of the open pairs that pull, m; 0: all of them are merged.
  double mean_opening() const {
    double sum = 0.0, count = 0.0;
    for (std::size_t s = 0; s < garment_.stitches.size(); ++s) {
      if (!garment_.is_chosen(s, stage())) continue;
      for (const auto& [a, b] : garment_.open_pairs(s)) {
        sum += (garment_.surface.vertices[b] - garment_.surface.vertices[a]).norm();
        count += 1.0;
      }
    }
    return count > 0.0 ? sum / count : 0.0;
  }

  /// Gathered seams close entirely. Seams that span the body only come so near that the garment
  /// encloses it: their ends, as in an armpit, may need the others.
  bool is_stage_done() const {
    const double share = stage() == SeamChoice::spanning ? kEnclosing : 0.0;
    return mean_opening() <= share * opening_at_start_;
  }

  void skip_closed_stages() {
    opening_at_start_ = mean_opening();
    while (!is_last_stage() && opening_at_start_ == 0.0) {
      ++stage_;
      opening_at_start_ = mean_opening();
    }
  }

  void go_on() {
    ++stage_;
    skip_closed_stages();
    pull_ = config_.pull;
    openings_.clear();
    reopen();
  }

  void note_start() {
    for (std::size_t s = 0; s < garment_.stitches.size(); ++s)
      result_.seams[s].opening_start =
          std::max(result_.seams[s].opening_start, garment_.opening(s));
  }

  void show() {
    if (dressing_.observer.frame) dressing_.observer.frame(*simulation_, phase_, result_.sew_time);
  }

  void make_frame() {
    ++frame_;
    ++frame_of_simulation_;
    try {
      simulation_->advance_to_frame(frame_of_simulation_, [&](double) {
        if (dressing_.observer.accepted) dressing_.observer.accepted(*simulation_, phase_);
      });
    } catch (const SimulationFailed& failure) {
      throw DressFailed(fmt::format("while seams close: {}", failure.what()));
    }
    sewn_s_ += 1.0 / config_.fps;
    result_.sew_time += 1.0 / config_.fps;
    take_state(*simulation_, garment_);
    show();
  }

  /// Merges pairs that are near but blocked, after one vertex of each has been moved to the other.
  bool merge_blocked() {
    const Stopwatch watch;
    const std::size_t moved = move_together(*simulation_, garment_, dressing_, merge_share_);
    result_.seconds["sew/merge"] += watch.seconds();
    if (moved == 0) return false;
    reopen();
    const std::size_t open = garment_.open_pairs();
    merge();
    return garment_.open_pairs() < open;
  }

  void merge() {
    const Stopwatch watch;
    const std::size_t merged =
        merge_closed(*scene_, *simulation_, dressing_.methods, garment_, result_);
    result_.seconds["sew/merge"] += watch.seconds();
    if (merged > 0) reopen();
  }

  /// Goes on with the garment as it is now.
  void reopen() {
    add_run(*simulation_, phase_name(phase_), result_);
    open();
  }

  void adapt_pull() {
    openings_.push_back(mean_opening());
    const auto n = static_cast<int>(openings_.size());
    if (n <= kStallFrames || garment_.open_pairs() == 0) return;
    if (openings_.back() < (1.0 - kProgress) * openings_[n - 1 - kStallFrames]) return;
    openings_.clear();
    const bool is_largest = pull_ >= config_.largest_pull;
    if (!is_last_stage() && (is_largest || stage() == SeamChoice::spanning)) return go_on();
    if (is_last_stage() && can_release() && is_blocked()) {
      is_stuck_ = gives_up_;
      return is_stuck_ ? void() : release();
    }
    const bool is_farthest = is_largest && merge_share_ >= kFarthest;
    if (is_farthest && merge_blocked()) return;
    if (is_farthest && can_release()) return release();
    is_stuck_ = is_farthest || garment_.largest_opening() <= closed_opening(config_);
    if (is_stuck_) return;
    if (is_largest)
      merge_share_ = std::min(kReachOut * merge_share_, kFarthest);
    else
      pull_ = std::min(2.0 * pull_, config_.largest_pull);
    reopen();
  }

  /// Whether the last pairs may hold a fold between them.
  bool can_release() const {
    const double opening = garment_.largest_opening();
    return releases_ < kMostReleases && opening > closed_opening(config_) &&
           opening <= config_.sewing_edge_length;
  }

  /// Whether cloth lies between the sides of an open pair, so that no stronger pull helps.
  bool is_blocked() const {
    std::vector<Edge> pairs;
    for (std::size_t s = 0; s < garment_.stitches.size(); ++s)
      for (const Edge& pair : garment_.open_pairs(s)) pairs.push_back(pair);
    return has_layer_between(garment_, pairs);
  }

  /// The seams let go while the cloth becomes smooth, also where they are closed beside an open
  /// pair. Then they pull from the start.
  void release() {
    ++releases_;
    if (!best_ || garment_.largest_opening() < best_->largest_opening()) best_ = garment_;
    unpick(garment_, dressing_, releases_ * kUnpicked);
    longest_s_ += kReleaseLonger;
    is_released_ = true;
    reopen();
    for (int left = static_cast<int>(std::lround(kReleaseTime * config_.fps)); left > 0; --left)
      make_frame();
    is_released_ = false;
    pull_ = config_.pull;
    reopen();
  }

  /// A release may leave more open than there was before it.
  void return_to_best() {
    if (!best_ || garment_.largest_opening() <= best_->largest_opening()) return;
    garment_ = *best_;
    if (dressing_.observer.restart) dressing_.observer.restart();
  }

  [[noreturn]] void refuse_open_seam() {
    const std::size_t widest = garment_.widest_seam();
    const std::vector<Edge> pairs = garment_.open_pairs(widest);
    const std::vector<Vec3>& x = garment_.surface.vertices;
    const Edge& pair =
        *std::max_element(pairs.begin(), pairs.end(), [&](const Edge& a, const Edge& b) {
          return (x[a[1]] - x[a[0]]).norm() < (x[b[1]] - x[b[0]]).norm();
        });
    const double strain = strain_near(garment_.surface, garment_.flat,
                                      0.5 * (x[pair[0]] + x[pair[1]]), kAroundOpening);
    throw DressFailed(fmt::format(
        "{} does not close: {} of its {} pairs are open, by at most {:.1f} mm; the cloth beside it "
        "is "
        "stretched by {:.0f} %: {}",
        result_.seams[widest].name, pairs.size(), garment_.stitches[widest].a.size(),
        1e3 * garment_.opening(widest), 100.0 * strain,
        strain > config_.wearable_stretch ? "the garment is too small there for the body"
                                          : "something is in the way, or the panels start too far "
                                            "from their places"));
  }

  Garment& garment_;
  DressPhase phase_;
  const Dressing& dressing_;
  const DressConfig& config_;
  DressResult& result_;
  double merge_share_;
  std::vector<SeamChoice> stages_;
  bool is_stiff_, gives_up_;
  std::size_t stage_ = 0;
  double opening_at_start_ = 0.0;  // m, mean of the open pairs that pull, when the stage began
  double pull_;                    // N per metre of seam
  double longest_s_;               // s, at which the sewing ends
  double sewn_s_ = 0.0;            // s
  int releases_ = 0;
  bool is_released_ = false;     // no seam pulls
  std::optional<Garment> best_;  // before a release
  std::unique_ptr<DressScene> scene_;
  std::unique_ptr<Simulation> simulation_;
  int frame_ = 0, frame_of_simulation_ = 0;
  std::vector<double> openings_;  // m, mean of the open pairs, frame by frame
  bool is_stuck_ = false;         // what is open stays so
};

}  // namespace

void sew(Garment& garment, const Dressing& dressing, DressPhase phase, const SewAttempt& attempt,
         DressResult& result) {
  Sewing(garment, dressing, phase, attempt, result).run();
}

}  // namespace selvedge::detail
