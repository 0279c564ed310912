// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>

namespace selvedge {

/// Largest resident memory of this process since it started, bytes.
std::size_t peak_bytes();

/// Largest resident memory of this process since construction, above its resident memory at
/// construction. It includes memory that other libraries allocate.
class PeakMemory {
 public:
  /// Measures only if `wanted`, because construction first returns freed memory to the system,
  /// which takes time.
  explicit PeakMemory(bool wanted = true);
  /// Bytes; nullopt where the system does not report them.
  std::optional<std::size_t> grown_by() const;

 private:
  std::optional<std::size_t> before_;
};

}  // namespace selvedge
