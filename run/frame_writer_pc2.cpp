// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <selvedge/run/frame_writer.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace selvedge {

// The .pc2 layout, little-endian: 12 bytes "POINTCACHE2\0"; int32 version 1; int32 points; float
// first frame; float frames per sample; int32 samples; then float32 x y z of every point and
// sample.
namespace {

static_assert(std::endian::native == std::endian::little, "the .pc2 writer copies native numbers");

struct Pc2Header {
  char magic[12] = {'P', 'O', 'I', 'N', 'T', 'C', 'A', 'C', 'H', 'E', '2', '\0'};
  std::int32_t version = 1, points = 0;
  float first_frame = 1.0F, frames_per_sample = 1.0F;
  std::int32_t samples = 0;
};
static_assert(sizeof(Pc2Header) == 32);

[[noreturn]] void fail(const char* action, const std::filesystem::path& file) {
  throw std::runtime_error(std::string(action) + " " + file.string() + ": " + std::strerror(errno));
}

void write_at(int descriptor, const void* data, std::size_t count, off_t place,
              const std::filesystem::path& file) {
  const char* begin = static_cast<const char*>(data);
  while (count > 0) {
    const ssize_t written = ::pwrite(descriptor, begin, count, place);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("cannot write", file);
    begin += written;
    place += written;
    count -= static_cast<std::size_t>(written);
  }
}

Pc2Header pc2_header(std::size_t points, int samples, const std::filesystem::path& file) {
  if (points > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    throw std::invalid_argument(file.string() + ": a .pc2 file cannot hold " +
                                std::to_string(points) + " points");
  Pc2Header header;
  header.points = static_cast<std::int32_t>(points);
  header.samples = samples;
  return header;
}

off_t pc2_size(std::size_t points, int samples) {
  return static_cast<off_t>(sizeof(Pc2Header) +
                            3 * sizeof(float) * points * static_cast<std::size_t>(samples));
}

/// "" if the open file is a cache of `points` points with at least `samples` samples, else its
/// fault.
std::string pc2_fault(int descriptor, std::size_t points, int samples) {
  Pc2Header header;
  if (::pread(descriptor, &header, sizeof header, 0) != sizeof header ||
      std::memcmp(header.magic, Pc2Header{}.magic, sizeof header.magic) != 0)
    return "is not a .pc2 point cache";
  if (header.points < 0 || static_cast<std::size_t>(header.points) != points)
    return "has " + std::to_string(header.points) + " points a frame, not " +
           std::to_string(points);
  struct stat status {};
  const bool complete =
      ::fstat(descriptor, &status) == 0 && status.st_size >= pc2_size(points, samples);
  if (header.samples < samples || !complete)
    return "has fewer than " + std::to_string(samples) + " complete frames";
  return "";
}

}  // namespace

Pc2Writer::Pc2Writer(const std::filesystem::path& file, std::size_t points)
    : file_(file), points_(points) {
  const Pc2Header header = pc2_header(points, 0, file_);
  constexpr mode_t readable_by_all = 0666;
  descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, readable_by_all);
  if (descriptor_ < 0) fail("cannot open", file_);
  try {
    write_at(descriptor_, &header, sizeof header, 0, file_);
  } catch (const std::runtime_error&) {
    ::close(descriptor_);
    throw;
  }
}

Pc2Writer::Pc2Writer(const std::filesystem::path& file, std::size_t points, int frames_kept)
    : file_(file), points_(points), frames_(frames_kept) {
  const Pc2Header header = pc2_header(points, frames_kept, file_);
  descriptor_ = ::open(file_.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor_ < 0) fail("cannot open", file_);
  try {
    const std::string fault = frames_kept < 0 ? "cannot keep a negative number of frames"
                                              : pc2_fault(descriptor_, points, frames_kept);
    if (!fault.empty()) throw std::invalid_argument(file_.string() + " " + fault);
    write_at(descriptor_, &header, sizeof header, 0, file_);
    if (::ftruncate(descriptor_, pc2_size(points, frames_kept)) != 0) fail("cannot write", file_);
  } catch (const std::exception&) {
    ::close(descriptor_);
    throw;
  }
}

Pc2Writer::~Pc2Writer() { ::close(descriptor_); }

void Pc2Writer::append(std::span<const Vec3> x) {
  if (x.size() != points_)
    throw std::invalid_argument(file_.string() + ": a frame of " + std::to_string(x.size()) +
                                " points for a cache of " + std::to_string(points_));
  std::vector<float> sample;
  sample.reserve(3 * points_);
  for (std::size_t i = 0; i < points_; ++i)
    for (const double coordinate : x[i]) {
      if (!(std::abs(coordinate) <= std::numeric_limits<float>::max()))
        throw std::invalid_argument(file_.string() + ": coordinate " + std::to_string(coordinate) +
                                    " of point " + std::to_string(i) + " does not fit a float");
      sample.push_back(static_cast<float>(coordinate));
    }
  write_at(descriptor_, sample.data(), sample.size() * sizeof(float), pc2_size(points_, frames_),
           file_);
  const Pc2Header header = pc2_header(points_, frames_ + 1, file_);
  write_at(descriptor_, &header, sizeof header, 0, file_);
  ++frames_;
}

namespace {

/// A base mesh with the vertices of frame 0, and the cache of all frames.
class Pc2Frames final : public FrameWriter {
 public:
  explicit Pc2Frames(std::filesystem::path out) : out_(std::move(out)) {}

  void write(const Frame& frame) override {
    if (!cache_) {
      write_ply(out_ / "cloth_base.ply", frame.x, frame.triangles);
      cache_.emplace(out_ / "cloth.pc2", frame.x.size());
    }
    cache_->append(frame.x);
  }

 private:
  std::filesystem::path out_;
  std::optional<Pc2Writer> cache_;
};

}  // namespace

void register_pc2(FrameFormatRegistry& registry) {
  registry.add("pc2", {},
               [](const MethodOptions&, const std::filesystem::path& out) {
                 return std::make_unique<Pc2Frames>(out);
               },
               {.promise = "one point cache of all frames in float beside a base mesh, for Blender",
                .source = "POINTCACHE2, as Blender's mesh-cache modifier reads it",
                .files = {"cloth.pc2", "cloth_base.ply"},
                .one_mesh = true});
}

}  // namespace selvedge
