// SPDX-License-Identifier: MIT
//
// Results as one page that a browser opens without a server: the cloth and the bodies of each
// frame, and values of the vertices as colours.
#pragma once

#include <selvedge/core/base/types.h>
#include <selvedge/scene/methods.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace selvedge {

/// How the page turns the byte of a vertex into a colour.
enum class ViewScale : std::uint8_t {
  diverging,   ///< byte 128 is 0, 1 is -full, 255 is +full
  sequential,  ///< byte 0 is 0, 255 is full
  flags,       ///< the byte is a sum of VertexFlag
  sides,       ///< 0: outside of tangles; odd and even bytes are the two sides of a tangle
};

/// One value of each vertex in each frame.
struct ViewField {
  std::string name;     ///< one word, as in the address of the page
  std::string meaning;  ///< one sentence
  std::string unit{};   ///< of `full`; "" for flags and sides
  ViewScale scale = ViewScale::sequential;
  double full = 0.0;  ///< value at full colour; larger values have the same colour
  /// One list per frame, and in it one byte per vertex; an empty list stands for zeros.
  std::vector<std::vector<std::uint8_t>> frames{};
};

/// Vertices of the cloth or the bodies in one frame. `triangles` is an index into
/// ResultView::triangles; -1: there is no such surface.
struct ViewSurface {
  std::vector<Vec3> x;  ///< m
  int triangles = -1;
};

/// One frame of a result.
struct ViewFrame {
  int number = 0;
  double time = 0.0;  ///< s; of a failure bundle: from 0 at the start of the step to 1 at its end
  ViewSurface cloth;
  int bodies = -1;  ///< index into ResultView::bodies; -1: the scene has none
};

/// A pair of primitives that collides, as 4 points at the start and at the end of the step.
struct ViewPair {
  bool edge_edge = false;          ///< else point and triangle
  double toi = 0.0;                ///< time of impact, in [0,1]
  std::array<Vec3, 4> x_t0, x_t1;  ///< m
};

/// All that the page shows of one result.
struct ResultView {
  std::string name;                              ///< of the scene, or of the folder
  double fps = 30.0;                             ///< frames per second at true speed
  std::vector<std::vector<Triangle>> triangles;  ///< different surfaces over time
  std::vector<ViewSurface> bodies;               ///< one, or one per frame if bodies move
  std::vector<ViewFrame> frames;
  std::vector<ViewField> fields;
  std::vector<ViewPair> pairs;
  /// Names of the pieces of cloth, each with its first vertex; empty where a mesh changes.
  std::vector<std::pair<std::size_t, std::string>> pieces;
  std::vector<std::string> notes;  ///< sentences: what is not shown and why, why a run stopped
};

/// Choice of what a page holds.
struct ViewConfig {
  Methods methods{};  ///< that the scene of the result may name
  /// Of these frames, in their order; empty: all.
  std::vector<int> frames{};
  /// Measure how far vertices come nearer than the rest gap, which needs a search in each frame.
  bool shortfall = true;
  /// Called with the number of frames that are read so far.
  std::function<void(std::size_t frames)> progress{};
};

/// Numbers of the frames that a page of this result can show; {0} for a mesh file. Throws
/// std::invalid_argument if there are none.
std::vector<int> view_frames(const std::filesystem::path& result);

/// Reads a result folder (layout: run/result_folder.h), a failure bundle (run/internal/replay.h) or
/// a single mesh file. Throws std::invalid_argument if there is nothing to show or a file is
/// damaged. If the scene of the result can no longer be built, the view has no strains, and a note
/// says why.
ResultView read_view(const std::filesystem::path& result, const ViewConfig& config = {});

/// Keeps the frames that both have, and adds to each the distance of every vertex from the same
/// vertex of the other. If the vertices do not correspond, it adds a note instead. Throws
/// std::invalid_argument if they have no frame in common.
void add_distance(ResultView& a, ResultView& b);

/// The page of one result, or of two side by side. It is self-contained: it loads nothing from the
/// network or from other files. Positions are stored as 16-bit numbers in the box of each frame, so
/// that each coordinate is off by at most 1/131070 of the extent of its box; the page names the
/// largest such distance. Names are escaped. Throws std::invalid_argument unless there are one or
/// two results.
std::string view_page(std::span<const ResultView> results);

/// Largest distance of a vertex of the page from its position, m.
double quantisation_error(const ResultView& view);

}  // namespace selvedge
