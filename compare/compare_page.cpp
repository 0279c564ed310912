// SPDX-License-Identifier: MIT
#include <selvedge/compare/compare_table.h>
#include <selvedge/run/result_pictures.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace selvedge {

namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

constexpr int kPictureWidth = 200, kPictureHeight = 150;
constexpr double kRoom = 0.04;  // margin around the cloth in a picture, over its size

std::string base64(const std::string& bytes) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : digits[three >> (18 - 6 * k) & 63u];
  }
  return text;
}

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
  std::ifstream in(file, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  return bytes.empty() ? "" : "data:image/png;base64," + base64(bytes);
}

/// "</" would close a script element.
std::string safe_in_script(const std::string& json) {
  std::string text;
  for (std::size_t i = 0; i < json.size(); ++i) {
    text += json[i];
    if (json[i] == '<') {
      text.pop_back();
      text += "\\u003c";
    }
  }
  return text;
}

void replace(std::string& text, const std::string& mark, const std::string& with) {
  const auto at = text.find(mark);
  if (at != std::string::npos) text.replace(at, mark.size(), with);
}

std::string html_escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text)
    escaped += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
  return escaped;
}

}  // namespace

std::string compare_page(const fs::path& out, const CompareTable& table, const PageConfig& config) {
  OrderedJson data = OrderedJson::parse(to_json_text(table));
  int pictures = 0;
  for (OrderedJson& row : data["rows"]) {
    if (!config.pictures || pictures >= config.most_pictures || row["status"] != "ok") continue;
    const std::string picture = picture_of(cell_folder(out, row["id"].get<std::string>()));
    if (picture.empty()) continue;
    row["picture"] = picture;
    ++pictures;
  }
  std::string page = compare_page_template();
  for (int times = 0; times < 2; ++times)  // once for the window title, once for the headline
    replace(page, "%TITLE%", html_escaped(table.plan.name));
  replace(page, "%DATA%",
          safe_in_script(data.dump(-1, ' ', false, OrderedJson::error_handler_t::replace)));
  return page;
}

}  // namespace selvedge
