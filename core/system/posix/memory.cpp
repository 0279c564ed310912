// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/memory.h>
#include <sys/resource.h>

#include <fstream>
#include <string>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace selvedge {
namespace {

constexpr std::size_t kKilobyte = 1024;  // unit of Linux in getrusage and /proc

/// Bytes of a line of /proc/self/status, such as VmRSS.
std::optional<std::size_t> status_bytes(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != name + ":") continue;
    std::size_t kilobytes = 0;
    if (status >> kilobytes) return kilobytes * kKilobyte;
  }
  return {};
}

/// Restarts VmHWM, the peak that the system keeps; false if the system refuses.
bool reset_peak() {
  std::ofstream file("/proc/self/clear_refs");
  file << "5" << std::flush;
  return static_cast<bool>(file);
}

}  // namespace

std::size_t peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) * kKilobyte;
}

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
