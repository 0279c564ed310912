// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/render.h>

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace selvedge {

/// What is known of a camera; the rest comes from the result's scene, or from what is to be seen.
struct CameraChoice {
  std::optional<Vec3> eye, target;      ///< m
  std::optional<double> field_of_view;  ///< degrees, vertical
  std::optional<int> width, height;     ///< pixels
};

/// Pictures of a result folder (layout: scene/output.h) or of a single mesh file. Of a single mesh,
/// closed parts look like bodies and open ones like cloth.
class ResultPictures {
 public:
  /// Throws std::invalid_argument if there is nothing to draw or what is there is damaged.
  explicit ResultPictures(std::filesystem::path result);

  bool is_folder() const { return is_folder_; }
  /// Numbers of the frames, ascending; {0} for a mesh file.
  const std::vector<int>& frames() const { return frames_; }
  /// Frames per second of the scene; 30 if it says nothing.
  double fps() const { return fps_; }
  /// Distance of the grid lines on cloth, m; 0 draws none. By default about a twentieth of the
  /// cloth.
  void set_grid(double spacing) { grid_ = spacing; }

  /// `choice`, completed by output.camera of the scene, completed so that all `shown` frames fit.
  Camera camera(const CameraChoice& choice, std::span<const int> shown);
  Image picture(int frame, const Camera& camera);

 private:
  /// Parts of a mesh that look alike.
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
  double grid_ = 0.0;                      ///< m
  std::vector<Eigen::Vector2d> material_;  ///< from the first frame, empty if that is not flat
  double backdrop_size_;                   ///< m, flat bodies larger than this are surroundings
  double ground_z_;                        ///< m; not a number: the lowest vertex of the frame
  int bodies_read_ = -1;                   ///< number of the frame in bodies_
  TriangleMesh bodies_;
};

/// Draws one frame of a result folder into a PNG file, whose folder is made if missing.
void render_result_frame(const std::filesystem::path& result, int frame, const CameraChoice& choice,
                         const std::filesystem::path& picture);

/// The connected parts of a mesh, ordered by their lowest vertex: triangles of each.
std::vector<std::vector<Triangle>> connected_parts(std::size_t vertices,
                                                   std::span<const Triangle> triangles);

}  // namespace selvedge
