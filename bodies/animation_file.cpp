// SPDX-License-Identifier: MIT
#include <selvedge/bodies/detail/animation_source.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace selvedge {
namespace detail {
namespace {

/// 32-bit words of a file.
class WordReader {
 public:
  WordReader(const MeshSource& source, std::size_t begin, bool big_endian)
      : source_(&source),
        at_(begin),
        swapped_(big_endian != (std::endian::native == std::endian::big)) {}

  std::size_t words_left() const { return (source_->bytes.size() - at_) / 4; }

  std::int32_t take_int() { return std::bit_cast<std::int32_t>(take()); }
  float take_float() { return std::bit_cast<float>(take()); }

 private:
  std::uint32_t take() {
    if (source_->bytes.size() - at_ < 4)
      refuse(*source_, "ends too early; the file is incomplete, export it again");
    std::uint32_t bits = 0;
    std::memcpy(&bits, source_->bytes.data() + at_, sizeof bits);
    at_ += sizeof bits;
    if (!swapped_) return bits;
    return bits >> 24 | (bits >> 8 & 0xFF00u) | (bits << 8 & 0xFF0000u) | bits << 24;
  }

  const MeshSource* source_;
  std::size_t at_;
  bool swapped_;
};

void read_cache_frames(const MeshSource& source, WordReader& words, std::int64_t frames,
                       std::int64_t points, MeshAnimation& animation) {
  if (frames < 1 || points < 1)
    refuse(source, "has " + std::to_string(frames) + " frames of " + std::to_string(points) +
                       " points; export it again");
  // Both counts are below 2^31, so that the product does not overflow.
  if (static_cast<std::uint64_t>(frames) * static_cast<std::uint64_t>(points) >
      words.words_left() / 3)
    refuse(source, "has fewer bytes than its " + std::to_string(frames) + " frames of " +
                       std::to_string(points) + " points need; export it again");
  for (std::int64_t f = 0; f < frames; ++f) {
    std::vector<Vec3>& x = animation.frames.emplace_back(static_cast<std::size_t>(points));
    for (Vec3& p : x)
      for (int axis = 0; axis < 3; ++axis) p[axis] = words.take_float();
  }
}

}  // namespace

MeshAnimation read_pc2(const MeshSource& source) {
  constexpr std::string_view magic("POINTCACHE2\0", 12);
  if (!source.bytes.starts_with(magic)) refuse(source, "is not a .pc2 point cache");
  WordReader words(source, magic.size(), false);
  if (const std::int32_t version = words.take_int(); version != 1)
    refuse(source, "is a point cache of version " + std::to_string(version) + "; only 1 is known");
  const std::int32_t points = words.take_int();
  words.take_float();  // the first frame in the program that wrote it
  words.take_float();  // its frames per sample
  const std::int32_t frames = words.take_int();
  MeshAnimation animation;
  read_cache_frames(source, words, frames, points, animation);
  return animation;
}

MeshAnimation read_mdd(const MeshSource& source) {
  WordReader words(source, 0, true);
  const std::int32_t frames = words.take_int(), points = words.take_int();
  if (frames < 1 || static_cast<std::size_t>(frames) > words.words_left())
    refuse(source, "is not an .mdd point cache, or is damaged");
  std::vector<double> seconds;
  for (std::int32_t f = 0; f < frames; ++f) seconds.push_back(words.take_float());
  MeshAnimation animation;
  if (frames > 1 && seconds.back() > seconds.front())
    animation.fps = (frames - 1) / (seconds.back() - seconds.front());
  read_cache_frames(source, words, frames, points, animation);
  return animation;
}

namespace {

template <class T>
void take_list(const char*& at, std::size_t n, std::vector<T>& values) {
  values.resize(n);
  if (n > 0) std::memcpy(static_cast<void*>(values.data()), at, n * sizeof(T));
  at += n * sizeof(T);
}

/// Returns false unless the bytes are a complete animation in the format of assimp_program.cpp.
bool decode_animation(const std::string& bytes, MeshAnimation& animation, StatedAxes& stated) {
  constexpr std::size_t header = 1 + sizeof(StatedAxes) + 3 * sizeof(std::uint64_t);
  if (bytes.size() < header || bytes[0] != 'A') return false;
  std::uint64_t counts[3];  // vertices, triangles, frames
  std::memcpy(&stated, bytes.data() + 1, sizeof stated);
  std::memcpy(counts, bytes.data() + 1 + sizeof stated, sizeof counts);
  const std::size_t body = bytes.size() - header;
  if (counts[1] > body / sizeof(Triangle) || counts[0] > body / sizeof(Vec3)) return false;
  const std::size_t left = body - counts[1] * sizeof(Triangle);
  if (counts[0] == 0 || counts[2] == 0 || counts[2] > left / (counts[0] * sizeof(Vec3)) ||
      counts[0] * counts[2] * sizeof(Vec3) != left)
    return false;
  const char* at = bytes.data() + header;
  take_list(at, counts[1], animation.triangles);
  for (std::uint64_t f = 0; f < counts[2]; ++f)
    take_list(at, counts[0], animation.frames.emplace_back());
  return true;
}

MeshAnimation animation_by_assimp(const std::filesystem::path& file, const AnimationConfig& config,
                                  StatedAxes& stated) {
  MeshAnimation animation;
  read_assimp_output(
      file, config.load, {std::to_string(config.fps)},
      [&](const std::string& output) { return decode_animation(output, animation, stated); });
  if (animation.frames.size() > 1) animation.fps = config.fps;
  return animation;
}

MeshAnimation with_base(MeshAnimation cache, const std::filesystem::path& file,
                        const AnimationConfig& config) {
  if (config.base.empty())
    throw std::invalid_argument(file.string() +
                                ": a point cache has no triangles; name the mesh that it moves");
  const TriangleMesh base = is_own_format(lower_extension(config.base))
                                ? read_mesh(config.base)
                                : load_mesh(config.base, {.weld = false});
  if (base.vertices.size() != cache.frames.front().size())
    throw std::invalid_argument(
        file.string() + ": has " + std::to_string(cache.frames.front().size()) + " points, but " +
        config.base.string() + " has " + std::to_string(base.vertices.size()) + " vertices");
  cache.triangles = base.triangles;
  return cache;
}

/// Merges vertices that are at exactly the same place in every frame, as exporters split them where
/// normals or texture coordinates differ, and drops triangles that lose a corner so.
void weld_animation(MeshAnimation& animation) {
  const auto& frames = animation.frames;
  const std::size_t n = frames.front().size();
  std::vector<std::int32_t> order(n), first(n), place(n, -1);
  std::iota(order.begin(), order.end(), 0);
  const auto compare = [&](std::int32_t a, std::int32_t b) {
    for (const std::vector<Vec3>& x : frames)
      for (int axis = 0; axis < 3; ++axis)
        if (x[a][axis] != x[b][axis]) return x[a][axis] < x[b][axis] ? -1 : 1;
    return 0;
  };
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    const int sign = compare(a, b);
    return sign < 0 || (sign == 0 && a < b);
  });
  for (std::size_t i = 0; i < n; ++i) {
    const bool same = i > 0 && compare(order[i], order[i - 1]) == 0;
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  for (Triangle& t : animation.triangles)
    for (std::int32_t& v : t) v = first[v];
  std::erase_if(animation.triangles,
                [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  for (const Triangle& t : animation.triangles)
    for (const std::int32_t v : t) place[v] = 0;
  std::int32_t kept = 0;
  for (std::int32_t& p : place)
    if (p == 0) p = kept++;
  for (std::vector<Vec3>& x : animation.frames) {
    for (std::size_t v = 0; v < n; ++v)
      if (place[v] >= 0) x[static_cast<std::size_t>(place[v])] = x[v];
    x.resize(static_cast<std::size_t>(kept));
  }
  for (Triangle& t : animation.triangles)
    for (std::int32_t& v : t) v = place[v];
}

/// Turns, scales and checks every frame.
void prepare(MeshAnimation& animation, const AnimationConfig& config, const std::string& name) {
  LoadConfig load = with_axes(config.load, animation.axes);
  load.weld = false;
  for (std::size_t f = 0; f < animation.frames.size(); ++f) {
    TriangleMesh mesh = prepare_mesh({std::move(animation.frames[f]), animation.triangles}, load,
                                     name + ": frame " + std::to_string(f));
    animation.frames[f] = std::move(mesh.vertices);
  }
  if (config.load.weld) weld_animation(animation);
  if (animation.triangles.empty())
    throw std::invalid_argument(name + ": has no faces with area; export the surface again");
}

}  // namespace
}  // namespace detail

MeshAnimation load_animation(const std::filesystem::path& file, const AnimationConfig& config) {
  constexpr double most_fps = 1000.0;
  if (!(config.fps > 0.0 && config.fps <= most_fps))
    throw std::invalid_argument(file.string() + ": " + std::to_string(config.fps) +
                                " frames per second are not within 0 and 1000");
  const std::string extension = detail::lower_extension(file);
  MeshAnimation animation;
  detail::StatedAxes stated;
  if (extension == ".pc2")
    animation = detail::with_base(detail::read_pc2(detail::read_source(file)), file, config);
  else if (extension == ".mdd")
    animation = detail::with_base(detail::read_mdd(detail::read_source(file)), file, config);
  else if (extension == ".usda" || extension == ".usd")
    animation = detail::read_usda(detail::read_source(file), stated);
  else if (detail::is_own_format(extension)) {
    TriangleMesh mesh = read_mesh(file);
    animation.triangles = std::move(mesh.triangles);
    animation.frames.push_back(std::move(mesh.vertices));
  } else
    animation = detail::animation_by_assimp(file, config, stated);
  animation.axes = detail::axes_of(config.load, stated, file.string());
  detail::prepare(animation, config, file.string());
  return animation;
}

}  // namespace selvedge
