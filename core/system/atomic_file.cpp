// SPDX-License-Identifier: MIT
#include <selvedge/core/system/detail/descriptor.h>
#include <selvedge/core/system/internal/files.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

namespace selvedge {
namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 16;  // bytes per write call

}  // namespace

AtomicFile::AtomicFile(std::filesystem::path file) : file_(std::move(file)), partial_(file_) {
  buffer_.reserve(kBufferSize);
  std::error_code ignored;  // if the status cannot be queried, opening the file fails too
  const auto status = std::filesystem::status(file_, ignored);
  if (!std::filesystem::exists(status) || std::filesystem::is_regular_file(status))
    partial_ += ".partial" + std::to_string(detail::process_number());
  descriptor_ = detail::open_file(partial_, detail::Opening::written);
  if (descriptor_ < 0) fail("cannot open");
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) detail::close_file(descriptor_);
  std::error_code ignored;  // a file that is left over does no harm
  if (!committed_ && partial_ != file_) std::filesystem::remove(partial_, ignored);
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
  if (detail::close_file(std::exchange(descriptor_, -1)) != 0) fail("cannot write");
  std::error_code error;
  if (partial_ != file_) std::filesystem::rename(partial_, file_, error);
  if (error) throw std::system_error(error, "cannot rename to " + file_.string());
  committed_ = true;
}

void AtomicFile::flush() {
  write_through(buffer_.data(), buffer_.size());
  buffer_.clear();
}

void AtomicFile::write_through(const std::byte* begin, std::size_t count) {
  while (count > 0) {
    const std::ptrdiff_t written = detail::write_next(descriptor_, begin, count);
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
