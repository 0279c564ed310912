// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/run/detail/part_mesh.h>
#include <selvedge/run/frame_writer.h>
#include <selvedge/run/result_folder.h>

#include <iterator>
#include <string>
#include <utility>
#include <vector>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using Buffer = fmt::memory_buffer;

/// Names of objects and materials end at a blank.
std::string word(std::string name) {
  for (char& c : name)
    if (c == ' ' || c == '\t' || c == '\n' || c == '#') c = '_';
  return name;
}

/// The vertices of the frame keep their numbers, whatever part they are of.
void add_part(const detail::PartMesh& part, std::span<const Vec3> x, std::size_t& textures,
              std::size_t& normals, Buffer& out) {
  auto to = std::back_inserter(out);
  fmt::format_to(to, "o {}\nusemtl {}\n", word(part.name), word(part.name));
  for (const TexturePoint& uv : part.texture) fmt::format_to(to, "vt {} {}\n", uv[0], uv[1]);
  for (const Vec3& n : detail::normals_of(part, detail::points_of(part, x)))
    fmt::format_to(to, "vn {} {} {}\n", n.x(), n.y(), n.z());
  for (const Triangle& t : part.triangles) {
    fmt::format_to(to, "f");
    for (const std::int32_t corner : t) {
      const auto k = static_cast<std::size_t>(corner);
      fmt::format_to(to, " {}/", std::int64_t{part.source[k]} + 1);
      if (!part.texture.empty()) fmt::format_to(to, "{}", textures + k + 1);
      fmt::format_to(to, "/{}", normals + k + 1);
    }
    fmt::format_to(to, "\n");
  }
  textures += part.texture.size();
  normals += part.source.size();
}

class ObjFrames final : public FrameWriter {
 public:
  explicit ObjFrames(fs::path folder) : folder_(std::move(folder)) {}

  void write(const Frame& frame) override {
    using detail::FrameHalf;
    write_half("cloth", frame.number, frame.x, detail::part_meshes(frame, FrameHalf::cloth));
    if (!frame.bodies.empty())
      write_half("bodies", frame.number, frame.bodies,
                 detail::part_meshes(frame, FrameHalf::bodies));
  }

 private:
  void write_half(const char* stem, int number, std::span<const Vec3> x,
                  const std::vector<detail::PartMesh>& parts) const {
    Buffer text;
    auto to = std::back_inserter(text);
    const std::string materials = std::string(stem) + ".mtl";
    fmt::format_to(to, "mtllib {}\n", materials);
    for (const Vec3& p : x) fmt::format_to(to, "v {} {} {}\n", p.x(), p.y(), p.z());
    std::size_t textures = 0, normals = 0;
    for (const detail::PartMesh& part : parts) add_part(part, x, textures, normals, text);
    save(numbered(folder_, stem, number, kFrameFileDigits, ".obj"), text);
    if (number == 0) write_materials(folder_ / materials, parts);
  }

  static void write_materials(const fs::path& file, const std::vector<detail::PartMesh>& parts) {
    Buffer text;
    for (const detail::PartMesh& part : parts)
      fmt::format_to(std::back_inserter(text), "newmtl {}\nKd {} {} {}\n", word(part.name),
                     part.colour.x(), part.colour.y(), part.colour.z());
    save(file, text);
  }

  static void save(const fs::path& file, const Buffer& text) {
    AtomicFile out(file);
    out.write({text.data(), text.size()});
    out.commit();
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
      {.promise = "one text file per frame, positions in full precision, an object for each piece "
                  "and body with normals, texture coordinates and colour",
       .source = "Wavefront OBJ, Advanced Visualizer manual, appendix B1",
       .extension = ".obj",
       .files = {"frames/cloth.mtl", "frames/bodies.mtl"}});
}

}  // namespace selvedge
