// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/run/detail/run_folder.h>
#include <selvedge/run/result_folder.h>

#include <algorithm>
#include <charconv>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace selvedge::detail {

namespace fs = std::filesystem;

namespace {

/// A run writes all its state into a checkpoint, which has no bound.
constexpr FileRules kJsonRules = {.most_bytes = std::uintmax_t{8} << 30};

}  // namespace

std::optional<Json> read_json(const fs::path& file) {
  Json json = Json::parse(read_if_there(file, kJsonRules), nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded() || !json.is_object()) return std::nullopt;
  return json;
}

namespace {

/// The name without the ending of an AtomicFile that was not committed: ".partial" and the process.
std::string without_partial(std::string name) {
  const auto last = name.find_last_not_of("0123456789");
  const std::string mark = ".partial";
  if (last == std::string::npos || last + 1 < mark.size()) return name;
  const std::string_view begin = std::string_view(name).substr(0, last + 1);
  if (begin.ends_with(mark)) name.erase(begin.size() - mark.size());
  return name;
}

/// The number in the name of a file that a run writes, such as cloth_00042.ply; nullopt for others.
std::optional<std::int64_t> number_of(const fs::path& file, const std::vector<std::string>& stems,
                                      const std::vector<std::string>& extensions) {
  std::string name = without_partial(file.filename().string());
  const auto extension = fs::path(name).extension().string();
  if (std::find(extensions.begin(), extensions.end(), extension) == extensions.end()) return {};
  name.erase(name.size() - extension.size());
  for (const std::string& stem : stems) {
    if (!name.starts_with(stem + "_")) continue;
    const char *begin = name.data() + stem.size() + 1, *end = name.data() + name.size();
    std::int64_t number = 0;
    const auto parsed = std::from_chars(begin, end, number);
    if (parsed.ec == std::errc{} && parsed.ptr == end && begin != end && *begin != '-')
      return number;
  }
  return {};
}

/// Removes the numbered files of a run with numbers above `last`, and nothing else.
void remove_numbered(const fs::path& folder, const std::vector<std::string>& stems,
                     const std::vector<std::string>& extensions, std::int64_t last) {
  std::error_code error;
  std::vector<fs::path> doomed;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (const auto number = number_of(entry.path(), stems, extensions); number && *number > last)
      doomed.push_back(entry.path());
  for (const auto& file : doomed)
    if (!fs::remove(file, error) && error)
      throw std::invalid_argument(fmt::format("{}: a file of an earlier run cannot be removed: {}",
                                              file.string(), error.message()));
}

/// Removes these files of a run, whole or not, and then the folder if nothing else is in it.
void remove_named(const fs::path& folder, const std::vector<std::string>& names) {
  std::error_code ignored;  // a file that cannot be removed fails with its name when it is written
  std::vector<fs::path> doomed;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = without_partial(entry.path().filename().string());
    if (entry.is_regular_file(ignored) &&
        std::find(names.begin(), names.end(), name) != names.end())
      doomed.push_back(entry.path());
  }
  for (const fs::path& file : doomed) fs::remove(file, ignored);
  if (!doomed.empty()) fs::remove(folder, ignored);  // fails if it is not empty
}

}  // namespace

void remove_leftovers(const fs::path& out) {
  std::error_code ignored;
  std::vector<fs::path> doomed;
  for (const fs::path& folder : {out, out / "frames", out / "steps"})
    for (const auto& entry : fs::directory_iterator(folder, ignored))
      if (const std::string name = entry.path().filename().string(); name != without_partial(name))
        doomed.push_back(entry.path());
  for (const fs::path& file : doomed) fs::remove(file, ignored);
}

void remove_beyond(const fs::path& out, const FrameFormatRegistry& formats, std::int64_t frame,
                   std::int64_t step) {
  std::vector<std::string> extensions;
  for (const auto& [name, format] : formats)
    if (const std::string extension = format.traits().extension; !extension.empty())
      extensions.push_back(extension);
  remove_numbered(out / "frames", {"cloth", "bodies"}, extensions, frame);
  remove_numbered(out / "steps", {"cloth", "bodies"}, {".ply"}, step);
  remove_numbered(out / "pictures", {"frame"}, {".png"}, frame);
}

void remove_former_run(const fs::path& out, const FrameFormatRegistry& formats) {
  remove_beyond(out, formats, -1, -1);
  std::vector<std::string> files = {"result.json", "checkpoint.ply", "checkpoint.json"};
  std::error_code ignored;
  for (const auto& [name, format] : formats)
    for (const fs::path file : format.traits().files)
      if (!file.has_parent_path())
        files.push_back(file.string());
      else if (fs::is_regular_file(out / file, ignored))
        fs::remove(out / file, ignored);
  remove_named(out, files);
  remove_leftovers(out);
  remove_named(out / "measures",
               {"measures.json", "strain.csv", "springs.csv", "energy.csv", "rim.csv",
                "spectrum.csv", "strain.png", "shadow.png", "spectrum.png"});
}

bool holds_results(const fs::path& out) {
  std::error_code error;
  for (const char* name : {"result.json", "checkpoint.json"})
    if (fs::exists(out / name, error)) return true;
  return !numbers_of(out / "frames", "cloth").empty();
}

void refuse_results(const fs::path& out) {
  if (holds_results(out))
    throw std::invalid_argument(
        out.string() +
        ": holds the results of an earlier run; continue it with --resume, replace it with "
        "--overwrite (in Python: resume=True, overwrite=True), or name another result folder");
}

namespace {

/// A run removes and writes files in these folders. Through a link it would do so elsewhere.
void refuse_links(const fs::path& out) {
  std::error_code ignored;
  for (const char* part : {"frames", "steps", "pictures", "measures", "failure", "failure/frames",
                           "failure/queries", "failure/meshes"})
    if (fs::is_symlink(fs::symlink_status(out / part, ignored)))
      throw std::invalid_argument(
          (out / part).string() +
          ": is a link, and a run would replace files where it leads; remove the link, or make the "
          "whole result folder a link");
}

}  // namespace

void check_folder(const Scene& scene, const fs::path& folder) {
  const std::string out = folder.string();
  if (out.empty())
    throw std::invalid_argument("the result folder has no name; give one with --out");
  std::error_code error;
  const auto status = fs::status(folder, error);
  if (!fs::exists(status)) return;
  if (!fs::is_directory(status))
    throw std::invalid_argument(out + ": is a file, not a folder; name another result folder");
  refuse_links(folder);
  fs::directory_iterator entry(folder, error);
  if (error) throw std::invalid_argument(out + ": cannot be read: " + error.message());
  // A run that was killed as it started leaves its lock and an unfinished scene.json.
  const auto is_nothing = [](const fs::directory_entry& e) {
    const std::string name = e.path().filename().string();
    return name == FolderLock::kFile ||
           (name != "scene.json" && without_partial(name) == "scene.json");
  };
  if (std::all_of(begin(entry), end(entry), is_nothing)) return;
  const auto former = read_json(folder / "scene.json");
  if (!former)
    throw std::invalid_argument(
        out + ": holds files but no selvedge run; name an empty or a new result folder");
  const auto name = former->find("name");
  if (name == former->end() || !name->is_string())
    throw std::invalid_argument(
        fmt::format("{}: is damaged: name: must be a text in quotes; name an empty or a new result "
                    "folder",
                    (folder / "scene.json").string()));
  if (*name != scene.name)
    throw std::invalid_argument(fmt::format(
        "{}: holds results of the scene \"{}\", this one is \"{}\"; name another result folder or "
        "empty this one",
        out, name->get<std::string>(), scene.name));
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw std::invalid_argument(
        fmt::format("{}: the result folder cannot be made: {}", folder.string(), error.message()));
  if (!can_write_in(folder))
    throw std::invalid_argument(folder.string() +
                                ": the result folder cannot be written; check its permissions");
}

void write_text(const fs::path& file, const std::string& text) {
  AtomicFile out(file);
  out.write(text);
  out.commit();
}

void write_scene(const fs::path& out, const Scene& scene) {
  const std::string text = scene.json.empty() ? Json{{"name", scene.name}}.dump(2) : scene.json;
  write_text(out / "scene.json", text + "\n");
}

namespace {

/// A method with the values of all its options.
template <class Registry>
Json method_json(const Registry& registry, const std::string& name, const MethodOptions& given) {
  Json json = {{"type", name}};
  for (const auto& [key, value] : complete_options(name, registry.at(name).options(), given))
    json[key] = value;
  return json;
}

/// The scene without its length and its output, which may differ in a resumed run. Methods have all
/// their options, however the file gives them.
Json resumable_part(const Scene& scene, const Methods& methods) {
  Json json = Json::parse(scene.json);
  json["time"].erase("frames");
  for (const char* key : {"output", "description", "$schema"}) json.erase(key);
  Json &contact = json["contact"], &solver = json["solver"];
  const ContactSpec& c = scene.contact;
  contact["broad_phase"] = method_json(methods.broad_phases, c.broad_phase, c.broad_phase_options);
  contact["narrow_phase"] =
      method_json(methods.narrow_phases, c.narrow_phase, c.narrow_phase_options);
  contact["response"] = method_json(methods.responses, c.response, c.response_options);
  contact["fail_safe"] = method_json(methods.fail_safes, c.fail_safe, c.fail_safe_options);
  const SolverSpec& s = scene.solver;
  solver["integrator"] = method_json(methods.integrators, s.integrator, s.integrator_options);
  solver["strain_limiter"] = method_json(methods.strain_limiters, s.limiter, s.limiter_options);
  for (std::size_t i = 0; i < scene.cloths.size(); ++i)
    if (const auto* grid = std::get_if<ClothGrid>(&scene.cloths[i].shape))
      json["geometry"][i]["pattern"] =
          method_json(methods.patterns, grid->pattern, grid->pattern_options);
  return json;
}

/// Whether the scene of the result folder moves as `scene`. Also reads the files of older versions.
bool is_resumable(const fs::path& file, const Scene& scene, const Methods& methods) {
  try {
    return resumable_part(read_scene(file, {}, methods), methods) == resumable_part(scene, methods);
  } catch (const std::invalid_argument&) {  // no scene that this program could have run
    return false;
  }
}

}  // namespace

void check_same_scene(const fs::path& out, const Scene& scene, const Methods& methods) {
  if (scene.json.empty())
    throw std::invalid_argument(
        out.string() +
        ": a scene made in code cannot be compared with the scene that was run; only a scene read "
        "from a file can be resumed");
  if (!is_resumable(out / "scene.json", scene, methods))
    throw std::invalid_argument(
        fmt::format("{}: differs from the scene that is to be resumed; only time.frames and output "
                    "may change",
                    (out / "scene.json").string()));
}

}  // namespace selvedge::detail
