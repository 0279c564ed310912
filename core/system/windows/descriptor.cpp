// SPDX-License-Identifier: MIT
#include <selvedge/core/system/detail/descriptor.h>
#include <selvedge/core/system/detail/windows.h>
#include <selvedge/core/system/internal/files.h>

#include <fcntl.h>
#include <io.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <string>
#include <system_error>

namespace selvedge::detail {
namespace {

constexpr std::size_t kMostAtOnce = std::size_t{1} << 30;  // bytes; the system counts in 32 bits
constexpr int kPermissions = _S_IREAD | _S_IWRITE;

/// Sets errno to the cause of the last error of the system.
std::ptrdiff_t failed() {
  errno = last_error().default_error_condition().value();
  return -1;
}

OVERLAPPED at_place(std::uint64_t place) {
  OVERLAPPED at{};
  at.Offset = static_cast<DWORD>(place);
  at.OffsetHigh = static_cast<DWORD>(place >> 32);
  return at;
}

HANDLE handle_of(int descriptor) { return reinterpret_cast<HANDLE>(_get_osfhandle(descriptor)); }

}  // namespace

int open_file(const std::filesystem::path& file, Opening opening) {
  const int access = opening == Opening::written ? _O_WRONLY : _O_RDWR;
  const int replace = opening == Opening::kept ? 0 : _O_CREAT | _O_TRUNC;
  return _wopen(file.c_str(), access | replace | _O_BINARY | _O_NOINHERIT, kPermissions);
}

int open_nameless(const std::filesystem::path& folder) {
  static std::atomic<int> number{0};
  const std::string name =
      "spool." + std::to_string(process_number()) + "." + std::to_string(number++);
  return _wopen((folder / name).c_str(),
                _O_RDWR | _O_CREAT | _O_EXCL | _O_TEMPORARY | _O_BINARY | _O_NOINHERIT,
                kPermissions);
}

int close_file(int descriptor) { return _close(descriptor); }

std::ptrdiff_t write_next(int descriptor, const void* bytes, std::size_t count) {
  return _write(descriptor, bytes, static_cast<unsigned>(std::min(count, kMostAtOnce)));
}

std::ptrdiff_t write_at(int descriptor, const void* bytes, std::size_t count, std::uint64_t place) {
  OVERLAPPED at = at_place(place);
  DWORD done = 0;
  const auto most = static_cast<DWORD>(std::min(count, kMostAtOnce));
  return WriteFile(handle_of(descriptor), bytes, most, &done, &at) != 0 ? done : failed();
}

std::ptrdiff_t read_at(int descriptor, void* bytes, std::size_t count, std::uint64_t place) {
  OVERLAPPED at = at_place(place);
  DWORD done = 0;
  const auto most = static_cast<DWORD>(std::min(count, kMostAtOnce));
  if (ReadFile(handle_of(descriptor), bytes, most, &done, &at) != 0) return done;
  return GetLastError() == ERROR_HANDLE_EOF ? 0 : failed();
}

std::int64_t size_of(int descriptor) { return _filelengthi64(descriptor); }

int resize_file(int descriptor, std::uint64_t bytes) {
  const errno_t error = _chsize_s(descriptor, static_cast<__int64>(bytes));
  if (error == 0) return 0;
  errno = error;
  return -1;
}

long process_number() { return static_cast<long>(GetCurrentProcessId()); }

}  // namespace selvedge::detail

// Windows tells only by an attempt.
bool selvedge::can_write_in(const std::filesystem::path& folder) {
  const int descriptor = detail::open_nameless(folder);
  return descriptor >= 0 && detail::close_file(descriptor) == 0;
}
