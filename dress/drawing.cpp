// SPDX-License-Identifier: MIT
//
// Drawing: after its seams have closed, a garment is pulled into place as hands do it. A tight hem
// slides up while the seams close, and the cloth above it makes a shelf or a roll. Each vertex is
// pulled along its panel, towards where the pattern places it. Across this direction nothing
// pulls, because a flat panel lies wider than one around a body. A garment that is its own mirror
// image is also pulled straight: each vertex half-way to where its image is on the other side.
#include <selvedge/dress/detail/pulls.h>

#include <cmath>

namespace selvedge::detail {
namespace {

constexpr double kLowFriction = 0.05;
constexpr double kDrawTime = 1.0;  // s, at most
constexpr int kStillFrames = 6;    // over which it is measured
constexpr double kStill = 1e-3;    // m, root mean square of the motion in these, which ends it
constexpr double kAlike = 0.9;  // cosine between the axes of panels that are images of each other

class Drawing {
 public:
  Drawing(Garment& garment, const Garment& start, const std::vector<PanelPlace>& places,
          const Dressing& dressing, DressResult& result)
      : garment_(garment),
        start_(start),
        places_(places),
        dressing_(dressing),
        result_(result),
        straightening_(garment, dressing) {}

  void run() {
    find_pulls();
    if (pulls_.empty()) return;
    const Methods methods = with_pulls(dressing_.methods, pulls_);
    const Dressing drawing{dressing_.body, dressing_.config, methods, dressing_.observer,
                           dressing_.deadline};
    const PhaseSettings settings{.drag = dressing_.config.sew_drag,
                                 .friction = kLowFriction,
                                 .pull = dressing_.config.largest_pull,
                                 .hold_under = true};
    DressScene scene = make_dress_scene(garment_, dressing_.body, dressing_.config, settings);
    const auto simulation = start_simulation(scene, drawing);
    const Garment before = garment_;
    try {
      advance(*simulation);
      take_state(*simulation, garment_);
    } catch (const SimulationFailed&) {
      // It stays as the seams left it.
      garment_ = before;
    }
    add_run(*simulation, "draw", result_);
    result_.settle_time += simulation->time();
  }

 private:
  void advance(Simulation& simulation) {
    const double fps = dressing_.config.fps;
    straightening_.aim(simulation.positions(), pulls_);
    std::vector<Vec3> last(simulation.positions().begin(), simulation.positions().end());
    for (int frame = 1; frame <= kDrawTime * fps; ++frame) {
      simulation.advance_to_frame(frame, [&](double) {
        if (dressing_.observer.accepted) dressing_.observer.accepted(simulation, DressPhase::draw);
      });
      if (dressing_.observer.frame)
        dressing_.observer.frame(simulation, DressPhase::draw,
                                 result_.sew_time + simulation.time());
      straightening_.aim(simulation.positions(), pulls_);
      if (frame % kStillFrames != 0) continue;
      double sum = 0.0;
      for (std::size_t v = 0; v < last.size(); ++v)
        sum += (simulation.positions()[v] - last[v]).squaredNorm();
      if (std::sqrt(sum / static_cast<double>(last.size())) < kStill) return;
      last.assign(simulation.positions().begin(), simulation.positions().end());
    }
  }

  /// Where the pattern places a vertex, and the axis of its panel.
  struct Placed {
    Vec3 x, axis;
  };
  Placed placed(std::size_t v, std::size_t panel) const {
    const PanelPlace& place = places_[panel];
    return {start_.surface.vertices[start_.corner[v]] + place.shift, place.axis};
  }

  /// Between that of a vertex and the mirror image of that of its image.
  Placed between(const Placed& own, const Placed& image) const {
    Vec3 axis(-image.axis.x(), image.axis.y(), image.axis.z());
    if (axis.dot(own.axis) < 0.0) axis = -axis;
    if (axis.dot(own.axis) < kAlike) return own;
    return {0.5 * (own.x + straightening_.mirrored(image.x)), (own.axis + axis).normalized()};
  }

  void find_pulls() {
    const std::vector<double> area = vertex_areas(garment_.flat.vertices, garment_.flat.triangles);
    std::vector<std::int32_t> panel(area.size(), -1);
    for (std::size_t i = 0; i < garment_.flat.triangles.size(); ++i)
      for (const std::int32_t v : garment_.flat.triangles[i])
        panel[v] = garment_.panel_of_triangle[i];
    for (std::size_t v = 0; v < area.size(); ++v) {
      if (panel[v] < 0) continue;
      const auto p = static_cast<std::size_t>(panel[v]);
      Placed to = placed(v, p);
      if (const std::int32_t image = straightening_.image()[v]; image >= 0)
        to = between(
            to, placed(static_cast<std::size_t>(image), static_cast<std::size_t>(panel[image])));
      if (to.axis.isZero(0.0)) continue;
      pulls_.push_back({.vertex = garment_.corner[v],
                        .axis = to.axis,
                        .target = to.axis.dot(to.x),
                        .area = places_[p].strength * area[v]});
    }
    straightening_.add_pulls(garment_, pulls_);
  }

  Garment& garment_;
  const Garment& start_;
  const std::vector<PanelPlace>& places_;
  const Dressing& dressing_;
  DressResult& result_;
  std::vector<Pull> pulls_;
  Straightening straightening_;
};

}  // namespace

void draw_into_place(Garment& garment, const Garment& start, const std::vector<PanelPlace>& places,
                     const Dressing& dressing, DressResult& result) {
  Drawing(garment, start, places, dressing, result).run();
}

}  // namespace selvedge::detail
