// SPDX-License-Identifier: BSD-3-Clause
/// Rules of a served policy, without a node: functions from request to response.
#pragma once

#include <pusht_msgs/Act.h>
#include <pusht_msgs/Describe.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <unordered_map>
#include <vector>

#include "pusht_task/policy.hpp"
#include "pusht_task/task.hpp"

namespace pusht {

/// Policy of a policy node, with its description.
struct PolicyModel {
  std::string name;  ///< name in metrics.json
  std::string version;
  std::unique_ptr<Policy> policy;
  nlohmann::json provenance = nlohmann::json::object();    ///< all that the numbers depend on
  std::reference_wrapper<const Task> task = fullCircle();  ///< in which it acts
};

/// Served policy. It keeps the policy's memory of each rollout, from step 0 on. Not thread-safe.
class PolicySession {
 public:
  explicit PolicySession(PolicyModel model);

  pusht_msgs::ActResponse act(const pusht_msgs::ActRequest& request);
  pusht_msgs::DescribeResponse describe() const;

 private:
  struct Remembered {
    std::unique_ptr<Policy::Memory> memory;
    std::int64_t step = -1;  // last one answered
    pusht_msgs::Query::_observation_type observation{};
    std::uint64_t last_request = 0;  // last request that asked for it
    Action action{};                 // its answer
  };

  using Memories = std::vector<std::unique_ptr<Policy::Memory>>;

  bool isRepeated(const pusht_msgs::Query& query) const;
  void require(const pusht_msgs::ActRequest& request) const;
  /// Memories of the rollouts that begin, by query; null for others. Throws what begin() throws, before anything
  /// changes.
  Memories memoriesOf(const pusht_msgs::ActRequest& request) const;
  /// Fills the actions of the queries. If the policy fails, it may have gone half a step: the rollouts are forgotten.
  void actOrForget(const pusht_msgs::ActRequest& request);
  Policy::Query begun(const pusht_msgs::Query& query, std::unique_ptr<Policy::Memory> memory);
  void forgetEnded();

  PolicyModel model_;
  std::string instance_id_;
  bool has_memory_;
  std::uint64_t requests_ = 0;
  std::unordered_map<std::uint64_t, Remembered> rollouts_;  // only of a policy with a memory
  std::vector<Policy::Query> queries_;
  std::vector<Action> actions_;
};

}  // namespace pusht
