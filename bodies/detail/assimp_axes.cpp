// SPDX-License-Identifier: MIT
#include <selvedge/bodies/detail/assimp_axes.h>

#include <assimp/metadata.h>

#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string_view>

namespace selvedge::detail {
namespace {

constexpr int kUpY = 2;

std::string ending_of(const std::string& file) {
  const auto point = file.rfind('.');
  std::string ending = point == std::string::npos ? "" : file.substr(point);
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

/// The <asset> of the document, which is its first element; "" without one.
std::string asset_of(const std::string& file) {
  constexpr std::size_t most = std::size_t{1} << 20;
  std::ifstream in(file, std::ios::binary);
  std::string text(most, '\0');
  in.read(text.data(), static_cast<std::streamsize>(most));
  text.resize(static_cast<std::size_t>(in.gcount()));
  const auto begin = text.find("<asset"), end = text.find("</asset>");
  return begin == std::string::npos || end == std::string::npos || end < begin
             ? ""
             : text.substr(begin, end - begin);
}

/// The text behind `mark`; "" if it is not there.
std::string_view behind(std::string_view text, std::string_view mark) {
  const auto at = text.find(mark);
  return at == std::string_view::npos ? std::string_view() : text.substr(at + mark.size());
}

double collada_unit(std::string_view asset) {
  std::string_view rest = behind(asset, "<unit");
  rest = behind(rest.substr(0, rest.find('>')), "meter");
  const auto quote = rest.find_first_of("\"'");
  if (quote == std::string_view::npos) return 1.0;
  const double unit = std::strtod(std::string(rest.substr(quote + 1)).c_str(), nullptr);
  return unit > 0.0 && std::isfinite(unit) ? unit : 1.0;
}

int collada_up(std::string_view asset) {
  std::string_view word = behind(asset, "<up_axis>");
  word = word.substr(0, word.find('<'));
  if (word.find("X_UP") != std::string_view::npos) return 1;
  return word.find("Z_UP") != std::string_view::npos ? 3 : kUpY;
}

/// The shortest decimal number that gives this float: 2.54, not 2.5399999618530273.
double as_written(float value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return std::strtod(std::string(text, end).c_str(), nullptr);
}

Axes fbx_axes(const aiScene& scene) {
  constexpr double centimetre = 0.01;
  Axes axes;
  if (scene.mMetaData == nullptr) return axes;
  const auto number = [&](const char* key, double otherwise) {
    double wide = 0.0;
    float narrow = 0.0F;
    int32_t whole = 0;
    if (scene.mMetaData->Get(key, wide)) return wide;
    if (scene.mMetaData->Get(key, narrow)) return as_written(narrow);
    if (scene.mMetaData->Get(key, whole)) return static_cast<double>(whole);
    return otherwise;
  };
  const double factor = number("UnitScaleFactor", 0.0), axis = number("UpAxis", -1.0);
  if (factor > 0.0 && std::isfinite(factor)) axes.unit = centimetre * factor;
  if (axis >= 0.0 && axis < 3.0) axes.up = static_cast<int>(axis) + 1;
  if (number("UpAxisSign", 1.0) < 0.0) axes.up = -axes.up;
  return axes;
}

}  // namespace

Axes stated_axes(const aiScene& scene, const std::string& file) {
  const std::string ending = ending_of(file);
  if (ending == ".gltf" || ending == ".glb") return {1.0, kUpY, 1.0};
  if (ending == ".fbx") return fbx_axes(scene);
  if (ending == ".dae") {
    const std::string asset = asset_of(file);
    const double unit = collada_unit(asset);
    return {unit, collada_up(asset), unit};
  }
  return {};
}

void undo_unit(const aiScene& scene, const Axes& axes) {
  if (axes.applied == 1.0) return;
  aiMatrix4x4 scale;
  aiMatrix4x4::Scaling(aiVector3D(static_cast<ai_real>(1.0 / axes.applied)), scale);
  scene.mRootNode->mTransformation = scale * scene.mRootNode->mTransformation;
}

std::vector<double> words_of(const Axes& axes) { return {axes.unit, static_cast<double>(axes.up)}; }

}  // namespace selvedge::detail
