// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/internal/mesh_groups.h>
#include <selvedge/bodies/mesh_file.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace selvedge::detail {

/// A mesh file in memory. `name` starts every message about it.
struct MeshSource {
  std::string name;
  std::string bytes;
};

/// Size in bytes of a regular, non-empty file. Throws std::invalid_argument for anything else.
std::uintmax_t checked_size(const std::filesystem::path& file);
/// Reads a whole regular file. Throws std::invalid_argument if it is missing, empty or not a
/// regular file.
MeshSource read_source(const std::filesystem::path& file);
/// The extension in lower case, with its dot.
std::string lower_extension(const std::filesystem::path& file);
/// True if read_mesh reads files with this extension.
bool is_own_format(const std::string& extension);

/// Throws std::invalid_argument "name: fault".
[[noreturn]] void refuse(const MeshSource& source, const std::string& fault);
/// Throws std::invalid_argument "name: line n: fault".
[[noreturn]] void refuse_line(const MeshSource& source, std::size_t line, const std::string& fault);

/// Splits a text into lines (ended by LF, CR LF or CR) and words, and counts lines for messages.
class LineReader {
 public:
  explicit LineReader(const MeshSource& source, std::size_t offset = 0, std::size_t line = 0)
      : source_(&source), at_(offset), line_(line) {}

  /// Moves to the next line. Returns false at the end of the text.
  bool next();
  /// Moves to the next line that has a word. The text after `comment` (0: no comments) is ignored.
  bool next_filled(char comment);
  /// Removes the text after the first `comment` of this line.
  void strip(char comment) { text_ = text_.substr(0, text_.find(comment)); }

  /// The line without its line end.
  std::string_view text() const { return text_; }
  std::size_t line() const { return line_; }
  /// Start of the next line, in bytes from the start of the file.
  std::size_t offset() const { return at_; }
  std::size_t bytes_left() const { return source_->bytes.size() - at_; }
  /// Removes the next word from the front of `words` and returns it; empty if there is none.
  static std::string_view take_word(std::string_view& words);

  /// The next word as a finite double; `what` names the value in messages.
  double take_double(std::string_view& words, const char* what) const;
  std::int64_t take_integer(std::string_view& words, const char* what) const;
  [[noreturn]] void refuse(const std::string& fault) const { refuse_line(*source_, line_, fault); }

 private:
  const MeshSource* source_;
  std::size_t at_, line_;
  std::string_view text_;
};

/// Value of a decimal number, correctly rounded; false if `word` is not a number. A number that is
/// too large gives infinity.
bool parse_double(std::string_view word, double& value);
bool parse_integer(std::string_view word, std::int64_t& value);
/// A word of the file as quoted in a message: shortened and printable.
std::string in_quotes(std::string_view word);
std::string count_of(std::size_t n, const char* thing);

/// Splits a polygon into a triangle fan about its first corner.
void append_fan(std::span<const std::int32_t> polygon, std::vector<Triangle>& triangles);

/// Removes the vertices that no triangle uses; the others keep their order.
void drop_unused_vertices(TriangleMesh& mesh);
/// Throws std::invalid_argument if the mesh has no vertices or no faces, or if a vertex has too
/// many faces.
void require_surface(const MeshSource& source, const TriangleMesh& mesh);
/// Throws std::invalid_argument "name: ..." if more than 8192 triangles meet at a vertex: the time
/// of a check of the mesh is quadratic in that number. All indices must be valid.
void require_few_faces_at_vertices(const TriangleMesh& mesh, const std::string& name);

/// `groups` may be null.
TriangleMesh read_obj(const MeshSource& source, std::vector<MeshGroup>* groups = nullptr);
TriangleMesh read_off(const MeshSource& source);
/// `extra` may be null.
TriangleMesh read_ply(const MeshSource& source, std::vector<NamedValues>* extra);

}  // namespace selvedge::detail
