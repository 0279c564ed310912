// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/run/frame_writer.h>

#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// A piece of cloth or a body as a mesh of its own.
struct PartMesh {
  std::string name;
  Vec3 colour = Vec3::Zero();
  std::vector<std::int32_t> source;  ///< of each vertex: its number in the frame
  std::vector<Triangle> triangles;
  std::vector<TexturePoint> texture;  ///< of each vertex; empty: none
  /// Of each vertex: the number of its normal, which it shares with others at the same place.
  std::vector<std::int32_t> normal;
  std::int32_t normals = 0;
};

/// The two halves of a frame.
enum class FrameHalf { cloth, bodies };

/// The parts of one half of a frame. A vertex of a body whose triangles meet at a sharp edge
/// becomes several, and so does one of cloth with several texture coordinates. Names are unique.
std::vector<PartMesh> part_meshes(const Frame& frame, FrameHalf half);

/// The positions of the vertices of a part, m.
std::vector<Vec3> points_of(const PartMesh& part, std::span<const Vec3> x);
/// Unit normals of its vertices: means of the triangles around, by area.
std::vector<Vec3> normals_of(const PartMesh& part, std::span<const Vec3> points);
/// Values of its vertices; empty if there are none of this name.
std::vector<float> values_of(const PartMesh& part, std::span<const NamedValues> values,
                             const std::string& name);

}  // namespace selvedge::detail
