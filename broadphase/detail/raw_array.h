// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/parallel.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>

namespace selvedge::detail {

/// A list whose elements start uninitialised: for large lists that several threads fill at once,
/// where writing zeros first would cost as much as the filling.
template <class T>
class RawArray {
 public:
  RawArray() = default;
  explicit RawArray(std::size_t n) { reset(n); }

  /// Discards the elements; the new ones are uninitialised.
  void reset(std::size_t n) {
    if (n > capacity_) {
      data_.reset();
      data_ = std::unique_ptr<T[]>(new T[n]);
      capacity_ = n;
    }
    size_ = n;
  }
  /// Replaces the elements by copies, with all threads.
  void assign(std::span<const T> from) {
    constexpr std::size_t kGrain = 32768;  // elements per task
    reset(from.size());
    parallel_for(size_, kGrain, [&](std::size_t begin, std::size_t end) {
      std::copy(from.begin() + static_cast<std::ptrdiff_t>(begin),
                from.begin() + static_cast<std::ptrdiff_t>(end), data() + begin);
    });
  }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }
  std::size_t bytes() const { return capacity_ * sizeof(T); }

 private:
  std::unique_ptr<T[]> data_;
  std::size_t size_ = 0, capacity_ = 0;
};

}  // namespace selvedge::detail
