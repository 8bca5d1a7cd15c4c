// SPDX-License-Identifier: BSD-3-Clause
/// Networks as they are called, whatever computes them, and what a policy makes of their answers.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "network_memory.hpp"
#include "pusht_policy/network_kernel.hpp"
#include "pusht_policy/policy_description.hpp"
#include "pusht_task/policy.hpp"

namespace pusht {

/// Call of a network for one rollout.
struct NetworkCall {
  Span<const float> observations;
  Span<float> state;  ///< is replaced
  Span<const float> noise;
  Span<float> actions;  ///< is filled
};

/// Network that answers calls, each for itself.
class Network {
 public:
  virtual ~Network() = default;
  virtual void answer(Span<const NetworkCall> calls) = 0;

  /// Copy for another thread; it shares the weights.
  virtual std::unique_ptr<Network> clone() const = 0;
};

/// Network on the kernel, whose rows are observations, state and noise side by side, and then actions and state.
class KernelNetwork final : public Network {
 public:
  explicit KernelNetwork(NetworkKernel kernel) : kernel_(std::move(kernel)) {}

  void answer(Span<const NetworkCall> calls) override;
  std::unique_ptr<Network> clone() const override { return std::make_unique<KernelNetwork>(kernel_); }

 private:
  NetworkKernel kernel_;
  std::vector<float> inputs_;
  std::vector<float> outputs_;
};

/// Policy of a network and its description: each rollout has its history, its state and its noise, and the network is
/// called for those whose actions have run out.
class NetworkActor final : public Policy {
 public:
  NetworkActor(std::unique_ptr<Network> network, PolicyDescription description);

  std::unique_ptr<NetworkActor> clone() const;

  /// Null for a network that remembers nothing.
  std::unique_ptr<Memory> begin(const Beginning& beginning) const override;
  void act(Span<const Query> queries, Span<Action> actions) override;

 private:
  void callForSpent(Span<const Query> queries);

  std::unique_ptr<Network> network_;
  PolicyDescription description_;
  std::vector<NetworkCall> calls_;
  std::vector<float> seen_;   // by all calls without a memory
  std::vector<float> noise_;  // of all calls
};

/// Numbers of a call: observations, then actions of an answer.
std::size_t observationNumbers(const PolicyDescription& description);
std::size_t actionNumbers(const PolicyDescription& description);

}  // namespace pusht
