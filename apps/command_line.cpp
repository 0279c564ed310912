// SPDX-License-Identifier: MIT
#include <selvedge/apps/command_line.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/system/internal/terminal.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <numeric>
#include <string_view>
#include <utility>

namespace selvedge {
namespace {

constexpr int kInputWrong = 2;

/// Whether `text` is a finite number, as `value`.
bool is_number(const std::string& text, double& value) {
  char* end = nullptr;
  value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == 0 && std::isfinite(value);
}

// The checks of the library print the smallest or largest double in their messages.

std::string refuse_negative(const std::string& text) {
  double value = 0.0;
  return is_number(text, value) && value >= 0.0 ? "" : text + " must be a number of at least 0";
}

std::string refuse_not_positive(const std::string& text) {
  double value = 0.0;
  return is_number(text, value) && value > 0.0 ? "" : text + " must be a number above 0";
}

/// Levenshtein's distance: insertions, deletions and replacements of a letter.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = std::exchange(row[j + 1], std::min({replaced, row[j] + 1, row[j + 1] + 1}));
    }
  }
  return row.back();
}

std::vector<std::string> subcommand_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    if (!command->get_name().empty()) names.push_back(command->get_name());
  return names;
}

/// A sentence if the first word is not one of the program's commands, else "".
std::string refuse_command(const CLI::App& app, const std::vector<std::string>& words) {
  const std::vector<std::string> names = subcommand_names(app);
  if (names.empty() || (words.size() > 1 && words[1].starts_with('-'))) return "";
  const std::string program = app.get_name();
  const std::string see = "`" + program + " --help` lists the commands";
  if (words.size() < 2)
    return "give a command, such as `" + program + " " + names.front() + "`; " + see;
  const std::string& word = words[1];
  if (std::find(names.begin(), names.end(), word) != names.end()) return "";
  const auto nearest =
      *std::min_element(names.begin(), names.end(), [&](const auto& a, const auto& b) {
        return edit_distance(word, a) < edit_distance(word, b);
      });
  const bool near = edit_distance(word, nearest) <= (word.size() < 4 ? 1 : 2);
  return "there is no command \"" + word + "\"" +
         (near ? "; did you mean `" + program + " " + nearest + "`? " : "; ") + see;
}

/// The error and the command whose help explains it.
std::string failure_message(const CLI::App* app, const CLI::Error& error) {
  std::string command = app->get_name();
  for (const CLI::App* used : app->get_subcommands()) command += " " + used->get_name();
  return (app->get_name().empty() ? "" : app->get_name() + ": ") + printable(error.what()) +
         (command.empty() ? "; --help describes the options\n"
                          : "; `" + command + " --help` describes the options\n");
}

}  // namespace

// -- options --------------------------------------------------------------------------------------

using Option = Command::Option;

const Option& Option::required() const {
  option_->required();
  return *this;
}
const Option& Option::range(int lowest, int highest) const {
  option_->check(CLI::Range(lowest, highest));
  return *this;
}
const Option& Option::range(double lowest, double highest) const {
  option_->check(CLI::Range(lowest, highest));
  return *this;
}
const Option& Option::range(std::size_t lowest, std::size_t highest) const {
  option_->check(CLI::Range(lowest, highest));
  return *this;
}
const Option& Option::positive() const {
  option_->check(refuse_not_positive, "POSITIVE");
  return *this;
}
const Option& Option::non_negative() const {
  option_->check(refuse_negative);
  return *this;
}
const Option& Option::one_of(const std::vector<std::string>& words) const {
  option_->check(CLI::IsMember(words));
  return *this;
}
const Option& Option::existing_file() const {
  option_->check(CLI::ExistingFile);
  return *this;
}
const Option& Option::existing_folder() const {
  option_->check(CLI::ExistingDirectory);
  return *this;
}
const Option& Option::comma_separated() const {
  option_->delimiter(',');
  return *this;
}
const Option& Option::one_word() const {
  option_->allow_extra_args(false);
  option_->option_text("TEXT (repeatable)");  // the library would print "TEXT ..."
  return *this;
}
const Option& Option::words(int count) const {
  option_->expected(count);
  return *this;
}
const Option& Option::excludes(const Option& other) const {
  option_->excludes(other.option_);
  return *this;
}
const Option& Option::show_default() const {
  option_->capture_default_str();
  return *this;
}
const Option& Option::hidden() const {
  option_->group("");
  return *this;
}

bool Option::given() const { return option_->count() > 0; }
std::string Option::name() const { return option_->get_name(); }

// -- commands -------------------------------------------------------------------------------------

Command Command::subcommand(const std::string& name, const std::string& description) const {
  app_->require_subcommand(1);
  return Command(*app_->add_subcommand(name, description), *outcome_);
}

Command Command::group(const std::string& heading) const {
  return Command(*app_->add_option_group(heading), *outcome_);
}

template <class Value>
Option Command::option(const std::string& name, Value& value, const std::string& help) const {
  return Option(*app_->add_option(name, value, help));
}

template Option Command::option(const std::string&, std::string&, const std::string&) const;
template Option Command::option(const std::string&, std::filesystem::path&,
                                const std::string&) const;
template Option Command::option(const std::string&, int&, const std::string&) const;
template Option Command::option(const std::string&, unsigned&, const std::string&) const;
template Option Command::option(const std::string&, std::size_t&, const std::string&) const;
template Option Command::option(const std::string&, double&, const std::string&) const;
template Option Command::option(const std::string&, std::optional<int>&, const std::string&) const;
template Option Command::option(const std::string&, std::optional<double>&,
                                const std::string&) const;
template Option Command::option(const std::string&, std::vector<std::string>&,
                                const std::string&) const;
template Option Command::option(const std::string&, std::vector<int>&, const std::string&) const;
template Option Command::option(const std::string&, std::vector<double>&, const std::string&) const;

Option Command::flag(const std::string& name, bool& value, const std::string& help) const {
  return Option(*app_->add_flag(name, value, help));
}

void Command::footer(const std::string& text) const { app_->footer(text); }

void Command::action(const std::function<int()>& run) const {
  app_->callback([run, outcome = outcome_] {
    const ThreadLimit limit(outcome->threads.value_or(0));
    outcome->exit_code = run();
  });
}

std::vector<Option> Command::options() const {
  std::vector<Option> options;
  for (CLI::Option* option : app_->get_options()) options.emplace_back(*option);
  return options;
}

// -- the program ----------------------------------------------------------------------------------

struct CommandLine::State {
  CLI::App app;
  Outcome outcome;
};

CommandLine::CommandLine(const std::string& description, const std::string& name)
    : CommandLine(std::unique_ptr<State>(new State{CLI::App(description, name), {}})) {}

CommandLine::CommandLine(std::unique_ptr<State> state)
    : Command(state->app, state->outcome), state_(std::move(state)) {
  state_->app.failure_message(failure_message);
  state_->app.allow_windows_style_options(false);  // a path may begin with /
}

CommandLine::~CommandLine() = default;

void CommandLine::version(const std::string& text) {
  state_->app.set_version_flag("--version", text, "Print version, licence and libraries");
}

void CommandLine::common_options() {
  state_->app.fallthrough();  // of the commands that are added from here on
  state_->app
      .add_option("--threads", state_->outcome.threads,
                  "Threads of any command; 0: all. The result does not depend on it. By default\n"
                  "all, but 1 for the runs of `compare` and for the trials of `stability`")
      ->check(CLI::Range(0, 1024));
  state_->app.add_flag("--no-pictures", state_->outcome.no_pictures,
                       "No command draws pictures: faster");
}

std::optional<int> CommandLine::parse(int argc, char** argv) {
  CLI::App& app = state_->app;
  const std::vector<std::string> words = program_arguments(argc, argv);
  if (const std::string refusal = refuse_command(app, words); !refusal.empty()) {
    std::cerr << app.get_name() << ": " << printable(refusal) << "\n";
    return kInputWrong;
  }
  try {
    std::vector<const char*> pointers;
    for (const std::string& word : words) pointers.push_back(word.c_str());
    app.parse(static_cast<int>(pointers.size()), pointers.data());
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kInputWrong;  // a call for help is not an error
  }
  return state_->outcome.exit_code;
}

}  // namespace selvedge
