// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <tuple>
#include <vector>

#include "bindings.hpp"
#include "desk.hpp"
#include "pusht_task/error.hpp"
#include "python_policy.hpp"
#include "served_run.hpp"
#include "sim2sim_eval/policy_audit_run.hpp"

namespace sim2sim::python {
namespace {

namespace py = pybind11;

using Rows = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// Rows of an episode as arrays of fixed length. Throws InvalidInput unless all numbers are finite.
template <class Row>
std::vector<Row> rowsOf(const Rows& array, const std::string& what) {
  constexpr auto kColumns = static_cast<py::ssize_t>(std::tuple_size_v<Row>);
  if (array.ndim() != 2 || array.shape(1) != kColumns) {
    throw pusht::InvalidInput(what + " of shape " + std::string(py::str(array.attr("shape"))) + ": must be (n, " +
                              std::to_string(kColumns) + ")");
  }
  std::vector<Row> rows(static_cast<std::size_t>(array.shape(0)));
  for (std::size_t row = 0; row < rows.size(); ++row) {
    std::copy_n(array.data(static_cast<py::ssize_t>(row), 0), kColumns, rows[row].begin());
    if (!std::all_of(rows[row].begin(), rows[row].end(), [](float number) { return std::isfinite(number); })) {
      throw pusht::InvalidInput(what + ", row " + std::to_string(row) + ": all numbers must be finite");
    }
  }
  return rows;
}

std::vector<Demonstration> demonstrationsFrom(const std::vector<Rows>& observations, const std::vector<Rows>& actions) {
  if (observations.empty()) {
    throw pusht::InvalidInput("demonstrations: 0 episodes: must be at least 1");
  }
  std::vector<Demonstration> demonstrations;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const std::string episode = "episode " + std::to_string(i);
    demonstrations.push_back({rowsOf<pusht::Observation>(observations[i], episode + ": observations"),
                              rowsOf<pusht::Action>(actions[i], episode + ": actions")});
    const Demonstration& demonstration = demonstrations.back();
    if (demonstration.actions.size() != demonstration.observations.size() || demonstration.actions.empty()) {
      throw pusht::InvalidInput(episode + ": " + std::to_string(demonstration.observations.size()) +
                                " observations and " + std::to_string(demonstration.actions.size()) +
                                " actions: must be as many, at least 1");
    }
  }
  return demonstrations;
}

PolicyAuditRun auditCallable(Desk& desk, const std::string& name, const PolicySignature& interface,
                             const std::vector<Demonstration>& demonstrations) {
  requireNoMemoryOfItsOwn(desk, name, interface.observations, pusht::fullCircle());
  PolicySignature signature = interface;
  signature.actions = actionsInAnswer(desk, signature.observations);
  PythonPolicy asked(desk, signature.observations);
  PolicyAuditRun run;
  run.policy = "python:" + name;
  run.audit = auditNamedPolicy(asked, name, signature, demonstrations);
  return run;
}

py::dict auditInPython(const py::object& policy, const std::string& name, int history,
                       const std::vector<Rows>& observations, const std::vector<Rows>& actions,
                       const std::string& label) {
  const std::vector<Demonstration> demonstrations = demonstrationsFrom(observations, actions);
  ServedRun served("audit_policy");
  PolicyAuditRun run;
  if (policy.is_none()) {
    served.run([&] { run = auditPolicyFile(name, demonstrations); });
  } else {
    PolicySignature interface;
    interface.observations = std::max(history, 1);
    interface.has_state = py::hasattr(policy, "begin") && py::hasattr(policy, "act");
    Desk& desk = served.deskOf(Callable(policy, name, history));
    served.run([&] { run = auditCallable(desk, name, interface, demonstrations); });
  }
  run.demonstrations = label;
  py::dict answer;
  answer["json"] = run.json();
  answer["text"] = run.text();
  answer["fault"] = run.audit.fault();
  return answer;
}

template <class Row>
Rows arrayOf(const std::vector<Row>& rows) {
  Rows array({static_cast<py::ssize_t>(rows.size()), static_cast<py::ssize_t>(std::tuple_size_v<Row>)});
  float* number = array.mutable_data();
  for (const Row& row : rows) {
    number = std::copy(row.begin(), row.end(), number);
  }
  return array;
}

py::tuple readFile(const std::string& path) {
  py::list observations;
  py::list actions;
  for (const Demonstration& demonstration : readDemonstrations(path)) {
    observations.append(arrayOf(demonstration.observations));
    actions.append(arrayOf(demonstration.actions));
  }
  return py::make_tuple(observations, actions);
}

}  // namespace

void bindAuditPolicy(py::module_& module) {
  module.def("audit_policy", auditInPython, py::arg("policy"), py::arg("name"), py::arg("history"),
             py::arg("observations"), py::arg("actions"), py::arg("label"));
  module.def("read_demonstrations", readFile, py::arg("path"));
}

}  // namespace sim2sim::python
