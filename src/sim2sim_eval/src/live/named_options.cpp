// SPDX-License-Identifier: BSD-3-Clause
#include "live/named_options.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <optional>
#include <type_traits>
#include <variant>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/probes.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace sim2sim {
namespace {

constexpr const char* kNoValue = "none";  // as joined() has an empty list

// Values as those of parameters. A seed, which may be beyond their integers, has one for its default alone.
pusht::ParameterValue parameterValue(bool value) { return value; }
pusht::ParameterValue parameterValue(int value) { return std::int64_t{value}; }
pusht::ParameterValue parameterValue(std::uint64_t value) { return static_cast<std::int64_t>(value); }
pusht::ParameterValue parameterValue(double value) { return value; }
pusht::ParameterValue parameterValue(std::optional<double> share) { return share.value_or(0.0); }
pusht::ParameterValue parameterValue(const std::vector<int>& list) {
  std::vector<std::string> numbers;
  std::transform(list.begin(), list.end(), std::back_inserter(numbers),
                 [](int value) { return std::to_string(value); });
  return pusht::joined(numbers, ",");
}
pusht::ParameterValue parameterValue(const std::string& value) { return value; }
pusht::ParameterValue parameterValue(const std::vector<std::string>& list) { return pusht::joined(list, ","); }

template <class Value>
std::string textOf(const Value& value) {
  return pusht::textOf(parameterValue(value));
}
std::string textOf(std::uint64_t value) { return std::to_string(value); }

template <class Option>
pusht::ParameterDescriptor descriptorOf(const Option& option) {
  const RunOptions usual;
  const auto& value = option.of(usual);
  constexpr bool kIsInt = std::is_same_v<std::decay_t<decltype(value)>, int>;
  const double most = kIsInt ? std::numeric_limits<int>::max() : std::numeric_limits<double>::infinity();
  return {option.name,           option.unit,        option.meaning,
          parameterValue(value), option.range.least, std::min(most, option.range.greatest)};
}

/// Sets `value` to what `text` stands for. Throws InvalidInput with the option's name, the text and the rule.
void read(const pusht::ParameterDescriptor& option, const std::string& text, bool& value) {
  value = std::get<bool>(option.read(text));
}
void read(const pusht::ParameterDescriptor& option, const std::string& text, int& value) {
  value = static_cast<int>(std::get<std::int64_t>(option.read(text)));
}
void read(const pusht::ParameterDescriptor& option, const std::string& text, std::uint64_t& value) {
  const std::optional<std::uint64_t> number = pusht::decimal<std::uint64_t>(text);
  if (!number) {
    throw pusht::InvalidInput(option.name + " '" + text + "': must be a decimal integer from 0 to 2^64 - 1");
  }
  value = *number;
}
void read(const pusht::ParameterDescriptor& option, const std::string& text, double& value) {
  value = std::get<double>(option.read(text));
}
void read(const pusht::ParameterDescriptor& option, const std::string& text, std::optional<double>& share) {
  double given = 0.0;
  read(option, text, given);
  share = given == 0.0 ? std::nullopt : std::optional(given);
}
void read(const pusht::ParameterDescriptor& /*option*/, const std::string& text, std::vector<int>& list) {
  list = reanchorFrom(text == kNoValue ? "" : text);
}
void read(const pusht::ParameterDescriptor& /*option*/, const std::string& text, std::string& value) { value = text; }
void read(const pusht::ParameterDescriptor& /*option*/, const std::string& text, std::vector<std::string>& list) {
  list = modelVariantsFrom(text == kNoValue ? "" : text);
}

std::string asText(bool value) { return value ? "true" : "false"; }
template <class Integer>
std::string asText(Integer value) {
  return std::to_string(value);
}
std::string asText(double value) { return pusht::shortestText(value); }

/// A list of control steps; 0 alone stands for an empty one.
std::string listText(const std::vector<std::uint32_t>& steps) {
  std::vector<std::string> numbers;
  std::transform(steps.begin(), steps.end(), std::back_inserter(numbers), asText<std::uint32_t>);
  return steps == std::vector<std::uint32_t>{0} ? kNoValue : pusht::joined(numbers, ",");
}

bool has(const pusht::Parameters& parameters, const std::string& name) {
  return std::any_of(parameters.begin(), parameters.end(),
                     [&](const pusht_msgs::Parameter& parameter) { return parameter.name == name; });
}

}  // namespace

pusht_msgs::RunOptions describe(const RunOptions& options) {
  pusht_msgs::RunOptions message;
  forEachOption([&](const auto& option) {
    message.values.push_back(pusht::parameter(option.name, textOf(option.of(options))));
    message.descriptors.push_back(pusht::toMessage(descriptorOf(option)));
  });
  return message;
}

void requireOneOrNone(const std::string& name, std::size_t values) {
  if (values > 1) {
    throw pusht::InvalidInput(name + " has " + std::to_string(values) +
                              " values: must have one, or none: then the parameter counts");
  }
}

pusht::Parameters oldFields(const pusht_msgs::CompareGoal& goal) {
  pusht::Parameters said;
  const auto add = [&](const char* name, const auto& values) {
    requireOneOrNone(name, values.size());
    if (!values.empty()) {
      said.push_back(pusht::parameter(name, asText(values.front())));
    }
  };
  add("seed", goal.seed);
  add("first_episode", goal.first_episode);
  add("episodes", goal.episodes);
  add("horizon", goal.horizon);
  add("until_decided", goal.until_decided);
  add("bound_position", goal.bound_position);
  add("bound_angle", goal.bound_angle);
  add("floor", std::vector<bool>(goal.floor.begin(), goal.floor.end()));
  if (!goal.reanchor.empty()) {
    said.push_back(pusht::parameter("reanchor", listText(goal.reanchor)));
  }
  return said;
}

bool names(const pusht_msgs::CompareGoal& goal, const std::string& name) {
  return has(goal.options, name) || has(oldFields(goal), name);
}

void setNamed(RunOptions& options, const pusht_msgs::CompareGoal& goal) {
  pusht::requireOnce(goal.options);
  pusht::Parameters said = oldFields(goal);
  for (const pusht_msgs::Parameter& named : goal.options) {
    if (has(said, named.name)) {
      throw pusht::InvalidInput("option " + named.name + " " + named.value +
                                ": must be set once, by name or in the field of that name");
    }
  }
  said.insert(said.end(), goal.options.begin(), goal.options.end());
  std::vector<std::string> known;
  forEachOption([&](const auto& option) { known.emplace_back(option.name); });
  for (const pusht_msgs::Parameter& each : said) {
    if (std::find(known.begin(), known.end(), each.name) == known.end()) {
      throw pusht::InvalidInput("option '" + each.name + "': unknown; known: " + pusht::joined(known));
    }
    forEachOption([&](const auto& option) {
      if (option.name == each.name) {
        read(descriptorOf(option), each.value, option.of(options));
      }
    });
  }
}

}  // namespace sim2sim
