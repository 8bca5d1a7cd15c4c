// SPDX-License-Identifier: BSD-3-Clause
/// Runs a small float32 network in a fixed order of operations: the same bits on every machine (tanh: for every libm
/// whose double tanh rounds to the same float).
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "pusht_task/types.hpp"

namespace pusht {

/// One operation of a network, done to every row.
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
  int columns;                 ///< of the result
  std::vector<float> operand;  ///< kMatrix: [inputs][columns], row-major; kTanh: empty; otherwise one value per column
};

/// What the kernel may be compiled for. All give the same bits.
enum class InstructionSet { kBaseline, kAvx2, kAvx512 };

/// Name of an instruction set, as in the provenance.
const char* toString(InstructionSet instruction_set);

/// What this machine can run, the fastest last.
std::vector<InstructionSet> availableInstructionSets();

/// A network as a straight line of operations. Rows are independent, to the last bit, of each other and of
/// their number. Not to be used from two threads at once; copies, which share the weights, may be.
class NetworkKernel {
 public:
  /// For rows of `inputs` numbers. Throws InternalError if an operation does not fit the one before it.
  NetworkKernel(int inputs, const std::vector<Operation>& operations,
                InstructionSet instruction_set = availableInstructionSets().back());

  int inputs() const { return inputs_; }
  int outputs() const { return outputs_; }
  InstructionSet instructionSet() const { return instruction_set_; }

  /// As text, e.g. "10, subtract, matrix 512, add, max, matrix 2, add".
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
  int lines_per_row_;  // of the blocks
  Lines block_;        // the rows that are on their way through the network, as they are now
  Lines product_;      // where a matrix puts them
};

}  // namespace pusht
