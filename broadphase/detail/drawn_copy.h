// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>

#include <cstring>
#include <span>
#include <vector>

namespace selvedge::detail {

/// A copy of the last drawn input, to detect changes.
class DrawnCopy {
 public:
  bool is(const SurfaceView& s) const {
    if (!valid_ || s.x_t0.size() != x_t0_.size() || s.triangles.size() != triangles_.size())
      return false;
    if (s.static_id != 0 && s.static_id == static_id_) return true;
    return same_triangles(s) && same_bytes(s.x_t0, x_t0_) && same_bytes(s.x_t1, x_t1_);
  }
  bool same_triangles(const SurfaceView& s) const {
    return valid_ && s.x_t0.size() == x_t0_.size() && same_bytes(s.triangles, triangles_);
  }
  void set(const SurfaceView& s) {
    valid_ = true;
    static_id_ = s.static_id;
    x_t0_.assign(s.x_t0.begin(), s.x_t0.end());
    x_t1_.assign(s.x_t1.begin(), s.x_t1.end());
    triangles_.assign(s.triangles.begin(), s.triangles.end());
  }
  void forget() { valid_ = false; }
  std::size_t bytes() const {
    return (x_t0_.capacity() + x_t1_.capacity()) * sizeof(Vec3) +
           triangles_.capacity() * sizeof(Triangle);
  }

 private:
  template <class T>
  static bool same_bytes(std::span<const T> a, const std::vector<T>& b) {
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
  }

  bool valid_ = false;
  std::uint64_t static_id_ = 0;
  std::vector<Vec3> x_t0_, x_t1_;
  std::vector<Triangle> triangles_;
};

}  // namespace selvedge::detail
