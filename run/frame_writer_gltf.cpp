// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/run/detail/float_points.h>
#include <selvedge/run/detail/spool_file.h>
#include <selvedge/run/frame_writer.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using GltfJson = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "the .glb writer copies native numbers");

// Constants of the glTF 2.0 specification.
constexpr int kUnsignedInt = 5125, kFloat = 5126;            // accessor.componentType
constexpr int kArrayBuffer = 34962, kElementBuffer = 34963;  // bufferView.target
constexpr std::uint32_t kMagic = 0x46546C67, kVersion = 2;   // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

/// glTF has y up: x, y, z of ours become x, z, -y.
std::vector<Vec3> with_y_up(std::span<const Vec3> x) {
  std::vector<Vec3> turned;
  turned.reserve(x.size());
  for (const Vec3& p : x) turned.emplace_back(p.x(), p.z(), -p.y());
  return turned;
}

/// The binary buffer of a file, and the views and accessors into it.
class GltfBuffer {
 public:
  explicit GltfBuffer(const fs::path& out) : bytes_(out) {}

  /// Appends numbers and returns the index of an accessor for them.
  template <class Number>
  int append(const std::vector<Number>& values, const char* type, std::size_t components,
             int target) {
    GltfJson view = {{"buffer", 0},
                     {"byteOffset", bytes_.size()},
                     {"byteLength", values.size() * sizeof(Number)}};
    if (target != 0) view["target"] = target;
    views_.push_back(std::move(view));
    bytes_.append(values.data(), values.size() * sizeof(Number));
    GltfJson accessor = {
        {"bufferView", views_.size() - 1},
        {"componentType",
         sizeof(Number) == 4 && std::is_integral_v<Number> ? kUnsignedInt : kFloat},
        {"count", values.size() / components},
        {"type", type}};
    if (std::is_floating_point_v<Number> && !values.empty())
      add_range(values, components, accessor);
    accessors_.push_back(std::move(accessor));
    return static_cast<int>(accessors_.size()) - 1;
  }

  const detail::SpoolFile& bytes() const { return bytes_; }
  const GltfJson& views() const { return views_; }
  const GltfJson& accessors() const { return accessors_; }

 private:
  template <class Number>
  static void add_range(const std::vector<Number>& values, std::size_t components,
                        GltfJson& accessor) {
    std::vector<Number> low(values.begin(),
                            values.begin() + static_cast<std::ptrdiff_t>(components));
    std::vector<Number> high = low;
    for (std::size_t i = 0; i < values.size(); ++i) {
      low[i % components] = std::min(low[i % components], values[i]);
      high[i % components] = std::max(high[i % components], values[i]);
    }
    accessor["min"] = low;
    accessor["max"] = high;
  }

  detail::SpoolFile bytes_;
  GltfJson views_ = GltfJson::array(), accessors_ = GltfJson::array();
};

/// A mesh whose first frame is its shape. Every later frame is a morph target: the differences of
/// all vertices from the first frame.
class GltfMesh {
 public:
  GltfMesh(std::string name, std::vector<double> colour, fs::path file)
      : name_(std::move(name)), colour_(std::move(colour)), file_(std::move(file)) {}

  bool empty() const { return base_.empty(); }
  std::size_t targets() const { return targets_.size(); }

  void append(std::span<const Vec3> x, std::span<const Triangle> triangles, float seconds,
              GltfBuffer& buffer) {
    std::vector<Vec3> points = with_y_up(x);
    seconds_.push_back(seconds);
    if (base_.empty()) {
      std::vector<std::uint32_t> indices;
      for (const Triangle& t : triangles) indices.insert(indices.end(), t.begin(), t.end());
      indices_ = buffer.append(indices, "SCALAR", 1, kElementBuffer);
      // Differences are taken from the positions as the file has them.
      base_ = detail::float_points(points, file_);
      position_ = buffer.append(base_, "VEC3", 3, kArrayBuffer);
      return;
    }
    detail::check_point_count(points.size(), base_.size() / 3, file_);
    for (std::size_t i = 0; i < points.size(); ++i)
      for (int axis = 0; axis < 3; ++axis)
        points[i][axis] -= base_[3 * i + static_cast<std::size_t>(axis)];
    targets_.push_back(buffer.append(detail::float_points(points, file_), "VEC3", 3, kArrayBuffer));
  }

  GltfJson mesh(int material) const {
    GltfJson primitive = {
        {"attributes", {{"POSITION", position_}}}, {"indices", indices_}, {"material", material}};
    GltfJson mesh = {{"name", name_}};
    if (!targets_.empty()) {
      for (const int target : targets_) primitive["targets"].push_back({{"POSITION", target}});
      mesh["weights"] = std::vector<int>(targets_.size(), 0);
    }
    mesh["primitives"] = GltfJson::array({std::move(primitive)});
    return mesh;
  }

  GltfJson material() const {
    GltfJson colour = colour_;
    return {{"name", name_},
            {"doubleSided", true},
            {"pbrMetallicRoughness",
             {{"baseColorFactor", colour}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.85}}}};
  }

  const std::string& name() const { return name_; }

  /// Accessors of the times and of the weights: frame i has weight 1 on target i - 1.
  std::pair<int, int> append_weights(GltfBuffer& buffer) const {
    std::vector<float> weights(seconds_.size() * targets_.size(), 0.0F);
    for (std::size_t i = 0; i < targets_.size(); ++i) weights[(i + 1) * targets_.size() + i] = 1.0F;
    const int times = buffer.append(seconds_, "SCALAR", 1, 0);
    return {times, buffer.append(weights, "SCALAR", 1, 0)};
  }

 private:
  std::string name_;
  std::vector<double> colour_;
  fs::path file_;
  std::vector<float> base_, seconds_;
  int indices_ = 0, position_ = 0;
  std::vector<int> targets_;
};

class GltfFrames final : public FrameWriter {
 public:
  explicit GltfFrames(fs::path out) : out_(std::move(out)) {}

  void write(const Frame& frame) override {
    const fs::path file = out_ / "result.glb";
    if (frame.number == 0) {
      buffer_.emplace(out_);
      meshes_.clear();
      meshes_.emplace_back("cloth", std::vector<double>{0.5, 0.085, 0.065, 1.0}, file);
      meshes_.emplace_back("bodies", std::vector<double>{0.47, 0.475, 0.485, 1.0}, file);
    }
    const auto seconds = static_cast<float>(frame.time);
    meshes_[0].append(frame.x, frame.triangles, seconds, *buffer_);
    if (!frame.bodies.empty())
      meshes_[1].append(frame.bodies, frame.body_triangles, seconds, *buffer_);
  }

  void finish() override {
    if (!buffer_) return;
    std::string json = description().dump();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::size_t total = 12 + 8 + json.size() + 8 + buffer_->bytes().size();
    if (total > std::numeric_limits<std::uint32_t>::max())
      throw std::runtime_error(
          fmt::format("{}: would have {} bytes, but a .glb file has at most 4 GiB; take usd or pc2",
                      (out_ / "result.glb").string(), total));
    AtomicFile file(out_ / "result.glb");
    const auto number = [&](std::size_t n) {
      const auto bits = static_cast<std::uint32_t>(n);
      file.write(&bits, sizeof bits);
    };
    for (const std::size_t n :
         {std::size_t{kMagic}, std::size_t{kVersion}, total, json.size(), std::size_t{kJsonChunk}})
      number(n);
    file.write(json);
    number(buffer_->bytes().size());
    number(kBinaryChunk);
    buffer_->bytes().copy_to(file);
    file.commit();
  }

 private:
  GltfJson description() {
    GltfJson json = {{"asset", {{"version", "2.0"}, {"generator", "selvedge"}}}, {"scene", 0}};
    GltfJson nodes = GltfJson::array(), channels = GltfJson::array(), samplers = GltfJson::array();
    for (const GltfMesh& mesh : meshes_) {
      if (mesh.empty()) continue;
      const int index = static_cast<int>(nodes.size());
      nodes.push_back({{"name", mesh.name()}, {"mesh", index}});
      json["meshes"].push_back(mesh.mesh(index));
      json["materials"].push_back(mesh.material());
      if (mesh.targets() == 0) continue;
      const auto [times, weights] = mesh.append_weights(*buffer_);
      channels.push_back(
          {{"sampler", samplers.size()}, {"target", {{"node", index}, {"path", "weights"}}}});
      samplers.push_back({{"input", times}, {"output", weights}, {"interpolation", "LINEAR"}});
    }
    std::vector<std::size_t> all(nodes.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
    json["scenes"] = GltfJson::array({GltfJson{{"nodes", all}}});
    json["nodes"] = std::move(nodes);
    if (!channels.empty())
      json["animations"] =
          GltfJson::array({GltfJson{{"channels", channels}, {"samplers", samplers}}});
    json["accessors"] = buffer_->accessors();
    json["bufferViews"] = buffer_->views();
    json["buffers"] = GltfJson::array({GltfJson{{"byteLength", buffer_->bytes().size()}}});
    return json;
  }

  fs::path out_;
  std::optional<GltfBuffer> buffer_;
  std::vector<GltfMesh> meshes_;
};

}  // namespace

void register_gltf(FrameFormatRegistry& registry) {
  registry.add(
      "gltf", {},
      [](const MethodOptions&, const fs::path& out) { return std::make_unique<GltfFrames>(out); },
      {.promise =
           "one binary file of all frames in float with cloth and bodies, a morph target per "
           "frame, written at the end of the run",
       .source = "glTF 2.0, ISO/IEC 12113:2022",
       .files = {"result.glb"},
       .one_mesh = true});
}

}  // namespace selvedge
