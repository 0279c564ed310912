// SPDX-License-Identifier: MIT
#include <selvedge/bodies/body.h>
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/base/internal/elementary.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace selvedge {

namespace {

class StaticBody final : public Body {
 public:
  explicit StaticBody(TriangleMesh mesh) : mesh_(std::move(mesh)) {}

  const std::vector<Triangle>& triangles() const override { return mesh_.triangles; }
  std::size_t vertex_count() const override { return mesh_.vertices.size(); }
  void positions(double, std::span<Vec3> x) const override {
    SELVEDGE_ASSERT(x.size() == mesh_.vertices.size());
    std::copy(mesh_.vertices.begin(), mesh_.vertices.end(), x.begin());
  }
  bool is_static(double, double) const override { return true; }

 private:
  TriangleMesh mesh_;
};

// A quaternion and its negative describe the same rotation.
bool same_pose(const Keyframe& a, const Keyframe& b) {
  return a.translation == b.translation && (a.rotation.coeffs() == b.rotation.coeffs() ||
                                            a.rotation.coeffs() == -b.rotation.coeffs());
}

class KeyframedBody final : public Body {
 public:
  KeyframedBody(TriangleMesh mesh, std::vector<Keyframe> keys)
      : mesh_(std::move(mesh)), keys_(std::move(keys)) {}

  const std::vector<Triangle>& triangles() const override { return mesh_.triangles; }
  std::size_t vertex_count() const override { return mesh_.vertices.size(); }
  void positions(double time, std::span<Vec3> x) const override {
    SELVEDGE_ASSERT(x.size() == mesh_.vertices.size());
    const Keyframe pose = pose_at(keys_, time);
    const Mat3 rotation = pose.rotation.toRotationMatrix();
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] = rotation * mesh_.vertices[i] + pose.translation;
  }
  bool is_static(double t0, double t1) const override {
    for (std::size_t k = 0; k + 1 < keys_.size(); ++k)
      if (keys_[k].time < t1 && keys_[k + 1].time > t0 && !same_pose(keys_[k], keys_[k + 1]))
        return false;
    return true;
  }
  std::optional<Pose> pose(double time) const override {
    const Keyframe pose = pose_at(keys_, time);
    return Pose{pose.rotation.toRotationMatrix(), pose.translation};
  }

 private:
  TriangleMesh mesh_;
  std::vector<Keyframe> keys_;
};

class SequenceBody final : public Body {
 public:
  SequenceBody(std::vector<TriangleMesh> frames, double fps, double start)
      : triangles_(std::move(frames.front().triangles)), fps_(fps), start_(start) {
    for (TriangleMesh& frame : frames) frames_.push_back(std::move(frame.vertices));
    for (std::size_t k = 0; k + 1 < frames_.size(); ++k)
      moves_.push_back(frames_[k] != frames_[k + 1]);
  }

  const std::vector<Triangle>& triangles() const override { return triangles_; }
  std::size_t vertex_count() const override { return frames_.front().size(); }
  void positions(double time, std::span<Vec3> x) const override {
    SELVEDGE_ASSERT(x.size() == vertex_count());
    const double s = frame_at(time);
    const auto k = static_cast<std::size_t>(s);
    const double w = s - static_cast<double>(k);
    const std::vector<Vec3>& a = frames_[k];
    if (w == 0.0 || !moves_[k]) {
      std::copy(a.begin(), a.end(), x.begin());
      return;
    }
    const std::vector<Vec3>& b = frames_[k + 1];
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = (1.0 - w) * a[i] + w * b[i];
  }
  bool is_static(double t0, double t1) const override {
    const auto first = static_cast<std::ptrdiff_t>(frame_at(t0));
    const auto last = static_cast<std::ptrdiff_t>(std::ceil(frame_at(t1)));
    return std::find(moves_.begin() + first, moves_.begin() + std::max(first, last), true) ==
           moves_.begin() + std::max(first, last);
  }

 private:
  double frame_at(double time) const {
    return std::clamp((time - start_) * fps_, 0.0, static_cast<double>(frames_.size() - 1));
  }

  std::vector<Triangle> triangles_;
  std::vector<std::vector<Vec3>> frames_;
  std::vector<bool> moves_;  // per k: whether frame k differs from frame k + 1
  double fps_, start_;
};

std::string key_name(std::size_t k) { return "keyframe " + std::to_string(k); }

void check_keys(const std::vector<Keyframe>& keys) {
  if (keys.empty()) throw std::invalid_argument("a keyframed body needs at least one keyframe");
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const double norm = keys[k].rotation.norm();
    if (!std::isfinite(keys[k].time) || !keys[k].translation.allFinite() || !std::isfinite(norm))
      throw std::invalid_argument(key_name(k) + " has a number that is not finite");
    if (!(norm > 0.0))
      throw std::invalid_argument(key_name(k) + " has a rotation quaternion of length 0");
    if (k > 0 && !(keys[k - 1].time < keys[k].time))
      throw std::invalid_argument(key_name(k) + " at " + std::to_string(keys[k].time) +
                                  " s is not later than the one before it; sort them by time");
  }
}

void check_frames(const std::vector<TriangleMesh>& frames) {
  if (frames.empty()) throw std::invalid_argument("a mesh sequence needs at least one frame");
  for (std::size_t k = 0; k < frames.size(); ++k) {
    validate(frames[k], "frame " + std::to_string(k) + " of the mesh sequence");
    if (frames[k].vertices.size() != frames[0].vertices.size() ||
        frames[k].triangles != frames[0].triangles)
      throw std::invalid_argument("frame " + std::to_string(k) +
                                  " of the mesh sequence has other vertices or triangles than "
                                  "frame 0; every frame must be the same mesh with moved vertices");
  }
}

/// The rotation at the share `s` of the shorter way from a to b, at a constant speed
/// [Shoemake1985].
Eigen::Quaterniond between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b, double s) {
  const double cosine = a.dot(b), turn = elementary::acos(std::min(1.0, std::abs(cosine)));
  const double sine = elementary::sin(turn);
  double from = 1.0 - s, to = s;  // where the sine would be lost
  if (sine > 1e-8) {
    from = elementary::sin((1.0 - s) * turn) / sine;
    to = elementary::sin(s * turn) / sine;
  }
  if (cosine < 0.0) to = -to;
  return Eigen::Quaterniond(from * a.coeffs() + to * b.coeffs());
}

}  // namespace

std::unique_ptr<Body> make_static_body(TriangleMesh mesh) {
  validate(mesh, "body");
  return std::make_unique<StaticBody>(std::move(mesh));
}

std::unique_ptr<Body> make_keyframed_body(TriangleMesh mesh, std::vector<Keyframe> keys) {
  validate(mesh, "body");
  check_keys(keys);
  for (Keyframe& key : keys) key.rotation.normalize();
  return std::make_unique<KeyframedBody>(std::move(mesh), std::move(keys));
}

std::unique_ptr<Body> make_sequence_body(std::vector<TriangleMesh> frames, double fps,
                                         double start) {
  check_frames(frames);
  if (!(fps > 0.0) || !std::isfinite(fps))
    throw std::invalid_argument("a mesh sequence at " + std::to_string(fps) +
                                " frames per second cannot be played; give a positive number");
  if (!std::isfinite(start))
    throw std::invalid_argument("the start of a mesh sequence is not finite");
  return std::make_unique<SequenceBody>(std::move(frames), fps, start);
}

Keyframe pose_at(std::span<const Keyframe> keys, double time) {
  if (keys.empty()) return {};
  const auto after = std::upper_bound(keys.begin(), keys.end(), time,
                                      [](double t, const Keyframe& k) { return t < k.time; });
  if (after == keys.begin()) return keys.front();
  const Keyframe& a = *(after - 1);
  // Interpolating between equal poses would round, but is_static promises identical positions.
  if (after == keys.end() || same_pose(a, *after)) return a;
  const Keyframe& b = *after;
  const double s = (time - a.time) / (b.time - a.time);
  return {time, (1.0 - s) * a.translation + s * b.translation, between(a.rotation, b.rotation, s)};
}

}  // namespace selvedge
