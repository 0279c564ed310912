// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>

namespace selvedge {

/// The most memory of this process since construction, above what it had then, as Linux counts
/// resident pages: also what libraries allocate on their own.
class PeakMemory {
 public:
  /// Measures only if `wanted`: it gives freed memory back to the system first, which takes time.
  explicit PeakMemory(bool wanted = true);
  /// Bytes; none where the system does not tell.
  std::optional<std::size_t> grown_by() const;

 private:
  std::optional<std::size_t> before_;
};

}  // namespace selvedge
