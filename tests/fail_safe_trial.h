// SPDX-License-Identifier: MIT
// Single steps of generated motion for tests of the fail-safes alone: triangles that fly at each
// other (free, held and of bodies), and sheets that fall on a plate. The detection and the exact
// narrow phase of the simulation verify the results.
#pragma once

#include <selvedge/response/fail_safe.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/contacts/detail/detection.h>

#include <Eigen/Geometry>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace selvedge {

inline constexpr double kStep = 1.0 / 120.0;
inline constexpr double kThickness = 0.01;
inline constexpr int kHalvings = 8;

/// Cloth and bodies over one step, in a joint index space.
struct Stage {
  TriangleMesh cloth, body;
  std::vector<double> mass;
  std::vector<Vec3> move;       // of particles, then of body vertices
  std::set<std::int32_t> held;  // particles
  double friction = 0.0;

  std::size_t n() const { return cloth.vertices.size(); }
};

/// A stage with its detection; calls follow the order of the simulation.
class Trial {
 public:
  explicit Trial(const Stage& stage)
      : stage_(stage), x_t0(stage.cloth.vertices), scene_(scene(stage)), built_(built(stage)) {
    x_t0.insert(x_t0.end(), stage.body.vertices.begin(), stage.body.vertices.end());
    inv_mass.assign(x_t0.size(), 0.0);
    for (std::size_t i = 0; i < stage.n(); ++i)
      if (!stage.held.contains(static_cast<std::int32_t>(i))) inv_mass[i] = 1.0 / stage.mass[i];
    detection_ = std::make_unique<detail::Detection>(scene_, built_, Methods{}, clock_);
    aim(1.0);
  }

  /// Sets the end positions to the given share of the motion.
  void aim(double share) {
    x_t1 = x_t0;
    for (std::size_t i = 0; i < x_t1.size(); ++i) x_t1[i] += share * stage_.move[i];
    body_move_.clear();
    for (std::size_t i = stage_.n(); i < x_t1.size(); ++i) body_move_.push_back(x_t1[i] - x_t0[i]);
    detection_->set_motion(x_t0, x_t1, true);
    detection_->find_candidates();
    find();
  }

  void find() {
    detection_->renew_candidates();
    detection_->find_collisions(hits);
  }

  /// Number of rounds until no collision remains; -1 if the step must be shorter.
  int resolve(FailSafe& fail_safe) {
    int rounds = 0;
    fail_safe.begin(step(), *detection_);
    for (; !hits.empty(); ++rounds) {
      if (!fail_safe.resolve(hits, x_t1)) return -1;
      find();
    }
    return rounds;
  }

  /// Halves the motion until it is free of collisions, as the simulation does. Returns the
  /// remaining share.
  double resolve_halved(FailSafe& fail_safe) {
    double share = 1.0;
    for (int k = 0; k <= kHalvings; ++k, share *= 0.5) {
      aim(share);
      if (resolve(fail_safe) >= 0) return share;
    }
    return 0.0;
  }

  ResponseStep step() const {
    return {{x_t0, inv_mass, stage_.n(), kStep}, stage_.mass, body_move_, {}, {}};
  }
  Clearances& clearances() { return *detection_; }
  Vec3 momentum() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < stage_.n(); ++i) sum += stage_.mass[i] * (x_t1[i] - x_t0[i]);
    return sum;
  }
  Vec3 angular_momentum() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < stage_.n(); ++i)
      sum += stage_.mass[i] * x_t0[i].cross(x_t1[i] - x_t0[i]);
    return sum;
  }
  double energy() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < stage_.n(); ++i)
      sum += 0.5 * stage_.mass[i] * (x_t1[i] - x_t0[i]).squaredNorm();
    return sum;
  }

 private:
  static Scene scene(const Stage& stage) {
    Scene scene;
    scene.materials["default"] = Material{};
    scene.materials["default"].friction = stage.friction;
    scene.contact.rest_gap = kThickness;
    scene.cloths.emplace_back();
    if (!stage.body.vertices.empty()) {
      scene.bodies.emplace_back();
      scene.bodies[0].friction = stage.friction;
    }
    return scene;
  }
  static BuiltScene built(const Stage& stage) {
    BuiltScene built;
    built.cloth.surface = stage.cloth;
    built.cloth.edges = unique_edges(stage.cloth.triangles);
    built.cloth.mass = stage.mass;
    built.velocity.assign(stage.n(), Vec3::Zero());
    built.piece_begin = {0, static_cast<std::int32_t>(stage.n())};
    if (!stage.body.vertices.empty()) built.bodies.push_back(make_static_body(stage.body));
    return built;
  }

  Stage stage_;

 public:
  std::vector<Vec3> x_t0, x_t1;
  std::vector<double> inv_mass;
  std::vector<ContactPoint> hits;

 private:
  std::vector<Vec3> body_move_;
  Scene scene_;
  BuiltScene built_;
  detail::PhaseClock clock_;
  std::unique_ptr<detail::Detection> detection_;
};

/// Disjoint triangles in the cells of a cube that fly through each other.
inline Stage swarm(unsigned seed, double speed) {
  constexpr int kSide = 3;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.5, 2.0);
  const auto vec = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  Stage stage;
  stage.friction = 0.2;
  for (int cell = 0; cell < kSide * kSide * kSide; ++cell) {
    const Vec3 centre(cell % kSide, cell / kSide % kSide, cell / kSide / kSide);
    const Vec3 drift = speed * vec();
    const auto first = static_cast<std::int32_t>(stage.n());
    for (int k = 0; k < 3; ++k) {
      stage.cloth.vertices.push_back(centre + 0.48 * vec().normalized());
      stage.mass.push_back(1e-3 * uniform(random));
      stage.move.push_back(drift + 0.3 * speed * vec());
    }
    stage.cloth.triangles.push_back({first, first + 1, first + 2});
  }
  return stage;
}

/// The same swarm with the last triangles as a body and some held particles. Held particles and
/// body move if `moving` is true.
inline Stage swarm_with_anchors(unsigned seed, double speed, bool moving) {
  const Stage all = swarm(seed, speed);
  constexpr std::size_t kFree = 54;
  Stage stage;
  stage.friction = all.friction;
  for (std::size_t i = 0; i < all.n(); ++i) {
    (i < kFree ? stage.cloth : stage.body).vertices.push_back(all.cloth.vertices[i]);
    if (i < kFree) stage.mass.push_back(all.mass[i]);
    if (i < kFree && i % 9 == 0) stage.held.insert(static_cast<std::int32_t>(i));
    const bool anchor = i >= kFree || i % 9 == 0;
    const Vec3 shared = 0.5 * speed * Vec3(1, 1, 0);
    stage.move.push_back(!anchor ? all.move[i] : moving ? shared : Vec3(0, 0, 0));
  }
  for (const Triangle& t : all.cloth.triangles)
    if (static_cast<std::size_t>(t[0]) < kFree)
      stage.cloth.triangles.push_back(t);
    else
      stage.body.triangles.push_back({t[0] - static_cast<std::int32_t>(kFree),
                                      t[1] - static_cast<std::int32_t>(kFree),
                                      t[2] - static_cast<std::int32_t>(kFree)});
  return stage;
}

/// Sheets above each other, 3 mm apart, on a plate; all fall by `fall` and slide by `slide`.
inline Stage falling_sheets(int sheets, int cells, const Vec3& move) {
  Stage stage;
  for (int k = 0; k < sheets; ++k) {
    const ClothMesh sheet = make_rectangular({0.1, 0.1, cells, cells}, Material{});
    const auto first = static_cast<std::int32_t>(stage.n());
    const Eigen::AngleAxisd turn(0.3 * k, Vec3::UnitZ());
    for (const Vec3& x : sheet.surface.vertices) {
      stage.cloth.vertices.push_back(turn * x + Vec3(0, 0, 0.003 * (k + 1)));
      stage.mass.push_back(1e-4);
      stage.move.push_back(move);
    }
    for (const Triangle& t : sheet.surface.triangles)
      stage.cloth.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  stage.body.vertices = {{-1, -1, 0}, {1, -1, 0}, {0, 2, 0}};
  stage.body.triangles = {{0, 1, 2}};
  stage.move.resize(stage.move.size() + 3, Vec3::Zero());
  return stage;
}

/// Mean displacement of the first n vertices, m.
inline Vec3 mean_move(const Trial& trial, std::size_t n) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < n; ++i) sum += trial.x_t1[i] - trial.x_t0[i];
  return sum / static_cast<double>(n);
}

}  // namespace selvedge
