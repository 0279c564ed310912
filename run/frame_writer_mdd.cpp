// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/files.h>
#include <selvedge/run/detail/float_points.h>
#include <selvedge/run/detail/spool_file.h>
#include <selvedge/run/frame_writer.h>

#include <bit>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace selvedge {
namespace {

namespace fs = std::filesystem;

/// The bytes of a 32-bit number, most significant first, as .mdd files have them.
template <class Number>
void append_big_endian(Number number, std::string& bytes) {
  static_assert(sizeof(Number) == 4);
  const auto bits = std::bit_cast<std::uint32_t>(number);
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(bits >> shift & 255u);
}

/// Layout: int32 frames, int32 points, float32 seconds of every frame, then float32 x y z of every
/// point and frame; all big-endian. The number of frames comes first, so the file is written last.
class MddFrames final : public FrameWriter {
 public:
  explicit MddFrames(fs::path out) : out_(std::move(out)) {}

  void write(const Frame& frame) override {
    const fs::path file = out_ / "cloth.mdd";
    if (frame.number == 0) {
      write_ply(out_ / "cloth_base.ply", frame.x, frame.triangles);
      spool_.emplace(out_);
      seconds_.clear();
      points_ = frame.x.size();
    }
    detail::check_point_count(frame.x.size(), points_, file);
    std::string bytes;
    for (const float x : detail::float_points(frame.x, file)) append_big_endian(x, bytes);
    spool_->append(bytes);
    seconds_.push_back(static_cast<float>(frame.time));
  }

  void finish() override {
    if (!spool_) return;
    std::string head;
    append_big_endian(static_cast<std::int32_t>(seconds_.size()), head);
    append_big_endian(static_cast<std::int32_t>(points_), head);
    for (const float s : seconds_) append_big_endian(s, head);
    AtomicFile file(out_ / "cloth.mdd");
    file.write(head);
    spool_->copy_to(file);
    file.commit();
  }

 private:
  fs::path out_;
  std::optional<detail::SpoolFile> spool_;
  std::vector<float> seconds_;
  std::size_t points_ = 0;
};

}  // namespace

void register_mdd(FrameFormatRegistry& registry) {
  registry.add(
      "mdd", {},
      [](const MethodOptions&, const fs::path& out) { return std::make_unique<MddFrames>(out); },
      {.promise = "one point cache of all frames in float beside a base mesh, written at "
                  "the end of the run",
       .source = "LightWave MDD, as Blender's mesh-cache modifier reads it",
       .files = {"cloth.mdd", "cloth_base.ply"},
       .one_mesh = true});
}

}  // namespace selvedge
