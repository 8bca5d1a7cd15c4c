// SPDX-License-Identifier: BSD-3-Clause
/// Kernel for small float32 networks in a fixed order of operations, with equal bits on every machine (with tanh: for
/// every libm whose double tanh rounds to the same float).
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "pusht_task/types.hpp"

namespace pusht {

/// Operation of a network, applied to every row.
struct Operation {
  enum class Kind {
    kMatrix,  ///< row times matrix; sums run over the inputs in index order, from 0, multiply then add
    kAdd,
    kSubtract,
    kMultiply,
    kDivide,
    kMax,  ///< ReLU is the maximum with 0; a clamp is a kMax and a kMin. A NaN stays NaN
    kMin,
    kTanh,
  };
  Kind kind;
  int columns;                 ///< number of columns of the result
  std::vector<float> operand;  ///< kMatrix: [inputs][columns], row-major; kTanh: empty; otherwise one value per column
};

/// Instruction sets that the kernel is compiled for. All give the same bits.
enum class InstructionSet { kBaseline, kAvx2, kAvx512 };

/// Name of an instruction set, as in the provenance.
const char* toString(InstructionSet instruction_set);

/// Instruction sets of this machine, the fastest last.
std::vector<InstructionSet> availableInstructionSets();

/// Network as a sequence of operations. A row's result does not depend, to the last bit, on the other rows or their
/// number. Not thread-safe; copies, which share the weights, may run in several threads.
class NetworkKernel {
 public:
  /// Network for rows of `inputs` numbers. Throws InternalError if an operation does not fit the one before it.
  NetworkKernel(int inputs, const std::vector<Operation>& operations,
                InstructionSet instruction_set = availableInstructionSets().back());

  int inputs() const { return inputs_; }
  int outputs() const { return outputs_; }
  InstructionSet instructionSet() const { return instruction_set_; }

  /// Operations as text: "10, subtract, matrix 512, add, max, matrix 2, add".
  std::string operations() const;

  /// Maps rows [n][inputs()] to rows [n][outputs()]. Does not allocate. Throws InternalError if the sizes disagree.
  void run(Span<const float> inputs, Span<float> outputs);

 private:
  /// Matrices and blocks have rows of whole cache lines, padded with 0, so that no vector straddles two.
  struct alignas(64) Line {
    std::array<float, 16> values;
  };
  using Lines = std::vector<Line>;

  struct Step {
    Operation::Kind kind;
    int columns;
    Lines operand;
  };

  static Lines padded(const std::vector<float>& operand, int columns);
  void runBlock(const float* inputs, int rows, float* outputs);
  float* row(Lines& block, int index) const { return block[index * lines_per_row_].values.data(); }

  int inputs_;
  int outputs_;
  InstructionSet instruction_set_;
  std::shared_ptr<const std::vector<Step>> steps_;
  int lines_per_row_;  // of block_ and product_
  Lines block_;        // rows under way, after the last operation
  Lines product_;      // rows after a matrix
};

}  // namespace pusht
