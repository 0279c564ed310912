// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/detail/make_piece.h>
#include <selvedge/scene/detail/read_values.h>
#include <selvedge/scene/detail/select_vertices.h>

#include <algorithm>
#include <cmath>

namespace selvedge::detail {

namespace {

/// Selects from one piece.
class Selection {
 public:
  Selection(const LocatedJson& document, const ClothSpec& cloth,
            const VertexSelector::Points& points, const ClothPatternRegistry& patterns)
      : document_(document), cloth_(cloth), points_(points), patterns_(patterns) {}

  std::vector<std::int32_t> select(const Json& j, const std::string& path) const {
    std::vector<std::int32_t> found;
    if (j.is_object())
      found = select_box(j["box"], join(path, "box"));
    else if (j.is_string())
      select_word(j, path, found);
    else
      for (std::size_t i = 0; i < j.size(); ++i) select_one(j[i], join(path, i), found);
    if (const auto* grid = std::get_if<ClothGrid>(&cloth_.shape);
        grid != nullptr && patterns_.at(grid->pattern).traits().two_layers)
      add_other_layer(found);
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

 private:
  /// Adds the vertices of the other layer of a bilayered grid, which coincide to the bit, so that
  /// both layers are held or weighted.
  void add_other_layer(std::vector<std::int32_t>& found) const {
    const std::vector<Vec3>& x = points_.placed;
    const std::size_t chosen = found.size();
    for (std::size_t i = 0; i < x.size(); ++i)
      for (std::size_t k = 0; k < chosen; ++k)
        if (x[i] == x[found[k]]) found.push_back(static_cast<std::int32_t>(i));
  }

  void select_one(const Json& j, const std::string& path, std::vector<std::int32_t>& found) const {
    if (j.is_string()) return select_word(j, path, found);
    const std::int64_t vertex = j.get<std::int64_t>(), count = std::ssize(points_.placed);
    if (vertex >= count)
      fail(document_, path,
           fmt::format("there is no vertex {}; {} has vertices 0 to {}", vertex,
                       in_quotes(cloth_.name), count - 1));
    found.push_back(static_cast<std::int32_t>(vertex));
  }

  /// A side such as x0, or a corner such as x0y1.
  void select_word(const Json& j, const std::string& path, std::vector<std::int32_t>& found) const {
    const auto word = j.get<std::string>();
    const GridConfig& grid = require_grid(path);
    if (word.size() > 2)
      found.push_back(corner(grid, word));
    else
      select_side(grid, word, path, found);
  }

  std::vector<std::int32_t> select_box(const Json& j, const std::string& path) const {
    const Vec3 low = read_vec3(j[0]), high = read_vec3(j[1]);
    if ((low.array() > high.array()).any())
      fail(document_, path, "the first corner must be the lowest in every coordinate");
    const std::vector<Vec3>& x = points_.placed;
    std::vector<std::int32_t> found;
    for (std::size_t i = 0; i < x.size(); ++i)
      if ((x[i].array() >= low.array()).all() && (x[i].array() <= high.array()).all())
        found.push_back(static_cast<std::int32_t>(i));
    if (found.empty()) fail(document_, path, describe_empty_box(x, cloth_.name));
    return found;
  }

  static std::string describe_empty_box(const std::vector<Vec3>& x, const std::string& name) {
    Vec3 low = x.front(), high = x.front();
    for (const Vec3& p : x) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    return fmt::format("selects nothing; {} lies from ({:g}, {:g}, {:g}) to ({:g}, {:g}, {:g}) m",
                       in_quotes(name), low.x(), low.y(), low.z(), high.x(), high.y(), high.z());
  }

  const GridConfig& require_grid(const std::string& path) const {
    const auto* grid = std::get_if<ClothGrid>(&cloth_.shape);
    if (grid == nullptr)
      fail(document_, path,
           in_quotes(cloth_.name) +
               " is a mesh and not a grid; select numbers of vertices or a \"box\"");
    return grid->grid;
  }

  std::int32_t corner(const GridConfig& grid, const std::string& word) const {
    const std::vector<Vec3>& x = points_.flat;
    const Vec3 wanted(word[1] == '0' ? -grid.size_x / 2 : grid.size_x / 2,
                      word[3] == '0' ? -grid.size_y / 2 : grid.size_y / 2, 0.0);
    const auto nearest = std::min_element(x.begin(), x.end(), [&](const Vec3& a, const Vec3& b) {
      return (a - wanted).squaredNorm() < (b - wanted).squaredNorm();
    });
    return static_cast<std::int32_t>(nearest - x.begin());
  }

  void select_side(const GridConfig& grid, const std::string& word, const std::string& path,
                   std::vector<std::int32_t>& found) const {
    const int axis = word[0] == 'x' ? 0 : 1;
    const double size = axis == 0 ? grid.size_x : grid.size_y;
    const std::int32_t cells = axis == 0 ? grid.cells_x : grid.cells_y;
    const double side = word[1] == '0' ? -size / 2 : size / 2;
    // Rows are one cell apart. Those of a triangular pattern begin half a cell further in or out,
    // so a third of a cell separates the outermost vertices from the next.
    const double reach = size / cells / 3.0;
    const std::vector<Vec3>& x = points_.flat;
    const std::size_t before = found.size();
    for (std::size_t i = 0; i < x.size(); ++i)
      if (std::abs(x[i][axis] - side) <= reach) found.push_back(static_cast<std::int32_t>(i));
    if (found.size() == before) fail(document_, path, "selects nothing");
  }

  const LocatedJson& document_;
  const ClothSpec& cloth_;
  const VertexSelector::Points& points_;
  const ClothPatternRegistry& patterns_;
};

}  // namespace

std::vector<std::int32_t> VertexSelector::select(const Json& select, const ClothSpec& cloth,
                                                 const std::string& path) {
  return Selection(document_, cloth, points(cloth), patterns_).select(select, path);
}

const VertexSelector::Points& VertexSelector::points(const ClothSpec& cloth) {
  const auto [place, is_new] = points_.try_emplace(cloth.name);
  if (!is_new) return place->second;
  const Material& material = materials_.at(cloth.material);
  place->second.placed = make_piece(cloth, material, patterns_).cloth.surface.vertices;
  if (!std::holds_alternative<ClothGrid>(cloth.shape)) return place->second;
  ClothSpec flat = cloth;
  flat.scale = 1.0;
  flat.placement = Placement{};
  std::get<ClothGrid>(flat.shape).path = StripPath{};
  place->second.flat = make_piece(flat, material, patterns_).cloth.surface.vertices;
  return place->second;
}

}  // namespace selvedge::detail
