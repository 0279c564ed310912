// SPDX-License-Identifier: MIT
#pragma once

#include <unistd.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
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

/// Numbers from the bytes of an input; zeros once it is used up.
class Bytes {
 public:
  Bytes(const std::uint8_t* bytes, std::size_t n) : at_(bytes), left_(n) {}

  std::uint8_t byte() {
    if (left_ == 0) return 0;
    --left_;
    return *at_++;
  }
  /// In [0, n).
  int below(int n) { return byte() % n; }
  /// In [low, high], in 255 steps.
  double between(double low, double high) { return low + (high - low) * byte() / 255.0; }
  /// From a table of small integers and numbers of other magnitudes, so that degenerate positions
  /// are common; the byte 255 takes the next eight bytes as a double.
  double coordinate() {
    constexpr double kOther[] = {5e-324, -5e-324, 1e-310, 1e-160,  -1e-60, 1e-18,
                                 1e18,   1e150,   0.1,    1.0 / 3, -0.7,   0x1p-52};
    const std::uint8_t b = byte();
    if (b < 200) return static_cast<double>(b % 9) - 4.0;
    if (b < 255) return kOther[(b - 200) % std::size(kOther)];
    double value = 0.0;
    std::array<std::uint8_t, sizeof value> raw;
    for (std::uint8_t& r : raw) r = byte();
    std::memcpy(&value, raw.data(), sizeof value);
    return std::isfinite(value) ? value : 0.0;
  }

 private:
  const std::uint8_t* at_;
  std::size_t left_;
};

}  // namespace selvedge::fuzz
