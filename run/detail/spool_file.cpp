// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/files.h>
#include <selvedge/run/detail/spool_file.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace selvedge::detail {

SpoolFile::SpoolFile(const std::filesystem::path& folder) : file_(OpenFile::nameless(folder)) {}

void SpoolFile::append(const void* bytes, std::size_t count) {
  file_.write(bytes, count, size_);
  size_ += count;
}

void SpoolFile::copy_to(AtomicFile& out) const {
  constexpr std::size_t block = std::size_t{1} << 20;
  std::vector<char> buffer(std::min(block, std::max<std::size_t>(size_, 1)));
  for (std::size_t place = 0; place < size_;) {
    const std::size_t got =
        file_.read(buffer.data(), std::min(buffer.size(), size_ - place), place);
    if (got == 0) throw std::runtime_error("a temporary file has lost its end");
    out.write(buffer.data(), got);
    place += got;
  }
}

}  // namespace selvedge::detail
