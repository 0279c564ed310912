// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/files.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

namespace selvedge {
namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 16;  // bytes per write call
constexpr mode_t kReadableByAll = 0666;                    // masked by the process's umask

}  // namespace

AtomicFile::AtomicFile(std::filesystem::path file) : file_(std::move(file)), partial_(file_) {
  buffer_.reserve(kBufferSize);
  std::error_code ignored;  // if the status cannot be queried, opening the file fails too
  const auto status = std::filesystem::status(file_, ignored);
  if (!std::filesystem::exists(status) || std::filesystem::is_regular_file(status))
    partial_ += ".partial" + std::to_string(::getpid());
  descriptor_ = ::open(partial_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kReadableByAll);
  if (descriptor_ < 0) fail("cannot open");
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!committed_ && partial_ != file_) ::unlink(partial_.c_str());
}

void AtomicFile::write(const void* bytes, std::size_t count) {
  const auto* begin = static_cast<const std::byte*>(bytes);
  if (buffer_.size() + count > kBufferSize) flush();
  if (count >= kBufferSize)
    write_through(begin, count);
  else
    buffer_.insert(buffer_.end(), begin, begin + count);
}

void AtomicFile::commit() {
  flush();
  if (::close(std::exchange(descriptor_, -1)) != 0) fail("cannot write");
  if (partial_ != file_ && ::rename(partial_.c_str(), file_.c_str()) != 0) fail("cannot rename to");
  committed_ = true;
}

void AtomicFile::flush() {
  write_through(buffer_.data(), buffer_.size());
  buffer_.clear();
}

void AtomicFile::write_through(const std::byte* begin, std::size_t count) {
  while (count > 0) {
    const ssize_t written = ::write(descriptor_, begin, count);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("cannot write");
    begin += written;
    count -= static_cast<std::size_t>(written);
  }
}

void AtomicFile::fail(const char* what) const {
  const std::error_code cause(errno, std::generic_category());
  throw std::system_error(cause, std::string(what) + " " + file_.string());
}

}  // namespace selvedge
