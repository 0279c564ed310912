// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/files.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <system_error>

namespace selvedge {
namespace {

/// Calls `transfer(bytes, count, place)` until `count` bytes are done or it returns 0. Returns the
/// number of bytes done, or -1 after an error.
template <class Byte>
ssize_t transfer_all(Byte* bytes, std::size_t count, std::uint64_t place, auto transfer) {
  std::size_t done = 0;
  while (done < count) {
    const ssize_t more = transfer(bytes + done, count - done, static_cast<off_t>(place + done));
    if (more < 0 && errno == EINTR) continue;
    if (more < 0) return -1;
    if (more == 0) break;
    done += static_cast<std::size_t>(more);
  }
  return static_cast<ssize_t>(done);
}

}  // namespace

OpenFile::OpenFile(const std::filesystem::path& file, Former former) : name_(file.string()) {
  constexpr mode_t readable_by_all = 0666;  // masked by the process's umask
  const int replace = former == Former::replaced ? O_CREAT | O_TRUNC : 0;
  descriptor_ = ::open(file.c_str(), O_RDWR | O_CLOEXEC | replace, readable_by_all);
  if (descriptor_ < 0) fail("cannot open");
}

OpenFile OpenFile::nameless(const std::filesystem::path& folder) {
  std::string name = (folder / "spool.XXXXXX").string();
  const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);
  if (descriptor >= 0) {
    ::unlink(name.c_str());
    return {descriptor, "a temporary file in " + folder.string()};
  }
  throw std::system_error(errno, std::generic_category(),
                          "cannot make a temporary file in " + folder.string());
}

OpenFile::~OpenFile() { ::close(descriptor_); }

void OpenFile::write(const void* bytes, std::size_t count, std::uint64_t place) {
  const auto write_some = [&](const char* from, std::size_t most, off_t at) {
    return ::pwrite(descriptor_, from, most, at);
  };
  if (transfer_all(static_cast<const char*>(bytes), count, place, write_some) < 0)
    fail("cannot write");
}

std::size_t OpenFile::read(void* bytes, std::size_t count, std::uint64_t place) const {
  const auto read_some = [&](char* to, std::size_t most, off_t at) {
    return ::pread(descriptor_, to, most, at);
  };
  const ssize_t done = transfer_all(static_cast<char*>(bytes), count, place, read_some);
  if (done < 0) fail("cannot read");
  return static_cast<std::size_t>(done);
}

std::uint64_t OpenFile::size() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) fail("cannot read");
  return static_cast<std::uint64_t>(status.st_size);
}

void OpenFile::resize(std::uint64_t bytes) {
  if (::ftruncate(descriptor_, static_cast<off_t>(bytes)) != 0) fail("cannot write");
}

void OpenFile::fail(const char* action) const {
  throw std::system_error(errno, std::generic_category(), action + (" " + name_));
}

}  // namespace selvedge
