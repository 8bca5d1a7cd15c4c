// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "bindings.hpp"
#include "pusht_policy/policy_choice.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/policy.hpp"
#include "sim2sim_serving/installed_file.hpp"
#include "without_gil.hpp"

namespace sim2sim::python {
namespace {

namespace py = pybind11;

/// Memory of a policy in one rollout, as an object of Python.
struct PolicyMemory {
  std::unique_ptr<pusht::Policy::Memory> memory;  // null: the policy has none
  std::shared_ptr<pusht::Policy> policy;          // which it must not outlive
};

/// Observations as Python gives them: any array of real numbers.
using Rows = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// Policy of the suite as a callable of Python.
class LoadedPolicy {
 public:
  LoadedPolicy(const std::string& name, bool require_policy, std::uint64_t untrained_seed, const std::string& task)
      : chosen_(choose(name, require_policy, untrained_seed, task)), policy_(chosen_.make()) {
    if (!chosen_.warning.empty() && PyErr_WarnEx(PyExc_RuntimeWarning, chosen_.warning.c_str(), 2) != 0) {
      throw py::error_already_set();
    }
  }

  PolicyMemory begin(std::uint64_t seed, int execute) const { return {policy_->begin({seed, execute}), policy_}; }

  py::array_t<float> act(const Rows& observations, const std::vector<PolicyMemory*>& memories) {
    const py::ssize_t count = rowsOf(observations);
    if (static_cast<py::ssize_t>(memories.size()) != count) {
      throw pusht::InvalidInput("memories: " + std::to_string(memories.size()) + " must be " + std::to_string(count) +
                                ", one for each row of the observations");
    }
    std::vector<pusht::Policy::Query> queries;
    for (py::ssize_t row = 0; row < count; ++row) {
      const PolicyMemory* const given = memories[static_cast<std::size_t>(row)];  // null: None
      if (given == nullptr || given->policy != policy_) {
        throw pusht::InvalidInput("memories: the one of row " + std::to_string(row) +
                                  " must be from begin() of this policy");
      }
      queries.push_back({observationIn(observations, row), given->memory.get()});
    }
    return answers(queries);
  }

  py::array_t<float> call(const Rows& observations) {
    if (policy_->begin({}) != nullptr) {
      throw pusht::InvalidInput("policy " + chosen_.name + ": has a memory; must be asked by begin() and act()");
    }
    std::vector<pusht::Policy::Query> queries;
    for (py::ssize_t row = 0; row < rowsOf(observations); ++row) {
      queries.push_back({observationIn(observations, row), nullptr});
    }
    return answers(queries);
  }

  const std::string& name() const { return chosen_.name; }
  std::string provenance() const { return chosen_.provenance.dump(); }

 private:
  static pusht::ChosenPolicy choose(const std::string& name, bool require_policy, std::uint64_t untrained_seed,
                                    const std::string& task) {
    try {
      return pusht::choosePolicy({name, require_policy, untrained_seed, false, pusht::taskNamed(task)},
                                 pusht::installedFile("pusht_policy", pusht::kShippedCheckpoint));
    } catch (const pusht::Error&) {
      if (PyErr_CheckSignals() != 0) {  // a signal breaks off the loading
        throw py::error_already_set();
      }
      throw;
    }
  }

  static py::ssize_t rowsOf(const Rows& observations) {
    if (observations.ndim() != 2 || observations.shape(1) != kNumbers) {
      throw pusht::InvalidInput("observations of shape " + std::string(py::str(observations.attr("shape"))) +
                                ": must be (n, " + std::to_string(kNumbers) + ")");
    }
    return observations.shape(0);
  }

  static pusht::Observation observationIn(const Rows& observations, py::ssize_t row) {
    pusht::Observation observation{};
    std::copy_n(observations.data(row, 0), kNumbers, observation.begin());
    return observation;
  }

  py::array_t<float> answers(const std::vector<pusht::Policy::Query>& queries) {
    std::vector<pusht::Action> actions(queries.size());
    if (!queries.empty()) {
      const WithoutGil released;
      const std::lock_guard<std::mutex> lock(mutex_);
      policy_->act(queries, actions);
    }
    py::array_t<float> rows({static_cast<py::ssize_t>(actions.size()), kAxes});
    float* number = rows.mutable_data();
    for (const pusht::Action& action : actions) {
      number = std::copy(action.begin(), action.end(), number);
    }
    return rows;
  }

  pusht::ChosenPolicy chosen_;
  std::shared_ptr<pusht::Policy> policy_;
  std::mutex mutex_;  // another thread of Python may call it, too
};

}  // namespace

void bindLoadedPolicy(py::module_& module) {
  const py::class_<PolicyMemory> memory(module, "PolicyMemory");
  py::class_<LoadedPolicy>(module, "LoadedPolicy")
      .def(py::init<const std::string&, bool, std::uint64_t, const std::string&>(), py::arg("name"),
           py::arg("require_policy"), py::arg("untrained_seed"), py::arg("task"))
      .def("begin", &LoadedPolicy::begin, py::arg("seed"), py::arg("execute"))
      .def("act", &LoadedPolicy::act, py::arg("observations"), py::arg("memories"))
      .def("__call__", &LoadedPolicy::call, py::arg("observations"))
      .def_property_readonly("name", &LoadedPolicy::name)
      .def_property_readonly("provenance", &LoadedPolicy::provenance);
}

}  // namespace sim2sim::python
