// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/html.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/run/frame_writer.h>
#include <selvedge/run/result_folder.h>

#include <bit>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace selvedge {
namespace {

namespace fs = std::filesystem;

/// The shortest text that reads back as the same double.
std::string shortest(double value) { return nlohmann::json(value).dump(); }

constexpr const char* kByteOrder =
    std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";

/// The arrays of a .vtp in the order of their offsets: each is a UInt64 byte count and the bytes.
class AppendedArrays {
 public:
  template <class T>
  std::string add(const std::vector<T>& values, const std::string& name, int components) {
    constexpr const char* type = std::is_same_v<T, double> ? "Float64" : "Int64";
    const std::string element = "<DataArray type=\"" + std::string(type) + "\" Name=\"" + name +
                                "\" NumberOfComponents=\"" + std::to_string(components) +
                                "\" format=\"appended\" offset=\"" + std::to_string(bytes_.size()) +
                                "\"/>\n";
    const std::uint64_t count = values.size() * sizeof(T);
    append(&count, sizeof count);
    append(values.data(), count);
    return element;
  }
  std::string_view bytes() const { return bytes_; }

 private:
  void append(const void* data, std::size_t count) {
    if (count > 0) bytes_.append(static_cast<const char*>(data), count);
  }
  std::string bytes_;
};

std::vector<double> flattened(std::span<const Vec3> values) {
  std::vector<double> flat;
  flat.reserve(3 * values.size());
  for (const Vec3& v : values) flat.insert(flat.end(), {v.x(), v.y(), v.z()});
  return flat;
}

struct Polygons {
  std::vector<std::int64_t> connectivity, offsets;
};

Polygons polygons(std::span<const Triangle> triangles) {
  Polygons result;
  result.connectivity.reserve(3 * triangles.size());
  result.offsets.reserve(triangles.size());
  for (const Triangle& t : triangles) {
    result.connectivity.insert(result.connectivity.end(), t.begin(), t.end());
    result.offsets.push_back(static_cast<std::int64_t>(result.connectivity.size()));
  }
  return result;
}

}  // namespace

void write_vtp(const std::filesystem::path& file, std::span<const Vec3> x, std::span<const Vec3> v,
               std::span<const Triangle> triangles) {
  if (!v.empty() && v.size() != x.size())
    throw std::invalid_argument("write_vtp: " + std::to_string(v.size()) + " velocities for " +
                                std::to_string(x.size()) + " points");
  const Polygons faces = polygons(triangles);
  AppendedArrays arrays;
  std::string head =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"" +
      std::string(kByteOrder) + "\" header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"" +
      std::to_string(x.size()) + "\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\"" +
      " NumberOfPolys=\"" + std::to_string(triangles.size()) + "\">\n";
  if (!v.empty())
    head += "<PointData Vectors=\"velocity\">\n" + arrays.add(flattened(v), "velocity", 3) +
            "</PointData>\n";
  head += "<Points>\n" + arrays.add(flattened(x), "Points", 3) + "</Points>\n<Polys>\n";
  head += arrays.add(faces.connectivity, "connectivity", 1);
  head += arrays.add(faces.offsets, "offsets", 1);
  head += "</Polys>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
  AtomicFile out(file);
  out.write(head);
  out.write(arrays.bytes());
  out.write("\n</AppendedData>\n</VTKFile>\n");
  out.commit();
}

void write_pvd(const std::filesystem::path& file, const std::vector<std::filesystem::path>& pieces,
               std::span<const double> times) {
  if (pieces.size() != times.size())
    throw std::invalid_argument("write_pvd: " + std::to_string(times.size()) + " times for " +
                                std::to_string(pieces.size()) + " files");
  const std::filesystem::path folder = std::filesystem::absolute(file).parent_path();
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n";
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const auto piece = std::filesystem::absolute(pieces[i]).lexically_relative(folder);
    text += "<DataSet timestep=\"" + shortest(times[i]) + "\" part=\"0\" file=\"" +
            html_escaped(piece.generic_string()) + "\"/>\n";
  }
  AtomicFile out(file);
  out.write(text + "</Collection>\n</VTKFile>\n");
  out.commit();
}

namespace {

class VtkFrames final : public FrameWriter {
 public:
  explicit VtkFrames(fs::path out) : out_(std::move(out)) {}

  void write(const Frame& frame) override {
    write_vtp(add(cloth_, "cloth", frame), frame.x, frame.v, frame.triangles);
    if (!frame.bodies.empty())
      write_vtp(add(bodies_, "bodies", frame), frame.bodies, {}, frame.body_triangles);
  }

  void update_series() override {
    write_pvd(out_ / "cloth.pvd", cloth_.pieces, cloth_.times);
    if (!bodies_.pieces.empty()) write_pvd(out_ / "bodies.pvd", bodies_.pieces, bodies_.times);
  }

 private:
  struct Series {
    std::vector<fs::path> pieces;
    std::vector<double> times;  // s
  };

  const fs::path& add(Series& series, const char* stem, const Frame& frame) const {
    series.times.push_back(frame.time);
    return series.pieces.emplace_back(
        numbered(out_ / "frames", stem, frame.number, kFrameFileDigits, ".vtp"));
  }

  fs::path out_;
  Series cloth_, bodies_;
};

}  // namespace

void register_vtk(FrameFormatRegistry& registry) {
  registry.add(
      "vtk", {},
      [](const MethodOptions&, const fs::path& out) { return std::make_unique<VtkFrames>(out); },
      {.promise = "a .vtp file per frame with velocities, and .pvd series, for ParaView",
       .source = "VTK XML PolyData file format, docs.vtk.org",
       .extension = ".vtp",
       .files = {"cloth.pvd", "bodies.pvd"}});
}

}  // namespace selvedge
