// SPDX-License-Identifier: BSD-3-Clause
/// Common parts of all commands: how they are run, exit codes, validators of options, progress bar.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <iostream>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace sim2sim {

/// Runs a command: parses the command line into `app`, catches signals (catchInterrupts), runs `body`, and returns the
/// exit code. Every failure becomes one line on stderr and the exit code of its kind.
int runCommand(CLI::App& app, int argc, char** argv, const std::function<void()>& body);

/// What a command takes from the program around it. The defaults are those of a terminal.
struct CommandHost {
  std::ostream* out = &std::cout;  ///< gets what the command prints
  bool progress = true;            ///< show a progress bar
};

/// Work of a command, which writes its files. Returns the figures that it has printed or written.
using CommandWork = std::function<nlohmann::json(const CommandHost& host)>;

/// Declares the options of a command, and its description, on a command line. The work has the options that are parsed
/// then.
using Command = CommandWork (*)(CLI::App& app);

/// Command `contrast`. Python has it, too, as the next three.
CommandWork contrastCommand(CLI::App& app);
/// Command `matrix`.
CommandWork matrixCommand(CLI::App& app);
/// Command `plan`.
CommandWork planCommand(CLI::App& app);
/// Command `sweep`.
CommandWork sweepCommand(CLI::App& app);

/// Runs such a command in a terminal.
int runCommand(const std::string& name, Command command, int argc, char** argv);

/// Parses `arguments` as a command line into `app`. Throws InvalidInput with the message of the command.
void parseArguments(CLI::App& app, std::vector<std::string> arguments);

/// Validator that refuses "". A shell leaves it for an unset variable, and it must not count as an option left out.
CLI::Validator notEmpty();

/// Validators that accept decimal numbers alone. CLI11 itself reads 010 as eight, and an empty text as zero.
CLI::Validator decimalInteger();
/// Accepts decimal numbers only, whole or not.
CLI::Validator decimalReal();

/// Progress bar on stderr: finished, total, time left. Silent unless stderr is a terminal.
class ProgressBar {
 public:
  /// `total` is the number of advance() calls to come; without `wanted` it is silent.
  ProgressBar(std::string title, std::int64_t total, bool wanted = true);
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();

  /// Counts one more as finished; `note` is shown behind the bar, as far as the terminal is wide.
  void advance(const std::string& note);

  /// Takes the bar off the terminal until it advances, so that a line can be printed in its place.
  void clear() const;

  /// Takes `count` off the total.
  void skip(std::int64_t count) { total_ -= count; }

 private:
  std::string title_;
  std::int64_t total_;
  std::int64_t done_ = 0;
  bool shown_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace sim2sim
