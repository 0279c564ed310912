// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/resolution.h>

#include <limits>

namespace selvedge::detail {
namespace {

constexpr std::size_t kVertexSamples = 2048;
constexpr std::size_t kBoxSamples = 128;
constexpr double kOutermost = 1e12;  // see to_float of dop.h
constexpr double kSteps = 0x1p-45;   // pieces narrower than this fraction of their position are
                                     // omitted

void add_samples(std::span<const Vec3> x, const std::array<int, 3>& d,
                 std::vector<double>& samples) {
  const std::size_t stride = x.size() / kVertexSamples + 1;
  for (std::size_t i = 0; i < x.size(); i += stride)
    samples.push_back((d[0] * x[i][0] + d[1] * x[i][1]) + d[2] * x[i][2]);
}

}  // namespace

QuantileMap::QuantileMap(std::vector<double> samples) {
  std::sort(samples.begin(), samples.end());
  // Boundaries between pieces; the first piece lies before all samples, the last after them.
  std::vector<double> bounds;
  constexpr std::size_t inner = kPieces - 2;
  for (std::size_t i = 0; i <= inner && !samples.empty(); ++i) {
    const double s = samples[i * (samples.size() - 1) / inner];
    if (bounds.empty() || s - bounds.back() > kSteps * std::abs(s)) bounds.push_back(s);
  }
  if (bounds.empty()) bounds.push_back(0.0);
  const std::size_t n = bounds.size() - 1;
  const double width = bounds.back() - bounds.front();
  const double outer = width > 0.0 ? static_cast<double>(n) / width : 1.0;
  // Zero lies in the middle, where floats are finest.
  const double first = -0.5 * static_cast<double>(n);
  pieces_.fill({std::numeric_limits<double>::infinity(), 0.0, 0.0, 0.0, 0.0});
  pieces_[0] = {bounds.front(), outer, first, -kOutermost, first};
  for (std::size_t i = 0; i < n; ++i) {
    const double base = first + static_cast<double>(i);
    pieces_[i + 1] = {bounds[i], 1.0 / (bounds[i + 1] - bounds[i]), base, base, base + 1.0};
  }
  const double last = first + static_cast<double>(n);
  pieces_[n + 1] = {bounds.back(), outer, last, last, kOutermost};
}

std::vector<QuantileMap> quantile_maps(std::span<const std::array<int, 3>> directions,
                                       std::span<const Vec3> a, std::span<const Vec3> b) {
  std::vector<QuantileMap> maps;
  for (const std::array<int, 3>& d : directions) {
    std::vector<double> samples;
    add_samples(a, d, samples);
    add_samples(b, d, samples);
    maps.emplace_back(std::move(samples));
  }
  return maps;
}

std::vector<QuantileMap> quantile_maps(std::span<const std::vector<DoubleBox>* const> lists) {
  std::vector<QuantileMap> maps;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> samples;
    for (const std::vector<DoubleBox>* list : lists) {
      const std::size_t stride = list->size() / kVertexSamples + 1;
      for (std::size_t i = 0; i < list->size(); i += stride) samples.push_back((*list)[i].lo[k]);
    }
    maps.emplace_back(std::move(samples));
  }
  return maps;
}

std::vector<DoubleBox> sample_boxes(const SurfaceView& surface) {
  std::vector<DoubleBox> sample;
  const auto take = [&](const auto& primitives) {
    const std::size_t stride = primitives.size() / kBoxSamples + 1;
    for (std::size_t i = 0; i < primitives.size(); i += stride)
      sample.push_back(swept_box(surface, primitives[i]));
  };
  if (surface.triangles.empty())
    take(surface.edges);
  else
    take(surface.triangles);
  return sample;
}

void add_sample(std::span<const DoubleBox> list, std::vector<DoubleBox>& sample) {
  const std::size_t stride = list.size() / kBoxSamples + 1;
  for (std::size_t i = 0; i < list.size(); i += stride) sample.push_back(list[i]);
}

}  // namespace selvedge::detail
