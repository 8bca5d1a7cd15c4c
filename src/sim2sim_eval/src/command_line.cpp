// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/command_line.hpp"

#include <unistd.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <ctime>
#include <iostream>
#include <thread>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/ros/node.hpp"

namespace sim2sim {
namespace {

std::atomic<std::int64_t> first_interrupt = 0;  // [ns] on the monotonic clock; 0: none yet
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "a signal handler may touch nothing else");

constexpr unsigned int kPatience = 10;  // [s] for an end in order

/// [ns] Two signals that are closer are one: `timeout` sends its own to the command and to the command's group.
constexpr std::int64_t kOneSignal = 500'000'000;

std::string last_words;  // written by a signal handler

[[noreturn]] void endAtOnce(int /*number*/) {
  [[maybe_unused]] const ssize_t count = ::write(STDERR_FILENO, last_words.data(), last_words.size());
  ::_exit(static_cast<int>(pusht::ExitCode::kRuntimeFault));
}

void onInterrupt(int number) {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  const std::int64_t time = now.tv_sec * std::int64_t{1'000'000'000} + now.tv_nsec;
  std::int64_t first = 0;
  if (first_interrupt.compare_exchange_strong(first, time)) {
    ::alarm(kPatience);
  } else if (time - first > kOneSignal) {
    endAtOnce(number);
  }
}

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

CLI::Validator decimalInteger() { return decimalText<std::uint64_t>("integer"); }

CLI::Validator decimalReal() { return decimalText<double>("number"); }

void catchInterrupts(const std::string& name) {
  last_words = name + ": interrupted, and ended before it had stopped in order; what it was writing is lost\n";
  struct sigaction action {};
  action.sa_flags = SA_RESTART;
  action.sa_handler = onInterrupt;
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    sigaction(number, &action, nullptr);
  }
  action.sa_handler = endAtOnce;
  sigaction(SIGALRM, &action, nullptr);
  // A file that grows beyond its limit and a reader that has gone are then errors of write(): results still get out.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

void catchInterruptsAside(const std::string& name) {
  catchInterrupts(name);
  std::thread([] {
    while (true) {
      ::pause();
    }
  }).detach();
  sigset_t signals;
  sigemptyset(&signals);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGALRM}) {
    sigaddset(&signals, number);
  }
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

bool interrupted() { return first_interrupt != 0; }

void warn(const std::string& warning) {
  if (!warning.empty()) {
    std::cerr << "WARNING: " << warning << std::endl;
  }
}

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
