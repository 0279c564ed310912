// SPDX-License-Identifier: MIT
// Guards what no compiler guards: the arrows between the rooms, what public headers may name, the
// licence line, and a README that says what is. Each rule is a function of a file's text, so that
// each is also shown a bad sample and must find its fault.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Sentences = std::vector<std::string>;

fs::path root() { return SELVEDGE_SOURCE_DIR; }

std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<std::string> split(const std::string& text, char mark) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, mark);) parts.push_back(part);
  return parts;
}

std::vector<std::string> lines_of(const std::string& text) { return split(text, '\n'); }

bool starts_with(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

using Arrows = std::map<std::string, std::set<std::string>>;

/// A line of cmake/rooms.txt.
struct Room {
  std::string name, part, bits, may_include, content;

  bool is_library() const {
    return part == "detectors" || part == "simulation" || part == "program";
  }
};

std::vector<std::string> words(const std::string& text) {
  std::istringstream in(text);
  return {std::istream_iterator<std::string>(in), {}};
}

Room read_room(const std::string& line) {
  std::vector<std::string> cells = split(line, '|');
  cells.resize(5);
  const auto trimmed = [](const std::string& cell) {
    const std::size_t first = cell.find_first_not_of(' ');
    if (first == std::string::npos) return std::string();
    return cell.substr(first, cell.find_last_not_of(' ') + 1 - first);
  };
  return {.name = trimmed(cells[0]),
          .part = trimmed(cells[1]),
          .bits = trimmed(cells[2]),
          .may_include = trimmed(cells[3]),
          .content = trimmed(cells[4])};
}

std::vector<Room> read_rooms() {
  std::vector<Room> rooms;
  for (const std::string& line : lines_of(read(root() / "cmake/rooms.txt")))
    if (!line.empty() && line[0] != '#') rooms.push_back(read_room(line));
  return rooms;
}

const std::vector<Room> kRooms = read_rooms();

std::set<std::string> names_of_rooms(bool (*wanted)(const Room&)) {
  std::set<std::string> names;
  for (const Room& room : kRooms)
    if (wanted(room)) names.insert(room.name);
  return names;
}

/// The libraries that determine states, which must have the same bits with every C library.
const std::set<std::string> kSameBits =
    names_of_rooms([](const Room& room) { return room.bits == "same"; });

/// The rooms, and what each may include; of those that are no libraries, beside all libraries.
Arrows arrows_of(bool (*wanted)(const Room&)) {
  Arrows arrows;
  for (const Room& room : kRooms)
    if (wanted(room))
      for (std::set<std::string>& to = arrows[room.name];
           const std::string& word : words(room.may_include))
        if (word != "libraries") to.insert(word);
  return arrows;
}

const Arrows& rooms() {
  static const Arrows listed = arrows_of([](const Room& room) { return room.is_library(); });
  return listed;
}

/// Folders that use the rooms.
const Arrows kUsers = arrows_of([](const Room& room) { return !room.is_library(); });

bool is_within(const std::string& file, const std::string& folder) {
  return starts_with(file, folder + "/") || file == folder;
}

/// The room or user that a file belongs to: `core` of `core/base/types.h`. One may lie in another.
std::string room_of(std::string path) {
  if (starts_with(path, "selvedge/")) path.erase(0, 9);
  std::string longest;
  for (const Arrows* list : {&rooms(), &kUsers})
    for (const auto& [room, arrows] : *list)
      if (is_within(path, room) && room.size() > longest.size()) longest = room;
  return longest.empty() ? path.substr(0, path.find('/')) : longest;
}

/// An arrow to a folder is one to every room in it.
bool may_include(const std::string& from, const std::string& to) {
  const auto has = [&](const std::set<std::string>& list) {
    return std::any_of(list.begin(), list.end(),
                       [&](const std::string& folder) { return is_within(to, folder); });
  };
  const auto user = kUsers.find(from);
  return from == to ||
         (user == kUsers.end() ? has(rooms().at(from)) : rooms().contains(to) || has(user->second));
}

struct Include {
  std::string name;  // between the brackets or quotes
  bool quoted;
};

std::vector<Include> includes_of(const std::string& text) {
  std::vector<Include> found;
  for (const std::string& line : lines_of(text)) {
    const std::size_t hash = line.find_first_not_of(" \t");
    if (hash == std::string::npos || line[hash] != '#') continue;
    const std::size_t word = line.find_first_not_of(" \t", hash + 1);
    if (word == std::string::npos || line.compare(word, 7, "include") != 0) continue;
    const std::size_t open = line.find_first_of("<\"", word);
    if (open == std::string::npos) continue;
    const std::size_t close = line.find(line[open] == '<' ? '>' : '"', open + 1);
    found.push_back({line.substr(open + 1, close - open - 1), line[open] == '"'});
  }
  return found;
}

/// "core" of "core/base/types.h" or "selvedge/core/base/types.h".
std::string folder_of(std::string path) {
  if (starts_with(path, "selvedge/")) path.erase(0, 9);
  return path.substr(0, path.find('/'));
}

/// A quoted name without a folder stays in its folder, but what is installed has to name its own.
bool is_bad_quote(const std::string& from, const Include& include) {
  const bool leaves = include.name.find('/') != std::string::npos;
  return include.quoted && (leaves || rooms().contains(from));
}

/// Not installed: detail/ is private to its top-level folder, internal/ to the repository.
bool is_private(const Include& include) {
  return include.name.find("/detail/") != std::string::npos ||
         include.name.find("/internal/") != std::string::npos;
}

/// Tests may look at what is private. Examples are programs of users.
bool is_private_elsewhere(const std::string& from, const Include& include) {
  if (include.quoted || !is_private(include)) return false;
  if (from == "examples") return true;
  return from != "tests" && folder_of(include.name) != folder_of(from) &&
         include.name.find("/detail/") != std::string::npos;
}

/// `file` is relative to the root.
Sentences forbidden_arrows(const std::string& file, const std::string& text) {
  Sentences faults;
  const std::string from = room_of(file);
  for (const Include& include : includes_of(text)) {
    const std::string to = room_of(include.name);
    const bool ours = starts_with(include.name, "selvedge/") && !include.quoted;
    if (is_bad_quote(from, include)) {
      faults.push_back(file + " includes \"" + include.name + "\": write <selvedge/room/file.h>");
    } else if (ours && !may_include(from, to)) {
      faults.push_back(file + " includes <" + include.name + ">: " + from + " may not name " + to);
    } else if (ours && to == "apps" && from != "apps" &&
               include.name != "selvedge/apps/command_line.h" &&
               include.name != "selvedge/apps/version.h") {
      faults.push_back(file + " includes <" + include.name +
                       ">: only apps/command_line.h and apps/version.h are shared");
    } else if (ours && is_private_elsewhere(from, include)) {
      faults.push_back(file + " includes <" + include.name + ">, which is private to " + to);
    }
  }
  return faults;
}

/// Functions whose last bits IEEE 754 leaves to the C library: core/base/internal/elementary.h has
/// their like.
Sentences platform_functions(const std::string& file, const std::string& text) {
  Sentences faults;
  static const std::regex call(
      "std::(a?(sin|cos|tan)h?|atan2|exp|exp2|expm1|log|log2|log10|log1p|pow|cbrt|hypot|[lt]gamma|"
      "erfc?)\\(|AngleAxis|\\bslerp\\(|[._]distribution");
  for (const std::string& line : lines_of(text)) {
    const std::string code = line.substr(0, line.find("//"));
    std::smatch found;
    if (std::regex_search(code, found, call))
      faults.push_back(file + " uses " + found.str() + ", which has other bits elsewhere");
  }
  return faults;
}

/// Standard headers have neither a folder nor an ending.
bool is_standard(const std::string& include) {
  return include.find_first_of("./") == std::string::npos;
}

Sentences foreign_includes(const std::string& header, const std::string& text) {
  Sentences faults;
  for (const Include& include : includes_of(text)) {
    const bool allowed = is_standard(include.name) || starts_with(include.name, "Eigen/") ||
                         starts_with(include.name, "selvedge/");
    if (!allowed) {
      faults.push_back(header + " is public and names <" + include.name + ">");
    } else if (is_private(include)) {
      faults.push_back(header + " is public and names the private <" + include.name + ">");
    }
  }
  return faults;
}

/// The sources that may include headers of an operating system.
bool is_of_system(const std::string& file) { return is_within(file, "core/system"); }

Sentences system_includes(const std::string& file, const std::string& text) {
  static const std::regex header(
      "sys/.*|(dlfcn|execinfo|fcntl|link|malloc|poll|pthread|sched|signal|spawn|termios|unistd|"
      "windows)\\.h|csignal|cerrno");
  Sentences faults;
  for (const Include& include : includes_of(text))
    if (std::regex_match(include.name, header))
      faults.push_back(file + " includes <" + include.name + ">: only the system's sources may");
  return faults;
}

/// Names of functions: those that a line without indentation defines, or all that are called or
/// declared.
std::set<std::string> functions(const std::string& text, bool defined_only) {
  static const std::regex name("(~?\\w+)\\(");
  std::set<std::string> names;
  for (const std::string& line : lines_of(text)) {
    if (defined_only && (line.empty() || !std::isalpha(static_cast<unsigned char>(line[0]))))
      continue;
    const std::string code = line.substr(0, line.find("//"));
    for (std::sregex_iterator at(code.begin(), code.end(), name), end; at != end; ++at) {
      names.insert((*at)[1]);
      if (defined_only) break;
    }
  }
  return names;
}

/// Functions of the headers that the sources of one system define and those of the other do not.
Sentences one_sided(const std::string& headers, const std::string& one, const std::string& other) {
  const std::set<std::string> here = functions(one, true), there = functions(other, true);
  Sentences faults;
  for (const std::string& name : functions(headers, false))
    if (here.contains(name) != there.contains(name)) faults.push_back(name);
  return faults;
}

/// Names of C++20 that neither the standard library of Emscripten has nor this text supplies.
Sentences missing_in_browsers(const std::string& file, const std::string& text,
                              const std::string& supplied) {
  static const std::regex name(
      "std::(ranges::\\w+|(?:views|pmr|execution)::|(?:format|jthread|stop_token|atomic_ref|"
      "source_location|osyncstream|assume_aligned|make_\\w+_for_overwrite)\\b)");
  Sentences faults;
  for (std::sregex_iterator at(text.begin(), text.end(), name), end; at != end; ++at) {
    const std::string found = (*at)[1];
    if (supplied.find(" " + found.substr(found.rfind(':') + 1) + "(") == std::string::npos)
      faults.push_back(file + " uses std::" + found +
                       ", which bindings/js/missing_std.h must supply");
  }
  return faults;
}

/// In the first line, or the second one after #!.
Sentences missing_licence(const std::string& file, const std::string& text) {
  const std::vector<std::string> lines = lines_of(text);
  const std::size_t at = !lines.empty() && starts_with(lines[0], "#!") ? 1 : 0;
  const bool there =
      lines.size() > at && lines[at].find("SPDX-License-Identifier: MIT") != std::string::npos;
  return there ? Sentences{} : Sentences{file + " does not begin with its SPDX line"};
}

bool is_path_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '/' || c == '.' ||
         c == '-';
}

/// Every script, data file, document or source that a text names must be there.
Sentences missing_files(const std::string& document, const std::string& text,
                        const fs::path& folder) {
  Sentences faults;
  std::set<std::string> starts = {"scripts/", "data/scenes/", "data/schema", "docs/", ".ci/"};
  for (const Arrows* list : {&rooms(), &kUsers})
    for (const auto& [room, arrows] : *list)
      if (room != "pictures") starts.insert(room + "/");  // of a result
  for (const std::string& start : starts) {
    for (std::size_t at = text.find(start); at != std::string::npos;
         at = text.find(start, at + 1)) {
      if (at > 0 && is_path_character(text[at - 1])) continue;     // the end of a longer path
      if (at > 1 && text.compare(at - 2, 2, "](") == 0) continue;  // a link: pages_test.cpp
      std::size_t end = at;
      while (end < text.size() && is_path_character(text[end])) ++end;
      if (end < text.size() && text[end] == '*') continue;  // stands for several files
      std::string name = text.substr(at, end - at);
      while (name.back() == '.') name.pop_back();
      if (!fs::exists(folder / name))
        faults.push_back(document + " names " + name + ", which is not there");
    }
  }
  return faults;
}

/// The text between the lines ```language and ``` that follow `marker`.
std::string code_block(const std::string& text, const std::string& marker) {
  const std::size_t at = text.find(marker);
  if (at == std::string::npos) return "";
  const std::size_t open = text.find("```", at);
  const std::size_t begin = text.find('\n', open) + 1;
  return text.substr(begin, text.find("```", begin) - begin);
}

/// The start of the row of docs/architecture.md that describes a library.
std::string row_of(const Room& room) {
  std::string row = "| `" + room.name + "` | " + room.content + " | ", comma;
  for (const std::string& word : words(room.may_include)) {
    row += comma + "`" + word + "`";
    comma = ", ";
  }
  return row + (comma.empty() ? "| " : " | ");
}

/// Keys such as [Provot1995] or [Provot1995, section 4] that a text cites.
std::set<std::string> cited_keys(const std::string& text) {
  const auto letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; };
  const auto digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  std::set<std::string> keys;
  for (auto open = std::find(text.begin(), text.end(), '['); open != text.end();
       open = std::find(open + 1, text.end(), '[')) {
    const auto year = std::find_if_not(open + 1, text.end(), letter);
    const auto end = std::find_if_not(year, text.end(), digit);
    if (year - open < 3 || end - year != 4 || (end != text.end() && letter(*end))) continue;
    const std::string key(open + 1, end), century(year, year + 2);
    if (std::isupper(static_cast<unsigned char>(key[0])) != 0 &&
        (century == "19" || century == "20"))
      keys.insert(key);
  }
  return keys;
}

Sentences unknown_sources(const std::string& file, const std::string& text,
                          const std::string& bibliography) {
  Sentences faults;
  for (const std::string& key : cited_keys(text)) {
    if (bibliography.find("{" + key + ",") == std::string::npos) {
      faults.push_back(file + " cites [" + key + "], which docs/references.bib does not have");
    }
  }
  return faults;
}

/// The text after the first line of a source, its licence.
std::string without_licence(const std::string& text) { return text.substr(text.find('\n') + 1); }

/// Files of the rooms and tools whose ending is one of `endings`, relative to the root.
std::vector<std::string> files_with(const std::vector<std::string>& endings) {
  std::vector<std::string> files;
  std::set<std::string> folders;
  for (const Arrows* list : {&rooms(), &kUsers})
    for (const auto& [room, arrows] : *list) folders.insert(folder_of(room));
  for (const std::string& folder : folders) {
    for (const auto& entry : fs::recursive_directory_iterator(root() / folder)) {
      const std::string name = entry.path().filename();
      const bool wanted = std::any_of(endings.begin(), endings.end(),
                                      [&](const std::string& end) { return name.ends_with(end); });
      if (entry.is_regular_file() && wanted) {
        files.push_back(entry.path().lexically_relative(root()).generic_string());
      }
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

bool is_public_header(const std::string& file) {
  return file.ends_with(".h") && rooms().contains(room_of(file)) &&
         file.find("/detail/") == std::string::npos && file.find("/internal/") == std::string::npos;
}

/// Public names lie in selvedge, private ones in selvedge::detail; those of the judge, which shares
/// no code with what it judges, in selvedge::judging.
Sentences misplaced_names(const std::string& file, const std::string& text) {
  Sentences faults;
  const bool is_private = file.find("/detail/") != std::string::npos;
  const std::string own = room_of(file) == "judge" ? "judging" : "detail";
  bool has_private = false;
  static const std::string nested = "namespace selvedge::";
  for (const std::string& line : lines_of(text)) {
    has_private = has_private || line == "namespace detail {";
    if (!starts_with(line, nested)) continue;
    const std::string name =
        line.substr(nested.size(), line.find_first_of(" :", nested.size()) - nested.size());
    const bool good = name == (is_private ? own : "elementary");
    if (!good) faults.push_back(file + " opens selvedge::" + name);
    has_private = has_private || good;
  }
  if (is_private && !has_private)
    faults.push_back(file + " declares private names outside selvedge::" + own);
  return faults;
}

std::string joined(const Sentences& sentences) {
  std::string text;
  for (const std::string& sentence : sentences) text += "\n  " + sentence;
  return text;
}

void append(Sentences& all, const Sentences& more) {
  all.insert(all.end(), more.begin(), more.end());
}

TEST(Architecture, NoModuleIncludesWhatItsArrowsForbid) {
  Sentences faults;
  const std::vector<std::string> files = files_with({".h", ".cpp", ".inc"});
  ASSERT_GT(files.size(), 40u) << "the sources were not found under " << root();
  for (const std::string& file : files) append(faults, forbidden_arrows(file, read(root() / file)));
  EXPECT_TRUE(faults.empty()) << joined(faults);
}

TEST(Architecture, WhatDeterminesStatesCallsNoFunctionWhoseBitsVary) {
  Sentences faults;
  for (const std::string& file : files_with({".h", ".cpp", ".inc"}))
    if (kSameBits.contains(room_of(file)))
      append(faults, platform_functions(file, read(root() / file)));
  EXPECT_TRUE(faults.empty()) << joined(faults);
}

TEST(Architecture, PublicHeadersNameOnlyTheStandardLibraryAndEigen) {
  Sentences faults;
  for (const std::string& file : files_with({".h"})) {
    if (is_public_header(file)) append(faults, foreign_includes(file, read(root() / file)));
  }
  EXPECT_TRUE(faults.empty()) << joined(faults);
}

TEST(Architecture, PublicNamesLieInSelvedgeAndPrivateOnesInItsDetail) {
  Sentences faults;
  for (const std::string& file : files_with({".h"}))
    if (rooms().contains(room_of(file))) append(faults, misplaced_names(file, read(root() / file)));
  EXPECT_TRUE(faults.empty()) << joined(faults);
}

TEST(Architecture, EverySourceBeginsWithItsLicence) {
  std::vector<std::string> files =
      files_with({".h", ".cpp", ".inc", "CMakeLists.txt", ".sh", ".py"});
  for (const char* folder : {"scripts", "cmake", ".ci"}) {
    for (const auto& entry : fs::directory_iterator(root() / folder)) {
      files.push_back(entry.path().lexically_relative(root()).generic_string());
    }
  }
  files.push_back("CMakeLists.txt");
  Sentences faults;
  for (const std::string& file : files) append(faults, missing_licence(file, read(root() / file)));
  EXPECT_TRUE(faults.empty()) << joined(faults);
}

TEST(Architecture, DocumentsNameOnlyFilesThatAreThere) {
  Sentences faults;
  append(faults, missing_files("README.md", read(root() / "README.md"), root()));
  for (const auto& entry : fs::recursive_directory_iterator(root() / "docs")) {
    if (entry.path().extension() == ".md") {
      append(faults, missing_files(entry.path().filename(), read(entry.path()), root()));
    }
  }
  EXPECT_TRUE(faults.empty()) << joined(faults);
}

TEST(Architecture, OnlyTheSystemIncludesHeadersOfTheOperatingSystem) {
  Sentences faults;
  for (const std::string& file : files_with({".h", ".cpp", ".inc"}))
    if (!is_of_system(file) && folder_of(file) != "tests" && folder_of(file) != "bench")
      append(faults, system_includes(file, read(root() / file)));
  EXPECT_TRUE(faults.empty()) << joined(faults);
}

TEST(Architecture, EverySystemDefinesTheSameFunctions) {
  std::map<std::string, std::string> text;
  for (const char* folder : {"internal", "posix", "windows"})
    for (const auto& entry : fs::directory_iterator(root() / "core/system" / folder))
      text[folder] += read(entry.path());
  EXPECT_GT(functions(text["posix"], true).size(), 30u);
  const Sentences faults = one_sided(text["internal"], text["posix"], text["windows"]);
  EXPECT_TRUE(faults.empty()) << joined(faults);
}

TEST(Architecture, WhatRunsInBrowsersUsesNoNameThatEmscriptenLacks) {
  const std::string supplied = read(root() / "bindings/js/missing_std.h");
  Sentences faults;
  for (const std::string& file : files_with({".h", ".cpp", ".inc"}))
    for (const Room& room : kRooms)
      if (room.name == room_of(file) &&
          (room.part == "detectors" || room.part == "simulation" || room.part == "c"))
        append(faults, missing_in_browsers(file, read(root() / file), supplied));
  EXPECT_TRUE(faults.empty()) << joined(faults);
}

TEST(Architecture, TheRoomsFormNoCircle) {
  std::set<std::string> done;
  for (std::size_t before = 1; before != done.size();) {
    before = done.size();
    for (const auto& [room, arrows] : rooms())
      if (std::all_of(arrows.begin(), arrows.end(), [&](const std::string& folder) {
            return std::all_of(rooms().begin(), rooms().end(), [&](const auto& other) {
              return other.first == room || !is_within(other.first, folder) ||
                     done.contains(other.first);
            });
          }))
        done.insert(room);
    if (done.size() == rooms().size()) break;
  }
  EXPECT_EQ(done.size(), rooms().size());
}

TEST(Architecture, ThePageOnTheRoomsDescribesEachAsTheListDoes) {
  const std::string page = read(root() / "docs/architecture.md");
  for (const Room& room : kRooms)
    if (room.is_library()) {
      EXPECT_NE(page.find("\n" + row_of(room)), std::string::npos)
          << "docs/architecture.md lacks the row: " << row_of(room) << "`TARGETS` |";
    }
}

TEST(Architecture, TheSampleOfTheLibraryPageIsACompiledExample) {
  const std::string sample =
      code_block(read(root() / "docs/library.md"), "This is [examples/drape_on_sphere.cpp]");
  ASSERT_FALSE(sample.empty());
  EXPECT_EQ(sample, without_licence(read(root() / "examples/drape_on_sphere.cpp")));
}

TEST(Architecture, TheSamplesOfTheReadmeAreExamplesThatAreCompiledAndRun) {
  const std::string readme = read(root() / "README.md");
  for (const char* name : {"find_collisions", "step_in_memory"}) {
    const std::string file = std::string("examples/") + name + ".cpp";
    const std::string sample = code_block(readme, "This is [" + file + "]");
    ASSERT_FALSE(sample.empty()) << file;
    EXPECT_EQ(sample, without_licence(read(root() / file))) << file;
  }
  EXPECT_LE(lines_of(readme).size(), 130u);
}

TEST(Architecture, EverySourceThatCitesAPaperFindsItInTheBibliography) {
  const std::string bibliography = read(root() / "docs/references.bib");
  Sentences faults;
  for (const std::string& file : files_with({".h", ".cpp", ".inc"})) {
    if (file != "tests/architecture_test.cpp") {
      append(faults, unknown_sources(file, read(root() / file), bibliography));
    }
  }
  EXPECT_TRUE(faults.empty()) << joined(faults);
}

TEST(Architecture, TheRootOfTheBuildStaysShort) {
  EXPECT_LT(lines_of(read(root() / "CMakeLists.txt")).size(), 60u);
}

TEST(ArchitectureRules, FindAForbiddenArrow) {
  const std::string sample = "#include <selvedge/scene/scene.h>\n";
  EXPECT_EQ(forbidden_arrows("core/cloth/force.cpp", sample).size(), 1u);
  EXPECT_EQ(forbidden_arrows("broadphase/bvh.cpp", "#  include <selvedge/bodies/body.h>").size(),
            1u);
  EXPECT_EQ(forbidden_arrows("run/run.cpp", "#include <selvedge/compare/page.h>").size(), 1u);
  EXPECT_EQ(forbidden_arrows("simulation/step.cpp", "#include <selvedge/run/run.h>").size(), 1u);
  EXPECT_EQ(forbidden_arrows("judge/judge.cpp", "#include <selvedge/broadphase/bvh.h>").size(), 1u);
  EXPECT_EQ(forbidden_arrows("run/run.cpp", "#include <selvedge/apps/command_line.h>").size(), 1u);
  EXPECT_EQ(forbidden_arrows("bench/rest.cpp", "#include <selvedge/apps/command_line.h>").size(),
            0u);
  EXPECT_EQ(forbidden_arrows("bench/rest.cpp", "#include <selvedge/apps/overrides.h>").size(), 1u);
  EXPECT_EQ(forbidden_arrows("tests/scene/scene_test.cpp", sample).size(), 0u);
  EXPECT_EQ(forbidden_arrows("run/run.cpp", sample).size(), 0u);
  EXPECT_EQ(forbidden_arrows("narrowphase/a.cpp", "#include <selvedge/bodies/body.h>").size(), 0u);
}

TEST(ArchitectureRules, FindAWayAroundTheArrows) {
  EXPECT_EQ(forbidden_arrows("core/cloth/force.cpp", "#include \"../scene/scene.h\"").size(), 1u);
  EXPECT_EQ(forbidden_arrows("run/run.cpp", "#include <selvedge/core/cloth/detail/x.h>").size(),
            1u);
  EXPECT_EQ(
      forbidden_arrows("core/cloth/run.cpp", "#include <selvedge/core/cloth/detail/x.h>").size(),
      0u);
  EXPECT_EQ(forbidden_arrows("core/cloth/run.cpp", "#include \"types.h\"").size(), 1u);
  EXPECT_EQ(forbidden_arrows("apps/main.cpp", "#include \"overrides.h\"").size(), 0u);
  EXPECT_EQ(forbidden_arrows("apps/main.cpp", "#include \"../scene/scene.h\"").size(), 1u);
}

TEST(ArchitectureRules, FindAForeignLibraryInAPublicHeader) {
  EXPECT_EQ(foreign_includes("scene/scene.h", "#include <nlohmann/json.hpp>\n").size(), 1u);
  EXPECT_EQ(foreign_includes("core/base/parallel.h", "#include <tbb/parallel_for.h>\n").size(), 1u);
  EXPECT_EQ(foreign_includes("core/file.h", "#include <unistd.h>\n").size(), 1u);
  EXPECT_EQ(foreign_includes("core/a.h", "#include <selvedge/core/detail/b.h>\n").size(), 1u);
  EXPECT_EQ(
      foreign_includes("core/base/types.h", "#include <Eigen/Core>\n#include <array>\n").size(),
      0u);
}

TEST(ArchitectureRules, FindANameInTheWrongNamespace) {
  const std::string struct_in = "namespace selvedge {\nstruct A;\nstruct B { int b; };\n}\n";
  EXPECT_EQ(misplaced_names("response/detail/a.h", struct_in).size(), 1u);
  EXPECT_EQ(misplaced_names("response/a.h", struct_in).size(), 0u);
  const std::string detail = "namespace selvedge::detail {\nstruct B { int b; };\n}\n";
  EXPECT_EQ(misplaced_names("response/detail/a.h", detail).size(), 0u);
  EXPECT_EQ(misplaced_names("response/a.h", detail).size(), 1u);
  EXPECT_EQ(misplaced_names("response/detail/a.h", "namespace selvedge::other {\n").size(), 2u);
}

TEST(ArchitectureRules, FindAHeaderOfTheOperatingSystem) {
  EXPECT_EQ(system_includes("a.cpp", "#include <unistd.h>\n#include <sys/wait.h>\n").size(), 2u);
  EXPECT_EQ(system_includes("a.cpp", "#include <vector>\n#include <thread>\n").size(), 0u);
}

TEST(ArchitectureRules, FindAFunctionThatOneSystemLacks) {
  const std::string header = "class A {\n  ~A();\n  int f() const;  // g()\n};\nvoid h();\n";
  const std::string posix = "A::~A() { close(); }\nint A::f() const { return 1; }\nvoid h() {}\n";
  EXPECT_EQ(one_sided(header, posix, posix), Sentences{});
  EXPECT_EQ(one_sided(header, posix, "A::~A() {}\nint A::f() const {\n  h();\n}\nint g() {}\n"),
            Sentences{"h"});
}

TEST(ArchitectureRules, FindANameThatEmscriptenLacks) {
  const std::string supplied = "auto find(int);\n";
  const auto faults = [&](const std::string& text) {
    return missing_in_browsers("a.cpp", text, supplied).size();
  };
  EXPECT_EQ(faults("std::ranges::find(a, 1); std::span<int> b; std::formatter c;"), 0u);
  EXPECT_EQ(faults("std::ranges::max(a); std::views::iota(1); std::jthread c;"), 3u);
}

TEST(ArchitectureRules, FindAFunctionWhoseBitsVary) {
  EXPECT_EQ(platform_functions("a.cpp", "x = std::atan2(y, z);\n").size(), 1u);
  EXPECT_EQ(platform_functions("a.cpp", "std::asin(x); // std::sin(x)\n std::log1p(x);").size(),
            2u);
  EXPECT_EQ(platform_functions("a.cpp", "q.slerp(t, p); Eigen::AngleAxisd r;").size(), 1u);
  EXPECT_EQ(platform_functions("a.cpp", "elementary::sin(x); std::sqrt(x); // std::exp(x)").size(),
            0u);
}

TEST(ArchitectureRules, FindAMissingLicence) {
  EXPECT_EQ(missing_licence("a.cpp", "#include <array>\n").size(), 1u);
  EXPECT_EQ(missing_licence("a.sh", "#!/usr/bin/env bash\nset -e\n").size(), 1u);
  EXPECT_EQ(missing_licence("a.sh", "#!/usr/bin/env bash\n# SPDX-License-Identifier: MIT\n").size(),
            0u);
}

TEST(ArchitectureRules, ReadALineOfTheListOfRooms) {
  const Room room = read_room("a | program | same | b c | x y");
  EXPECT_TRUE(room.is_library());
  EXPECT_EQ(words(room.may_include), (std::vector<std::string>{"b", "c"}));
  EXPECT_EQ(row_of(room), "| `a` | x y | `b`, `c` | ");
}

TEST(ArchitectureRules, FindAFileThatADocumentInvents) {
  EXPECT_EQ(missing_files("README.md", "Run `scripts/no_such_script.sh`.", root()).size(), 1u);
  EXPECT_EQ(missing_files("README.md", "Run scripts/drape.sh.", root()).size(), 0u);
}

TEST(ArchitectureRules, FindAPaperThatTheBibliographyLacks) {
  const std::string bibliography = "@article{Provot1995,\n";
  EXPECT_EQ(unknown_sources("a.cpp", "// [Nobody1999] eq. (1)", bibliography).size(), 1u);
  EXPECT_EQ(unknown_sources("a.cpp", "// [Provot1995, section 4]", bibliography).size(), 0u);
  EXPECT_EQ(unknown_sources("a.cpp", "x[Index1000]", bibliography).size(), 0u);
}

TEST(ArchitectureRules, ReadTheCodeBlockThatFollowsAMarker) {
  EXPECT_EQ(code_block("a\n```sh\nno\n```\nmark\n```cpp\nyes\n```\n", "mark"), "yes\n");
  EXPECT_EQ(code_block("a", "mark"), "");
}

}  // namespace
