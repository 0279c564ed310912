// SPDX-License-Identifier: MIT
#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

/// Shared by the fuzz targets, which scripts/fuzz.sh builds and runs. A target passes if a reader
/// returns or throws std::invalid_argument; sanitizers find the rest.
namespace selvedge::fuzz {

/// A file of these bytes in memory (/dev/shm), removed at the end of the process.
class InputFile {
 public:
  explicit InputFile(const std::string& extension)
      : path_("/dev/shm/selvedge_fuzz_" + std::to_string(getpid()) + extension) {}
  ~InputFile() { std::filesystem::remove(path_); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::filesystem::path& holding(const std::uint8_t* bytes, std::size_t n) const {
    std::ofstream(path_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes), static_cast<std::streamsize>(n));
    return path_;
  }

 private:
  std::filesystem::path path_;
};

}  // namespace selvedge::fuzz
