// SPDX-License-Identifier: BSD-3-Clause
/// Configuration of a run; its hash, and its description as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pusht_task/parameters.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// Kinds of simulators of the course's experiment, which are the defaults.
inline constexpr const char* kCourseReference = "mujoco";
inline constexpr const char* kCourseEngine = "two_mass";

/// A simulator of a run, reference or engine.
struct SimulatorRecord {
  std::string name;   ///< name of its kind: "two_mass"
  std::string title;  ///< for people: "two-mass engine"
  /// Value of each parameter (true, false, a number or a text) by name, in the simulator's own order. A file is named
  /// by its content: "sha256:...".
  nlohmann::ordered_json parameters = nlohmann::ordered_json::object();
  nlohmann::ordered_json units = nlohmann::ordered_json::object();  ///< units of the parameters that have one
  std::vector<std::string> changed{};  ///< names of the parameters that do not have their default

  /// Adds a parameter. For a file, `provenance` of the simulator has its SHA-256, under the parameter's name.
  void add(const std::string& parameter, const pusht::ParameterValue& value, const std::string& unit, bool is_default,
           const nlohmann::json& provenance);

  /// Adds the parameters of the loop that a policy drives it in, as "loop.NAME": those that were set.
  void add(const pusht::ParameterSet& loop);
};

/// Loop between the policy and a simulator.
pusht::ParameterSet loopOf(const SimulatorRecord& simulator);

/// Whether this loop has noise.
bool hasNoisyLoop(const SimulatorRecord& simulator);

/// Title with the parameters that do not have their default: "two-mass engine, block_damp 20.0".
std::string titleOf(const SimulatorRecord& simulator);

/// Simulator as JSON: the entries of "simulators" in a description.
nlohmann::ordered_json toJson(const SimulatorRecord& simulator);

/// Reads the JSON of toJson(). Throws json::exception for any other.
SimulatorRecord simulatorFrom(const nlohmann::ordered_json& description);

/// What a run was asked for: protocol, policy by name, simulators with their parameters. What else decides its bytes
/// (weights, libraries, code) is in its provenance.
struct RunConfiguration {
  Protocol protocol;
  bool smoke = false;
  std::string policy;  ///< text that named it, or "fresh-untrained"
  SimulatorRecord reference;
  SimulatorRecord engine;
};

/// Options that decide what the reference does from a given initial state, by name, for the key of the reference cache.
/// An option of kIfChanged is there only if it is changed.
nlohmann::json referenceOptions(const RunOptions& options);

/// First 12 hex digits of the md5 of `episodes|PARAMETER|...|horizon`, as Python prints them, with the values of the
/// course's three parameters, if the engine has them. All other differences from the course follow: `|reference=NAME`,
/// `|engine=NAME`, and `|ROLE.PARAMETER=VALUE` for each parameter that does not have its default, and
/// `|starts=HASH` if initial states were given, `|probes=NAME,...` unless these are the floor,
/// `|bound=METERS,RADIANS` unless it is the task's tolerance, and `|NAME=VALUE` for each option that is written if it
/// is changed. Seed, first episode and policy are left out, and a smoke run counts as one of the default length, as in
/// the course.
std::string configurationHash(const RunConfiguration& configuration);

/// Description of a configuration as JSON; part of metrics.json and of provenance.json.
nlohmann::ordered_json describe(const RunConfiguration& configuration);

/// Throws InvalidInput with both formats unless `description` is of the format of describe().
void requireDescriptionFormat(const nlohmann::json& description);

/// Reads the protocol from the description of a run or of a sweep; given initial states are known by their hash alone.
/// Throws json::exception if there is none, InvalidInput if it cannot be run or is of another format.
Protocol protocolFrom(const nlohmann::json& description);

/// Reads a configuration from its description. Throws InvalidInput if it is none, or of another format.
RunConfiguration configurationFrom(const nlohmann::ordered_json& description);

}  // namespace sim2sim
