// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/resolution.h>
#include <selvedge/broadphase/detail/swept_box.h>
#include <selvedge/core/base/types.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace selvedge::detail {

/// A box in float with the index of its double original and a tag for its user. Boxes a and b
/// overlap if a.lo <= b.hi and -a.hi <= -b.lo: because the negatives are stored, eight floats are
/// compared at once.
///
/// Why float loses nothing: see FloatBox. Every coordinate goes through one monotone map, so boxes
/// that overlap in double do so in float, strict overlap in float is certain, and only equal
/// coordinates require a test in double.
struct alignas(32) PackedBox {
  float lo[3];
  std::int32_t id;
  float minus_hi[3];
  std::uint32_t tag;
};

/// The other side of the comparison; lanes 3 and 7 are ignored.
struct alignas(32) PackedQuery {
  float hi[4], minus_lo[4];
};

inline PackedQuery query_of(const PackedBox& box) {
  PackedQuery query{};
  for (int k = 0; k < 3; ++k) {
    query.hi[k] = -box.minus_hi[k];
    query.minus_lo[k] = -box.lo[k];
  }
  return query;
}

/// The monotone map from doubles to floats: relative to an origin, or by a QuantileMap for each
/// axis.
class FloatMap {
 public:
  /// Coordinates are clamped to this value, so that neither a box's extent nor its inverse
  /// overflows.
  static constexpr double kFar = 0x1p100;

  explicit FloatMap(const Vec3& origin = Vec3::Zero()) : origin_(origin) {}
  explicit FloatMap(std::vector<QuantileMap> quantiles) : quantiles_(std::move(quantiles)) {}
  /// True if both maps are relative to an origin and the origins are within `near` of each other.
  bool is_near(const FloatMap& other, double near) const {
    return !is_by_quantiles() && !other.is_by_quantiles() &&
           (origin_ - other.origin_).cwiseAbs().maxCoeff() < near;
  }
  bool is_by_quantiles() const { return !quantiles_.empty(); }

  PackedBox pack(const DoubleBox& box, std::int32_t id, std::uint32_t tag = 0) const {
    PackedBox out;
    if (is_by_quantiles()) {  // The test is outside the loop for speed.
      for (int k = 0; k < 3; ++k) {
        out.lo[k] = static_cast<float>(quantiles_[k](box.lo[k]));
        out.minus_hi[k] = -static_cast<float>(quantiles_[k](box.hi[k]));
      }
    } else {
      for (int k = 0; k < 3; ++k) {
        out.lo[k] = static_cast<float>(from_origin(k, box.lo[k]));
        out.minus_hi[k] = -static_cast<float>(from_origin(k, box.hi[k]));
      }
    }
    out.id = id;
    out.tag = tag;
    return out;
  }
  /// The map along axis k, before rounding.
  double operator()(int k, double x) const {
    return is_by_quantiles() ? quantiles_[k](x) : from_origin(k, x);
  }

 private:
  double from_origin(int k, double x) const { return std::clamp(x - origin_[k], -kFar, kFar); }

  Vec3 origin_ = Vec3::Zero();
  std::vector<QuantileMap> quantiles_;  ///< none or three
};

/// A point in the middle of most boxes, insensitive to outliers: the median of a sample of their
/// corners, per coordinate. Floats relative to it are finest where the boxes are.
Vec3 middle_of(std::span<const std::vector<DoubleBox>* const> lists);

/// Writes 2·i + certain for each box [i] of [boxes, boxes + n) that overlaps the query in float
/// (`certain`: strictly, hence in double too) and returns the end. There must be space for n.
using ScanBoxes = std::uint32_t* (*)(const PackedBox* boxes, std::uint32_t n,
                                     const PackedQuery& query, std::uint32_t* out);
/// The widest version that this processor supports.
ScanBoxes scan_boxes();

}  // namespace selvedge::detail
