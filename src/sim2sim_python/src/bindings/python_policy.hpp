// SPDX-License-Identifier: BSD-3-Clause
/// Policy that is a Python callable.
#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <string>
#include <vector>

#include "desk.hpp"
#include "pusht_task/policy.hpp"
#include "pusht_task/task.hpp"

namespace sim2sim::python {

/// Policy whose answers come from a desk. It keeps the history of each rollout, and asks
/// only when the actions of the last answer are used up.
class PythonPolicy : public pusht::Policy {
 public:
  /// `history`: number of observations that the callable looks back on, at least 1. The desk must outlive the policy
  /// and its memories.
  PythonPolicy(Desk& desk, int history) : desk_(desk), history_(history) {}

  std::unique_ptr<Memory> begin(const pusht::Beginning& beginning) const override;
  void act(pusht::Span<const Query> queries, pusht::Span<pusht::Action> actions) override;

 private:
  Desk& desk_;
  int history_;
};

/// Asks the desk's callable for the same rows three times: in order, in reverse, and a few of them. Throws
/// BadDependency unless each row gets the same answer, to within what rounding in other batches makes; also as
/// Desk::ask().
void requireNoMemoryOfItsOwn(Desk& desk, const std::string& name, int history, const pusht::Task& task);

/// Number of actions in an answer of the desk's callable. Throws as Desk::ask().
int actionsInAnswer(Desk& desk, int history);

/// Callable of Python that answers rows. All functions need the GIL.
class Callable {
 public:
  /// `policy` is a function of observations, or an object with begin() and act(). With `history` 0 an observation is
  /// a row of 10 numbers, otherwise [history, 10]. `name` stands in messages. With a `sight`, not None, observations
  /// are what that function makes of states in pixels, with kPixelNumbers in place of the 10 (pixel_worlds.hpp).
  Callable(pybind11::object policy, std::string name, int history, pybind11::object sight = pybind11::none());

  const std::string& name() const { return name_; }

  /// Asks the callable once for all rows. Throws BadDependency for an answer of the wrong type or shape, and what the
  /// callable raises.
  void answer(const std::vector<Row*>& rows) const;

 private:
  pybind11::object ask(const std::vector<Row*>& rows) const;
  pybind11::object observationsOf(const std::vector<Row*>& rows) const;

  /// Array [n, width], or with a history [n, history, width], of the numbers of all that the rows look back on.
  template <class Number, class Numbers>
  pybind11::array_t<Number> arrayOf(const std::vector<Row*>& rows, pybind11::ssize_t width,
                                    const Numbers& numbers) const;

  /// Throws BadDependency unless NumPy can make an array of it.
  pybind11::array arrayOf(const pybind11::object& answer) const;

  pybind11::object policy_;
  pybind11::object sight_;
  pybind11::object as_array_;  // of sim2sim.tensors
  std::string name_;
  int history_;
  bool has_memory_;
};

}  // namespace sim2sim::python
