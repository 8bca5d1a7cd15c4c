// SPDX-License-Identifier: BSD-3-Clause
/// Runs of the suite within a program in Python.
#pragma once

#include <pybind11/pybind11.h>

#include <exception>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "desk.hpp"
#include "python_policy.hpp"

namespace sim2sim::python {

/// Run of a command in a thread of its own, and its service in the thread that called Python: signals, warnings, and
/// the answers of a callable. One at a time in a process.
class ServedRun {
 public:
  /// `command` names the run in messages: "compare".
  explicit ServedRun(std::string command) : command_(std::move(command)) {}

  /// The desk at which the work calls Python.
  Desk& desk() { return desk_; }

  /// The desk, at which the work asks `callable`, too.
  Desk& deskOf(Callable callable);

  /// Runs `work`. Throws what it throws; what the callable raises, a warning that is an error, or a signal's exception,
  /// as itself.
  void run(const std::function<void()>& work);

 private:
  void workAside(const std::function<void()>& work);
  void serve();
  void answer(const Desk::Work& work);

  /// Ends the run because of the current exception.
  void interruptRun();

  std::string command_;
  std::optional<Callable> callable_;
  Desk desk_;
  std::exception_ptr raised_;
  std::exception_ptr failure_;
};

/// Ends the runs of daemon threads with the interpreter. To be called once.
void endRunsAtExit();

}  // namespace sim2sim::python
