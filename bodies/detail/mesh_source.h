// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/mesh_file.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace selvedge::detail {

/// A mesh file in memory. `name` starts every sentence about it.
struct MeshSource {
  std::string name;
  std::string bytes;
};

/// Size in bytes of a regular, non-empty file. Throws std::invalid_argument if it is none.
std::uintmax_t checked_size(const std::filesystem::path& file);
/// Reads a regular file whole. Throws std::invalid_argument if it is missing, empty, no file, …
MeshSource read_source(const std::filesystem::path& file);
/// The extension in lower case, with its dot.
std::string lower_extension(const std::filesystem::path& file);
/// True if read_mesh reads files of this extension.
bool is_own_format(const std::string& extension);

/// Throws std::invalid_argument "name: fault".
[[noreturn]] void refuse(const MeshSource& source, const std::string& fault);
/// Throws std::invalid_argument "name: line n: fault".
[[noreturn]] void refuse_line(const MeshSource& source, std::size_t line, const std::string& fault);

/// Lines of a text (ended by LF, CR LF or CR) and their words; counts lines for the sentences.
class LineReader {
 public:
  explicit LineReader(const MeshSource& source, std::size_t offset = 0, std::size_t line = 0)
      : source_(&source), at_(offset), line_(line) {}

  /// Goes to the next line. False at the end of the text.
  bool next();
  /// Goes to the next line that has a word; everything behind `comment` (0: none) is left out.
  bool next_filled(char comment);
  /// Leaves out what stands behind the first `comment` of this line.
  void strip(char comment) { text_ = text_.substr(0, text_.find(comment)); }

  /// The line without its end.
  std::string_view text() const { return text_; }
  std::size_t line() const { return line_; }
  /// Where the next line begins, bytes from the start of the file.
  std::size_t offset() const { return at_; }
  std::size_t bytes_left() const { return source_->bytes.size() - at_; }
  /// The next word of this line, empty if there is none. `words` is taken from the front.
  static std::string_view take_word(std::string_view& words);

  /// The next word as a finite double; `what` names it in the sentence.
  double take_double(std::string_view& words, const char* what) const;
  std::int64_t take_integer(std::string_view& words, const char* what) const;
  [[noreturn]] void refuse(const std::string& fault) const { refuse_line(*source_, line_, fault); }

 private:
  const MeshSource* source_;
  std::size_t at_, line_;
  std::string_view text_;
};

/// Exact value of a decimal number; false if `word` is none. Too large a number gives infinity.
bool parse_double(std::string_view word, double& value);
bool parse_integer(std::string_view word, std::int64_t& value);
/// A word of the file as it may stand in a sentence: short and printable.
std::string in_quotes(std::string_view word);
std::string count_of(std::size_t n, const char* thing);

/// Splits a polygon into a fan about its first corner.
void append_fan(std::span<const std::int32_t> polygon, std::vector<Triangle>& triangles);
/// Refuses a mesh without vertices or faces.
void require_surface(const MeshSource& source, const TriangleMesh& mesh);

TriangleMesh read_obj(const MeshSource& source);
TriangleMesh read_off(const MeshSource& source);
/// `extra` may be null.
TriangleMesh read_ply(const MeshSource& source, std::vector<NamedValues>* extra);

}  // namespace selvedge::detail
