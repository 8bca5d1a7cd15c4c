// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/served_kind.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "pusht_task/error.hpp"
#include "sim2sim_serving/conversions.hpp"
#include "sim2sim_serving/node.hpp"
#include "sim2sim_serving/node_parameters.hpp"
#include "sim2sim_serving/peer.hpp"
#include "sim2sim_serving/remote_simulator.hpp"

namespace pusht {
namespace {

constexpr std::chrono::seconds kGlance{1};  // wait for a node that was waited for in vain

/// What a node says of its code: all that its numbers depend on but for its parameters.
nlohmann::json codeOf(const pusht_msgs::DescribeResponse& node) {
  nlohmann::json provenance = provenanceOf(node);
  for (const pusht_msgs::Parameter& parameter : node.parameters) {
    provenance.erase(parameter.name);  // its file
  }
  provenance.erase("version");
  return {{"simulator", node.name}, {"version", node.version}, {"provenance", provenance}};
}

/// Parameters that a node describes, but for the task: a run has that, not a simulator.
std::vector<ParameterDescriptor> descriptorsOf(const pusht_msgs::DescribeResponse& node) {
  std::vector<ParameterDescriptor> descriptors;
  for (const pusht_msgs::ParameterDescriptor& descriptor : node.parameter_descriptors) {
    if (descriptor.name != kTaskParameter) {
      descriptors.push_back(fromMessage(descriptor));
    }
  }
  return descriptors;
}

/// Whether a node says of a task, as those in another one than full_circle do.
bool saysTask(const pusht_msgs::DescribeResponse& node) {
  return std::any_of(node.parameters.begin(), node.parameters.end(),
                     [](const auto& parameter) { return parameter.name == kTaskParameter; });
}

/// Node of a simulator. One thread at a time has it.
class ServedNode {
 public:
  ServedNode(const std::string& services, const NodeTimes& times, std::function<bool()> stop)
      : times_(times), stop_(std::move(stop)), watchdog_(times.deadline), peer_(services, watchdog_) {
    connect(false);
    first_ = peer_.description();
    if (first_.frame_prefix.empty()) {
      throw InvalidInput(services + ": is the policy '" + first_.name + "', must be a simulator");
    }
    if (first_.parameter_descriptors.size() != first_.parameters.size()) {
      throw BadDependency(services + ": describes " + std::to_string(first_.parameter_descriptors.size()) + " of its " +
                          std::to_string(first_.parameters.size()) +
                          " parameters: must describe all, so that their defaults are known");
    }
    if (saysTask(first_)) {  // some caller has left it in a task, in which its numbers are others
      pusht_msgs::DescribeRequest as_it_begins;
      as_it_begins.kind = first_.name;
      descriptors_ = descriptorsOf(ServiceCaller<pusht_msgs::Describe>(peer_, "describe").call(as_it_begins));
    } else {
      descriptors_ = descriptorsOf(first_);
    }
    defaults_ = ParameterSet(descriptors_);
    code_ = codeOf(first_);
  }

  const pusht_msgs::DescribeResponse& description() const { return first_; }
  const std::vector<ParameterDescriptor>& descriptors() const { return descriptors_; }
  const nlohmann::json& code() const { return code_; }

  /// Throws PeerFault if the node was replaced, or the master has died.
  void requireThere() const { peer_.requireSameOwner(); }

  /// The node's world with these parameters, in a task, taken over.
  std::unique_ptr<RemoteSimulator> open(const ParameterSet& parameters, const Task& task) {
    connect(true);
    Parameters changes;
    for (const auto& [name, value] : fewestSettings(parameters, defaults_)) {
      changes.push_back(parameter(name, value));
    }
    auto world = std::make_unique<RemoteSimulator>(peer_, stamps_, first_.name, changes, task);
    requireSameCode(world->describe());
    world->silence();
    return world;
  }

  /// Parameters as the node reads them in a task, and its provenance with them.
  const std::pair<ParameterSet, nlohmann::json>& accepted(const ParameterSet& parameters, const Task& task) {
    std::string key = textOf(task);
    for (const Parameter& parameter : parameters) {
      key.append(textOf(parameter.value)).append(1, '\0');
    }
    auto known = accepted_.find(key);
    if (known == accepted_.end()) {
      const pusht_msgs::DescribeResponse now = open(parameters, task)->describe();
      nlohmann::json provenance = provenanceOf(now);
      provenance["node"] = peer_.services();
      ParameterSet read = merged(ParameterSet(descriptorsOf(now)), withoutTask(now.parameters));
      known = accepted_.emplace(key, std::pair(std::move(read), std::move(provenance))).first;
    }
    return known->second;
  }

 private:
  /// Waits for the node; a dead one may come back if it was there `before`.
  void connect(bool before) {
    becomeNode();
    const std::chrono::milliseconds patience = in_vain_ ? kGlance : times_.patience;
    in_vain_ = true;
    try {
      peer_.connect({patience, before, stop_});
    } catch (const NodeMissing&) {
      if (stop_()) {
        throw RuntimeFault("interrupted while " + peer_.services() + " was waited for");
      }
      throw;
    }
    in_vain_ = false;
  }

  void requireSameCode(const pusht_msgs::DescribeResponse& now) const {
    const nlohmann::json code = codeOf(now);
    for (const auto& [key, before] : code_.items()) {
      if (code.at(key) != before) {
        throw BadDependency(peer_.services() + ": has the " + key + " " + code.at(key).dump() + ": must have " +
                            before.dump() + ", as it said before");
      }
    }
  }

  NodeTimes times_;
  std::function<bool()> stop_;
  Watchdog watchdog_;
  Peer peer_;
  StampSource stamps_;
  bool in_vain_ = false;  // whether the last wait was
  pusht_msgs::DescribeResponse first_;
  std::vector<ParameterDescriptor> descriptors_;
  ParameterSet defaults_;
  nlohmann::json code_;
  std::map<std::string, std::pair<ParameterSet, nlohmann::json>> accepted_;  // by task and values
};

/// World of a node that fails as one in this process would.
class ServedWorld : public Simulator {
 public:
  ServedWorld(std::shared_ptr<ServedNode> node, const ParameterSet& parameters, const Task& task)
      : Simulator("", startToleranceOf(node->description()), task),
        node_(std::move(node)),
        world_(node_->open(parameters, task)) {}

 private:
  void doReset(const WorldState& state) override {
    node_->requireThere();
    ask([&] { world_->reset(state); });
  }
  void doStep(const Action& action) override {
    ask([&] { world_->step(action); });
  }
  WorldState doState() const override { return world_->state(); }

  template <class Call>
  static void ask(const Call& call) {
    try {
      call();
    } catch (const RuntimeFault&) {
      throw;  // of this side: a node that is lost, another caller
    } catch (const Error& refusal) {
      throw SimulationFault(refusal.what());
    }
  }

  std::shared_ptr<ServedNode> node_;
  std::unique_ptr<RemoteSimulator> world_;
};

}  // namespace

ServedKind servedKind(const std::string& services, const NodeTimes& times, std::function<bool()> stop) {
  const auto node = std::make_shared<ServedNode>(serviceName("node", services), times, std::move(stop));
  const pusht_msgs::DescribeResponse& description = node->description();
  SimulatorKind kind;
  kind.name = description.name;
  kind.title = description.title.empty() ? description.name : description.title;
  kind.version = description.version;
  kind.parameters = node->descriptors();
  kind.start_tolerance = startToleranceOf(description);
  kind.tasks.clear();  // the node refuses those that it does not hold
  kind.loader = [node](const ParameterSet& asked, const Task& task) {
    const auto& [parameters, provenance] = node->accepted(asked, task);
    SimulatorModel model = modelOfWorlds(parameters, [node, parameters = parameters, &task] {
      return std::make_unique<ServedWorld>(node, parameters, task);
    });
    model.provenance = provenance;
    return model;
  };
  return {std::move(kind), node->code()};
}

}  // namespace pusht
