// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/policy_session.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

#include "pusht_task/clipped.hpp"
#include "pusht_task/error.hpp"
#include "sim2sim_serving/node.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace pusht {
namespace {

/// Number of rollouts above which those that were not asked for lately are forgotten: callers do not say when one ends.
constexpr std::size_t kManyRollouts = 1'024;
constexpr std::uint64_t kLately = 1'000;  // requests

}  // namespace

PolicySession::PolicySession(PolicyModel model)
    : model_(std::move(model)), instance_id_(newInstanceId()), has_memory_(model_.policy->begin({}) != nullptr) {}

pusht_msgs::ActResponse PolicySession::act(const pusht_msgs::ActRequest& request) {
  pusht_msgs::ActResponse response;
  response.instance_id = instance_id_;
  try {
    forgetEnded();
    require(request);
    Memories memories = memoriesOf(request);
    queries_.clear();
    for (std::size_t i = 0; i < request.queries.size(); ++i) {
      if (!isRepeated(request.queries[i])) {
        queries_.push_back(begun(request.queries[i], std::move(memories[i])));
      }
    }
    actions_.resize(queries_.size());
    actOrForget(request);
  } catch (const std::exception& refusal) {
    response.message = clipped(refusal.what());
    response.exit_code = static_cast<int>(exitCodeOf(refusal));
    return response;
  }

  std::size_t next = 0;
  response.actions.reserve(2 * request.queries.size());
  for (const pusht_msgs::Query& query : request.queries) {
    const Action action = isRepeated(query) ? rollouts_.at(query.rollout).action : actions_.at(next++);
    if (has_memory_) {
      Remembered& rollout = rollouts_.at(query.rollout);
      rollout.step = query.step;
      rollout.observation = query.observation;
      rollout.last_request = requests_;
      rollout.action = action;
    }
    response.actions.insert(response.actions.end(), action.begin(), action.end());
  }
  response.success = 1;
  return response;
}

bool PolicySession::isRepeated(const pusht_msgs::Query& query) const {
  if (!has_memory_) {
    return false;  // asked again, it answers the same
  }
  const auto rollout = rollouts_.find(query.rollout);
  return rollout != rollouts_.end() && query.step > 0 && rollout->second.step == query.step &&
         rollout->second.observation == query.observation;
}

void PolicySession::require(const pusht_msgs::ActRequest& request) const {
  std::set<std::uint64_t> seen;
  for (const pusht_msgs::Query& query : request.queries) {
    const std::string who = "rollout " + std::to_string(query.rollout);
    if (!std::all_of(query.observation.begin(), query.observation.end(), [](float x) { return std::isfinite(x); })) {
      throw InvalidInput(who + ": observation must be finite");
    }
    if (!has_memory_) {
      continue;
    }
    if (!seen.insert(query.rollout).second) {
      throw InvalidInput(who + ": must be asked for once in a request");
    }
    const auto rollout = rollouts_.find(query.rollout);
    const std::int64_t expected = rollout == rollouts_.end() ? 0 : rollout->second.step + 1;
    if (query.step != 0 && query.step + 1 == expected && !isRepeated(query)) {
      throw InvalidInput(who + ": step " + std::to_string(query.step) + ": was answered for another observation");
    }
    if (query.step != 0 && query.step != expected && !isRepeated(query)) {
      throw InvalidInput(who + ": step " + std::to_string(query.step) + ": expected " + std::to_string(expected));
    }
  }
}

PolicySession::Memories PolicySession::memoriesOf(const pusht_msgs::ActRequest& request) const {
  constexpr std::uint32_t kMost = std::numeric_limits<int>::max();
  Memories memories(request.queries.size());
  for (std::size_t i = 0; i < memories.size(); ++i) {
    const pusht_msgs::Query& query = request.queries[i];
    if (query.step == 0) {
      try {
        if (query.execute > kMost) {
          throw InvalidInput("execute " + std::to_string(query.execute) + ": must be below 2^31");
        }
        memories[i] = model_.policy->begin({query.seed, static_cast<int>(query.execute)});
      } catch (Error& error) {
        error.addContext("rollout " + std::to_string(query.rollout));
        throw;
      }
    }
  }
  return memories;
}

void PolicySession::actOrForget(const pusht_msgs::ActRequest& request) {
  try {
    model_.policy->act(queries_, actions_);
  } catch (...) {
    for (const pusht_msgs::Query& query : request.queries) {
      if (!isRepeated(query)) {
        rollouts_.erase(query.rollout);
      }
    }
    throw;
  }
}

Policy::Query PolicySession::begun(const pusht_msgs::Query& query, std::unique_ptr<Policy::Memory> memory) {
  Observation observation{};
  std::copy(query.observation.begin(), query.observation.end(), observation.begin());
  if (!has_memory_) {
    return {observation, nullptr};
  }
  Remembered& rollout = rollouts_[query.rollout];
  if (query.step == 0) {
    rollout.memory = std::move(memory);
    rollout.step = -1;
  }
  return {observation, rollout.memory.get()};
}

void PolicySession::forgetEnded() {
  ++requests_;
  if (rollouts_.size() < kManyRollouts) {
    return;
  }
  for (auto rollout = rollouts_.begin(); rollout != rollouts_.end();) {
    rollout = rollout->second.last_request + kLately < requests_ ? rollouts_.erase(rollout) : std::next(rollout);
  }
}

pusht_msgs::DescribeResponse PolicySession::describe() const {
  pusht_msgs::DescribeResponse response;
  response.success = 1;
  response.instance_id = instance_id_;
  response.name = model_.name;
  response.version = model_.version;
  response.provenance = model_.provenance.dump();
  if (const Task& task = model_.task; &task != &fullCircle()) {
    response.parameters = {parameter(kTaskParameter, textOf(task))};
  }
  return response;
}

}  // namespace pusht
