// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <selvedge/run/detail/spool_file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace selvedge::detail {

SpoolFile::SpoolFile(std::filesystem::path folder) : folder_(std::move(folder)) {
  std::string name = (folder_ / "spool.XXXXXX").string();
  descriptor_ = ::mkostemp(name.data(), O_CLOEXEC);
  if (descriptor_ < 0) fail("cannot make a temporary file in");
  ::unlink(name.c_str());
}

SpoolFile::~SpoolFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void SpoolFile::append(const void* bytes, std::size_t count) {
  const char* begin = static_cast<const char*>(bytes);
  while (count > 0) {
    const ssize_t written = ::pwrite(descriptor_, begin, count, static_cast<off_t>(size_));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("cannot write to a temporary file in");
    begin += written;
    size_ += static_cast<std::size_t>(written);
    count -= static_cast<std::size_t>(written);
  }
}

void SpoolFile::copy_to(AtomicFile& out) const {
  constexpr std::size_t block = std::size_t{1} << 20;
  std::vector<char> buffer(std::min(block, std::max<std::size_t>(size_, 1)));
  for (std::size_t place = 0; place < size_;) {
    const std::size_t wanted = std::min(buffer.size(), size_ - place);
    const ssize_t got = ::pread(descriptor_, buffer.data(), wanted, static_cast<off_t>(place));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail("cannot read a temporary file in");
    out.write(buffer.data(), static_cast<std::size_t>(got));
    place += static_cast<std::size_t>(got);
  }
}

void SpoolFile::fail(const char* action) const {
  throw std::system_error(errno, std::generic_category(), action + (" " + folder_.string()));
}

}  // namespace selvedge::detail
