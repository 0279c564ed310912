// SPDX-License-Identifier: MIT
#include <selvedge/apps/detail/peak_memory.h>

#include <fstream>
#include <string>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace selvedge {
namespace {

/// Bytes of a line of /proc/self/status, such as VmRSS.
std::optional<std::size_t> status_bytes(const std::string& name) {
  constexpr std::size_t kKilobyte = 1024;
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != name + ":") continue;
    std::size_t kilobytes = 0;
    if (status >> kilobytes) return kilobytes * kKilobyte;
  }
  return {};
}

/// From now on VmHWM is the peak since now.
bool reset_peak() {
  std::ofstream file("/proc/self/clear_refs");
  file << "5" << std::flush;
  return static_cast<bool>(file);
}

}  // namespace

PeakMemory::PeakMemory(bool wanted) {
  if (!wanted) return;
#ifdef __GLIBC__
  malloc_trim(0);
#endif
  if (reset_peak()) before_ = status_bytes("VmRSS");
}

std::optional<std::size_t> PeakMemory::grown_by() const {
  if (!before_) return {};
  const std::optional<std::size_t> peak = status_bytes("VmHWM");
  if (!peak) return {};
  return *peak > *before_ ? *peak - *before_ : 0;
}

}  // namespace selvedge
