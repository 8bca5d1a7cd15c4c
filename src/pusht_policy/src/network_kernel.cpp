// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/network_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

constexpr int kLineValues = 16;
constexpr int kBlockRows = 24;  // taken through the network together: weights are read once, rows stay in the cache

int linesFor(int columns) { return (columns + kLineValues - 1) / kLineValues; }

/// outputs[rows][columns] = inputs[rows][depth] * matrix[depth][columns]; columns are whole lines.
struct Product {
  const float* inputs;
  const float* matrix;
  float* outputs;
  int rows;
  int depth;
  int columns;
  int row_stride;  // of inputs and outputs
};

// The product is vectorized over the columns, so that every sum runs in index order whatever the width of
// the vectors. `-ffp-contract=off` keeps multiplication and addition apart. All of it is inlined into one
// function per instruction set, below.

/// kRows x kVectors sums, held in registers.
template <class Vector, int kRows, int kVectors>
[[gnu::always_inline]] inline void multiplyTile(const Product& product, int row, int column) {
  const float* inputs = product.inputs + row * product.row_stride;
  const float* matrix = product.matrix + column;
  float* outputs = product.outputs + row * product.row_stride + column;
  Vector sums[kRows][kVectors] = {};  // NOLINT(modernize-avoid-c-arrays): std::array loses the attributes of Vector
  for (int k = 0; k < product.depth; ++k, matrix += product.columns) {
    const auto* weights = reinterpret_cast<const Vector*>(matrix);
#pragma GCC unroll 8
    for (int r = 0; r < kRows; ++r) {
      const float input = inputs[r * product.row_stride + k];
#pragma GCC unroll 8
      for (int v = 0; v < kVectors; ++v) {
        sums[r][v] += input * weights[v];
      }
    }
  }
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) {
      reinterpret_cast<Vector*>(outputs + r * product.row_stride)[v] = sums[r][v];
    }
  }
}

/// The rows from `first_row` on, kRows at a time, and what is left of them fewer at a time.
template <class Vector, int kRows>
[[gnu::always_inline]] inline void multiplyRows(const Product& product, int first_row) {
  constexpr int kLanes = sizeof(Vector) / sizeof(float);
  constexpr int kVectors = kRows == 1 ? 8 : 4;  // a single row needs more sums to hide the latency of an addition
  const int end_row = product.rows - (product.rows - first_row) % kRows;
  int column = 0;
  for (; column + kVectors * kLanes <= product.columns; column += kVectors * kLanes) {
    for (int row = first_row; row < end_row; row += kRows) {
      multiplyTile<Vector, kRows, kVectors>(product, row, column);
    }
  }
  for (; column < product.columns; column += kLanes) {
    for (int row = first_row; row < end_row; row += kRows) {
      multiplyTile<Vector, kRows, 1>(product, row, column);
    }
  }
  if constexpr (kRows > 1) {
    multiplyRows<Vector, kRows - 1>(product, end_row);
  }
}

// Products by instruction set. Each takes as many rows at a time as there are registers for sums.
using Vector4 = float __attribute__((vector_size(16), may_alias));
void multiplyBaseline(const Product& product) { multiplyRows<Vector4, 3>(product, 0); }

#if defined(__x86_64__)
using Vector8 = float __attribute__((vector_size(32), may_alias));
[[gnu::target("avx2")]] void multiplyAvx2(const Product& product) { multiplyRows<Vector8, 3>(product, 0); }

using Vector16 = float __attribute__((vector_size(64), may_alias));
[[gnu::target("avx512f")]] void multiplyAvx512(const Product& product) { multiplyRows<Vector16, 6>(product, 0); }
#endif

void multiply(const Product& product, InstructionSet instruction_set) {
  switch (instruction_set) {
#if defined(__x86_64__)
    case InstructionSet::kAvx512:
      return multiplyAvx512(product);
    case InstructionSet::kAvx2:
      return multiplyAvx2(product);
#endif
    default:
      return multiplyBaseline(product);
  }
}

template <class Function>
void forEachColumn(float* row, const float* operand, int columns, Function function) {
  for (int j = 0; j < columns; ++j) {
    row[j] = function(row[j], operand[j]);
  }
}

/// Hyperbolic tangent in double, rounded to float: C libraries differ in the last bit of tanhf, but hardly ever in a
/// rounded tanh.
void applyTanh(float* row, int columns) {
  for (int j = 0; j < columns; ++j) {
    row[j] = static_cast<float>(std::tanh(static_cast<double>(row[j])));
  }
}

/// Any operation but a matrix, in place.
void apply(Operation::Kind kind, const float* operand, int columns, float* row) {
  switch (kind) {
    case Operation::Kind::kMatrix:
      break;
    case Operation::Kind::kAdd:
      return forEachColumn(row, operand, columns, [](float x, float c) { return x + c; });
    case Operation::Kind::kSubtract:
      return forEachColumn(row, operand, columns, [](float x, float c) { return x - c; });
    case Operation::Kind::kMultiply:
      return forEachColumn(row, operand, columns, [](float x, float c) { return x * c; });
    case Operation::Kind::kDivide:
      return forEachColumn(row, operand, columns, [](float x, float c) { return x / c; });
    case Operation::Kind::kMax:
      return forEachColumn(row, operand, columns, [](float x, float c) { return x < c ? c : x; });
    case Operation::Kind::kMin:
      return forEachColumn(row, operand, columns, [](float x, float c) { return x > c ? c : x; });
    case Operation::Kind::kTanh:
      return applyTanh(row, columns);
  }
}

std::string toString(Operation::Kind kind) {
  switch (kind) {
    case Operation::Kind::kMatrix:
      return "matrix";
    case Operation::Kind::kAdd:
      return "add";
    case Operation::Kind::kSubtract:
      return "subtract";
    case Operation::Kind::kMultiply:
      return "multiply";
    case Operation::Kind::kDivide:
      return "divide";
    case Operation::Kind::kMax:
      return "max";
    case Operation::Kind::kMin:
      return "min";
    case Operation::Kind::kTanh:
      return "tanh";
  }
  return "";
}

std::size_t operandSize(const Operation& operation, int inputs) {
  switch (operation.kind) {
    case Operation::Kind::kMatrix:
      return static_cast<std::size_t>(inputs) * operation.columns;
    case Operation::Kind::kTanh:
      return 0;
    default:
      return operation.columns;
  }
}

void requireFit(const Operation& operation, int inputs) {
  const bool may_widen = operation.kind == Operation::Kind::kMatrix;
  if (operation.columns < 1 || (operation.columns != inputs && !may_widen) ||
      operation.operand.size() != operandSize(operation, inputs)) {
    throw InternalError("operation " + toString(operation.kind) + ": must fit the " + std::to_string(inputs) +
                        " columns before it");
  }
}

}  // namespace

const char* toString(InstructionSet instruction_set) {
  switch (instruction_set) {
    case InstructionSet::kAvx512:
      return "AVX-512";
    case InstructionSet::kAvx2:
      return "AVX2";
    case InstructionSet::kBaseline:
      return "baseline";
  }
  return "";
}

std::vector<InstructionSet> availableInstructionSets() {
  std::vector<InstructionSet> available = {InstructionSet::kBaseline};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) {
    available.push_back(InstructionSet::kAvx2);
  }
  if (__builtin_cpu_supports("avx512f")) {
    available.push_back(InstructionSet::kAvx512);
  }
#endif
  return available;
}

NetworkKernel::NetworkKernel(int inputs, const std::vector<Operation>& operations, InstructionSet instruction_set)
    : inputs_(inputs), outputs_(inputs), instruction_set_(instruction_set), lines_per_row_(linesFor(inputs)) {
  std::vector<Step> steps;
  for (const Operation& operation : operations) {
    requireFit(operation, outputs_);
    outputs_ = operation.columns;
    steps.push_back({operation.kind, outputs_, padded(operation.operand, outputs_)});
    lines_per_row_ = std::max(lines_per_row_, linesFor(outputs_));
  }
  steps_ = std::make_shared<const std::vector<Step>>(std::move(steps));
  block_.resize(kBlockRows * lines_per_row_);
  product_ = block_;
}

NetworkKernel::Lines NetworkKernel::padded(const std::vector<float>& operand, int columns) {
  const int rows = static_cast<int>(operand.size()) / columns;
  const int lines_per_row = linesFor(columns);
  Lines lines(rows * lines_per_row);
  for (int row = 0; row < rows; ++row) {
    std::copy_n(operand.data() + row * columns, columns, lines[row * lines_per_row].values.data());
  }
  return lines;
}

std::string NetworkKernel::operations() const {
  std::string text = std::to_string(inputs_);
  for (const Step& step : *steps_) {
    text += ", " + toString(step.kind);
    if (step.kind == Operation::Kind::kMatrix) {
      text += " " + std::to_string(step.columns);
    }
  }
  return text;
}

void NetworkKernel::run(Span<const float> inputs, Span<float> outputs) {
  const int rows = static_cast<int>(inputs.size()) / inputs_;
  if (static_cast<int>(inputs.size()) != rows * inputs_ || static_cast<int>(outputs.size()) != rows * outputs_) {
    throw InternalError("network of " + std::to_string(inputs_) + " to " + std::to_string(outputs_) +
                        " columns: cannot map " + std::to_string(inputs.size()) + " numbers to " +
                        std::to_string(outputs.size()));
  }
  for (int first = 0; first < rows; first += kBlockRows) {
    runBlock(inputs.data() + first * inputs_, std::min(kBlockRows, rows - first), outputs.data() + first * outputs_);
  }
}

void NetworkKernel::runBlock(const float* inputs, int rows, float* outputs) {
  for (int i = 0; i < rows; ++i) {
    std::copy_n(inputs + i * inputs_, inputs_, row(block_, i));
  }
  int columns = inputs_;
  for (const Step& step : *steps_) {
    const float* operand = step.operand.empty() ? nullptr : step.operand.front().values.data();
    if (step.kind == Operation::Kind::kMatrix) {
      multiply({row(block_, 0), operand, row(product_, 0), rows, columns, linesFor(step.columns) * kLineValues,
                lines_per_row_ * kLineValues},
               instruction_set_);
      std::swap(block_, product_);
      columns = step.columns;
    } else {
      for (int i = 0; i < rows; ++i) {
        apply(step.kind, operand, columns, row(block_, i));
      }
    }
  }
  for (int i = 0; i < rows; ++i) {
    std::copy_n(row(block_, i), outputs_, outputs + i * outputs_);
  }
}

}  // namespace pusht
