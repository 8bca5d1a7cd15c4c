// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/network_policy.hpp"

#include <sys/mman.h>

#include <chrono>
#include <utility>

#include "checkpoint_file.hpp"
#include "network_actor.hpp"
#include "network_trial.hpp"
#include "pusht_task/error.hpp"
#include "rehearsal.hpp"
#include "torch_network.hpp"

namespace pusht {
namespace {

/// Throws RuntimeFault unless there is memory for the buffers of OpenBLAS, of one of its threads and of the caller's:
/// it asks for them in an endless loop.
void requireMemoryOfBlas(const std::string& name) {
  constexpr std::size_t kBuffers = std::size_t{2} << 27U;  // bytes, as Debian builds it
  void* const buffers = mmap(nullptr, kBuffers, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (buffers == MAP_FAILED) {
    throw RuntimeFault(name + ": its matrices need " + std::to_string(kBuffers >> 20U) +
                       " MB more of memory for the BLAS");
  }
  munmap(buffers, kBuffers);
}

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
    if (graph_ != nullptr) {
      requireFitForUse(*graph_, file.name);
    }
    tryOut(file.name);
  }

  /// Kernel that acts as the network does. Throws UnfitForKernel if there is none.
  NetworkKernel kernel(InstructionSet instruction_set) const {
    const PolicyDescription& description = network_->description();
    if (graph_ == nullptr) {
      throw UnfitForKernel(why_not_on_kernel_);
    }
    const bool has_state = !description.state.empty();
    NetworkKernel kernel(
        static_cast<int>(observationNumbers(description) + numbersIn(description.state) + numbersIn(description.noise)),
        readGraph(*graph_, network_->inputSizes(), has_state), instruction_set);
    KernelNetwork on_kernel(kernel);
    requireAgreement(answersToProbes(on_kernel, description, "kernel"), answers_, description.interface);
    return kernel;
  }

  std::unique_ptr<Network> takeNetwork() { return std::move(network_); }

 private:
  static void requireFitForUse(const torch::jit::Graph& graph, const std::string& name) {
    if (const std::string device = otherDeviceIn(graph); !device.empty()) {
      throw BadDependency(name + ": must compute on the CPU, but has a constant on " + device +
                          ": move the module to the CPU before it is traced or scripted");
    }
    if (const std::string operation = trainingOperationIn(graph); !operation.empty()) {
      throw BadDependency(name + ": must be in evaluation, but " + operation +
                          " does as in training: call .eval() before tracing");
    }
    if (const std::string operation = randomOperationIn(graph); !operation.empty()) {
      throw BadDependency(name + ": must not draw random numbers, but has " + operation +
                          ": it must take noise as an input, and say so in its policy.json");
    }
  }

  /// Answers to the probes, which must be the same the second time.
  void tryOut(const std::string& name) {
    requireMemoryOfBlas(name);
    answers_ = answersToProbes(*network_, network_->description(), name);
    if (answersToProbes(*network_, network_->description(), name) != answers_) {
      throw BadDependency(name +
                          ": must act the same on the same inputs, but has a memory or is random: it must take its "
                          "state and its noise as inputs, and say so in its policy.json");
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

NetworkPolicy::NetworkPolicy(NetworkInfo info, std::unique_ptr<NetworkActor> actor)
    : info_(std::move(info)), actor_(std::move(actor)) {}

NetworkPolicy::NetworkPolicy(NetworkInfo info, const NetworkKernel& kernel) : info_(std::move(info)) {
  info_.operations = kernel.operations();
  info_.instruction_set = toString(kernel.instructionSet());
  actor_ = std::make_unique<NetworkActor>(std::make_unique<KernelNetwork>(kernel), info_.description);
}

NetworkPolicy::NetworkPolicy(NetworkInfo info, std::unique_ptr<Network> on_libtorch, std::string why_not_on_kernel)
    : info_(std::move(info)), actor_(std::make_unique<NetworkActor>(std::move(on_libtorch), info_.description)) {
  info_.why_not_on_kernel = std::move(why_not_on_kernel);
}

NetworkPolicy::~NetworkPolicy() = default;

std::unique_ptr<NetworkPolicy> NetworkPolicy::clone() const {
  return std::unique_ptr<NetworkPolicy>(new NetworkPolicy(info_, actor_->clone()));
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
  const NetworkKernel kernel(std::tuple_size<Observation>::value, untrainedOperations(seed));
  return std::unique_ptr<NetworkPolicy>(new NetworkPolicy(NetworkInfo(), kernel));
}

std::unique_ptr<Policy::Memory> NetworkPolicy::begin(const Beginning& beginning) const {
  return actor_->begin(beginning);
}

void NetworkPolicy::act(Span<const Query> queries, Span<Action> actions) { actor_->act(queries, actions); }

}  // namespace pusht
