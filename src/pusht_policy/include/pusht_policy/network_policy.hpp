// SPDX-License-Identifier: BSD-3-Clause
/// A trained policy: a TorchScript checkpoint, raw observation in, raw action out.
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
#include "pusht_task/policy.hpp"

namespace pusht {

class TorchNetwork;

/// Version of libtorch as loaded.
std::string libtorchVersion();

/// The file that libtorch's calls of the BLAS end in; empty if that cannot be found out.
std::string activeBlas();

/// By what libtorch and its libraries choose their code on this machine, as they are set up now: the core type and the
/// threads of OpenBLAS, the vectors of libtorch and of oneDNN.
std::map<std::string, std::string> libtorchChoices();

/// Where a network's numbers come from.
struct NetworkInfo {
  std::string sha256;             ///< of the checkpoint; empty if untrained
  std::string operations;         ///< what the kernel does to a row; empty on libtorch
  std::string instruction_set;    ///< of the kernel; empty on libtorch
  std::string why_not_on_kernel;  ///< empty on the kernel
  std::string libtorch_version = libtorchVersion();
  std::string blas = activeBlas();  ///< on libtorch the bits depend on it

  bool runsOnKernel() const { return why_not_on_kernel.empty(); }
};

/// Runs on NetworkKernel if the checkpoint is a straight line of operations that the kernel knows and agrees with
/// libtorch; otherwise on libtorch, a row at a time, so that there too a row does not depend on its neighbours.
/// Actions are what the network says: not clipped, and not finite if they are not.
class NetworkPolicy : public Policy {
 public:
  /// A checkpoint of a megabyte takes 0.1 s to load and to try out. An evaluator waits 30 s for a policy to appear, and
  /// should learn why it does not.
  static constexpr std::chrono::seconds kLoadDeadline{20};

  /// Loads a checkpoint, after a copy of this process has loaded it and tried it out without harm. Throws InvalidInput
  /// if it cannot be read, is damaged, is no TorchScript or crashes libtorch; BadDependency if it is not the one that
  /// the file PATH.provenance.json beside it names (checked before libtorch sees it; no such file, no check), if its
  /// numbers are not finite, or if it does not map float32 [1, 10] to finite float32 [1, 2]; RuntimeFault if that
  /// takes longer than `deadline`, or if meanwhile the calling thread gets a signal that is handled, or `stop` holds:
  /// a program with other threads says by it that it was asked to end. Call it while no other thread uses libtorch or
  /// its BLAS, at the start of a program: a lock of theirs would be held for ever in the copy.
  static std::unique_ptr<NetworkPolicy> load(
      const std::filesystem::path& path, InstructionSet instruction_set = availableInstructionSets().back(),
      std::chrono::milliseconds deadline = kLoadDeadline, const std::function<bool()>& stop = [] { return false; });

  /// The same on libtorch, even if the kernel could run it: a yardstick.
  static std::unique_ptr<NetworkPolicy> loadOnLibtorch(const std::filesystem::path& path);

  /// The course's stand-in where there is no checkpoint: 10-64-64-2, ReLU, tanh, with torch's initial weights for
  /// `seed`. Seeds torch's global generator.
  static std::unique_ptr<NetworkPolicy> untrained(std::uint64_t seed);

  /// The same policy for another thread; they share the weights.
  std::unique_ptr<NetworkPolicy> clone() const;

  ~NetworkPolicy() override;

  void act(Span<const Query> queries, Span<Action> actions) override;

  const NetworkInfo& info() const { return info_; }

 private:
  NetworkPolicy(NetworkInfo info, std::unique_ptr<NetworkKernel> kernel, std::unique_ptr<TorchNetwork> network);
  NetworkPolicy(std::string sha256, std::unique_ptr<NetworkKernel> kernel);
  NetworkPolicy(std::string sha256, std::unique_ptr<TorchNetwork> network, std::string why_not_on_kernel);

  void actOnKernel(Span<const Query> queries, Span<Action> actions);

  NetworkInfo info_;
  std::unique_ptr<NetworkKernel> kernel_;  // one of these two
  std::unique_ptr<TorchNetwork> network_;
  std::vector<float> inputs_;  // of the kernel, row by row
  std::vector<float> outputs_;
};

}  // namespace pusht
