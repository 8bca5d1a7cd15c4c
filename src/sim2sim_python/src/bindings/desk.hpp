// SPDX-License-Identifier: BSD-3-Clause
/// Where the threads of a run, which have no GIL, meet the thread that called Python.
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "pusht_task/gym_pusht.hpp"
#include "pusht_task/policy.hpp"

namespace sim2sim::python {

/// What a policy sees in a control step.
struct Glimpse {
  pusht::Observation observation{};
  std::optional<pusht::gym_pusht::State>
      in_pixels{};  ///< read in gym-pusht's task alone; none if the query has no state
};

/// Row of a query: a rollout in which the callable is asked for a new answer.
struct Row {
  std::uint64_t seed = 0;               ///< of the rollout
  std::vector<Glimpse> past{};          ///< what the callable looks back on, oldest first
  std::vector<pusht::Action> answer{};  ///< its last answer, one action a control step
  PyObject* memory = nullptr;           ///< the callable's own; owned, null before the first query
};

/// Call of something of Python other than the policy: a world's step.
struct Call {
  std::string name;  ///< of what is called, for messages
  const std::function<void()>& work;
  std::exception_ptr error{};  ///< pusht::Error that the work has thrown
};

/// Desk at which threads of a run ask, and one thread, which may call Python, answers. So the callable runs in the
/// thread in which the command was called: Ctrl-C reaches it, and settings that belong to a thread (torch.no_grad)
/// hold. While the callable runs, further queries gather; the next call answers them all.
class Desk {
 public:
  /// What there is to do.
  struct Work {
    std::vector<Row*> rows{};             ///< to be answered; answered() must follow
    std::vector<Call*> calls{};           ///< likewise
    std::vector<std::string> warnings{};  ///< that came up meanwhile
    bool ended = false;                   ///< the run is over: there will be no more
  };

  /// Waits until all `rows` are answered. Throws RuntimeFault with the reason if the desk is closed, and what the
  /// answering thread found wrong. For threads of the run.
  void ask(const std::vector<Row*>& rows);

  /// Waits until the answering thread has run `work`, which may call Python. Throws RuntimeFault with the reason if the
  /// desk is closed, and the Error that the work throws. `name` says in messages what raised. For threads of the run.
  void call(const std::string& name, const std::function<void()>& work);

  /// Keeps the reference until releaseDropped(): only a thread with the GIL may give it up.
  void drop(PyObject* memory);

  void warn(const std::string& warning);

  /// Tells that the run is over.
  void end();

  /// Waits for work, not longer than `patience`. For the answering thread, without the GIL.
  Work wait(std::chrono::milliseconds patience);

  /// Gives the rows of the last wait() back to the threads that asked.
  void answered();

  /// Answers all queries, present and future, with RuntimeFault.
  void close(const std::string& reason);

  /// Answers the rows of the last wait() with an error of the callable's answer.
  void refuse(std::exception_ptr error);

  /// Lets go of the memories that were dropped. With the GIL.
  void releaseDropped();

 private:
  struct Query {
    const std::vector<Row*>* rows;  // null: a call
    Call* call = nullptr;
    bool answered = false;
    std::exception_ptr error{};
  };

  void ask(Query query);
  void finish(const std::exception_ptr& error);

  std::mutex mutex_;
  std::condition_variable work_;
  std::condition_variable answers_;
  std::vector<Query*> waiting_;
  std::vector<Query*> in_hand_;
  std::vector<PyObject*> dropped_;
  std::vector<std::string> warnings_;
  std::optional<std::string> closed_;
  bool ended_ = false;
};

}  // namespace sim2sim::python
