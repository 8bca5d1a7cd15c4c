// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/parameters.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>

#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"

namespace pusht {
namespace {

/// Names of types, by index in ParameterValue.
struct TypeName {
  const char* name;
  const char* rule;
};
constexpr std::array<TypeName, std::variant_size_v<ParameterValue>> kTypes = {{{"boolean", "must be true or false"},
                                                                               {"integer", "must be a decimal integer"},
                                                                               {"real", "must be a decimal number"},
                                                                               {"text", "must be a text"}}};

/// Value of `text` of the type that `wanted` has; none if it shows no such value.
std::optional<ParameterValue> valueLike(const ParameterValue& wanted, const std::string& text) {
  if (std::holds_alternative<std::string>(wanted)) {
    return text;
  }
  ParameterValue value = valueOf(text);
  if (std::holds_alternative<double>(wanted) && std::holds_alternative<std::int64_t>(value)) {
    return decimal<double>(text);
  }
  return value.index() == wanted.index() ? std::optional(value) : std::nullopt;
}

}  // namespace

ParameterValue valueOf(const std::string& text) {
  if (text == "true" || text == "false") {
    return text == "true";
  }
  if (const std::optional<std::int64_t> integer = decimal<std::int64_t>(text)) {
    return *integer;
  }
  if (const std::optional<double> real = decimal<double>(text)) {
    return *real;
  }
  return text;
}

std::string textOf(const ParameterValue& value) {
  struct Text {
    std::string operator()(bool flag) const { return flag ? "true" : "false"; }
    std::string operator()(std::int64_t integer) const { return std::to_string(integer); }
    std::string operator()(double real) const { return shortestText(real); }
    std::string operator()(const std::string& text) const { return text; }
  };
  return std::visit(Text(), value);
}

const char* ParameterDescriptor::type() const { return kTypes.at(default_value.index()).name; }

std::string ParameterDescriptor::range() const {
  if (std::holds_alternative<bool>(default_value)) {
    return "true or false";
  }
  if (std::holds_alternative<std::string>(default_value)) {
    return words.empty() ? "" : "one of: " + joined(words);
  }
  const auto end = [&](double value) {
    const bool whole = std::holds_alternative<std::int64_t>(default_value);
    return whole ? std::to_string(std::llround(value)) : shortestText(value);
  };
  const std::string in_unit = unit.empty() ? "" : " [" + unit + "]";
  if (!numbers.empty()) {
    std::vector<std::string> texts;
    std::transform(numbers.begin(), numbers.end(), std::back_inserter(texts), end);
    return "one of: " + joined(texts) + in_unit;
  }
  if (std::isfinite(least) && std::isfinite(greatest)) {
    return "from " + end(least) + " to " + end(greatest) + in_unit;
  }
  if (std::isfinite(least)) {
    return "at least " + end(least) + in_unit;
  }
  return std::isfinite(greatest) ? "at most " + end(greatest) + in_unit : "";
}

ParameterValue ParameterDescriptor::read(const std::string& text) const {
  std::optional<ParameterValue> value = valueLike(default_value, text);
  if (!value) {
    throw InvalidInput(name + " '" + text + "': " + kTypes.at(default_value.index()).rule);
  }
  if (std::holds_alternative<double>(*value)) {
    value = std::get<double>(*value) + 0.0;  // -0.0 is 0.0
  }
  require(*value);
  return *value;
}

void ParameterDescriptor::require(const ParameterValue& value) const {
  if (const auto* const word = std::get_if<std::string>(&value);
      word != nullptr && !words.empty() && std::find(words.begin(), words.end(), *word) == words.end()) {
    throw InvalidInput(name + " '" + *word + "': must be " + range());
  }
  const auto* const integer = std::get_if<std::int64_t>(&value);
  const auto* const real = std::get_if<double>(&value);
  const double number = real != nullptr ? *real : integer != nullptr ? static_cast<double>(*integer) : 0.0;
  // Written so that a NaN fails.
  const bool listed = numbers.empty() || std::find(numbers.begin(), numbers.end(), number) != numbers.end();
  if ((real != nullptr || integer != nullptr) && !(least <= number && number <= greatest && listed)) {
    throw InvalidInput(name + " " + textOf(value) + ": must be " + range() + (reason.empty() ? "" : ": " + reason));
  }
}

ParameterSet::ParameterSet(const std::vector<ParameterDescriptor>& descriptors) {
  for (const ParameterDescriptor& descriptor : descriptors) {
    parameters_.push_back({descriptor, descriptor.default_value});
  }
}

void ParameterSet::set(const std::string& name, const std::string& text) {
  Parameter& parameter = place(name);
  parameter.value = parameter.descriptor.read(text);
  parameter.set_by_name = true;
  for (const Preset& preset : parameter.descriptor.presets) {
    if (parameter.value != ParameterValue(preset.word)) {
      continue;
    }
    for (const auto& [other_name, other_text] : preset.settings) {
      Parameter& other = place(other_name);
      if (!other.set_by_name) {
        other.value = other.descriptor.read(other_text);
      }
    }
  }
}

void ParameterSet::setDefault(const std::string& name, const ParameterValue& value) {
  Parameter& parameter = place(name);
  parameter.descriptor.default_value = value;
  if (!parameter.set_by_name) {
    parameter.value = value;
  }
}

Parameter& ParameterSet::place(const std::string& name) { return parameters_[&at(name) - parameters_.data()]; }

bool ParameterSet::has(const std::string& name) const {
  return std::any_of(parameters_.begin(), parameters_.end(),
                     [&](const Parameter& each) { return each.name() == name; });
}

const Parameter& ParameterSet::at(const std::string& name) const {
  const auto place = std::find_if(parameters_.begin(), parameters_.end(),
                                  [&](const Parameter& parameter) { return parameter.name() == name; });
  if (place == parameters_.end()) {
    std::vector<std::string> names;
    std::transform(parameters_.begin(), parameters_.end(), std::back_inserter(names), std::mem_fn(&Parameter::name));
    throw InvalidInput("parameter '" + name + "': unknown; known: " + joined(names));
  }
  return *place;
}

std::vector<std::pair<std::string, std::string>> fewestSettings(const ParameterSet& set, ParameterSet defaults) {
  std::vector<std::pair<std::string, std::string>> settings;
  const auto add = [&](const Parameter& parameter) {
    settings.emplace_back(parameter.name(), textOf(parameter.value));
    defaults.set(settings.back().first, settings.back().second);
  };
  for (const Parameter& parameter : set) {  // presets first: they set others
    if (!parameter.descriptor.presets.empty() && parameter.value != defaults.at(parameter.name()).value) {
      add(parameter);
    }
  }
  for (const Parameter& parameter : set) {
    if (parameter.value != defaults.at(parameter.name()).value) {
      add(parameter);
    }
  }
  return settings;
}

bool operator==(const ParameterSet& a, const ParameterSet& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Parameter& x, const Parameter& y) { return x.name() == y.name() && x.value == y.value; });
}

}  // namespace pusht
