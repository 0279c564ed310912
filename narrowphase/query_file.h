// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace selvedge {

/// lo <= true time of impact <= hi; both are kNoCollision if there is no collision.
struct TimeEnclosure {
  double lo = kNoCollision, hi = kNoCollision;
};

/// Queries of one kind and their true answers.
struct QuerySet {
  ContactKind kind = ContactKind::point_triangle;
  std::vector<Query> queries;
  std::vector<std::uint8_t> truth;     ///< one per query: 1 if the primitives collide
  std::vector<TimeEnclosure> toi;      ///< one per query, or empty if no file gives times
  std::vector<std::string> remarks{};  ///< sentences about irregularities that were accepted
};

/// "point_triangle" or "edge_edge".
const char* query_kind_name(ContactKind kind);

/// The kind that a path indicates: by its file name, otherwise by the nearest folder. Recognises
/// vertex-face, point-triangle and edge-edge (with - or _); in file names also vf, pt or ee
/// (227vf.csv).
std::optional<ContactKind> query_kind_of(const std::filesystem::path& file);

/// The file of time enclosures beside X.csv: X.toi.csv.
std::filesystem::path toi_file_of(const std::filesystem::path& file);

/// Reads queries in the format of the public benchmark of B. Wang, Z. Ferguson, T. Schneider, X.
/// Jiang, M. Attene, D. Panozzo, A large-scale benchmark and an inclusion-based algorithm for
/// continuous collision detection, 2021: no header, eight rows per query, each
/// x_num,x_den,y_num,y_den,z_num,z_den,truth. Rows: p, a, b, c or a0, a1, b0, b1 at t = 0, then at
/// t = 1. The parts are integers of up to 100,000 digits whose quotient must be a double.
///
/// If X.toi.csv exists beside X.csv (index,truth,toi_lo,toi_hi; empty times without a collision),
/// its times are read too. `kind` may be omitted if the path indicates it.
///
/// Throws std::invalid_argument with one sentence (file, line, fault, remedy) for any other input.
/// Accepts Windows line ends and a byte-order mark, with a remark.
QuerySet read_queries(const std::filesystem::path& file, std::optional<ContactKind> kind = {});

/// Writes a query file and its times, each coordinate as the exact quotient of an integer and a
/// power of two: read_queries returns the same bits. Both files appear when commit() returns.
/// Throws std::system_error if a file cannot be written.
class QueryWriter {
 public:
  explicit QueryWriter(const std::filesystem::path& file);
  ~QueryWriter();
  QueryWriter(const QueryWriter&) = delete;
  QueryWriter& operator=(const QueryWriter&) = delete;

  /// Appends a query; its truth is 1 if `toi` is finite. Throws std::invalid_argument, and writes
  /// nothing, if a coordinate is not finite, `toi` is not an enclosure in [0,1], or the kind
  /// differs from that of the first query.
  void append(const Query& query, const TimeEnclosure& toi);
  /// Completes both files and puts them in place.
  void commit();
  /// Number of queries appended.
  std::size_t count() const;

 private:
  struct Files;
  std::unique_ptr<Files> files_;
};

/// Options of a QueryRecorder.
struct QueryRecorderConfig {
  /// Writes PREFIX.point_triangle.csv and PREFIX.edge_edge.csv or, if PREFIX is a folder,
  /// point_triangle.csv and edge_edge.csv in it. A trailing .csv of PREFIX is dropped.
  std::filesystem::path prefix;
  /// Maximum number of queries kept of each kind (about 200 bytes each); 0: all.
  std::size_t limit = 100'000;
};

/// Result of recording queries of one kind.
struct RecordedQueries {
  std::filesystem::path file;
  std::size_t asked = 0, written = 0, positives = 0;
};

/// Keeps the queries that a narrow phase receives and writes them with their true answers, computed
/// by ccd_exact. If there are more than `limit` queries it keeps every second, fourth, eighth, ...
/// of them, so that a recording covers a whole run, and the same run gives the same files.
class QueryRecorder {
 public:
  /// Opens the files, so that an unwritable path is reported before a long run. Throws
  /// std::invalid_argument if the folder does not exist.
  explicit QueryRecorder(const QueryRecorderConfig& config);
  ~QueryRecorder();

  /// Records queries; the second form those of candidate pairs.
  void add(const Query& query);
  void add(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs);
  /// Writes the files and ends the recording. A kind without queries gets no file, and files of an
  /// earlier recording with that name are removed.
  std::vector<RecordedQueries> write();

 private:
  struct Sample;
  Sample& sample_of(ContactKind kind);

  std::mutex mutex_;
  std::size_t limit_;
  std::vector<Sample> samples_;  // point_triangle, edge_edge
};

/// A narrow phase that forwards every query to `method` and records it in `recorder`, which must
/// outlive it.
std::unique_ptr<NarrowPhase> make_recording(std::unique_ptr<NarrowPhase> method,
                                            QueryRecorder& recorder);

}  // namespace selvedge
