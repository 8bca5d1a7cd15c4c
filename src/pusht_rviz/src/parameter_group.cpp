// SPDX-License-Identifier: BSD-3-Clause
#include "parameter_group.hpp"

#include <algorithm>
#include <cstddef>

#include "pusht_task/loop.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace pusht_rviz {
namespace {

/// Parameters of the loop, which are the evaluator's, named beside those of the node.
std::vector<pusht_msgs::ParameterDescriptor> loopDescriptors() {
  std::vector<pusht_msgs::ParameterDescriptor> descriptors;
  for (pusht::ParameterDescriptor of_loop : pusht::loopParameters()) {
    of_loop.name.insert(0, pusht::kLoopPrefix);
    for (pusht::Preset& preset : of_loop.presets) {
      for (auto& [name, value] : preset.settings) {
        name.insert(0, pusht::kLoopPrefix);
      }
    }
    descriptors.push_back(pusht::toMessage(of_loop));
  }
  return descriptors;
}

}  // namespace

void ParameterGroup::add(const pusht_msgs::ParameterDescriptor& descriptor, const std::string& initial,
                         bool always_named) {
  auto* const row = new ParameterProperty(descriptor, initial, always_named, this);
  connect(row, &rviz::Property::changed, this, [this, row] { follow(row); });
}

void ParameterGroup::clear() {
  if (numChildren() > 0) {
    removeChildren();
  }
}

void ParameterGroup::build(const pusht_msgs::DescribeResponse& simulator,
                           const std::vector<pusht_msgs::Parameter>& chosen) {
  clear();
  for (const pusht_msgs::Parameter& parameter : simulator.parameters) {
    const auto& all = simulator.parameter_descriptors;
    const auto known =
        std::find_if(all.begin(), all.end(), [&](const auto& descriptor) { return descriptor.name == parameter.name; });
    if (known != all.end()) {
      add(*known, known->default_value);
    } else {
      pusht_msgs::ParameterDescriptor any_text;
      any_text.name = parameter.name;
      add(any_text, parameter.value, true);
    }
  }
  for (const pusht_msgs::ParameterDescriptor& descriptor : loopDescriptors()) {
    add(descriptor, descriptor.default_value);
  }
  quiet_ = true;
  for (ParameterProperty* const row : parameters()) {
    row->setText(textAmong(chosen, row->descriptor().name).value_or(row->initial()));
  }
  rebase();
  for (ParameterProperty* const row : parameters()) {
    row->setText(textAmong(chosen, row->descriptor().name).value_or(row->base()));
  }
  quiet_ = false;
  expand();
  Q_EMIT edited();
}

void ParameterGroup::build(const pusht_msgs::RunOptions& options) {
  clear();
  for (const pusht_msgs::ParameterDescriptor& descriptor : options.descriptors) {
    add(descriptor, textAmong(options.values, descriptor.name).value_or(descriptor.default_value));
  }
  expand();
  Q_EMIT edited();
}

void ParameterGroup::follow(const ParameterProperty* changed) {
  if (quiet_) {
    return;
  }
  quiet_ = true;
  std::vector<ParameterProperty*> followers;
  for (ParameterProperty* const row : parameters()) {
    if (row != changed && !row->differs()) {
      followers.push_back(row);
    }
  }
  rebase();
  for (ParameterProperty* const row : followers) {
    row->setText(row->base());
  }
  quiet_ = false;
  Q_EMIT edited();
}

void ParameterGroup::rebase() {
  const std::vector<ParameterProperty*> rows = parameters();
  for (ParameterProperty* const row : rows) {
    row->setBase(row->initial());
  }
  for (const ParameterProperty* const word : rows) {
    if (!word->differs()) {
      continue;
    }
    for (const pusht_msgs::Preset& preset : word->descriptor().presets) {
      if (preset.word != word->text()) {
        continue;
      }
      for (ParameterProperty* const row : rows) {
        row->setBase(textAmong(preset.settings, row->descriptor().name).value_or(row->base()));
      }
    }
  }
}

std::vector<ParameterProperty*> ParameterGroup::parameters() const {
  std::vector<ParameterProperty*> rows;
  rows.reserve(static_cast<std::size_t>(numChildren()));
  for (int i = 0; i < numChildren(); ++i) {
    rows.push_back(static_cast<ParameterProperty*>(childAt(i)));
  }
  return rows;
}

ParameterProperty* ParameterGroup::find(const std::string& name) const {
  const std::vector<ParameterProperty*> rows = parameters();
  const auto found =
      std::find_if(rows.begin(), rows.end(), [&](const auto* row) { return row->descriptor().name == name; });
  return found == rows.end() ? nullptr : *found;
}

std::vector<pusht_msgs::Parameter> ParameterGroup::named() const {
  std::vector<pusht_msgs::Parameter> named;
  for (const ParameterProperty* const row : parameters()) {
    if (row->named()) {
      named.emplace_back();
      named.back().name = row->descriptor().name;
      named.back().value = row->text();
    }
  }
  return named;
}

std::string ParameterGroup::refusal() const {
  for (const ParameterProperty* const row : parameters()) {
    if (std::string rule = row->refusal(); !rule.empty()) {
      return rule;
    }
  }
  return "";
}

}  // namespace pusht_rviz
