// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/pictures/renderer/render.h>

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace selvedge {

/// Given properties of a camera. The others come from the scene of the result, or are chosen so
/// that the picture shows everything.
struct CameraChoice {
  std::optional<Vec3> eye, target;      ///< m
  std::optional<double> field_of_view;  ///< degrees, vertical
  std::optional<int> width, height;     ///< pixels
};

/// Pictures of a result folder (layout: result_folder.h) or of a single mesh file. In a mesh file,
/// closed parts are drawn as bodies and open parts as cloth.
class ResultPictures {
 public:
  /// Throws std::invalid_argument if there is nothing to draw or a file is damaged.
  explicit ResultPictures(std::filesystem::path result);

  bool is_folder() const { return is_folder_; }
  /// Numbers of the frames, ascending; {0} for a mesh file.
  const std::vector<int>& frames() const { return frames_; }
  /// Frames per second of the scene; 30 by default.
  double fps() const { return fps_; }
  /// `choice`, completed first by output.camera of the scene, then so that all `shown` frames fit.
  Camera camera(const CameraChoice& choice, std::span<const int> shown);
  Image picture(int frame, const Camera& camera);

 private:
  /// Parts of a mesh with the same look.
  struct Look {
    RenderSurface surface;
    std::vector<Triangle> triangles;
  };
  void add_parts(const TriangleMesh& mesh, bool is_body, std::vector<Look>& looks) const;
  TriangleMesh cloth(int frame) const;
  const TriangleMesh& bodies(int frame);
  void read_scene_file();
  void prepare_folder();

  std::filesystem::path result_;
  bool is_folder_ = false;
  std::vector<int> frames_, body_frames_;
  double fps_ = 30.0;
  CameraChoice scene_camera_;
  double grid_ = 0.0;  ///< m, between the grid lines on cloth: about a twentieth of it
  std::vector<Eigen::Vector2d>
      material_;          ///< in-plane coordinates in the first frame; empty if it is not flat
  double backdrop_size_;  ///< m, diagonal above which a body is part of the surroundings
  double ground_z_;       ///< m; NaN: the lowest vertex of the frame
  int bodies_read_ = -1;  ///< number of the frame in bodies_
  TriangleMesh bodies_;
};

/// Draws one frame of a result folder into a PNG file and makes the folder of that file if needed.
void render_result_frame(const std::filesystem::path& result, int frame, const CameraChoice& choice,
                         const std::filesystem::path& picture);

/// The triangles of each connected part of a mesh. The parts are ordered by their lowest vertex.
std::vector<std::vector<Triangle>> connected_parts(std::size_t vertices,
                                                   std::span<const Triangle> triangles);

}  // namespace selvedge
