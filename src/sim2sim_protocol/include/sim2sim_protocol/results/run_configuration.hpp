// SPDX-License-Identifier: BSD-3-Clause
/// What decides the results of a run.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pusht_task/parameters.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// The kinds of simulators in the course's experiment: what a run has where nothing else is asked for.
inline constexpr const char* kCourseReference = "mujoco";
inline constexpr const char* kCourseEngine = "two_mass";

/// A simulator that took part in a run, in whatever role.
struct SimulatorRecord {
  std::string name;   ///< of its kind: "two_mass"
  std::string title;  ///< for people: "two-mass engine"
  /// true or false, a number or a text for each name, in the simulator's own order. A file is named by its content:
  /// "sha256:...".
  nlohmann::ordered_json parameters = nlohmann::ordered_json::object();
  nlohmann::ordered_json units = nlohmann::ordered_json::object();  ///< of those parameters that have one
  std::vector<std::string> changed{};  ///< names of the parameters that have not their default

  /// Adds a parameter. If it is a file, `provenance` of the simulator has its SHA-256, under the parameter's name.
  void add(const std::string& parameter, const pusht::ParameterValue& value, const std::string& unit, bool is_default,
           const nlohmann::json& provenance);
};

/// Description of a simulator in metrics.json and provenance.json.
nlohmann::ordered_json toJson(const SimulatorRecord& simulator);
/// Throws json::exception if `description` does not come from toJson().
SimulatorRecord simulatorFrom(const nlohmann::ordered_json& description);

/// What decides the bytes of metrics.json and episodes.csv.
struct RunConfiguration {
  Protocol protocol;
  bool smoke = false;
  std::string policy;  ///< the string given, or "fresh-untrained"
  SimulatorRecord reference;
  SimulatorRecord engine;
};

/// The options that decide what the reference does from a given initial state, by name, for the key of kept references.
/// An option that is written only if it is changed stands there only then.
nlohmann::json referenceOptions(const RunOptions& options);

/// First 12 hex digits of the md5 of `episodes|KNOB|...|horizon`, as Python prints them, with the values of the
/// course's three knobs, if the engine has them. Whatever else is not as in the course follows: `|reference=NAME`,
/// `|engine=NAME`, and `|ROLE.PARAMETER=VALUE` for each parameter that has not its default, and
/// `|starts=HASH` where the starts were given, `|probes=NAME,...` unless these are the floor,
/// `|bound=METRES,RADIANS` unless it is the task's tolerance, and `|NAME=VALUE` for each option that is written if it
/// is changed. A smoke run counts as one of the default length, as in the course.
std::string configurationHash(const RunConfiguration& configuration);

/// The configuration as JSON; part of metrics.json and of provenance.json.
nlohmann::ordered_json describe(const RunConfiguration& configuration);

/// Throws InvalidInput, naming both formats, unless `description` is of the format that describe() writes.
void requireDescriptionFormat(const nlohmann::json& description);

/// The protocol of a configuration, or of a sweep, that describe() has described; given starts are known by their hash
/// alone. Throws json::exception if there is none, InvalidInput if it cannot be run or is of another format.
Protocol protocolFrom(const nlohmann::json& description);

/// The configuration that `description` describes. Throws InvalidInput if it describes none, or is of another format.
RunConfiguration configurationFrom(const nlohmann::ordered_json& description);

}  // namespace sim2sim
