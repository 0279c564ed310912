// SPDX-License-Identifier: MIT
#include <selvedge/scene/output.h>

#include <fcntl.h>
#include <selvedge/core/atomic_file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no word for these, and null would hide that something went wrong.
Json number(double value) {
  if (std::isfinite(value)) return value;
  if (std::isnan(value)) return "nan";
  return value > 0.0 ? "inf" : "-inf";
}

Json numbers(const std::map<std::string, double>& values) {
  Json object = Json::object();
  for (const auto& [name, value] : values) object[name] = number(value);
  return object;
}

/// Text that may stand in an XML attribute.
std::string xml_escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '"')
      escaped += "&quot;";
    else
      escaped += c;
  }
  return escaped;
}

std::string shortest(double value) { return Json(value).dump(); }

constexpr const char* byte_order =
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

void write_result(const std::filesystem::path& file, const RunResult& result) {
  const TangleReport& t = result.tangle;
  const Json tangle = {{"start_pairs", t.start_pairs},     {"pairs", t.pairs},
                       {"elsewhere", t.elsewhere},         {"until_s", number(t.until_s)},
                       {"max_speed", number(t.max_speed)}, {"given_up", t.given_up}};
  Json flags = Json::object();
  for (int bit = 0; bit < kVertexFlags; ++bit)
    flags[flag_name(bit)] = {{"end", result.flags.end[bit]}, {"worst", result.flags.worst[bit]}};
  Json ledger = Json::object();
  for (const auto& [stage, figures] : result.ledger) ledger[stage] = numbers(figures);
  Json plan = Json::object();
  for (const auto& [part, p] : result.plan)
    plan[part] = {{"asked", p.asked}, {"left_out", p.left_out}, {"saved_s", number(p.saved_s)}};
  const Json json = {
      {"clean", result.clean},
      {"clean_elsewhere", result.clean_elsewhere},
      {"frames", result.frames},
      {"steps", result.steps},
      {"halvings", result.halvings},
      {"retried_steps", result.retried_steps},
      {"wall_s", number(result.wall_s)},
      {"phase_s", numbers(result.phase_s)},
      {"worst_self_intersections", result.worst_self_intersections},
      {"worst_body_intersections", result.worst_body_intersections},
      {"max_penetration_m", number(result.max_penetration_m)},
      {"max_stretch", number(result.max_stretch)},
      {"strain_residual", number(result.strain_residual)},
      {"final_max_speed", number(result.final_max_speed)},
      {"peak_bytes", result.peak_bytes},
      {"tangle", tangle},
      {"flags", flags},
      {"state_hash", result.state_hash},
      {"stopped", result.stopped},
      {"counters", numbers(result.counters)},
      {"ledger", ledger},
      {"plan", plan},
      {"measures", numbers(result.measures)},
  };
  AtomicFile out(file);
  out.write(json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  out.commit();
}

std::filesystem::path numbered(const std::filesystem::path& folder, const std::string& stem,
                               int number, int digits, const std::string& extension) {
  std::string text = std::to_string(number);
  if (const auto width = static_cast<std::size_t>(digits); digits > 0 && text.size() < width)
    text.insert(0, width - text.size(), '0');
  return folder / (stem + "_" + text + extension);
}

void write_vtp(const std::filesystem::path& file, std::span<const Vec3> x, std::span<const Vec3> v,
               std::span<const Triangle> triangles) {
  if (!v.empty() && v.size() != x.size())
    throw std::invalid_argument("write_vtp: " + std::to_string(v.size()) + " velocities for " +
                                std::to_string(x.size()) + " points");
  const Polygons faces = polygons(triangles);
  AppendedArrays arrays;
  std::string head =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"" +
      std::string(byte_order) + "\" header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"" +
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
            xml_escaped(piece.generic_string()) + "\"/>\n";
  }
  AtomicFile out(file);
  out.write(text + "</Collection>\n</VTKFile>\n");
  out.commit();
}

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

[[noreturn]] void fail(const char* what, const std::filesystem::path& file) {
  throw std::runtime_error(std::string(what) + " " + file.string() + ": " + std::strerror(errno));
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

/// "" if the open file is a cache of so many points that holds so many samples, else why not.
std::string pc2_fault(int descriptor, std::size_t points, int samples) {
  Pc2Header header;
  if (::pread(descriptor, &header, sizeof header, 0) != sizeof header ||
      std::memcmp(header.magic, Pc2Header{}.magic, sizeof header.magic) != 0)
    return "is no .pc2 point cache";
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

}  // namespace selvedge
