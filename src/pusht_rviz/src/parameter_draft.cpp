// SPDX-License-Identifier: BSD-3-Clause
#include "parameter_draft.hpp"

#include <algorithm>
#include <cstdint>

#include "pusht_task/error.hpp"
#include "pusht_task/loop.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/parameters.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace pusht_rviz {
namespace {

/// Value of the type that a descriptor names; a text for any other name.
pusht::ParameterValue valueOfType(const std::string& type) {
  if (type == "boolean") {
    return false;
  }
  if (type == "integer") {
    return std::int64_t{0};
  }
  return type == "real" ? pusht::ParameterValue(0.0) : pusht::ParameterValue(std::string());
}

/// The descriptor as the task has it: the rules are the simulators' own.
pusht::ParameterDescriptor ruleOf(const pusht_msgs::ParameterDescriptor& parameter) {
  pusht::ParameterDescriptor rule{parameter.name,  parameter.unit,    "", valueOfType(parameter.type),
                                  parameter.least, parameter.greatest};
  rule.words = parameter.words;
  return rule;
}

/// Whether a text is an integer beyond those of ParameterDescriptor, as a seed may be.
bool isLargeInteger(const std::string& text) {
  return !pusht::decimal<std::int64_t>(text) && pusht::decimal<std::uint64_t>(text);
}

const pusht_msgs::ParameterDescriptor* descriptorAmong(const std::vector<pusht_msgs::ParameterDescriptor>& descriptors,
                                                       const std::string& name) {
  const auto found = std::find_if(descriptors.begin(), descriptors.end(),
                                  [&](const auto& descriptor) { return descriptor.name == name; });
  return found == descriptors.end() ? nullptr : &*found;
}

}  // namespace

std::string refusalOf(const pusht_msgs::ParameterDescriptor& parameter, const std::string& text) {
  if (parameter.type == "integer" && parameter.greatest > 0x1p63 && isLargeInteger(text)) {
    return "";
  }
  try {
    ruleOf(parameter).read(text);
    return "";
  } catch (const pusht::InvalidInput& refusal) {
    return refusal.what();
  }
}

std::string rangeOf(const pusht_msgs::ParameterDescriptor& parameter) { return ruleOf(parameter).range(); }

std::optional<std::string> textAmong(const std::vector<pusht_msgs::Parameter>& parameters, const std::string& name) {
  const auto found = std::find_if(parameters.rbegin(), parameters.rend(),
                                  [&](const auto& candidate) { return candidate.name == name; });
  return found == parameters.rend() ? std::nullopt : std::optional<std::string>(found->value);
}

bool DraftedParameter::differs() const {
  if (text == base) {
    return false;
  }
  const std::optional<double> number =
      descriptor.type == "real" ? pusht::decimal<double>(text) : std::optional<double>();
  return !number || number != pusht::decimal<double>(base);
}

ParameterDraft::ParameterDraft(const pusht_msgs::DescribeResponse& simulator,
                               const std::vector<pusht_msgs::Parameter>& chosen) {
  for (const pusht_msgs::Parameter& parameter : simulator.parameters) {
    DraftedParameter drafted;
    if (const auto* const known = descriptorAmong(simulator.parameter_descriptors, parameter.name)) {
      drafted.descriptor = *known;
      drafted.initial = known->default_value;
    } else {
      drafted.descriptor.name = parameter.name;  // without a type: any text
      drafted.initial = parameter.value;
      drafted.always_named = true;
    }
    drafted.text = textAmong(chosen, parameter.name).value_or(drafted.initial);
    parameters_.push_back(drafted);
  }
  for (pusht::ParameterDescriptor of_loop : pusht::loopParameters()) {  // the evaluator's, beside those of the node
    of_loop.name.insert(0, pusht::kLoopPrefix);
    for (pusht::Preset& preset : of_loop.presets) {
      for (auto& [name, value] : preset.settings) {
        name.insert(0, pusht::kLoopPrefix);
      }
    }
    DraftedParameter drafted;
    drafted.descriptor = pusht::toMessage(of_loop);
    drafted.initial = drafted.descriptor.default_value;
    parameters_.push_back(drafted);
  }
  rebase();
  for (DraftedParameter& drafted : parameters_) {
    drafted.text = textAmong(chosen, drafted.descriptor.name).value_or(drafted.base);
  }
}

ParameterDraft::ParameterDraft(const pusht_msgs::RunOptions& options) {
  for (const pusht_msgs::ParameterDescriptor& descriptor : options.descriptors) {
    const std::string value = textAmong(options.values, descriptor.name).value_or(descriptor.default_value);
    parameters_.push_back({descriptor, value, value, value});
  }
}

void ParameterDraft::type(std::size_t index, const std::string& text) {
  parameters_.at(index).text = text;
  std::vector<DraftedParameter*> followers;
  for (DraftedParameter& drafted : parameters_) {
    if (&drafted != &parameters_[index] && !drafted.differs()) {
      followers.push_back(&drafted);
    }
  }
  rebase();
  for (DraftedParameter* const follower : followers) {
    follower->text = follower->base;
  }
}

/// Sets the base of each parameter. A goal names the words that differ, and their presets set others.
void ParameterDraft::rebase() {
  for (DraftedParameter& drafted : parameters_) {
    drafted.base = drafted.initial;
  }
  for (const DraftedParameter& word : parameters_) {
    if (!word.differs()) {
      continue;
    }
    for (const pusht_msgs::Preset& preset : word.descriptor.presets) {
      if (preset.word != word.text) {
        continue;
      }
      for (DraftedParameter& drafted : parameters_) {
        drafted.base = textAmong(preset.settings, drafted.descriptor.name).value_or(drafted.base);
      }
    }
  }
}

std::vector<pusht_msgs::Parameter> ParameterDraft::named() const {
  std::vector<pusht_msgs::Parameter> named;
  for (const DraftedParameter& drafted : parameters_) {
    if (drafted.differs() || drafted.always_named) {
      named.emplace_back();
      named.back().name = drafted.descriptor.name;
      named.back().value = drafted.text;
    }
  }
  return named;
}

std::optional<std::size_t> ParameterDraft::find(const std::string& name) const {
  const auto found = std::find_if(parameters_.begin(), parameters_.end(),
                                  [&](const auto& drafted) { return drafted.descriptor.name == name; });
  return found == parameters_.end() ? std::nullopt : std::optional<std::size_t>(found - parameters_.begin());
}

}  // namespace pusht_rviz
