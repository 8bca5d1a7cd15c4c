// SPDX-License-Identifier: BSD-3-Clause
/// Rules of a served simulator, without a node: functions from request to response.
#pragma once

#include <pusht_msgs/Configure.h>
#include <pusht_msgs/Describe.h>
#include <pusht_msgs/Reset.h>
#include <pusht_msgs/Step.h>
#include <pusht_msgs/WorldStateStamped.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "pusht_task/simulator_kind.hpp"
#include "sim2sim_serving/node_parameters.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"

namespace pusht {

/// Served world: accepts or refuses requests by the rules that the services of pusht_msgs state, and answers them. A
/// refused request changes nothing; its answer has no success, a message and an exit code. Not thread-safe.
class SimulatorSession {
 public:
  using Observer = std::function<void(const pusht_msgs::WorldStateStamped&)>;

  /// `observer` gets the world after every reset and step that was taken (not in silent episodes, nor for an answer
  /// given again). The world can become one of any of `kinds`, which must outlive it; without any it stays of its own.
  /// Throws as the kind does that refuses `parameters`.
  SimulatorSession(SimulatorKind kind, const ParameterSet& parameters, std::string frame_prefix, Observer observer,
                   const SimulatorKinds* kinds = nullptr);

  pusht_msgs::ResetResponse reset(const pusht_msgs::ResetRequest& request);
  pusht_msgs::StepResponse step(const pusht_msgs::StepRequest& request);
  pusht_msgs::ConfigureResponse configure(const pusht_msgs::ConfigureRequest& request);
  pusht_msgs::DescribeResponse describe(const pusht_msgs::DescribeRequest& request = {}) const;

 private:
  /// The episode under way.
  struct Episode {
    std::uint64_t index;
    std::uint32_t horizon;  // [control steps]
    std::uint32_t steps;    // taken
    bool failed;            // the simulation did, in the last step
    pusht_msgs::ResetRequest begin;
    pusht_msgs::ResetResponse begun;
    pusht_msgs::StepRequest last;    // request of step `steps` - 1
    pusht_msgs::StepResponse taken;  // its answer
  };

  /// Last change of kind or parameters, if no reset has followed.
  struct Configuration {
    pusht_msgs::ConfigureRequest request;
    pusht_msgs::ConfigureResponse answer;
  };

  bool isRepeated(const pusht_msgs::ResetRequest& request) const;
  bool isRepeated(const pusht_msgs::StepRequest& request) const;
  bool isRepeated(const pusht_msgs::ConfigureRequest& request) const;
  void requireHold(const std::string& token) const;
  void requireStep(const pusht_msgs::StepRequest& request) const;
  ros::Time nextStamp(const ros::Time& requested, const std::string& token) const;
  void observe(const Action& action) const;
  bool inEpisode() const;
  const SimulatorKind& kindFor(const std::string& name) const;

  const SimulatorKinds* kinds_;  // null: it stays of its own
  SimulatorKind kind_;
  SimulatorModel model_;
  std::unique_ptr<Simulator> world_;
  std::string frame_prefix_;
  std::string instance_id_;
  Observer observer_;
  ros::Time stamp_;
  std::optional<Episode> episode_;
  std::optional<Configuration> configuration_;  // empty once the world was reset
};

/// Description of a node that failed at its start.
pusht_msgs::DescribeResponse describeFailure(const std::exception& failure);

}  // namespace pusht
