// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace selvedge {

/// lo <= the true time of impact <= hi; both kNoCollision where there is no collision.
struct TimeEnclosure {
  double lo = kNoCollision, hi = kNoCollision;
};

/// Queries of one kind and their true answers.
struct QuerySet {
  ContactKind kind = ContactKind::point_triangle;
  std::vector<Query> queries;
  std::vector<std::uint8_t> truth;     ///< one per query: 1 where the primitives collide
  std::vector<TimeEnclosure> toi;      ///< one per query, or none where no file tells
  std::vector<std::string> remarks{};  ///< sentences about what was read in spite of its form
};

/// "point_triangle" or "edge_edge".
const char* query_kind_name(ContactKind kind);

/// The kind that a path tells, by its file name, else by the nearest folder: vertex-face,
/// point-triangle or edge-edge (with - or _); in file names also vf, pt or ee (227vf.csv).
std::optional<ContactKind> query_kind_of(const std::filesystem::path& file);

/// The file of time enclosures beside X.csv: X.toi.csv.
std::filesystem::path toi_file_of(const std::filesystem::path& file);

/// Reads queries in the format of the public benchmark of B. Wang, Z. Ferguson, T. Schneider,
/// X. Jiang, M. Attene, D. Panozzo, A large-scale benchmark and an inclusion-based algorithm for
/// continuous collision detection, 2021: no header, eight rows a query, each
/// x_num,x_den,y_num,y_den,z_num,z_den,truth. Rows: p, a, b, c or a0, a1, b0, b1 at t = 0, then at
/// t = 1. The parts are integers of up to 100,000 digits whose quotient must be a double.
///
/// Where X.toi.csv lies beside X.csv (index,truth,toi_lo,toi_hi; the times empty without a
/// collision), it gives the times. `kind` need not be given where the path tells it.
///
/// Throws std::invalid_argument with one sentence (file, line, fault, remedy) for anything else;
/// Windows line ends and a byte-order mark are read, with a remark.
QuerySet read_queries(const std::filesystem::path& file, std::optional<ContactKind> kind = {});

/// Writes a query file and its times, each coordinate as the exact quotient of an integer and a
/// power of two: read_queries gives back the same bits. Both files appear when commit() returns.
/// Throws std::system_error if a file cannot be written.
class QueryWriter {
 public:
  explicit QueryWriter(const std::filesystem::path& file);
  ~QueryWriter();
  QueryWriter(const QueryWriter&) = delete;
  QueryWriter& operator=(const QueryWriter&) = delete;

  /// truth is 1 if `toi` is finite. Throws std::invalid_argument, and writes nothing, if a
  /// coordinate is not finite, `toi` is no enclosure in [0,1], or the kind is not the first one's.
  void append(const Query& query, const TimeEnclosure& toi);
  void commit();
  std::size_t count() const;

 private:
  struct Files;
  std::unique_ptr<Files> files_;
};

}  // namespace selvedge
