// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace selvedge {

/// The options of a program or of one of its commands. Only command_line.cpp includes the library
/// that parses them, because its headers take seconds to compile. A handle: copies refer to the
/// same command, which the CommandLine owns.
class Command {
 public:
  /// One option; a handle too. Each function returns the option, so that calls can be chained.
  class Option {
   public:
    explicit Option(CLI::Option& option) : option_(&option) {}

    const Option& required() const;
    /// Bounds are inclusive; the help shows them.
    const Option& range(int lowest, int highest) const;
    const Option& range(double lowest, double highest) const;
    const Option& range(std::size_t lowest, std::size_t highest) const;
    const Option& positive() const;
    const Option& non_negative() const;
    const Option& one_of(const std::vector<std::string>& words) const;
    const Option& existing_file() const;
    const Option& existing_folder() const;
    /// One word may hold several values, separated by commas.
    const Option& comma_separated() const;
    /// Each occurrence of the option takes one word; the next word is not part of it.
    const Option& one_word() const;
    /// The option takes exactly this many words.
    const Option& words(int count) const;
    const Option& excludes(const Option& other) const;
    const Option& show_default() const;
    const Option& hidden() const;

    /// Whether the user gave the option.
    bool given() const;
    std::string name() const;

   private:
    CLI::Option* option_;
  };

  /// What the whole command line says and how its command ended.
  struct Outcome {
    std::optional<int> threads;    ///< as given for any command
    bool no_pictures = false;      ///< as given for any command
    std::optional<int> exit_code;  ///< of the command that ran
  };
  explicit Command(CLI::App& app, Outcome& outcome) : app_(&app), outcome_(&outcome) {}

  Command subcommand(const std::string& name, const std::string& description) const;
  /// Options under a heading of their own in the help.
  Command group(const std::string& heading) const;

  /// A name without dashes is a positional argument. `value` must outlive the parsing; its type is
  /// one of those that command_line.cpp instantiates: std::string, std::filesystem::path, int,
  /// unsigned, std::size_t, double, std::optional of int or double, std::vector of std::string, int
  /// or double.
  template <class Value>
  Option option(const std::string& name, Value& value, const std::string& help = "") const;
  /// "!--name" sets `value` to false.
  Option flag(const std::string& name, bool& value, const std::string& help) const;

  /// Text below the options in the help.
  void footer(const std::string& text) const;
  /// Runs where the command line names this command, after its options are read and with the
  /// threads that were given; returns the exit code of the program.
  void action(const std::function<int()>& run) const;

  /// The number given with --threads, 0: all processors; after the parsing.
  std::optional<int> threads() const { return outcome_->threads; }
  /// False after --no-pictures; after the parsing.
  bool pictures() const { return !outcome_->no_pictures; }

  /// The options added so far, those of groups left out.
  std::vector<Option> options() const;

 private:
  CLI::App* app_;
  Outcome* outcome_;
};

/// The command line of a program.
class CommandLine : public Command {
 public:
  /// `name` is the word that starts the program; if empty, messages use that of the call.
  explicit CommandLine(const std::string& description, const std::string& name = "");
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  /// `--version` prints this text.
  void version(const std::string& text);
  /// What every command takes, before or after its name: `--threads N` limits the threads of its
  /// action, `--no-pictures` is for those that draw.
  void common_options();
  /// Reads the options and runs the action of the command. Returns the exit code if the program
  /// shall end: that of the action, 0 after the help, 2 after a message on the error stream if the
  /// command line is wrong. Returns nothing if no command has an action. Exceptions of the action
  /// pass through.
  std::optional<int> parse(int argc, char** argv);

 private:
  struct State;
  explicit CommandLine(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace selvedge
