// SPDX-License-Identifier: MIT
//
// Drawing: after its seams have closed, a garment is pulled into place as hands do it. A tight hem
// slides up while the seams close, and the cloth above it makes a shelf or a roll. Each vertex is
// pulled along its panel, towards where the pattern places it. Across this direction nothing
// pulls, because a flat panel lies wider than one around a body.
#include <selvedge/dress/detail/dressing.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace selvedge::detail {
namespace {

constexpr double kStiffness = 4000.0;  // N/m³, of the pull
constexpr double kStrongest = 200.0;   // N/m², that a hand pulls
constexpr double kLowFriction = 0.05;
constexpr double kDrawTime = 1.0;  // s, at most
constexpr int kStillFrames = 6;    // over which it is measured
constexpr double kStill = 1e-3;    // m, root mean square of the motion in these, which ends it

/// The pull on one vertex of the flat pattern.
struct Pull {
  std::int32_t vertex = 0;   // of the surface
  Vec3 axis = Vec3::Zero();  // unit
  double target = 0.0;       // m, along the axis
  double area = 0.0;         // m², times the strength of the pull
};

/// f = A k e / √(1 + (k e / p)²) along the axis, e: the way to the target, k: stiffness, p: the
/// strongest pull.
class DrawForce final : public Force {
 public:
  explicit DrawForce(const std::vector<Pull>& pulls) : pulls_(pulls) {}

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    for (const Pull& pull : pulls_) {
      const double e = way(pull, state);
      f[pull.vertex] += pull.area * kStiffness * e / root(e) * pull.axis;
    }
  }
  double energy(const ForceState& state) const override {
    double sum = 0.0;
    for (const Pull& pull : pulls_)
      sum += pull.area * kStrongest * kStrongest / kStiffness * (root(way(pull, state)) - 1.0);
    return sum;
  }
  // The Jacobian has blocks on the diagonal only, which every matrix has.
  void add_links(std::vector<Edge>&) const override {}
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const override {
    for (const Pull& pull : pulls_)
      a.diagonal(static_cast<std::size_t>(pull.vertex)) +=
          h * h * stiffness(pull, state) * pull.axis * pull.axis.transpose();
  }
  void add_stiffness_bound(const ForceState& state, std::span<double> stiffness_sum,
                           std::span<double>) const override {
    for (const Pull& pull : pulls_) stiffness_sum[pull.vertex] += stiffness(pull, state);
  }

 private:
  static double way(const Pull& pull, const ForceState& state) {
    return pull.target - pull.axis.dot(state.x[pull.vertex]);
  }
  static double root(double e) {
    const double share = kStiffness * e / kStrongest;
    return std::sqrt(1.0 + share * share);
  }
  static double stiffness(const Pull& pull, const ForceState& state) {
    const double r = root(way(pull, state));
    return pull.area * kStiffness / (r * r * r);
  }

  const std::vector<Pull>& pulls_;
};

class Drawing {
 public:
  Drawing(Garment& garment, const Garment& start, const std::vector<PanelPlace>& places,
          const Dressing& dressing, DressResult& result)
      : garment_(garment), start_(start), places_(places), dressing_(dressing), result_(result) {}

  void run() {
    find_pulls();
    if (pulls_.empty()) return;
    Methods methods = dressing_.methods;
    methods.force_laws.add("draw", {},
                           [this](const MethodOptions&, const ClothMesh&) {
                             ForceList forces;
                             forces.push_back(std::make_unique<DrawForce>(pulls_));
                             return forces;
                           },
                           {.promise = "minus the gradient of its energy", .source = "selvedge"});
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
    std::vector<Vec3> last(simulation.positions().begin(), simulation.positions().end());
    for (int frame = 1; frame <= kDrawTime * fps; ++frame) {
      simulation.advance_to_frame(frame, [&](double) {
        if (dressing_.observer.accepted) dressing_.observer.accepted(simulation, DressPhase::draw);
      });
      if (dressing_.observer.frame)
        dressing_.observer.frame(simulation, DressPhase::draw,
                                 result_.sew_time + simulation.time());
      if (frame % kStillFrames != 0) continue;
      double sum = 0.0;
      for (std::size_t v = 0; v < last.size(); ++v)
        sum += (simulation.positions()[v] - last[v]).squaredNorm();
      if (std::sqrt(sum / static_cast<double>(last.size())) < kStill) return;
      last.assign(simulation.positions().begin(), simulation.positions().end());
    }
  }

  void find_pulls() {
    const std::vector<double> area = vertex_areas(garment_.flat.vertices, garment_.flat.triangles);
    std::vector<std::int32_t> panel(area.size(), -1);
    for (std::size_t i = 0; i < garment_.flat.triangles.size(); ++i)
      for (const std::int32_t v : garment_.flat.triangles[i])
        panel[v] = garment_.panel_of_triangle[i];
    for (std::size_t v = 0; v < area.size(); ++v) {
      if (panel[v] < 0) continue;
      const PanelPlace& place = places_[static_cast<std::size_t>(panel[v])];
      if (place.axis.isZero(0.0)) continue;
      const Vec3& start = start_.surface.vertices[start_.corner[v]];
      pulls_.push_back({.vertex = garment_.corner[v],
                        .axis = place.axis,
                        .target = place.axis.dot(start + place.shift),
                        .area = place.strength * area[v]});
    }
  }

  Garment& garment_;
  const Garment& start_;
  const std::vector<PanelPlace>& places_;
  const Dressing& dressing_;
  DressResult& result_;
  std::vector<Pull> pulls_;
};

}  // namespace

void draw_into_place(Garment& garment, const Garment& start, const std::vector<PanelPlace>& places,
                     const Dressing& dressing, DressResult& result) {
  Drawing(garment, start, places, dressing, result).run();
}

}  // namespace selvedge::detail
