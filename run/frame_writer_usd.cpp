// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/run/detail/float_points.h>
#include <selvedge/run/detail/part_mesh.h>
#include <selvedge/run/detail/spool_file.h>
#include <selvedge/run/frame_writer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace selvedge {
namespace {

namespace fs = std::filesystem;

/// A name that a path of USD may hold: letters, digits and underscores, no digit first.
std::string prim_name(const std::string& name) {
  std::string path;
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    const bool digit = c >= '0' && c <= '9';
    if (digit && path.empty()) path += '_';
    path += letter || digit ? c : '_';
  }
  return path.empty() ? "_" : path;
}

std::string quoted(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') text += '\\';
    text += c == '\n' ? ' ' : c;
  }
  return text + '"';
}

/// "(x, y, z), ..." of the numbers, three by three.
std::string vectors(const std::vector<float>& p) {
  std::string text;
  for (std::size_t i = 0; i < p.size(); i += 3)
    text += fmt::format("{}({}, {}, {})", i == 0 ? "" : ", ", p[i], p[i + 1], p[i + 2]);
  return text;
}

std::string list_of(const std::vector<float>& values) {
  return fmt::format("{}", fmt::join(values, ", "));
}

/// One UsdGeomMesh whose points are sampled in time. The samples go to files of their own, because
/// a stage names all samples of one attribute together.
class UsdMesh {
 public:
  UsdMesh(detail::PartMesh part, std::string prim, const fs::path& out)
      : part_(std::move(part)),
        prim_(std::move(prim)),
        file_(out / "result.usda"),
        points_(out),
        normals_(out),
        extents_(out),
        flags_(out),
        pressure_(out) {}

  void append(int number, std::span<const Vec3> x, std::span<const NamedValues> values) {
    const std::vector<Vec3> points = detail::points_of(part_, x);
    const std::vector<float> p = detail::float_points(points, file_);
    if (p != points_now_) {
      // Readers draw straight lines from sample to sample: one at the end of a rest.
      if (written_ >= 0 && written_ < number - 1) add_sample(number - 1);
      points_now_ = p;
      normals_now_ = detail::float_points(detail::normals_of(part_, points), file_);
      add_sample(number);
    }
    if (const auto flags = detail::values_of(part_, values, "flag"); !flags.empty())
      add(flags_, number, list_of(flags));
    if (const auto pressure = detail::values_of(part_, values, "pressure"); !pressure.empty())
      add(pressure_, number, list_of(pressure));
  }

  void write(AtomicFile& out) const {
    if (written_ < 0) return;
    out.write(
        fmt::format("    def Mesh \"{}\" (\n        customData = {{\n            string name = "
                    "{}\n        }}\n    )\n"
                    "    {{\n",
                    prim_, quoted(part_.name)));
    out.write("        uniform bool doubleSided = 1\n");
    out.write("        uniform token orientation = \"rightHanded\"\n");
    out.write("        uniform token subdivisionScheme = \"none\"\n");
    const Vec3& c = part_.colour;
    out.write(fmt::format("        color3f[] primvars:displayColor = [({}, {}, {})]\n", c.x(),
                          c.y(), c.z()));
    std::string counts, indices;
    for (const Triangle& t : part_.triangles) {
      const char* separator = counts.empty() ? "" : ", ";
      counts += fmt::format("{}3", separator);
      indices += fmt::format("{}{}, {}, {}", separator, t[0], t[1], t[2]);
    }
    out.write("        int[] faceVertexCounts = [" + counts + "]\n");
    out.write("        int[] faceVertexIndices = [" + indices + "]\n");
    write_texture(out);
    write_samples(out, "float3[] extent", extents_, false);
    write_samples(out, "point3f[] points", points_, false);
    write_samples(out, "normal3f[] normals", normals_, true);
    write_samples(out, "float[] primvars:flag", flags_, true);
    write_samples(out, "float[] primvars:pressure", pressure_, true);
    out.write("    }\n");
  }

 private:
  void add_sample(int number) {
    add(points_, number, vectors(points_now_));
    add(normals_, number, vectors(normals_now_));
    extents_.append(extent(number, points_now_));
    written_ = number;
  }

  static void add(detail::SpoolFile& file, int number, const std::string& values) {
    file.append(fmt::format("            {}: [", number));
    file.append(values + "],\n");
  }

  static void write_samples(AtomicFile& out, const char* attribute,
                            const detail::SpoolFile& samples, bool by_vertex) {
    if (samples.size() == 0) return;
    out.write(fmt::format("        {}.timeSamples = {{\n", attribute));
    samples.copy_to(out);
    out.write("        }\n");
    if (by_vertex)
      out.write(fmt::format("        {} (\n            interpolation = \"vertex\"\n        )\n",
                            attribute));
  }

  void write_texture(AtomicFile& out) const {
    if (part_.texture.empty()) return;
    std::string list;
    for (const TexturePoint& uv : part_.texture)
      list += fmt::format("{}({}, {})", list.empty() ? "" : ", ", static_cast<float>(uv[0]),
                          static_cast<float>(uv[1]));
    out.write("        texCoord2f[] primvars:st = [" + list +
              "] (\n            interpolation = \"vertex\"\n        )\n");
  }

  static std::string extent(int number, const std::vector<float>& p) {
    std::array<float, 3> low{}, high{};
    for (std::size_t i = 0; i < p.size(); ++i) {
      const std::size_t axis = i % 3;
      low[axis] = i < 3 ? p[i] : std::min(low[axis], p[i]);
      high[axis] = i < 3 ? p[i] : std::max(high[axis], p[i]);
    }
    return fmt::format("            {}: [({}, {}, {}), ({}, {}, {})],\n", number, low[0], low[1],
                       low[2], high[0], high[1], high[2]);
  }

  detail::PartMesh part_;
  std::string prim_;
  fs::path file_;
  detail::SpoolFile points_, normals_, extents_, flags_, pressure_;
  std::vector<float> points_now_, normals_now_;
  int written_ = -1;  // number of the last sample
};

class UsdFrames final : public FrameWriter {
 public:
  explicit UsdFrames(fs::path out) : out_(std::move(out)) {}

  void write(const Frame& frame) override {
    if (frame.number == 0) start(frame);
    if (frame.number == 1 && frame.time > 0.0) fps_ = rounded(1.0 / frame.time);
    detail::check_point_count(frame.x.size(), vertices_, out_ / "result.usda");
    for (UsdMesh& mesh : cloth_) mesh.append(frame.number, frame.x, frame.values);
    if (!frame.bodies.empty())
      for (UsdMesh& mesh : bodies_) mesh.append(frame.number, frame.bodies, {});
    last_ = frame.number;
  }

  void finish() override {
    if (cloth_.empty()) return;
    AtomicFile file(out_ / "result.usda");
    file.write(
        fmt::format("#usda 1.0\n(\n    defaultPrim = \"result\"\n    endTimeCode = {}\n"
                    "    metersPerUnit = 1\n    startTimeCode = 0\n"
                    "    timeCodesPerSecond = {}\n    upAxis = \"Z\"\n)\n\n",
                    last_, fps_));
    file.write("def Xform \"result\"\n{\n");
    for (const auto* half : {&cloth_, &bodies_})
      for (const UsdMesh& mesh : *half) mesh.write(file);
    file.write("}\n");
    file.commit();
  }

 private:
  void start(const Frame& frame) {
    cloth_.clear();
    bodies_.clear();
    vertices_ = frame.x.size();
    std::set<std::string> taken;
    const auto add = [&](std::deque<UsdMesh>& meshes, detail::FrameHalf half) {
      for (detail::PartMesh& part : detail::part_meshes(frame, half)) {
        std::string prim = prim_name(part.name);
        while (!taken.insert(prim).second) prim += '_';
        meshes.emplace_back(std::move(part), std::move(prim), out_);
      }
    };
    add(cloth_, detail::FrameHalf::cloth);
    add(bodies_, detail::FrameHalf::bodies);
  }

  /// Without the rounding error of the time of a frame.
  static double rounded(double fps) {
    constexpr double digits = 1e9;
    return std::round(fps * digits) / digits;
  }

  fs::path out_;
  std::deque<UsdMesh> cloth_, bodies_;
  std::size_t vertices_ = 0;  // of each frame
  double fps_ = 24.0;         // that of a stage that does not say
  int last_ = 0;
};

}  // namespace

void register_usd(FrameFormatRegistry& registry) {
  registry.add(
      "usd", {},
      [](const MethodOptions&, const fs::path& out) { return std::make_unique<UsdFrames>(out); },
      {.promise = "one ASCII stage of all frames in float, z up, in metres, a mesh for each piece "
                  "and body with normals, texture coordinates, colour, flags and pressure, written "
                  "at the end of the run",
       .source = "Universal Scene Description, UsdGeomMesh with time samples",
       .files = {"result.usda"},
       .one_mesh = true});
}

}  // namespace selvedge
