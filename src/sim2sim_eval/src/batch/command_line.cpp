// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/command_line.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <iostream>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/ros/node.hpp"
#include "sim2sim_eval/interruption.hpp"

namespace sim2sim {
namespace {

template <class Number>
CLI::Validator decimalText(const char* name) {
  return {[name](const std::string& text) -> std::string {
            return pusht::decimal<Number>(text) ? "" : "'" + text + "': must be a decimal " + name + " in range";
          },
          ""};
}

}  // namespace

int runCommand(CLI::App& app, int argc, char** argv, const std::function<void()>& body) {
  try {
    app.parse(argc, argv);
    catchInterrupts(app.get_name());
    body();
    if (!std::cout.flush()) {
      throw pusht::RuntimeFault("cannot write to stdout");
    }
    return static_cast<int>(pusht::ExitCode::kOk);
  } catch (const CLI::Success& request) {  // --help
    return app.exit(request);
  } catch (const CLI::ParseError& error) {
    return pusht::reportFailure(app.get_name(), pusht::InvalidInput(error.what()));
  } catch (const std::exception& failure) {
    return pusht::reportFailure(app.get_name(), failure);
  }
}

void requireNewFile(const std::string& what, const std::filesystem::path& path) {
  std::error_code ignored;
  if (!path.empty() && std::filesystem::symlink_status(path, ignored).type() != std::filesystem::file_type::not_found) {
    throw pusht::InvalidInput(what + " " + path.string() + ": is there already; name a new file");
  }
}

CLI::Validator decimalInteger() { return decimalText<std::uint64_t>("integer"); }

CLI::Validator decimalReal() { return decimalText<double>("number"); }

ProgressBar::ProgressBar(std::string title, std::int64_t total)
    : title_(std::move(title)),
      total_(total),
      shown_(isatty(STDERR_FILENO) != 0),
      start_(std::chrono::steady_clock::now()) {}

ProgressBar::~ProgressBar() {
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
  std::cerr << "\r\033[K" << title_ << " [" << std::string(filled, '#') << std::string(kWidth - filled, '.') << "] "
            << done_ << "/" << total_ << "  " << seconds_left << " s left  " << note << std::flush;
}

}  // namespace sim2sim
