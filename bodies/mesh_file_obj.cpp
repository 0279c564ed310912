// SPDX-License-Identifier: MIT
// Wavefront OBJ. Only the statements v and f define the surface; g, o and usemtl name its parts,
// and all others are skipped.
#include <selvedge/bodies/detail/mesh_source.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <limits>
#include <map>
#include <utility>

namespace selvedge::detail {

namespace {

constexpr std::int64_t kMaxVertices = std::numeric_limits<std::int32_t>::max();

bool is_keyword(std::string_view word) {
  return std::all_of(word.begin(), word.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
  });
}

class ObjReader {
 public:
  ObjReader(const MeshSource& source, std::vector<MeshGroup>* groups)
      : source_(source), lines_(source), groups_(groups) {}

  TriangleMesh read() {
    while (next_statement()) read_statement();
    check_forward_reference();
    return std::move(mesh_);
  }

 private:
  // Joins lines that end with a backslash.
  bool next_statement() {
    if (!lines_.next()) return false;
    words_ = lines_.text();
    if (words_.ends_with('\\')) join_lines();
    words_ = words_.substr(0, words_.find('#'));
    return true;
  }

  void join_lines() {
    joined_.assign(words_);
    while (joined_.ends_with('\\')) {
      joined_.back() = ' ';
      if (!lines_.next()) break;
      joined_ += lines_.text();
    }
    words_ = joined_;
  }

  void read_statement() {
    const std::string_view keyword = LineReader::take_word(words_);
    if (keyword == "v")
      read_vertex();
    else if (keyword == "f")
      read_face();
    else if (groups_ != nullptr && (keyword == "g" || keyword == "o" || keyword == "usemtl"))
      read_group(keyword);
    else if (!is_keyword(keyword))
      lines_.refuse(in_quotes(keyword) +
                    " is not an OBJ statement; the file is damaged or not an OBJ file");
  }

  void read_vertex() {
    Vec3 x;
    x[0] = lines_.take_double(words_, "the x coordinate");
    x[1] = lines_.take_double(words_, "the y coordinate");
    x[2] = lines_.take_double(words_, "the z coordinate");
    if (static_cast<std::int64_t>(mesh_.vertices.size()) >= kMaxVertices)
      lines_.refuse("more than 2147483647 vertices cannot be indexed; reduce the mesh first");
    mesh_.vertices.push_back(x);
  }

  void read_face() {
    polygon_.clear();
    for (auto word = LineReader::take_word(words_); !word.empty();
         word = LineReader::take_word(words_))
      polygon_.push_back(vertex_of(word));
    if (polygon_.size() < 3)
      lines_.refuse("the face has " + count_of(polygon_.size(), "corner") +
                    "; a face needs at least 3, export the mesh again");
    const std::size_t before = mesh_.triangles.size();
    append_fan(polygon_, mesh_.triangles);
    for (const std::vector<std::size_t>& of_kind : current_)
      for (const std::size_t group : of_kind)
        for (std::size_t t = before; t < mesh_.triangles.size(); ++t)
          (*groups_)[group].triangles.push_back(static_cast<std::int32_t>(t));
  }

  // A statement g may name several groups. The names of objects and materials may contain spaces.
  void read_group(std::string_view keyword) {
    const auto kind = keyword == "g"   ? MeshGroup::Kind::group
                      : keyword == "o" ? MeshGroup::Kind::object
                                       : MeshGroup::Kind::material;
    std::vector<std::size_t>& current = current_[static_cast<std::size_t>(kind)];
    current.clear();
    if (kind != MeshGroup::Kind::group) {
      std::string_view first = words_;
      const std::string_view word = LineReader::take_word(first);
      if (word.empty()) return;
      std::string_view rest(word.data(), static_cast<std::size_t>(words_.end() - word.begin()));
      while (rest.ends_with(' ') || rest.ends_with('\t')) rest.remove_suffix(1);
      current.push_back(group_of(kind, rest));
      return;
    }
    for (auto word = LineReader::take_word(words_); !word.empty();
         word = LineReader::take_word(words_))
      if (const std::size_t group = group_of(kind, word);
          std::find(current.begin(), current.end(), group) == current.end())
        current.push_back(group);
  }

  std::size_t group_of(MeshGroup::Kind kind, std::string_view name) {
    const auto [at, is_new] =
        number_of_.try_emplace({static_cast<int>(kind), std::string(name)}, groups_->size());
    if (is_new) groups_->push_back({kind, std::string(name), {}});
    return at->second;
  }

  // A corner is v, v/vt, v//vn or v/vt/vn. Indices start at 1; negative ones count from the end.
  std::int32_t vertex_of(std::string_view corner) {
    const std::size_t slash = std::min(corner.find('/'), corner.size());
    std::int64_t index = 0;
    if (!parse_integer(corner.substr(0, slash), index) || !is_attribute(corner.substr(slash)))
      lines_.refuse(in_quotes(corner) +
                    " is not a face corner; expected v, v/vt, v//vn or v/vt/vn");
    return checked_index(index);
  }

  static bool is_attribute(std::string_view rest) {
    std::int64_t unused = 0;
    for (int part = 0; !rest.empty(); ++part) {
      if (part == 2) return false;
      rest.remove_prefix(1);
      const std::size_t end = std::min(rest.find('/'), rest.size());
      if (end > 0 && !parse_integer(rest.substr(0, end), unused)) return false;
      rest.remove_prefix(end);
    }
    return true;
  }

  std::int32_t checked_index(std::int64_t index) {
    const auto n = static_cast<std::int64_t>(mesh_.vertices.size());
    if (index == 0) lines_.refuse("a face names vertex 0; OBJ indices begin at 1");
    if (index < -n)
      lines_.refuse("a face names vertex " + std::to_string(index) + " counted from the end, but " +
                    "only " + count_of(mesh_.vertices.size(), "vertex line") + " stand before it");
    if (index < 0) return static_cast<std::int32_t>(n + index);
    if (index > kMaxVertices) refuse_index(lines_.line(), index);
    if (index > n && index > forward_index_) {
      forward_index_ = index;
      forward_line_ = lines_.line();
    }
    return static_cast<std::int32_t>(index - 1);
  }

  // A face may precede its vertices, so the largest such index is checked at the end.
  void check_forward_reference() const {
    if (forward_index_ > static_cast<std::int64_t>(mesh_.vertices.size()))
      refuse_index(forward_line_, forward_index_);
  }

  [[noreturn]] void refuse_index(std::size_t line, std::int64_t index) const {
    refuse_line(source_, line,
                "a face names vertex " + std::to_string(index) + ", but the file has " +
                    std::to_string(mesh_.vertices.size()) +
                    "; it is damaged or cut short, export the mesh again");
  }

  const MeshSource& source_;
  LineReader lines_;
  std::string_view words_;
  std::string joined_;
  TriangleMesh mesh_;
  std::vector<std::int32_t> polygon_;
  std::vector<MeshGroup>* groups_;
  std::array<std::vector<std::size_t>, 3> current_;  // groups of the next face, by kind
  std::map<std::pair<int, std::string>, std::size_t> number_of_;
  std::int64_t forward_index_ = 0;
  std::size_t forward_line_ = 0;
};

}  // namespace

TriangleMesh read_obj(const MeshSource& source, std::vector<MeshGroup>* groups) {
  return ObjReader(source, groups).read();
}

}  // namespace selvedge::detail
