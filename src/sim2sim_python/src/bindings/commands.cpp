// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "arguments.hpp"
#include "bindings.hpp"
#include "served_run.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_protocol/results/json.hpp"

namespace sim2sim::python {
namespace {

namespace py = pybind11;

/// Runs a command with these options, and returns what it prints and its figures, in JSON.
py::dict runInPython(const std::string& name, const py::dict& options, bool progress) {
  static const std::map<std::string, Command> commands = {
      {"contrast", contrastCommand}, {"matrix", matrixCommand}, {"plan", planCommand}, {"sweep", sweepCommand}};
  CLI::App app("", name);
  const CommandWork work = commands.at(name)(app);
  parseArguments(app, argumentsOf(app, options));
  std::ostringstream text;
  CommandHost host;
  host.out = &text;
  host.progress = progress;
  nlohmann::json figures;
  ServedRun(name).run([&] { figures = work(host); });
  py::dict answer;
  answer["text"] = text.str();
  answer["figures"] = jsonText(figures);
  return answer;
}

}  // namespace

void bindCommands(py::module_& module) {
  module.def("run", runInPython, py::arg("name"), py::arg("options"), py::arg("progress"));
}

}  // namespace sim2sim::python
