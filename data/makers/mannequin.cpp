// SPDX-License-Identifier: MIT
#include <selvedge/bodies/mesh_report.h>
#include <selvedge/data/makers/detail/implicit_surface.h>
#include <selvedge/data/makers/detail/mannequin_bones.h>
#include <selvedge/data/makers/mannequin.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace selvedge {

namespace {

constexpr double kModelledHeight = 1.7;  // m; all dimensions below refer to this height

// Position of a limb segment: its joint, and the rotation of its axes relative to the standing
// figure.
struct Frame {
  Mat3 rotation = Mat3::Identity();
  Vec3 origin = Vec3::Zero();

  Vec3 to_world(const Vec3& x) const { return rotation * x + origin; }
  Vec3 to_local(const Vec3& x) const { return rotation.transpose() * (x - origin); }
  Frame child(const Vec3& joint, const Mat3& turn) const {
    return {rotation * turn, to_world(joint)};
  }
};

Mat3 turn_about(const Vec3& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

// A sphere of radius r0 at a whose radius changes linearly to r1 at b, stretched about a by
// `stretch`. If a = b: an ellipsoid with the radii r0·stretch.
struct Part {
  Frame frame;
  Vec3 a, b;
  double r0, r1;
  Vec3 stretch;
  double blend;           // m, width of the blend with the preceding parts
  std::size_t bone;       // the bone it moves with
  bool has_sole = false;  // clipped below the local plane z = sole
  double sole = 0.0;
};

// Signed distance to the hull of two spheres: in the half-plane of axis distance and height along
// ab, the outline is two arcs and their common tangent.
double round_cone_distance(const Vec3& p, const Part& part) {
  const Vec3 axis = part.b - part.a, x = p - part.a;
  const double length = axis.norm();
  if (length <= std::abs(part.r0 - part.r1)) return x.norm() - std::max(part.r0, part.r1);
  const double along = x.dot(axis) / length;
  const double across = std::sqrt(std::max(0.0, x.squaredNorm() - along * along));
  const double sine = (part.r0 - part.r1) / length, cosine = std::sqrt(1.0 - sine * sine);
  const double foot = along * cosine - across * sine;  // along the tangent line
  if (foot < 0.0) return std::hypot(along, across) - part.r0;
  if (foot > length * cosine) return std::hypot(along - length, across) - part.r1;
  return across * cosine + along * sine - part.r0;
}

// Minimum of both, rounded over the width k: [Quilez2013] polynomial smooth minimum.
double smooth_min(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - 0.25 * h * h * k;
}

double distance_to(const Part& part, const Vec3& x) {
  const Vec3 local = part.frame.to_local(x);
  const Vec3 p = part.a + (local - part.a).cwiseQuotient(part.stretch);
  double distance = 0.0;
  if (part.a == part.b) {
    // First-order distance to an ellipsoid: f/|∇f| with f = |q| - 1, exact on the surface.
    const Vec3 radii = part.r0 * part.stretch, y = local - part.a;
    const double f = y.cwiseQuotient(radii).norm();
    const double slope = y.cwiseQuotient(radii.cwiseProduct(radii)).norm();
    distance = slope > 0.0 ? f * (f - 1.0) / slope : -radii.minCoeff();
  } else {
    distance = round_cone_distance(p, part) * part.stretch.minCoeff();
  }
  constexpr double sole_rounding = 0.012;  // m
  if (part.has_sole) distance = -smooth_min(-distance, local.z() - part.sole, sole_rounding);
  return distance;
}

class Figure {
 public:
  explicit Figure(const MannequinConfig& config) {
    add_trunk();
    add_leg(config.left, 1.0);
    add_leg(config.right, -1.0);
    add_arm(config.left, 1.0);
    add_arm(config.right, -1.0);
    bound();
  }

  double operator()(const Vec3& x) const {
    double distance = distance_to(parts_[0], x);
    for (std::size_t i = 1; i < parts_.size(); ++i)
      if (least_distance(balls_[i], x) < distance + parts_[i].blend)
        distance = smooth_min(distance, distance_to(parts_[i], x), parts_[i].blend);
    return distance;
  }
  const std::vector<Frame>& bones() const { return bones_; }
  /// Distance to each bone, that of its nearest part.
  std::vector<double> bone_distances(const Vec3& x) const {
    std::vector<double> distance(bones_.size(), std::numeric_limits<double>::infinity());
    for (const Part& part : parts_)
      distance[part.bone] = std::min(distance[part.bone], distance_to(part, x));
    return distance;
  }
  const Vec3& lower() const { return lower_; }
  const Vec3& upper() const { return upper_; }

 private:
  void add_cone(const Frame& frame, const Vec3& a, const Vec3& b, double r0, double r1,
                double blend, const Vec3& stretch = Vec3::Ones()) {
    parts_.push_back({frame, a, b, r0, r1, stretch, blend, bones_.size() - 1});
  }
  void add_ellipsoid(const Frame& frame, const Vec3& centre, const Vec3& radii, double blend) {
    parts_.push_back({frame, centre, centre, 1.0, 1.0, radii, blend, bones_.size() - 1});
  }

  void add_trunk() {
    const Frame world;
    bones_.push_back(world);
    add_ellipsoid(world, {0.0, 0.005, 1.225}, {0.138, 0.098, 0.165}, 0.0);  // rib cage
    add_cone(world, {0.0, 0.005, 1.16}, {0.0, 0.005, 0.98}, 0.098, 0.105, 0.06, {1.12, 0.84, 1.0});
    add_ellipsoid(world, {0.0, 0.008, 0.905}, {0.165, 0.112, 0.115}, 0.08);  // pelvis
    for (const double side : {-1.0, 1.0}) {
      add_ellipsoid(world, {0.068 * side, 0.058, 0.865}, {0.082, 0.07, 0.085}, 0.05);   // seat
      add_ellipsoid(world, {0.066 * side, -0.068, 1.245}, {0.062, 0.045, 0.06}, 0.05);  // breast
      add_cone(world, {0.035 * side, 0.012, 1.415}, {0.155 * side, 0.012, 1.372}, 0.046, 0.05,
               0.05);
    }
    add_cone(world, {0.0, 0.014, 1.40}, {0.0, -0.004, 1.53}, 0.054, 0.049, 0.05);     // neck
    add_ellipsoid(world, {0.0, -0.006, 1.605}, {0.073, 0.09, 0.096}, 0.03);           // skull
    add_cone(world, {0.0, -0.03, 1.56}, {0.0, -0.052, 1.522}, 0.055, 0.032, 0.04);    // jaw
    add_cone(world, {0.0, -0.093, 1.60}, {0.0, -0.103, 1.572}, 0.009, 0.013, 0.025);  // nose
  }

  void add_leg(const LimbPose& pose, double side) {
    const Frame thigh = Frame().child({0.088 * side, 0.008, 0.885},
                                      turn_about(Vec3::UnitY(), -side * pose.hip_out) *
                                          turn_about(Vec3::UnitX(), -pose.hip_swing));
    bones_.push_back(thigh);
    const Vec3 knee(0.0, -0.004, -0.415), ankle(0.0, 0.018, -0.385);
    add_cone(thigh, {-0.004 * side, 0.0, -0.06}, knee, 0.086, 0.053, 0.05);
    const Frame shank = thigh.child(knee, turn_about(Vec3::UnitX(), pose.knee));
    bones_.push_back(shank);
    add_cone(shank, Vec3::Zero(), ankle, 0.051, 0.034, 0.03);
    add_ellipsoid(shank, {0.0, 0.022, -0.125}, {0.05, 0.047, 0.12}, 0.04);  // calf
    // The foot stays flat although the leg is rotated outward.
    const Frame foot = shank.child(ankle, turn_about(Vec3::UnitY(), side * pose.hip_out) *
                                              turn_about(Vec3::UnitZ(), side * 0.12));
    bones_.push_back(foot);
    add_foot(foot);
  }

  void add_foot(const Frame& foot) {
    const double sole = -0.078;
    add_cone(foot, {0.0, 0.032, sole + 0.03}, {0.0, -0.03, sole + 0.045}, 0.037, 0.042, 0.03);
    parts_.back().has_sole = true, parts_.back().sole = sole;
    add_cone(foot, {0.0, -0.03, sole + 0.035}, {0.0, -0.158, sole + 0.016}, 0.038, 0.025, 0.03,
             {1.25, 1.0, 1.0});
    parts_.back().has_sole = true, parts_.back().sole = sole;
  }

  void add_arm(const LimbPose& pose, double side) {
    const Frame upper = Frame().child({0.17 * side, 0.012, 1.365},
                                      turn_about(Vec3::UnitY(), -side * pose.shoulder_out) *
                                          turn_about(Vec3::UnitX(), -pose.shoulder_swing));
    bones_.push_back(upper);
    const Vec3 elbow(0.0, 0.0, -0.295), wrist(0.0, 0.0, -0.245);
    add_ellipsoid(upper, {0.004 * side, 0.0, -0.03}, {0.053, 0.057, 0.075}, 0.05);  // shoulder
    add_cone(upper, {0.0, 0.0, -0.03}, elbow, 0.046, 0.037, 0.035);
    const Frame forearm = upper.child(elbow, turn_about(Vec3::UnitX(), -pose.elbow));
    bones_.push_back(forearm);
    add_cone(forearm, Vec3::Zero(), wrist, 0.037, 0.026, 0.02);
    add_ellipsoid(forearm, {0.0, 0.0, -0.075}, {0.041, 0.043, 0.085}, 0.03);
    add_hand(forearm.child(wrist, turn_about(Vec3::UnitX(), -0.1)));
  }

  // A mitten: palm and fingers as one part, and the thumb in front.
  void add_hand(const Frame& hand) {
    add_ellipsoid(hand, {0.0, 0.0, -0.055}, {0.021, 0.041, 0.06}, 0.03);
    add_cone(hand, {0.0, 0.0, -0.09}, {0.0, -0.004, -0.155}, 0.017, 0.0125, 0.025, {1.0, 2.1, 1.0});
    add_cone(hand, {0.0, -0.028, -0.035}, {0.0, -0.056, -0.085}, 0.016, 0.0125, 0.015);
  }

  // A bounding ball of a part. Because of the stretch, distance_to is smaller than the distance by
  // at most `factor`.
  struct Ball {
    Vec3 centre;
    double radius, factor;
  };

  static double least_distance(const Ball& ball, const Vec3& x) {
    return ball.factor * ((x - ball.centre).norm() - ball.radius);
  }

  static Ball ball_around(const Part& part) {
    const double most = part.stretch.maxCoeff();
    const double radius = most * (0.5 * (part.b - part.a).norm() + std::max(part.r0, part.r1));
    const Vec3 middle = part.a + 0.5 * (part.b - part.a).cwiseProduct(part.stretch);
    return {part.frame.to_world(middle), radius, part.stretch.minCoeff() / most};
  }

  void bound() {
    for (const Part& part : parts_) balls_.push_back(ball_around(part));
    lower_.setConstant(std::numeric_limits<double>::infinity());
    upper_ = -lower_;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const Vec3 reach = Vec3::Constant(balls_[i].radius + parts_[i].blend);
      lower_ = lower_.cwiseMin(balls_[i].centre - reach);
      upper_ = upper_.cwiseMax(balls_[i].centre + reach);
    }
  }

  std::vector<Frame> bones_;  // in the order of detail::MannequinBone
  std::vector<Part> parts_;
  std::vector<Ball> balls_;
  Vec3 lower_, upper_;
};

void check_range(double value, double least, double most, const char* field) {
  if (!(value >= least && value <= most))
    throw std::invalid_argument(std::string("mannequin: ") + field + " is " +
                                std::to_string(value) + ", but must lie between " +
                                std::to_string(least) + " and " + std::to_string(most));
}

void check_pose(const LimbPose& pose) {
  check_range(pose.shoulder_out, 0.2, 1.5, "shoulder_out");
  check_range(pose.shoulder_swing, -1.0, 1.5, "shoulder_swing");
  check_range(pose.elbow, 0.0, 1.8, "elbow");
  check_range(pose.hip_out, 0.05, 0.6, "hip_out");
  check_range(pose.hip_swing, -0.5, 1.2, "hip_swing");
  check_range(pose.knee, 0.0, 1.6, "knee");
}

void check_config(const MannequinConfig& config) {
  check_range(config.height, 0.1, 10.0, "height");
  check_range(config.faces, 5000, 30000, "faces");
  check_pose(config.left);
  check_pose(config.right);
}

bool is_clean(const TriangleMesh& mesh) {
  const MeshReport report = report_mesh(mesh);
  return report.sentences().empty() && report.components == 1;
}

// Fine enough for the hands and for more faces than the largest target.
constexpr double kGridCell = 0.0125;  // m

TriangleMesh mesh_figure(const Figure& figure, int faces, double offset) {
  detail::ImplicitSurfaceConfig surface;
  surface.cell = kGridCell;
  surface.lower = figure.lower() - Vec3::Constant((1.0 + offset) * kGridCell);
  surface.upper = figure.upper() + Vec3::Constant(2.0 * kGridCell);
  surface.faces = faces;
  return detail::mesh_implicit_surface(figure, surface);
}

}  // namespace

void detail::stand(std::vector<Vec3>& x, double height) {
  double floor = std::numeric_limits<double>::infinity();
  for (const Vec3& p : x) floor = std::min(floor, p.z());
  for (Vec3& p : x) p = height / kModelledHeight * (p - floor * Vec3::UnitZ());
}

TriangleMesh detail::mannequin_surface(const MannequinConfig& config) {
  check_config(config);
  const Figure figure(config);
  // If two folds come closer than a cell, shifting the grid can separate them.
  constexpr int attempts = 8;
  for (int attempt = 0; attempt < attempts; ++attempt) {
    TriangleMesh mesh = mesh_figure(figure, config.faces, static_cast<double>(attempt) / attempts);
    if (is_clean(mesh)) return mesh;
  }
  throw std::runtime_error("mannequin: found no surface without self-intersections of " +
                           std::to_string(config.faces) + " faces for this pose; use more faces");
}

std::vector<detail::BoneFrame> detail::mannequin_bones(const MannequinConfig& config) {
  check_config(config);
  std::vector<BoneFrame> bones;
  const Figure figure(config);
  for (const Frame& frame : figure.bones()) bones.push_back({frame.rotation, frame.origin});
  return bones;
}

std::vector<std::vector<double>> detail::bone_distances(const MannequinConfig& config,
                                                        const std::vector<Vec3>& x) {
  const Figure figure(config);
  std::vector<std::vector<double>> distances;
  distances.reserve(x.size());
  for (const Vec3& p : x) distances.push_back(figure.bone_distances(p));
  return distances;
}

TriangleMesh make_mannequin(const MannequinConfig& config) {
  TriangleMesh mesh = detail::mannequin_surface(config);
  detail::stand(mesh.vertices, config.height);
  return mesh;
}

}  // namespace selvedge
