// SPDX-License-Identifier: BSD-3-Clause
#include "live/request.hpp"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <regex>

#include "live/named_options.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "sim2sim_protocol/probes.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"

namespace sim2sim {
namespace {

constexpr int kMostFolders = 10'000;

/// Sets `field` to what a goal says of it, if it says anything.
template <class Field, class Values>
void set(const std::string& name, Field& field, const Values& values) {
  requireOneOrNone(name, values.size());
  if (!values.empty()) {
    field = static_cast<Field>(values.front());
  }
}

}  // namespace

pusht::Parameters parametersFrom(const std::string& what, const std::string& text) {
  constexpr std::size_t kLongest = 10'000;  // [bytes] std::regex recurses over each, and its stack is limited
  if (text.size() > kLongest) {
    throw pusht::InvalidInput(what + " of " + std::to_string(text.size()) + " bytes: must have at most " +
                              std::to_string(kLongest));
  }
  static const std::regex parameter_name("(^|\\s)\\s*([A-Za-z_][A-Za-z0-9_.]*)=");
  const std::sregex_iterator end;
  std::sregex_iterator name(text.begin(), text.end(), parameter_name);
  const std::string before =
      text.substr(0, name == end ? std::string::npos : static_cast<std::size_t>(name->position()));
  if (before.find_first_not_of(" \t\n") != std::string::npos) {
    throw pusht::InvalidInput(what + " '" + text + "': must be NAME=VALUE NAME=VALUE");
  }
  pusht::Parameters parsed;
  while (name != end) {
    const std::sregex_iterator next = std::next(name);
    const auto value = static_cast<std::size_t>(name->position() + name->length());
    const auto value_end =
        next == end ? text.find_last_not_of(" \t\n") + 1 : static_cast<std::size_t>(next->position());
    if (std::any_of(parsed.begin(), parsed.end(), [&](const auto& other) { return other.name == name->str(2); })) {
      throw pusht::InvalidInput(what + " '" + text + "': " + name->str(2) + " must be set once");
    }
    parsed.push_back(pusht::parameter(name->str(2), text.substr(value, std::max(value, value_end) - value)));
    name = next;
  }
  return parsed;
}

std::string freeFolder(const std::string& out) {
  const auto is_free = [](const std::string& name) {
    try {
      const RunFolder folder(name, false);
      return true;
    } catch (const pusht::InvalidInput&) {
      return false;
    }
  };
  std::string name = out;
  for (int number = 2; !is_free(name) && number < kMostFolders; ++number) {
    name = (std::filesystem::path(out) / "").parent_path().string() + "-" + std::to_string(number);
  }
  return name;
}

LiveRequest merged(LiveRequest request, const pusht_msgs::CompareGoal& goal) {
  if (request.smoke && (names(goal, "episodes") || names(goal, "horizon"))) {
    throw pusht::InvalidInput("episodes and horizon: a smoke run has its own");
  }
  if (!goal.policy_namespace.empty()) {
    request.policy.clear();  // of another node
  }
  std::string& policy = request.services.policy;
  set("policy_namespace", policy, goal.policy_namespace);
  policy = pusht::serviceName("policy_namespace", policy);
  const auto set_world = [&](const char* name, Mode mode, const std::vector<std::string>& values) {
    std::string& world = request.services.worlds[mode];
    set(name, world, values);
    world = pusht::serviceName(name, world);
  };
  set_world("reference_namespace", kReferenceClosed, goal.reference_namespace);
  set_world("engine_namespace", kEngineClosed, goal.engine_namespace);
  set_world("replay_namespace", kEngineReplay, goal.replay_namespace);
  setNamed(request.protocol, goal);
  request.protocol.probes();  // throws if there are none such
  forEachLiveField([&](const char* name, const auto& of) { set(name, of(request), of(goal)); });
  const auto set_simulator = [](const char* name, WorldRequest& simulator, const auto& kinds, const auto& parameters) {
    WorldRequest asked;
    set(name, asked.kind, kinds);
    if (asked.kind.empty()) {
      asked = simulator;
    }
    asked.parameters = pusht::changed(asked.parameters, parameters);
    simulator = asked;
  };
  set_simulator("reference", request.simulators.reference, goal.reference, goal.reference_parameters);
  set_simulator("engine", request.simulators.engine, goal.engine, goal.engine_parameters);
  loopOf(request.simulators.reference);  // throws if there are none such
  loopOf(request.simulators.engine);
  return request;
}

pusht_msgs::CompareGoal goalOf(const RunOptions& options) {
  pusht_msgs::CompareGoal goal;
  goal.options = describe(options).values;
  return goal;
}

pusht_msgs::CompareGoal goalOf(const LiveRequest& request) {
  const auto kind = [](const WorldRequest& simulator) {
    return simulator.kind.empty() ? std::vector<std::string>() : std::vector<std::string>{simulator.kind};
  };
  pusht_msgs::CompareGoal goal = goalOf(request.protocol);
  forEachLiveField([&](const char* /*name*/, const auto& of) { of(goal) = {of(request)}; });
  goal.reference_namespace = {request.services.worlds[kReferenceClosed]};
  goal.engine_namespace = {request.services.worlds[kEngineClosed]};
  goal.replay_namespace = {request.services.worlds[kEngineReplay]};
  goal.policy_namespace = {request.services.policy};
  goal.reference = kind(request.simulators.reference);
  goal.engine = kind(request.simulators.engine);
  goal.reference_parameters = request.simulators.reference.parameters;
  goal.engine_parameters = request.simulators.engine.parameters;
  return goal;
}

}  // namespace sim2sim
