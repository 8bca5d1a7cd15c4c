// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/node_parameters.hpp"

#include <ros/exceptions.h>
#include <ros/names.h>
#include <ros/param.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <optional>
#include <sstream>
#include <system_error>

#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"

namespace pusht {
namespace {

bool isTask(const pusht_msgs::Parameter& parameter) { return parameter.name == kTaskParameter; }

using XmlRpc::XmlRpcValue;

/// Private parameters that this process has set. Of the main thread, which spins.
std::set<std::string> own_keys;

/// Read by libraries from the private namespace of every node.
constexpr std::array<const char*, 2> kOfLibraries = {"diagnostic_period", "tf"};

std::string shown(const XmlRpcValue& value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

std::string textIn(XmlRpcValue value) {
  switch (value.getType()) {
    case XmlRpcValue::TypeInt:
      return std::to_string(static_cast<int>(value));
    case XmlRpcValue::TypeDouble:
      return shortestText(static_cast<double>(value));
    case XmlRpcValue::TypeBoolean:
      return static_cast<bool>(value) ? "true" : "false";
    case XmlRpcValue::TypeString:
      return static_cast<std::string>(value);
    default:
      return shown(value);
  }
}

/// The integer that an integer or a text is; none if it is no such number.
template <class Integer>
std::optional<Integer> integerIn(const XmlRpcValue& value) {
  const bool possible = value.getType() == XmlRpcValue::TypeInt || value.getType() == XmlRpcValue::TypeString;
  return possible ? decimal<Integer>(textIn(value)) : std::nullopt;
}

}  // namespace

pusht_msgs::Parameter parameter(const std::string& name, const std::string& value) {
  pusht_msgs::Parameter result;
  result.name = name;
  result.value = value;
  return result;
}

bool sameValue(const std::string& a, const std::string& b) {
  const std::optional<double> number = decimal<double>(a);
  return number ? number == decimal<double>(b) : a == b;
}

ParameterSet withTask(const SimulatorKind& kind) {
  ParameterDescriptor task{kTaskParameter, "", "what all simulators of a run agree on", fullCircle().name};
  task.only_if_changed = true;
  ParameterSet set = kind.defaults(kind.ownTask());
  set.add({task, kind.ownTask().name});
  return set;
}

Parameters toMessages(const ParameterSet& parameters) {
  Parameters messages;
  for (const Parameter& known : parameters) {
    if (known.isRecorded()) {
      messages.push_back(parameter(known.name(), textOf(known.value)));
    }
  }
  return messages;
}

pusht_msgs::ParameterDescriptor toMessage(const ParameterDescriptor& descriptor) {
  pusht_msgs::ParameterDescriptor message;
  message.name = descriptor.name;
  message.type = descriptor.type();
  message.unit = descriptor.unit;
  message.meaning = descriptor.meaning;
  message.default_value = textOf(descriptor.default_value);
  message.least = descriptor.least;
  message.greatest = descriptor.greatest;
  message.words = descriptor.words;
  for (const Preset& preset : descriptor.presets) {
    message.presets.emplace_back();
    message.presets.back().word = preset.word;
    for (const auto& [name, text] : preset.settings) {
      message.presets.back().settings.push_back(parameter(name, text));
    }
  }
  return message;
}

ParameterDescriptor fromMessage(const pusht_msgs::ParameterDescriptor& message) {
  static const std::map<std::string, ParameterValue> types = {
      {"boolean", false}, {"integer", std::int64_t{0}}, {"real", 0.0}, {"text", std::string()}};
  const auto type = types.find(message.type);
  if (type == types.end()) {
    throw BadDependency("parameter " + message.name + ": type '" + message.type +
                        "': must be boolean, integer, real or text");
  }
  ParameterDescriptor descriptor;
  descriptor.name = message.name;
  descriptor.unit = message.unit;
  descriptor.meaning = message.meaning;
  descriptor.default_value = type->second;
  try {
    descriptor.default_value = descriptor.read(message.default_value);
  } catch (const InvalidInput& refusal) {
    throw BadDependency(std::string("default of ") + refusal.what());
  }
  descriptor.least = message.least;
  descriptor.greatest = message.greatest;
  descriptor.words = message.words;
  for (const pusht_msgs::Preset& preset : message.presets) {
    descriptor.presets.push_back({preset.word, {}});
    for (const pusht_msgs::Parameter& setting : preset.settings) {
      descriptor.presets.back().settings.emplace_back(setting.name, setting.value);
    }
  }
  return descriptor;
}

void requireOnce(const Parameters& parameters) {
  for (auto first = parameters.begin(); first != parameters.end(); ++first) {
    const auto second =
        std::find_if(std::next(first), parameters.end(), [&](const auto& other) { return other.name == first->name; });
    if (second != parameters.end()) {
      throw InvalidInput("parameter " + first->name + " " + first->value + ", " + second->value + ": must be set once");
    }
  }
}

Parameters changed(Parameters parameters, const Parameters& changes) {
  requireOnce(changes);
  for (const pusht_msgs::Parameter& change : changes) {
    const auto known = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const auto& parameter) { return parameter.name == change.name; });
    if (known == parameters.end()) {
      parameters.push_back(change);
    } else {
      known->value = change.value;
    }
  }
  return parameters;
}

std::optional<std::string> taskIn(const Parameters& parameters) {
  const auto said = std::find_if(parameters.begin(), parameters.end(), isTask);
  return said == parameters.end() ? std::nullopt : std::optional(said->value);
}

Parameters withoutTask(Parameters parameters) {
  parameters.erase(std::remove_if(parameters.begin(), parameters.end(), isTask), parameters.end());
  return parameters;
}

ParameterSet merged(ParameterSet parameters, const Parameters& changes) {
  requireOnce(changes);
  for (const pusht_msgs::Parameter& change : changes) {
    parameters.set(change.name, change.value);
  }
  return parameters;
}

std::string serviceName(const std::string& what, const std::string& name) {
  try {
    if (!name.empty()) {
      return ros::names::resolve(name);
    }
  } catch (const ros::InvalidNameException&) {
    // Refused below, like no name at all.
  }
  throw InvalidInput(what + " '" + name + "': must be a ROS name: letters, digits, _ and /");
}

void setParameters(const ros::NodeHandle& private_handle, const Parameters& parameters) {
  for (const pusht_msgs::Parameter& parameter : parameters) {
    const ParameterValue value = valueOf(parameter.value);
    if (const auto* flag = std::get_if<bool>(&value)) {
      private_handle.setParam(parameter.name, *flag);
    } else if (const std::optional<int> integer = decimal<int>(parameter.value)) {
      private_handle.setParam(parameter.name, *integer);
    } else if (const auto* real = std::get_if<double>(&value)) {
      private_handle.setParam(parameter.name, *real);
    } else {
      private_handle.setParam(parameter.name, parameter.value);
    }
    own_keys.insert(parameter.name);
  }
}

std::optional<std::string> storedText(const std::string& key) {
  XmlRpcValue value;
  if (!ros::param::get(key, value)) {
    return std::nullopt;
  }
  const bool single = value.getType() != XmlRpcValue::TypeStruct && value.getType() != XmlRpcValue::TypeArray;
  return single ? std::optional(textIn(value)) : std::nullopt;
}

void takeCommandLine(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const std::size_t end = argument.find(":=");
    if (end != std::string::npos && end > 1 && argument[0] == '_' && argument[1] != '_') {
      own_keys.insert(argument.substr(1, end - 1));
    }
  }
}

void removeOwnParameters() {
  for (const std::string& key : own_keys) {
    ros::param::del("~" + key);
  }
}

ParameterReader::ParameterReader(const ros::NodeHandle& private_handle) : namespace_(private_handle.getNamespace()) {
  XmlRpcValue all;
  if (private_handle.getParam(namespace_, all) && all.getType() == XmlRpcValue::TypeStruct) {
    values_.insert(all.begin(), all.end());
  }
  known_.insert(kOfLibraries.begin(), kOfLibraries.end());
}

const XmlRpcValue* ParameterReader::find(const std::string& key) {
  known_.insert(key);
  const auto value = values_.find(key);
  return value == values_.end() ? nullptr : &value->second;
}

/// How to remove a parameter that this process has not set, in brackets.
std::string ParameterReader::originOf(const std::string& key) const {
  const std::string whole = namespace_ + "/" + key;
  return own_keys.count(key) > 0
             ? ""
             : " (set by a launch file or left by an earlier node: `rosparam delete " + whole + "` removes it)";
}

void ParameterReader::refuse(const std::string& key, const std::string& rule) const {
  throw InvalidInput("parameter " + namespace_ + "/" + key + " " + shown(values_.at(key)) + ": " + rule +
                     originOf(key));
}

std::string ParameterReader::text(const std::string& key, const std::string& fallback) {
  const XmlRpcValue* value = find(key);
  if (value != nullptr && value->getType() != XmlRpcValue::TypeString) {
    refuse(key, "must be a text");
  }
  return value == nullptr ? fallback : textIn(*value);
}

std::string ParameterReader::optionalText(const std::string& key, const std::string& absent) {
  const std::string value = text(key, absent);
  if (value.empty()) {
    throw InvalidInput(key + " '': must not be empty; leave it out, or say " + absent);
  }
  return value == absent ? "" : value;
}

std::string ParameterReader::services(const std::string& key, const std::string& fallback) {
  return serviceName("parameter " + namespace_ + "/" + key, text(key, fallback));
}

bool ParameterReader::flag(const std::string& key, bool fallback) {
  const XmlRpcValue* value = find(key);
  if (value != nullptr && value->getType() != XmlRpcValue::TypeBoolean) {
    refuse(key, "must be true or false");
  }
  return value == nullptr ? fallback : textIn(*value) == "true";
}

int ParameterReader::integer(const std::string& key, int fallback) {
  const XmlRpcValue* value = find(key);
  if (value == nullptr) {
    return fallback;
  }
  const std::optional<int> integer = integerIn<int>(*value);
  if (!integer) {
    refuse(key, "must be an integer of 32 bits");
  }
  return *integer;
}

double ParameterReader::real(const std::string& key, double fallback) {
  const XmlRpcValue* value = find(key);
  if (value == nullptr) {
    return fallback;
  }
  XmlRpcValue copy = *value;
  if (copy.getType() == XmlRpcValue::TypeInt) {
    return static_cast<int>(copy);
  }
  if (copy.getType() != XmlRpcValue::TypeDouble) {
    refuse(key, "must be a number");
  }
  return static_cast<double>(copy);
}

double ParameterReader::positive(const std::string& key, double fallback) {
  const double value = real(key, fallback);
  if (!std::isfinite(value) || value <= 0.0) {
    refuse(key, "must be finite and > 0");
  }
  return value;
}

std::uint64_t ParameterReader::seed(const std::string& key, std::uint64_t fallback) {
  const XmlRpcValue* value = find(key);
  if (value == nullptr) {
    return fallback;
  }
  const std::optional<std::uint64_t> seed = integerIn<std::uint64_t>(*value);
  if (!seed) {
    refuse(key, "must be an integer from 0 to 2^64 - 1 (as a text if it has more than 31 bits)");
  }
  return *seed;
}

ParameterSet ParameterReader::changed(ParameterSet parameters) {
  for (const Parameter& known : ParameterSet(parameters)) {
    if (const XmlRpcValue* value = find(known.name())) {
      try {
        parameters.set(known.name(), textIn(*value));
      } catch (const InvalidInput& error) {
        throw InvalidInput(error.what() + originOf(known.name()));
      }
    }
  }
  return parameters;
}

void ParameterReader::enterWorkingDirectory() {
  const std::string path = text("working_directory", "");
  std::error_code error;
  if (!path.empty()) {
    std::filesystem::current_path(path, error);
  }
  if (error) {
    refuse("working_directory", "must be a folder: " + error.message());
  }
}

void ParameterReader::refuseUnknown() const {
  for (const auto& entry : values_) {
    const std::string& key = entry.first;
    if (known_.count(key) == 0) {
      std::set<std::string> offered = known_;
      for (const char* name : kOfLibraries) {
        offered.erase(name);
      }
      refuse(key, "unknown; known: " + joined(offered));
    }
  }
}

}  // namespace pusht
