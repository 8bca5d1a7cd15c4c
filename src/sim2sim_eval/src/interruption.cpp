// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/interruption.hpp"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <iostream>
#include <system_error>
#include <thread>
#include <utility>

#include "pusht_task/ending_signals.hpp"
#include "pusht_task/error.hpp"
#include "sim2sim_serving/node.hpp"

namespace sim2sim {
namespace {

std::atomic<std::int64_t> first_interrupt = 0;  // [ns] on the monotonic clock; 0: none yet
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "a signal handler may touch nothing else");

constexpr unsigned int kPatience = 10;  // [s] for an end in order

/// [ns] Two signals that are closer are one: `timeout` sends its own to the command and to the command's group.
constexpr std::int64_t kOneSignal = 500'000'000;

std::function<void(const std::string&)> take_warning;  // empty: stderr

std::string last_words;  // written by a signal handler

[[noreturn]] void endAtOnce(int /*number*/) {
  [[maybe_unused]] const ssize_t count = ::write(STDERR_FILENO, last_words.data(), last_words.size());
  ::_exit(static_cast<int>(pusht::ExitCode::kRuntimeFault));
}

std::string command;  // for endUncaught()

/// Ends the process when an exception finds no handler: one line and an exit code, no core.
[[noreturn]] void endUncaught() {
  int code = static_cast<int>(pusht::ExitCode::kInternalError);
  try {
    if (const std::exception_ptr uncaught = std::current_exception()) {
      std::rethrow_exception(uncaught);
    }
    throw pusht::InternalError("std::terminate without an exception");
  } catch (const std::system_error& failure) {  // a thread that the system does not give, say
    code = pusht::reportFailure(command, pusht::RuntimeFault(failure.what()));
  } catch (const std::exception& failure) {
    code = pusht::reportFailure(command, failure);
  } catch (...) {
    pusht::reportFailure(command, pusht::InternalError("an unknown exception"));
  }
  ::_exit(code);
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

}  // namespace

void catchInterrupts(const std::string& name) {
  command = name;
  std::set_terminate(endUncaught);
  last_words = name + ": interrupted, and ended before it had stopped in order; what it was writing is lost\n";
  struct sigaction action {};
  action.sa_flags = SA_RESTART;
  action.sa_handler = onInterrupt;
  for (const int number : pusht::kEndingSignals) {
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
  for (const int number : pusht::kEndingSignals) {
    sigaddset(&signals, number);
  }
  sigaddset(&signals, SIGALRM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

bool interrupted() { return first_interrupt != 0; }

void interrupt(bool wanted) { first_interrupt = wanted ? 1 : 0; }

void requireNotInterrupted(const std::string& where) {
  if (interrupted()) {
    throw pusht::RuntimeFault(where.empty() ? "interrupted" : "interrupted " + where);
  }
}

void warn(const std::string& warning) {
  if (warning.empty()) {
    return;
  }
  if (take_warning) {
    take_warning(warning);
  } else {
    std::cerr << "WARNING: " << warning << std::endl;
  }
}

void sendWarningsTo(std::function<void(const std::string&)> take) { take_warning = std::move(take); }

}  // namespace sim2sim
