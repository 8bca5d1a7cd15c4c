// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/remote_policy.hpp"

#include <algorithm>
#include <cstdint>
#include <string>

namespace pusht {
namespace {

struct ServedRollout : Policy::Memory {
  ServedRollout(std::uint64_t index, const Beginning& of) : id(index), beginning(of) {}

  std::uint64_t id;
  Beginning beginning;
  std::uint32_t next_step = 0;
};

}  // namespace

RemotePolicy::RemotePolicy(const Peer& peer) : act_(peer, "act") {}

std::unique_ptr<Policy::Memory> RemotePolicy::begin(const Beginning& beginning) const {
  return std::make_unique<ServedRollout>(ids_.next(), beginning);
}

void RemotePolicy::act(Span<const Query> queries, Span<Action> actions) {
  if (queries.empty()) {
    return;
  }
  pusht_msgs::ActRequest request;
  request.queries.resize(queries.size());
  for (std::size_t row = 0; row < queries.size(); ++row) {
    const auto& rollout = static_cast<const ServedRollout&>(*queries[row].memory);
    request.queries[row].rollout = rollout.id;
    request.queries[row].step = rollout.next_step;
    request.queries[row].seed = rollout.beginning.seed;
    request.queries[row].execute = static_cast<std::uint32_t>(rollout.beginning.execute);
    std::copy(queries[row].observation.begin(), queries[row].observation.end(),
              request.queries[row].observation.begin());
  }
  const pusht_msgs::ActResponse response = act_.call(request);
  if (response.actions.size() != 2 * queries.size()) {
    throw BadDependency("the policy answers " + std::to_string(queries.size()) + " queries with " +
                        std::to_string(response.actions.size()) + " numbers; must be two each");
  }
  for (std::size_t row = 0; row < queries.size(); ++row) {
    actions[row] = {response.actions[2 * row], response.actions[2 * row + 1]};
    ++static_cast<ServedRollout&>(*queries[row].memory).next_step;
  }
}

}  // namespace pusht
