// SPDX-License-Identifier: BSD-3-Clause
/// The private parameters of a node.
#pragma once

#include <pusht_msgs/Parameter.h>
#include <pusht_msgs/ParameterDescriptor.h>
#include <ros/node_handle.h>

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pusht_task/parameters.hpp"

namespace pusht {

/// As pusht_msgs/Parameter: knobs and switches of a simulator, by name, with their values as text.
using Parameters = std::vector<pusht_msgs::Parameter>;

pusht_msgs::Parameter parameter(const std::string& name, const std::string& value);

/// Whether both texts stand for one value: "6" and "6.0" do.
bool sameValue(const std::string& a, const std::string& b);

/// As messages.
Parameters toMessages(const ParameterSet& parameters);
pusht_msgs::ParameterDescriptor toMessage(const ParameterDescriptor& descriptor);

/// Throws InvalidInput with name, values and rule if one of `parameters` is named twice: one of its values would count
/// without a word.
void requireOnce(const Parameters& parameters);

/// `changes` on top of `parameters`, which keep their order. Throws as requireOnce() for `changes`.
Parameters changed(Parameters parameters, const Parameters& changes);

/// `changes` on top of `parameters`. Throws as requireOnce() and ParameterSet::set.
ParameterSet merged(ParameterSet parameters, const Parameters& changes);

/// Makes the parameters of a node those that it works with, typed as valueOf() says. The parameter server's integers
/// have 32 bits; others stay texts.
void setParameters(const ros::NodeHandle& private_handle, const Parameters& parameters);

/// The text of what the parameter server holds as `key`; none if it holds nothing there, or no single value.
std::optional<std::string> storedText(const std::string& key);

/// The namespace of services that `name` stands for here. Throws InvalidInput with `what`, the name and the rule if it
/// is none.
std::string serviceName(const std::string& what, const std::string& name);

/// The private parameters of a node as they are when it starts. Every getter throws InvalidInput, naming the key with
/// its namespace, the value and the rule, if the value is not of its type.
class ParameterReader {
 public:
  explicit ParameterReader(const ros::NodeHandle& private_handle);

  std::string text(const std::string& key, const std::string& fallback);
  /// As serviceName().
  std::string services(const std::string& key, const std::string& fallback);
  bool flag(const std::string& key, bool fallback);
  /// A text that is an integer is accepted: as text, 010 stays what the user wrote, and is refused.
  int integer(const std::string& key, int fallback);
  /// Integers are accepted.
  double real(const std::string& key, double fallback);
  /// A real that is finite and above 0.
  double positive(const std::string& key, double fallback);
  /// A uint64 as text, since integers of the parameter server have 32 bits; those are accepted too.
  std::uint64_t seed(const std::string& key, std::uint64_t fallback);

  /// `parameters`, changed where there is one of that name. Throws as ParameterSet::set.
  ParameterSet changed(ParameterSet parameters);

  /// Makes relative paths mean what they mean to the user: the parameter `working_directory` is where he stands.
  void enterWorkingDirectory();

  /// Throws InvalidInput for a parameter that nobody has asked for, with those that there are.
  void refuseUnknown() const;

 private:
  const XmlRpc::XmlRpcValue* find(const std::string& key);
  [[noreturn]] void refuse(const std::string& key, const std::string& rule) const;

  std::string namespace_;
  std::map<std::string, XmlRpc::XmlRpcValue> values_;
  std::set<std::string> known_;
};

}  // namespace pusht
