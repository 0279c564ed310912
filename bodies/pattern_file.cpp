// SPDX-License-Identifier: MIT
#include <selvedge/bodies/detail/mesh_source.h>
#include <selvedge/bodies/mesh_file.h>

#include <utility>

namespace selvedge {
namespace {

using detail::LineReader;

class PatternReader {
 public:
  PatternReader(const detail::MeshSource& source, double unit)
      : source_(source), lines_(source), unit_(unit) {}

  TriangleMesh read() {
    while (lines_.next_filled('#')) {
      std::string_view words = lines_.text();
      const std::string_view keyword = LineReader::take_word(words);
      if (words.ends_with('\\'))
        lines_.refuse(
            "a line continued on the next line is not supported here; join the two lines");
      if (keyword == "vt") read_place(words);
      if (keyword == "f") read_face(words);
    }
    if (pattern_.triangles.empty()) detail::refuse(source_, "has no faces; export the mesh again");
    check_indices();
    return std::move(pattern_);
  }

 private:
  void read_place(std::string_view words) {
    const double u = lines_.take_double(words, "the texture coordinate u");
    const double v = lines_.take_double(words, "the texture coordinate v");
    pattern_.vertices.emplace_back(unit_ * u, unit_ * v, 0.0);
  }

  void read_face(std::string_view words) {
    polygon_.clear();
    for (auto word = LineReader::take_word(words); !word.empty();
         word = LineReader::take_word(words))
      polygon_.push_back(place_of(word));
    if (polygon_.size() < 3) lines_.refuse("the face has too few corners; it needs at least 3");
    detail::append_fan(polygon_, pattern_.triangles);
    line_of_.resize(pattern_.triangles.size(), lines_.line());
  }

  /// The number after the first slash of v/vt or v/vt/vn.
  std::int32_t place_of(std::string_view corner) const {
    const std::size_t slash = corner.find('/');
    std::int64_t index = 0;
    const std::string_view rest =
        slash == std::string_view::npos ? std::string_view{} : corner.substr(slash + 1);
    if (!detail::parse_integer(rest.substr(0, rest.find('/')), index) || index == 0)
      lines_.refuse(
          detail::in_quotes(corner) +
          " has no texture coordinate, which gives its position in the flat pattern; export "
          "the mesh with them");
    const auto n = static_cast<std::int64_t>(pattern_.vertices.size());
    if (index < -n) lines_.refuse("a face counts back beyond the first texture coordinate");
    constexpr std::int64_t most = 2147483647;
    if (index > most) lines_.refuse("a face names a texture coordinate beyond 2147483647");
    return static_cast<std::int32_t>(index < 0 ? n + index : index - 1);
  }

  void check_indices() const {
    for (std::size_t i = 0; i < pattern_.triangles.size(); ++i)
      for (const std::int32_t v : pattern_.triangles[i])
        if (v >= static_cast<std::int64_t>(pattern_.vertices.size()))
          detail::refuse_line(source_, line_of_[i],
                              "a face names texture coordinate " + std::to_string(v + 1) +
                                  ", but the file has " + std::to_string(pattern_.vertices.size()) +
                                  "; export the mesh again");
  }

  const detail::MeshSource& source_;
  LineReader lines_;
  double unit_;
  TriangleMesh pattern_;
  std::vector<std::int32_t> polygon_;
  std::vector<std::size_t> line_of_;  // per triangle
};

}  // namespace

TriangleMesh read_pattern(const std::filesystem::path& file, double unit) {
  const detail::MeshSource source = detail::read_source(file);
  if (detail::lower_extension(file) != ".obj")
    detail::refuse(
        source,
        "is not an OBJ file; the pattern is read from the texture coordinates of an OBJ file");
  return PatternReader(source, unit).read();
}

}  // namespace selvedge
