// SPDX-License-Identifier: BSD-3-Clause
#include "live/world_memory.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace sim2sim {

WorldRequest ofWorld(const WorldRequest& asked) {
  WorldRequest of_world{asked.kind, {}};
  std::copy_if(asked.parameters.begin(), asked.parameters.end(), std::back_inserter(of_world.parameters),
               [](const pusht_msgs::Parameter& parameter) { return pusht::loopParameterOf(parameter.name).empty(); });
  return of_world;
}

pusht::ParameterSet loopOf(const WorldRequest& asked) {
  pusht::ParameterSet loop = pusht::plainLoop();
  for (const pusht_msgs::Parameter& parameter : asked.parameters) {
    if (const std::string name = pusht::loopParameterOf(parameter.name); !name.empty()) {
      pusht::setOfLoop(loop, name, parameter.value);
    }
  }
  return loop;
}
namespace {

/// The values that the parameters have where only words of presets are set; of those that are described.
std::map<std::string, std::string> impliedBy(const pusht_msgs::DescribeResponse& now) {
  std::map<std::string, std::string> implied;
  for (const pusht_msgs::ParameterDescriptor& descriptor : now.parameter_descriptors) {
    implied[descriptor.name] = descriptor.default_value;
  }
  for (const pusht_msgs::ParameterDescriptor& descriptor : now.parameter_descriptors) {
    const auto value = std::find_if(now.parameters.begin(), now.parameters.end(),
                                    [&](const auto& parameter) { return parameter.name == descriptor.name; });
    for (const pusht_msgs::Preset& preset : descriptor.presets) {
      if (value != now.parameters.end() && value->value == preset.word) {
        for (const pusht_msgs::Parameter& setting : preset.settings) {
          implied[setting.name] = setting.value;
        }
      }
    }
  }
  return implied;
}

}  // namespace

WorldRequest requestFor(const pusht_msgs::DescribeResponse& now) {
  const std::map<std::string, std::string> implied = impliedBy(now);
  WorldRequest request{now.name, {}};
  for (const pusht_msgs::Parameter& parameter : now.parameters) {
    const auto known = implied.find(parameter.name);
    if (known == implied.end() || !pusht::sameValue(known->second, parameter.value)) {
      request.parameters.push_back(parameter);
    }
  }
  return request;
}

WorldRequest WorldMemory::resolve(const std::string& services, const pusht_msgs::DescribeResponse& now,
                                  const WorldRequest& asked) {
  const auto [known, is_new] = worlds_.try_emplace(services);
  World& world = known->second;
  const bool others = world.left && (world.left->name != now.name || world.left->parameters != now.parameters);
  if (is_new || others) {
    world.original = requestFor(now);
  }
  world.left.reset();
  const WorldRequest current = requestFor(now);
  const bool unchanged = current.kind == world.original.kind && current.parameters == world.original.parameters;
  if (!asked.kind.empty() || unchanged) {
    return asked;
  }
  return {world.original.kind, pusht::changed(world.original.parameters, asked.parameters)};
}

void WorldMemory::configured(const std::string& services, const pusht_msgs::DescribeResponse& now) {
  worlds_[services].left = State{now.name, now.parameters};
}

std::string WorldMemory::kindOf(const std::string& services) const {
  const auto known = worlds_.find(services);
  return known == worlds_.end() ? "" : known->second.original.kind;
}

}  // namespace sim2sim
