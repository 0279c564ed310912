// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/detail/numbered_files.h>
#include <selvedge/apps/result_states.h>
#include <selvedge/scene/output.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

[[noreturn]] void refuse(const fs::path& file, const std::string& fault) {
  throw std::invalid_argument(file.string() + ": " + fault);
}

/// One numbered series of a result: frames or steps.
struct Series {
  fs::path folder;
  int digits;
  std::vector<int> cloths, bodies;

  Series(fs::path series_folder, int series_digits)
      : folder(std::move(series_folder)),
        digits(series_digits),
        cloths(numbers_of(folder, "cloth")),
        bodies(numbers_of(folder, "bodies")) {}

  fs::path file(const char* stem, int number) const {
    return numbered(folder, stem, number, digits, ".ply");
  }
};

/// null where there is no such file or it is no JSON: a result is judged without them.
Json read_json(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  Json json = in ? Json::parse(in, nullptr, /*allow_exceptions=*/false, true) : Json();
  return json.is_object() ? json : Json();
}

/// A run counts from 0 and leaves nothing out.
void check_complete(const Series& series, const char* stem, const std::vector<int>& numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (numbers[i] != static_cast<int>(i))
      refuse(series.file(stem, static_cast<int>(i)),
             fmt::format("is missing, though {} is there; run the scene again, or check the files "
                         "that are there as MESH files",
                         series.file(stem, numbers[i]).filename().string()));
}

/// A run resumed without --every-step leaves fewer states than it accepted.
void check_all_steps(const fs::path& result, const Series& steps) {
  const Json json = read_json(result / "result.json");
  const auto count = json.find("steps");
  if (count == json.end() || !count->is_number_integer()) return;
  const auto states = count->get<long>() + 1;
  if (states > static_cast<long>(steps.cloths.size()))
    refuse(steps.folder,
           fmt::format("holds {} of the {} states of the run; run the scene again with "
                       "--every-step, or remove the folder to judge the frames alone",
                       steps.cloths.size(), states));
}

/// Bodies that rest are written once, with the first frame and step; others with each.
std::vector<fs::path> bodies_of(const fs::path& result, const Series& series,
                                const Series& frames) {
  const std::size_t n = series.cloths.size();
  const Series& source = series.bodies.empty() && frames.bodies.size() == 1 ? frames : series;
  if (source.bodies.empty()) {
    const Json scene = read_json(result / "scene.json");
    const auto obstacles = scene.find("obstacles");
    if (!frames.bodies.empty() || (obstacles != scene.end() && !obstacles->empty()))
      refuse(series.file("bodies", 0), "is missing, though the scene has obstacles");
    return std::vector<fs::path>(n);
  }
  if (source.bodies.size() == 1)
    return std::vector<fs::path>(n, source.file("bodies", source.bodies.front()));
  check_complete(source, "bodies", source.bodies);
  if (source.bodies.size() < n)
    refuse(source.file("bodies", static_cast<int>(source.bodies.size())),
           "is missing, though the bodies move; run the scene again");
  std::vector<fs::path> files;
  for (const int number : source.cloths) files.push_back(source.file("bodies", number));
  return files;
}

}  // namespace

ResultStates result_states(const fs::path& folder) {
  const Series frames(folder / "frames", frame_file_digits);
  const Series steps(folder / "steps", step_file_digits);
  ResultStates result;
  result.every_step = !steps.cloths.empty();
  const Series& series = result.every_step ? steps : frames;
  if (series.cloths.empty())
    refuse(folder, "holds no frames/cloth_*.ply; give a mesh file or the result folder of a run");
  check_complete(series, "cloth", series.cloths);
  if (result.every_step) check_all_steps(folder, steps);
  const std::vector<fs::path> bodies = bodies_of(folder, series, frames);
  for (std::size_t i = 0; i < series.cloths.size(); ++i)
    result.states.push_back({series.file("cloth", series.cloths[i]), bodies[i]});
  return result;
}

}  // namespace selvedge
