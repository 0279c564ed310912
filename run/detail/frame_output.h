// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/run/detail/checkpoint.h>
#include <selvedge/run/frame_writer.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/simulation.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace selvedge::detail {

/// Writes the states of a run into its result folder, in all formats of its scene.
class FrameOutput {
 public:
  /// Throws std::invalid_argument for a format that is not among `formats`, for an option that it
  /// does not have, and for one that needs one mesh if `mesh_changes`. Writes nothing yet. Keeps a
  /// reference to the scene.
  FrameOutput(const Scene& scene, const FrameFormatRegistry& formats, std::filesystem::path out,
              bool mesh_changes);

  /// Copies the present state as frame `number`, with all that its files hold.
  StateCopy copy_frame(const Simulation& simulation, int number) const;
  /// Writes a frame. Another thread may call write_step meanwhile.
  void write_frame(const StateCopy& copy);
  /// Writes the present state to steps/, after the states that the last step passed through.
  void write_step(const Simulation& simulation, int number);
  /// Gives the PLY frames 0 to `last` of the folder to the writers of all other formats, so that
  /// the series of a resumed run are complete even in a format that the run did not have before.
  void resume(const Simulation& simulation, int last);
  /// Whether resume() reads the frames.
  bool needs_former_frames() const { return !others_.empty(); }
  /// Numbers of the frames from 0 to `last` of which the folder lacks a PLY file: that of the
  /// cloth, or, where resume() reads it, that of the bodies.
  std::vector<int> missing_frames(const Simulation& simulation, int last) const;
  /// Completes the files of all formats. No frame follows.
  void finish();

 private:
  std::shared_ptr<const FrameParts> parts_of(const Simulation& simulation) const;
  void write_passed(const Simulation& simulation);

  std::filesystem::path out_;
  std::vector<std::string> piece_names_, body_names_;
  mutable std::shared_ptr<const FrameParts> parts_;  // of the mesh of parts_owner_
  mutable std::shared_ptr<const void> parts_owner_;
  double fps_;
  bool pressure_;  ///< whether frames hold contact pressures
  const Scene& scene_;
  std::unique_ptr<FrameWriter> ply_, steps_;
  std::vector<std::unique_ptr<FrameWriter>> others_;
  std::unique_ptr<FrameWriter> step_wrenches_;
};

}  // namespace selvedge::detail
