// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/detail/person_body.h>

#include <stdexcept>

namespace selvedge {
namespace {

/// People are between these sizes, m; a body of another size is probably in another unit.
constexpr double kSmallest = 0.3, kLargest = 3.0;

bool has_height_of_person(double height) { return height >= kSmallest && height <= kLargest; }

/// Largest minus smallest coordinate of the vertices, along each axis.
Vec3 extent_of(const TriangleMesh& mesh) {
  Vec3 low = mesh.vertices.front(), high = low;
  for (const Vec3& x : mesh.vertices) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return high - low;
}

/// The option with which a body of this height, and of these extents along the axes of its file,
/// would be a person.
std::string remedy_of_height(const FileAxes& axes, double height, const Vec3& extent) {
  Eigen::Index longest = 0;
  if (has_height_of_person(extent.maxCoeff(&longest)))
    return fmt::format("give the axis that points up, such as --up {}", "xyz"[longest]);
  for (const double unit : {1.0, 0.01, 0.001})
    if (has_height_of_person(height / axes.unit * unit))
      return fmt::format("give the metres per unit of the file, such as --unit {:g}", unit);
  return "give --unit, the metres per unit of the file, and --up, the axis that points up";
}

}  // namespace

BodyMesh read_person(const std::string& file, const LoadConfig& config) {
  BodyMesh body = load_body_mesh(file, config);
  if (body.mesh.triangles.empty())
    throw std::invalid_argument(file + ": has no triangles; a body is a surface");
  const Vec3 extent = extent_of(body.mesh);
  const FileAxes& axes = body.axes;
  if (has_height_of_person(extent.z())) return body;
  // load_mesh has turned the axes of the file.
  const Vec3 of_file = axes.up == UpAxis::x   ? Vec3(extent.z(), extent.x(), extent.y())
                       : axes.up == UpAxis::y ? Vec3(extent.x(), extent.z(), extent.y())
                                              : extent;
  throw std::invalid_argument(fmt::format(
      "{}: is {:g} m tall with --unit {:g} and --up {}; if it is a person, {}", file, extent.z(),
      axes.unit, "xyz"[static_cast<int>(axes.up)], remedy_of_height(axes, extent.z(), of_file)));
}

}  // namespace selvedge
