// SPDX-License-Identifier: MIT
#include <selvedge/core/system/detail/descriptor.h>
#include <selvedge/core/system/internal/files.h>

#include <cerrno>
#include <system_error>

namespace selvedge {
namespace {

/// Calls `transfer(bytes, count, place)` until `count` bytes are done or it returns 0. Returns the
/// number of bytes done, or -1 after an error.
template <class Byte>
std::ptrdiff_t transfer_all(Byte* bytes, std::size_t count, std::uint64_t place, auto transfer) {
  std::size_t done = 0;
  while (done < count) {
    const std::ptrdiff_t more = transfer(bytes + done, count - done, place + done);
    if (more < 0 && errno == EINTR) continue;
    if (more < 0) return -1;
    if (more == 0) break;
    done += static_cast<std::size_t>(more);
  }
  return static_cast<std::ptrdiff_t>(done);
}

}  // namespace

OpenFile::OpenFile(const std::filesystem::path& file, Former former) : name_(file.string()) {
  using detail::Opening;
  descriptor_ =
      detail::open_file(file, former == Former::replaced ? Opening::replaced : Opening::kept);
  if (descriptor_ < 0) fail("cannot open");
}

OpenFile OpenFile::nameless(const std::filesystem::path& folder) {
  const std::string name = "a temporary file in " + folder.string();
  const int descriptor = detail::open_nameless(folder);
  if (descriptor >= 0) return {descriptor, name};
  throw std::system_error(errno, std::generic_category(), "cannot make " + name);
}

OpenFile::~OpenFile() { detail::close_file(descriptor_); }

void OpenFile::write(const void* bytes, std::size_t count, std::uint64_t place) {
  const auto write_some = [&](const char* from, std::size_t most, std::uint64_t at) {
    return detail::write_at(descriptor_, from, most, at);
  };
  if (transfer_all(static_cast<const char*>(bytes), count, place, write_some) < 0)
    fail("cannot write");
}

std::size_t OpenFile::read(void* bytes, std::size_t count, std::uint64_t place) const {
  const auto read_some = [&](char* to, std::size_t most, std::uint64_t at) {
    return detail::read_at(descriptor_, to, most, at);
  };
  const std::ptrdiff_t done = transfer_all(static_cast<char*>(bytes), count, place, read_some);
  if (done < 0) fail("cannot read");
  return static_cast<std::size_t>(done);
}

std::uint64_t OpenFile::size() const {
  const std::int64_t size = detail::size_of(descriptor_);
  if (size < 0) fail("cannot read");
  return static_cast<std::uint64_t>(size);
}

void OpenFile::resize(std::uint64_t bytes) {
  if (detail::resize_file(descriptor_, bytes) != 0) fail("cannot write");
}

void OpenFile::fail(const char* action) const {
  throw std::system_error(errno, std::generic_category(), action + (" " + name_));
}

}  // namespace selvedge
