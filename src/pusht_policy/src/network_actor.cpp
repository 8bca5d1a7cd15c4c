// SPDX-License-Identifier: BSD-3-Clause
#include "network_actor.hpp"

#include <algorithm>
#include <utility>

#include "pusht_task/error.hpp"

namespace pusht {

std::size_t observationNumbers(const PolicyDescription& description) {
  return static_cast<std::size_t>(description.observations) * static_cast<std::size_t>(description.interface.numbers());
}

std::size_t actionNumbers(const PolicyDescription& description) {
  return static_cast<std::size_t>(description.actions) * std::tuple_size<Action>::value;
}

void KernelNetwork::answer(Span<const NetworkCall> calls) {
  inputs_.resize(calls.size() * static_cast<std::size_t>(kernel_.inputs()));
  outputs_.resize(calls.size() * static_cast<std::size_t>(kernel_.outputs()));
  auto input = inputs_.begin();
  for (const NetworkCall& call : calls) {
    input = std::copy(call.observations.begin(), call.observations.end(), input);
    input = std::copy(call.state.begin(), call.state.end(), input);
    input = std::copy(call.noise.begin(), call.noise.end(), input);
  }
  kernel_.run(inputs_, outputs_);
  auto output = outputs_.begin();
  for (const NetworkCall& call : calls) {
    for (const Span<float> part : {call.actions, call.state}) {
      std::copy_n(output, part.size(), part.begin());
      output += static_cast<std::ptrdiff_t>(part.size());
    }
  }
}

NetworkActor::NetworkActor(std::unique_ptr<Network> network, PolicyDescription description)
    : network_(std::move(network)), description_(std::move(description)) {}

std::unique_ptr<NetworkActor> NetworkActor::clone() const {
  return std::make_unique<NetworkActor>(network_->clone(), description_);
}

std::unique_ptr<Policy::Memory> NetworkActor::begin(const Beginning& beginning) const {
  requireExecutable(beginning, description_.actions);
  return description_.hasMemory() ? std::make_unique<NetworkMemory>(description_, beginning) : nullptr;
}

void NetworkActor::act(Span<const Query> queries, Span<Action> actions) {
  calls_.clear();
  if (!description_.hasMemory()) {
    const std::size_t numbers = observationNumbers(description_);
    seen_.resize(queries.size() * numbers);
    for (std::size_t i = 0; i < queries.size(); ++i) {
      const Span<float> seen(seen_.data() + i * numbers, numbers);
      description_.interface.look(queries[i].observation, seen);
      calls_.push_back({seen, {}, {}, actions[i]});
    }
    return network_->answer(calls_);
  }
  callForSpent(queries);
  for (std::size_t i = 0; i < actions.size(); ++i) {
    actions[i] = static_cast<NetworkMemory&>(*queries[i].memory).next();
  }
}

/// Every rollout sees its observation; the network is asked for those alone whose actions have run out.
void NetworkActor::callForSpent(Span<const Query> queries) {
  const std::size_t noise_numbers = numbersIn(description_.noise);
  noise_.resize(queries.size() * noise_numbers);
  for (const Query& query : queries) {
    if (query.memory == nullptr) {
      throw InternalError("a policy with a memory must be asked with the memory of a rollout");
    }
    auto& memory = static_cast<NetworkMemory&>(*query.memory);
    memory.see(query.observation);
    if (memory.isSpent()) {
      const Span<float> noise(noise_.data() + calls_.size() * noise_numbers, noise_numbers);
      memory.draw(noise);
      calls_.push_back({memory.history(), memory.state(), noise, memory.answer()});
    }
  }
  network_->answer(calls_);
}

}  // namespace pusht
