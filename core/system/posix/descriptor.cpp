// SPDX-License-Identifier: MIT
#include <selvedge/core/system/detail/descriptor.h>
#include <selvedge/core/system/internal/files.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

namespace selvedge::detail {

int open_file(const std::filesystem::path& file, Opening opening) {
  constexpr mode_t readable_by_all = 0666;  // masked by the process's umask
  const int access = opening == Opening::written ? O_WRONLY : O_RDWR;
  const int replace = opening == Opening::kept ? 0 : O_CREAT | O_TRUNC;
  return ::open(file.c_str(), access | replace | O_CLOEXEC, readable_by_all);
}

int open_nameless(const std::filesystem::path& folder) {
  std::string name = (folder / "spool.XXXXXX").string();
  const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);
  if (descriptor >= 0) ::unlink(name.c_str());
  return descriptor;
}

int close_file(int descriptor) { return ::close(descriptor); }

std::ptrdiff_t write_next(int descriptor, const void* bytes, std::size_t count) {
  return ::write(descriptor, bytes, count);
}

std::ptrdiff_t write_at(int descriptor, const void* bytes, std::size_t count, std::uint64_t place) {
  return ::pwrite(descriptor, bytes, count, static_cast<off_t>(place));
}

std::ptrdiff_t read_at(int descriptor, void* bytes, std::size_t count, std::uint64_t place) {
  return ::pread(descriptor, bytes, count, static_cast<off_t>(place));
}

std::int64_t size_of(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) != 0 ? -1 : static_cast<std::int64_t>(status.st_size);
}

int resize_file(int descriptor, std::uint64_t bytes) {
  return ::ftruncate(descriptor, static_cast<off_t>(bytes));
}

long process_number() { return ::getpid(); }

}  // namespace selvedge::detail

bool selvedge::can_write_in(const std::filesystem::path& folder) {
  return ::access(folder.c_str(), W_OK | X_OK) == 0;
}
