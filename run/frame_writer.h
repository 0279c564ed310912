// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/registry.h>
#include <selvedge/core/base/types.h>

#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

class OpenFile;

/// A piece of cloth or a body in the arrays of a frame: some of the vertices, and the triangles
/// whose first vertex is one of them.
struct FramePart {
  std::string name;
  std::size_t first = 0, count = 0;  ///< vertices
  Vec3 colour = Vec3::Zero();        ///< linear RGB in [0,1]
};

/// Texture coordinates, in the square from 0 to 1.
using TexturePoint = std::array<double, 2>;

/// Force and torque about a stated point, with what they act on.
struct NamedWrench {
  std::string
      on;  ///< body "ball", handle "left", vertex 24 of cloth "skirt", or cloth: and a cause
  Vec3 about = Vec3::Zero();                         ///< m
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  ///< N, N·m
};

/// One state as frame writers get it. The views are valid during the call only.
struct Frame {
  int number = 0;                       ///< from 0, without gaps
  double time = 0.0;                    ///< s
  std::span<const Vec3> x, v;           ///< cloth: m and m/s, one per vertex
  std::span<const Triangle> triangles;  ///< cloth
  /// More values of each cloth vertex: vx, vy, vz (m/s), water (kg, only in wet scenes), flag, side
  /// (of a tangle, while there is one) and pressure (Pa, an option of ply).
  std::span<const NamedValues> values;
  /// All bodies joined in scene order, m. Empty in scenes without bodies, and after frame 0 if no
  /// body moves.
  std::span<const Vec3> bodies;
  std::span<const Triangle> body_triangles;
  /// Empty: the cloth is one part, and so are the bodies.
  std::span<const FramePart> pieces{}, body_parts{};
  /// Of the corners of each triangle of the cloth, from its flat rest shape; NaN in pieces that
  /// have no flat one. Empty: none.
  std::span<const std::array<TexturePoint, 3>> texture{};
  /// Means of the steps since the frame before; empty unless the formats name "wrenches", at frame
  /// 0, and for the former frames of a resumed run.
  std::span<const NamedWrench> wrenches{};
};

/// Writes the frames of one run in one format. Every function throws std::runtime_error that names
/// file and cause where a file cannot be written.
class FrameWriter {
 public:
  virtual ~FrameWriter() = default;
  /// Writes the next frame; the first call starts new files. A resumed run calls it again for the
  /// frames that the folder has already, from frame 0.
  virtual void write(const Frame& frame) = 0;
  /// Writes the files that list all frames so far. Called after every new frame, and once after
  /// the earlier frames of a resumed run.
  virtual void update_series() {}
  /// Writes the files that can only be written when all frames are known. Called once after the
  /// last frame, also where a run stopped early; a resumed run calls it again.
  virtual void finish() {}
};

/// Properties of an output format.
struct FrameFormatTraits {
  std::string promise;  ///< content of the files, in one line
  std::string source;   ///< the specification, or the program that reads them
  /// Of files frames/cloth_00000 and frames/bodies_00000; "": it writes none.
  std::string extension{};
  std::vector<std::string> files{};  ///< other files, relative to the result folder
  bool one_mesh = false;             ///< every frame has the same vertices, so `refine` is refused
};

/// Formats by name. Each makes a writer into a result folder whose subfolder frames/ exists, and
/// writes nothing yet. A program may add its own (RunConfig::formats).
using FrameFormatRegistry =
    Registry<std::unique_ptr<FrameWriter>, FrameFormatTraits, const std::filesystem::path&>;
/// The formats of this library.
FrameFormatRegistry frame_formats();

// -- single files ---------------------------------------------------------------------------------

/// Writes FOLDER/cloth_NUMBER.ply and FOLDER/bodies_NUMBER.ply; NUMBER has at least `digits`
/// digits.
std::unique_ptr<FrameWriter> make_ply_writer(const std::filesystem::path& folder, int digits);

/// VTK PolyData (.vtp): doubles, appended raw; velocity per point unless `v` is empty. Throws
/// std::invalid_argument for another number of velocities, std::runtime_error with file and cause.
/// The file appears only when it is complete.
void write_vtp(const std::filesystem::path& file, std::span<const Vec3> x, std::span<const Vec3> v,
               std::span<const Triangle> triangles);
/// ParaView series (.pvd): names `pieces` relative to its own folder, with their `times` (s).
/// Errors as in write_vtp.
void write_pvd(const std::filesystem::path& file, const std::vector<std::filesystem::path>& pieces,
               std::span<const double> times);

/// Point cache (.pc2, float) for Blender's mesh-cache modifier of a mesh with the same vertices.
/// The frame count in the header grows after each frame, so the file is a valid cache of the
/// complete frames at any moment. Throws std::runtime_error with file and cause.
class Pc2Writer {
 public:
  /// Starts a new file for frames of `points` vertices; sample i belongs to Blender's frame 1 + i.
  Pc2Writer(const std::filesystem::path& file, std::size_t points);
  /// Continues a file that has at least `frames_kept` frames and drops all later ones. Throws
  /// std::invalid_argument if it is not a cache of `points` vertices or has fewer frames.
  Pc2Writer(const std::filesystem::path& file, std::size_t points, int frames_kept);
  ~Pc2Writer();
  Pc2Writer(const Pc2Writer&) = delete;
  Pc2Writer& operator=(const Pc2Writer&) = delete;

  /// Throws std::invalid_argument for a wrong number of points or one outside the range of float.
  void append(std::span<const Vec3> x);
  int frames() const { return frames_; }

 private:
  std::string name_;  // of the file
  std::unique_ptr<OpenFile> file_;
  std::size_t points_ = 0;
  int frames_ = 0;
};

}  // namespace selvedge
