// SPDX-License-Identifier: MIT
#include <selvedge/bodies/mesh_file.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace selvedge {

namespace {

constexpr std::size_t buffer_size = std::size_t{1} << 20;  // bytes per write call
constexpr int exact_digits = 17;  // 17 significant decimal digits identify every double

[[noreturn]] void refuse_write(const std::filesystem::path& file, int cause) {
  throw std::runtime_error(file.string() +
                           ": cannot be written: " + std::generic_category().message(cause));
}

/// A file that appears under its name only when it is whole; a temporary one beside it until then.
class WholeFile {
 public:
  explicit WholeFile(const std::filesystem::path& file) : file_(file), part_(file) {
    refuse_special(file);
    part_ += ".part" + std::to_string(::getpid());
    descriptor_ = ::open(part_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor_ < 0) refuse_write(file_, errno);
    buffer_.reserve(buffer_size);
  }
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;
  ~WholeFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!committed_) ::unlink(part_.c_str());
  }

  void append(const void* bytes, std::size_t n) {
    if (buffer_.size() + n > buffer_size) flush();
    buffer_.append(static_cast<const char*>(bytes), n);
  }
  void append(std::string_view text) { append(text.data(), text.size()); }

  void commit() {
    flush();
    const int descriptor = std::exchange(descriptor_, -1);
    if (::close(descriptor) != 0) refuse_write(file_, errno);
    if (::rename(part_.c_str(), file_.c_str()) != 0) refuse_write(file_, errno);
    committed_ = true;
  }

 private:
  // A rename would replace a device or a pipe by a plain file.
  static void refuse_special(const std::filesystem::path& file) {
    struct stat status {};
    if (::stat(file.c_str(), &status) != 0) return;
    if (S_ISDIR(status.st_mode)) refuse_write(file, EISDIR);
    if (!S_ISREG(status.st_mode))
      throw std::runtime_error(file.string() + ": cannot be written: not a regular file");
  }

  void flush() {
    for (std::size_t done = 0; done < buffer_.size();) {
      const ssize_t n = ::write(descriptor_, buffer_.data() + done, buffer_.size() - done);
      if (n < 0 && errno != EINTR) refuse_write(file_, errno);
      if (n > 0) done += static_cast<std::size_t>(n);
    }
    buffer_.clear();
  }

  std::filesystem::path file_, part_;
  int descriptor_ = -1;
  bool committed_ = false;
  std::string buffer_;
};

template <class T>
void append_little_endian(WholeFile& file, T value) {
  auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if constexpr (std::endian::native == std::endian::big) std::reverse(bytes.begin(), bytes.end());
  file.append(bytes.data(), bytes.size());
}

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
  for (const NamedValues& values : extra) header += "property double " + values.name + "\n";
  return header + "element face " + std::to_string(triangles) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

void append_number(std::string& text, double value) {
  char digits[40];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value,
                                          std::chars_format::general, exact_digits);
  text.append(digits, end);
}

}  // namespace

void write_ply(const std::filesystem::path& file, std::span<const Vec3> x,
               std::span<const Triangle> triangles, std::span<const NamedValues> extra) {
  check_extra(extra, x.size());
  WholeFile out(file);
  out.append(ply_header(x.size(), triangles.size(), extra));
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (int k = 0; k < 3; ++k) append_little_endian(out, x[i][k]);
    for (const NamedValues& values : extra) append_little_endian(out, values.values[i]);
  }
  for (const Triangle& t : triangles) {
    append_little_endian(out, std::uint8_t{3});
    for (const std::int32_t v : t) append_little_endian(out, v);
  }
  out.commit();
}

void write_obj(const std::filesystem::path& file, std::span<const Vec3> x,
               std::span<const Triangle> triangles) {
  WholeFile out(file);
  std::string line;
  for (const Vec3& p : x) {
    line.assign(1, 'v');
    for (int k = 0; k < 3; ++k) append_number(line += ' ', p[k]);
    out.append(line += '\n');
  }
  for (const Triangle& t : triangles)  // OBJ counts from 1; 2^31 needs 64 bits
    out.append("f " + std::to_string(std::int64_t{t[0]} + 1) + ' ' +
               std::to_string(std::int64_t{t[1]} + 1) + ' ' +
               std::to_string(std::int64_t{t[2]} + 1) + '\n');
  out.commit();
}

}  // namespace selvedge
