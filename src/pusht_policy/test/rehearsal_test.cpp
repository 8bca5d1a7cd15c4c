// SPDX-License-Identifier: BSD-3-Clause
#include "../src/rehearsal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <future>
#include <stdexcept>
#include <string>
#include <thread>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

using ::testing::HasSubstr;

constexpr std::chrono::milliseconds kLong{60'000};
constexpr std::chrono::milliseconds kShort{50};

[[noreturn]] void sleepForEver() {
  for (;;) {
    pause();
  }
}

bool never() { return false; }

/// Rehearsing `work` must fail so.
void expectFailure(std::chrono::milliseconds deadline, const std::function<void()>& work, ExitCode exit_code,
                   const std::string& message, const std::function<bool()>& stop = never) {
  try {
    rehearse("the work", deadline, stop, work);
    FAIL() << "nothing is thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.exitCode(), exit_code) << error.what();
    EXPECT_THAT(error.what(), HasSubstr(message));
  }
}

class Rehearsal : public ::testing::Test {
 protected:
  ~Rehearsal() override { EXPECT_TRUE(waitpid(-1, nullptr, WNOHANG) < 0 && errno == ECHILD) << "a copy is left"; }
};

TEST_F(Rehearsal, ChangesNothing) {
  int value = 1;
  rehearse("the work", kLong, never, [&] { value = 2; });
  EXPECT_EQ(value, 1);
}

TEST_F(Rehearsal, ThrowsWhatTheWorkThrows) {
  const std::string text(100'000, 'x');  // more than a pipe holds
  expectFailure(
      kLong, [&] { throw BadDependency(text); }, ExitCode::kBadDependency, text);
  expectFailure(
      kLong, [] { throw std::runtime_error("a defect"); }, ExitCode::kInternalError, "a defect");
}

TEST_F(Rehearsal, SurvivesACrash) {
  expectFailure(
      kLong, [] { std::raise(SIGKILL); }, ExitCode::kInvalidInput, "the work: must not crash libtorch, but does: Kill");
  expectFailure(
      kLong, [] { _exit(0); }, ExitCode::kInvalidInput, "the work: must not crash libtorch, but does: ");
}

TEST_F(Rehearsal, HasADeadline) {
  expectFailure(kShort, sleepForEver, ExitCode::kRuntimeFault, "the work: must load and act within ");
}

TEST_F(Rehearsal, EndsAtASignalThatIsHandled) {
  struct sigaction handled {};
  handled.sa_handler = [](int /*number*/) {};
  handled.sa_flags = SA_RESTART;
  struct sigaction before {};
  sigaction(SIGTERM, &handled, &before);
  const auto signal_parent = [] {
    kill(getppid(), SIGTERM);
    sleepForEver();
  };
  expectFailure(kLong, signal_parent, ExitCode::kRuntimeFault, "the work: interrupted while it was tried out");
  sigaction(SIGTERM, &before, nullptr);
}

/// Signal to a process with other threads: in a node, a thread of roscpp may take it.
TEST_F(Rehearsal, EndsAtASignalThatAnotherThreadTakes) {
  static std::atomic<bool> stop{false};
  struct sigaction handled {};
  handled.sa_handler = [](int /*number*/) { stop = true; };
  struct sigaction before {};
  sigaction(SIGTERM, &handled, &before);
  std::promise<void> done;
  std::thread other([ending = done.get_future()] { ending.wait(); });
  sigset_t held;
  sigemptyset(&held);
  sigaddset(&held, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &held, nullptr);
  const auto signal_parent = [] {
    kill(getppid(), SIGTERM);
    sleepForEver();
  };
  const auto begin = std::chrono::steady_clock::now();
  expectFailure(kLong, signal_parent, ExitCode::kRuntimeFault, "the work: interrupted while it was tried out",
                [] { return stop.load(); });
  EXPECT_LT(std::chrono::steady_clock::now() - begin, kLong / 2) << "it must not wait for the deadline";
  pthread_sigmask(SIG_UNBLOCK, &held, nullptr);
  done.set_value();
  other.join();
  sigaction(SIGTERM, &before, nullptr);
}

/// Signal to the process and its copy, as from Ctrl-C.
TEST_F(Rehearsal, EndsAtASignalToTheCopy) {
  const auto raise = [] { std::raise(SIGINT); };
  expectFailure(kLong, raise, ExitCode::kRuntimeFault, "the work: interrupted while it was tried out");
  EXPECT_THROW(rehearse("the work", kLong, never, raise), InterruptedCopy) << "callers tell it from other faults";
}

}  // namespace
}  // namespace pusht
