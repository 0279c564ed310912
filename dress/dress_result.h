// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/mesh_file.h>
#include <selvedge/dress/dress.h>

#include <filesystem>
#include <string>
#include <vector>

namespace selvedge {

// clang-format off
/// Layout of the folder of a dressed garment:
///   result.json               verdict and measures (dress_result_text)
///   garment.obj               the garment with merged seams, the flat pattern as texture
///                             coordinates in metres, one group for each panel
///   garment.ply               the same vertices with flags, strains along warp and weft, and the
///                             pressure of the body (Pa)
///   body.obj                  the body on which it lies, if it differs from the user's
///   frames/cloth_00000.ply    the motion up to it, frame by frame, z up; frames/bodies_00000.ply
///   steps/cloth_000000.ply    with `every_step`: every accepted state
///   pictures/front.png, back.png, and the same of strain_ and pressure_: the largest strain of
///                             each triangle and the pressure, from dark blue (0) to yellow
///                             (strain_scale_top and pressure_scale_top_Pa of result.json)
///   fit.html                  with pictures: the fit report, with pictures/fit_front.png, fit_back.png,
///                             fit_left.png and fit_right.png
///   under/0.obj, ...          with garments below: as they lie under the new one, innermost first, as
///                             garment.obj without groups
///   poses/NAME.obj            of a moving body: the garment at each pose, as garment.obj; with
///                             pictures/last_pose_front.png, last_pose_back.png
///   motion/frames, motion/steps    the motion through the poses, with the body in each frame, and
///                             files of `pose_formats`, of which each has garments and body as pieces
// clang-format on
struct DressFolderConfig {
  std::filesystem::path out;  ///< made if missing; refused if it holds anything else
  bool every_step = false;    ///< also write every accepted state to steps/
  bool pictures = true;
  /// Axes and unit of garment.obj and garment.ply: those of the body's file.
  LoadConfig body_file{.up = UpAxis::y};
  std::string body_name;                  ///< for result.json
  std::vector<std::string> pose_names;    ///< of the files in poses/; missing ones are numbers
  std::vector<std::string> pose_formats;  ///< of the motion beside PLY, names of frame_formats()
};

/// Puts a garment on a body as `dress` does, and writes the folder. Fabrics that panels name are
/// found as seen from the folder of the pattern's file, its name. If the garment cannot be put
/// on, result.json gives the reason, and the function throws DressFailed. Throws
/// std::invalid_argument for a folder that cannot be used, and std::runtime_error for a file that
/// cannot be written.
DressResult dress_into_folder(const SewingPattern& pattern, const TriangleMesh& body,
                              const DressConfig& config, const DressFolderConfig& folder,
                              const Methods& methods = {});

/// The garments of a result folder, the innermost first, to be worn below another one: those that
/// it has in under/, and its own, with the fabric, strain limit and friction of result.json and
/// `outer_friction`. `body_file`: axes and unit with which the folder was made. Throws
/// std::invalid_argument for a folder without a garment, one that is not clean, and fabrics that
/// cannot be found.
std::vector<WornGarment> read_worn(const std::filesystem::path& folder, const LoadConfig& body_file,
                                   double outer_friction);

/// The verdict and the measures of a dressed garment as JSON text.
std::string dress_result_text(const std::string& pattern_name, const DressResult& result,
                              const std::string& body_name);

}  // namespace selvedge
