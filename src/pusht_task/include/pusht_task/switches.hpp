// SPDX-License-Identifier: BSD-3-Clause
/// Switches of a kind: true/false parameters, one for each modeling choice, and presets that set all of them. Their
/// owner lists them once, in an array of Switch; parameters, presets and values follow from that.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "pusht_task/parameters.hpp"

namespace pusht {

/// Description of one switch: a member of the struct `Choices`, true by default.
template <typename Choices>
struct Switch {
  const char* name;
  const char* meaning;  ///< a phrase for people: what it is when on, then when off
  bool Choices::*value;
};

/// Preset that sets every switch to what `is_on` says of it.
template <typename Switches, typename IsOn>
Preset presetOf(const std::string& word, const Switches& switches, const IsOn& is_on) {
  Preset result = {word, {}};
  for (const auto& each : switches) {
    result.settings.emplace_back(each.name, textOf(is_on(each)));
  }
  return result;
}

/// Preset that sets every switch alike.
template <typename Switches>
Preset presetOf(const std::string& word, const Switches& switches, bool on) {
  return presetOf(word, switches, [on](const auto& /*each*/) { return on; });
}

/// Descriptors of the parameter `preset`, whose default is the first of `presets`, and of each switch.
template <typename Switches>
std::vector<ParameterDescriptor> switchDescriptors(const Switches& switches, std::vector<Preset> presets) {
  ParameterDescriptor words = {"preset", "", "sets the switches that are not set by name", presets.front().word};
  for (const Preset& preset : presets) {
    words.words.push_back(preset.word);
  }
  words.presets = std::move(presets);
  std::vector<ParameterDescriptor> descriptors = {std::move(words)};
  for (const auto& each : switches) {
    descriptors.push_back({each.name, "", each.meaning, true});
  }
  return descriptors;
}

/// Sets each switch of `choices` to its value in `parameters`.
template <typename Switches, typename Choices>
void readSwitches(const ParameterSet& parameters, const Switches& switches, Choices& choices) {
  for (const auto& each : switches) {
    choices.*each.value = parameters.get<bool>(each.name);
  }
}

}  // namespace pusht
