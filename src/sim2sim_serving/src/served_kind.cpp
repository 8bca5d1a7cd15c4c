// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/served_kind.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/physics_numbers.hpp"
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

/// Whether it is a number of the task, as those of this suite's kinds are: by its name and full_circle's value.
bool isOfTask(const ParameterDescriptor& descriptor) {
  const std::vector<PhysicsNumber>& numbers = physicsNumbers();
  return std::any_of(numbers.begin(), numbers.end(), [&](const PhysicsNumber& number) {
    return number.descriptor.name == descriptor.name && number.descriptor.default_value == descriptor.default_value;
  });
}

/// Parameters that a node describes, but for the task: a run has that, not a simulator.
std::vector<ParameterDescriptor> descriptorsOf(const pusht_msgs::DescribeResponse& node) {
  std::vector<ParameterDescriptor> descriptors;
  for (const pusht_msgs::ParameterDescriptor& message : node.parameter_descriptors) {
    if (message.name != kTaskParameter) {
      descriptors.push_back(fromMessage(message));
      descriptors.back().of_task = isOfTask(descriptors.back());
    }
  }
  return descriptors;
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
    kind_.name = first_.name;
    kind_.title = first_.title.empty() ? first_.name : first_.title;
    kind_.version = first_.version;
    kind_.parameters = descriptorsOf(taskIn(first_.parameters) ? asItBegins() : first_);
    kind_.start_tolerance = startToleranceOf(first_);
    kind_.tasks.clear();  // the node refuses those that it does not hold
    code_ = codeOf(first_);
  }

  /// The kind that it serves, but for its loader.
  const SimulatorKind& kind() const { return kind_; }
  const nlohmann::json& code() const { return code_; }

  /// Throws PeerFault if the node was replaced, or the master has died.
  void requireThere() const { peer_.requireSameOwner(); }

  /// The node's world with these parameters, in a task, taken over.
  std::unique_ptr<RemoteSimulator> open(const ParameterSet& parameters, const Task& task) {
    connect(true);
    Parameters changes;
    for (const auto& [name, value] : fewestSettings(parameters, kind_.defaults(task))) {
      changes.push_back(parameter(name, value));
    }
    auto world = std::make_unique<RemoteSimulator>(peer_, stamps_, first_.name, changes, task);
    requireSameCode(world->describe());
    world->silence();
    return world;
  }

  /// Parameters as the node reads them in a task, and its provenance with them.
  const std::pair<ParameterSet, nlohmann::json>& accepted(const ParameterSet& parameters, const Task& task) {
    std::string key = textOf(task) + '\0';
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
  /// What the node says of itself in the task in which it begins: some caller has left it in another, in which its
  /// numbers have other defaults.
  pusht_msgs::DescribeResponse asItBegins() {
    pusht_msgs::DescribeRequest request;
    request.kind = first_.name;
    return ServiceCaller<pusht_msgs::Describe>(peer_, "describe").call(request);
  }

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
  SimulatorKind kind_;
  nlohmann::json code_;
  std::map<std::string, std::pair<ParameterSet, nlohmann::json>> accepted_;  // by task and values
};

/// World of a node that fails as one in this process would.
class ServedWorld : public Simulator {
 public:
  ServedWorld(std::shared_ptr<ServedNode> node, const ParameterSet& parameters, const Task& task)
      : Simulator("", node->kind().start_tolerance, task),
        node_(std::move(node)),
        world_(node_->open(parameters, task)) {}

  const gym_pusht::State* stateInPixels() const override { return world_->stateInPixels(); }

 private:
  void doReset(const WorldState& state) override {
    node_->requireThere();
    ask([&] { world_->reset(state); });
  }
  void doSpawn(const WorldState& /*start*/, std::uint64_t seed) override {
    node_->requireThere();
    ask([&] { world_->spawn(seed); });
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
  SimulatorKind kind = node->kind();
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
