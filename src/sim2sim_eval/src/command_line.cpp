// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/command_line.hpp"

#include <ros/package.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <iostream>
#include <system_error>
#include <utility>

#include "pusht_task/error.hpp"

namespace sim2sim {
namespace {

volatile std::sig_atomic_t interrupt_received = 0;

int report(const std::string& command, const std::string& message, pusht::ExitCode code) {
  std::cerr << command << ": " << message << std::endl;
  return static_cast<int>(code);
}

}  // namespace

int runCommand(CLI::App& app, int argc, char** argv, const std::function<void()>& body) {
  try {
    app.parse(argc, argv);
    body();
    return static_cast<int>(pusht::ExitCode::kOk);
  } catch (const CLI::Success& request) {  // --help
    return app.exit(request);
  } catch (const CLI::ParseError& error) {
    return report(app.get_name(), error.what(), pusht::ExitCode::kInvalidInput);
  } catch (const pusht::Error& error) {
    return report(app.get_name(), error.what(), error.exitCode());
  } catch (const std::exception& error) {
    return report(app.get_name(), std::string("internal error: ") + error.what(), pusht::ExitCode::kInternalError);
  }
}

void catchInterrupts() {
  struct sigaction action {};
  action.sa_handler = [](int) { interrupt_received = 1; };
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() { return interrupt_received != 0; }

std::filesystem::path installedFile(const std::string& package, const std::string& relative_path) {
  const std::string share = ros::package::getPath(package);
  if (share.empty()) {
    throw pusht::BadDependency("package " + package + " is not found: source the workspace's setup.bash");
  }
  std::filesystem::path path = std::filesystem::path(share) / relative_path;
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    throw pusht::BadDependency(path.string() + " is missing: package " + package + " must install it");
  }
  return path;
}

ProgressBar::ProgressBar(std::string title, int total)
    : title_(std::move(title)),
      total_(total),
      shown_(isatty(STDERR_FILENO) != 0),
      start_(std::chrono::steady_clock::now()) {}

ProgressBar::~ProgressBar() {
  if (shown_) {
    std::cerr << "\r\033[K" << std::flush;
  }
}

void ProgressBar::update(int done, const std::string& note) {
  if (!shown_ || done == 0) {
    return;
  }
  constexpr int kWidth = 30;
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  const auto seconds_left = std::lround(elapsed.count() / done * (total_ - done));
  const auto filled = static_cast<std::size_t>(kWidth * done / total_);
  std::cerr << "\r\033[K" << title_ << " [" << std::string(filled, '#') << std::string(kWidth - filled, '.') << "] "
            << done << "/" << total_ << "  " << seconds_left << " s left  " << note << std::flush;
}

}  // namespace sim2sim
