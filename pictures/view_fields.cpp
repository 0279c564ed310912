// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/measure.h>
#include <selvedge/detection/find.h>
#include <selvedge/pictures/detail/view_fields.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace selvedge::detail {
namespace {

// Two vertices of one piece whose rest distance is less than twice the rest gap are neighbours:
// they are nearer than the gap because the cloth is, not because a contact is squeezed.
constexpr double kShareOfRestDistance = 0.5;

// Full colour of strains and pressures, which have a few much larger values.
constexpr double kFullShare = 0.98;

constexpr double kPercent = 100.0, kMillimetres = 1000.0;

bool is_zero(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return v == 0.0F; });
}

bool has_values(const std::vector<std::vector<float>>& series) {
  return std::any_of(series.begin(), series.end(),
                     [](const std::vector<float>& values) { return !is_zero(values); });
}

std::uint8_t byte_of(double value, ViewScale scale, double full) {
  switch (scale) {
    case ViewScale::diverging:
      return static_cast<std::uint8_t>(128.0 +
                                       std::round(127.0 * std::clamp(value / full, -1.0, 1.0)));
    case ViewScale::sequential:
      return static_cast<std::uint8_t>(std::round(255.0 * std::clamp(value / full, 0.0, 1.0)));
    case ViewScale::flags:
    case ViewScale::sides:
      break;
  }
  return static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
}

/// Of the triangles at each vertex, the mean principal strain of larger magnitude, by rest area.
std::vector<float> vertex_strains(const TriangleMesh& cloth, const TriangleMesh& rest) {
  const std::vector<TriangleStrain> strains =
      triangle_strains(cloth.vertices, cloth.triangles, rest);
  std::vector<double> sum(cloth.vertices.size(), 0.0), area(cloth.vertices.size(), 0.0);
  for (std::size_t i = 0; i < strains.size(); ++i) {
    const TriangleStrain& s = strains[i];
    const double larger = std::abs(s.larger) >= std::abs(s.smaller) ? s.larger : s.smaller;
    for (const std::int32_t v : cloth.triangles[i]) {
      sum[v] += s.area * larger;
      area[v] += s.area;
    }
  }
  std::vector<float> values(sum.size(), 0.0F);
  for (std::size_t v = 0; v < sum.size(); ++v)
    if (area[v] > 0.0) values[v] = static_cast<float>(kPercent * sum[v] / area[v]);
  return values;
}

}  // namespace

FieldMaker::FieldMaker(const SceneOfView* scene, bool shortfall)
    : scene_(scene), wants_shortfall_(shortfall && scene != nullptr) {
  if (scene_ == nullptr) return;
  const BuiltScene& built = scene_->built;
  const auto pieces = static_cast<std::int32_t>(scene_->scene.cloths.size());
  for (std::int32_t p = 0; p + 1 < static_cast<std::int32_t>(built.piece_begin.size()); ++p)
    piece_.resize(static_cast<std::size_t>(built.piece_begin[p + 1]), p);
  for (std::size_t b = 0; b < built.bodies.size(); ++b)
    body_.resize(body_.size() + built.bodies[b]->vertex_count(),
                 pieces + static_cast<std::int32_t>(b));
  if (wants_shortfall_) pairs_.emplace(scene_->scene);
}

void FieldMaker::add(const TriangleMesh& cloth, const std::vector<NamedValues>& values,
                     const TriangleMesh* bodies) {
  add_strain(cloth);
  add_shortfall(cloth, bodies);
  add_named(values, "pressure", pressure_);
  add_named(values, "flag", flags_);
  add_named(values, "side", sides_);
}

void FieldMaker::add_strain(const TriangleMesh& cloth) {
  strain_.emplace_back();
  if (scene_ != nullptr && scene_->built.rest.triangles.size() == cloth.triangles.size())
    strain_.back() = vertex_strains(cloth, scene_->built.rest);
}

void FieldMaker::add_shortfall(const TriangleMesh& cloth, const TriangleMesh* bodies) {
  shortfall_.emplace_back();
  if (!wants_shortfall_ || cloth.vertices.size() != piece_.size()) return;
  std::vector<float> most(cloth.vertices.size(), 0.0F);
  const auto note = [&](const Proximity& p, std::size_t begin, std::size_t end, double gap) {
    const auto lacking = static_cast<float>(kMillimetres * (gap - p.gap));
    for (std::size_t k = begin; k < end; ++k)
      if (p.weight[k] != 0.0) most[p.vertex[k]] = std::max(most[p.vertex[k]], lacking);
  };
  const double reach = pairs_->largest_rest_gap();
  const auto& rest = scene_->built.rest.vertices;
  if (scene_->scene.contact.self)
    for (const Proximity& p : find_contacts(cloth.vertices, cloth.triangles, reach)) {
      if (p.kind != ContactKind::point_triangle) continue;
      const std::int32_t a = piece_[p.vertex[0]], b = piece_[p.vertex[1]];
      double gap = pairs_->rest_gap(a, b);
      if (a == b && rest.size() == cloth.vertices.size()) {
        Vec3 apart = Vec3::Zero();
        for (std::size_t k = 0; k < 4; ++k) apart += p.weight[k] * rest[p.vertex[k]];
        gap = std::min(gap, kShareOfRestDistance * apart.norm());
      }
      note(p, 0, 4, gap);
    }
  if (bodies != nullptr && bodies->vertices.size() == body_.size())
    for (const Proximity& p : find_contacts(SurfaceState{cloth.vertices, cloth.triangles},
                                            {bodies->vertices, bodies->triangles}, reach)) {
      if (p.kind == ContactKind::point_triangle)
        note(p, 0, 1, pairs_->rest_gap(piece_[p.vertex[0]], body_[p.vertex[1]]));
      else if (p.kind == ContactKind::triangle_point)
        note(p, 1, 4, pairs_->rest_gap(piece_[p.vertex[1]], body_[p.vertex[0]]));
    }
  shortfall_.back() = std::move(most);
}

void FieldMaker::add_named(const std::vector<NamedValues>& values, const std::string& name,
                           Series& series) {
  series.emplace_back();
  for (const NamedValues& named : values)
    if (named.name == name) series.back().assign(named.values.begin(), named.values.end());
}

std::vector<ViewField> FieldMaker::fields() const {
  std::vector<ViewField> list;
  const auto append = [&](ViewField field, const Series& series) {
    if (has_values(series)) list.push_back(make_field(std::move(field), series));
  };
  append({.name = "strain",
          .meaning = "principal strain of larger magnitude",
          .unit = "%",
          .scale = ViewScale::diverging,
          .full = quantile_of(strain_, kFullShare)},
         strain_);
  append({.name = "shortfall",
          .meaning = "how much nearer than the rest gap a vertex or face is to another surface",
          .unit = "mm",
          .scale = ViewScale::sequential,
          .full = quantile_of(shortfall_, 1.0)},
         shortfall_);
  append({.name = "pressure",
          .meaning = "contact pressure of the step that ends with the frame",
          .unit = "Pa",
          .scale = ViewScale::sequential,
          .full = quantile_of(pressure_, kFullShare)},
         pressure_);
  append({.name = "flags",
          .meaning = "guarantees that do not hold at a vertex",
          .scale = ViewScale::flags},
         flags_);
  append({.name = "sides", .meaning = "sides of tangles", .scale = ViewScale::sides}, sides_);
  return list;
}

double quantile_of(const std::vector<std::vector<float>>& values, double share) {
  std::vector<float> all;
  for (const std::vector<float>& frame : values)
    for (const float v : frame)
      if (v != 0.0F && std::isfinite(v)) all.push_back(std::abs(v));
  if (all.empty()) return 0.0;
  const auto at = std::min(all.size() - 1, static_cast<std::size_t>(share * all.size()));
  std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(at), all.end());
  return all[at];
}

ViewField make_field(ViewField field, const std::vector<std::vector<float>>& values) {
  for (const std::vector<float>& frame : values) {
    std::vector<std::uint8_t>& bytes = field.frames.emplace_back();
    if (is_zero(frame)) continue;
    bytes.reserve(frame.size());
    for (const float v : frame) bytes.push_back(byte_of(v, field.scale, field.full));
  }
  return field;
}

}  // namespace selvedge::detail
