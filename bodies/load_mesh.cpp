// SPDX-License-Identifier: MIT
#include <selvedge/bodies/detail/animation_source.h>
#include <selvedge/bodies/detail/mesh_source.h>
#include <selvedge/bodies/internal/mesh_groups.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/system/internal/libraries.h>
#include <selvedge/core/system/internal/processes.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <numeric>
#include <stdexcept>
#include <system_error>

namespace selvedge {

namespace {

#ifdef SELVEDGE_USE_ASSIMP
constexpr bool kHasAssimp = true;
#else
constexpr bool kHasAssimp = false;
#define SELVEDGE_ASSIMP_PROGRAM ""
#endif

constexpr double kMaxTimeout = 1e6;  // s; more than eleven days is a mistake
constexpr const char* kOwnFormatsRemedy = "save the mesh as OBJ, PLY or OFF";

void check_config(const LoadConfig& config) {
  if (const double unit = config.unit.value_or(1.0); !(unit > 0.0) || !std::isfinite(unit))
    throw std::invalid_argument("the unit of a mesh is " + std::to_string(unit) +
                                " m, but must be positive and finite");
  if (!(config.timeout > 0.0) || config.timeout > kMaxTimeout)
    throw std::invalid_argument("the time allowed for reading a mesh is " +
                                std::to_string(config.timeout) +
                                " s, but must lie between 0 and 1000000 s");
}

// ---------------------------------------------------------------- formats read by assimp

bool is_program(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error);
}

// Path of selvedge-assimp: the variable SELVEDGE_ASSIMP, else the folder of the shared library or
// library that contains this code, else that of the running program, else the build folder, else
// PATH.
std::string assimp_program() {
  if (const char* chosen = std::getenv("SELVEDGE_ASSIMP"); chosen && *chosen) return chosen;
  for (const auto& own :
       {file_of_code(reinterpret_cast<const void*>(&assimp_program)), running_program()}) {
    for (const char* name : {"selvedge-assimp", "selvedge-assimp.exe"})
      if (const auto beside = own.parent_path() / name; !own.empty() && is_program(beside))
        return beside.string();
  }
  if (is_program(SELVEDGE_ASSIMP_PROGRAM)) return SELVEDGE_ASSIMP_PROGRAM;
  return "selvedge-assimp";
}

// The program's message as part of a sentence.
std::string message_of(const std::string& output) {
  std::string message;
  for (const char c : output.substr(1, 300))
    message += std::isprint(static_cast<unsigned char>(c)) ? c : ' ';
  while (!message.empty() && (message.back() == ' ' || message.back() == '.')) message.pop_back();
  return message.empty() ? "no reason given" : message;
}

std::string seconds_text(double seconds) {
  std::string text = std::to_string(seconds);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text + " s";
}

std::string fault_of(const ChildResult& result, const LoadConfig& config) {
  using End = ChildResult::End;
  switch (result.end) {
    case End::not_started:
      return "selvedge-assimp, which reads this format, cannot be started (" +
             std::generic_category().message(result.code) +
             "); set SELVEDGE_ASSIMP to its path or " + kOwnFormatsRemedy;
    case End::timed_out:
      return "assimp did not finish reading within " + seconds_text(config.timeout) +
             "; the file may be damaged, " + kOwnFormatsRemedy;
    case End::too_much_output:
      return "the mesh needs more memory than the limit of " +
             std::to_string(config.memory_limit >> 20) + " MiB; raise the limit or reduce the mesh";
    case End::signalled:
      return "assimp crashed (signal " + std::to_string(result.code) +
             ") while reading; the file is damaged or too large, export it again";
    case End::exited:
      break;
  }
  if (!result.output.empty() && result.output[0] == 'E')
    return "assimp cannot read it: " + message_of(result.output) + "; " + kOwnFormatsRemedy;
  return "assimp gave no mesh (exit status " + std::to_string(result.code) +
         "); the file is damaged, export it again";
}

template <class T>
void take(const char*& at, std::size_t n, std::vector<T>& values) {
  values.resize(n);
  if (n > 0) std::memcpy(static_cast<void*>(values.data()), at, n * sizeof(T));
  at += n * sizeof(T);
}

// Returns false unless the bytes are a complete mesh in the format of assimp_program.cpp.
bool decode(const std::string& bytes, TriangleMesh& mesh, detail::StatedAxes& stated) {
  constexpr std::size_t header = 1 + sizeof(detail::StatedAxes) + 2 * sizeof(std::uint64_t);
  if (bytes.size() < header || bytes[0] != 'M') return false;
  std::uint64_t counts[2];
  std::memcpy(&stated, bytes.data() + 1, sizeof stated);
  std::memcpy(counts, bytes.data() + 1 + sizeof stated, sizeof counts);
  const std::size_t body = bytes.size() - header;
  if (counts[0] > body / sizeof(Vec3) || counts[1] > body / sizeof(Triangle)) return false;
  if (counts[0] * sizeof(Vec3) + counts[1] * sizeof(Triangle) != body) return false;
  const char* at = bytes.data() + header;
  take(at, counts[0], mesh.vertices);
  take(at, counts[1], mesh.triangles);
  return true;
}

std::uint32_t little_endian(const unsigned char* bytes) {
  return bytes[0] | bytes[1] << 8 | bytes[2] << 16 | std::uint32_t{bytes[3]} << 24;
}

// Compares the lengths in the headers of a binary glTF file with its size: assimp allocates them
// before it reads.
void check_glb(const std::filesystem::path& file, std::uintmax_t size) {
  constexpr std::uintmax_t header = 12, chunk_header = 8;
  std::array<unsigned char, header + chunk_header> bytes{};
  std::ifstream(file, std::ios::binary)
      .read(reinterpret_cast<char*>(bytes.data()), std::ssize(bytes));
  const std::uintmax_t length = little_endian(&bytes[8]), chunk = little_endian(&bytes[12]);
  const std::string name = file.string();
  if (size < header + chunk_header || std::memcmp(bytes.data(), "glTF", 4) != 0)
    throw std::invalid_argument(name + ": is not a binary glTF file; export the mesh again");
  if (length > size || chunk > size - header - chunk_header)
    throw std::invalid_argument(name + ": its header gives " +
                                std::to_string(std::max(length, chunk)) + " bytes, the file has " +
                                std::to_string(size) + "; it is cut short, export the mesh again");
}

// What reading a file of this size may need, at most the limit of `config`. Packed formats grow
// hundredfold; a .gltf file may name larger files.
std::size_t memory_for(std::uintmax_t size, const std::string& extension,
                       const LoadConfig& config) {
  constexpr std::uintmax_t least = std::uintmax_t{512} << 20, growth = 400;
  if (extension == ".gltf") return config.memory_limit;
  return static_cast<std::size_t>(
      std::min<std::uintmax_t>(config.memory_limit, least + growth * size));
}

}  // namespace

void detail::read_assimp_output(const std::filesystem::path& file, const LoadConfig& config,
                                const std::vector<std::string>& more,
                                const std::function<bool(const std::string& output)>& decode) {
  const std::string name = file.string(), extension = detail::lower_extension(file);
  check_config(config);
  const std::uintmax_t size = detail::checked_size(file);
  if (extension == ".glb") check_glb(file, size);
  const std::size_t memory = memory_for(size, extension, config);
  if (!kHasAssimp)
    throw std::invalid_argument(name +
                                ": this build has no assimp and reads OBJ, PLY and OFF only; " +
                                kOwnFormatsRemedy + ", or build with SELVEDGE_ASSIMP=ON");
  const auto cpu_seconds = static_cast<long>(std::ceil(config.timeout));
  std::vector<std::string> words = {assimp_program(), std::filesystem::absolute(file).string(),
                                    std::to_string(memory), std::to_string(cpu_seconds)};
  words.insert(words.end(), more.begin(), more.end());
  const ChildResult result =
      run_program(words, {.timeout = config.timeout, .output_limit = config.memory_limit});
  const bool whole =
      result.end == ChildResult::End::exited && result.code == 0 && decode(result.output);
  if (!whole) throw std::invalid_argument(name + ": " + fault_of(result, config));
}

namespace {

TriangleMesh read_by_assimp(const std::filesystem::path& file, const LoadConfig& config,
                            detail::StatedAxes& stated) {
  TriangleMesh mesh;
  detail::read_assimp_output(
      file, config, {}, [&](const std::string& output) { return decode(output, mesh, stated); });
  return mesh;
}

// ---------------------------------------------------------------- all formats

// Rotates the file's up axis to +z, without mirroring, and scales its unit to metres.
Vec3 to_world(const Vec3& x, const LoadConfig& config) {
  const double unit = config.unit.value_or(1.0);
  switch (config.up.value_or(UpAxis::z)) {
    case UpAxis::x:
      return unit * Vec3(x.y(), x.z(), x.x());
    case UpAxis::y:
      return unit * Vec3(x.x(), -x.z(), x.y());
    case UpAxis::z:
      break;
  }
  return unit * x;
}

// For each vertex, the first vertex at exactly its position.
std::vector<std::int32_t> first_at_position(const std::vector<Vec3>& x) {
  std::vector<std::int32_t> order(x.size()), first(x.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    if (x[a] == x[b]) return a < b;
    return std::lexicographical_compare(x[a].begin(), x[a].end(), x[b].begin(), x[b].end());
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && x[order[i]] == x[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

// Welds vertices; removes triangles whose corners coincide.
void weld(TriangleMesh& mesh) {
  const std::vector<std::int32_t> first = first_at_position(mesh.vertices);
  for (Triangle& t : mesh.triangles)
    for (std::int32_t& v : t) v = first[v];
  std::erase_if(mesh.triangles,
                [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  detail::drop_unused_vertices(mesh);
}

void check_mesh(const TriangleMesh& mesh, const std::string& name) {
  if (mesh.triangles.empty())
    throw std::invalid_argument(name + ": has no faces with area; export the surface again");
  validate(mesh, name);
}

void check_indices(const TriangleMesh& mesh, const std::string& name) {
  const auto n = static_cast<std::int64_t>(mesh.vertices.size());
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k)
    for (const std::int32_t v : mesh.triangles[k])
      if (v < 0 || v >= n)
        throw std::invalid_argument(name + ": triangle " + std::to_string(k) +
                                    " names a vertex that the file does not have; it is damaged, "
                                    "export it again");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (!mesh.vertices[i].allFinite())
      throw std::invalid_argument(name + ": vertex " + std::to_string(i) +
                                  " has a coordinate that is not finite in metres; export it again "
                                  "or correct the unit");
}

}  // namespace

FileAxes detail::axes_of(const LoadConfig& config, const StatedAxes& stated,
                         const std::string& name) {
  constexpr UpAxis axes[] = {UpAxis::x, UpAxis::y, UpAxis::z};
  FileAxes used;
  used.unit_stated = stated.unit > 0.0 && std::isfinite(stated.unit);
  used.up_stated = std::abs(stated.up) >= 1.0 && std::abs(stated.up) <= 3.0;
  used.unit = config.unit.value_or(used.unit_stated ? stated.unit : 1.0);
  const auto axis = static_cast<std::size_t>(used.up_stated ? std::abs(stated.up) : 3.0) - 1;
  if (!config.up && stated.up < 0.0)
    throw std::invalid_argument(name + ": states that its negative " + "xyz"[axis] +
                                " axis points up; export it with a positive one, or give the axis");
  used.up = config.up.value_or(axes[axis]);
  return used;
}

LoadConfig detail::with_axes(LoadConfig config, const FileAxes& axes) {
  config.unit = axes.unit;
  config.up = axes.up;
  return config;
}

bool states_axes(const std::filesystem::path& file) {
  const std::string extension = detail::lower_extension(file);
  for (const char* known : {".gltf", ".glb", ".dae", ".fbx"})
    if (extension == known) return true;
  return false;
}

TriangleMesh load_mesh(const std::filesystem::path& file, const LoadConfig& config) {
  return load_body_mesh(file, config).mesh;
}

BodyMesh load_body_mesh(const std::filesystem::path& file, const LoadConfig& config) {
  check_config(config);
  detail::StatedAxes stated;
  const std::string name = file.string();
  const bool own = detail::is_own_format(detail::lower_extension(file));
  if (!config.groups.empty()) {
    if (!own)
      throw std::invalid_argument(name +
                                  ": only OBJ files have groups to choose; save the mesh as OBJ");
    return {prepare_mesh(select_groups(read_grouped_mesh(file), config.groups, name), config, name),
            detail::axes_of(config, stated, name)};
  }
  TriangleMesh mesh = own ? read_mesh(file) : read_by_assimp(file, config, stated);
  const FileAxes axes = detail::axes_of(config, stated, name);
  return {prepare_mesh(std::move(mesh), detail::with_axes(config, axes), name), axes};
}

TriangleMesh prepare_mesh(TriangleMesh mesh, const LoadConfig& config, const std::string& name) {
  check_config(config);
  for (Vec3& x : mesh.vertices) x = to_world(x, config);
  check_indices(mesh, name);
  if (config.weld) weld(mesh);
  check_mesh(mesh, name);
  detail::require_few_faces_at_vertices(mesh, name);
  return mesh;
}

}  // namespace selvedge
