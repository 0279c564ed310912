// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/resolution.h>
#include <selvedge/broadphase/detail/swept_box.h>
#include <selvedge/core/types.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace selvedge::detail {

/// A box in float with the index of its double original and a tag of its owner's choice. Boxes a
/// and b overlap if a.lo <= b.hi and -a.hi <= -b.lo: as the negatives are stored, eight floats are
/// compared at once.
///
/// Why float loses nothing: see FloatBox. Every coordinate goes through one monotone map, so that
/// boxes that overlap in double do so in float, strict overlap in float is certain, and only where
/// two coordinates are equal the doubles are looked at.
struct alignas(32) PackedBox {
  float lo[3];
  std::int32_t id;
  float minus_hi[3];
  std::uint32_t tag;
};

/// The other side of the comparison; lanes 3 and 7 are not looked at.
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

/// The monotone map of doubles to floats: about an origin, or by a QuantileMap for each axis.
class FloatMap {
 public:
  /// Coordinates are clamped here, so that neither a box's extent nor the inverse of it overflows.
  static constexpr double kFar = 0x1p100;

  explicit FloatMap(const Vec3& origin = Vec3::Zero()) : origin_(origin) {}
  explicit FloatMap(std::vector<QuantileMap> quantiles) : quantiles_(std::move(quantiles)) {}
  /// True if `other` is about an origin within `near` of this one's, as both are.
  bool is_near(const FloatMap& other, double near) const {
    return !is_by_quantiles() && !other.is_by_quantiles() &&
           (origin_ - other.origin_).cwiseAbs().maxCoeff() < near;
  }
  bool is_by_quantiles() const { return !quantiles_.empty(); }

  PackedBox pack(const SweptBox& box, std::int32_t id, std::uint32_t tag = 0) const {
    PackedBox out;
    if (is_by_quantiles()) {  // Asked once, so that the usual loop is free of it.
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
  /// The map along axis k, before it is rounded.
  double operator()(int k, double x) const {
    return is_by_quantiles() ? quantiles_[k](x) : from_origin(k, x);
  }

 private:
  double from_origin(int k, double x) const { return std::clamp(x - origin_[k], -kFar, kFar); }

  Vec3 origin_ = Vec3::Zero();
  std::vector<QuantileMap> quantiles_;  ///< none or three
};

/// A place in the middle of most boxes, whatever a few of them do: the median of a sample of their
/// corners, per coordinate. Floats about it are finest where the boxes are.
Vec3 middle_of(std::span<const std::vector<SweptBox>* const> lists);

/// Writes 2·i + certain for each box [i] of [boxes, boxes + n) that overlaps the query in float
/// (`certain`: strictly, hence in double too); returns the end. There must be room for n.
using ScanBoxes = std::uint32_t* (*)(const PackedBox* boxes, std::uint32_t n,
                                     const PackedQuery& query, std::uint32_t* out);
/// The widest one that this processor has.
ScanBoxes scan_boxes();

}  // namespace selvedge::detail
