// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Rows of a LaneMatrix that are stored side by side.
inline constexpr std::size_t kRowLanes = 8;
/// Numbers of a row group: of one column of 3×3 blocks, and of its symmetric smoother blocks.
inline constexpr std::size_t kSlotNumbers = 9 * kRowLanes, kStepNumbers = 6 * kRowLanes;

/// A 3-vector in single precision; the fourth number is not used.
struct alignas(16) Point4 {
  float at[4];
};

/// 3-vectors in single precision: all x, then all y, then all z, each padded with zeros to whole
/// groups of rows.
class LaneVector {
 public:
  void resize(std::size_t n);
  std::size_t size() const { return size_; }
  std::size_t groups() const { return padded_ / kRowLanes; }
  /// Distance between the coordinates of a vector.
  std::size_t stride() const { return padded_; }
  float* data() { return values_.data(); }
  const float* data() const { return values_.data(); }
  Vec3 operator[](std::size_t i) const {
    return {values_[i], values_[padded_ + i], values_[2 * padded_ + i]};
  }
  void set(std::size_t i, const Vec3& v) {
    for (int k = 0; k < 3; ++k) values_[k * padded_ + i] = static_cast<float>(v[k]);
  }
  void set_zero();
  std::size_t bytes() const { return sizeof(float) * values_.size(); }

 private:
  std::size_t size_ = 0, padded_ = 0;
  std::vector<float> values_;
};

double dot(const LaneVector& a, const LaneVector& b);
/// x += factor·p and r -= factor·ap.
void add_step(float factor, const LaneVector& p, const LaneVector& ap, LaneVector& x,
              LaneVector& r);
/// y = x + factor·y.
void scale_and_add(float factor, const LaneVector& x, LaneVector& y);

/// View of a LaneMatrix and of the smoother blocks S of its rows, for the kernels.
struct LaneRows {
  const std::uint32_t* slot_begin;  ///< per group, plus one
  const std::int32_t* run;     ///< per slot: its first column if the columns are consecutive, or -1
  const std::int32_t* column;  ///< kRowLanes per slot
  const float* value;          ///< kSlotNumbers per slot: 9 entries, column-major, lane by lane
  const float* step;           ///< kStepNumbers per group: xx, xy, xz, yy, yz, zz, lane by lane
  std::size_t stride;          ///< of all vectors
};

/// The parents of the rows of a prolongation, kRowLanes rows side by side. Rows with fewer parents
/// than others of their group have further ones of weight 0.
class LaneParents {
 public:
  /// Row i has the parents [begin[i], begin[i+1]) of `parent`.
  void set_pattern(std::span<const std::int32_t> begin, std::span<const std::int32_t> parent);
  /// Sets the weight of parent k of row i.
  void set_weight(std::size_t i, std::size_t k, float weight);
  std::size_t bytes() const;

 private:
  friend struct LaneParentRows;
  std::vector<std::uint32_t> slot_begin_;
  std::vector<std::int32_t> parent_;
  std::vector<float> weight_;
};

/// View of LaneParents for the kernels.
struct LaneParentRows {
  explicit LaneParentRows(const LaneParents& p)
      : slot_begin(p.slot_begin_.data()), parent(p.parent_.data()), weight(p.weight_.data()) {}
  const std::uint32_t* slot_begin;  ///< per group, plus one
  const std::int32_t* parent;       ///< kRowLanes per slot
  const float* weight;              ///< kRowLanes per slot
};

/// A step of the conjugate gradients: the direction and its product, and what they change.
struct LaneStep {
  const float *p, *ap;
  float *x, *r;
};

/// Operations on the groups of rows [first, last). Vectors are LaneVector data; `extra` is added to
/// A x and may be null. Every vector width gives the same bits.
struct LaneMatrixKernel {
  int width = 0;  ///< floats in a vector
  /// y = A x + extra; returns x·y.
  double (*multiply)(const LaneRows& a, const float* x, const float* extra, float* y,
                     std::size_t first, std::size_t last) = nullptr;
  /// x = S b.
  void (*start)(const LaneRows& a, const float* b, float* x, std::size_t first,
                std::size_t last) = nullptr;
  /// r = b - A x - extra.
  void (*residual)(const LaneRows& a, const float* b, const float* x, const float* extra, Point4* r,
                   std::size_t first, std::size_t last) = nullptr;
  /// y = x + S (b - A x - extra); returns b·y.
  double (*relax)(const LaneRows& a, const float* b, const float* x, const float* extra, float* y,
                  std::size_t first, std::size_t last) = nullptr;
  /// x += P coarse.
  void (*prolong)(const LaneParentRows& p, const Point4* coarse, float* x, std::size_t stride,
                  std::size_t first, std::size_t last) = nullptr;
  /// b = Pᵀ r for the parents [first, last). Parent a has the children [begin[a], begin[a + 1]) of
  /// `child`.
  void (*restrict_to)(const std::int32_t* begin, const std::int32_t* child, const float* weight,
                      const Point4* r, float* b, std::size_t stride, std::size_t first,
                      std::size_t last) = nullptr;
  /// Sum of a·b over blocks of kRowLanes numbers.
  double (*dot)(const float* a, const float* b, std::size_t first, std::size_t last) = nullptr;
  /// x += factor·p and r -= factor·ap over blocks of kRowLanes numbers.
  void (*add_step)(float factor, const LaneStep& step, std::size_t first,
                   std::size_t last) = nullptr;
  /// y = x + factor·y over blocks of kRowLanes numbers.
  void (*add_to_scaled)(float factor, const float* x, float* y, std::size_t first,
                        std::size_t last) = nullptr;
  /// y = A x in double precision by rows [first, last) of 3×3 blocks, column-major.
  void (*multiply_blocks)(const std::int32_t* row_begin, const std::int32_t* column,
                          const double* value, const double* x, double* y, std::size_t first,
                          std::size_t last) = nullptr;
};

/// All kernels that this machine supports, narrowest first.
std::span<const LaneMatrixKernel> lane_matrix_kernels();
/// The widest.
const LaneMatrixKernel& lane_matrix_kernel();

/// A sparse matrix of 3×3 blocks in single precision with a fixed pattern, stored for vector units:
/// groups of eight rows hold their blocks side by side. M. Kreutzer et al., "A unified sparse
/// matrix data format for efficient general sparse matrix-vector multiplication on modern
/// processors with wide SIMD units", SIAM J. Sci. Comput. 2014 (SELL-8). Deviation: where the rows
/// of a group have nearly the same pattern relative to the diagonal, as in grids, a slot holds one
/// distance from the diagonal, so that its columns are consecutive and need no gather.
class LaneMatrix {
 public:
  /// Row i has the columns [begin[i], begin[i+1]) of `column`, ascending.
  void set_pattern(std::span<const std::int32_t> begin, std::span<const std::int32_t> column);
  std::size_t size() const { return size_; }
  /// Sets block k, counted in the pattern.
  void set(std::size_t k, const Mat3& block) {
    float* to = first_number(k);
    for (int e = 0; e < 9; ++e) to[e * kRowLanes] = static_cast<float>(block.data()[e]);
  }
  /// Adds to block k.
  void add(std::size_t k, const Mat3& block) {
    float* to = first_number(k);
    for (int e = 0; e < 9; ++e) to[e * kRowLanes] += static_cast<float>(block.data()[e]);
  }
  /// The view, with smoother blocks of kStepNumbers per group.
  LaneRows rows(std::span<const float> step) const;
  /// Bytes that one multiplication reads, without vectors.
  std::size_t bytes() const;

 private:
  void add_distance_slots(std::size_t first, std::span<const std::int32_t> begin,
                          std::span<const std::int32_t> column,
                          std::span<const std::int32_t> distances);
  void add_packed_slots(std::size_t first, std::size_t longest, std::span<const std::int32_t> begin,
                        std::span<const std::int32_t> column);
  void add_slot(std::span<const std::int32_t, kRowLanes> columns);
  float* first_number(std::size_t k) {
    return value_.data() + where_[k] / kRowLanes * kSlotNumbers + where_[k] % kRowLanes;
  }

  std::size_t size_ = 0, padded_ = 0, gathered_ = 0;
  std::vector<std::uint32_t> slot_begin_;
  std::vector<std::int32_t> run_, column_;
  std::vector<float> value_;
  std::vector<std::uint32_t> where_;  // per block of the pattern: slot and lane of its first number
};

/// Writes a symmetric block into the smoother blocks of row i.
void set_step(std::span<float> step, std::size_t i, const Mat3& block);

}  // namespace selvedge::detail
