// SPDX-License-Identifier: BSD-3-Clause
/// Values of a YAML file, and messages that name their line. Private to plans and hypotheses.
#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_eval/batch/simulators.hpp"

namespace sim2sim {

/// "line 3, block_damp"
inline std::string locationOf(const YAML::Node& node, const std::string& key) {
  return "line " + std::to_string(node.Mark().line + 1) + ", " + key;
}

[[noreturn]] inline void refuse(const YAML::Node& node, const std::string& key, const std::string& rule) {
  throw pusht::InvalidInput(locationOf(node, key) + ": " + rule);
}

inline std::string textAt(const YAML::Node& node, const std::string& key) {
  if (!node.IsScalar()) {
    refuse(node, key, "must be a single value");
  }
  return node.Scalar();
}

/// A value or a list of values, as a list; none if the node is not there.
inline std::vector<std::string> textsAt(const YAML::Node& node, const std::string& key) {
  std::vector<std::string> texts;
  if (node.IsDefined() && !node.IsSequence()) {
    texts.push_back(textAt(node, key));
  }
  for (const YAML::Node& text : node.IsDefined() && node.IsSequence() ? node : YAML::Node()) {
    texts.push_back(textAt(text, key));
  }
  return texts;
}

template <class Integer>
Integer integerAt(const YAML::Node& node, const std::string& key) {
  const std::string text = textAt(node, key);
  const std::optional<Integer> value = pusht::decimal<Integer>(text);
  if (!value) {
    refuse(node, key, "'" + text + "' must be a decimal integer in range");
  }
  return *value;
}

/// Calls check(); what it refuses is in the line of `node`.
template <class Check>
void inLineOf(const YAML::Node& node, Check check) {
  try {
    pusht::asInput(check);
  } catch (pusht::InvalidInput& error) {
    error.addContext("line " + std::to_string(node.Mark().line + 1));
    throw;
  }
}

/// Throws InvalidInput for a key that appears twice; YAML itself would take the last.
inline void requireDistinctKeys(const YAML::Node& map) {
  std::set<std::string> seen;
  for (const auto& entry : map) {
    const std::string key = textAt(entry.first, "key");
    if (!seen.insert(key).second) {
      refuse(entry.first, key, "must appear only once");
    }
  }
}

/// Reads a file of one YAML document: build(root). Errors name `what`, the file and, of YAML itself, the line.
template <class Build>
auto fromYaml(const std::filesystem::path& path, const std::string& what, Build build) {
  const std::string text = pusht::readFile(path, what, pusht::kLargestSmallFile);
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(text);
    if (documents.size() > 1) {
      throw pusht::InvalidInput("must be one YAML document");
    }
    return build(documents.empty() ? YAML::Node() : documents.front());
  } catch (const YAML::Exception& error) {
    throw pusht::InvalidInput(what + " " + path.string() + ": line " + std::to_string(error.mark.line + 1) +
                              ": must be YAML: " + error.msg);
  } catch (pusht::Error& error) {
    error.addContext(what + " " + path.string());
    throw;
  }
}

/// Simulator that "KIND" or "KIND:NAME=VALUE:NAME=VALUE" names, with its defaults otherwise.
inline SimulatorChoice simulatorAt(const YAML::Node& node, const std::string& key) {
  std::optional<SimulatorChoice> choice;
  inLineOf(node, [&] { choice = simulatorFromText(textAt(node, key)); });
  return *choice;
}

}  // namespace sim2sim
