// SPDX-License-Identifier: MIT
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/system/internal/files.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string>
#include <system_error>

namespace selvedge {

namespace {

constexpr int kExactDigits = 17;  // 17 significant decimal digits identify every double

/// Refuses devices and pipes, from which the mesh could not be read back.
void refuse_special(const std::filesystem::path& file) {
  std::error_code ignored;  // if the status cannot be queried, opening the file fails too
  const auto status = std::filesystem::status(file, ignored);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status) &&
      !std::filesystem::is_directory(status))
    throw std::runtime_error(file.string() + ": cannot be written: not a regular file");
}

template <class Fill>
void write_whole(const std::filesystem::path& file, const Fill& fill) {
  refuse_special(file);
  try {
    AtomicFile out(file);
    fill(out);
    out.commit();
  } catch (const std::system_error& error) {
    throw std::runtime_error(file.string() + ": cannot be written: " + error.code().message());
  }
}

/// Bytes of numbers on their way into a file, a block at a time.
class BinaryBlock {
 public:
  explicit BinaryBlock(AtomicFile& out) : out_(out) {}

  template <class T>
  void append(T value) {
    auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if constexpr (std::endian::native == std::endian::big) std::reverse(bytes.begin(), bytes.end());
    if (size_ + bytes.size() > block_.size()) flush();
    std::copy(bytes.begin(), bytes.end(), block_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += bytes.size();
  }
  void flush() {
    out_.write(block_.data(), size_);
    size_ = 0;
  }

 private:
  AtomicFile& out_;
  std::array<char, 4096> block_;
  std::size_t size_ = 0;
};

bool is_property_name(const std::string& name) {
  const bool taken = name == "x" || name == "y" || name == "z";
  return !name.empty() && !taken && std::none_of(name.begin(), name.end(), [](unsigned char c) {
    return c <= ' ' || c > '~';
  });
}

void check_extra(std::span<const NamedValues> extra, std::size_t vertices) {
  for (std::size_t i = 0; i < extra.size(); ++i) {
    if (!is_property_name(extra[i].name))
      throw std::invalid_argument("write_ply: '" + extra[i].name + "' cannot name a property");
    if (extra[i].values.size() != vertices)
      throw std::invalid_argument("write_ply: property '" + extra[i].name + "' has " +
                                  std::to_string(extra[i].values.size()) + " values for " +
                                  std::to_string(vertices) + " vertices");
    constexpr double highest = 255.0;
    if (extra[i].as_byte &&
        std::any_of(extra[i].values.begin(), extra[i].values.end(),
                    [](double v) { return !(v >= 0.0 && v <= highest) || v != std::floor(v); }))
      throw std::invalid_argument("write_ply: property '" + extra[i].name +
                                  "' has values that are not integers from 0 to 255");
    for (std::size_t j = 0; j < i; ++j)
      if (extra[j].name == extra[i].name)
        throw std::invalid_argument("write_ply: property '" + extra[i].name + "' is given twice");
  }
}

std::string ply_header(std::size_t vertices, std::size_t triangles,
                       std::span<const NamedValues> extra) {
  std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                       std::to_string(vertices) +
                       "\nproperty double x\nproperty double y\nproperty double z\n";
  for (const NamedValues& values : extra)
    header += (values.as_byte ? "property uchar " : "property double ") + values.name + "\n";
  return header + "element face " + std::to_string(triangles) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

void append_number(std::string& text, double value) {
  char digits[40];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value,
                                          std::chars_format::general, kExactDigits);
  text.append(digits, end);
}

}  // namespace

void write_ply(const std::filesystem::path& file, std::span<const Vec3> x,
               std::span<const Triangle> triangles, std::span<const NamedValues> extra) {
  check_extra(extra, x.size());
  write_whole(file, [&](AtomicFile& out) {
    out.write(ply_header(x.size(), triangles.size(), extra));
    BinaryBlock block(out);
    for (std::size_t i = 0; i < x.size(); ++i) {
      for (int k = 0; k < 3; ++k) block.append(x[i][k]);
      for (const NamedValues& values : extra)
        if (values.as_byte)
          block.append(static_cast<std::uint8_t>(values.values[i]));
        else
          block.append(values.values[i]);
    }
    for (const Triangle& t : triangles) {
      block.append(std::uint8_t{3});
      for (const std::int32_t v : t) block.append(v);
    }
    block.flush();
  });
}

void write_obj(const std::filesystem::path& file, std::span<const Vec3> x,
               std::span<const Triangle> triangles) {
  write_whole(file, [&](AtomicFile& out) {
    std::string line;
    for (const Vec3& p : x) {
      line.assign(1, 'v');
      for (int k = 0; k < 3; ++k) append_number(line += ' ', p[k]);
      out.write(line += '\n');
    }
    for (const Triangle& t : triangles)  // OBJ indices start at 1; 2^31 needs 64 bits
      out.write("f " + std::to_string(std::int64_t{t[0]} + 1) + ' ' +
                std::to_string(std::int64_t{t[1]} + 1) + ' ' +
                std::to_string(std::int64_t{t[2]} + 1) + '\n');
  });
}

}  // namespace selvedge
