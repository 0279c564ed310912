// SPDX-License-Identifier: MIT
//
// Measures of a result folder: strains, energies and drape, as numbers and tables.
#pragma once

#include <selvedge/core/cloth/measure.h>
#include <selvedge/simulation/run_result.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace selvedge {

struct MeasureConfig {
  int frame = -1;  ///< number of the frame; -1: the last one
  /// m, radius and centre (x, y) of the drape support. By default those of the scene's first
  /// upright cylinder; a centre without a radius needs that cylinder.
  std::optional<double> support_radius;
  std::optional<Eigen::Vector2d> support_centre;
};

/// Energies of a frame, and its growth in area.
struct FrameEnergies {
  double time = 0.0;                    ///< s
  std::map<std::string, double> joule;  ///< by the names of `energies`
  double spring_strain = 0.0;           ///< mean
  /// Growth of the summed area of the triangles [Ji2006, "face strain"].
  double area_growth = 0.0;
};

/// A spring between two vertices and its strain (L-L0)/L0.
struct SpringStrain {
  std::int32_t a = 0, b = 0;
  double strain = 0.0;
};

struct ResultMeasures {
  std::string scene;  ///< name
  int frame = 0;
  std::vector<Vec3> x;  ///< m
  std::vector<Triangle> triangles;
  std::vector<TriangleStrain> triangle_strains;
  std::vector<SpringStrain> spring_strains;
  StrainSummary sheet, springs;         ///< of the triangles and of the springs
  double picture_range = 0.0;           ///< strain at full colour in the picture
  std::map<std::string, double> joule;  ///< energies of the frame
  std::vector<FrameEnergies> frames;    ///< energies of every frame
  std::optional<DrapeSupport> support;  ///< nullopt: the scene has none and none was given
  std::optional<DrapeMeasures> drape;   ///< nullopt: the rim does not go around the support
};

/// Measures a frame of a result folder (layout: run/result_folder.h). Throws std::invalid_argument
/// with file, fault and remedy for a folder without a scene or frames, for a frame that does not
/// exist or does not fit the scene, and for a support centre without a support.
ResultMeasures measure_result(const std::filesystem::path& result, const MeasureConfig& config,
                              const Methods& methods = {});

/// The measures as JSON text, with the names of docs/fabrics.md.
std::string measures_text(const ResultMeasures& measures);

/// Writes strain.csv, springs.csv and energy.csv and, with a drape, rim.csv and spectrum.csv into a
/// folder.
void write_measure_tables(const ResultMeasures& measures, const std::filesystem::path& folder);

}  // namespace selvedge
