// SPDX-License-Identifier: MIT
//
// Rigid bodies as affine ones: all vertices follow four particles, whose springs leave only rigid
// motions [L. Lan, D. M. Kaufman, M. Li, C. Jiang, Y. Yang, "Affine body dynamics", 2022, with
// springs in place of their potential]. The paths of the vertices within a step are straight lines
// and one affine motion, so that collision with them is exact; contacts and friction act on the
// four particles in the same solve as on the cloth.
#include <fmt/format.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/scene/detail/solid.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

namespace selvedge {
namespace {

// The share of the mass that lies at the vertices of the surface; the leaders have the rest. It
// only keeps each particle's mass positive.
constexpr double kAtVertices = 0.01;

// A radius of gyration of at least this share of the largest one keeps the leaders apart.
constexpr double kThinnest = 1e-3;

// A centre of mass nearer to the hinge than this share of the radius of gyration about it shows no
// direction.
constexpr double kOffAxis = 1e-3;

// Degrees; the limits of a hinge stay apart by a quarter turn behind.
constexpr double kMostTurn = 270.0;

struct MassPoints {
  double volume = 0.0;
  Vec3 centre = Vec3::Zero();
  Mat3 second = Mat3::Zero();  // ∫ (x - centre)(x - centre)ᵀ over the volume, by the volume
};

// Over the signed tetrahedra from the mean of the vertices.
MassPoints mass_points(const TriangleMesh& mesh) {
  Vec3 origin = Vec3::Zero();
  for (const Vec3& x : mesh.vertices) origin += x / static_cast<double>(mesh.vertices.size());
  MassPoints m;
  Vec3 first = Vec3::Zero();
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - origin, b = mesh.vertices[t[1]] - origin,
               c = mesh.vertices[t[2]] - origin, sum = a + b + c;
    const double volume = a.dot(b.cross(c)) / 6.0;
    m.volume += volume;
    first += volume / 4.0 * sum;
    m.second += volume / 20.0 *
                (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  if (!(m.volume > 0.0)) return m;
  const Vec3 off = first / m.volume;
  m.centre = origin + off;
  m.second = m.second / m.volume - off * off.transpose();
  return m;
}

void refuse_open(const TriangleMesh& mesh) {
  std::map<Edge, int> balance;
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = t[k], b = t[(k + 1) % 3];
      balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  if (std::ranges::any_of(balance, [](const auto& side) { return side.second != 0; }))
    throw std::invalid_argument(
        "a body with \"mass\" needs a closed surface; close its holes, or leave \"mass\" out");
}

std::vector<double> area_shares(const TriangleMesh& mesh) {
  std::vector<double> shares(mesh.vertices.size(), 0.0);
  double all = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[t[0]];
    const double area = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
    for (const std::int32_t v : t) shares[v] += area;
    all += 3.0 * area;
  }
  for (double& share : shares) share /= all;
  return shares;
}

// The corners of the box and the weights by which a point follows them.
struct Box4 {
  static constexpr std::array<std::array<double, 3>, 4> kSigns{
      {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}};
  Vec3 centre, half;
  Mat3 axes;

  Vec3 corner(int k) const {
    return centre + axes * half.cwiseProduct(Vec3(kSigns[k][0], kSigns[k][1], kSigns[k][2]));
  }
  std::array<double, 4> weights(const Vec3& x) const {
    const Vec3 at = (axes.transpose() * (x - centre)).cwiseQuotient(half);
    std::array<double, 4> weight{};
    for (int k = 0; k < 4; ++k)
      weight[k] = 0.25 * (1.0 + at.dot(Vec3(kSigns[k][0], kSigns[k][1], kSigns[k][2])));
    return weight;
  }
};

Box4 box_of(const MassPoints& m) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(m.second);
  const double largest = std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
  Box4 box{.centre = m.centre, .half = {}, .axes = solver.eigenvectors()};
  for (int k = 0; k < 3; ++k)
    box.half[k] = std::max(std::sqrt(std::max(0.0, solver.eigenvalues()[k])), kThinnest * largest);
  return box;
}

// A point that follows leaders at the corners of a box.
BuiltSolid::Point following_point(const Vec3& x, std::span<const Vec3> leaders) {
  Box4 box{.centre = Vec3::Zero(), .half = Vec3::Ones(), .axes = Mat3::Zero()};
  for (const Vec3& leader : leaders) box.centre += 0.25 * leader;
  for (int k = 0; k < 4; ++k)
    box.axes += 0.25 * (leaders[k] - box.centre) *
                Vec3(Box4::kSigns[k][0], Box4::kSigns[k][1], Box4::kSigns[k][2]).transpose();
  BuiltSolid::Point point{.start = x};
  const Vec3 at = box.axes.inverse() * (x - box.centre);
  for (int k = 0; k < 4; ++k)
    point.weight[k] =
        0.25 * (1.0 + at.dot(Vec3(Box4::kSigns[k][0], Box4::kSigns[k][1], Box4::kSigns[k][2])));
  return point;
}

void check_joint(const SolidSpec& solid) {
  const auto fail = [](const char* words) { throw std::invalid_argument(words); };
  if (solid.slides() && solid.turns())
    fail("a body has both \"slide\" and \"hinge\"; leave one out");
  if ((solid.has_limits() || solid.damping != 0.0) && !solid.slides() && !solid.turns())
    fail("\"limits\" and \"damping\" need \"slide\" or \"hinge\" beside them");
  if (!(solid.limits[0] <= 0.0 && solid.limits[1] >= 0.0))
    fail("\"limits\" count from the start: the first is at most 0, the second at least 0");
  if (solid.turns() && solid.limits[1] - solid.limits[0] > kMostTurn)
    fail("the \"limits\" of a hinge are at most 270 degrees apart");
  if (!(solid.damping >= 0.0)) fail("\"damping\" is at least 0");
}

}  // namespace

const SolidSpec* solid_of(const ClothSpec& cloth) {
  const auto* file = std::get_if<ClothFile>(&cloth.shape);
  return file != nullptr && file->solid ? &*file->solid : nullptr;
}

namespace detail {

ClothMesh make_solid(const TriangleMesh& surface, const SolidSpec& solid) {
  refuse_open(surface);
  check_joint(solid);
  const MassPoints points = mass_points(surface);
  if (!(points.volume > 0.0))
    throw std::invalid_argument(
        "a body with \"mass\" needs a surface whose triangles face outwards; turn them around");
  const Box4 box = box_of(points);
  const auto first = static_cast<std::int32_t>(surface.vertices.size());
  constexpr std::int32_t leaders = 4;
  ClothMesh cloth;
  cloth.surface = surface;
  cloth.edges = unique_edges(surface.triangles);
  std::vector<double> own(leaders, solid.mass / leaders);
  const std::vector<double> shares = area_shares(surface);
  for (std::int32_t i = 0; i < first; ++i) {
    const RigidVertex vertex{.v = {i, first, first + 1, first + 2, first + 3},
                             .weight = box.weights(surface.vertices[i])};
    const double mass = kAtVertices * solid.mass * shares[i];
    for (std::int32_t k = 0; k < leaders; ++k) own[k] -= vertex.weight[k] * mass;
    cloth.mass.push_back(mass);
    cloth.rigid.push_back(vertex);
  }
  for (std::int32_t k = 0; k < leaders; ++k) {
    cloth.surface.vertices.push_back(box.corner(k));
    cloth.mass.push_back(own[k]);
    if (!(own[k] > 0.0) || !(cloth.mass.front() > 0.0))
      throw std::invalid_argument(
          "the surface of a body with \"mass\" has vertices without a triangle, or too far from "
          "its "
          "centre; give it a simpler mesh");
  }
  return cloth;
}

BuiltSolid built_solid(std::size_t piece, std::int32_t begin, const SolidSpec& solid,
                       const ClothMesh& all) {
  const auto end = static_cast<std::int32_t>(all.surface.vertices.size());
  BuiltSolid built{.piece = piece, .mass = solid.mass};
  built.leader = end - built.leaders;
  Vec3 centre = Vec3::Zero();
  for (std::int32_t k = built.leader; k < end; ++k)
    centre += all.surface.vertices[k] / built.leaders;
  // A hinge's vertices turn about its axis, others about their centre.
  const Vec3 axis = solid.turns() ? (solid.hinge[1] - solid.hinge[0]).normalized() : Vec3::Zero();
  const auto arm = [&](const Vec3& x) {
    if (!solid.turns()) return (x - centre).norm();
    return axis.cross(x - solid.hinge[0]).norm();
  };
  for (std::int32_t i = begin; i < built.leader; ++i)
    built.radius = std::max(built.radius, arm(all.surface.vertices[i]));
  const auto leaders = std::span(all.surface.vertices).subspan(built.leader, built.leaders);
  if (solid.slides()) built.limited = following_point(centre, leaders);
  if (!solid.turns()) return built;
  double squares = 0.0;
  for (const Vec3& x : leaders) squares += arm(x) * arm(x) / built.leaders;
  built.lever = std::sqrt(squares);
  const Vec3 foot = solid.hinge[0] + axis.dot(centre - solid.hinge[0]) * axis, out = centre - foot;
  const bool is_off = out.norm() > kOffAxis * built.lever;
  built.pins = {following_point(foot - built.lever * axis, leaders),
                following_point(foot + built.lever * axis, leaders)};
  built.limited = following_point(
      foot + built.lever * (is_off ? Vec3(out.normalized()) : Vec3(axis.unitOrthogonal())),
      leaders);
  return built;
}

}  // namespace detail
}  // namespace selvedge
