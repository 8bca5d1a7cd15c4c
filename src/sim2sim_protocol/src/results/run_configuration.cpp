// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/run_configuration.hpp"

#include <algorithm>
#include <array>
#include <variant>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/loop.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/result_files.hpp"

namespace sim2sim {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

constexpr std::array<const char*, 3> kCourseParameters = {"pusher_mass", "block_damp", "baumgarte"};

bool isCourseParameter(const std::string& name) {
  return std::find(kCourseParameters.begin(), kCourseParameters.end(), name) != kCourseParameters.end();
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

/// Differences from the course, as text of the hash.
std::string differencesOf(const std::string& role, const SimulatorRecord& simulator, const std::string& in_course) {
  std::string differences;
  if (simulator.name != in_course) {
    differences.append("|").append(role).append("=").append(simulator.name);
  }
  for (const std::string& name : simulator.changed) {
    if (!(role == "engine" && isCourseParameter(name))) {
      differences.append("|").append(role).append(".").append(name).append("=");
      differences += asPythonPrints(simulator.parameters.at(name));
    }
  }
  return differences;
}

std::vector<std::string> probeNames(const Protocol& protocol) {
  std::vector<std::string> names;
  for (const Probe& probe : protocol.probes()) {
    names.push_back(probe.name);
  }
  return names;
}

/// The options that ask for probes of these names. Throws InvalidInput if none does.
void setProbes(const std::vector<std::string>& names, Protocol& protocol) {
  protocol.floor = false;
  for (const std::string& name : names) {
    const Probe probe = probeFrom(name);
    if (probe.world == ProbedWorld::kVariant) {
      (probe.closed ? protocol.closed_variants : protocol.model_variants).push_back(probe.variant);
    } else if (probe.reset_every > 0) {
      protocol.reanchor.push_back(probe.reset_every);
    } else {
      protocol.floor = true;
    }
  }
  if (probeNames(protocol) != names) {
    throw pusht::InvalidInput("probes " + pusht::joined(names) + ": must be " + pusht::joined(probeNames(protocol)));
  }
}

/// "|bound=0.03,0.2", unless it is the default.
std::string boundDifference(const RunOptions& options) {
  const RunOptions usual;
  return options.bound_position == usual.bound_position && options.bound_angle == usual.bound_angle
             ? ""
             : "|bound=" + pusht::shortestText(options.bound_position) + "," + pusht::shortestText(options.bound_angle);
}

template <class Value>
ordered_json jsonOf(const Value& value) {
  return value;
}
ordered_json jsonOf(const std::optional<double>& value) { return value ? ordered_json(*value) : ordered_json(); }

template <class Value>
void take(const json& text, Value& value) {
  text.get_to(value);
}
void take(const json& text, std::optional<double>& value) { value = text.get<double>(); }

/// The options that are written only if they are changed, by name, as far as they are.
ordered_json changedOptions(const RunOptions& options) {
  ordered_json changed = ordered_json::object();
  forEachOption([&](const auto& option) {
    if (option.written == Written::kIfChanged && !option.isDefault(options)) {
      changed[option.name] = jsonOf(option.of(options));
    }
  });
  return changed;
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

void SimulatorRecord::add(const pusht::ParameterSet& loop) {
  for (const pusht::Parameter& parameter : loop) {
    if (parameter.set_by_name || !parameter.isDefault()) {
      add(pusht::kLoopPrefix + parameter.name(), parameter.value, parameter.descriptor.unit, parameter.isDefault(),
          json::object());
    }
  }
}

pusht::ParameterSet loopOf(const SimulatorRecord& simulator) {
  pusht::ParameterSet loop = pusht::plainLoop();
  for (const auto& [name, value] : simulator.parameters.items()) {
    if (const std::string of_loop = pusht::loopParameterOf(name); !of_loop.empty()) {
      pusht::setOfLoop(loop, of_loop, value.is_string() ? value.get<std::string>() : value.dump());
    }
  }
  return loop;
}

bool hasNoisyLoop(const SimulatorRecord& simulator) {
  const pusht::ParameterSet loop = loopOf(simulator);
  return std::any_of(loop.begin(), loop.end(), [](const pusht::Parameter& parameter) {
    return parameter.name().find("noise") != std::string::npos && !parameter.isDefault();
  });
}

std::string titleOf(const SimulatorRecord& simulator) {
  std::string title = simulator.title;
  for (const std::string& name : simulator.changed) {
    title.append(", ").append(name).append(" ").append(simulator.parameters.at(name).dump());
  }
  return title;
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

json referenceOptions(const RunOptions& options) {
  json decisive = json::object();
  forEachOption([&](const auto& option) {
    if (option.decides == Decides::kReference &&
        !(option.written == Written::kIfChanged && option.isDefault(options))) {
      decisive[option.name] = jsonOf(option.of(options));
    }
  });
  return decisive;
}

std::string configurationHash(const RunConfiguration& configuration) {
  constexpr std::size_t kDigits = 12;
  const Protocol& protocol = configuration.protocol;
  const Protocol nominal = configuration.smoke ? Protocol() : protocol;
  const ordered_json& parameters = configuration.engine.parameters;
  std::string key = std::to_string(nominal.episodes);
  for (const char* name : kCourseParameters) {
    if (parameters.contains(name)) {
      key += "|" + asPythonPrints(parameters.at(name));
    }
  }
  key += "|" + std::to_string(protocol.horizon) +
         differencesOf("reference", configuration.reference, kCourseReference) +
         differencesOf("engine", configuration.engine, kCourseEngine) +
         (protocol.initial_states ? "|starts=" + protocol.initial_states->hash() : "") +
         (protocol.probes() == floorProbes() ? "" : "|probes=" + pusht::joined(probeNames(protocol), ",")) +
         boundDifference(protocol);
  const ordered_json changed = changedOptions(protocol);
  for (const auto& [name, value] : changed.items()) {
    key += std::string("|").append(name).append("=").append(asPythonPrints(value));
  }
  return pusht::md5(key).substr(0, kDigits);
}

ordered_json describe(const RunConfiguration& configuration) {
  const Protocol& protocol = configuration.protocol;
  ordered_json description = {{"format", kDescriptionFormat}, {"policy", configuration.policy}};
  forEachOption([&](const auto& option) {
    if (option.written == Written::kAlways) {
      description[option.name] = jsonOf(option.of(protocol));
    }
  });
  description["smoke"] = configuration.smoke;
  description["probes"] = probeNames(protocol);
  description["bound"] = {{"position_m", protocol.bound_position}, {"angle_rad", protocol.bound_angle}};
  description["reference_simulator"] = configuration.reference.name;
  description["engine_simulator"] = configuration.engine.name;
  description["knobs"] = configuration.engine.parameters;
  description["simulators"] = {{"reference", toJson(configuration.reference)},
                               {"engine", toJson(configuration.engine)}};
  description["config_hash"] = configurationHash(configuration);
  if (protocol.initial_states) {
    description["starts"] = protocol.initial_states->hash();
  }
  description.update(changedOptions(protocol));
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
  Protocol protocol;
  forEachOption([&](const auto& option) {
    const bool changed = option.written == Written::kIfChanged && description.contains(option.name);
    if (option.written == Written::kAlways || changed) {
      take(description.at(option.name), option.of(protocol));
    }
  });
  setProbes(description.at("probes"), protocol);
  const json& bound = description.at("bound");
  protocol.bound_position = bound.at("position_m");
  protocol.bound_angle = bound.at("angle_rad");
  if (const auto starts = description.find("starts"); starts != description.end()) {
    protocol.initial_states = std::make_shared<InitialStates>(InitialStates::named(starts->get<std::string>()));
  }
  protocol.alone = description.value("engine_simulator", "") == kNoEngine;  // a sweep's description has no engine
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
    if (describe(configuration) != description) {
      throw pusht::InvalidInput("its config_hash or one of its values does not fit the others");
    }
    return configuration;
  } catch (const json::exception& error) {
    throw pusht::InvalidInput(error.what());
  }
}

}  // namespace sim2sim
