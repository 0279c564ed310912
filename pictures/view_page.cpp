// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/html.h>
#include <selvedge/pictures/detail/view_page.h>
#include <selvedge/pictures/internal/result_view.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace selvedge {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr double kLevels = 65535.0;  // largest 16-bit number

static_assert(std::endian::native == std::endian::little, "the page reads little-endian numbers");

struct FrameBox {
  Vec3 low = Vec3::Zero(), extent = Vec3::Zero();
};

FrameBox box_of(std::span<const Vec3> x) {
  if (x.empty()) return {};
  Vec3 low = x.front(), high = low;
  for (const Vec3& p : x) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return {low, high - low};
}

template <class T>
std::string base64_of(const std::vector<T>& values) {
  return base64(std::as_bytes(std::span(values)));
}

OrderedJson to_json(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

/// Positions as 16-bit numbers in their box, and the box.
OrderedJson positions_json(std::span<const Vec3> x) {
  const FrameBox box = box_of(x);
  std::vector<std::uint16_t> levels;
  levels.reserve(3 * x.size());
  for (const Vec3& p : x)
    for (int axis = 0; axis < 3; ++axis) {
      const double share =
          box.extent[axis] > 0.0 ? (p[axis] - box.low[axis]) / box.extent[axis] : 0.0;
      levels.push_back(static_cast<std::uint16_t>(std::lround(kLevels * share)));
    }
  return {{"low", to_json(box.low)}, {"extent", to_json(box.extent)}, {"x", base64_of(levels)}};
}

OrderedJson surface_json(const ViewSurface& surface) {
  OrderedJson json = positions_json(surface.x);
  json["triangles"] = surface.triangles;
  return json;
}

const char* scale_name(ViewScale scale) {
  switch (scale) {
    case ViewScale::diverging:
      return "diverging";
    case ViewScale::sequential:
      return "sequential";
    case ViewScale::flags:
      return "flags";
    case ViewScale::sides:
      break;
  }
  return "sides";
}

OrderedJson field_json(const ViewField& field) {
  OrderedJson frames = OrderedJson::array();
  for (const auto& bytes : field.frames) frames.push_back(base64_of(bytes));
  return {{"name", field.name}, {"meaning", field.meaning},
          {"unit", field.unit}, {"scale", scale_name(field.scale)},
          {"full", field.full}, {"frames", std::move(frames)}};
}

OrderedJson points_json(const std::array<Vec3, 4>& points) {
  OrderedJson list = OrderedJson::array();
  for (const Vec3& p : points)
    for (int axis = 0; axis < 3; ++axis) list.push_back(p[axis]);
  return list;
}

OrderedJson view_json(const ResultView& view) {
  OrderedJson json = {{"name", view.name},
                      {"fps", view.fps},
                      {"error_m", quantisation_error(view)},
                      {"pieces", view.pieces},
                      {"notes", view.notes}};
  for (const char* list : {"triangles", "bodies", "frames", "fields", "pairs"})
    json[list] = OrderedJson::array();
  for (const auto& triangles : view.triangles) json["triangles"].push_back(base64_of(triangles));
  for (const ViewSurface& bodies : view.bodies) json["bodies"].push_back(surface_json(bodies));
  for (const ViewFrame& frame : view.frames) {
    OrderedJson one = surface_json(frame.cloth);
    one["number"] = frame.number;
    one["time"] = frame.time;
    one["bodies"] = frame.bodies;
    json["frames"].push_back(std::move(one));
  }
  for (const ViewField& field : view.fields) json["fields"].push_back(field_json(field));
  for (const ViewPair& pair : view.pairs)
    json["pairs"].push_back({{"edge_edge", pair.edge_edge},
                             {"toi", pair.toi},
                             {"x0", points_json(pair.x_t0)},
                             {"x1", points_json(pair.x_t1)}});
  return json;
}

}  // namespace

double quantisation_error(const ResultView& view) {
  double largest = 0.0;
  const auto note = [&](const ViewSurface& surface) {
    largest = std::max(largest, box_of(surface.x).extent.norm() / (2.0 * kLevels));
  };
  for (const ViewFrame& frame : view.frames) note(frame.cloth);
  for (const ViewSurface& bodies : view.bodies) note(bodies);
  return largest;
}

std::string view_page(std::span<const ResultView> results) {
  if (results.empty() || results.size() > 2)
    throw std::invalid_argument(
        fmt::format("view_page: a page shows one or two results, not {}", results.size()));
  OrderedJson data = OrderedJson::array();
  std::string title;
  for (const ResultView& view : results) {
    data.push_back(view_json(view));
    title += (title.empty() ? "" : " and ") + view.name;
  }
  const std::string json =
      safe_in_script(data.dump(-1, ' ', false, OrderedJson::error_handler_t::replace));
  title = html_escaped(title);
  const PagePart parts[] = {
      {"%TITLE%", title}, {"%DATA%", json}, {"%SCRIPT%", detail::view_page_script()}};
  return filled_page(detail::view_page_template(), parts);
}

}  // namespace selvedge
