// SPDX-License-Identifier: BSD-3-Clause
/// Networks on libtorch, without libtorch's headers, which take ten seconds to compile.
#pragma once

#include <cstdint>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "checkpoint_archive.hpp"
#include "network_actor.hpp"
#include "network_builder.hpp"
#include "pusht_policy/network_kernel.hpp"
#include "pusht_policy/policy_description.hpp"
#include "pusht_task/types.hpp"

namespace at {
class Tensor;
}  // namespace at
namespace c10 {
struct IValue;
}  // namespace c10
namespace torch::jit {
struct Graph;
struct Module;
}  // namespace torch::jit

namespace pusht {

/// TorchScript module with the signature of a description, called for one rollout at a time. libtorch uses one thread
/// for each calling thread. Copies share the module, which several threads may run at once.
class TorchNetwork final : public Network {
 public:
  /// Loads the bytes of a checkpoint; `name` is for messages. Throws InvalidInput if they are no TorchScript,
  /// BadDependency if a parameter or buffer is not finite.
  TorchNetwork(const std::string& bytes, std::string name, PolicyDescription description);

  /// Calls the module: fills `actions` and replaces `state`. Throws BadDependency if the module fails or returns
  /// anything but float32 of the described shapes.
  void run(Span<const float> observations, Span<float> state, Span<const float> noise, Span<float> actions);

  void answer(Span<const NetworkCall> calls) override;
  std::unique_ptr<Network> clone() const override { return std::make_unique<TorchNetwork>(*this); }

  /// Graph of forward() for one rollout, with operations and constants alone, in the module's own order of
  /// floating-point operations. Throws UnfitForKernel if there is none.
  std::shared_ptr<torch::jit::Graph> straightened() const;

  const PolicyDescription& description() const { return description_; }
  /// Shapes of what a call takes: observations, and state and noise if there are any.
  std::vector<Sizes> inputSizes() const;

 private:
  [[noreturn]] void refuse(const std::string& instead) const;
  void take(const c10::IValue& part, const std::vector<std::int64_t>& sizes, Span<float> values,
            const c10::IValue& result) const;

  std::string name_;
  PolicyDescription description_;
  std::vector<std::int64_t> observation_sizes_;
  std::vector<std::int64_t> action_sizes_;
  std::shared_ptr<torch::jit::Module> module_;
};

/// Throws InvalidInput, naming the record, unless libtorch finds in the archive `bytes` the records that were verified,
/// and the pickles ask of each record that holds a tensor all of its bytes and no more. libtorch itself reads beyond
/// the end of a short record, and may crash on a bad pickle: rehearse().
void requireWholeTensors(const std::string& bytes, const Records& records, const std::string& name);

/// Replaces tensors of no dimension in arithmetic by the numbers that they were before `module` was traced. Arithmetic
/// of such a tensor and integers gives doubles, of a number and integers floats. libtorch's optimizer of graphs does
/// the same.
void restoreTracedNumbers(const torch::jit::Module& module);

/// Operations of a graph whose first input is the module and whose others are float32 of these shapes for one rollout:
/// the kernel's row has their numbers side by side. With a state the result is (actions, state), and the row has both.
/// Throws UnfitForKernel, naming all operations that the kernel cannot run.
std::vector<Operation> readGraph(const torch::jit::Graph& graph, const std::vector<Sizes>& shapes, bool has_state);

/// Name of an operation that does as in training; empty if there is none.
std::string trainingOperationIn(const torch::jit::Graph& graph);

/// Device that a constant of a graph names and that is not the CPU: "cuda:0"; empty if there is none.
std::string otherDeviceIn(const torch::jit::Graph& graph);

/// Name of an operation of a graph that draws random numbers; empty if there is none.
std::string randomOperationIn(const torch::jit::Graph& graph);

/// Operations of Linear(10, 64), ReLU, Linear(64, 64), ReLU, Linear(64, 2), tanh, initialized as by torch after
/// manual_seed(seed).
std::vector<Operation> untrainedOperations(std::uint64_t seed);

/// Message of an exception of libtorch on one line: without its traces, the first line of the message, which a failing
/// module puts after "RuntimeError:". Throws std::bad_alloc instead if memory is used up.
std::string firstLine(const std::exception& error);

/// The values of a float32 tensor, row-major.
std::vector<float> toVector(const at::Tensor& tensor);

}  // namespace pusht
