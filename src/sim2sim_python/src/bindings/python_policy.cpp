// SPDX-License-Identifier: BSD-3-Clause
#include "python_policy.hpp"

#include <pybind11/numpy.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <utility>

#include "bindings.hpp"
#include "pixel_worlds.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"

namespace sim2sim::python {
namespace {

namespace py = pybind11;

/// Memory of a rollout: what the callable is asked with, and the actions of its last answer that are left.
struct RolloutMemory : pusht::Policy::Memory {
  RolloutMemory(Desk& desk_of_run, const pusht::Beginning& beginning) : desk(desk_of_run), told(beginning) {
    row.seed = beginning.seed;
  }
  RolloutMemory(const RolloutMemory&) = delete;
  RolloutMemory& operator=(const RolloutMemory&) = delete;
  ~RolloutMemory() override {
    if (row.memory != nullptr) {
      desk.drop(row.memory);
    }
  }

  void see(const Glimpse& glimpse, std::size_t history) {
    if (row.past.empty()) {
      row.past.assign(history, glimpse);
      return;
    }
    std::rotate(row.past.begin(), row.past.begin() + 1, row.past.end());
    row.past.back() = glimpse;
  }

  Desk& desk;
  pusht::Beginning told;
  Row row;
  std::size_t next = 0;  // action of the answer
  std::size_t left = 0;  // actions of it that are still executed
};

/// Rows that a callable is tried out with: as many observations as it looks back on, from spawns, each another one.
std::vector<std::unique_ptr<RolloutMemory>> trialRows(Desk& desk, int history, const pusht::Task& task) {
  constexpr std::uint64_t kRows = 8;
  std::vector<std::unique_ptr<RolloutMemory>> rows;
  for (std::uint64_t number = 0; number < kRows; ++number) {
    rows.push_back(std::make_unique<RolloutMemory>(desk, pusht::Beginning{number}));
    for (int past = 0; past < history; ++past) {
      const pusht::WorldState start = pusht::spawn(number + kRows * static_cast<std::uint64_t>(past), task);
      rows.back()->see({pusht::observe(start, task), pusht::gym_pusht::fromTable(start)},
                       static_cast<std::size_t>(history));
    }
  }
  return rows;
}

/// Rows of the memories from `first`, until before `last`.
template <class Iterator>
std::vector<Row*> rowsOf(Iterator first, Iterator last) {
  std::vector<Row*> rows;
  std::transform(first, last, std::back_inserter(rows), [](const auto& memory) { return &memory->row; });
  return rows;
}

/// Whether two answers are the same but for the rounding of another batch.
bool isAlike(const std::vector<pusht::Action>& one, const std::vector<pusht::Action>& other, const pusht::Task& task) {
  const double rounding = 1e-3 * pusht::actionPerSpeed(task);
  const auto alike = [&](float a, float b) {
    return static_cast<double>(std::abs(a - b)) <= rounding ||
           (!std::isfinite(a) && !std::isfinite(b));  // refused where it is executed
  };
  return std::equal(
      one.begin(), one.end(), other.begin(), other.end(),
      [&](const pusht::Action& a, const pusht::Action& b) { return std::equal(a.begin(), a.end(), b.begin(), alike); });
}

RolloutMemory& memoryOf(const pusht::Policy::Query& query) { return static_cast<RolloutMemory&>(*query.memory); }

Glimpse glimpseOf(const pusht::Policy::Query& query) {
  if (query.state_in_pixels != nullptr) {
    return {query.observation, *query.state_in_pixels};
  }
  return {query.observation,
          query.state == nullptr ? std::nullopt : std::optional(pusht::gym_pusht::fromTable(*query.state))};
}

std::string shapeOf(const py::array& array) { return py::str(array.attr("shape")); }

}  // namespace

std::unique_ptr<pusht::Policy::Memory> PythonPolicy::begin(const pusht::Beginning& beginning) const {
  return std::make_unique<RolloutMemory>(desk_, beginning);
}

void PythonPolicy::act(pusht::Span<const Query> queries, pusht::Span<pusht::Action> actions) {
  std::vector<Row*> rows;
  std::vector<RolloutMemory*> asking;
  for (const Query& query : queries) {
    RolloutMemory& memory = memoryOf(query);
    memory.see(glimpseOf(query), static_cast<std::size_t>(history_));
    if (memory.left == 0) {
      rows.push_back(&memory.row);
      asking.push_back(&memory);
    }
  }
  if (!rows.empty()) {
    desk_.ask(rows);
  }
  for (RolloutMemory* memory : asking) {
    requireExecutable(memory->told, static_cast<int>(memory->row.answer.size()));
    memory->next = 0;
    memory->left =
        memory->told.execute > 0 ? static_cast<std::size_t>(memory->told.execute) : memory->row.answer.size();
  }
  for (std::size_t i = 0; i < queries.size(); ++i) {
    RolloutMemory& memory = memoryOf(queries[i]);
    actions[i] = memory.row.answer[memory.next++];
    --memory.left;
  }
}

void requireNoMemoryOfItsOwn(Desk& desk, const std::string& name, int history, const pusht::Task& task) {
  constexpr std::ptrdiff_t kFew = 3;
  const auto in_order = trialRows(desk, history, task);
  const auto in_reverse = trialRows(desk, history, task);
  const auto few = trialRows(desk, history, task);
  desk.ask(rowsOf(in_order.begin(), in_order.end()));
  const auto require_same = [&](const auto& memories, std::ptrdiff_t count, const char* when) {
    for (std::size_t row = 0; row < static_cast<std::size_t>(count); ++row) {
      if (!isAlike(memories[row]->row.answer, in_order[row]->row.answer, task)) {
        throw pusht::BadDependency(
            "policy " + name + ": answers the same observation with another action " + when +
            ": it has a memory or random numbers of its own, or mixes rows; give an object with begin(seed) and "
            "act(observations, memories), or answer with chunks (n, K, 2)");
      }
    }
  };
  desk.ask(rowsOf(in_reverse.rbegin(), in_reverse.rend()));
  require_same(in_reverse, static_cast<std::ptrdiff_t>(in_reverse.size()), "when the rows come again in another order");
  desk.ask(rowsOf(few.begin(), few.begin() + kFew));
  require_same(few, kFew, "beside other rows");
}

int actionsInAnswer(Desk& desk, int history) {
  const std::vector<std::unique_ptr<RolloutMemory>> rows = trialRows(desk, history, pusht::fullCircle());
  desk.ask({&rows.front()->row});
  return static_cast<int>(rows.front()->row.answer.size());
}

Callable::Callable(py::object policy, std::string name, int history, py::object sight)
    : policy_(std::move(policy)),
      sight_(std::move(sight)),
      as_array_(py::module_::import("sim2sim.tensors").attr("as_array")),
      name_(std::move(name)),
      history_(history),
      has_memory_(py::hasattr(policy_, "begin") && py::hasattr(policy_, "act")) {}

py::array Callable::arrayOf(const py::object& answer) const {
  try {
    return as_array_(answer);
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_ValueError) && !error.matches(PyExc_TypeError)) {
      throw;
    }
    throw pusht::BadDependency("policy " + name_ + ": answered a " + std::string(py::str(py::type::of(answer))) +
                               " that is no array: " + std::string(py::str(error.value())));
  }
}

template <class Number, class Numbers>
py::array_t<Number> Callable::arrayOf(const std::vector<Row*>& rows, py::ssize_t width, const Numbers& numbers) const {
  std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(rows.size()), width};
  if (history_ > 0) {
    shape.insert(shape.begin() + 1, history_);
  }
  py::array_t<Number> array(shape);  // a new one each time: the callable may keep it
  Number* number = array.mutable_data();
  for (const Row* row : rows) {
    for (const Glimpse& glimpse : row->past) {
      const auto values = numbers(glimpse);
      number = std::copy(values.begin(), values.end(), number);
    }
  }
  return array;
}

py::object Callable::observationsOf(const std::vector<Row*>& rows) const {
  if (sight_.is_none()) {
    return arrayOf<float>(rows, kNumbers, [](const Glimpse& glimpse) { return glimpse.observation; });
  }
  return sight_(arrayOf<double>(rows, kPixelNumbers, [](const Glimpse& glimpse) {
    if (!glimpse.in_pixels) {
      throw pusht::InternalError("a policy that sees states must be asked with them");
    }
    return numbersInPixels(*glimpse.in_pixels);
  }));
}

py::object Callable::ask(const std::vector<Row*>& rows) const {
  const py::object observations = observationsOf(rows);
  if (!has_memory_) {
    return policy_(observations);
  }
  py::list memories;
  for (Row* row : rows) {
    if (row->memory == nullptr) {
      row->memory = policy_.attr("begin")(row->seed).release().ptr();
    }
    memories.append(py::reinterpret_borrow<py::object>(row->memory));
  }
  return policy_.attr("act")(observations, memories);
}

void Callable::answer(const std::vector<Row*>& rows) const {
  const auto count = static_cast<py::ssize_t>(rows.size());
  const py::array answered = arrayOf(ask(rows));
  const char kind = answered.dtype().kind();
  const bool is_real = kind == 'f' && (answered.itemsize() == sizeof(float) || answered.itemsize() == sizeof(double));
  const bool has_steps = answered.ndim() == 3;
  if (!is_real || (answered.ndim() != 2 && !has_steps) || answered.shape(0) != count ||
      answered.shape(answered.ndim() - 1) != kAxes || answered.size() == 0) {
    const std::string n = std::to_string(count);
    throw pusht::BadDependency("policy " + name_ + ": answered " + std::string(py::str(answered.dtype())) +
                               " of shape " + shapeOf(answered) + ": must be float32 (or float64) of shape (" + n +
                               ", 2), or (" + n + ", K, 2) for K control steps");
  }
  const py::array_t<float, py::array::c_style | py::array::forcecast> actions(answered);
  const auto steps = static_cast<std::size_t>(has_steps ? answered.shape(1) : 1);
  const float* number = actions.data();
  for (Row* row : rows) {
    row->answer.resize(steps);
    for (pusht::Action& action : row->answer) {
      std::copy_n(number, kAxes, action.begin());
      number += kAxes;
    }
  }
}

}  // namespace sim2sim::python
