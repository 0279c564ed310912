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

struct QueryRecorderConfig {
  /// PREFIX.point_triangle.csv and PREFIX.edge_edge.csv are written, or, where it is a folder,
  /// point_triangle.csv and edge_edge.csv in it; a last .csv is left out.
  std::filesystem::path prefix;
  /// At most so many queries of each kind are kept (about 200 bytes each); 0: all.
  std::size_t limit = 100'000;
};

/// What was recorded of one kind.
struct RecordedQueries {
  std::filesystem::path file;
  std::size_t asked = 0, written = 0, positives = 0;
};

/// Keeps the queries that a narrow phase is asked and writes them with their true answers, which
/// ccd_exact gives. Of more than `limit` queries it keeps every second, fourth, eighth, ... one
/// from the first to the last, so that a recording covers a whole run and the same run gives the
/// same files.
class QueryRecorder {
 public:
  /// Opens the files, so that a place that cannot be written is known before a long run. Throws
  /// std::invalid_argument if there is no such folder.
  explicit QueryRecorder(const QueryRecorderConfig& config);
  ~QueryRecorder();

  void add(const Query& query);
  void add(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs);
  /// Writes and ends the recording. A kind that was never asked gets no file, and files of an
  /// earlier recording of that name go.
  std::vector<RecordedQueries> write();

 private:
  struct Sample;
  Sample& sample_of(ContactKind kind);

  std::mutex mutex_;
  std::size_t limit_;
  std::vector<Sample> samples_;  // point_triangle, edge_edge
};

/// Asks `method`, and `recorder` takes note of every query; the recorder must outlive it.
std::unique_ptr<NarrowPhase> make_recording(std::unique_ptr<NarrowPhase> method,
                                            QueryRecorder& recorder);

}  // namespace selvedge
