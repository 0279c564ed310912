// SPDX-License-Identifier: MIT
#include <selvedge/run/frame_writer.h>
#include <selvedge/run/result_folder.h>

#include <utility>

namespace selvedge {
namespace {

namespace fs = std::filesystem;

class ObjFrames final : public FrameWriter {
 public:
  explicit ObjFrames(fs::path folder) : folder_(std::move(folder)) {}

  void write(const Frame& frame) override {
    write_obj(file("cloth", frame.number), frame.x, frame.triangles);
    if (!frame.bodies.empty())
      write_obj(file("bodies", frame.number), frame.bodies, frame.body_triangles);
  }

 private:
  fs::path file(const char* stem, int number) const {
    return numbered(folder_, stem, number, kFrameFileDigits, ".obj");
  }

  fs::path folder_;
};

}  // namespace

void register_obj(FrameFormatRegistry& registry) {
  registry.add(
      "obj", {},
      [](const MethodOptions&, const fs::path& out) {
        return std::make_unique<ObjFrames>(out / "frames");
      },
      {.promise = "one text file per frame with 17 significant digits, which read back exactly",
       .source = "Wavefront OBJ, Advanced Visualizer manual, appendix B1",
       .extension = ".obj"});
}

}  // namespace selvedge
