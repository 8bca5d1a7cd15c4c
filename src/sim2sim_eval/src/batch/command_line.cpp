// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/command_line.hpp"

#include <sys/ioctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/standard_streams.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_serving/node.hpp"

namespace sim2sim {
namespace {

template <class Number>
CLI::Validator decimalText(const char* name) {
  return {[name](const std::string& text) -> std::string {
            return pusht::decimal<Number>(text) ? "" : "'" + text + "': must be a decimal " + name + " in range";
          },
          ""};
}

/// Throws RuntimeFault where libraries, which open files of their own, would fail in their own words.
void requireOpenFiles() {
  constexpr rlim_t kFewest = 16;
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_cur < kFewest) {
    throw pusht::RuntimeFault("the limit of open files (ulimit -n) is " + std::to_string(limit.rlim_cur) +
                              ": must be at least " + std::to_string(kFewest));
  }
}

/// Edit distance: number of characters to insert, delete, change, or swap with their neighbor to turn `a` into `b`.
std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> distance(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        distance[i][j] = i + j;
        continue;
      }
      distance[i][j] = std::min(
          {distance[i - 1][j] + 1, distance[i][j - 1] + 1, distance[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        distance[i][j] = std::min(distance[i][j], distance[i - 2][j - 2] + 1);
      }
    }
  }
  return distance[a.size()][b.size()];
}

/// The option of `app` whose name is nearest to `name`; none if all are far.
std::optional<std::string> nearestOption(const CLI::App& app, const std::string& name) {
  std::optional<std::string> nearest;
  std::size_t least = std::max<std::size_t>(2, name.size() / 4) + 1;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& known : option->get_lnames()) {
      if (const std::size_t distance = editDistance(name, known); distance < least) {
        least = distance;
        nearest = known;
      }
    }
  }
  return nearest;
}

/// Message about arguments that `app` does not know.
std::string unexpectedText(const CLI::App& app, const CLI::ExtrasError& error) {
  constexpr std::size_t kLongest = 60;  // characters of an argument that may be an option
  for (const std::string& argument : app.remaining()) {
    const std::string name = argument.substr(0, argument.find('='));
    if (name.size() < 3 || name.size() > kLongest || name.compare(0, 2, "--") != 0) {
      continue;
    }
    const std::optional<std::string> nearest = nearestOption(app, name.substr(2));
    return name + ": there is no such option; " +
           (nearest ? "did you mean --" + *nearest + "?" : "--help lists what there is");
  }
  return error.what();
}

}  // namespace

int runCommand(CLI::App& app, int argc, char** argv, const std::function<void()>& body) {
  pusht::openStandardStreams();
  try {
    parseArguments(app, {argv + 1, argv + argc});
    catchInterrupts(app.get_name());
    requireOpenFiles();
    body();
    if (!std::cout.flush()) {
      throw pusht::RuntimeFault("cannot write to stdout");
    }
    return static_cast<int>(pusht::ExitCode::kOk);
  } catch (const CLI::Success& request) {  // --help
    return app.exit(request);
  } catch (const std::system_error& error) {  // files or threads that the system does not give
    return pusht::reportFailure(app.get_name(), pusht::RuntimeFault(error.what()));
  } catch (const std::exception& failure) {
    return pusht::reportFailure(app.get_name(), failure);
  }
}

int runCommand(const std::string& name, Command command, int argc, char** argv) {
  CLI::App app("", name);
  const CommandWork work = command(app);
  return runCommand(app, argc, argv, [&] { work({}); });
}

void parseArguments(CLI::App& app, std::vector<std::string> arguments) {
  try {
    std::reverse(arguments.begin(), arguments.end());  // as CLI11 takes them
    app.parse(std::move(arguments));
  } catch (const CLI::Success&) {  // --help
    throw;
  } catch (const CLI::ExtrasError& error) {
    throw pusht::InvalidInput(unexpectedText(app, error));
  } catch (const CLI::ParseError& error) {
    throw pusht::InvalidInput(error.what());
  }
}

CLI::Validator notEmpty() {
  return {[](const std::string& text) -> std::string { return text.empty() ? "'': must not be empty" : ""; }, ""};
}

CLI::Validator decimalInteger() { return decimalText<std::uint64_t>("integer"); }

CLI::Validator decimalReal() { return decimalText<double>("number"); }

ProgressBar::ProgressBar(std::string title, std::int64_t total, bool wanted)
    : title_(std::move(title)),
      total_(total),
      shown_(wanted && isatty(STDERR_FILENO) != 0),
      start_(std::chrono::steady_clock::now()) {}

ProgressBar::~ProgressBar() { clear(); }

void ProgressBar::clear() const {
  if (shown_) {
    std::cerr << "\r\033[K" << std::flush;
  }
}

void ProgressBar::advance(const std::string& note) {
  ++done_;
  if (!shown_) {
    return;
  }
  constexpr int kWidth = 30;
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  const auto seconds_left =
      std::lround(elapsed.count() / static_cast<double>(done_) * static_cast<double>(total_ - done_));
  const auto filled = static_cast<std::size_t>(kWidth * done_ / total_);
  std::ostringstream text;
  text << title_ << " [" << std::string(filled, '#') << std::string(kWidth - filled, '.') << "] " << done_ << "/"
       << total_ << "  " << seconds_left << " s left  " << note;
  winsize terminal{};
  const bool has_width = ioctl(STDERR_FILENO, TIOCGWINSZ, &terminal) == 0 && terminal.ws_col > 1;
  std::string line = text.str();
  if (has_width && line.size() >= terminal.ws_col) {
    std::size_t end = terminal.ws_col - 1U;
    while (end > 0 && (static_cast<unsigned char>(line[end]) & 0xC0U) == 0x80U) {
      --end;  // not within a character of UTF-8
    }
    line.resize(end);
  }
  std::cerr << "\r\033[K" << line << std::flush;
}

}  // namespace sim2sim
