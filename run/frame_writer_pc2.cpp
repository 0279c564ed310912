// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/files.h>
#include <selvedge/run/frame_writer.h>

#include <bit>
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

Pc2Header pc2_header(std::size_t points, int samples, const std::string& file) {
  if (points > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    throw std::invalid_argument(file + ": a .pc2 file cannot hold " + std::to_string(points) +
                                " points");
  Pc2Header header;
  header.points = static_cast<std::int32_t>(points);
  header.samples = samples;
  return header;
}

std::uint64_t pc2_size(std::size_t points, int samples) {
  return sizeof(Pc2Header) + 3 * sizeof(float) * points * static_cast<std::size_t>(samples);
}

/// "" if the open file is a cache of `points` points with at least `samples` samples, else its
/// fault.
std::string pc2_fault(const OpenFile& file, std::size_t points, int samples) {
  Pc2Header header;
  if (file.read(&header, sizeof header, 0) != sizeof header ||
      std::memcmp(header.magic, Pc2Header{}.magic, sizeof header.magic) != 0)
    return "is not a .pc2 point cache";
  if (header.points < 0 || static_cast<std::size_t>(header.points) != points)
    return "has " + std::to_string(header.points) + " points a frame, not " +
           std::to_string(points);
  if (header.samples < samples || file.size() < pc2_size(points, samples))
    return "has fewer than " + std::to_string(samples) + " complete frames";
  return "";
}

}  // namespace

Pc2Writer::Pc2Writer(const std::filesystem::path& file, std::size_t points)
    : name_(file.string()), points_(points) {
  const Pc2Header header = pc2_header(points, 0, name_);
  file_ = std::make_unique<OpenFile>(file, OpenFile::Former::replaced);
  file_->write(&header, sizeof header, 0);
}

Pc2Writer::Pc2Writer(const std::filesystem::path& file, std::size_t points, int frames_kept)
    : name_(file.string()), points_(points), frames_(frames_kept) {
  const Pc2Header header = pc2_header(points, frames_kept, name_);
  file_ = std::make_unique<OpenFile>(file, OpenFile::Former::kept);
  const std::string fault = frames_kept < 0 ? "cannot keep a negative number of frames"
                                            : pc2_fault(*file_, points, frames_kept);
  if (!fault.empty()) throw std::invalid_argument(name_ + " " + fault);
  file_->write(&header, sizeof header, 0);
  file_->resize(pc2_size(points, frames_kept));
}

Pc2Writer::~Pc2Writer() = default;

void Pc2Writer::append(std::span<const Vec3> x) {
  if (x.size() != points_)
    throw std::invalid_argument(name_ + ": a frame of " + std::to_string(x.size()) +
                                " points for a cache of " + std::to_string(points_));
  std::vector<float> sample;
  sample.reserve(3 * points_);
  for (std::size_t i = 0; i < points_; ++i)
    for (const double coordinate : x[i]) {
      if (!(std::abs(coordinate) <= std::numeric_limits<float>::max()))
        throw std::invalid_argument(name_ + ": coordinate " + std::to_string(coordinate) +
                                    " of point " + std::to_string(i) + " does not fit a float");
      sample.push_back(static_cast<float>(coordinate));
    }
  file_->write(sample.data(), sample.size() * sizeof(float), pc2_size(points_, frames_));
  const Pc2Header header = pc2_header(points_, frames_ + 1, name_);
  file_->write(&header, sizeof header, 0);
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
