// SPDX-License-Identifier: BSD-3-Clause
/// What all commands share: exit codes, options, progress.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace sim2sim {

/// Parses the command line into `app`, runs `body` and returns its exit code. Every failure becomes one line
/// on stderr and the exit code of its kind; signals are caught.
int runCommand(CLI::App& app, int argc, char** argv, const std::function<void()>& body);

/// Throws InvalidInput, with `what` in front, if there is something at `path` already; an empty one means none.
void requireNewFile(const std::string& what, const std::filesystem::path& path);

/// Refuses "", which an unset variable of a shell leaves: it must not count as an option that was not given.
CLI::Validator notEmpty();

/// Accept whole decimal numbers only: CLI11 itself takes 010 for eight, and nothing for zero.
CLI::Validator decimalInteger();
/// Accepts decimal numbers only, whole or not.
CLI::Validator decimalReal();

/// A bar on stderr that shows done, total and time left; silent unless stderr is a terminal.
class ProgressBar {
 public:
  ProgressBar(std::string title, std::int64_t total);
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();

  /// One more is done.
  void advance(const std::string& note);

  /// `count` need not be done.
  void skip(std::int64_t count) { total_ -= count; }

 private:
  std::string title_;
  std::int64_t total_;
  std::int64_t done_ = 0;
  bool shown_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace sim2sim
