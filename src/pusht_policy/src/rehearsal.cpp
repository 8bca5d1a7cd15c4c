// SPDX-License-Identifier: BSD-3-Clause
#include "rehearsal.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <system_error>

#include "pusht_task/ending_signals.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/reason.hpp"

namespace pusht {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kStopPeriod{100};

/// Blocks the ending signals in this thread while it exists. A wait with mask() unblocks them, so no signal is lost
/// between two waits.
class SignalsHeld {
 public:
  SignalsHeld() {
    sigset_t held;
    sigemptyset(&held);
    for (const int number : kEndingSignals) {
      sigaddset(&held, number);
    }
    pthread_sigmask(SIG_BLOCK, &held, &mask_);
  }
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;
  ~SignalsHeld() { pthread_sigmask(SIG_SETMASK, &mask_, nullptr); }

  const sigset_t& mask() const { return mask_; }

 private:
  sigset_t mask_{};
};

[[noreturn]] void throwSystemError(const std::string& what) {
  throw RuntimeFault(what + ": " + std::generic_category().message(errno));
}

bool is_copy = false;  // whether this process is one

/// Verdict of the copy: the exit code in the first byte, then the message.
std::string verdictOf(const std::function<void()>& work) {
  try {
    work();
    return {static_cast<char>(ExitCode::kOk)};
  } catch (const std::exception& error) {
    return static_cast<char>(exitCodeOf(error)) + reasonOf(error);
  }
}

/// The life of the copy. It leaves no core, says nothing, ends at a signal, and does not outlive its parent.
[[noreturn]] void perform(const std::function<void()>& work, pid_t parent, const sigset_t& mask, int output) {
  for (const int number : kEndingSignals) {
    std::signal(number, SIG_DFL);
  }
  pthread_sigmask(SIG_SETMASK, &mask, nullptr);
  is_copy = true;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) {
    _exit(EXIT_FAILURE);
  }
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  const std::string verdict = verdictOf(work);
  for (std::size_t done = 0; done < verdict.size();) {
    const ssize_t count = ::write(output, verdict.data() + done, verdict.size() - done);
    if (count <= 0) {
      _exit(EXIT_FAILURE);
    }
    done += static_cast<std::size_t>(count);
  }
  _exit(EXIT_SUCCESS);
}

/// A copy of this process that does some work.
class Copy {
 public:
  Copy(const std::string& what, const std::function<void()>& work) : what_(what) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) {
      throwSystemError(what + ": cannot be tried out: pipe");
    }
    input_ = ends[0];
    const pid_t parent = getpid();
    process_ = fork();
    if (process_ == 0) {
      perform(work, parent, signals_.mask(), ends[1]);
    }
    close(ends[1]);
    if (process_ < 0) {
      close(input_);
      throwSystemError(what + ": cannot be tried out: fork");
    }
  }
  Copy(const Copy&) = delete;
  Copy& operator=(const Copy&) = delete;
  ~Copy() {
    close(input_);
    if (process_ > 0) {
      kill(process_, SIGKILL);
      waitForEnd();
    }
  }

  /// Output of the copy until it ends.
  std::string verdict(std::chrono::milliseconds deadline, const std::function<bool()>& stop) {
    const Clock::time_point end = Clock::now() + deadline;
    std::string text;
    std::array<char, 4096> buffer{};
    for (;;) {
      waitForInput(end, deadline, stop);
      const ssize_t count = read(input_, buffer.data(), buffer.size());
      if (count < 0) {
        throwSystemError(what_ + ": cannot be tried out: read");
      }
      if (count == 0) {
        return text;
      }
      text.append(buffer.data(), static_cast<std::size_t>(count));
    }
  }

  /// The signal that ended it, or 0.
  int signalAtEnd() {
    const int status = waitForEnd();
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  }

 private:
  void waitForInput(Clock::time_point end, std::chrono::milliseconds deadline,
                    const std::function<bool()>& stop) const {
    for (;;) {
      const std::chrono::nanoseconds left = std::max<std::chrono::nanoseconds>(end - Clock::now(), {});
      const timespec timeout{0, std::min<std::chrono::nanoseconds>(left, kStopPeriod).count()};
      pollfd input{input_, POLLIN, 0};
      const int ready = ppoll(&input, 1, &timeout, &signals_.mask());
      if (ready > 0) {
        return;
      }
      if (ready < 0 && errno != EINTR) {
        throwSystemError(what_ + ": cannot be tried out: poll");
      }
      if (ready < 0 || stop()) {
        throw InterruptedCopy(what_ + ": interrupted while it was tried out");
      }
      if (left.count() == 0) {
        throw RuntimeFault(what_ + ": must load and act within " +
                           std::to_string(std::chrono::duration_cast<std::chrono::seconds>(deadline).count()) +
                           " s, but does not return");
      }
    }
  }

  int waitForEnd() {
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
    return status;
  }

  SignalsHeld signals_;
  std::string what_;
  int input_ = -1;
  pid_t process_ = -1;
};

}  // namespace

void rehearse(const std::string& what, std::chrono::milliseconds deadline, const std::function<bool()>& stop,
              const std::function<void()>& work) {
  if (is_copy) {
    return work();
  }
  Copy copy(what, work);
  const std::string verdict = copy.verdict(deadline, stop);
  const int signal = copy.signalAtEnd();
  if (std::count(kEndingSignals.begin(), kEndingSignals.end(), signal) != 0) {
    throw InterruptedCopy(what + ": interrupted while it was tried out");
  }
  if (signal != 0 || verdict.empty()) {
    throw CrashedCopy(
        what + ": must not crash libtorch, but does: " + (signal != 0 ? strsignal(signal) : "it ended the process"));
  }
  const auto exit_code = static_cast<ExitCode>(verdict.front());
  if (exit_code != ExitCode::kOk) {
    throw Error(exit_code, verdict.substr(1));
  }
}

}  // namespace pusht
