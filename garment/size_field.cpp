// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/garment/detail/size_field.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace selvedge::detail {
namespace {

/// Growth of the edge length per distance from a short side.
constexpr double kGrowth = 0.35;
/// Of the wanted length; shorter sides have slender triangles. The field has one value for a cell
/// as long as the wanted length, so shorter edges would fill the cell.
constexpr double kShortest = 0.1;

double side_distance(const std::array<Eigen::Vector2d, 2>& side, const Eigen::Vector2d& p) {
  const Eigen::Vector2d along = side[1] - side[0];
  const double t = std::clamp((p - side[0]).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - side[0] - t * along).norm();
}

}  // namespace

SizeField::SizeField(std::span<const Eigen::Vector2d> loop, std::span<const Side> lines,
                     double length, std::int64_t cells)
    : cell_(length) {
  Eigen::Vector2d low = loop[0], high = loop[0];
  for (const Eigen::Vector2d& p : loop) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector2d counts = ((high - low) / cell_).array().floor() + 4.0;
  if (!(counts.x() * counts.y() <= static_cast<double>(cells)))
    throw std::invalid_argument(
        fmt::format("an edge length of {:g} m gives more than {} vertices in a panel of {:g} m by "
                    "{:g} m; choose a larger one",
                    length, cells, high.x() - low.x(), high.y() - low.y()));
  low_ = low - Eigen::Vector2d::Constant(1.5 * cell_);
  columns_ = static_cast<std::int64_t>(counts.x());
  rows_ = static_cast<std::int64_t>(counts.y());
  size_.assign(columns_ * rows_, length);
  for (std::size_t i = 0; i < loop.size(); ++i)
    sides_.push_back({loop[i], loop[(i + 1) % loop.size()]});
  sides_.insert(sides_.end(), lines.begin(), lines.end());
  enter_sides();
  grade();
}

std::size_t SizeField::cell_of(const Eigen::Vector2d& p) const {
  const auto place = [&](double x, std::int64_t n) {
    return static_cast<std::int64_t>(std::clamp(std::floor(x / cell_), 0.0, double(n - 1)));
  };
  return place(p.y() - low_.y(), rows_) * columns_ + place(p.x() - low_.x(), columns_);
}

void SizeField::enter_sides() {
  std::vector<std::pair<std::size_t, std::int32_t>> entries;
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    const auto& [a, b] = sides_[i];
    const double length = (b - a).norm();
    const auto samples = static_cast<std::int32_t>(std::ceil(2.0 * length / cell_)) + 1;
    for (std::int32_t k = 0; k <= samples; ++k) {
      const std::size_t cell = cell_of(a + (static_cast<double>(k) / samples) * (b - a));
      size_[cell] = std::min(size_[cell], std::max(length, kShortest * cell_));
      entries.push_back({cell, static_cast<std::int32_t>(i)});
    }
  }
  std::sort(entries.begin(), entries.end());
  entries.erase(std::unique(entries.begin(), entries.end()), entries.end());
  first_.assign(size_.size() + 1, 0);
  for (const auto& [cell, side] : entries) ++first_[cell + 1];
  for (std::size_t c = 0; c < size_.size(); ++c) first_[c + 1] += first_[c];
  for (const auto& [cell, side] : entries) list_.push_back(side);
}

// Two passes of a distance transform over the eight neighbours [Borgefors1986].
void SizeField::grade() {
  const auto relax = [&](std::int64_t x, std::int64_t y, std::int64_t dx, std::int64_t dy) {
    if (x + dx < 0 || x + dx >= columns_ || y + dy < 0 || y + dy >= rows_) return;
    double& here = size_[y * columns_ + x];
    const double step = dx != 0 && dy != 0 ? std::sqrt(2.0) : 1.0;
    here = std::min(here, size_[(y + dy) * columns_ + x + dx] + kGrowth * step * cell_);
  };
  for (std::int64_t y = 0; y < rows_; ++y)
    for (std::int64_t x = 0; x < columns_; ++x)
      for (const auto& [dx, dy] : {std::pair{-1, 0}, {-1, -1}, {0, -1}, {1, -1}})
        relax(x, y, dx, dy);
  for (std::int64_t y = rows_ - 1; y >= 0; --y)
    for (std::int64_t x = columns_ - 1; x >= 0; --x)
      for (const auto& [dx, dy] : {std::pair{1, 0}, {1, 1}, {0, 1}, {-1, 1}}) relax(x, y, dx, dy);
}

double SizeField::distance(const Eigen::Vector2d& p) const {
  const auto at = static_cast<std::int64_t>(cell_of(p));
  const std::int64_t x = at % columns_, y = at / columns_;
  double least = std::numeric_limits<double>::infinity();
  for (std::int64_t j = std::max<std::int64_t>(0, y - 1); j <= std::min(rows_ - 1, y + 1); ++j)
    for (std::int64_t i = std::max<std::int64_t>(0, x - 1); i <= std::min(columns_ - 1, x + 1); ++i)
      for (std::int32_t k = first_[j * columns_ + i]; k < first_[j * columns_ + i + 1]; ++k)
        least = std::min(least, side_distance(sides_[list_[k]], p));
  return least;
}

}  // namespace selvedge::detail
