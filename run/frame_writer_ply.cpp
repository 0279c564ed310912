// SPDX-License-Identifier: MIT
#include <selvedge/run/frame_writer.h>
#include <selvedge/run/result_folder.h>

#include <utility>

namespace selvedge {
namespace {

namespace fs = std::filesystem;

class PlyFrames final : public FrameWriter {
 public:
  PlyFrames(fs::path folder, int digits) : folder_(std::move(folder)), digits_(digits) {}

  void write(const Frame& frame) override {
    write_ply(file("cloth", frame.number), frame.x, frame.triangles, frame.values);
    if (!frame.bodies.empty())
      write_ply(file("bodies", frame.number), frame.bodies, frame.body_triangles);
  }

 private:
  fs::path file(const char* stem, int number) const {
    return numbered(folder_, stem, number, digits_, ".ply");
  }

  fs::path folder_;
  int digits_;
};

}  // namespace

std::unique_ptr<FrameWriter> make_ply_writer(const fs::path& folder, int digits) {
  return std::make_unique<PlyFrames>(folder, digits);
}

void register_ply(FrameFormatRegistry& registry) {
  registry.add(
      "ply",
      {{.name = "pressure",
        .initial = 0.0,
        .unit = "",
        .kind = OptionKind::boolean,
        .meaning = "adds the contact pressure of the last step at each vertex, Pa; costs 8 bytes "
                   "a vertex and frame"}},
      [](const MethodOptions&, const fs::path& out) {
        return make_ply_writer(out / "frames", kFrameFileDigits);
      },
      {.promise = "doubles, velocity and flag per vertex; always written, since runs resume and "
                  "are checked from it",
       .source = "PLY - Polygon File Format, Greg Turk, 1994; binary little-endian",
       .extension = ".ply"});
}

}  // namespace selvedge
