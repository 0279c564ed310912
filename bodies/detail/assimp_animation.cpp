// SPDX-License-Identifier: MIT
#include <selvedge/bodies/detail/assimp_animation.h>

#include <assimp/anim.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace selvedge::detail {
namespace {

constexpr int kMaxDepth = 1000;  // of nodes, far beyond any real scene
constexpr Affine kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/// The keys around a time and the share of the later one. There is at least one key.
template <class Key>
struct Between {
  const Key *a, *b;
  double share;
};

template <class Key>
Between<Key> around(const Key* keys, unsigned count, double ticks) {
  const Key* after = std::upper_bound(keys, keys + count, ticks,
                                      [](double t, const Key& key) { return t < key.mTime; });
  if (after == keys) return {keys, keys, 0.0};
  if (after == keys + count) return {after - 1, after - 1, 0.0};
  const Key* before = after - 1;
  return {before, after, (ticks - before->mTime) / (after->mTime - before->mTime)};
}

aiVector3D vector_at(const aiVectorKey* keys, unsigned count, double ticks,
                     const aiVector3D& otherwise) {
  if (count == 0) return otherwise;
  const auto [a, b, share] = around(keys, count, ticks);
  const auto t = static_cast<ai_real>(share);
  return a->mValue + t * (b->mValue - a->mValue);
}

aiQuaternion rotation_at(const aiNodeAnim& channel, double ticks) {
  if (channel.mNumRotationKeys == 0) return {};
  const auto [a, b, share] = around(channel.mRotationKeys, channel.mNumRotationKeys, ticks);
  aiQuaternion q;
  aiQuaternion::Interpolate(q, a->mValue, b->mValue, static_cast<ai_real>(share));
  return q.Normalize();
}

/// Weight of each morph target of a mesh.
std::vector<double> morph_weights(const aiMesh& mesh, const aiMeshMorphAnim* morph, double ticks) {
  std::vector<double> weights(mesh.mNumAnimMeshes, 0.0);
  for (unsigned i = 0; i < mesh.mNumAnimMeshes; ++i) weights[i] = mesh.mAnimMeshes[i]->mWeight;
  if (morph == nullptr || morph->mNumKeys == 0) return weights;
  std::fill(weights.begin(), weights.end(), 0.0);
  const auto [a, b, share] = around(morph->mKeys, morph->mNumKeys, ticks);
  const auto add = [&](const aiMeshMorphKey& key, double part) {
    for (unsigned i = 0; i < key.mNumValuesAndWeights; ++i)
      if (key.mValues[i] < weights.size()) weights[key.mValues[i]] += part * key.mWeights[i];
  };
  add(*a, 1.0 - share);
  add(*b, share);
  return weights;
}

}  // namespace

Affine to_affine(const aiMatrix4x4& m) {
  return {m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4};
}

Affine compose(const Affine& a, const Affine& b) {
  Affine c{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 4; ++j) {
      for (int k = 0; k < 3; ++k) c[4 * i + j] += a[4 * i + k] * b[4 * k + j];
      if (j == 3) c[4 * i + j] += a[4 * i + 3];
    }
  return c;
}

double determinant(const Affine& m) {
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
         m[2] * (m[4] * m[9] - m[5] * m[8]);
}

Point to_point(const aiVector3D& p) { return {p.x, p.y, p.z}; }

Point mapped(const Affine& m, const Point& p) {
  Point q;
  for (int i = 0; i < 3; ++i)
    q[i] = m[4 * i] * p[0] + m[4 * i + 1] * p[1] + m[4 * i + 2] * p[2] + m[4 * i + 3];
  return q;
}

PosedScene::PosedScene(const aiScene& scene) : scene_(&scene) {
  find_instances(*scene.mRootNode, 0);
  if (scene.mNumAnimations == 0) return;
  animation_ = scene.mAnimations[0];
  if (animation_->mTicksPerSecond > 0.0) ticks_per_second_ = animation_->mTicksPerSecond;
  for (unsigned i = 0; i < animation_->mNumChannels; ++i)
    channels_[animation_->mChannels[i]->mNodeName.C_Str()] = animation_->mChannels[i];
  for (unsigned i = 0; i < animation_->mNumMorphMeshChannels; ++i)
    morphs_[animation_->mMorphMeshChannels[i]->mName.C_Str()] = animation_->mMorphMeshChannels[i];
}

void PosedScene::find_instances(const aiNode& node, int depth) {
  if (depth > kMaxDepth) return;
  nodes_.emplace(node.mName.C_Str(), &node);
  for (unsigned i = 0; i < node.mNumMeshes; ++i)
    if (node.mMeshes[i] < scene_->mNumMeshes)
      instances_.push_back({scene_->mMeshes[node.mMeshes[i]], &node});
  for (unsigned i = 0; i < node.mNumChildren; ++i) find_instances(*node.mChildren[i], depth + 1);
}

std::uint64_t PosedScene::frames(double fps) const {
  if (animation_ == nullptr || !(animation_->mDuration > 0.0)) return 1;
  constexpr double most = 1e6;
  const double seconds = animation_->mDuration / ticks_per_second_;
  return static_cast<std::uint64_t>(std::min(most, std::round(seconds * fps))) + 1;
}

Affine PosedScene::local_map(const aiNode& node, double ticks) const {
  const auto found = channels_.find(node.mName.C_Str());
  if (found == channels_.end()) return to_affine(node.mTransformation);
  const aiNodeAnim& c = *found->second;
  return to_affine(
      aiMatrix4x4(vector_at(c.mScalingKeys, c.mNumScalingKeys, ticks, aiVector3D(1, 1, 1)),
                  rotation_at(c, ticks),
                  vector_at(c.mPositionKeys, c.mNumPositionKeys, ticks, aiVector3D(0, 0, 0))));
}

void PosedScene::pose_nodes(const aiNode& node, const Affine& parent, double ticks, int depth) {
  if (depth > kMaxDepth) return;
  const Affine map = compose(parent, local_map(node, ticks));
  global_[&node] = map;
  for (unsigned i = 0; i < node.mNumChildren; ++i)
    pose_nodes(*node.mChildren[i], map, ticks, depth + 1);
}

/// p = p0 + Σ w (target - p0)
std::vector<Point> PosedScene::morphed(const Instance& instance, double ticks) const {
  const aiMesh& mesh = *instance.mesh;
  std::vector<Point> points;
  points.reserve(mesh.mNumVertices);
  for (unsigned v = 0; v < mesh.mNumVertices; ++v) points.push_back(to_point(mesh.mVertices[v]));
  if (mesh.mNumAnimMeshes == 0) return points;
  const auto found = morphs_.find(instance.node->mName.C_Str());
  const std::vector<double> weights =
      morph_weights(mesh, found == morphs_.end() ? nullptr : found->second, ticks);
  for (unsigned i = 0; i < mesh.mNumAnimMeshes; ++i) {
    const aiAnimMesh& target = *mesh.mAnimMeshes[i];
    if (weights[i] == 0.0 || target.mVertices == nullptr) continue;
    for (unsigned v = 0; v < std::min(mesh.mNumVertices, target.mNumVertices); ++v) {
      const Point base = to_point(mesh.mVertices[v]), moved = to_point(target.mVertices[v]);
      for (int k = 0; k < 3; ++k) points[v][k] += weights[i] * (moved[k] - base[k]);
    }
  }
  return points;
}

/// Linear blend skinning: p = Σ w (bone · offset) p / Σ w. A vertex without a bone follows the
/// node.
void PosedScene::append_skinned(const Instance& instance, const std::vector<Point>& points,
                                std::vector<Point>& out) const {
  const aiMesh& mesh = *instance.mesh;
  std::vector<Point> sum(points.size(), Point{});
  std::vector<double> weight(points.size(), 0.0);
  for (unsigned b = 0; b < mesh.mNumBones; ++b) {
    const aiBone& bone = *mesh.mBones[b];
    const auto node = nodes_.find(bone.mName.C_Str());
    if (node == nodes_.end()) continue;
    const Affine map = compose(global_.at(node->second), to_affine(bone.mOffsetMatrix));
    for (unsigned i = 0; i < bone.mNumWeights; ++i) {
      const auto [v, w] = std::pair(bone.mWeights[i].mVertexId, double(bone.mWeights[i].mWeight));
      if (v >= points.size()) continue;
      const Point p = mapped(map, points[v]);
      for (int k = 0; k < 3; ++k) sum[v][k] += w * p[k];
      weight[v] += w;
    }
  }
  const Affine& own = global_.at(instance.node);
  for (std::size_t v = 0; v < points.size(); ++v) {
    if (weight[v] > 0.0)
      out.push_back({sum[v][0] / weight[v], sum[v][1] / weight[v], sum[v][2] / weight[v]});
    else
      out.push_back(mapped(own, points[v]));
  }
}

std::vector<Point> PosedScene::vertices(double seconds) {
  const double ticks = seconds * ticks_per_second_;
  pose_nodes(*scene_->mRootNode, kIdentity, ticks, 0);
  std::vector<Point> out;
  for (const Instance& instance : instances_)
    append_skinned(instance, morphed(instance, ticks), out);
  return out;
}

std::vector<std::array<std::int32_t, 3>> PosedScene::triangles() {
  pose_nodes(*scene_->mRootNode, kIdentity, 0.0, 0);
  std::vector<std::array<std::int32_t, 3>> list;
  std::uint32_t first = 0;
  for (const auto& [mesh, node] : instances_) {
    const bool mirrored = mesh->mNumBones == 0 && determinant(global_.at(node)) < 0.0;
    for (unsigned k = 0; k < mesh->mNumFaces; ++k) {
      const aiFace& face = mesh->mFaces[k];
      if (face.mNumIndices != 3) continue;  // points and lines
      std::array<std::int32_t, 3> t;
      for (int i = 0; i < 3; ++i)
        t[i] = face.mIndices[i] < mesh->mNumVertices
                   ? static_cast<std::int32_t>(first + face.mIndices[i])
                   : -1;
      if (mirrored) std::swap(t[1], t[2]);
      list.push_back(t);
    }
    first += mesh->mNumVertices;
  }
  return list;
}

}  // namespace selvedge::detail
