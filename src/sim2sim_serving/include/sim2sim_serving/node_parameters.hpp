// SPDX-License-Identifier: BSD-3-Clause
/// Parameters of nodes: as messages, and on the parameter server.
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
#include "pusht_task/simulator_kind.hpp"

namespace pusht {

/// Parameters of a simulator by name, with their values as text.
using Parameters = std::vector<pusht_msgs::Parameter>;

/// Message that names a parameter and its value as text.
pusht_msgs::Parameter parameter(const std::string& name, const std::string& value);

/// Whether both texts stand for one value: "6" and "6.0" do.
bool sameValue(const std::string& a, const std::string& b);

/// Name of the parameter that every served simulator has besides those of its kind: the task of its world.
inline constexpr const char* kTaskParameter = "task";

/// Parameters of a served simulator of a kind, with their defaults: those of the kind, and the task, which results and
/// hashes have only if it is not full_circle.
ParameterSet withTask(const SimulatorKind& kind);

/// Parameters as messages, but for those that results do not have (Parameter::isRecorded()).
Parameters toMessages(const ParameterSet& parameters);
/// Description of a parameter as a message.
pusht_msgs::ParameterDescriptor toMessage(const ParameterDescriptor& descriptor);
/// Parameter as a node describes it. Throws BadDependency for an unknown type, or a default that is not of it.
ParameterDescriptor fromMessage(const pusht_msgs::ParameterDescriptor& message);

/// Throws InvalidInput with name, values and rule if `parameters` has a name twice. Otherwise one of the values would
/// be ignored silently.
void requireOnce(const Parameters& parameters);

/// `changes` on top of `parameters`, which keep their order. Throws as requireOnce() for `changes`.
Parameters changed(Parameters parameters, const Parameters& changes);

/// Task among the parameters of a node, by its name or as JSON; none: the node says of none, so it is of full_circle.
std::optional<std::string> taskIn(const Parameters& parameters);

/// Parameters of a simulator, out of those of its node: all but the task, which a run has.
Parameters withoutTask(Parameters parameters);

/// `changes` on top of `parameters`. Throws as requireOnce() and ParameterSet::set.
ParameterSet merged(ParameterSet parameters, const Parameters& changes);

/// Writes a node's parameters in force to the parameter server, typed as by valueOf(). Integers beyond the server's 32
/// bits are written as texts.
void setParameters(const ros::NodeHandle& private_handle, const Parameters& parameters);

/// Value of `key` on the parameter server as text; none if there is none, or no single value.
std::optional<std::string> storedText(const std::string& key);

/// Namespace of services that `name` resolves to in this node. Throws InvalidInput with `what`, the name and the rule
/// for a name that is not valid.
std::string serviceName(const std::string& what, const std::string& name);

/// Takes note of the private parameters that a command line sets (`_out:=here`), before ros::init() writes them to the
/// parameter server and takes them away.
void takeCommandLine(int argc, char** argv);

/// Removes from the parameter server what the command line and setParameters() have set there.
void removeOwnParameters();

/// The private parameters of a node as they are when it starts. Every getter throws InvalidInput, naming the key with
/// its namespace, the value and the rule, if the value is not of its type; and, if this process has not set it, how to
/// remove it from the parameter server, where an earlier node may have left it.
class ParameterReader {
 public:
  explicit ParameterReader(const ros::NodeHandle& private_handle);

  std::string text(const std::string& key, const std::string& fallback);
  /// A text that may be left out: empty if it is, or if it is the word `absent`. An empty one is refused: it may be a
  /// variable of a shell that is not set.
  std::string optionalText(const std::string& key, const std::string& absent);
  /// Namespace of services; throws as serviceName().
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

  /// Changes to the folder `working_directory`, the user's current one, so that relative paths mean the same here.
  void enterWorkingDirectory();

  /// Throws InvalidInput for a parameter that no getter has asked for, with the known ones.
  void refuseUnknown() const;

 private:
  const XmlRpc::XmlRpcValue* find(const std::string& key);
  std::string originOf(const std::string& key) const;
  [[noreturn]] void refuse(const std::string& key, const std::string& rule) const;

  std::string namespace_;
  std::map<std::string, XmlRpc::XmlRpcValue> values_;
  std::set<std::string> known_;
};

}  // namespace pusht
