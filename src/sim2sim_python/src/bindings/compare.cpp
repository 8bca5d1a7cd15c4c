// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "arguments.hpp"
#include "bindings.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/json_text.hpp"
#include "python_policy.hpp"
#include "python_world.hpp"
#include "served_run.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/batch/comparison.hpp"
#include "sim2sim_protocol/results/episodes_csv.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/run_results.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_protocol/results/table.hpp"

namespace sim2sim::python {
namespace {

namespace py = pybind11;

/// A callable of Python as compare() of the package describes it.
struct CallablePolicy {
  py::object policy;    ///< None: the policy is one of the suite, by its name
  std::string name;     ///< for people: "examples.charge"
  std::string version;  ///< empty: none
  int history = 0;
  py::object sight{};  ///< None: it sees what policies of files see
  std::string seen{};  ///< what it sees then: "pixels 96 x 96"
};

/// The callable as the run's policy, once it has shown that it has no memory of its own.
pusht::ChosenPolicy chosenFrom(const CallablePolicy& callable, Desk& desk) {
  const py::object python = py::module_::import("platform").attr("python_version")();
  nlohmann::json identity = {{"python", callable.name}, {"version", callable.version}, {"history", callable.history}};
  nlohmann::json provenance = {
      {"runs_on", "Python " + std::string(py::str(python))},
      {"callable", callable.name},
      {"history", callable.history},
      {"version", callable.version.empty() ? nlohmann::json() : nlohmann::json(callable.version)},
      {"note", "a Python callable: known by its name and version, not by its code"}};
  if (!callable.seen.empty()) {
    identity["sees"] = callable.seen;
    provenance["sees"] = callable.seen;
  }
  const int history = std::max(callable.history, 1);
  return {[&desk, history] { return std::make_unique<PythonPolicy>(desk, history); },
          "python:" + callable.name,
          identity,
          provenance,
          {},
          ""};
}

/// Throws InvalidInput if `options` ask for what cannot be with a Python callable.
void requireFitting(const CompareOptions& options, const CallablePolicy& callable) {
  if (callable.policy.is_none()) {
    return;
  }
  const std::string& task = options.protocol.runTask().name;
  if (!callable.sight.is_none() && task != pusht::gymPusht().name) {
    throw pusht::InvalidInput("obs_type " + callable.seen + ": must be left out in the task " + task +
                              ", as it is of " + pusht::gymPusht().name);
  }
  if (options.smoke) {
    throw pusht::InvalidInput("smoke: must be left out: it runs an untrained policy, and none of Python");
  }
  if (!options.batch.reference_cache.empty() && callable.version.empty()) {
    throw pusht::InvalidInput("reference_cache " + options.batch.reference_cache +
                              ": must be left out without a version of the policy: a Python callable is known by its "
                              "name and version, not by its code");
  }
}

/// Simulators of Python, which choices find by name while these live. With the GIL, at their end, too.
using Lent = std::vector<std::shared_ptr<const ForeignKind>>;

Lent lend(const py::list& simulators, Desk& desk) {
  Lent lent;
  for (const py::handle& worlds : simulators) {
    lent.push_back(sim2sim::lend(kindOf(py::reinterpret_borrow<py::object>(worlds), desk)));
  }
  return lent;
}

/// Results as Python takes them: the texts of their files.
py::dict textsOf(const ComparisonResults& results, const std::string& text) {
  py::dict answer;
  answer["episodes"] = episodesCsv(results.configuration.protocol, results.episodes);
  answer["metrics"] = jsonText(results.metrics);
  answer["provenance"] = jsonText(results.provenance);
  answer["text"] = text;
  answer["folder"] = results.folder.string();
  return answer;
}

py::dict compareInPython(const py::dict& keywords, const py::object& policy, const std::string& name,
                         const std::string& version, int history, const py::object& sight, const std::string& seen,
                         const py::list& simulators, bool progress) {
  CompareOptions options;
  CLI::App app("", "compare");
  options.declare(app);
  parseArguments(app, argumentsOf(app, keywords));
  const CallablePolicy callable = {policy, name, version, history, sight, seen};
  requireFitting(options, callable);
  for (std::string* const written : {&options.out, &options.write_starts}) {
    if ((!policy.is_none() || !simulators.empty()) && !written->empty()) {  // what Python runs may change folders
      *written = std::filesystem::absolute(*written).string();
    }
  }
  ServedRun served("compare");
  const Lent lent = lend(simulators, served.desk());
  std::ostringstream text;
  ComparisonHost host;
  host.out = &text;
  host.progress = progress;
  host.files = !options.out.empty();
  if (!policy.is_none()) {
    Desk& desk = served.deskOf(Callable(policy, name, history, sight));
    host.can_return = !version.empty();
    const pusht::Task& task = options.protocol.runTask();
    host.choose_policy = [&desk, &task, name, history, chosen = chosenFrom(callable, desk)] {
      requireNoMemoryOfItsOwn(desk, name, std::max(history, 1), task);
      return chosen;
    };
  }
  host.can_return = host.can_return && std::none_of(lent.begin(), lent.end(), [](const auto& simulator) {
                      return simulator->kind.version.empty();
                    });
  std::optional<ComparisonResults> results;
  served.run([&] { results = compare(options, host); });
  return textsOf(*results, text.str());
}

RunConfiguration configurationOf(const RunResults& run) {
  RunConfiguration configuration;
  configuration.protocol = run.protocol;
  run.metrics.at("policy").get_to(configuration.policy);
  run.metrics.at("smoke").get_to(configuration.smoke);
  configuration.reference = simulatorFrom(run.metrics.at("simulators").at("reference"));
  configuration.engine = simulatorFrom(run.metrics.at("simulators").at("engine"));
  return configuration;
}

/// Results of a run, or of a row of a sweep, from their folder; `provenance` is that of the run or the sweep.
py::dict loadInPython(const std::string& folder, const std::string& provenance) {
  const RunResults run = readResults(folder);
  const RunConfiguration configuration = configurationOf(run);
  const auto origin = pusht::parseOrderedJson(pusht::readFile(provenance, "results"));
  return textsOf({configuration, run.episodes, run.metrics, origin, run.folder},
                 table(configuration, summarize(run.protocol, run.episodes)));
}

}  // namespace

void bindCompare(py::module_& module) {
  module.def("compare", compareInPython, py::arg("options"), py::arg("policy"), py::arg("name"), py::arg("version"),
             py::arg("history"), py::arg("sight"), py::arg("seen"), py::arg("simulators"), py::arg("progress"));
  module.def("load", loadInPython, py::arg("folder"), py::arg("provenance"));
}

}  // namespace sim2sim::python
