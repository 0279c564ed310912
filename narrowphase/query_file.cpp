// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/files.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/narrowphase/detail/rational.h>
#include <selvedge/narrowphase/query_file.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using detail::RationalFault;

constexpr std::size_t kRows = 8, kColumns = 7, kTimeColumns = 4;
constexpr std::size_t kMaxQuoted = 40;
/// A row whose parts have their maximum length, with some reserve.
constexpr std::size_t kMaxLine = 7 * detail::kMaxDigits;
constexpr std::size_t kChunk = std::size_t{1} << 18;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string in_quotes(std::string_view word) {
  std::string text = "\"";
  for (const char c : word.substr(0, kMaxQuoted))
    text += std::isprint(static_cast<unsigned char>(c)) != 0 ? c : '?';
  return text + (word.size() > kMaxQuoted ? "...\"" : "\"");
}

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

// -- lines ----------------------------------------------------------------------------------------

/// The lines of a text file, counted from 1, without their ends.
class Lines {
 public:
  explicit Lines(const fs::path& file) : name_(file.string()), stream_(open(file)) {}

  /// Moves to the next line; returns false at the end of the file.
  bool next() {
    std::size_t end = buffer_.find('\n', at_);
    while (end == std::string::npos && more()) end = buffer_.find('\n', searched_);
    if (end == std::string::npos && at_ == buffer_.size()) return false;
    ++number_;
    text_ = std::string_view(buffer_).substr(at_, end - at_);
    at_ = end == std::string::npos ? buffer_.size() : end + 1;
    clean();
    return true;
  }

  std::string_view text() const { return text_; }
  std::size_t number() const { return number_; }
  const std::vector<std::string>& remarks() const { return remarks_; }

  [[noreturn]] void refuse(const std::string& fault) const { refuse(number_, fault); }
  [[noreturn]] void refuse(std::size_t line, const std::string& fault) const {
    throw std::invalid_argument(name_ + ": line " + std::to_string(line) + ": " + fault);
  }
  [[noreturn]] void refuse_file(const std::string& fault) const {
    throw std::invalid_argument(name_ + ": " + fault);
  }

 private:
  std::ifstream open(const fs::path& file) const {
    require_file(file, {.what = "query file", .pipes = true});
    std::ifstream stream(file, std::ios::binary);
    if (!stream) refuse_file("cannot be opened for reading; check its permissions");
    return stream;
  }

  /// Reads more after the unused part; returns false at the end of the file.
  bool more() {
    buffer_.erase(0, at_);
    at_ = 0;
    searched_ = buffer_.size();
    if (searched_ > kMaxLine) refuse(number_ + 1, "is too long; this is no query file");
    buffer_.resize(searched_ + kChunk);
    stream_.read(buffer_.data() + searched_, kChunk);
    buffer_.resize(searched_ + static_cast<std::size_t>(stream_.gcount()));
    if (stream_.bad()) refuse_file("cannot be read to its end");
    return buffer_.size() > searched_;
  }

  void clean() {
    if (number_ == 1 && text_.starts_with(kByteOrderMark)) {
      text_.remove_prefix(kByteOrderMark.size());
      remarks_.push_back(name_ + ": line 1: begins with a byte-order mark, which is ignored");
    }
    if (!text_.ends_with('\r')) return;
    text_.remove_suffix(1);
    if (windows_) return;
    windows_ = true;
    remarks_.push_back(name_ + ": line " + std::to_string(number_) +
                       ": has a Windows line end (CR LF), which is accepted");
  }

  std::string name_;
  std::ifstream stream_;
  std::string buffer_;
  std::size_t at_ = 0, searched_ = 0, number_ = 0;
  std::string_view text_;
  bool windows_ = false;
  std::vector<std::string> remarks_;
};

/// Splits a line at its commas.
template <std::size_t N>
void split(const Lines& lines, const char* columns, std::array<std::string_view, N>& parts) {
  std::string_view rest = lines.text();
  const std::size_t count = 1 + static_cast<std::size_t>(std::count(rest.begin(), rest.end(), ','));
  if (count != N)
    lines.refuse("has " + std::to_string(count) + (count == 1 ? " column" : " columns") +
                 ", must have " + std::to_string(N) + ": " + columns);
  for (std::string_view& part : parts) {
    const std::size_t comma = rest.find(',');
    part = trimmed(rest.substr(0, comma));
    rest.remove_prefix(comma == std::string_view::npos ? rest.size() : comma + 1);
  }
}

// -- queries --------------------------------------------------------------------------------------

double coordinate(const Lines& lines, char axis, std::string_view num, std::string_view den) {
  double value = 0.0;
  const auto part = [&](const char* name) { return std::string(1, axis) + name; };
  switch (detail::parse_rational(num, den, value)) {
    case RationalFault::none:
      return value;
    case RationalFault::numerator:
      lines.refuse(part("_num") + " is " + in_quotes(num) +
                   ", must be an integer (a query file has no header)");
    case RationalFault::denominator:
      lines.refuse(part("_den") + " is " + in_quotes(den) + ", must be an integer");
    case RationalFault::zero_denominator:
      lines.refuse(part("_den") + " is zero; a coordinate is a quotient of two integers");
    case RationalFault::too_long:
      lines.refuse(part("_num") + " or " + part("_den") + " has more than " +
                   std::to_string(detail::kMaxDigits) + " digits");
    case RationalFault::no_double:
      break;
  }
  lines.refuse(std::string(1, axis) + " is " +
               in_quotes(std::string(num) + "/" + std::string(den)) +
               ", which no double equals; write each coordinate as an exact double");
}

bool truth_of(const Lines& lines, std::string_view text) {
  if (text != "0" && text != "1") lines.refuse("truth is " + in_quotes(text) + ", must be 0 or 1");
  return text == "1";
}

class QueryReader {
 public:
  QueryReader(const fs::path& file, ContactKind kind) : lines_(file) { set_.kind = kind; }

  QuerySet read() {
    while (next_row()) read_query();
    if (set_.queries.empty()) lines_.refuse_file("is empty; it holds no query");
    set_.remarks = lines_.remarks();
    return std::move(set_);
  }

 private:
  /// Moves to the next row; empty lines are allowed only at the end of the file.
  bool next_row() {
    if (!lines_.next()) return false;
    if (!trimmed(lines_.text()).empty()) return true;
    const std::size_t empty = lines_.number();
    while (lines_.next())
      if (!trimmed(lines_.text()).empty())
        lines_.refuse(empty, "is empty, but rows follow; remove it");
    return false;
  }

  void read_query() {
    const std::size_t first = lines_.number();
    Query& query = set_.queries.emplace_back();
    query.kind = set_.kind;
    bool truth = false;
    for (std::size_t row = 0; row < kRows; ++row) {
      if (row > 0 && !next_row())
        lines_.refuse(last_row_,
                      "the file ends after " + std::to_string(row) + " of the 8 rows of query " +
                          std::to_string(set_.queries.size() - 1) + ", which begins in line " +
                          std::to_string(first) + "; rows must come in eights");
      last_row_ = lines_.number();
      const bool stated = read_row((row < 4 ? query.x_t0 : query.x_t1)[row % 4]);
      if (row > 0 && stated != truth)
        lines_.refuse("truth is " + std::to_string(stated) + ", but line " + std::to_string(first) +
                      " of the same query says " + std::to_string(truth));
      truth = stated;
    }
    set_.truth.push_back(truth ? 1 : 0);
  }

  bool read_row(Vec3& x) {
    std::array<std::string_view, kColumns> parts;
    split(lines_, "x_num,x_den,y_num,y_den,z_num,z_den,truth", parts);
    for (int i = 0; i < 3; ++i) x[i] = coordinate(lines_, "xyz"[i], parts[2 * i], parts[2 * i + 1]);
    return truth_of(lines_, parts.back());
  }

  Lines lines_;
  QuerySet set_;
  std::size_t last_row_ = 0;
};

// -- times ----------------------------------------------------------------------------------------

double time_of(const Lines& lines, const char* name, std::string_view text) {
  double value = -1.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value >= 0.0 && value <= 1.0))
    lines.refuse(std::string(name) + " is " + in_quotes(text) + ", must be a time in [0, 1]");
  return value;
}

TimeEnclosure enclosure_of(const Lines& lines, bool truth, std::string_view lo,
                           std::string_view hi) {
  if (!truth) {
    if (!lo.empty() || !hi.empty()) lines.refuse("has a time, but truth is 0; leave it empty");
    return {};
  }
  const TimeEnclosure toi{time_of(lines, "toi_lo", lo), time_of(lines, "toi_hi", hi)};
  if (toi.lo > toi.hi) lines.refuse("toi_lo is later than toi_hi; swap them");
  return toi;
}

void read_time(const Lines& lines, std::size_t index, QuerySet& set) {
  std::array<std::string_view, kTimeColumns> parts;
  split(lines, "index,truth,toi_lo,toi_hi", parts);
  if (index >= set.queries.size())
    lines.refuse("there are only " + std::to_string(set.queries.size()) +
                 " queries in the query file beside it; the two files do not belong together");
  if (parts[0] != std::to_string(index))
    lines.refuse("index is " + in_quotes(parts[0]) + ", must be " + std::to_string(index) +
                 ": a line for each query, in order");
  const bool truth = truth_of(lines, parts[1]);
  if (truth != (set.truth[index] != 0))
    lines.refuse("truth is " + std::to_string(truth) + ", but the query file says " +
                 std::to_string(set.truth[index]) + " for query " + std::to_string(index));
  set.toi.push_back(enclosure_of(lines, truth, parts[2], parts[3]));
}

void read_times(const fs::path& file, QuerySet& set) {
  Lines lines(file);
  set.toi.reserve(set.queries.size());
  std::size_t index = 0;
  while (lines.next())
    if (!trimmed(lines.text()).empty()) read_time(lines, index++, set);
  if (index != set.queries.size())
    lines.refuse_file("has times for " + std::to_string(index) + " of " +
                      std::to_string(set.queries.size()) +
                      " queries; the two files do not belong together");
  set.remarks.insert(set.remarks.end(), lines.remarks().begin(), lines.remarks().end());
}

// -- the kind -------------------------------------------------------------------------------------

/// Letters in lower case, every run of other characters as one '-'.
std::string plain(const std::string& name) {
  std::string text;
  for (const char c : name) {
    const auto u = static_cast<unsigned char>(c);
    if (std::isalpha(u) != 0)
      text += static_cast<char>(std::tolower(u));
    else if (!text.ends_with('-'))
      text += '-';
  }
  return text;
}

bool says(const std::string& text, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(),
                     [&](const char* word) { return text.find(word) != std::string::npos; });
}

/// Folders may be called "ee" for other reasons; a file with that name is meant so.
std::optional<ContactKind> kind_in(const std::string& name, bool folder) {
  const std::string text = plain("." + name + ".");
  const bool point_triangle =
      says(text, {"vertex-face", "point-triangle", "vertexface", "pointtriangle"}) ||
      (!folder && says(text, {"-vf-", "-pt-"}));
  const bool edge_edge = says(text, {"edge-edge", "edgeedge"}) || (!folder && says(text, {"-ee-"}));
  if (point_triangle == edge_edge) return {};
  return edge_edge ? ContactKind::edge_edge : ContactKind::point_triangle;
}

}  // namespace

const char* query_kind_name(ContactKind kind) {
  return kind == ContactKind::edge_edge ? "edge_edge" : "point_triangle";
}

std::optional<ContactKind> query_kind_of(const fs::path& file) {
  if (const auto kind = kind_in(file.stem().string(), false)) return kind;
  std::error_code ignored;  // a folder without an absolute path has no informative name
  for (fs::path folder = fs::absolute(file, ignored).parent_path(); folder.has_relative_path();
       folder = folder.parent_path())
    if (const auto kind = kind_in(folder.filename().string(), true)) return kind;
  return {};
}

fs::path toi_file_of(const fs::path& file) {
  fs::path toi = file;
  if (toi.extension() == ".csv") toi.replace_extension();
  return toi += ".toi.csv";
}

QuerySet read_queries(const fs::path& file, std::optional<ContactKind> kind) {
  std::error_code error;
  if (!kind && fs::exists(file, error)) {
    kind = query_kind_of(file);
    if (!kind)
      throw std::invalid_argument(
          file.string() +
          ": neither the file name nor a folder name gives the kind of the queries; pass "
          "point_triangle or edge_edge, or put the file into a folder vertex-face or edge-edge");
  }
  if (kind == ContactKind::triangle_point) kind = ContactKind::point_triangle;
  QuerySet set = QueryReader(file, kind.value_or(ContactKind::point_triangle)).read();
  const fs::path toi = toi_file_of(file);
  if (fs::exists(toi, error)) read_times(toi, set);
  return set;
}

// -- writing --------------------------------------------------------------------------------------

struct QueryWriter::Files {
  explicit Files(const fs::path& file) : queries(file), times(toi_file_of(file)) {}

  AtomicFile queries, times;
  std::optional<ContactKind> kind;
  std::size_t count = 0;
  std::string text;
};

namespace {

bool is_finite(const Query& query) {
  const auto finite = [](const Vec3& x) { return x.allFinite(); };
  return std::all_of(query.x_t0.begin(), query.x_t0.end(), finite) &&
         std::all_of(query.x_t1.begin(), query.x_t1.end(), finite);
}

bool is_enclosure(const TimeEnclosure& toi) {
  return (toi.lo == kNoCollision && toi.hi == kNoCollision) ||
         (toi.lo >= 0.0 && toi.lo <= toi.hi && toi.hi <= 1.0);
}

void append_row(const Vec3& x, bool truth, std::string& text) {
  for (int i = 0; i < 3; ++i) {
    detail::append_rational(x[i], text);
    text += ',';
  }
  text += truth ? "1\n" : "0\n";
}

/// The fewest digits that give back the same double.
std::string shortest(double value) {
  constexpr std::size_t kLongest = 32;
  char digits[kLongest];
  return {digits, std::to_chars(digits, digits + kLongest, value).ptr};
}

}  // namespace

QueryWriter::QueryWriter(const fs::path& file) : files_(std::make_unique<Files>(file)) {}
QueryWriter::~QueryWriter() = default;

void QueryWriter::append(const Query& query, const TimeEnclosure& toi) {
  if (!is_finite(query))
    throw std::invalid_argument("a query with a coordinate that is not finite cannot be written");
  if (!is_enclosure(toi)) throw std::invalid_argument("toi must enclose a time in [0, 1]");
  Files& f = *files_;
  if (f.kind.value_or(query.kind) != query.kind)
    throw std::invalid_argument("a query file holds queries of one kind only");
  f.kind = query.kind;
  const bool truth = toi.lo != kNoCollision;
  f.text.clear();
  for (const Vec3& x : query.x_t0) append_row(x, truth, f.text);
  for (const Vec3& x : query.x_t1) append_row(x, truth, f.text);
  f.queries.write(f.text);
  f.text = std::to_string(f.count++) + (truth ? ",1," : ",0,");
  if (truth) f.text += shortest(toi.lo) + "," + shortest(toi.hi) + "\n";
  if (!truth) f.text += ",\n";
  f.times.write(f.text);
}

void QueryWriter::commit() {
  files_->queries.commit();
  files_->times.commit();
}

std::size_t QueryWriter::count() const { return files_->count; }

}  // namespace selvedge
