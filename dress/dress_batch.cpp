// SPDX-License-Identifier: MIT
//
// Many garments, one after the other: list, resumption, and the page of the results.
#include <fmt/format.h>
#include <selvedge/core/base/internal/html.h>
#include <selvedge/core/base/internal/json_value.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/dress/detail/page_style.h>
#include <selvedge/dress/internal/dress_batch.h>
#include <selvedge/garment/sewing_pattern.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <system_error>

namespace selvedge {
namespace {

namespace fs = std::filesystem;

constexpr const char* kInputsFile = "inputs.txt";  // in the folder of a garment that has ended

// ---- the list --------------------------------------------------------------------------------

std::string trimmed(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

std::vector<DressJob> jobs_of_folder(const fs::path& folder, const fs::path& body) {
  std::vector<DressJob> jobs;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".json")
      jobs.push_back({entry.path().stem().string(), entry.path(), body});
  std::sort(jobs.begin(), jobs.end(),
            [](const DressJob& a, const DressJob& b) { return a.name < b.name; });
  return jobs;
}

std::vector<DressJob> jobs_of_file(const fs::path& list, const fs::path& body) {
  std::istringstream in(read_whole_file(list, {.what = "list of patterns", .pipes = true}));
  std::vector<DressJob> jobs;
  std::string line;
  while (std::getline(in, line)) {
    line = trimmed(line);
    if (line.empty() || line.front() == '#') continue;
    const auto comma = line.find(',');
    const fs::path pattern = trimmed(line.substr(0, comma));
    const std::string own = comma == std::string::npos ? "" : trimmed(line.substr(comma + 1));
    jobs.push_back({pattern.stem().string(), list.parent_path() / pattern,
                    own.empty() ? body : list.parent_path() / own});
  }
  return jobs;
}

void check_jobs(const std::vector<DressJob>& jobs, const fs::path& list) {
  if (jobs.empty())
    throw std::invalid_argument(list.string() +
                                ": names no garment; give a folder with patterns (*.json), or a "
                                "file with PATTERN or PATTERN,BODY in each line");
  std::map<std::string, fs::path> known;
  for (const DressJob& job : jobs) {
    if (job.name.empty() || job.name == "." || job.name == "..")
      throw std::invalid_argument(
          fmt::format("{}: \"{}\" is not a pattern", list.string(), job.pattern.string()));
    if (job.body.empty())
      throw std::invalid_argument(
          fmt::format("{}: there is no body for {}; name it behind the pattern, after a comma, or "
                      "behind --list",
                      list.string(), job.pattern.string()));
    const auto [former, is_new] = known.try_emplace(job.name, job.pattern);
    if (!is_new)
      throw std::invalid_argument(fmt::format(
          "{}: {} and {} would both be written to the folder {}; rename one of the files",
          list.string(), former->second.string(), job.pattern.string(), job.name));
  }
}

// ---- resumption ------------------------------------------------------------------------------

std::string bytes_of(const fs::path& file) {
  return read_if_there(file, {.most_bytes = std::uintmax_t{8} << 30});
}

std::string inputs_of(const DressJob& job, const DressBatchConfig& config) {
  return fmt::format("pattern {}\nbody {}\n{}\n", file_hash(job.pattern), file_hash(job.body),
                     config.settings);
}

void write_text(const fs::path& file, const std::string& text) {
  AtomicFile out(file);
  out.write(text);
  out.commit();
}

bool row_from(const JsonValue<nlohmann::json>& json, DressBatchRow& row) {
  const std::string state = json.text_or("dress", "");
  if (state != "finished" && state != "failed") return false;
  row.good = json.flag_or("good", false);
  row.worn = json.flag_or("worn", row.good);
  row.verdict = json.text_or("verdict", "");
  row.panels = json.has("panels") ? json["panels"].json().size() : 0;
  row.vertices = json.has("vertices") ? json["vertices"].whole<std::size_t>() : 0;
  row.states = json.has("states_judged") ? json["states_judged"].whole<std::size_t>() : 0;
  row.opening = json.number_or("largest_opening_m", 0.0);
  row.stretch = json.number_or("max_stretch", 0.0);
  if (json.has("seconds"))
    for (const char* phase : {"start", "sew", "close", "draw", "settle", "skin", "refine", "move"})
      row.seconds += json["seconds"].number_or(phase, 0.0);
  return true;
}

/// Reads the row of a garment from its folder; false if it has not ended.
bool read_row(const fs::path& folder, DressBatchRow& row) {
  const auto json = nlohmann::json::parse(bytes_of(folder / "result.json"), nullptr, false);
  if (!json.is_object()) return false;
  try {
    return row_from(JsonValue(json), row);
  } catch (const JsonFault&) {  // damaged or of another version; the garment is made again
    return false;
  }
}

// ---- one garment -----------------------------------------------------------------------------

void make_garment(const DressJob& job, const DressBatchConfig& config, const Methods& methods) {
  const SewingPattern pattern = read_sewing_pattern(job.pattern, config.dress.limits);
  const BodyMesh body = config.read_body(job.body);
  DressFolderConfig folder = config.folder;
  folder.out = config.out / job.name;
  folder.body_name = job.body.string();
  const UpAxis up = config.folder.body_file.up.value_or(UpAxis::y);
  folder.body_file = {.unit = body.axes.unit, .up = body.axes.up};
  dress_into_folder(turned_upright(pattern, up), body.mesh, config.dress, folder, methods);
}

constexpr const char* kViewFile = "view.html";

void add_view(const fs::path& folder, const DressBatchConfig& config, DressBatchRow& row) {
  std::error_code ignored;
  const bool has_one = fs::exists(folder / kViewFile, ignored);
  const bool has_frames = fs::exists(folder / "frames", ignored);
  if (config.write_view && has_frames && !(row.kept && has_one)) config.write_view(folder);
  row.view = fs::exists(folder / kViewFile, ignored);
}

DressBatchRow row_of(const DressJob& job, const DressBatchConfig& config, const Methods& methods) {
  const fs::path folder = config.out / job.name;
  const std::string inputs = inputs_of(job, config);
  DressBatchRow row;
  row.job = job;
  if (bytes_of(folder / kInputsFile) == inputs && read_row(folder, row)) {
    row.kept = true;
    add_view(folder, config, row);
    return row;
  }
  try {
    make_garment(job, config, methods);
  } catch (const DressFailed&) {  // result.json gives the reason
  } catch (const std::invalid_argument& fault) {
    row.verdict = fault.what();
    return row;
  }
  if (read_row(folder, row)) {
    write_text(folder / kInputsFile, inputs);
    add_view(folder, config, row);
  }
  return row;
}

// ---- the page --------------------------------------------------------------------------------

constexpr const char* kPage = R"(<!doctype html>
<!-- SPDX-License-Identifier: MIT -->
<html lang="en">
<head>
%STYLE%<title>Garments on bodies</title>
<style>
.all { display: grid; grid-template-columns: repeat(auto-fill, minmax(15rem, 1fr)); gap: 1rem; }
article { border: 1px solid var(--line); border-radius: .5rem; padding: .6rem; overflow-wrap: anywhere; }
h2 { font-size: 1.05rem; margin: 0 0 .3rem; }
p { margin: .2rem 0; font-size: .9rem; }
img { width: 49%; height: auto; border-radius: .3rem; }
.good { color: var(--good); font-weight: 600; }
.bad { color: var(--bad); font-weight: 600; }
</style>
</head>
<body>
<h1>Garments on bodies</h1>
<p>%SUMMARY%</p>
<div class="all">
%ROWS%</div>
</body>
</html>
)";

std::string url_of(const std::string& name) {
  std::string url;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = (byte >= '0' && byte <= '9') || (byte >= 'A' && byte <= 'Z') ||
                       (byte >= 'a' && byte <= 'z') || byte == '-' || byte == '_' || byte == '.';
    url += plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return url;
}

std::string article(const DressBatchRow& row) {
  const std::string url = url_of(row.job.name), name = html_escaped(row.job.name);
  std::string text = fmt::format("<article>\n<h2>{}</h2>\n", name);
  if (row.vertices > 0) {
    for (const char* side : {"front", "back"})
      text += fmt::format(
          "<a href=\"{0}/pictures/{1}.png\"><img loading=\"lazy\" src=\"{0}/pictures/{1}.png\" "
          "alt=\"{2}, {1}\"></a>\n",
          url, side, name);
    text += fmt::format(
        "<p class=\"soft\">{}, {}, {:.1f} s, {} judged; largest opening "
        "{:.2f} mm; largest stretch {:.1f} %</p>\n",
        counted(row.panels, "panel"), counted(row.vertices, "vertex", "vertices"), row.seconds,
        counted(row.states, "state"), 1e3 * row.opening, 1e2 * row.stretch);
  }
  text +=
      fmt::format("<p class=\"{}\">{}</p>\n", row.worn ? "good" : "bad", html_escaped(row.verdict));
  std::string links;
  if (row.view) links += fmt::format("<a href=\"{}/{}\">in 3D</a> ", url, kViewFile);
  if (row.vertices > 0) links += fmt::format("<a href=\"{}/result.json\">result</a>", url);
  if (!links.empty()) text += "<p>" + links + "</p>\n";
  return text + "</article>\n";
}

void prepare(const fs::path& out) {
  std::error_code error;
  if (out.empty()) throw std::invalid_argument("dress: the batch needs a folder; give --out");
  fs::create_directories(out, error);
  if (error || !fs::is_directory(out, error))
    throw std::invalid_argument(out.string() + ": is not a folder and cannot be made one");
}

}  // namespace

std::string file_hash(const fs::path& file) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : bytes_of(file))
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return fmt::format("{:016x}", hash);
}

std::vector<DressJob> read_dress_list(const fs::path& list, const fs::path& body) {
  std::error_code ignored;
  std::vector<DressJob> jobs =
      fs::is_directory(list, ignored) ? jobs_of_folder(list, body) : jobs_of_file(list, body);
  check_jobs(jobs, list);
  return jobs;
}

std::string dress_page(const std::vector<DressBatchRow>& rows, std::size_t open) {
  const auto good =
      std::count_if(rows.begin(), rows.end(), [](const DressBatchRow& row) { return row.good; });
  const auto worn =
      std::count_if(rows.begin(), rows.end(), [](const DressBatchRow& row) { return row.worn; });
  std::string summary = fmt::format("Good: {} of {}, worn: {}", good, rows.size(), worn);
  summary += open > 0 ? fmt::format("; {} are still to come.", open) : ".";
  std::string articles;
  for (const DressBatchRow& row : rows) articles += article(row);
  const PagePart parts[] = {
      {"%STYLE%", detail::kPageStyle}, {"%SUMMARY%", summary}, {"%ROWS%", articles}};
  return filled_page(kPage, parts);
}

DressBatchRow dress_one_of(const std::vector<DressJob>& jobs, const std::string& name,
                           const DressBatchConfig& config, const Methods& methods) {
  const auto job =
      std::find_if(jobs.begin(), jobs.end(), [&](const DressJob& j) { return j.name == name; });
  if (job == jobs.end())
    throw std::invalid_argument(
        fmt::format("the list has no garment \"{}\"; a garment is named after its pattern's file, "
                    "without .json",
                    name));
  prepare(config.out);
  return row_of(*job, config, methods);
}

std::vector<DressBatchRow> dress_batch(const std::vector<DressJob>& jobs,
                                       const DressBatchConfig& config, const Methods& methods,
                                       const std::function<void(const DressBatchRow&)>& done) {
  prepare(config.out);
  const FolderLock lock(config.out, "dress --list");
  std::vector<DressBatchRow> rows;
  for (const DressJob& job : jobs) {
    rows.push_back(row_of(job, config, methods));
    write_text(config.out / "index.html", dress_page(rows, jobs.size() - rows.size()));
    if (done) done(rows.back());
  }
  return rows;
}

}  // namespace selvedge
