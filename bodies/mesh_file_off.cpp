// SPDX-License-Identifier: MIT
// Geomview OFF in text form. Normals, colours and texture coordinates after the coordinates of a
// vertex are skipped.
#include <selvedge/bodies/detail/mesh_source.h>

#include <limits>
#include <utility>

namespace selvedge::detail {

namespace {

// "0 0 0" and its line end.
constexpr std::size_t kMinVertexBytes = 6;
// "3 0 1 2" and its line end.
constexpr std::size_t kMinFaceBytes = 8;

class OffReader {
 public:
  explicit OffReader(const MeshSource& source) : source_(source), lines_(source) {}

  TriangleMesh read() {
    read_keyword();
    read_counts();
    for (std::int64_t i = 0; i < vertices_; ++i) read_vertex();
    for (std::int64_t i = 0; i < faces_; ++i) read_face(i);
    if (lines_.next_filled('#'))
      lines_.refuse("more lines follow than the header counts (" + std::to_string(vertices_) +
                    " vertices, " + std::to_string(faces_) + " faces); correct the counts");
    return std::move(mesh_);
  }

 private:
  void next_line(const char* what) {
    if (!lines_.next_filled('#'))
      refuse(source_, std::string("ends before ") + what + "; it is cut short, export it again");
    words_ = lines_.text();
  }

  // [ST][C][N][4][n]OFF [BINARY]; the keyword itself is optional.
  void read_keyword() {
    next_line("its header");
    std::string_view rest = words_;
    const std::string_view keyword = LineReader::take_word(rest);
    std::int64_t unused = 0;
    if (parse_integer(keyword, unused)) return;
    check_keyword(keyword);
    words_ = rest;
    std::string_view ahead = rest;
    const std::string_view second = LineReader::take_word(ahead);
    if (second == "BINARY")
      lines_.refuse("binary OFF is not supported; save the mesh as text or PLY");
    if (second.empty()) next_line("its counts");
  }

  void check_keyword(std::string_view keyword) const {
    std::string_view prefix = keyword;
    if (!prefix.ends_with("OFF"))
      lines_.refuse("expected OFF, found " + in_quotes(keyword) + "; this is not an OFF file");
    prefix.remove_suffix(3);
    for (const std::string_view part : {"ST", "C", "N"})
      if (prefix.starts_with(part)) prefix.remove_prefix(part.size());
    if (!prefix.empty())
      lines_.refuse("the kind " + in_quotes(keyword) +
                    " has no three coordinates; save the mesh as plain OFF");
  }

  void read_counts() {
    vertices_ = lines_.take_integer(words_, "the number of vertices");
    faces_ = lines_.take_integer(words_, "the number of faces");
    check_count(vertices_, kMinVertexBytes, "vertices");
    check_count(faces_, kMinFaceBytes, "faces");
    mesh_.vertices.reserve(static_cast<std::size_t>(vertices_));
    mesh_.triangles.reserve(static_cast<std::size_t>(faces_));
  }

  void check_count(std::int64_t count, std::size_t bytes, const char* what) const {
    if (count < 0 || count > std::numeric_limits<std::int32_t>::max())
      lines_.refuse("the header gives " + std::to_string(count) + " " + what +
                    ", which is impossible");
    // The last line may lack a line end.
    if (static_cast<std::size_t>(count) > (lines_.bytes_left() + 1) / bytes)
      lines_.refuse("the header gives " + std::to_string(count) + " " + what +
                    ", more than the file can hold; it is damaged or cut short, export it again");
  }

  void read_vertex() {
    next_line("its last vertex");
    Vec3 x;
    x[0] = lines_.take_double(words_, "the x coordinate");
    x[1] = lines_.take_double(words_, "the y coordinate");
    x[2] = lines_.take_double(words_, "the z coordinate");
    mesh_.vertices.push_back(x);
  }

  // Colours may follow the corners.
  void read_face(std::int64_t face) {
    next_line("its last face");
    const std::int64_t corners = lines_.take_integer(words_, "the number of corners");
    if (corners < 3)
      lines_.refuse("face " + std::to_string(face) + " has " + std::to_string(corners) +
                    " corners; a face needs at least 3, export the mesh again");
    polygon_.clear();
    for (std::int64_t k = 0; k < corners; ++k) polygon_.push_back(take_vertex(face));
    append_fan(polygon_, mesh_.triangles);
  }

  std::int32_t take_vertex(std::int64_t face) {
    const std::int64_t index = lines_.take_integer(words_, "the last corner of the face");
    if (index < 0 || index >= vertices_)
      lines_.refuse("face " + std::to_string(face) + " names vertex " + std::to_string(index) +
                    ", but the file has vertices 0 to " + std::to_string(vertices_ - 1));
    return static_cast<std::int32_t>(index);
  }

  const MeshSource& source_;
  LineReader lines_;
  std::string_view words_;
  TriangleMesh mesh_;
  std::vector<std::int32_t> polygon_;
  std::int64_t vertices_ = 0, faces_ = 0;
};

}  // namespace

TriangleMesh read_off(const MeshSource& source) { return OffReader(source).read(); }

}  // namespace selvedge::detail
