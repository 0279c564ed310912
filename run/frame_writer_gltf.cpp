// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/run/detail/float_points.h>
#include <selvedge/run/detail/part_mesh.h>
#include <selvedge/run/detail/spool_file.h>
#include <selvedge/run/frame_writer.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <map>
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

/// glTF has the origin of textures above, ours is below.
std::vector<float> texture_numbers(const std::vector<TexturePoint>& texture) {
  std::vector<float> numbers;
  for (const TexturePoint& uv : texture) {
    numbers.push_back(static_cast<float>(uv[0]));
    numbers.push_back(static_cast<float>(1.0 - uv[1]));
  }
  return numbers;
}

/// Vectors of each vertex in all frames: those of the first frame, and the differences of each
/// later one from them.
class GltfSeries {
 public:
  void append(const std::vector<float>& numbers, GltfBuffer& buffer) {
    if (base_.empty()) {
      base_ = numbers;
      accessor_ = buffer.append(base_, "VEC3", 3, kArrayBuffer);
      return;
    }
    std::vector<float> change(numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) change[i] = numbers[i] - base_[i];
    targets_.push_back(buffer.append(change, "VEC3", 3, kArrayBuffer));
  }
  /// As the first frame: one accessor for all such frames.
  void append_rest(GltfBuffer& buffer) {
    if (rest_ < 0) rest_ = buffer.append(std::vector<float>(base_.size()), "VEC3", 3, kArrayBuffer);
    targets_.push_back(rest_);
  }
  const std::vector<float>& base() const { return base_; }
  int accessor() const { return accessor_; }
  const std::vector<int>& targets() const { return targets_; }

 private:
  std::vector<float> base_;
  int accessor_ = 0, rest_ = -1;
  std::vector<int> targets_;
};

/// A piece of cloth or a body whose first frame is its shape. Every later frame is a morph target;
/// of a body at rest there are none.
class GltfMesh {
 public:
  GltfMesh(detail::PartMesh part, fs::path file) : part_(std::move(part)), file_(std::move(file)) {}

  std::size_t targets() const { return positions_.targets().size(); }
  const std::string& name() const { return part_.name; }

  void append(double time, std::span<const Vec3> x, std::span<const NamedValues> values,
              GltfBuffer& buffer) {
    const std::vector<Vec3> points = detail::points_of(part_, x);
    const std::vector<float> numbers = detail::float_points(with_y_up(points), file_);
    seconds_.push_back(static_cast<float>(time));
    note_values(values);
    if (positions_.base().empty()) begin(buffer);
    if (numbers == positions_.base()) {
      ++at_rest_;
      return;
    }
    for (; at_rest_ > 0; --at_rest_) {
      positions_.append_rest(buffer);
      normals_.append_rest(buffer);
    }
    const std::vector<Vec3> normals = with_y_up(detail::normals_of(part_, points));
    const bool first = positions_.base().empty();
    positions_.append(numbers, buffer);
    normals_.append(detail::float_points(normals, file_), buffer);
    if (first) at_rest_ = 0;
  }

  /// Values of all frames, once no frame follows: the flags of any frame, the pressure of the last.
  void finish(GltfBuffer& buffer) {
    for (auto& [name, values] : values_)
      attributes_[name] = buffer.append(values, "SCALAR", 1, kArrayBuffer);
    if (targets() == 0) return;
    for (; at_rest_ > 0; --at_rest_) {
      positions_.append_rest(buffer);
      normals_.append_rest(buffer);
    }
  }

  GltfJson mesh(int material) const {
    GltfJson attributes = {{"POSITION", positions_.accessor()}, {"NORMAL", normals_.accessor()}};
    attributes.update(attributes_);
    GltfJson primitive = {
        {"attributes", std::move(attributes)}, {"indices", indices_}, {"material", material}};
    GltfJson mesh = {{"name", name()}};
    if (targets() > 0) {
      for (std::size_t i = 0; i < targets(); ++i)
        primitive["targets"].push_back(
            {{"POSITION", positions_.targets()[i]}, {"NORMAL", normals_.targets()[i]}});
      mesh["weights"] = std::vector<int>(targets(), 0);
    }
    mesh["primitives"] = GltfJson::array({std::move(primitive)});
    return mesh;
  }

  GltfJson material() const {
    const Vec3& c = part_.colour;
    return {{"name", name()},
            {"doubleSided", true},
            {"pbrMetallicRoughness",
             {{"baseColorFactor", {c.x(), c.y(), c.z(), 1.0}},
              {"metallicFactor", 0.0},
              {"roughnessFactor", 0.85}}}};
  }

  /// Accessors of the times and of the weights: frame i has weight 1 on target i - 1.
  std::pair<int, int> append_weights(GltfBuffer& buffer) const {
    std::vector<float> weights(seconds_.size() * targets(), 0.0F);
    for (std::size_t i = 0; i < targets(); ++i) weights[(i + 1) * targets() + i] = 1.0F;
    const int times = buffer.append(seconds_, "SCALAR", 1, 0);
    return {times, buffer.append(weights, "SCALAR", 1, 0)};
  }

 private:
  void begin(GltfBuffer& buffer) {
    std::vector<std::uint32_t> indices;
    for (const Triangle& t : part_.triangles) indices.insert(indices.end(), t.begin(), t.end());
    indices_ = buffer.append(indices, "SCALAR", 1, kElementBuffer);
    if (!part_.texture.empty())
      attributes_["TEXCOORD_0"] =
          buffer.append(texture_numbers(part_.texture), "VEC2", 2, kArrayBuffer);
  }

  void note_values(std::span<const NamedValues> values) {
    const std::vector<float> flags = detail::values_of(part_, values, "flag");
    std::vector<float>& all = values_["_FLAG"];
    all.resize(flags.size(), 0.0F);
    for (std::size_t i = 0; i < flags.size(); ++i)
      all[i] = static_cast<float>(static_cast<int>(all[i]) | static_cast<int>(flags[i]));
    if (all.empty()) values_.erase("_FLAG");
    if (std::vector<float> pressure = detail::values_of(part_, values, "pressure");
        !pressure.empty())
      values_["_PRESSURE"] = std::move(pressure);
  }

  detail::PartMesh part_;
  fs::path file_;
  std::vector<float> seconds_;
  int indices_ = 0;
  std::size_t at_rest_ = 0;  // frames with the shape of the first one that have no target yet
  GltfSeries positions_, normals_;
  GltfJson attributes_ = GltfJson::object();
  std::map<std::string, std::vector<float>> values_;
};

class GltfFrames final : public FrameWriter {
 public:
  explicit GltfFrames(fs::path out) : out_(std::move(out)) {}

  void write(const Frame& frame) override {
    const fs::path file = out_ / "result.glb";
    if (frame.number == 0) {
      buffer_.emplace(out_);
      start(cloth_, frame, detail::FrameHalf::cloth);
      start(bodies_, frame, detail::FrameHalf::bodies);
      vertices_ = frame.x.size();
      body_vertices_ = frame.bodies.size();
    }
    detail::check_point_count(frame.x.size(), vertices_, file);
    for (GltfMesh& mesh : cloth_) mesh.append(frame.time, frame.x, frame.values, *buffer_);
    if (frame.bodies.empty()) return;
    detail::check_point_count(frame.bodies.size(), body_vertices_, file);
    for (GltfMesh& mesh : bodies_) mesh.append(frame.time, frame.bodies, {}, *buffer_);
  }

  void finish() override {
    if (!buffer_) return;
    for (auto* half : {&cloth_, &bodies_})
      for (GltfMesh& mesh : *half) mesh.finish(*buffer_);
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
  void start(std::vector<GltfMesh>& meshes, const Frame& frame, detail::FrameHalf half) const {
    meshes.clear();
    for (detail::PartMesh& part : detail::part_meshes(frame, half))
      if (!part.triangles.empty()) meshes.emplace_back(std::move(part), out_ / "result.glb");
  }

  GltfJson description() {
    GltfJson json = {{"asset", {{"version", "2.0"}, {"generator", "selvedge"}}}, {"scene", 0}};
    GltfJson nodes = GltfJson::array(), channels = GltfJson::array(), samplers = GltfJson::array();
    const auto add = [&](const GltfMesh& mesh) {
      const int index = static_cast<int>(nodes.size());
      nodes.push_back({{"name", mesh.name()}, {"mesh", index}});
      json["meshes"].push_back(mesh.mesh(index));
      json["materials"].push_back(mesh.material());
      if (mesh.targets() == 0) return;
      const auto [times, weights] = mesh.append_weights(*buffer_);
      channels.push_back(
          {{"sampler", samplers.size()}, {"target", {{"node", index}, {"path", "weights"}}}});
      samplers.push_back({{"input", times}, {"output", weights}, {"interpolation", "LINEAR"}});
    };
    for (const auto* half : {&cloth_, &bodies_})
      for (const GltfMesh& mesh : *half) add(mesh);
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
  std::vector<GltfMesh> cloth_, bodies_;
  std::size_t vertices_ = 0, body_vertices_ = 0;  // of each frame
};

}  // namespace

void register_gltf(FrameFormatRegistry& registry) {
  registry.add(
      "gltf", {},
      [](const MethodOptions&, const fs::path& out) { return std::make_unique<GltfFrames>(out); },
      {.promise =
           "one binary file of all frames in float, a mesh for each piece and body with normals, "
           "texture coordinates, colour, flags and pressure, a morph target per frame, written at "
           "the end of the run",
       .source = "glTF 2.0, ISO/IEC 12113:2022",
       .files = {"result.glb"},
       .one_mesh = true});
}

}  // namespace selvedge
