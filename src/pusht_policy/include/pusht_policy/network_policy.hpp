// SPDX-License-Identifier: BSD-3-Clause
/// Trained policy from a TorchScript checkpoint: raw observation in, raw action out.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pusht_policy/network_kernel.hpp"
#include "pusht_policy/policy_description.hpp"
#include "pusht_task/policy.hpp"

namespace pusht {

class Network;
class NetworkActor;

/// Version of the loaded libtorch.
std::string libtorchVersion();

/// File of the BLAS library that libtorch calls; empty if it cannot be determined.
std::string activeBlas();

/// Settings by which libtorch and its libraries choose their code on this machine: core type and threads of OpenBLAS,
/// vector instructions of libtorch and of oneDNN.
std::map<std::string, std::string> libtorchChoices();

/// Origin of a network's numbers.
struct NetworkInfo {
  std::string sha256;             ///< digest of the checkpoint; empty if untrained
  std::string operations;         ///< operations of the kernel; empty on libtorch
  std::string instruction_set;    ///< instruction set of the kernel; empty on libtorch
  std::string why_not_on_kernel;  ///< reason to run on libtorch; empty on the kernel
  PolicyDescription description;  ///< signature of the network
  std::string libtorch_version = libtorchVersion();
  std::string blas = activeBlas();  ///< on libtorch the bits depend on it

  bool runsOnKernel() const { return why_not_on_kernel.empty(); }
};

/// Policy of a network. It runs on NetworkKernel if the checkpoint has operations alone that the kernel knows, and the
/// results agree with libtorch's; otherwise on libtorch, one row at a time, so rows stay independent. Actions
/// are the network's outputs: not clipped, and possibly not finite.
///
/// A checkpoint with a description may look back on several observations, answer with several actions, and have a state
/// and noise. All of that is in the memory of a rollout. The network is called when the actions to be executed have run
/// out; state and noise go on once for each call.
class NetworkPolicy : public Policy {
 public:
  /// Default deadline of load(). A checkpoint of a megabyte takes 0.1 s to load and to try out. It is below the 30 s
  /// that an evaluator waits for a policy, so the evaluator learns the reason.
  static constexpr std::chrono::seconds kLoadDeadline{20};

  /// Loads a checkpoint, after a copy of this process has loaded it and tried it out (rehearse()). If there is a file
  /// PATH.provenance.json beside it, its SHA-256 is checked first.
  ///
  /// Throws InvalidInput if the file cannot be read, is damaged, is no TorchScript, crashes libtorch or has a bad
  /// description; BadDependency if its SHA-256 differs, its numbers are not finite, it draws random numbers itself, or
  /// it does not map what its description says (without one: float32 [1, 10] to float32 [1, 2]) to finite numbers;
  /// RuntimeFault if the copy takes longer than `deadline`, the calling thread gets a handled signal meanwhile, or
  /// `stop` holds, by which a program with other threads says that it was asked to end.
  ///
  /// Must be called while no other thread uses libtorch or its BLAS: the copy would wait for their locks forever.
  static std::unique_ptr<NetworkPolicy> load(
      const std::filesystem::path& path, InstructionSet instruction_set = availableInstructionSets().back(),
      std::chrono::milliseconds deadline = kLoadDeadline, const std::function<bool()>& stop = [] { return false; });

  /// Loads a checkpoint to run on libtorch even if the kernel could run it, as a baseline. Throws as load().
  static std::unique_ptr<NetworkPolicy> loadOnLibtorch(const std::filesystem::path& path);

  /// Untrained network, the course's stand-in for a missing checkpoint: 10-64-64-2, ReLU, tanh, with torch's initial
  /// weights for `seed`. Seeds torch's global generator.
  static std::unique_ptr<NetworkPolicy> untrained(std::uint64_t seed);

  /// Copy for another thread; it shares the weights.
  std::unique_ptr<NetworkPolicy> clone() const;

  ~NetworkPolicy() override;

  /// Null for a network that remembers nothing.
  std::unique_ptr<Memory> begin(const Beginning& beginning) const override;

  void act(Span<const Query> queries, Span<Action> actions) override;

  const NetworkInfo& info() const { return info_; }

 private:
  NetworkPolicy(NetworkInfo info, const NetworkKernel& kernel);
  NetworkPolicy(NetworkInfo info, std::unique_ptr<Network> on_libtorch, std::string why_not_on_kernel);
  NetworkPolicy(NetworkInfo info, std::unique_ptr<NetworkActor> actor);

  NetworkInfo info_;
  std::unique_ptr<NetworkActor> actor_;
};

}  // namespace pusht
