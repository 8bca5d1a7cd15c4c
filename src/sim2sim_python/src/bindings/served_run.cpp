// SPDX-License-Identifier: BSD-3-Clause
#include "served_run.hpp"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <future>
#include <mutex>

#include "pusht_task/error.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "without_gil.hpp"

namespace sim2sim::python {
namespace {

namespace py = pybind11;

/// Time between two looks at the signals that Python has got, while no query comes.
constexpr std::chrono::milliseconds kSignalPeriod{50};

/// Time for a run to end with the interpreter; its callable may not return.
constexpr std::chrono::seconds kLeavingPatience{10};

/// Whether a run is under way in this process, and whether the interpreter ends.
struct Runs {
  std::mutex mutex;
  std::condition_variable changed;
  bool is_running = false;
  std::atomic<bool> is_leaving = false;
};

Runs& runs() {
  static Runs runs;
  return runs;
}

/// The right to run, to take the warnings of the process, and to be interrupted. Throws InvalidInput if another run has
/// it.
class OneRun {
 public:
  OneRun(const std::string& command, std::function<void(const std::string&)> take_warning) {
    const std::lock_guard<std::mutex> lock(runs().mutex);
    if (runs().is_running) {
      throw pusht::InvalidInput(command +
                                ": another command runs already in this process; must not be called beside it");
    }
    runs().is_running = true;
    interrupt(false);
    sendWarningsTo(std::move(take_warning));
  }
  OneRun(const OneRun&) = delete;
  OneRun& operator=(const OneRun&) = delete;
  ~OneRun() {
    sendWarningsTo({});
    const std::lock_guard<std::mutex> lock(runs().mutex);
    runs().is_running = false;
    runs().changed.notify_all();
  }
};

void carryOut(Call& call) {
  try {
    call.work();
  } catch (const pusht::Error&) {
    call.error = std::current_exception();
  }
}

/// Ends the run of a daemon thread before the interpreter ends: later, a thread that wants the GIL is killed within
/// C++.
void leave() {
  {
    const py::gil_scoped_release released;
    runs().is_leaving = true;
    std::unique_lock<std::mutex> lock(runs().mutex);
    runs().changed.wait_for(lock, kLeavingPatience, [] { return !runs().is_running; });
  }
  endWithoutGil();
}

}  // namespace

Desk& ServedRun::deskOf(Callable callable) {
  callable_.emplace(std::move(callable));
  return desk_;
}

void ServedRun::run(const std::function<void()>& work) {
  const OneRun one_run(command_, [this](const std::string& warning) { desk_.warn(warning); });
  std::future<void> run = std::async(std::launch::async, [&] { workAside(work); });
  serve();
  {
    const py::gil_scoped_release released;
    run.wait();
  }
  desk_.releaseDropped();
  if (raised_) {
    std::rethrow_exception(raised_);
  }
  if (failure_) {
    std::rethrow_exception(failure_);
  }
}

void ServedRun::workAside(const std::function<void()>& work) {
  try {
    work();
  } catch (...) {
    failure_ = std::current_exception();
  }
  desk_.end();
}

void ServedRun::serve() {
  for (bool ended = false; !ended;) {
    Desk::Work work;
    {
      const py::gil_scoped_release released;
      work = desk_.wait(kSignalPeriod);
    }
    ended = work.ended;
    try {
      if (PyErr_CheckSignals() != 0) {
        throw py::error_already_set();
      }
      if (runs().is_leaving) {
        throw pusht::RuntimeFault(command_ + ": the interpreter ends");
      }
      for (const std::string& warning : work.warnings) {
        if (PyErr_WarnEx(PyExc_RuntimeWarning, warning.c_str(), 2) != 0) {
          throw py::error_already_set();
        }
      }
      desk_.releaseDropped();
      answer(work);
    } catch (...) {  // not the callable's: a signal's, mostly
      interruptRun();
    }
  }
}

void ServedRun::answer(const Desk::Work& work) {
  std::string asked;  // what Python runs now
  try {
    for (Call* call : work.calls) {
      asked = call->name;
      carryOut(*call);
    }
    if (!work.rows.empty()) {
      asked = "policy " + callable_->name();
      callable_->answer(work.rows);
    }
    desk_.answered();
  } catch (const pusht::Error&) {
    desk_.refuse(std::current_exception());
  } catch (const py::error_already_set& error) {
    if (error.matches(PyExc_KeyboardInterrupt)) {
      throw;
    }
    raised_ = raised_ ? raised_ : std::current_exception();
    const std::string text = error.what();  // a traceback may follow
    desk_.close(asked + ": raised " + text.substr(0, text.find('\n')));
  }
}

void ServedRun::interruptRun() {
  raised_ = raised_ ? raised_ : std::current_exception();
  interrupt(true);
  desk_.close("interrupted");
}

void endRunsAtExit() { py::module_::import("atexit").attr("register")(py::cpp_function(leave)); }

}  // namespace sim2sim::python
