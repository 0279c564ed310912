// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/mesh_file.h>

#include <string>
#include <vector>

#include "fuzz.h"

namespace selvedge::fuzz {

/// A folder in memory (/dev/shm) for each input, removed at the end of the process.
class InputFolder {
 public:
  InputFolder() : path_("/dev/shm/selvedge_fuzz_folder_" + std::to_string(getpid())) {}
  ~InputFolder() { std::filesystem::remove_all(path_); }
  InputFolder(const InputFolder&) = delete;
  InputFolder& operator=(const InputFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  void clear() const {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  void write(const std::string& name, const std::string& content) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << content;
  }
  /// A mesh as one of a few frames would have it, or spoilt; the bytes choose.
  void write_mesh(const std::string& name, Bytes& bytes) const;

 private:
  std::filesystem::path path_;
};

/// A tetrahedron, moved, turned inside out, with a vertex or a triangle more, or flat.
inline TriangleMesh some_mesh(Bytes& bytes) {
  TriangleMesh mesh;
  const Vec3 shift(0.1 * bytes.below(4), 0.0, 0.1 * bytes.below(8));
  mesh.vertices = {shift, shift + Vec3::UnitX(), shift + Vec3::UnitY(), shift + Vec3::UnitZ()};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const int kind = bytes.below(16);
  if (kind == 1) mesh.vertices.emplace_back(1, 1, 1);
  if (kind == 2) std::swap(mesh.triangles[0], mesh.triangles[1]);
  if (kind == 3) mesh.triangles.pop_back();
  if (kind == 4) mesh.vertices[3] = shift;
  if (kind == 5) mesh.vertices.push_back(mesh.vertices[0]), mesh.triangles[3] = {1, 2, 4};
  if (kind == 6) mesh.vertices.clear(), mesh.triangles.clear();
  if (kind == 7) mesh.vertices[1] = {bytes.coordinate(), bytes.coordinate(), bytes.coordinate()};
  return mesh;
}

inline void InputFolder::write_mesh(const std::string& name, Bytes& bytes) const {
  const int spoilt = bytes.below(16);
  if (spoilt == 1) return write(name, "");
  if (spoilt == 2) return std::filesystem::create_directories(path_ / name), void();
  if (spoilt == 3) return;
  std::filesystem::create_directories((path_ / name).parent_path());
  const TriangleMesh mesh = some_mesh(bytes);
  const std::filesystem::path file = path_ / name;
  if (name.ends_with(".ply")) {
    write_ply(file, mesh.vertices, mesh.triangles);
  } else {
    std::ofstream out(file);
    for (const Vec3& x : mesh.vertices) out << "v " << x.transpose() << "\n";
    for (const Triangle& t : mesh.triangles)
      out << "f " << t[0] + 1 << " " << t[1] + 1 << " " << t[2] + 1 << "\n";
  }
  std::error_code none;
  if (spoilt == 4) std::filesystem::resize_file(file, bytes.byte(), none);
  if (spoilt != 5) return;
  std::fstream out(file, std::ios::binary | std::ios::in | std::ios::out);
  for (int k = bytes.below(4); k-- > 0;) {
    out.seekp(bytes.byte());
    out.put(static_cast<char>(bytes.byte()));
  }
}

}  // namespace selvedge::fuzz
