// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/run/internal/replay.h>
#include <selvedge/run/result_folder.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace selvedge {
namespace {

namespace fs = std::filesystem;

/// Numbered states of a result folder.
struct States {
  fs::path folder;
  int digits;

  fs::path file(const char* stem, int number) const {
    return numbered(folder, stem, number, digits, ".ply");
  }
  bool has(const char* stem, int number) const {
    std::error_code error;
    return fs::exists(file(stem, number), error);
  }
  /// The file of that state, or of state 0 for bodies at rest, which have one file. "" without any.
  fs::path latest(const char* stem, int number) const {
    if (has(stem, number)) return file(stem, number);
    return has(stem, 0) ? file(stem, 0) : fs::path();
  }
  int count() const {
    int n = 0;
    while (has("cloth", n)) ++n;
    return n;
  }
};

struct State {
  std::vector<NamedValues> values;  // declared first: reading the mesh fills it
  TriangleMesh mesh;

  explicit State(const fs::path& file) : mesh(read_ply(file, values)) {}

  Vec3 velocity(std::size_t i) const {
    Vec3 v = Vec3::Zero();
    const char* names[] = {"vx", "vy", "vz"};
    for (const NamedValues& named : values)
      for (int k = 0; k < 3; ++k)
        if (named.name == names[k]) v[k] = named.values[i];
    return v;
  }
};

bool same_bits(const Vec3& a, const Vec3& b) {
  return std::memcmp(a.data(), b.data(), 3 * sizeof(double)) == 0;
}

/// Why the vertices of the two states do not correspond; "" if they do.
std::string structure(const State& a, const State& b) {
  if (a.mesh.vertices.size() != b.mesh.vertices.size())
    return fmt::format("number of vertices {} in the first run, {} in the second",
                       a.mesh.vertices.size(), b.mesh.vertices.size());
  if (a.mesh.triangles != b.mesh.triangles) return "the triangles differ";
  return "";
}

/// True if the files differ; then it describes the difference.
bool compare(const fs::path& file_a, const fs::path& file_b, RunDifference& d) {
  const State a(file_a), b(file_b);
  d.structure = structure(a, b);
  if (!d.structure.empty()) return true;
  for (std::size_t i = 0; i < a.mesh.vertices.size(); ++i) {
    const Vec3 &x_a = a.mesh.vertices[i], &x_b = b.mesh.vertices[i];
    const Vec3 v_a = a.velocity(i), v_b = b.velocity(i);
    if (same_bits(x_a, x_b) && same_bits(v_a, v_b)) continue;
    if (d.vertices++ == 0) {
      d.vertex = static_cast<std::int32_t>(i);
      d.x_a = x_a;
      d.x_b = x_b;
    }
    d.distance = std::max(d.distance, (x_a - x_b).norm());
    d.speed = std::max(d.speed, (v_a - v_b).norm());
  }
  return d.vertices > 0;
}

States states_of(const fs::path& result, bool every_step) {
  return every_step ? States{result / "steps", kStepFileDigits}
                    : States{result / "frames", kFrameFileDigits};
}

}  // namespace

RunDifference find_difference(const fs::path& a, const fs::path& b) {
  RunDifference d;
  d.every_step = states_of(a, true).has("cloth", 0) && states_of(b, true).has("cloth", 0);
  const States first = states_of(a, d.every_step), second = states_of(b, d.every_step);
  d.states_a = first.count();
  d.states_b = second.count();
  for (const auto& [folder, count] : {std::pair{a, d.states_a}, std::pair{b, d.states_b}})
    if (count == 0)
      throw std::invalid_argument(folder.string() +
                                  ": holds no frames/cloth_00000.ply; give the result folder of a "
                                  "run");
  for (int i = 0; i < std::min(d.states_a, d.states_b) && !d.differ; ++i)
    for (const char* stem : {"cloth", "bodies"}) {
      const fs::path file_a = first.latest(stem, i), file_b = second.latest(stem, i);
      if (file_a.empty() || file_b.empty()) continue;
      d.differ = compare(file_a, file_b, d);
      if (!d.differ) continue;
      d.number = i;
      d.surface = stem;
      break;
    }
  d.compared = d.differ ? d.number : std::min(d.states_a, d.states_b);
  return d;
}

}  // namespace selvedge
