// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/run/detail/part_mesh.h>
#include <selvedge/run/internal/part_colours.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

namespace selvedge::detail {
namespace {

Vec3 face_normal(const Triangle& t, std::span<const Vec3> x) {
  const Vec3& a = x[static_cast<std::size_t>(t[0])];
  return (x[static_cast<std::size_t>(t[1])] - a).cross(x[static_cast<std::size_t>(t[2])] - a);
}

/// Builds one part, triangle by triangle.
class PartBuilder {
 public:
  PartBuilder(PartMesh& part, std::span<const Vec3> x, bool creases) : part_(part), x_(x) {
    if (creases) least_cosine_ = std::cos(kBodyCrease * std::numbers::pi / 180.0);
  }

  /// Call after the last triangle. Vertices come in the order of the frame.
  void finish() {
    std::vector<std::int32_t> number(vertices_.size());
    PartMesh sorted;
    for (const auto& [key, old] : vertices_) {
      const auto from = static_cast<std::size_t>(old);
      number[from] = static_cast<std::int32_t>(sorted.source.size());
      sorted.source.push_back(part_.source[from]);
      sorted.normal.push_back(part_.normal[from]);
      if (!part_.texture.empty()) sorted.texture.push_back(part_.texture[from]);
    }
    part_.source = std::move(sorted.source);
    part_.normal = std::move(sorted.normal);
    part_.texture = std::move(sorted.texture);
    for (Triangle& t : part_.triangles)
      for (std::int32_t& v : t) v = number[static_cast<std::size_t>(v)];
  }

  void add(const Triangle& t, const std::array<TexturePoint, 3>* texture) {
    const Vec3 direction = face_normal(t, x_).normalized();
    Triangle own{};
    for (std::size_t k = 0; k < 3; ++k)
      own[k] = vertex(t[k], direction, texture != nullptr ? &(*texture)[k] : nullptr);
    part_.triangles.push_back(own);
  }

 private:
  struct Smooth {
    Vec3 direction;  // of its first triangle
    std::int32_t normal;
  };

  // A corner joins the first normal of its vertex that is near its own direction.
  std::int32_t normal(std::int32_t source, const Vec3& direction) {
    std::vector<Smooth>& known = smooth_[source];
    for (const Smooth& s : known)
      if (!(s.direction.dot(direction) < least_cosine_)) return s.normal;
    known.push_back({direction, part_.normals});
    return part_.normals++;
  }

  std::int32_t vertex(std::int32_t source, const Vec3& direction, const TexturePoint* texture) {
    const std::int32_t n = normal(source, direction);
    const TexturePoint uv = texture != nullptr ? *texture : TexturePoint{};
    const auto [at, is_new] = vertices_.try_emplace(std::tuple(source, n, uv),
                                                    static_cast<std::int32_t>(part_.source.size()));
    if (!is_new) return at->second;
    part_.source.push_back(source);
    part_.normal.push_back(n);
    if (texture != nullptr) part_.texture.push_back(uv);
    return at->second;
  }

  PartMesh& part_;
  std::span<const Vec3> x_;
  double least_cosine_ = -2.0;  // all corners of a vertex share a normal
  std::map<std::int32_t, std::vector<Smooth>> smooth_;
  std::map<std::tuple<std::int32_t, std::int32_t, TexturePoint>, std::int32_t> vertices_;
};

std::vector<FramePart> parts_of(const Frame& frame, FrameHalf half) {
  const bool cloth = half == FrameHalf::cloth;
  const auto given = cloth ? frame.pieces : frame.body_parts;
  if (!given.empty()) return {given.begin(), given.end()};
  if (cloth) return {{"cloth", 0, frame.x.size(), piece_dye(0).front}};
  if (frame.bodies.empty()) return {};
  return {{"bodies", 0, frame.bodies.size(), body_colour()}};
}

std::string unique_name(const std::string& wanted, std::set<std::string>& taken) {
  std::string name = wanted;
  for (int k = 2; !taken.insert(name).second; ++k) name = fmt::format("{}_{}", wanted, k);
  return name;
}

}  // namespace

std::vector<PartMesh> part_meshes(const Frame& frame, FrameHalf half) {
  const bool cloth = half == FrameHalf::cloth;
  const std::span<const Vec3> x = cloth ? frame.x : frame.bodies;
  const std::span<const Triangle> triangles = cloth ? frame.triangles : frame.body_triangles;
  const std::vector<FramePart> parts = parts_of(frame, half);
  std::vector<PartMesh> meshes(parts.size());
  std::set<std::string> taken;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    meshes[p].name = unique_name(parts[p].name, taken);
    meshes[p].colour = parts[p].colour;
    PartBuilder builder(meshes[p], x, !cloth);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const auto first = static_cast<std::size_t>(triangles[t][0]);
      if (first < parts[p].first || first >= parts[p].first + parts[p].count) continue;
      const bool textured = cloth && !frame.texture.empty() && !std::isnan(frame.texture[t][0][0]);
      builder.add(triangles[t], textured ? &frame.texture[t] : nullptr);
    }
    builder.finish();
  }
  return meshes;
}

std::vector<Vec3> points_of(const PartMesh& part, std::span<const Vec3> x) {
  std::vector<Vec3> points;
  points.reserve(part.source.size());
  for (const std::int32_t i : part.source) points.push_back(x[static_cast<std::size_t>(i)]);
  return points;
}

std::vector<Vec3> normals_of(const PartMesh& part, std::span<const Vec3> points) {
  std::vector<Vec3> sums(static_cast<std::size_t>(part.normals), Vec3::Zero());
  for (const Triangle& t : part.triangles) {
    const Vec3 area = face_normal(t, points);
    for (const std::int32_t v : t)
      sums[static_cast<std::size_t>(part.normal[static_cast<std::size_t>(v)])] += area;
  }
  std::vector<Vec3> normals;
  normals.reserve(points.size());
  for (const std::int32_t n : part.normal) {
    const Vec3& sum = sums[static_cast<std::size_t>(n)];
    normals.push_back(sum.norm() > 0.0 ? Vec3(sum.normalized()) : Vec3(Vec3::UnitZ()));
  }
  return normals;
}

std::vector<float> values_of(const PartMesh& part, std::span<const NamedValues> all,
                             const std::string& name) {
  std::vector<float> values;
  for (const NamedValues& named : all)
    if (named.name == name)
      for (const std::int32_t i : part.source)
        values.push_back(static_cast<float>(named.values[static_cast<std::size_t>(i)]));
  return values;
}

}  // namespace selvedge::detail
