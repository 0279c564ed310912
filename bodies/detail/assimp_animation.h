// SPDX-License-Identifier: MIT
//
// Poses of a scene of assimp: nodes, skins and morph targets at a time. Only selvedge-assimp
// includes this.
#pragma once

#include <assimp/scene.h>

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace selvedge::detail {

using Point = std::array<double, 3>;

struct Soup {
  std::vector<Point> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;
};

/// Row-major affine map in double precision; assimp's own matrices are float.
using Affine = std::array<double, 12>;

Affine to_affine(const aiMatrix4x4& m);
Affine compose(const Affine& a, const Affine& b);
double determinant(const Affine& m);
Point to_point(const aiVector3D& p);
Point mapped(const Affine& m, const Point& p);

/// A scene under its first animation.
class PosedScene {
 public:
  explicit PosedScene(const aiScene& scene);

  /// Number of frames at this rate, from 0 s to the end of the animation; 1 without one.
  std::uint64_t frames(double fps) const;
  /// Vertices of all meshes of all nodes at a time (s), in file units, the same order at any time.
  std::vector<Point> vertices(double seconds);
  /// Their triangles, unchecked.
  std::vector<std::array<std::int32_t, 3>> triangles();

 private:
  /// A mesh at a node; a mesh may be at several.
  struct Instance {
    const aiMesh* mesh;
    const aiNode* node;
  };

  void find_instances(const aiNode& node, int depth);
  void pose_nodes(const aiNode& node, const Affine& parent, double ticks, int depth);
  Affine local_map(const aiNode& node, double ticks) const;
  std::vector<Point> morphed(const Instance& instance, double ticks) const;
  void append_skinned(const Instance& instance, const std::vector<Point>& points,
                      std::vector<Point>& out) const;

  const aiScene* scene_;
  const aiAnimation* animation_ = nullptr;
  double ticks_per_second_ = 25.0;
  std::vector<Instance> instances_;
  std::map<std::string, const aiNodeAnim*> channels_;
  std::map<std::string, const aiMeshMorphAnim*> morphs_;
  std::map<const aiNode*, Affine> global_;
  std::map<std::string, const aiNode*> nodes_;
};

}  // namespace selvedge::detail
