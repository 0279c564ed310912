// SPDX-License-Identifier: MIT
#include <selvedge/core/system/detail/windows.h>
#include <selvedge/core/system/internal/memory.h>

#include <psapi.h>

namespace selvedge {

std::size_t peak_bytes() {
  PROCESS_MEMORY_COUNTERS memory{};
  memory.cb = sizeof memory;
  if (K32GetProcessMemoryInfo(GetCurrentProcess(), &memory, sizeof memory) == 0) return 0;
  return memory.PeakWorkingSetSize;
}

// Windows cannot restart the peak that it keeps.
PeakMemory::PeakMemory(bool) {}

std::optional<std::size_t> PeakMemory::grown_by() const { return before_; }

}  // namespace selvedge
