// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/run/detail/float_points.h>
#include <selvedge/run/detail/spool_file.h>
#include <selvedge/run/frame_writer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace selvedge {
namespace {

namespace fs = std::filesystem;

/// One UsdGeomMesh whose points are sampled in time. The samples of points and extents go to files
/// of their own, because a stage names all samples of one attribute together.
class UsdMesh {
 public:
  UsdMesh(std::string name, std::string colour, const fs::path& out)
      : name_(std::move(name)),
        colour_(std::move(colour)),
        file_(out / "result.usda"),
        points_(out),
        extents_(out) {}

  void start(std::span<const Triangle> triangles) {
    triangles_.assign(triangles.begin(), triangles.end());
  }

  void append(int number, std::span<const Vec3> x) {
    if (count_ == 0 && samples_ == 0) count_ = x.size();
    detail::check_point_count(x.size(), count_, file_);
    const std::vector<float> p = detail::float_points(x, file_);
    std::string text = fmt::format("            {}: [", number);
    for (std::size_t i = 0; i < p.size(); i += 3)
      text += fmt::format("{}({}, {}, {})", i == 0 ? "" : ", ", p[i], p[i + 1], p[i + 2]);
    points_.append(text + "],\n");
    extents_.append(extent(number, p));
    ++samples_;
  }

  void write(AtomicFile& out) const {
    if (samples_ == 0) return;
    out.write(fmt::format("    def Mesh \"{}\"\n    {{\n", name_));
    out.write("        uniform bool doubleSided = 1\n");
    out.write("        uniform token orientation = \"rightHanded\"\n");
    out.write("        uniform token subdivisionScheme = \"none\"\n");
    out.write(fmt::format("        color3f[] primvars:displayColor = [{}]\n", colour_));
    std::string counts, indices;
    for (const Triangle& t : triangles_) {
      const char* separator = counts.empty() ? "" : ", ";
      counts += fmt::format("{}3", separator);
      indices += fmt::format("{}{}, {}, {}", separator, t[0], t[1], t[2]);
    }
    out.write("        int[] faceVertexCounts = [" + counts + "]\n");
    out.write("        int[] faceVertexIndices = [" + indices + "]\n");
    out.write("        float3[] extent.timeSamples = {\n");
    extents_.copy_to(out);
    out.write("        }\n        point3f[] points.timeSamples = {\n");
    points_.copy_to(out);
    out.write("        }\n    }\n");
  }

 private:
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

  std::string name_, colour_;
  fs::path file_;
  detail::SpoolFile points_, extents_;
  std::vector<Triangle> triangles_;
  std::size_t count_ = 0, samples_ = 0;
};

class UsdFrames final : public FrameWriter {
 public:
  explicit UsdFrames(fs::path out) : out_(std::move(out)) {}

  void write(const Frame& frame) override {
    if (frame.number == 0) {
      cloth_.emplace("cloth", "(0.5, 0.085, 0.065)", out_);
      bodies_.emplace("bodies", "(0.47, 0.475, 0.485)", out_);
      cloth_->start(frame.triangles);
      bodies_->start(frame.body_triangles);
    }
    if (frame.number == 1 && frame.time > 0.0) fps_ = rounded(1.0 / frame.time);
    cloth_->append(frame.number, frame.x);
    if (!frame.bodies.empty()) bodies_->append(frame.number, frame.bodies);
    last_ = frame.number;
  }

  void finish() override {
    if (!cloth_) return;
    AtomicFile file(out_ / "result.usda");
    file.write(
        fmt::format("#usda 1.0\n(\n    defaultPrim = \"result\"\n    endTimeCode = {}\n"
                    "    metersPerUnit = 1\n    startTimeCode = 0\n"
                    "    timeCodesPerSecond = {}\n    upAxis = \"Z\"\n)\n\n",
                    last_, fps_));
    file.write("def Xform \"result\"\n{\n");
    cloth_->write(file);
    bodies_->write(file);
    file.write("}\n");
    file.commit();
  }

 private:
  /// Without the rounding error of the time of a frame.
  static double rounded(double fps) {
    constexpr double digits = 1e9;
    return std::round(fps * digits) / digits;
  }

  fs::path out_;
  std::optional<UsdMesh> cloth_, bodies_;
  double fps_ = 24.0;  // that of a stage that does not say
  int last_ = 0;
};

}  // namespace

void register_usd(FrameFormatRegistry& registry) {
  registry.add(
      "usd", {},
      [](const MethodOptions&, const fs::path& out) { return std::make_unique<UsdFrames>(out); },
      {.promise = "one ASCII stage of all frames in float with cloth and bodies, z up, in metres, "
                  "written at the end of the run",
       .source = "Universal Scene Description, UsdGeomMesh with time samples",
       .files = {"result.usda"},
       .one_mesh = true});
}

}  // namespace selvedge
