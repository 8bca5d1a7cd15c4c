// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/live/audit_nodes.hpp"

#include <ros/init.h>
#include <ros/node_handle.h>

#include <chrono>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pusht_policy/scripted_expert.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/ros/node.hpp"
#include "pusht_task/ros/parameters.hpp"
#include "pusht_task/ros/peer.hpp"
#include "pusht_task/ros/served_simulator.hpp"
#include "pusht_task/ros/simulator_kinds.hpp"
#include "sim2sim_audit/audit.hpp"
#include "sim2sim_audit/audit_json.hpp"
#include "sim2sim_eval/bag/messages.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/model_variants.hpp"
#include "sim2sim_protocol/results/audit_files.hpp"

namespace sim2sim {
namespace {

struct AuditParameters {
  std::string reference;  ///< namespace of services
  std::string engine;     ///< namespace of services
  std::uint64_t seed;
  std::filesystem::path out;  ///< empty: none
  std::chrono::milliseconds deadline;
  std::chrono::milliseconds patience;

  static AuditParameters load(pusht::ParameterReader& parameters) {
    const auto milliseconds = [&](const char* key, double fallback) {
      return std::chrono::milliseconds(static_cast<std::int64_t>(1000.0 * parameters.positive(key, fallback)));
    };
    return {parameters.services("reference", "/reference"),
            parameters.services("engine", "/engine"),
            parameters.seed("seed", 0),
            parameters.text("out", ""),
            milliseconds("deadline", 5.0),
            milliseconds("patience", 30.0)};
  }
};

/// A node that serves a world. It has a watchdog of its own, so each may be asked by a thread of its own.
class WorldNode {
 public:
  WorldNode(const std::string& services, const AuditParameters& parameters)
      : watchdog_(parameters.deadline), peer_(services, watchdog_) {
    peer_.connect({parameters.patience, false, [] { return !ros::ok() || interrupted(); }});
    if (description().frame_prefix.empty()) {
      throw pusht::InvalidInput(services + ": is the policy '" + description().name + "', must be a simulator");
    }
  }

  const pusht_msgs::DescribeResponse& description() const { return peer_.description(); }

  /// The world as a simulator, which shows nothing of its experiments.
  AuditedWorld world() {
    return {peer_.services() + " (" + description().name + ")",
            [this] {
              auto world = std::make_unique<pusht::ServedSimulator>(peer_, stamps_);
              world->announce(0, pusht::kHorizon);
              world->silence();
              return world;
            },
            false};
  }

 private:
  pusht::Watchdog watchdog_;
  pusht::Peer peer_;
  pusht::StampSource stamps_;
};

/// Model variants of a node, in this process; none if its kind is not installed here.
std::vector<AuditedWorld> variantsOf(const pusht_msgs::DescribeResponse& reference) {
  std::vector<AuditedWorld> variants;
  if (const pusht::SimulatorKind* const kind = pusht::SimulatorKinds::installed().find(reference.name)) {
    for (const LoadedVariant& variant :
         loadDefaultVariants(*kind, pusht::merged(kind->defaults(), reference.parameters))) {
      variants.push_back({variant.name, variant.model.make_world});
    }
  }
  return variants;
}

}  // namespace

pusht::ExitCode auditNodes() {
  pusht::requireClock();
  const ros::NodeHandle node("~");
  pusht::ParameterReader reader(node);
  reader.enterWorkingDirectory();
  const AuditParameters parameters = AuditParameters::load(reader);
  reader.refuseUnknown();
  WorldNode reference(parameters.reference, parameters);
  WorldNode engine(parameters.engine, parameters);
  const SimulatorRecord reference_record = recordOf(reference.description());
  const SimulatorRecord engine_record = recordOf(engine.description());
  constexpr int kThreads = 2;
  pusht::ScriptedExpert expert;
  const Audit result =
      audit(reference.world(), engine.world(), variantsOf(reference.description()), parameters.seed, kThreads, &expert);
  requireNotInterrupted();
  std::cout << textOf(result) << std::flush;
  if (!parameters.out.empty()) {
    pusht::writeFile(parameters.out, auditText(toJson(result), reference_record, engine_record));
  }
  if (result.hasContractErrors()) {
    throw pusht::ContractError("the contract is broken: " + causeOf(result.findings().front()));
  }
  return pusht::ExitCode::kOk;
}

}  // namespace sim2sim
