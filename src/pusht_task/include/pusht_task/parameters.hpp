// SPDX-License-Identifier: BSD-3-Clause
/// The parameters of a kind of simulator: what each of them is, and a value for each.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "pusht_task/error.hpp"

namespace pusht {

/// true or false, an integer, a finite real, or a text.
using ParameterValue = std::variant<bool, std::int64_t, double, std::string>;

/// What a text shows by itself: true or false, an integer, a finite real; else the text itself. "20.0" is a real.
ParameterValue valueOf(const std::string& text);

/// The text that reads back as `value`: "true", "20", "20.0", "shaped".
std::string textOf(const ParameterValue& value);

/// What a word sets: the parameters that it names, unless they are set by name.
struct Preset {
  std::string word;
  std::vector<std::pair<std::string, std::string>> settings;  ///< names and texts
};

/// What a parameter is, and which values it takes.
struct ParameterDescriptor {
  std::string name;
  std::string unit;              ///< empty: none
  std::string meaning;           ///< a phrase for people
  ParameterValue default_value;  ///< every value is of its type

  // Of a number: where its range ends, and why.
  double least = -std::numeric_limits<double>::infinity();
  double greatest = std::numeric_limits<double>::infinity();
  std::string reason{};

  /// Of a text: what it may be; empty: anything.
  std::vector<std::string> words{};

  /// Of a text: what its words set besides. The parameters that they set must default to what the default word sets.
  std::vector<Preset> presets{};

  /// "real", "integer", "boolean" or "text".
  const char* type() const;

  /// Values that it takes, in words: "from 0.0 to 100.0 [1/s]", "at least 1", "true or false", "one of: a, b". Empty:
  /// every value of its type.
  std::string range() const;

  /// The value that `text` stands for; an integer is a real, too. Throws InvalidInput with name, text and rule if it
  /// stands for none that the parameter takes.
  ParameterValue read(const std::string& text) const;

  /// Throws InvalidInput with name, value and rule if `value`, of the parameter's type, is none of those.
  void require(const ParameterValue& value) const;
};

/// A parameter that has a value.
struct Parameter {
  ParameterDescriptor descriptor;
  ParameterValue value;
  bool set_by_name = false;  ///< a preset does not change it any more

  const std::string& name() const { return descriptor.name; }
  bool isDefault() const { return value == descriptor.default_value; }
};

/// The parameters of a kind, in its order, each with a value.
class ParameterSet {
 public:
  ParameterSet() = default;
  /// With their defaults.
  explicit ParameterSet(const std::vector<ParameterDescriptor>& descriptors);

  /// And what its preset sets, whichever comes first. Throws InvalidInput if there is none of that name (the message
  /// says which there are), or as ParameterDescriptor::read.
  void set(const std::string& name, const std::string& text);

  /// Throws InvalidInput if there is none of that name.
  const Parameter& at(const std::string& name) const;

  /// Of the parameter's type, or std::bad_variant_access is thrown.
  template <class Value>
  const Value& get(const std::string& name) const {
    return std::get<Value>(at(name).value);
  }

  bool empty() const { return parameters_.empty(); }
  auto begin() const { return parameters_.begin(); }
  auto end() const { return parameters_.end(); }

 private:
  Parameter& place(const std::string& name);

  std::vector<Parameter> parameters_;
};

/// Whether names and values are the same.
bool operator==(const ParameterSet& a, const ParameterSet& b);

}  // namespace pusht
