// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/run/detail/run_folder.h>
#include <selvedge/run/result_folder.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using detail::Json;

std::optional<int> number_in(const std::string& name, const std::string& begin,
                             const std::string& end) {
  if (name.size() <= begin.size() + end.size() || !name.starts_with(begin) || !name.ends_with(end))
    return std::nullopt;
  const char* first = name.data() + begin.size();
  const char* stop = name.data() + name.size() - end.size();
  int number = 0;
  const auto [ptr, fault] = std::from_chars(first, stop, number);
  if (fault != std::errc() || ptr != stop || number < 0) return std::nullopt;
  return number;
}

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

/// null without a readable JSON object: a result can be checked without it.
Json json_or_null(const fs::path& file) { return detail::read_json(file).value_or(Json()); }

/// Refuses a series with a gap: a run numbers its files from 0.
void check_complete(const Series& series, const char* stem, const std::vector<int>& numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (numbers[i] != static_cast<int>(i))
      refuse(series.file(stem, static_cast<int>(i)),
             fmt::format("is missing, though {} exists; run the scene again, or check the existing "
                         "files as MESH files",
                         series.file(stem, numbers[i]).filename().string()));
}

/// A number of result.json; 0 if the run has left none.
long counted(const fs::path& result, const char* key) {
  const Json json = json_or_null(result / "result.json");
  const auto count = json.find(key);
  return count != json.end() && count->is_number_integer() ? count->get<long>() : 0;
}

/// Refuses steps/ with fewer states than the run accepted, as a run that was resumed without
/// --every-step leaves it.
void check_all_steps(const fs::path& result, const Series& steps) {
  const long states = counted(result, "steps") + 1;
  if (states > static_cast<long>(steps.cloths.size()))
    refuse(steps.folder,
           fmt::format("holds {} of the {} states of the run; run the scene again with "
                       "--every-step, or remove the folder to check only the frames",
                       steps.cloths.size(), states));
}

void check_all_frames(const fs::path& result, const Series& frames) {
  const long count = counted(result, "frames");
  if (count > static_cast<long>(frames.cloths.size()))
    refuse(frames.folder,
           fmt::format("holds {} of the {} frames of the run; run the scene again, or check the "
                       "existing files as MESH files",
                       frames.cloths.size(), count));
}

/// Whether a scene has a body with files of its own: one with a mass is written with the cloth.
bool has_body_files(const Json& scene) {
  const auto obstacles = scene.find("obstacles");
  if (obstacles == scene.end()) return false;
  return std::any_of(obstacles->begin(), obstacles->end(), [](const Json& body) {
    const auto mass = body.is_object() ? body.find("mass") : body.end();
    return mass == body.end() || !mass->is_number() || !(mass->get<double>() > 0.0);
  });
}

/// The body file of each state. Bodies at rest have one file, of the first frame and step.
std::vector<fs::path> bodies_of(const fs::path& result, const Series& series,
                                const Series& frames) {
  const std::size_t n = series.cloths.size();
  const Series& source = series.bodies.empty() && frames.bodies.size() == 1 ? frames : series;
  if (source.bodies.empty()) {
    if (!frames.bodies.empty() || has_body_files(json_or_null(result / "scene.json")))
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

fs::path numbered(const fs::path& folder, const std::string& stem, int number, int digits,
                  const std::string& extension) {
  return folder / fmt::format("{}_{:0{}}{}", stem, number, std::max(digits, 1), extension);
}

std::vector<int> numbers_of(const fs::path& folder, const std::string& stem) {
  std::vector<int> numbers;
  std::error_code error;
  if (!fs::exists(folder, error) && !error) return numbers;
  for (fs::directory_iterator it(folder, error), last; !error && it != last; it.increment(error))
    if (const auto number = number_in(it->path().filename().string(), stem + "_", ".ply"))
      numbers.push_back(*number);
  if (error) throw std::invalid_argument(folder.string() + ": cannot be read: " + error.message());
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

ResultStates result_states(const fs::path& folder) {
  const Series frames(folder / "frames", kFrameFileDigits);
  const Series steps(folder / "steps", kStepFileDigits);
  ResultStates result;
  result.every_step = !steps.cloths.empty();
  const Series& series = result.every_step ? steps : frames;
  if (series.cloths.empty())
    refuse(folder, "holds no frames/cloth_*.ply; give a mesh file or the result folder of a run");
  check_complete(series, "cloth", series.cloths);
  if (result.every_step)
    check_all_steps(folder, steps);
  else
    check_all_frames(folder, frames);
  const std::vector<fs::path> bodies = bodies_of(folder, series, frames);
  for (std::size_t i = 0; i < series.cloths.size(); ++i)
    result.states.push_back({series.file("cloth", series.cloths[i]), bodies[i]});
  return result;
}

}  // namespace selvedge
