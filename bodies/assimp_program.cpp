// SPDX-License-Identifier: MIT
// selvedge-assimp FILE MEMORY SECONDS [FPS] reads a mesh file with assimp and writes it to standard
// output. It is a separate process because assimp may crash, abort or hang on a damaged file.
// Output in native byte order: the byte 'M', what the file states of its axes (see Axes), the
// numbers of vertices and triangles (uint64), x y z (double) and indices (int32); or the byte 'E'
// and a message. With FPS, the first animation is sampled: the byte 'A', the axes, the numbers of
// vertices, triangles and frames, indices, and x y z of every frame. Positions are in the axes and
// the unit of the file.
#include <selvedge/bodies/detail/assimp_animation.h>
#include <selvedge/bodies/detail/assimp_axes.h>
#include <selvedge/bodies/detail/gltf_nodes.h>
#include <selvedge/core/system/internal/processes.h>
#include <selvedge/core/system/internal/terminal.h>

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <array>
#include <assimp/Importer.hpp>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

constexpr int kMaxNodeDepth = 1000;  // far beyond any real scene; a damaged file may be endless

using namespace selvedge::detail;

// Passes the indices on unchecked; the reader of the output checks them. Points and lines, with
// fewer than three indices, are skipped.
void append_mesh(const aiMesh& mesh, const Affine& map, Soup& soup) {
  const auto first = static_cast<std::uint32_t>(soup.vertices.size());
  const bool mirrored = determinant(map) < 0.0;
  for (unsigned i = 0; i < mesh.mNumVertices; ++i)
    soup.vertices.push_back(mapped(map, to_point(mesh.mVertices[i])));
  for (unsigned k = 0; k < mesh.mNumFaces; ++k) {
    const aiFace& face = mesh.mFaces[k];
    if (face.mNumIndices != 3) continue;
    std::array<std::int32_t, 3> t;
    for (int i = 0; i < 3; ++i)
      t[i] = face.mIndices[i] < mesh.mNumVertices
                 ? static_cast<std::int32_t>(first + face.mIndices[i])
                 : -1;
    if (mirrored) std::swap(t[1], t[2]);
    soup.triangles.push_back(t);
  }
}

void append_node(const aiScene& scene, const aiNode& node, const Affine& parent, int depth,
                 Soup& soup) {
  if (depth > kMaxNodeDepth) return;
  const Affine map = compose(parent, to_affine(node.mTransformation));
  for (unsigned i = 0; i < node.mNumMeshes; ++i)
    if (node.mMeshes[i] < scene.mNumMeshes) append_mesh(*scene.mMeshes[node.mMeshes[i]], map, soup);
  for (unsigned i = 0; i < node.mNumChildren; ++i)
    append_node(scene, *node.mChildren[i], map, depth + 1, soup);
}

int finish_with_error(const std::string& message) {
  std::fputc('E', stdout);
  std::fwrite(message.data(), 1, message.size(), stdout);
  return 1;
}

template <class T>
bool write_all(const std::vector<T>& values) {
  return std::fwrite(values.data(), sizeof(T), values.size(), stdout) == values.size();
}

int write_soup(const Soup& soup, const Axes& axes) {
  const std::vector<std::uint64_t> counts{soup.vertices.size(), soup.triangles.size()};
  std::fputc('M', stdout);
  const bool written = write_all(words_of(axes)) && write_all(counts) && write_all(soup.vertices) &&
                       write_all(soup.triangles);
  return written && std::fflush(stdout) == 0 ? 0 : 1;
}

// All frames, one after the other, so that only one is in memory.
int write_animation(const aiScene& scene, double fps, const Axes& axes) {
  PosedScene posed(scene);
  const std::vector<std::array<std::int32_t, 3>> triangles = posed.triangles();
  const std::uint64_t frames = posed.frames(fps);
  const std::vector<std::uint64_t> counts{posed.vertices(0.0).size(), triangles.size(), frames};
  std::fputc('A', stdout);
  bool written = write_all(words_of(axes)) && write_all(counts) && write_all(triangles);
  for (std::uint64_t f = 0; f < frames && written; ++f)
    written = write_all(posed.vertices(static_cast<double>(f) / fps));
  return written && std::fflush(stdout) == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words = selvedge::program_arguments(argc, argv);
  if (words.size() != 4 && words.size() != 5) {
    std::fprintf(stderr, "usage: selvedge-assimp FILE MEMORY_BYTES SECONDS [FPS]\n");
    return 2;
  }
  selvedge::write_bytes_to_output();
  selvedge::limit_this_process(std::strtoull(words[2].c_str(), nullptr, 10),
                               std::strtoull(words[3].c_str(), nullptr, 10));
  if (const std::string fault = gltf_node_fault(words[1]); !fault.empty())
    return finish_with_error(fault);
  Assimp::Importer importer;
  const bool animated = words.size() == 5;
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS,
                              aiComponent_NORMALS | aiComponent_TEXCOORDS | aiComponent_COLORS |
                                  aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_TEXTURES |
                                  aiComponent_LIGHTS | aiComponent_CAMERAS |
                                  (animated ? 0 : int{aiComponent_ANIMATIONS}));
  // Else a Collada file whose z axis points up would be turned, and the user could not say
  // otherwise.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  // No vertex joining here: assimp joins valid vertices with NaN vertices.
  const aiScene* scene =
      importer.ReadFile(words[1], aiProcess_RemoveComponent | aiProcess_Triangulate |
                                      aiProcess_ValidateDataStructure);
  if (!scene || !scene->mRootNode) return finish_with_error(importer.GetErrorString());
  const Axes axes = stated_axes(*scene, words[1]);
  undo_unit(*scene, axes);
  if (animated) {
    const double fps = std::strtod(words[4].c_str(), nullptr);
    return fps > 0.0 ? write_animation(*scene, fps, axes)
                     : finish_with_error("the frame rate is wrong");
  }
  Soup soup;
  append_node(*scene, *scene->mRootNode, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, 0, soup);
  return write_soup(soup, axes);
}
