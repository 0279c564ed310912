// SPDX-License-Identifier: MIT
// Edges with a label, such as a waist, that are held while the rest of a garment settles.
#include "dress_shapes.h"

#include <gtest/gtest.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/dressing.h>

#include <cmath>
#include <vector>

namespace selvedge::dress_labels_test {
namespace {

using namespace selvedge::dress_shapes;

/// The tube, whose upper edges have a label.
SewingPattern labelled(const char* label) {
  SewingPattern pattern = tube(0.6, 0.3, 0.32);
  for (PatternPanel& panel : pattern.panels) panel.edges[2].label = label;
  return pattern;
}

DressConfig coarse() {
  DressConfig config;
  config.edge_length = config.sewing_edge_length = 0.06;
  return config;
}

/// Vertices that stay at their place, to the bit, during a run of settled frames.
struct StillVertices {
  std::vector<std::vector<Vec3>> frames;

  std::size_t count(std::size_t first, std::size_t last) const {
    std::size_t still = 0;
    for (std::size_t v = 0; v < frames[first].size(); ++v)
      still += frames[first][v] == frames[last][v] ? 1 : 0;
    return still;
  }
};

DressResult dressed(const SewingPattern& pattern, const DressConfig& config, StillVertices& still) {
  const TriangleMesh body = cone(0.3, 0.6);
  std::size_t crossings = 0;
  DressObserver observer;
  observer.frame = [&](const Simulation& now, DressPhase phase, double) {
    crossings += find_crossings(now.positions(), now.cloth_triangles()).size();
    crossings +=
        find_crossings({now.positions(), now.cloth_triangles()}, {body.vertices, body.triangles})
            .size();
    if (phase == DressPhase::settle)
      still.frames.emplace_back(now.positions().begin(), now.positions().end());
  };
  const DressResult r = dress(pattern, body, config, {}, observer);
  EXPECT_EQ(crossings, 0u);
  return r;
}

TEST(DressLabels, AWaistIsHeldUntilTheRestHasSettled) {
  StillVertices still;
  const DressResult r = dressed(labelled("waist"), coarse(), still);
  EXPECT_EQ(r.fault(), "");
  // 0.6 m in 10 pieces on each side; the ends of the seams are common.
  EXPECT_EQ(r.held, 20u);
  EXPECT_GT(r.held_time, 0.1);
  EXPECT_LE(r.held_time, 0.5 + 1e-9);
  const auto held_frames = static_cast<std::size_t>(std::lround(r.held_time * 60.0));
  ASSERT_GT(still.frames.size(), held_frames + 12);
  EXPECT_EQ(still.count(0, held_frames - 1), r.held);
  // Then nothing holds it, and it is at rest only after a full window without the hold.
  EXPECT_EQ(still.count(held_frames - 1, still.frames.size() - 1), 0u);
}

TEST(DressLabels, OtherLabelsAndNoTimeHoldNothing) {
  StillVertices other, none;
  EXPECT_EQ(dressed(labelled("hem"), coarse(), other).held, 0u);
  DressConfig config = coarse();
  config.hold_time = 0.0;
  const DressResult r = dressed(labelled("waist"), config, none);
  EXPECT_EQ(r.held, 0u);
  EXPECT_EQ(r.held_time, 0.0);
  EXPECT_EQ(none.frames.back(), other.frames.back());
  config.hold_time = -1.0;
  EXPECT_THROW(dress(labelled("waist"), cone(0.3, 0.6), config), std::invalid_argument);
}

}  // namespace
}  // namespace selvedge::dress_labels_test
