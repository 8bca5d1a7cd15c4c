// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/results/run_configuration.hpp"

#include <algorithm>
#include <array>
#include <variant>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"

namespace sim2sim {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

/// Of a run's description. 1 named no parameters of the reference, 2 no units; 3 had no probes and no bound.
constexpr int kDescriptionFormat = 4;

constexpr std::array<const char*, 3> kCourseKnobs = {"pusher_mass", "block_damp", "baumgarte"};

bool isCourseKnob(const std::string& name) {
  return std::find(kCourseKnobs.begin(), kCourseKnobs.end(), name) != kCourseKnobs.end();
}

std::string asPythonPrints(const ordered_json& value) {
  if (value.is_boolean()) {
    return value.get<bool>() ? "True" : "False";
  }
  if (value.is_number_float()) {
    return pusht::shortestText(value.get<double>());
  }
  return value.is_string() ? value.get<std::string>() : value.dump();
}

/// What is not as in the course.
std::string differencesOf(const std::string& role, const SimulatorRecord& simulator, const std::string& in_course) {
  std::string differences;
  if (simulator.name != in_course) {
    differences.append("|").append(role).append("=").append(simulator.name);
  }
  for (const std::string& name : simulator.changed) {
    if (!(role == "engine" && isCourseKnob(name))) {
      differences.append("|").append(role).append(".").append(name).append("=");
      differences += asPythonPrints(simulator.parameters.at(name));
    }
  }
  return differences;
}

std::vector<std::string> probeNames(const RunConfiguration& configuration) {
  std::vector<std::string> names;
  for (const Probe& probe : configuration.protocol.probes) {
    names.push_back(probe.name);
  }
  return names;
}

/// "|bound=0.03,0.2", unless it is the default.
std::string boundDifference(const Bound& bound) {
  const Bound usual;
  return bound.position == usual.position && bound.angle == usual.angle
             ? ""
             : "|bound=" + pusht::shortestText(bound.position) + "," + pusht::shortestText(bound.angle);
}

}  // namespace

void SimulatorRecord::add(const std::string& parameter, const pusht::ParameterValue& value, const std::string& unit,
                          bool is_default, const json& provenance) {
  parameters[parameter] = std::visit([](const auto& plain) { return ordered_json(plain); }, value);
  if (!unit.empty()) {
    units[parameter] = unit;
  }
  if (is_default) {
    return;
  }
  changed.push_back(parameter);
  const json sha256 = provenance.value(json::json_pointer("/" + parameter + "/sha256"), json());
  if (sha256.is_string()) {
    parameters[parameter] = "sha256:" + sha256.get<std::string>();
  }
}

ordered_json toJson(const SimulatorRecord& simulator) {
  return {{"name", simulator.name},
          {"title", simulator.title},
          {"parameters", simulator.parameters},
          {"units", simulator.units},
          {"changed", simulator.changed}};
}

SimulatorRecord simulatorFrom(const ordered_json& description) {
  SimulatorRecord simulator;
  description.at("name").get_to(simulator.name);
  description.at("title").get_to(simulator.title);
  simulator.parameters = description.at("parameters");
  simulator.units = description.at("units");
  description.at("changed").get_to(simulator.changed);
  for (const std::string& name : simulator.changed) {
    simulator.parameters.at(name);
  }
  return simulator;
}

std::string configurationHash(const RunConfiguration& configuration) {
  constexpr std::size_t kDigits = 12;
  const Protocol nominal = configuration.smoke ? Protocol() : configuration.protocol;
  const ordered_json& parameters = configuration.engine.parameters;
  std::string key = std::to_string(nominal.episodes);
  for (const char* knob : kCourseKnobs) {
    if (parameters.contains(knob)) {
      key += "|" + asPythonPrints(parameters.at(knob));
    }
  }
  key += "|" + std::to_string(configuration.protocol.horizon) +
         differencesOf("reference", configuration.reference, kCourseReference) +
         differencesOf("engine", configuration.engine, kCourseEngine) +
         (configuration.protocol.starts ? "|starts=" + configuration.protocol.starts->hash() : "") +
         (configuration.protocol.probes == floorProbes() ? ""
                                                         : "|probes=" + pusht::joined(probeNames(configuration), ",")) +
         boundDifference(configuration.protocol.bound) +
         (configuration.until_decided ? "|until_decided=" + pusht::shortestText(*configuration.until_decided) : "");
  return pusht::md5(key).substr(0, kDigits);
}

ordered_json describe(const RunConfiguration& configuration) {
  ordered_json description = {
      {"format", kDescriptionFormat},
      {"policy", configuration.policy},
      {"seed", configuration.protocol.seed},
      {"first_episode", configuration.protocol.first_episode},
      {"episodes", configuration.protocol.episodes},
      {"horizon", configuration.protocol.horizon},
      {"smoke", configuration.smoke},
      {"probes", probeNames(configuration)},
      {"bound",
       {{"position_m", configuration.protocol.bound.position}, {"angle_rad", configuration.protocol.bound.angle}}},
      {"reference_simulator", configuration.reference.name},
      {"engine_simulator", configuration.engine.name},
      {"knobs", configuration.engine.parameters},
      {"simulators", {{"reference", toJson(configuration.reference)}, {"engine", toJson(configuration.engine)}}},
      {"config_hash", configurationHash(configuration)}};
  if (configuration.protocol.starts) {
    description["starts"] = configuration.protocol.starts->hash();
  }
  if (configuration.until_decided) {
    description["until_decided"] = *configuration.until_decided;
  }
  return description;
}

void requireDescriptionFormat(const json& description) {
  if (const json format = description.value("format", json(1)); format != kDescriptionFormat) {
    throw pusht::InvalidInput("format " + format.dump() + ": must be " + std::to_string(kDescriptionFormat) +
                              "; another version of the suite wrote it");
  }
}

Protocol protocolFrom(const json& description) {
  requireDescriptionFormat(description);
  Protocol protocol{description.at("seed"), description.at("first_episode"), description.at("episodes"),
                    description.at("horizon")};
  protocol.probes.clear();
  for (const json& name : description.at("probes")) {
    protocol.probes.push_back(probeFrom(name.get<std::string>()));
  }
  const json& bound = description.at("bound");
  protocol.bound = {bound.at("position_m"), bound.at("angle_rad")};
  if (const auto starts = description.find("starts"); starts != description.end()) {
    protocol.starts = std::make_shared<Starts>(Starts::named(starts->get<std::string>()));
  }
  protocol.validate();
  return protocol;
}

RunConfiguration configurationFrom(const ordered_json& description) {
  try {
    RunConfiguration configuration;
    configuration.protocol = protocolFrom(description);
    description.at("policy").get_to(configuration.policy);
    description.at("smoke").get_to(configuration.smoke);
    configuration.reference = simulatorFrom(description.at("simulators").at("reference"));
    configuration.engine = simulatorFrom(description.at("simulators").at("engine"));
    if (const auto share = description.find("until_decided"); share != description.end()) {
      configuration.until_decided = share->get<double>();
    }
    if (describe(configuration) != description) {
      throw pusht::InvalidInput("its config_hash or one of its values does not fit the others");
    }
    return configuration;
  } catch (const json::exception& error) {
    throw pusht::InvalidInput(error.what());
  }
}

}  // namespace sim2sim
