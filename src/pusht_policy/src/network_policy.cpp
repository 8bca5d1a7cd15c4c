// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/network_policy.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "checkpoint_file.hpp"
#include "network_memory.hpp"
#include "network_trial.hpp"
#include "pusht_task/error.hpp"
#include "rehearsal.hpp"
#include "torch_network.hpp"

namespace pusht {
namespace {

constexpr int kInputs = std::tuple_size<Observation>::value;
constexpr int kOutputs = std::tuple_size<Action>::value;

/// A network that has been loaded and tried out. Throws as NetworkPolicy::load() does.
class Checkpoint {
 public:
  explicit Checkpoint(const CheckpointFile& file)
      : network_(std::make_unique<TorchNetwork>(file.bytes, file.name, file.description)) {
    try {
      graph_ = network_->straightened();
    } catch (const UnfitForKernel& error) {
      why_not_on_kernel_ = error.what();
    }
    requireNoRandomOperation(file.name);
    answers_ = tryOut(*network_, file.name);
  }

  /// Kernel that acts as the network does. Throws UnfitForKernel if there is none.
  std::unique_ptr<NetworkKernel> kernel(InstructionSet instruction_set) const {
    const PolicyDescription& description = network_->description();
    if (graph_ == nullptr) {
      throw UnfitForKernel(why_not_on_kernel_);
    }
    auto kernel = std::make_unique<NetworkKernel>(kInputs * description.observations,
                                                  readGraph(*graph_, network_->observationSizes()), instruction_set);
    requireAgreement(*kernel, description, answers_);
    return kernel;
  }

  std::unique_ptr<TorchNetwork> takeNetwork() { return std::move(network_); }

 private:
  void requireNoRandomOperation(const std::string& name) const {
    const std::string operation = graph_ == nullptr ? "" : randomOperationIn(*graph_);
    if (!operation.empty()) {
      throw BadDependency(name + ": must not draw random numbers, but has " + operation +
                          ": it must take noise as an input, and say so in its policy.json");
    }
  }

  std::unique_ptr<TorchNetwork> network_;
  std::shared_ptr<const torch::jit::Graph> graph_;
  std::string why_not_on_kernel_;
  std::vector<float> answers_;
};

/// Loads the checkpoint at `path` in a copy of the process first: what libtorch makes of damaged files, or of code that
/// never returns, ends there.
template <class Load>
auto loadRehearsed(const std::filesystem::path& path, std::chrono::milliseconds deadline,
                   const std::function<bool()>& stop, Load load) {
  const CheckpointFile file(path);
  rehearse(file.name, deadline, stop, [&] {
    requireWholeTensors(file.bytes, file.records, file.name);
    load(file);
  });
  return load(file);
}

NetworkInfo infoOf(const CheckpointFile& file) {
  NetworkInfo info;
  info.sha256 = file.hash;
  info.description = file.description;
  return info;
}

}  // namespace

NetworkPolicy::NetworkPolicy(NetworkInfo info, std::unique_ptr<NetworkKernel> kernel)
    : info_(std::move(info)), kernel_(std::move(kernel)) {
  info_.operations = kernel_->operations();
  info_.instruction_set = toString(kernel_->instructionSet());
}

NetworkPolicy::NetworkPolicy(NetworkInfo info, std::unique_ptr<TorchNetwork> network, std::string why_not_on_kernel)
    : info_(std::move(info)), network_(std::move(network)) {
  info_.why_not_on_kernel = std::move(why_not_on_kernel);
}

NetworkPolicy::~NetworkPolicy() = default;

std::unique_ptr<NetworkPolicy> NetworkPolicy::clone() const {
  if (kernel_ != nullptr) {
    return std::unique_ptr<NetworkPolicy>(new NetworkPolicy(info_, std::make_unique<NetworkKernel>(*kernel_)));
  }
  return std::unique_ptr<NetworkPolicy>(
      new NetworkPolicy(info_, std::make_unique<TorchNetwork>(*network_), info_.why_not_on_kernel));
}

std::unique_ptr<NetworkPolicy> NetworkPolicy::load(const std::filesystem::path& path, InstructionSet instruction_set,
                                                   std::chrono::milliseconds deadline,
                                                   const std::function<bool()>& stop) {
  return loadRehearsed(path, deadline, stop, [&](const CheckpointFile& file) {
    Checkpoint checkpoint(file);
    try {
      return std::unique_ptr<NetworkPolicy>(new NetworkPolicy(infoOf(file), checkpoint.kernel(instruction_set)));
    } catch (const UnfitForKernel& error) {
      return std::unique_ptr<NetworkPolicy>(new NetworkPolicy(infoOf(file), checkpoint.takeNetwork(), error.what()));
    }
  });
}

std::unique_ptr<NetworkPolicy> NetworkPolicy::loadOnLibtorch(const std::filesystem::path& path) {
  const auto never = [] { return false; };
  return loadRehearsed(path, kLoadDeadline, never, [](const CheckpointFile& file) {
    return std::unique_ptr<NetworkPolicy>(
        new NetworkPolicy(infoOf(file), Checkpoint(file).takeNetwork(), "asked for on libtorch"));
  });
}

std::unique_ptr<NetworkPolicy> NetworkPolicy::untrained(std::uint64_t seed) {
  auto kernel = std::make_unique<NetworkKernel>(kInputs, untrainedOperations(seed));
  return std::unique_ptr<NetworkPolicy>(new NetworkPolicy(NetworkInfo(), std::move(kernel)));
}

std::unique_ptr<Policy::Memory> NetworkPolicy::begin(const Beginning& beginning) const {
  requireExecutable(beginning, info_.description.actions);
  return info_.description.hasMemory() ? std::make_unique<NetworkMemory>(info_.description, beginning) : nullptr;
}

void NetworkPolicy::act(Span<const Query> queries, Span<Action> actions) {
  if (info_.description.hasMemory()) {
    return actFromMemory(queries, actions);
  }
  if (kernel_ != nullptr) {
    return actOnKernel(queries, actions);
  }
  for (std::size_t i = 0; i < queries.size(); ++i) {
    network_->run(queries[i].observation, {}, {}, actions[i]);
  }
}

void NetworkPolicy::actOnKernel(Span<const Query> queries, Span<Action> actions) {
  inputs_.resize(queries.size() * kInputs);
  outputs_.resize(queries.size() * kOutputs);
  for (std::size_t i = 0; i < queries.size(); ++i) {
    std::copy_n(queries[i].observation.begin(), kInputs, inputs_.data() + i * kInputs);
  }
  kernel_->run(inputs_, outputs_);
  for (std::size_t i = 0; i < actions.size(); ++i) {
    std::copy_n(outputs_.data() + i * kOutputs, kOutputs, actions[i].begin());
  }
}

/// Every rollout sees its observation; the network is asked for those alone whose actions have run out.
void NetworkPolicy::actFromMemory(Span<const Query> queries, Span<Action> actions) {
  spent_.clear();
  for (const Query& query : queries) {
    if (query.memory == nullptr) {
      throw InternalError("a policy with a memory must be asked with the memory of a rollout");
    }
    auto& memory = static_cast<NetworkMemory&>(*query.memory);
    memory.see(query.observation);
    if (memory.isSpent()) {
      spent_.push_back(&memory);
    }
  }
  if (kernel_ != nullptr) {
    answerOnKernel();
  } else {
    answerOnLibtorch();
  }
  for (std::size_t i = 0; i < actions.size(); ++i) {
    actions[i] = static_cast<NetworkMemory&>(*queries[i].memory).next();
  }
}

void NetworkPolicy::answerOnKernel() {
  const auto inputs = static_cast<std::size_t>(kernel_->inputs());
  const auto outputs = static_cast<std::size_t>(kernel_->outputs());
  inputs_.resize(spent_.size() * inputs);
  outputs_.resize(spent_.size() * outputs);
  for (std::size_t i = 0; i < spent_.size(); ++i) {
    std::copy_n(spent_[i]->history().begin(), inputs, inputs_.data() + i * inputs);
  }
  kernel_->run(inputs_, outputs_);
  for (std::size_t i = 0; i < spent_.size(); ++i) {
    std::copy_n(outputs_.data() + i * outputs, outputs, spent_[i]->answer().begin());
  }
}

void NetworkPolicy::answerOnLibtorch() {
  inputs_.resize(numbersIn(info_.description.noise));
  for (NetworkMemory* const memory : spent_) {
    memory->draw(inputs_);
    network_->run(memory->history(), memory->state(), inputs_, memory->answer());
  }
}

}  // namespace pusht
