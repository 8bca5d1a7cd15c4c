// SPDX-License-Identifier: BSD-3-Clause
/// Trained policy from an ONNX file: raw observation in, raw action out. It needs no libtorch.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "network_actor.hpp"
#include "pusht_policy/network_kernel.hpp"
#include "pusht_task/policy.hpp"

namespace pusht {

/// Origin of the numbers of an ONNX file.
struct OnnxInfo {
  std::string sha256;  ///< digest of the file
  std::string operations;
  std::string instruction_set;
  std::int64_t opset = 0;
  std::string producer;                           ///< as the file says
  std::map<std::string, std::string> data_files;  ///< SHA-256 of files beside it that have values of its tensors
  PolicyDescription description;
};

/// Policy of a network in ONNX, on NetworkKernel. Actions are the network's outputs: not clipped, and possibly not
/// finite.
class OnnxPolicy : public Policy {
 public:
  /// Loads the file and tries it out. If there is a file PATH.provenance.json beside it, its SHA-256 is checked first.
  ///
  /// Throws InvalidInput if the file cannot be read, is damaged, is no ONNX, has a bad description or an operator that
  /// the kernel has not; BadDependency if its SHA-256 differs, its numbers are not finite, or it does not map what its
  /// description says (without one: float32 [n, 10] to float32 [n, 2]) to finite numbers.
  static std::unique_ptr<OnnxPolicy> load(const std::filesystem::path& path,
                                          InstructionSet instruction_set = availableInstructionSets().back());

  /// Policy of the bytes of a file in `folder`, tried out; `name` is for messages. Throws as load().
  static std::unique_ptr<OnnxPolicy> read(const std::string& bytes, const std::filesystem::path& folder,
                                          const std::string& name,
                                          InstructionSet instruction_set = availableInstructionSets().back());

  /// Copy for another thread; it shares the weights.
  std::unique_ptr<OnnxPolicy> clone() const;

  /// Null for a network that remembers nothing.
  std::unique_ptr<Memory> begin(const Beginning& beginning) const override { return actor_->begin(beginning); }

  void act(Span<const Query> queries, Span<Action> actions) override { actor_->act(queries, actions); }

  const OnnxInfo& info() const { return info_; }

 private:
  OnnxPolicy(OnnxInfo info, std::unique_ptr<NetworkActor> actor) : info_(std::move(info)), actor_(std::move(actor)) {}

  OnnxInfo info_;
  std::unique_ptr<NetworkActor> actor_;
};

}  // namespace pusht
