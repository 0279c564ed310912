// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/dress/dress_result.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace selvedge {

/// One garment of a batch.
struct DressJob {
  std::string name;  ///< of its folder: the name of the pattern's file without its suffix
  std::filesystem::path pattern, body;
};

/// The garments of a list. A folder: every `*.json` in it, in the order of their names, on `body`.
/// A file: one garment in each line, as PATTERN or PATTERN,BODY; relative paths start at the folder
/// of the file; empty lines and lines that begin with '#' are skipped; without a body in the line,
/// `body` is used. Throws std::invalid_argument for a list without garments, a line without a body,
/// and two garments with the same name.
std::vector<DressJob> read_dress_list(const std::filesystem::path& list,
                                      const std::filesystem::path& body);

struct DressBatchConfig {
  std::filesystem::path out;  ///< one folder for each garment, and index.html
  DressConfig dress;
  /// `out`, `body_name` and `body_file` are set for each garment. body_file.up is the up axis of
  /// the patterns.
  DressFolderConfig folder;
  /// Identifies the settings and the program. A finished garment is kept if this text and the
  /// bytes of its pattern and its body are those with which it was made.
  std::string settings;
  /// The body, with the axes of its file, in which its garment is written.
  std::function<BodyMesh(const std::filesystem::path&)> read_body;
  /// Writes view.html, to which the page links, into the folder of a garment; empty: no such pages.
  /// Garments that were finished before get one if they have none.
  std::function<void(const std::filesystem::path& folder)> write_view{};
};

/// What became of one garment.
struct DressBatchRow {
  DressJob job;
  bool worn = false;    ///< clean, sewn and at rest
  bool good = false;    ///< and nothing to object
  bool kept = false;    ///< was finished before
  bool view = false;    ///< has a page that shows it in three dimensions, view.html
  std::string verdict;  ///< DressResult::verdict
  std::size_t panels = 0, vertices = 0, states = 0;
  double seconds = 0.0;  ///< wall time, without the output
  double opening = 0.0;  ///< m, the largest of a seam
  double stretch = 0.0;  ///< the largest of a spring
};

/// Puts all garments on, one after the other, each into its folder in `out`, and calls `done` after
/// each of them. A garment that fails does not end the batch: its verdict gives the reason. After
/// each garment, out/index.html is written: one page with picture, verdict and measures of each.
/// Throws std::invalid_argument for a folder that cannot be used.
std::vector<DressBatchRow> dress_batch(const std::vector<DressJob>& jobs,
                                       const DressBatchConfig& config, const Methods& methods,
                                       const std::function<void(const DressBatchRow&)>& done = {});

/// Puts the garment of this name on, as dress_batch does, but writes no page: several processes may
/// put on garments of one list. Throws std::invalid_argument for a name that no job has.
DressBatchRow dress_one_of(const std::vector<DressJob>& jobs, const std::string& name,
                           const DressBatchConfig& config, const Methods& methods);

/// Writes out/Snakefile, a Snakemake workflow with one job for each garment and one for the page.
/// `arguments` of `selvedge dress`, to be run in `out`: the list and all options but the threads,
/// of which each job takes `threads` (0: one).
void write_dress_workflow(const std::filesystem::path& out, const std::vector<DressJob>& jobs,
                          const std::vector<std::string>& arguments, int threads);

/// FNV-1a over the bytes of a file, as 16 hex digits; a file that cannot be read counts as empty.
std::string file_hash(const std::filesystem::path& file);

/// The page of a batch; `open`: garments that have no row yet.
std::string dress_page(const std::vector<DressBatchRow>& rows, std::size_t open);

}  // namespace selvedge
