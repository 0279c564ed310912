// SPDX-License-Identifier: MIT
#include <selvedge/bodies/detail/mesh_source.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/system/internal/read_file.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <system_error>

namespace selvedge {

namespace detail {

namespace {

// 2^28 vertices in double precision, more than any use case; prevents a sparse file of terabytes
// from filling the memory.
constexpr std::uintmax_t kMaxFileSize = std::uintmax_t{8} << 30;
constexpr std::size_t kMaxQuotedLength = 40;

std::string_view without_sign(std::string_view word) {
  const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
  return plus ? word.substr(1) : word;
}

// std::from_chars reports overflow and underflow alike; this distinguishes them. Rarely called.
bool parse_extreme(std::string_view word, double& value) {
  std::istringstream stream{std::string(word)};
  stream.imbue(std::locale::classic());
  stream >> value;
  if (stream.fail()) value = std::copysign(HUGE_VAL, value);
  return true;
}

}  // namespace

std::uintmax_t checked_size(const std::filesystem::path& file) {
  const std::string name = file.string();
  require_file(file, {.what = "mesh file"});
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw std::invalid_argument(name + ": cannot be opened: " + error.message());
  if (size == 0) throw std::invalid_argument(name + ": is empty; export the mesh again");
  if (size > kMaxFileSize)
    throw std::invalid_argument(name + ": is larger than 8 GiB; reduce the mesh first");
  return size;
}

MeshSource read_source(const std::filesystem::path& file) {
  MeshSource source;
  source.name = file.string();
  const std::uintmax_t size = checked_size(file);
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw std::invalid_argument(source.name +
                                ": cannot be opened for reading; check its permissions");
  source.bytes.resize(size);
  stream.read(source.bytes.data(), static_cast<std::streamsize>(size));
  if (static_cast<std::uintmax_t>(stream.gcount()) != size)
    throw std::invalid_argument(source.name + ": cannot be read to its end");
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";  // some editors begin text with it
  if (source.bytes.starts_with(byte_order_mark)) source.bytes.erase(0, byte_order_mark.size());
  return source;
}

std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

bool is_own_format(const std::string& extension) {
  return extension == ".obj" || extension == ".ply" || extension == ".off";
}

void refuse(const MeshSource& source, const std::string& fault) {
  throw std::invalid_argument(source.name + ": " + fault);
}

void refuse_line(const MeshSource& source, std::size_t line, const std::string& fault) {
  refuse(source, "line " + std::to_string(line) + ": " + fault);
}

bool LineReader::next() {
  const std::string_view all = source_->bytes;
  if (at_ >= all.size()) return false;
  const std::size_t end = std::min(all.find_first_of("\r\n", at_), all.size());
  text_ = all.substr(at_, end - at_);
  at_ = std::min(end + 1, all.size());
  if (end + 1 < all.size() && all[end] == '\r' && all[end + 1] == '\n') ++at_;
  ++line_;
  return true;
}

bool LineReader::next_filled(char comment) {
  while (next()) {
    if (comment != 0) strip(comment);
    std::string_view words = text_;
    if (!take_word(words).empty()) return true;
  }
  return false;
}

std::string_view LineReader::take_word(std::string_view& words) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; };
  std::size_t begin = 0;
  while (begin < words.size() && blank(words[begin])) ++begin;
  std::size_t end = begin;
  while (end < words.size() && !blank(words[end])) ++end;
  const std::string_view word = words.substr(begin, end - begin);
  words.remove_prefix(end);
  return word;
}

double LineReader::take_double(std::string_view& words, const char* what) const {
  const std::string_view word = take_word(words);
  if (word.empty())
    refuse(std::string("the line ends before ") + what +
           "; the file is damaged or cut short, export the mesh again");
  double value = 0.0;
  if (!parse_double(word, value))
    refuse(std::string("expected ") + what + ", found " + in_quotes(word) +
           ", which is not a number");
  if (!std::isfinite(value))
    refuse(std::string(what) + " is " + in_quotes(word) + ", which is not finite");
  return value;
}

std::int64_t LineReader::take_integer(std::string_view& words, const char* what) const {
  const std::string_view word = take_word(words);
  if (word.empty())
    refuse(std::string("the line ends before ") + what +
           "; the file is damaged or cut short, export the mesh again");
  std::int64_t value = 0;
  if (!parse_integer(word, value))
    refuse(std::string("expected ") + what + ", found " + in_quotes(word) +
           ", which is not an integer");
  return value;
}

bool parse_double(std::string_view word, double& value) {
  word = without_sign(word);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size()) return false;
  if (error == std::errc::result_out_of_range) return parse_extreme(word, value);
  return error == std::errc();
}

bool parse_integer(std::string_view word, std::int64_t& value) {
  word = without_sign(word);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

std::string in_quotes(std::string_view word) {
  std::string text = "'";
  for (const char c : word.substr(0, kMaxQuotedLength))
    text += std::isprint(static_cast<unsigned char>(c)) ? c : '?';
  return text + (word.size() > kMaxQuotedLength ? "...'" : "'");
}

std::string count_of(std::size_t n, const char* thing) {
  return std::to_string(n) + " " + thing + (n == 1 ? "" : "s");
}

void drop_unused_vertices(TriangleMesh& mesh) {
  std::vector<std::int32_t> place(mesh.vertices.size(), -1);
  for (const Triangle& t : mesh.triangles)
    for (const std::int32_t v : t) place[v] = 0;
  std::int32_t kept = 0;
  for (std::size_t i = 0; i < place.size(); ++i) {
    if (place[i] < 0) continue;
    mesh.vertices[kept] = mesh.vertices[i];
    place[i] = kept++;
  }
  mesh.vertices.resize(static_cast<std::size_t>(kept));
  for (Triangle& t : mesh.triangles)
    for (std::int32_t& v : t) v = place[v];
}

void append_fan(std::span<const std::int32_t> polygon, std::vector<Triangle>& triangles) {
  for (std::size_t k = 2; k < polygon.size(); ++k)
    triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
}

void require_surface(const MeshSource& source, const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) refuse(source, "has no vertices; export the mesh again");
  if (mesh.triangles.empty())
    refuse(source, "has no faces; export the surface, not only its points");
  require_few_faces_at_vertices(mesh, source.name);
}

void require_few_faces_at_vertices(const TriangleMesh& mesh, const std::string& name) {
  constexpr std::int32_t most = 8192;
  std::vector<std::int32_t> faces(mesh.vertices.size(), 0);
  for (const Triangle& t : mesh.triangles)
    for (const std::int32_t v : t)
      if (++faces[v] > most)
        throw std::invalid_argument(
            name + ": more than " + std::to_string(most) + " triangles meet at vertex " +
            std::to_string(v) + " (a polygon counts as a fan); divide the face, or mesh it anew");
}

namespace {

TriangleMesh read_known(const MeshSource& source, const std::string& extension) {
  if (extension == ".obj") return read_obj(source);
  if (extension == ".off") return read_off(source);
  return read_ply(source, nullptr);
}

}  // namespace

}  // namespace detail

TriangleMesh read_mesh(const std::filesystem::path& file) {
  const std::string extension = detail::lower_extension(file);
  if (!detail::is_own_format(extension)) {
    detail::checked_size(file);  // for a missing file or a folder, that error is more helpful
    throw std::invalid_argument(file.string() + ": " +
                                (extension.empty()
                                     ? "has no extension"
                                     : "the extension '" + extension + "' is not supported") +
                                "; give an .obj, .ply or .off file");
  }
  const detail::MeshSource source = detail::read_source(file);
  TriangleMesh mesh = detail::read_known(source, extension);
  detail::require_surface(source, mesh);
  return mesh;
}

TriangleMesh read_ply(const std::filesystem::path& file, std::vector<NamedValues>& extra) {
  const detail::MeshSource source = detail::read_source(file);
  TriangleMesh mesh = detail::read_ply(source, &extra);
  detail::require_surface(source, mesh);
  return mesh;
}

}  // namespace selvedge
