// SPDX-License-Identifier: BSD-3-Clause
/// Networks on libtorch, without libtorch's headers, which take ten seconds to compile.
#pragma once

#include <cstdint>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "checkpoint_archive.hpp"
#include "pusht_policy/network_kernel.hpp"
#include "pusht_task/types.hpp"

namespace at {
class Tensor;
}  // namespace at
namespace torch::jit {
struct Graph;
struct Module;
}  // namespace torch::jit

namespace pusht {

/// Error: the kernel cannot run the network, for this reason.
struct UnfitForKernel : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// TorchScript module that maps one observation to one action. libtorch uses one thread for each calling thread. Copies
/// share the module, which several threads may run at once.
class TorchNetwork {
 public:
  /// Loads the bytes of a checkpoint; `name` is for messages. Throws InvalidInput if they are no TorchScript,
  /// BadDependency if a parameter or buffer is not finite.
  TorchNetwork(const std::string& bytes, std::string name);

  /// Throws BadDependency if the module fails or returns anything but float32 [1, 2].
  Action act(const Observation& observation);

  /// Sequence of operations of the module, in its own order. Throws UnfitForKernel if it is none.
  std::vector<Operation> operations() const;

 private:
  std::string name_;
  std::shared_ptr<torch::jit::Module> module_;
};

/// Throws InvalidInput, naming the record, unless libtorch finds in the archive `bytes` the records that were verified,
/// and the pickles ask of each record that holds a tensor all of its bytes and no more. libtorch itself reads beyond
/// the end of a short record, and may crash on a bad pickle: rehearse().
void requireWholeTensors(const std::string& bytes, const Records& records, const std::string& name);

/// Operations of a graph whose first input is the module and whose second is rows of `inputs` numbers.
/// Throws UnfitForKernel.
std::vector<Operation> readGraph(const torch::jit::Graph& graph, int inputs);

/// Operations of Linear(10, 64), ReLU, Linear(64, 64), ReLU, Linear(64, 2), tanh, initialized as by torch after
/// manual_seed(seed).
std::vector<Operation> untrainedOperations(std::uint64_t seed);

/// Message of an exception of libtorch on one line: without its traces, the first line of the message, which a failing
/// module puts after "RuntimeError:". Throws std::bad_alloc instead if memory is used up.
std::string firstLine(const std::exception& error);

/// The values of a float32 tensor, row-major.
std::vector<float> toVector(const at::Tensor& tensor);

}  // namespace pusht
