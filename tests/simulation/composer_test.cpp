// SPDX-License-Identifier: MIT
// Detection as a whole, at the edge of its margins: candidates are found for one end of a motion,
// then the end is moved by nearly the margin in each coordinate. What collides then, and what is
// near at the start, is compared with a fresh search that has no margins (StepValidator).
#include <gtest/gtest.h>
#include <selvedge/narrowphase/distance.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/contacts/detail/contact_filter.h>
#include <selvedge/simulation/contacts/detail/detection.h>
#include <selvedge/simulation/detail/validate_step.h>
#include <selvedge/simulation/simulation_state.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

namespace selvedge::composer_test {
namespace {

// What Detection promises, as numbers of its own so that a change of a constant there is seen.
constexpr double kMargin = 0.005;      // m, the largest thickness of the stage
constexpr double kNearlyAll = 0.9999;  // of a margin
constexpr double kPointReach = 1.5;    // thicknesses at the start within which a pair is a contact
constexpr double kSelfMargin = 0.5 * kPointReach;  // of the cloth with itself, by kMargin

/// A square of `n` x `n` cells in the plane z = 0, centred.
TriangleMesh sheet(int n, double size, double z = 0.0) {
  TriangleMesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      mesh.vertices.emplace_back(size * (static_cast<double>(i) / n - 0.5),
                                 size * (static_cast<double>(j) / n - 0.5), z);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const std::int32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  return mesh;
}

TriangleMesh octahedron(double radius) {
  TriangleMesh mesh;
  for (const double side : {-radius, radius})
    for (int k = 0; k < 3; ++k) mesh.vertices.push_back(side * Vec3::Unit(k));
  mesh.triangles = {{3, 4, 5}, {4, 0, 5}, {0, 1, 5}, {1, 3, 5},
                    {4, 3, 2}, {0, 4, 2}, {1, 0, 2}, {3, 1, 2}};
  return mesh;
}

ClothSpec piece(const std::string& name, TriangleMesh mesh) {
  ClothFile file;
  file.mesh = std::move(mesh);
  ClothSpec spec;
  spec.name = name;
  spec.shape = std::move(file);
  return spec;
}

BodySpec body(const std::string& name, TriangleMesh mesh) {
  BodyFile file;
  file.mesh = std::move(mesh);
  BodySpec spec;
  spec.name = name;
  spec.shape = std::move(file);
  return spec;
}

/// What a piece comes near to.
enum class Target { piece, resting, rigid, deforming };

using Key = std::array<std::int32_t, 5>;

Key key(const ContactPoint& c) {
  return {static_cast<std::int32_t>(c.kind), c.vertex[0], c.vertex[1], c.vertex[2], c.vertex[3]};
}

std::set<Key> keys(const std::vector<ContactPoint>& pairs) {
  std::set<Key> set;
  for (const ContactPoint& c : pairs) set.insert(key(c));
  return set;
}

/// Two pieces of cloth, a closed one with a particle of no triangle in its middle, and three
/// bodies: one that rests, a large one that moves rigidly, one that changes its shape. `frame`: the
/// axes in which sheets are flat; a margin per coordinate reaches farther along a diagonal.
class Stage {
 public:
  Stage(const std::string& broad_phase, const Mat3& frame, bool with_loose, unsigned seed)
      : random_(seed), frame_(frame) {
    scene_.name = "stage";
    scene_.materials["default"] = Material{};
    scene_.contact.rest_gap = 0.002;
    scene_.contact.broad_phase = broad_phase;
    scene_.contact.pairs = {{"a", "b", {}, kMargin},
                            {"a", "resting", {}, kMargin},
                            {"a", "rigid", {}, kMargin},
                            {"a", "deforming", {}, 0.003}};
    scene_.cloths = {piece("a", sheet(6, kSize)), piece("b", sheet(5, kSize, 3.0))};
    if (with_loose) {
      ClothSpec closed = piece("closed", octahedron(0.05));
      std::get<ClothFile>(closed.shape).support = SupportConstants{};
      closed.placement.translation = {0.0, 0.0, 5.0};
      scene_.cloths.push_back(std::move(closed));
    }
    scene_.bodies = {body("resting", sheet(4, 2.0 * kSize)), body("rigid", sheet(12, 2.0 * kSize)),
                     body("deforming", sheet(4, 2.0 * kSize))};
    built_ = std::make_unique<BuiltScene>(build_scene(scene_));
    place_bodies();
    detection_ = std::make_unique<detail::Detection>(scene_, *built_, Methods{}, clock_);
    pairs_ = std::make_unique<ContactPairs>(scene_);
    x_t0_.resize(n() + detection_->body_vertices());
    x_t1_.resize(x_t0_.size());
  }

  std::size_t n() const { return built_->cloth.surface.vertices.size(); }
  detail::Detection& detection() { return *detection_; }
  detail::SearchedMotion motion() const { return detection_->searched(); }
  std::vector<Vec3>& x_t0() { return x_t0_; }
  std::vector<Vec3>& x_t1() { return x_t1_; }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  /// A step of the bodies; the first piece keeps this gap to the target and moves with it, and by
  /// `way` farther; all cloth drifts if it is far from the bodies. Then candidates are found.
  void begin(int step, Target target, double gap, double roughness,
             const Vec3& way = Vec3::Zero()) {
    target_ = target;
    const detail::StepTimes times{0.1 * step, 0.1 * (step + 1)};
    std::size_t first = n();
    for (const auto& b : built_->bodies) {
      b->positions(times.t0, std::span(x_t0_).subspan(first, b->vertex_count()));
      b->positions(times.t1, std::span(x_t1_).subspan(first, b->vertex_count()));
      first += b->vertex_count();
    }
    const Pose t0 = pose(times.t0), t1 = pose(times.t1);
    const bool is_piece = target == Target::piece;
    const Vec3 drift =
        is_piece && drifts_ ? Vec3(uniform(-9, 9), uniform(-9, 9), uniform(-9, 9)) : Vec3::Zero();
    const Vec3 off(uniform(-0.02, 0.02), uniform(-0.02, 0.02), gap);
    const auto& rest = built_->cloth.surface.vertices;
    for (std::size_t i = 0; i < n(); ++i) {
      Vec3 local = rest[i] + off;
      if (is_b(i)) local.z() = is_piece ? 0.0 : rest[i].z();
      for (int k = 0; k < 3; ++k) local[k] += roughness * uniform(-1.0, 1.0);
      x_t0_[i] = t0.rotation * local + t0.translation;
      x_t1_[i] = t1.rotation * local + t1.translation + drift;
      if (!is_b(i)) x_t1_[i] += way;
    }
    pass_loose_particles(t0, t1);
    detection_->set_motion(x_t0_, x_t1_, true, times);
    detection_->find_candidates();
  }

  void set_drifts(bool drifts) { drifts_ = drifts; }

  /// Moves the end of every particle by up to the margin in each coordinate, most of them all of it
  /// and towards the target. If the target is a body, no two of them move apart by more than two
  /// margins of the cloth with itself.
  void go_to_the_edge() {
    const Vec3 normal = pose(0.0).rotation.col(2);
    const bool is_piece = target_ == Target::piece;
    const double least = is_piece ? -1.0 : 1.0 - 2.0 * kSelfMargin;
    for (std::size_t i = 0; i < n(); ++i)
      for (int k = 0; k < 3; ++k) {
        const double side = (is_piece && is_b(i) ? 1.0 : -1.0) * (normal[k] < 0.0 ? -1.0 : 1.0);
        x_t1_[i][k] +=
            margin() * kNearlyAll * side * (uniform(0.0, 1.0) < 0.8 ? 1.0 : uniform(least, 1.0));
      }
  }

  /// Moves the end of every particle to the edge of the box of its way, grown by the margin, or
  /// into that box, most of them to its edge towards the target. If the target is cloth, the box is
  /// that without the displacement that all cloth shares, and all ends get another one.
  void go_to_the_edge_of_the_way() {
    const bool is_piece = target_ == Target::piece;
    Vec3 drift = Vec3::Zero(), other = Vec3::Zero();
    if (is_piece) {
      for (std::size_t i = 0; i < n(); ++i) drift += x_t1_[i] - x_t0_[i];
      drift /= static_cast<double>(n());
      other = 10.0 * kMargin * Vec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    }
    const Vec3 normal = pose(0.0).rotation.col(2);
    for (std::size_t i = 0; i < n(); ++i)
      for (int k = 0; k < 3; ++k) {
        const auto [from, to] = std::minmax({x_t0_[i][k], x_t1_[i][k] - drift[k]});
        const double low = from - kNearlyAll * margin(), high = to + kNearlyAll * margin();
        const bool up = is_b(i) == (normal[k] >= 0.0);
        x_t1_[i][k] = drift[k] + other[k] +
                      (uniform(0.0, 1.0) < 0.8 ? (up ? high : low) : uniform(low, high));
      }
  }

  /// How far the end of a particle can be moved along the normal of the target.
  double reach() const { return margin() * pose(0.0).rotation.col(2).cwiseAbs().sum(); }

  double thickness(const ContactPoint& c) const {
    const auto surface = [&](std::int32_t v) {
      const auto& begin = built_->piece_begin;
      const auto vertex = static_cast<std::size_t>(v);
      std::int32_t s = 0;
      if (vertex < n()) {
        while (v >= begin[s + 1]) ++s;
        return s;
      }
      while (v - static_cast<std::int32_t>(n()) >= detection_->body_begin()[s + 1]) ++s;
      return s + static_cast<std::int32_t>(scene_.cloths.size());
    };
    const auto [a, b] = std::minmax({surface(c.vertex[0]), surface(c.vertex[3])});
    return pairs_->rest_gap(a, b);
  }

  static constexpr double kSize = 0.2;

 private:
  double margin() const { return (target_ == Target::piece ? kSelfMargin : 1.0) * kMargin; }

  bool is_b(std::size_t i) const {
    return static_cast<std::int32_t>(i) >= built_->piece_begin[1] &&
           static_cast<std::int32_t>(i) < built_->piece_begin[2];
  }

  /// Of the target, or of the first piece's place far from all bodies.
  Pose pose(double time) const {
    if (target_ == Target::piece) return {frame_, Vec3(0.0, 0.0, 40.0)};
    if (target_ == Target::rigid) return built_->bodies[1]->pose(time).value();
    return {frame_, target_ == Target::resting ? Vec3(0, 0, 0) : Vec3(0.0, 0.0, 20.0)};
  }

  void place_bodies() {
    const auto placed = [&](TriangleMesh mesh, const Vec3& at) {
      for (Vec3& x : mesh.vertices) x = frame_ * x + at;
      return mesh;
    };
    TriangleMesh plate = sheet(4, 2.0 * kSize), wide = plate;
    for (Vec3& x : wide.vertices) x.head<2>() *= 1.2;
    built_->bodies[0] = make_static_body(placed(plate, Vec3::Zero()));
    // A sheet turned in its own frame: the margin's diagonal is the normal of the world's boxes in
    // no frame but the body's.
    const Eigen::Quaterniond start(frame_), end(frame_ * Eigen::AngleAxisd(0.5, Vec3::UnitZ()));
    built_->bodies[1] = make_keyframed_body(
        sheet(12, 2.0 * kSize), {{0.0, Vec3(10, 0, 0), start}, {1.0, Vec3(10.5, 0.2, 0), end}});
    built_->bodies[2] =
        make_sequence_body({placed(plate, Vec3(0, 0, 20)), placed(wide, Vec3(0, 0, 20))}, 1.0, 0.0);
  }

  /// Particles of no triangle go straight through the first piece, which is no collision.
  void pass_loose_particles(const Pose& t0, const Pose& t1) {
    for (std::size_t p = 2; p + 1 < built_->piece_begin.size(); ++p) {
      const std::size_t i = built_->piece_begin[p + 1] - 1;
      x_t0_[i] = t0.rotation * Vec3(0.01, 0.02, 0.1) + t0.translation;
      x_t1_[i] = t1.rotation * Vec3(0.01, 0.02, -0.1) + t1.translation;
    }
  }

  std::mt19937 random_;
  Mat3 frame_;
  Target target_ = Target::piece;
  bool drifts_ = true;
  Scene scene_;
  std::unique_ptr<BuiltScene> built_;
  detail::PhaseClock clock_;
  std::unique_ptr<detail::Detection> detection_;
  std::unique_ptr<ContactPairs> pairs_;
  std::vector<Vec3> x_t0_, x_t1_;
};

/// Pairs nearer at the start than `reach` of their thickness, and not among the candidates.
std::vector<ContactPoint> near_but_missed(const Stage& stage, const detail::SearchedMotion& motion,
                                          double reach, std::size_t& near) {
  detail::SearchedMotion standing = motion;
  standing.x_t1 = motion.x_t0;
  detail::StepValidator validator(make_brute_force());
  detail::FreshPairs pairs;
  const SurfaceView cloth{motion.x_t0.first(motion.particles), motion.x_t0.first(motion.particles),
                          motion.cloth_edges, motion.cloth_triangles};
  const SurfaceView bodies{motion.x_t0.subspan(motion.particles),
                           motion.x_t0.subspan(motion.particles), motion.body_edges,
                           motion.body_triangles};
  std::vector<ContactPoint> missed;
  const auto look = [&](const CandidatePairs& of, const SurfaceView& other, bool self, bool count) {
    std::vector<Contact> found;
    find_separations(cloth, other, of, found);
    const auto n = static_cast<std::int32_t>(motion.particles);
    for (const Contact& contact : found) {
      ContactPoint c{.vertex = {}, .weight = {}, .normal = Vec3::Zero(), .kind = contact.kind};
      std::array<Vec3, 4> x;
      for (int k = 0; k < 4; ++k) {
        const bool point = contact.kind == ContactKind::triangle_point;
        const int first = contact.kind == ContactKind::edge_edge ? 2 : 1;
        c.vertex[k] = contact.vertex[k] + (!self && (k >= first) != point ? n : 0);
        x[k] = motion.x_t0[c.vertex[k]];
      }
      const double distance = c.kind == ContactKind::edge_edge
                                  ? edge_edge_closest(x[0], x[1], x[2], x[3]).distance
                                  : point_triangle_closest(x[0], x[1], x[2], x[3]).distance;
      if (distance >= reach * stage.thickness(c)) continue;
      if (count)
        ++near;
      else
        missed.push_back(c);
    }
  };
  for (const bool count : {true, false}) {
    validator.find_pairs(standing, reach * kMargin, pairs);
    if (!count) detail::remove_candidates(motion, pairs);
    look(pairs.body, bodies, false, count);
    look(pairs.self, cloth, true, count);
  }
  return missed;
}

/// Axes of the world; a quarter between two of them; the diagonal of all three; any.
std::vector<Mat3> frames() {
  // Eigen's FromTwoVectors would compile a singular value decomposition.
  const auto to = [](const Vec3& normal) {
    const Vec3 axis = Vec3::UnitZ().cross(normal);
    return Eigen::AngleAxisd(std::atan2(axis.norm(), normal.z()), axis.normalized())
        .toRotationMatrix();
  };
  return {Mat3::Identity(), to(Vec3(0, 1, 1)), to(Vec3(1, 1, 1)), to(Vec3(1, -0.4, 0.7))};
}

struct Tally {
  std::size_t collisions = 0, near = 0, excluded = 0, needed_margin = 0;
  std::size_t on_the_way = 0, renewed = 0;  // motions, and those that need new candidates
};

/// `on_the_way`: also moves the cloth by several margins, and then ends it anywhere on its way.
void try_motion(Stage& stage, int step, Target target, bool exclude, bool on_the_way,
                Tally& tally) {
  const double sides = target == Target::piece ? 2.0 : 1.0;
  // Half of the motions start within reach of a contact, the others anywhere up to the margin.
  const double most = step % 2 == 0 ? kPointReach * kMargin : 1.02 * sides * stage.reach();
  Vec3 way = Vec3::Zero();
  if (on_the_way)
    for (int k = 0; k < 3; ++k) way[k] = stage.uniform(-4.0, 4.0) * kMargin;
  stage.begin(step, target, stage.uniform(0.0, most), step % 3 == 0 ? 0.0 : 0.1 * kMargin, way);
  detail::ExcludedPairs excluded;
  if (exclude) {
    const JointSurface joint = stage.detection().joint_surface();
    Tangle tangle;
    for (std::int32_t t = 0; t < 36; ++t) tangle.side[0].push_back(t);  // half of the first piece
    for (auto t = 72; t < static_cast<std::int32_t>(joint.triangles().size()); ++t)
      tangle.side[1].push_back(t);
    excluded = detail::ExcludedPairs(joint);
    excluded.add(joint, tangle.side);
    stage.detection().set_excluded(&excluded);
    stage.detection().find_candidates();
  }
  const auto missed_near = near_but_missed(stage, stage.motion(), kPointReach, tally.near);
  EXPECT_TRUE(missed_near.empty()) << missed_near.size() << " near pairs are no candidates";
  detail::StepValidator brute(make_brute_force());
  detail::FreshPairs predicted;
  detail::SearchedMotion standing = stage.motion();
  standing.x_t1 = standing.x_t0;
  brute.find_pairs(standing, 0.25 * kMargin, predicted);
  std::vector<ContactPoint> near;
  stage.detection().find_proximities(near);  // gives certificates at the first end
  if (on_the_way) {
    stage.go_to_the_edge_of_the_way();
    if (stage.detection().renew_candidates()) ++tally.renewed;
    ++tally.on_the_way;
  } else {
    stage.go_to_the_edge();
  }
  ASSERT_TRUE(stage.detection().candidates_cover());
  std::vector<ContactPoint> found;
  stage.detection().find_collisions(found);
  const detail::SearchedMotion motion = stage.motion();
  const auto all = brute.collisions(motion);
  EXPECT_EQ(keys(found), keys(all)) << found.size() << " found, " << all.size() << " there are";
  EXPECT_TRUE(brute.missed(motion).empty());
  EXPECT_TRUE(detail::StepValidator("bvh_aabb").missed(motion).empty());
  tally.collisions += all.size();
  // How many start farther apart than half of a margin.
  detail::SearchedMotion halved = motion;
  halved.body_pairs = &predicted.body;
  halved.self_pairs = &predicted.self;
  tally.needed_margin += brute.missed(halved).size();
  if (!exclude) return;
  detail::SearchedMotion with_excluded = motion;
  with_excluded.excluded = nullptr;
  tally.excluded += brute.collisions(with_excluded).size() - all.size();
  stage.detection().set_excluded(nullptr);
}

class Composer : public ::testing::TestWithParam<const char*> {};

TEST_P(Composer, FindsWhatAFreshSearchFindsAtTheEdgeOfEveryMargin) {
  unsigned seed = 1;
  Tally tally;
  for (const Mat3& frame : frames())
    for (const bool with_loose : {false, true}) {
      Stage stage(GetParam(), frame, with_loose, seed++);
      for (int step = 0; step < 8; ++step)
        for (const Target target :
             {Target::piece, Target::resting, Target::rigid, Target::deforming}) {
          SCOPED_TRACE(::testing::Message() << "seed " << seed - 1 << ", step " << step
                                            << ", target " << static_cast<int>(target));
          for (const bool on_the_way : {false, true}) {
            ASSERT_NO_FATAL_FAILURE(
                try_motion(stage, step, target, step % 4 == 3, on_the_way, tally));
            if (HasFailure()) return;
          }
        }
    }
  EXPECT_GT(tally.collisions, 10000u);
  EXPECT_GT(tally.needed_margin, 1000u);
  EXPECT_GT(tally.near, 10000u);
  EXPECT_GT(tally.excluded, 100u);
  EXPECT_GT(tally.on_the_way, 200u);
  // Boxes cover many ends on the way; this stage has a body that bvh_aabb searches in its own
  // frame.
  const std::string name = GetParam();
  if (name == "verlet_bvh" || name == "sweep_and_prune") {
    EXPECT_LT(tally.renewed, 200u);
  }
}

INSTANTIATE_TEST_SUITE_P(Detectors, Composer,
                         ::testing::Values("bvh_aabb", "verlet_bvh", "sweep_and_prune",
                                           "bvh_kdop18", "bvh_obb", "curvature_cone"),
                         [](const auto& info) { return std::string(info.param); });

TEST(Margins, AnEndBeyondTheMarginNeedsNewCandidates) {
  Stage stage("bvh_aabb", Mat3::Identity(), false, 1);
  stage.begin(0, Target::resting, kMargin, 0.0);
  EXPECT_TRUE(stage.detection().candidates_cover());
  for (int k = 0; k < 3; ++k)
    for (const double side : {-1.0, 1.0}) {
      const Vec3 before = stage.x_t1()[7];
      stage.x_t1()[7][k] += 0.9999 * side * kMargin;
      EXPECT_TRUE(stage.detection().candidates_cover());
      stage.x_t1()[7][k] = before[k] + 1.0001 * side * kMargin;
      EXPECT_FALSE(stage.detection().candidates_cover());
      stage.x_t1()[7] = before;
    }
}

TEST(Margins, AnEndOnTheSearchedPathNeedsNoNewCandidatesWithBoxes) {
  for (const char* name : {"sweep_and_prune", "bvh_kdop18", "bvh_aabb"})
    for (const Target target : {Target::resting, Target::rigid}) {
      SCOPED_TRACE(::testing::Message() << name << ", " << static_cast<int>(target));
      // Of these, only bvh_aabb searches the rigid body of the stage in the frame of that body.
      const bool boxes = std::string(name) == "sweep_and_prune";
      Stage stage(name, Mat3::Identity(), false, 1);
      stage.begin(0, target, kMargin, 0.0, Vec3(0.0, 0.0, -4.0 * kMargin));
      const auto end_above_the_start = [&](double margins) {
        for (std::size_t i = 0; i < 49; ++i)  // the first piece
          stage.x_t1()[i].z() = stage.x_t0()[i].z() + margins * kMargin;
      };
      end_above_the_start(0.9999);
      EXPECT_EQ(stage.detection().candidates_cover(), boxes);
      end_above_the_start(1.0001);
      EXPECT_FALSE(stage.detection().candidates_cover());
      EXPECT_TRUE(stage.detection().renew_candidates());
      EXPECT_TRUE(stage.detection().candidates_cover());
      EXPECT_FALSE(stage.detection().renew_candidates());
    }
}

TEST(Margins, WhatIsProvedIdleHasNothingNear) {
  std::size_t idle = 0, busy = 0, near = 0;
  for (int step = 0; step < 60; ++step)
    for (const Target target : {Target::piece, Target::resting}) {
      // A new stage each time: a proof that failed is not tried again at once.
      Stage stage("bvh_aabb", Mat3::Identity(), false, static_cast<unsigned>(step));
      stage.set_drifts(false);  // boxes of two pieces overlap on a long way
      stage.begin(0, target, 0.15 * step * kMargin, 0.0);
      const detail::SearchedMotion motion = stage.motion();
      (motion.self_pairs == nullptr && motion.body_pairs == nullptr ? idle : busy) += 1;
      EXPECT_TRUE(near_but_missed(stage, motion, kPointReach, near).empty()) << step;
      stage.go_to_the_edge();
      std::vector<ContactPoint> found;
      stage.detection().find_collisions(found);
      EXPECT_TRUE(detail::StepValidator(make_brute_force()).missed(stage.motion()).empty()) << step;
    }
  EXPECT_GT(idle, 15u);
  EXPECT_GT(busy, 20u);
  EXPECT_GT(near, 1000u);
}

// -- what is a contact ----------------------------------------------------------------------------

/// One piece of cloth and one body that rests, where their vertices say.
class Scenery {
 public:
  static constexpr double kThickness = 0.002;

  Scenery(TriangleMesh cloth, TriangleMesh obstacle) {
    scene_.name = "scenery";
    scene_.materials["default"] = Material{};
    scene_.contact.rest_gap = kThickness;
    scene_.cloths = {piece("cloth", std::move(cloth))};
    if (!obstacle.triangles.empty()) scene_.bodies = {body("body", std::move(obstacle))};
    built_ = std::make_unique<BuiltScene>(build_scene(scene_));
    detection_ = std::make_unique<detail::Detection>(scene_, *built_, Methods{}, clock_);
    x_t0_ = built_->cloth.surface.vertices;
    n_ = x_t0_.size();
    x_t0_.resize(n_ + detection_->body_vertices());
    if (!built_->bodies.empty()) built_->bodies[0]->positions(0.0, std::span(x_t0_).subspan(n_));
  }

  /// Contacts where the cloth moves by `step`.
  std::vector<ContactPoint> contacts(const Vec3& step = Vec3::Zero()) {
    x_t1_ = x_t0_;
    for (std::size_t i = 0; i < n_; ++i) x_t1_[i] += step;
    detection_->set_motion(x_t0_, x_t1_, false);
    detection_->find_candidates();
    std::vector<ContactPoint> out;
    detection_->find_proximities(out);
    return out;
  }
  detail::Detection& detection() { return *detection_; }
  detail::SearchedMotion motion() const { return detection_->searched(); }
  std::vector<Vec3>& ends() { return x_t1_; }

 private:
  Scene scene_;
  std::unique_ptr<BuiltScene> built_;
  detail::PhaseClock clock_;
  std::unique_ptr<detail::Detection> detection_;
  std::vector<Vec3> x_t0_, x_t1_;
  std::size_t n_ = 0;
};

TriangleMesh moved(TriangleMesh mesh, const Vec3& by) {
  for (Vec3& x : mesh.vertices) x += by;
  return mesh;
}

std::size_t count(const std::vector<ContactPoint>& contacts, ContactKind kind) {
  return static_cast<std::size_t>(std::count_if(contacts.begin(), contacts.end(),
                                                [&](const auto& c) { return c.kind == kind; }));
}

TEST(Contacts, APointTakesPartFromOneAndAHalfRestGapsOn) {
  const double t = Scenery::kThickness;
  for (const double gap : {0.3, 0.7, 1.0, 1.4, 1.49, 1.51, 2.0, 3.0}) {
    Scenery scenery(moved(sheet(2, 0.1), {0.003, 0.001, gap * t}), sheet(1, 1.0));
    const auto contacts = scenery.contacts();
    EXPECT_EQ(count(contacts, ContactKind::point_triangle), gap < 1.5 ? 9u : 0u) << gap;
    for (const ContactPoint& c : contacts)
      if (c.kind == ContactKind::point_triangle) {
        EXPECT_NEAR(c.rest_gap, t, 1e-15);
      }
  }
}

/// A sheet and a smaller one at `gap` above it, as one piece of cloth.
TriangleMesh two_layers(double gap) {
  TriangleMesh layers = sheet(1, 0.1);
  const TriangleMesh upper = moved(sheet(1, 0.05), {0.01, 0.002, gap});
  for (const Vec3& x : upper.vertices) layers.vertices.push_back(x);
  for (const Triangle& f : upper.triangles)
    layers.triangles.push_back({f[0] + 4, f[1] + 4, f[2] + 4});
  return layers;
}

TEST(Contacts, SoDoPointsOfTheClothItself) {
  const double t = Scenery::kThickness;
  for (const double gap : {0.3, 1.2, 1.4, 1.49, 1.51, 3.0}) {
    Scenery scenery(two_layers(gap * t), {});
    EXPECT_EQ(count(scenery.contacts(), ContactKind::point_triangle),
              gap < 1.5 * std::min(1.0, 0.9 * gap) ? 4u : 0u)
        << gap;
  }
}

TEST(Contacts, OneThatApproachesTakesPartFromFourRestGapsOn) {
  const double t = Scenery::kThickness;
  for (const double gap : {2.0, 3.0, 3.9, 4.1, 5.0}) {
    Scenery scenery(moved(sheet(2, 0.1), {0.003, 0.001, gap * t}), sheet(1, 1.0));
    const auto contacts = scenery.contacts({0.0, 0.0, (1.2 - gap) * t});
    EXPECT_EQ(count(contacts, ContactKind::point_triangle), gap < 4.0 ? 9u : 0u) << gap;
  }
}

TEST(Contacts, BodyVerticesTakePartFromElevenTwentiethsOfTheRestGap) {
  const double t = Scenery::kThickness;
  TriangleMesh spike;
  spike.vertices = {{0, 0, 0}, {0.01, 0, -0.1}, {-0.01, 0.01, -0.1}, {-0.01, -0.01, -0.1}};
  spike.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
  for (const double gap : {0.2, 0.3, 0.5, 0.54, 0.56, 0.8, 1.2}) {
    Scenery scenery(moved(sheet(1, 0.1), {0.02, 0.007, gap * t}), spike);
    const auto contacts = scenery.contacts();
    EXPECT_EQ(count(contacts, ContactKind::triangle_point), gap < 0.55 ? 1u : 0u) << gap;
    for (const ContactPoint& c : contacts)
      if (c.kind == ContactKind::triangle_point) {
        EXPECT_NEAR(c.rest_gap, 0.5 * t, 1e-15);
      }
  }
}

TEST(Contacts, LayersThatStartTooNearKeepNineTenthsOfTheirDistance) {
  const double t = Scenery::kThickness;
  Scenery scenery(two_layers(0.5 * t), {});
  const auto contacts = scenery.contacts();
  ASSERT_EQ(count(contacts, ContactKind::point_triangle), 4u);
  for (const ContactPoint& c : contacts)
    if (c.kind == ContactKind::point_triangle) {
      EXPECT_NEAR(c.rest_gap, 0.9 * 0.5 * t, 1e-12);
    }
}

TEST(Contacts, APointInAValleyIsHeldByBothFaces) {
  const double t = Scenery::kThickness;
  for (const double angle : {5.0, 15.0, 25.0, 50.0, 90.0}) {  // degrees between the faces
    const double half = 0.5 * angle * std::numbers::pi / 180.0;
    TriangleMesh valley;
    const double up = 0.1 * std::tan(half);
    valley.vertices = {{0, -0.1, 0}, {0, 0.1, 0}, {0.1, 0, up}, {-0.1, 0, up}};
    valley.triangles = {{0, 2, 1}, {0, 1, 3}};
    TriangleMesh point;  // whose lowest vertex is as near to both
    point.vertices = {{0, 0, t / std::cos(half)}, {0.001, 0.01, 0.2}, {-0.001, -0.01, 0.2}};
    point.triangles = {{0, 1, 2}};
    Scenery scenery(point, valley);
    const auto contacts = scenery.contacts();
    // cos 18.2 degrees = 0.95
    EXPECT_EQ(count(contacts, ContactKind::point_triangle), angle < 18.0 ? 1u : 2u) << angle;
  }
}

TEST(Contacts, ASlabAcrossTheImpactIsTakenIfItIsWideEnough) {
  const double t = Scenery::kThickness, size = 0.1;
  TriangleMesh plate;
  plate.vertices = {{-size, -size, 0}, {size, -size, 0}, {0, size, 0}};
  plate.triangles = {{0, 1, 2}};
  TriangleMesh point;
  point.vertices = {{0, 0, t}, {0.001, 0.01, 0.2}, {-0.001, -0.01, 0.2}};
  point.triangles = {{0, 1, 2}};
  Scenery scenery(point, plate);
  scenery.contacts();
  for (const double width : {0.03, 0.045, 0.06, 0.2}) {
    // Tilted by so much, the slab between the point and the plate is that many thicknesses wide.
    const double tilt = (1.0 - width) * t / size;
    ContactPoint hit{.vertex = {}, .weight = {}, .normal = Vec3::Zero()};
    hit.vertex = {0, 3, 4, 5};
    hit.normal = Vec3(-std::sin(tilt), 0.0, std::cos(tilt));
    std::vector<ContactPoint> out;
    scenery.detection().at_start(std::span(&hit, 1), out);
    EXPECT_EQ((out[0].normal - hit.normal).norm() < 1e-12, width > 0.05) << width;
  }
}

TEST(Contacts, ASheetThatWasProvedIdleAndFoldsIsSearchedAfterAll) {
  Scenery scenery(sheet(6, 0.2), {});
  scenery.contacts();
  ASSERT_EQ(scenery.motion().self_pairs, nullptr);
  // One half goes through the other.
  for (Vec3& x : scenery.ends())
    if (x.x() > 0.01) x = {-x.x(), x.y() + 0.003, -0.3 * x.x()};
  for (Vec3& x : scenery.ends())
    if (x.x() < -0.01 && x.z() == 0.0) x.z() = -0.05;
  ASSERT_TRUE(scenery.detection().candidates_cover());
  std::vector<ContactPoint> found;
  scenery.detection().find_collisions(found);
  const auto all = detail::StepValidator(make_brute_force()).collisions(scenery.motion());
  EXPECT_EQ(keys(found), keys(all));
  EXPECT_GT(all.size(), 10u);
}

TEST(Margins, ACommonDisplacementNeedsNoNewSelfPairs) {
  TriangleMesh two = sheet(6, 0.2);
  const auto n = static_cast<std::int32_t>(two.vertices.size());
  const TriangleMesh upper = sheet(6, 0.2, 0.001);
  for (const Vec3& x : upper.vertices) two.vertices.push_back(x);
  for (const Triangle& t : upper.triangles) two.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  Scenery scenery(two, {});
  scenery.contacts();
  ASSERT_NE(scenery.motion().self_pairs, nullptr);
  for (Vec3& x : scenery.ends()) x += Vec3(3.0, -1.0, 0.5);
  const std::vector<Vec3> shared = scenery.ends();
  EXPECT_TRUE(scenery.detection().candidates_cover());
  for (int k = 0; k < 3; ++k)
    for (const double share : {0.9999, 1.0001}) {
      scenery.ends()[3][k] += share * kSelfMargin * Scenery::kThickness;
      scenery.ends()[60][k] -= share * kSelfMargin * Scenery::kThickness;
      EXPECT_EQ(scenery.detection().candidates_cover(), share < 1.0);
      scenery.ends() = shared;
    }
}

TEST(Contacts, AFineSheetHasItsNearPairsAmongTheCandidates) {
  // The cells are so fine that a sheet which is proved to keep apart by less than the reach of a
  // contact would still have near pairs.
  const double t = Scenery::kThickness;
  for (const double nearest : {0.5, 0.8, 1.0, 1.2, 1.4, 1.6}) {
    const double cell = nearest * t * std::numbers::sqrt2;
    Scenery scenery(sheet(5, 5 * cell), {});
    scenery.contacts();
    EXPECT_EQ(scenery.motion().self_pairs == nullptr, nearest > 1.5) << nearest;
  }
}

ContactPoint point_on_face(const std::array<double, 3>& weight) {
  ContactPoint c;
  c.kind = ContactKind::point_triangle;
  c.vertex = {0, 1, 2, 3};
  c.weight = {1.0, -weight[0], -weight[1], -weight[2]};
  return c;
}

TEST(ContactFilter, SlopesBelowItsBoundsAreNoNearerNeighbours) {
  // A point above an edge, whose other triangle rises by `slope`.
  for (const double slope : {0.0, 0.8e-6, 1.2e-6, 0.1}) {
    const std::vector<Vec3> x = {{0, 0, 1}, {-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, slope}};
    const std::vector<Triangle> triangles = {{1, 2, 3}, {2, 1, 4}};
    const detail::ContactFilter filter(x.size(), triangles);
    EXPECT_EQ(filter.is_true_point_contact(point_on_face({0.5, 0.5, 0.0}), x), slope < 1e-6)
        << slope;
  }
  // Two edges that cross, one of which has a triangle that leans towards the other.
  for (const double slope : {0.0, 0.06, 0.09, 0.11, 0.3}) {
    const std::vector<Vec3> x = {{-1, 0, 1}, {1, 0, 1}, {0, 1, 1 - slope},
                                 {0, -1, 0}, {0, 1, 0}, {1, 0, 0}};
    const std::vector<Triangle> triangles = {{0, 1, 2}, {3, 4, 5}};
    ContactPoint c;
    c.kind = ContactKind::edge_edge;
    c.vertex = {0, 1, 3, 4};
    c.weight = {0.5, 0.5, -0.5, -0.5};
    EXPECT_EQ(detail::ContactFilter(x.size(), triangles).is_true_edge_contact(c, x), slope < 0.1)
        << slope;
  }
}

TEST(ContactFilter, AWeightBelowItsBoundIsOnTheBorder) {
  const std::vector<Vec3> x = {{0, 0, 1}, {-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0.1}};
  const std::vector<Triangle> triangles = {{1, 2, 3}, {2, 1, 4}};
  const detail::ContactFilter filter(x.size(), triangles);
  for (const double weight : {0.0, 0.7e-9, 1.3e-9, 1e-3})
    EXPECT_EQ(filter.is_true_point_contact(point_on_face({0.5, 0.5 - weight, weight}), x),
              weight > 1e-9)
        << weight;
}

}  // namespace
}  // namespace selvedge::composer_test
