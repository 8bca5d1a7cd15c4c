// SPDX-License-Identifier: BSD-3-Clause
#include "live/audit_nodes.hpp"

#include <ros/init.h>
#include <ros/node_handle.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "audit/audit_run.hpp"
#include "bag/messages.hpp"
#include "live/request.hpp"
#include "pusht_task/files.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_serving/node.hpp"
#include "sim2sim_serving/node_parameters.hpp"
#include "sim2sim_serving/peer.hpp"
#include "sim2sim_serving/remote_simulator.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"

namespace sim2sim {
namespace {

using std::chrono::milliseconds;

/// A node that is to be asked.
struct WorldParameters {
  std::string services;  ///< namespace of its services
  WorldRequest asked;    ///< what it must be or become

  static WorldParameters load(pusht::ParameterReader& parameters, const std::string& role) {
    const std::string values = role + "_parameters";
    return {parameters.services(role + "_namespace", role),
            {parameters.optionalText(role, "auto"), parametersFrom(values, parameters.optionalText(values, "none"))}};
  }
};

struct AuditParameters {
  WorldParameters reference;
  WorldParameters engine;
  std::reference_wrapper<const pusht::Task> task;
  bool against_task;
  std::uint64_t seed;
  std::filesystem::path out;  ///< empty: none
  bool overwrite;
  milliseconds deadline;
  milliseconds patience;

  static AuditParameters load(pusht::ParameterReader& parameters) {
    const auto duration = [&](const char* key, double fallback) {
      return milliseconds(static_cast<std::int64_t>(1000.0 * parameters.positive(key, fallback)));
    };
    AuditParameters loaded = {WorldParameters::load(parameters, "reference"),
                              WorldParameters::load(parameters, "engine"),
                              pusht::taskNamed(parameters.text("task", pusht::fullCircle().name)),
                              againstTask(parameters),
                              parameters.seed("seed", 0),
                              parameters.optionalText("out", "none"),
                              parameters.flag("overwrite", false),
                              duration("deadline", 5.0),
                              duration("patience", 30.0)};
    if (!loaded.overwrite) {
      pusht::requireNewFile("out", loaded.out);
    }
    const WorldRequest& reference = loaded.reference.asked;
    if (loaded.against_task && !(reference.kind.empty() && reference.parameters.empty())) {
      throw pusht::InvalidInput(std::string("reference, reference_parameters: must be left out with against ") +
                                kAgainstTask);
    }
    return loaded;
  }

 private:
  static bool againstTask(pusht::ParameterReader& parameters) {
    const std::string against = parameters.optionalText("against", "none");
    if (!against.empty() && against != kAgainstTask) {
      throw pusht::InvalidInput("against '" + against + "': must be " + kAgainstTask + ", or left out");
    }
    return !against.empty();
  }
};

/// Node that serves the world under audit. It has a watchdog of its own, so each node may be asked by its own thread.
class WorldNode {
 public:
  /// Waits for the node, and makes it what is asked for. Throws as Peer::connect() and RemoteSimulator; InvalidInput if
  /// it serves a policy.
  WorldNode(const WorldParameters& world, const AuditParameters& audit)
      : watchdog_(audit.deadline), peer_(world.services, watchdog_), task_(audit.task), request_(world.asked) {
    connect(audit.patience);
    description_ = peer_.description();
    if (description_.frame_prefix.empty()) {
      throw pusht::InvalidInput(world.services + ": is the policy '" + description_.name + "', must be a simulator");
    }
    description_ = open()->describe();
    request_ = requestFor(description_);
  }

  const pusht_msgs::DescribeResponse& description() const { return description_; }
  const pusht::Task& task() const { return task_; }

  /// The node as a simulator of an audit. It must outlive that.
  AuditedSimulator simulator();

  /// The node's world, made anew. Throws as Peer::connect() and RemoteSimulator.
  std::unique_ptr<pusht::RemoteSimulator> open() {
    std::unique_ptr<pusht::RemoteSimulator> world;
    ask([&] {
      connect(watchdog_.deadline());  // what the node was before does not count
      world = std::make_unique<pusht::RemoteSimulator>(peer_, stamps_, request_.kind, request_.parameters, task_);
    });
    world->silence();
    return world;
  }

  /// Whether the node was lost in the last call.
  bool isLost() const { return lost_; }

  /// The world of a node that was lost. It has once more the time of an answer to come back. Throws WorldLost if it
  /// does not.
  std::unique_ptr<pusht::RemoteSimulator> openAgain() {
    try {
      if (!gone_) {
        return open();
      }
    } catch (const pusht::Error&) {
      gone_ = true;
    }
    throw WorldLost(loss_);
  }

  /// Runs `call`, which asks the node. Throws what it throws, and notes a loss.
  template <class Call>
  void ask(const Call& call) {
    try {
      call();
      lost_ = false;
    } catch (const pusht::PeerFault& fault) {
      lost_ = true;
      loss_ = fault.what();
      throw;
    }
  }

  /// Throws RuntimeFault if the node was lost at any time.
  void requireNeverLost() const {
    if (!loss_.empty()) {
      throw pusht::RuntimeFault(loss_);
    }
  }

  /// What the node itself says in `message`, in which the peer has put its name in front.
  std::string withoutName(const std::string& message) const {
    const std::string name = peer_.services() + ": ";
    return message.compare(0, name.size(), name) == 0 ? message.substr(name.size()) : message;
  }

 private:
  void connect(milliseconds patience) {
    peer_.connect({patience, lost_, [] { return !ros::ok() || interrupted(); }});
  }

  pusht::Watchdog watchdog_;
  pusht::Peer peer_;
  pusht::StampSource stamps_;
  const pusht::Task& task_;
  WorldRequest request_;
  pusht_msgs::DescribeResponse description_;
  bool lost_ = false;
  bool gone_ = false;  // for good
  std::string loss_;   // how it was lost last
};

/// World of a node that fails as one in this process would.
class NodeWorld : public pusht::Simulator {
 public:
  explicit NodeWorld(WorldNode& node)
      : Simulator("", pusht::startToleranceOf(node.description()), node.task()), node_(node), world_(node.open()) {}

 private:
  void doReset(const pusht::WorldState& state) override {
    if (node_.isLost()) {
      world_.reset();
      world_ = node_.openAgain();
    }
    ask([&] { world_->reset(state); });
  }
  void doStep(const pusht::Action& action) override {
    ask([&] { world_->step(action); });
  }
  pusht::WorldState doState() const override { return world_->state(); }

  template <class Call>
  void ask(const Call& call) {
    try {
      node_.ask(call);
    } catch (const pusht::RuntimeFault&) {
      throw;  // of this side: a node that is lost, another caller
    } catch (const pusht::Error& refusal) {
      throw pusht::SimulationFault(node_.withoutName(refusal.what()));
    }
  }

  WorldNode& node_;
  std::unique_ptr<pusht::RemoteSimulator> world_;
};

/// Kind of a node, if it is installed here in that version; else null.
const pusht::SimulatorKind* kindOf(const pusht_msgs::DescribeResponse& node) {
  const pusht::SimulatorKind* const kind = pusht::SimulatorKinds::installed().find(node.name);
  return kind != nullptr && kind->version == node.version ? kind : nullptr;
}

AuditedSimulator WorldNode::simulator() {
  const pusht::SimulatorKind* const kind = kindOf(description_);
  return {recordOf(description_), [this] { return std::make_unique<NodeWorld>(*this); },
          kind == nullptr ? std::vector<std::string>() : kind->departures};
}

/// Model variants of a node, in this process; none if its kind is not known here.
std::vector<AuditedWorld> variantsOfNode(const WorldNode& reference) {
  const pusht::SimulatorKind* const kind = kindOf(reference.description());
  if (kind == nullptr) {
    return {};
  }
  const pusht::Task& task = reference.task();
  return variantsOf(*kind, pusht::merged(kind->defaults(task), pusht::withoutTask(reference.description().parameters)),
                    task);
}

void requireTwoNodes(const WorldNode& reference, const WorldNode& engine, const AuditParameters& parameters) {
  if (reference.description().instance_id == engine.description().instance_id) {
    throw pusht::InvalidInput(parameters.reference.services + " and " + parameters.engine.services +
                              " are one node: each needs a world of its own");
  }
}

void auditNodes(const AuditParameters& parameters) {
  constexpr int kThreads = 2;
  requireFits(parameters.task);
  AuditRun run;
  run.task = parameters.task;
  std::optional<WorldNode> reference;
  if (!parameters.against_task) {
    reference.emplace(parameters.reference, parameters);
    run.reference = reference->simulator();
    run.variants = variantsOfNode(*reference);
  }
  WorldNode engine(parameters.engine, parameters);
  if (reference) {
    requireTwoNodes(*reference, engine, parameters);
  }
  run.engine = engine.simulator();
  run.seed = parameters.seed;
  run.threads = kThreads;
  const Audit result = carryOut(run);
  if (!ros::ok()) {
    throw pusht::RuntimeFault("shut down before the audit was done");
  }
  report(run, result, parameters.out, parameters.overwrite);
  requireContract(result);
  engine.requireNeverLost();
  if (reference) {
    reference->requireNeverLost();
  }
}

}  // namespace

pusht::ExitCode auditNodes() {
  pusht::requireClock();
  pusht::ParameterReader reader(ros::NodeHandle("~"));
  reader.enterWorkingDirectory();
  const AuditParameters parameters = AuditParameters::load(reader);
  reader.refuseUnknown();
  try {
    auditNodes(parameters);
  } catch (const pusht::NodeMissing&) {
    requireNotInterrupted();
    throw;
  }
  return pusht::ExitCode::kOk;
}

}  // namespace sim2sim
