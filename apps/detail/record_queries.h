// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/query_recorder.h>
#include <selvedge/scene/methods.h>

#include <optional>

namespace CLI {
class App;
}

namespace selvedge {

/// --record and --record-limit.
void add_record_options(CLI::App& command, QueryRecorderConfig& config);

/// A recording, or none if `config` names no file. Also a run that fails keeps what was recorded.
class RecordedRun {
 public:
  explicit RecordedRun(const QueryRecorderConfig& config);
  /// Every narrow phase that `methods` makes from now on is recorded.
  RecordedRun(const QueryRecorderConfig& config, Methods& methods);
  ~RecordedRun();
  RecordedRun(const RecordedRun&) = delete;
  RecordedRun& operator=(const RecordedRun&) = delete;

  /// None where nothing is recorded.
  QueryRecorder* recorder() { return recorder_ ? &*recorder_ : nullptr; }
  /// Writes the files and says so on the error stream.
  void write();

 private:
  std::optional<QueryRecorder> recorder_;
};

}  // namespace selvedge
