// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/simulation/run_result.h>

#include <filesystem>
#include <string>
#include <vector>

namespace selvedge {

// clang-format off
/// Layout of a result folder:
///   scene.json                the scene as run, with absolute paths
///   result.json               the fields of RunResult
///   frames/cloth_00000.ply    one per frame: positions and velocities in double, and flags
///   frames/bodies_00000.ply   all bodies joined; one file if nothing moves, else one per frame
///   frames/, *.pvd, *.pc2     files of other formats that `output` of the scene asks for
///   steps/cloth_000000.ply    with --every-step: one per accepted state,
///   steps/bodies_000000.ply   and the bodies as in frames/
///   pictures/frame_00000.png
///   checkpoint.ply, .json     the state from which --resume continues, written with each frame
///   lock                      while a run writes here (core/system/internal/files.h)
///   failure/                  of a run that stopped (layout: replay.h)
// clang-format on

/// Least number of digits in the names of frames and steps.
inline constexpr int kFrameFileDigits = 5, kStepFileDigits = 6;

/// folder / stem_00042.extension; `digits` is the least number of digits.
std::filesystem::path numbered(const std::filesystem::path& folder, const std::string& stem,
                               int number, int digits, const std::string& extension);
/// Numbers of the files STEM_NUMBER.ply in a folder, ascending; empty if there is no such folder.
/// Throws std::invalid_argument if the folder cannot be read.
std::vector<int> numbers_of(const std::filesystem::path& folder, const std::string& stem);

/// The files of one state of a result folder.
struct ResultState {
  std::filesystem::path cloth, bodies;  ///< `bodies` is empty where the scene has none
};

/// The states that a check of a result folder examines.
struct ResultStates {
  std::vector<ResultState> states;
  /// True: every accepted state in order, so the straight paths between neighbours are those that
  /// the run keeps free of collisions. False: frames, with other states between them.
  bool every_step = false;
};

/// Lists the states of a result folder. Throws std::invalid_argument with one sentence if there is
/// no frame, or if a state or a body file is missing, without which a check would be incomplete.
ResultStates result_states(const std::filesystem::path& folder);

/// The result as JSON text with the field names of RunResult. A number that is not finite becomes
/// the string "nan", "inf" or "-inf", never null.
std::string result_text(const RunResult& result);
/// Reads the text of result_text. Throws std::invalid_argument for other text.
RunResult result_from_text(const std::string& text);
/// Writes result_text to a file, which appears only when it is complete. Throws std::runtime_error
/// with file and cause.
void write_result(const std::filesystem::path& file, const RunResult& result);

}  // namespace selvedge
