// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>
#include <selvedge/narrowphase/query_file.h>

#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>
#include <vector>

namespace selvedge {

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
