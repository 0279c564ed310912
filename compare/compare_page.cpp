// SPDX-License-Identifier: MIT
#include <selvedge/compare/compare_table.h>
#include <selvedge/core/base/internal/html.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/pictures/picture_files.h>
#include <selvedge/pictures/result_pictures.h>

#include <array>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <utility>

namespace selvedge {

namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

constexpr int kPictureWidth = 200, kPictureHeight = 150;
constexpr double kRoom = 0.04;  // margin around the cloth in a picture, over its size

/// Bounding box of the cloth at its end, with a margin.
std::pair<Vec3, Vec3> end_box(const fs::path& cell) {
  const auto ends = read_ends(cell);
  if (!ends) throw std::invalid_argument("there is no end to draw");
  Vec3 low = ends->end.front(), high = low;
  for (const Vec3& x : ends->end) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const Vec3 room = Vec3::Constant(kRoom * (high - low).norm());
  return {low - room, high + room};
}

/// A thumbnail of the end of a cell, drawn once; "" if there is nothing to draw.
std::string picture_of(const fs::path& cell) {
  const fs::path file = cell / "end.png";
  try {
    if (!fs::exists(file)) {
      CameraChoice choice;
      choice.width = kPictureWidth;
      choice.height = kPictureHeight;
      ResultPictures pictures(cell);
      const std::array<int, 1> shown = {kEndFrame};
      const auto [low, high] = end_box(cell);
      write_png(file,
                pictures.picture(kEndFrame, framed(pictures.camera(choice, shown), low, high)));
    }
  } catch (const std::invalid_argument&) {  // no end frame, or one that is not finite
    return {};
  }
  const std::string bytes = read_if_there(file);
  return bytes.empty() ? "" : "data:image/png;base64," + base64(std::as_bytes(std::span(bytes)));
}

}  // namespace

std::string compare_page(const fs::path& out, const CompareTable& table, const PageConfig& config) {
  OrderedJson data = OrderedJson::parse(to_json_text(table));
  int pictures = 0;
  for (OrderedJson& row : data["rows"]) {
    const fs::path view = fs::path("cells") / row["id"].get<std::string>() / "view.html";
    if (fs::exists(out / view)) row["view"] = view.string();
    if (!config.pictures || pictures >= config.most_pictures || row["status"] != "ok") continue;
    const std::string picture = picture_of(cell_folder(out, row["id"].get<std::string>()));
    if (picture.empty()) continue;
    row["picture"] = picture;
    ++pictures;
  }
  const std::string title = html_escaped(table.plan.name);
  const std::string json =
      safe_in_script(data.dump(-1, ' ', false, OrderedJson::error_handler_t::replace));
  const PagePart parts[] = {{"%TITLE%", title}, {"%DATA%", json}};
  return filled_page(compare_page_template(), parts);
}

}  // namespace selvedge
