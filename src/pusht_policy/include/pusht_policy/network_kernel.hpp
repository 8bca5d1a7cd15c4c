// SPDX-License-Identifier: BSD-3-Clause
/// Kernel for small float32 networks in a fixed order of operations, with equal bits on every machine.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "pusht_task/types.hpp"

namespace pusht {

/// Operation of a network, applied to every row. Value 0 of a row are its inputs, value i the result of operation i,
/// counted from 1.
struct Operation {
  enum class Kind {
    kMatrix,  ///< row times matrix; sums run over the inputs in index order, from 0, multiply then add
    kAdd,     ///< this and the next: with an operand, or of two values
    kSubtract,
    kMultiply,
    kDivide,
    kMax,  ///< ReLU is the maximum with 0; a clamp is a kMax and a kMin. A NaN stays NaN
    kMin,
    kTanh,  ///< this and the next: of each number
    kErf,
    kExp,
    kExpMinusOne,
    kLog,
    kSigmoid,
    kSoftplus,  ///< log(1 + e^x)
    kSqrt,
    kSum,       ///< sums of equal parts of the row, one for each column: every 16th number first, then these by halves
    kPick,      ///< columns of the sources, side by side
    kConstant,  ///< the operand itself
  };
  Kind kind;
  int columns;                   ///< number of columns of the result
  std::vector<float> operand{};  ///< kMatrix: [inputs][columns], row-major; otherwise one value per column, or empty
  std::vector<int> sources{};    ///< values that it takes; empty: the one before it
  std::vector<int> picked{};     ///< kPick: for each column, its index in the sources side by side
};

/// Instruction sets that the kernel is compiled for. All give the same bits.
enum class InstructionSet { kBaseline, kAvx2, kAvx512 };

/// Name of an instruction set, as in the provenance.
const char* toString(InstructionSet instruction_set);

/// Instruction sets of this machine, the fastest last.
std::vector<InstructionSet> availableInstructionSets();

/// Network as a list of operations, whose last one has the result. A row's result does not depend, to the last bit, on
/// the other rows or their number. Not thread-safe; copies, which share the weights, may run in several threads.
class NetworkKernel {
 public:
  /// Network for rows of `inputs` numbers. Throws InternalError if an operation does not fit the values that it takes.
  NetworkKernel(int inputs, const std::vector<Operation>& operations,
                InstructionSet instruction_set = availableInstructionSets().back());

  int inputs() const { return inputs_; }
  int outputs() const { return outputs_; }
  InstructionSet instructionSet() const { return instruction_set_; }

  /// Operations as text, with the values that they take unless that is the one before:
  /// "10, subtract, matrix 512, add, max, matrix 512, add (4, 5), matrix 2, add".
  const std::string& operations() const { return text_; }

  /// Maps rows [n][inputs()] to rows [n][outputs()]. Does not allocate. Throws InternalError if the sizes disagree.
  void run(Span<const float> inputs, Span<float> outputs);

 private:
  /// Matrices and slots have rows of whole cache lines, padded with 0, so that no vector straddles two.
  struct alignas(64) Line {
    std::array<float, 16> values;
  };
  using Lines = std::vector<Line>;

  /// Columns of a source from `first` on, every `stride`-th, that kPick puts one behind the other.
  struct Run {
    int slot;
    int first;
    int stride;
    int count;
  };

  struct Step {
    Operation::Kind kind;
    int inputs;   ///< columns of the first source
    int columns;  ///< of the result
    Lines operand;
    int source = 0;  ///< slots
    int other = -1;  ///< of a second source
    int result = 0;
    std::vector<Run> runs{};
  };
  struct Plan;

  /// Rows under way of one value after another.
  struct Slot {
    int lines_per_row = 0;
    Lines rows;
  };

  static Lines padded(const std::vector<float>& operand, int columns);
  float* row(int slot, int index) { return slots_[slot].rows[index * slots_[slot].lines_per_row].values.data(); }
  void runBlock(const float* inputs, int rows, float* outputs);
  void take(const Step& step, int rows);
  void multiplyRows(const Step& step, int rows);
  void pickRow(const Step& step, int index);

  int inputs_;
  int outputs_;
  InstructionSet instruction_set_;
  std::string text_;
  std::shared_ptr<const std::vector<Step>> steps_;
  std::vector<Slot> slots_;
  int result_slot_ = 0;
};

}  // namespace pusht
