// SPDX-License-Identifier: BSD-3-Clause
/// Parameters of a kind of simulator: their descriptors and their values.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "pusht_task/error.hpp"

namespace pusht {

/// Value of a parameter: true or false, an integer, a finite real, or a text.
using ParameterValue = std::variant<bool, std::int64_t, double, std::string>;

/// Value of a text without a descriptor: true or false, an integer, a finite real, else the text. "20.0" is a real.
ParameterValue valueOf(const std::string& text);

/// Text that reads back as `value`: "true", "20", "20.0", "shaped".
std::string textOf(const ParameterValue& value);

/// Preset: a word that sets the listed parameters, except those that are set by name.
struct Preset {
  std::string word;
  std::vector<std::pair<std::string, std::string>> settings;  ///< names and texts
};

/// Descriptor of a parameter: its meaning and the values that it takes.
struct ParameterDescriptor {
  std::string name;
  std::string unit;              ///< empty: none
  std::string meaning;           ///< a phrase for people
  ParameterValue default_value;  ///< every value is of its type

  // Range of a number, both ends included, and the reason for its ends.
  double least = -std::numeric_limits<double>::infinity();
  double greatest = std::numeric_limits<double>::infinity();
  std::string reason{};

  /// Words that a text may be; empty: any text.
  std::vector<std::string> words{};

  /// Presets of a text's words. The parameters that they set must default to the values of the default word.
  std::vector<Preset> presets{};

  /// Numbers that a real may be, between `least` and `greatest`; empty: any number in the range.
  std::vector<double> numbers{};

  bool of_task = false;          ///< whether it is a number of the task: its default is the task's at hand
  bool only_if_changed = false;  ///< whether results and hashes have it only if it differs from its default

  /// "real", "integer", "boolean" or "text".
  const char* type() const;

  /// Values that it takes, in words: "from 0.0 to 100.0 [1/s]", "at least 1", "true or false", "one of: a, b".
  /// Empty: every value of its type.
  std::string range() const;

  /// Value of `text`; an integer is a real, too. Throws InvalidInput with name, text and rule if it is no value that
  /// the parameter takes.
  ParameterValue read(const std::string& text) const;

  /// Throws InvalidInput with name, value and rule if `value`, of the parameter's type, is out of range or no word.
  void require(const ParameterValue& value) const;
};

/// Parameter with its value.
struct Parameter {
  ParameterDescriptor descriptor;
  ParameterValue value;
  bool set_by_name = false;  ///< set by its own name; presets leave it

  const std::string& name() const { return descriptor.name; }
  bool isDefault() const { return value == descriptor.default_value; }
  /// Whether results and hashes have it.
  bool isRecorded() const { return !(descriptor.only_if_changed && isDefault()); }
};

/// Parameters of a kind, in its order, each with a value.
class ParameterSet {
 public:
  ParameterSet() = default;
  /// Parameters with their defaults.
  explicit ParameterSet(const std::vector<ParameterDescriptor>& descriptors);

  /// Sets a parameter, and the parameters of its preset unless these are set by name, in any order of calls. Throws
  /// InvalidInput for an unknown name, with the known ones, or as ParameterDescriptor::read().
  void set(const std::string& name, const std::string& text);

  /// Gives a parameter another default, and this value unless it is set by name. Throws InvalidInput for an unknown
  /// name.
  void setDefault(const std::string& name, const ParameterValue& value);

  /// Parameter with this name. Throws InvalidInput for an unknown name.
  const Parameter& at(const std::string& name) const;

  /// Value of a parameter. Throws std::bad_variant_access unless `Value` is its type.
  template <class Value>
  const Value& get(const std::string& name) const {
    return std::get<Value>(at(name).value);
  }

  /// Whether there is a parameter of this name.
  bool has(const std::string& name) const;

  /// Adds a parameter that is of no kind.
  void add(Parameter parameter) { parameters_.push_back(std::move(parameter)); }

  bool empty() const { return parameters_.empty(); }
  auto begin() const { return parameters_.begin(); }
  auto end() const { return parameters_.end(); }

 private:
  Parameter& place(const std::string& name);

  std::vector<Parameter> parameters_;
};

/// Fewest settings, as names and values, that make `set` from `defaults`: presets, and what differs from them.
std::vector<std::pair<std::string, std::string>> fewestSettings(const ParameterSet& set, ParameterSet defaults);

/// Whether names and values are the same.
bool operator==(const ParameterSet& a, const ParameterSet& b);

}  // namespace pusht
