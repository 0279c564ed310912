// SPDX-License-Identifier: MIT
// PLY as declared by its header: any elements and properties in any order. The reader keeps the
// coordinates, the vertex list of the faces and, on request, further double values of the vertices.
#include <selvedge/bodies/detail/mesh_source.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

namespace selvedge::detail {

namespace {

enum class Scalar { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
enum class Encoding { ascii, little_endian, big_endian };

struct ScalarName {
  std::string_view name;
  Scalar type;
};

constexpr ScalarName kScalarNames[] = {
    {"char", Scalar::int8},      {"int8", Scalar::int8},       {"uchar", Scalar::uint8},
    {"uint8", Scalar::uint8},    {"short", Scalar::int16},     {"int16", Scalar::int16},
    {"ushort", Scalar::uint16},  {"uint16", Scalar::uint16},   {"int", Scalar::int32},
    {"int32", Scalar::int32},    {"uint", Scalar::uint32},     {"uint32", Scalar::uint32},
    {"float", Scalar::float32},  {"float32", Scalar::float32}, {"double", Scalar::float64},
    {"float64", Scalar::float64}};

constexpr std::size_t size_of(Scalar type) {
  switch (type) {
    case Scalar::int8:
    case Scalar::uint8:
      return 1;
    case Scalar::int16:
    case Scalar::uint16:
      return 2;
    case Scalar::int32:
    case Scalar::uint32:
    case Scalar::float32:
      return 4;
    case Scalar::float64:
      return 8;
  }
  return 8;
}

constexpr bool is_integer(Scalar type) {
  return type != Scalar::float32 && type != Scalar::float64;
}

enum class Role { skip, x, y, z, extra, corners };

struct Property {
  std::string name;
  Scalar type;
  std::optional<Scalar> count_type;  ///< set for a list
  Role role = Role::skip;
  std::size_t extra_index = 0;
};

struct Element {
  std::string name;
  std::int64_t count;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
};

class HeaderReader {
 public:
  HeaderReader(const MeshSource& source, LineReader& lines) : source_(source), lines_(lines) {}

  Header read() {
    next();
    if (LineReader::take_word(words_) != "ply")
      lines_.refuse("the file does not begin with 'ply'; it is not a PLY file");
    while (!done_) {
      next();
      read_statement(LineReader::take_word(words_));
    }
    if (!has_format_) refuse(source_, "the header names no format; it is damaged");
    return std::move(header_);
  }

 private:
  void next() {
    if (!lines_.next())
      refuse(source_, "the header has no end_header; the file is cut short, export it again");
    words_ = lines_.text();
  }

  void read_statement(std::string_view keyword) {
    if (keyword == "format")
      read_format();
    else if (keyword == "element")
      read_element();
    else if (keyword == "property")
      read_property();
    else if (keyword == "end_header")
      done_ = true;
    else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info")
      lines_.refuse(in_quotes(keyword) +
                    " is not a statement of a PLY header; the file is damaged");
  }

  void read_format() {
    const std::string_view name = LineReader::take_word(words_);
    if (name == "ascii")
      header_.encoding = Encoding::ascii;
    else if (name == "binary_little_endian")
      header_.encoding = Encoding::little_endian;
    else if (name == "binary_big_endian")
      header_.encoding = Encoding::big_endian;
    else
      lines_.refuse("the format " + in_quotes(name) +
                    " is unknown; expected ascii, binary_little_endian or binary_big_endian");
    has_format_ = true;
  }

  void read_element() {
    Element element;
    element.name = LineReader::take_word(words_);
    element.count = lines_.take_integer(words_, "the number of elements");
    if (element.count < 0 || element.count > std::numeric_limits<std::int32_t>::max())
      lines_.refuse("the element " + in_quotes(element.name) + " has the count " +
                    std::to_string(element.count) + ", which is impossible");
    for (const Element& other : header_.elements)
      if (other.name == element.name)
        lines_.refuse("the element " + in_quotes(element.name) + " is declared twice");
    header_.elements.push_back(std::move(element));
  }

  void read_property() {
    if (header_.elements.empty()) lines_.refuse("a property precedes the first element");
    Property property;
    std::string_view type = LineReader::take_word(words_);
    if (type == "list") {
      property.count_type = scalar(LineReader::take_word(words_));
      if (!is_integer(*property.count_type))
        lines_.refuse("the length of a list is a floating-point number");
      type = LineReader::take_word(words_);
    }
    property.type = scalar(type);
    property.name = LineReader::take_word(words_);
    if (property.name.empty()) lines_.refuse("a property has no name; the header is damaged");
    for (const Property& other : header_.elements.back().properties)
      if (other.name == property.name)
        lines_.refuse("the property " + in_quotes(property.name) + " is declared twice");
    header_.elements.back().properties.push_back(std::move(property));
  }

  Scalar scalar(std::string_view name) const {
    for (const ScalarName& known : kScalarNames)
      if (known.name == name) return known.type;
    lines_.refuse("the type " + in_quotes(name) + " is unknown in PLY");
  }

  const MeshSource& source_;
  LineReader& lines_;
  std::string_view words_;
  Header header_;
  bool has_format_ = false, done_ = false;
};

// Rows of an ASCII body: one element per line.
class AsciiBody {
 public:
  AsciiBody(const MeshSource& source, const LineReader& header) : source_(source), lines_(header) {}

  static std::size_t min_bytes(const Property& property) {
    return property.role == Role::corners ? 8 : 2;  // "3 0 1 2 " and "0 "
  }
  std::size_t bytes_left() const {
    return lines_.bytes_left() + 1;
  }  // the last line may lack its end

  void begin_row(const Element& element, std::int64_t row) {
    if (!lines_.next_filled(0))
      refuse(source_, "ends after " + std::to_string(row) + " of " + std::to_string(element.count) +
                          " elements '" + element.name +
                          "'; it is cut short, export the mesh again");
    words_ = lines_.text();
  }
  void end_row() {
    const std::string_view word = LineReader::take_word(words_);
    if (!word.empty())
      lines_.refuse("more values than the header declares, from " + in_quotes(word) + " on");
  }
  double take(Scalar) {
    const std::string_view word = LineReader::take_word(words_);
    double value = 0.0;
    if (word.empty()) lines_.refuse("fewer values than the header declares; the file is damaged");
    if (!parse_double(word, value)) lines_.refuse(in_quotes(word) + " is not a number");
    return value;
  }
  std::int64_t take_index(Scalar) { return lines_.take_integer(words_, "an index or count"); }
  void skip(Scalar type, std::int64_t n) {
    for (; n > 0; --n) take(type);
  }
  void finish() {
    if (lines_.next_filled(0))
      lines_.refuse("more lines follow than the header counts; correct the counts");
  }
  std::string place(const Element&, std::int64_t) const {
    return "line " + std::to_string(lines_.line());
  }

 private:
  const MeshSource& source_;
  LineReader lines_;
  std::string_view words_;
};

template <class T>
T from_bytes(const char* bytes, bool swap) {
  std::array<char, sizeof(T)> copy;
  std::copy_n(bytes, sizeof(T), copy.begin());
  if (swap) std::reverse(copy.begin(), copy.end());
  return std::bit_cast<T>(copy);
}

class BinaryBody {
 public:
  BinaryBody(const MeshSource& source, const LineReader& header, Encoding encoding)
      : source_(source),
        at_(source.bytes.data() + header.offset()),
        end_(source.bytes.data() + source.bytes.size()),
        swap_((encoding == Encoding::big_endian) != (std::endian::native == std::endian::big)) {}

  static std::size_t min_bytes(const Property& property) {
    const std::size_t corners = property.role == Role::corners ? 3 : 0;
    return property.count_type ? size_of(*property.count_type) + corners * size_of(property.type)
                               : size_of(property.type);
  }
  std::size_t bytes_left() const { return static_cast<std::size_t>(end_ - at_); }

  void begin_row(const Element& element, std::int64_t row) { element_ = &element, row_ = row; }
  void end_row() {}
  double take(Scalar type) {
    const char* bytes = advance(size_of(type), 1);
    switch (type) {
      case Scalar::float32:
        return static_cast<double>(from_bytes<float>(bytes, swap_));
      case Scalar::float64:
        return from_bytes<double>(bytes, swap_);
      default:
        return static_cast<double>(integer(bytes, type));
    }
  }
  std::int64_t take_index(Scalar type) { return integer(advance(size_of(type), 1), type); }
  void skip(Scalar type, std::int64_t n) { advance(size_of(type), n); }
  // Writers add at most a line end or padding at the end; anything else means wrong counts.
  void finish() {
    for (; at_ < end_; ++at_)
      if (*at_ != '\n' && *at_ != '\r' && *at_ != ' ' && *at_ != '\0')
        refuse(source_, "has " + count_of(bytes_left(), "byte") +
                            " more than its header counts; the header is wrong");
  }
  std::string place(const Element& element, std::int64_t row) const {
    return element.name + " " + std::to_string(row);
  }

 private:
  const char* advance(std::size_t size, std::int64_t n) {
    if (n > static_cast<std::int64_t>(bytes_left() / size))
      refuse(source_, "ends within " + place(*element_, row_) + " of " +
                          std::to_string(element_->count) +
                          "; it is damaged or cut short, export the mesh again");
    const char* bytes = at_;
    at_ += size * static_cast<std::size_t>(n);
    return bytes;
  }

  std::int64_t integer(const char* bytes, Scalar type) const {
    switch (type) {
      case Scalar::int8:
        return from_bytes<std::int8_t>(bytes, swap_);
      case Scalar::uint8:
        return from_bytes<std::uint8_t>(bytes, swap_);
      case Scalar::int16:
        return from_bytes<std::int16_t>(bytes, swap_);
      case Scalar::uint16:
        return from_bytes<std::uint16_t>(bytes, swap_);
      case Scalar::int32:
        return from_bytes<std::int32_t>(bytes, swap_);
      default:
        return from_bytes<std::uint32_t>(bytes, swap_);
    }
  }

  const MeshSource& source_;
  const char *at_, *end_;
  bool swap_;
  const Element* element_ = nullptr;
  std::int64_t row_ = 0;
};

class PlyReader {
 public:
  PlyReader(const MeshSource& source, std::vector<NamedValues>* extra)
      : source_(source), extra_(extra) {}

  TriangleMesh read() {
    LineReader lines(source_);
    header_ = HeaderReader(source_, lines).read();
    assign_roles();
    if (header_.encoding == Encoding::ascii)
      read_body(AsciiBody(source_, lines));
    else
      read_body(BinaryBody(source_, lines, header_.encoding));
    return std::move(mesh_);
  }

 private:
  void assign_roles() {
    if (extra_) extra_->clear();
    assign_vertex_roles(element("vertex"));
    assign_face_roles(element("face"));
  }

  Element& element(const char* name) {
    for (Element& e : header_.elements)
      if (e.name == name) return e;
    refuse(source_, std::string("the header declares no element '") + name +
                        "'; export the mesh as a surface of vertices and faces");
  }

  void assign_vertex_roles(Element& vertex) {
    vertex_count_ = vertex.count;
    int coordinates = 0;
    for (Property& p : vertex.properties) {
      if (p.count_type) continue;
      if (p.name == "x" || p.name == "y" || p.name == "z") {
        p.role = p.name == "x" ? Role::x : p.name == "y" ? Role::y : Role::z;
        ++coordinates;
      } else if (extra_ && (p.type == Scalar::float64 || p.type == Scalar::uint8)) {
        p.role = Role::extra;
        p.extra_index = extra_->size();
        extra_->push_back({p.name, {}, p.type == Scalar::uint8});
      }
    }
    if (coordinates != 3)
      refuse(source_, "the vertices must have the properties x, y and z; export the mesh again");
  }

  void assign_face_roles(Element& face) {
    for (Property& p : face.properties)
      if (p.count_type && (p.name == "vertex_indices" || p.name == "vertex_index")) {
        if (!is_integer(p.type))
          refuse(source_, "the vertex indices of the faces are floating-point numbers");
        p.role = Role::corners;
        return;
      }
    refuse(source_, "the faces have no list vertex_indices; export the mesh with faces");
  }

  template <class Body>
  void read_body(Body body) {
    for (const Element& e : header_.elements) {
      check_count(body, e);
      reserve(e);
      for (std::int64_t row = 0; row < e.count; ++row) read_row(body, e, row);
    }
    body.finish();
  }

  template <class Body>
  void check_count(const Body& body, const Element& e) const {
    std::size_t bytes = 0;
    for (const Property& p : e.properties) bytes += Body::min_bytes(p);
    if (e.count > 0 &&
        (bytes == 0 || static_cast<std::size_t>(e.count) > body.bytes_left() / bytes))
      refuse(source_, "the header gives " + std::to_string(e.count) + " of element '" + e.name +
                          "', more than the file can hold; it is damaged or cut short, export "
                          "the mesh again");
  }

  void reserve(const Element& e) {
    const auto n = static_cast<std::size_t>(e.count);
    if (e.name == "face") mesh_.triangles.reserve(n);
    if (e.name != "vertex") return;
    mesh_.vertices.reserve(n);
    if (extra_)
      for (NamedValues& values : *extra_) values.values.reserve(n);
  }

  template <class Body>
  void read_row(Body& body, const Element& e, std::int64_t row) {
    body.begin_row(e, row);
    Vec3 x = Vec3::Zero();
    for (const Property& p : e.properties) switch (p.role) {
        case Role::x:
          x[0] = body.take(p.type);
          break;
        case Role::y:
          x[1] = body.take(p.type);
          break;
        case Role::z:
          x[2] = body.take(p.type);
          break;
        case Role::extra:
          (*extra_)[p.extra_index].values.push_back(body.take(p.type));
          break;
        case Role::corners:
          read_corners(body, e, row, p);
          break;
        case Role::skip:
          body.skip(p.type, length(body, e, row, p));
          break;
      }
    body.end_row();
    if (e.name != "vertex") return;
    if (!x.allFinite())
      refuse(source_, body.place(e, row) + ": vertex " + std::to_string(row) +
                          " has a coordinate that is not finite");
    mesh_.vertices.push_back(x);
  }

  template <class Body>
  std::int64_t length(Body& body, const Element& e, std::int64_t row, const Property& p) const {
    if (!p.count_type) return 1;
    const std::int64_t n = body.take_index(*p.count_type);
    if (n < 0) refuse(source_, body.place(e, row) + ": a list has a negative length");
    return n;
  }

  /// The place and the number of a face; in binary files the number is the place.
  template <class Body>
  static std::string face_at(const Body& body, const Element& e, std::int64_t row) {
    const std::string place = body.place(e, row), face = "face " + std::to_string(row);
    return place == face ? face : place + ": " + face;
  }

  template <class Body>
  void read_corners(Body& body, const Element& e, std::int64_t row, const Property& p) {
    const std::int64_t n = length(body, e, row, p);
    if (n < 3)
      refuse(source_, face_at(body, e, row) + " has " + std::to_string(n) +
                          " corners; a face needs at least 3");
    polygon_.clear();
    for (std::int64_t k = 0; k < n; ++k) {
      const std::int64_t index = body.take_index(p.type);
      if (index < 0 || index >= vertex_count_)
        refuse(source_, face_at(body, e, row) + " names vertex " + std::to_string(index) +
                            ", but the file has vertices 0 to " +
                            std::to_string(vertex_count_ - 1));
      polygon_.push_back(static_cast<std::int32_t>(index));
    }
    append_fan(polygon_, mesh_.triangles);
  }

  const MeshSource& source_;
  std::vector<NamedValues>* extra_;
  Header header_;
  std::int64_t vertex_count_ = 0;
  TriangleMesh mesh_;
  std::vector<std::int32_t> polygon_;
};

}  // namespace

TriangleMesh read_ply(const MeshSource& source, std::vector<NamedValues>* extra) {
  return PlyReader(source, extra).read();
}

}  // namespace selvedge::detail
