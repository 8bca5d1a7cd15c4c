// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/network_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kernel_functions.hpp"
#include "kernel_product.hpp"
#include "pusht_task/error.hpp"

namespace pusht {
namespace {

using Kind = Operation::Kind;

constexpr int kBlockRows = 24;  // taken through the network together: weights are read once, rows stay in the cache

int linesFor(int columns) { return (columns + kLineValues - 1) / kLineValues; }

template <class Function>
void forEachColumn(float* row, const float* operand, int columns, Function function) {
  for (int j = 0; j < columns; ++j) {
    row[j] = function(row[j], operand[j]);
  }
}

/// An operation of a row and an operand, in place.
void combine(Kind kind, const float* operand, int columns, float* row) {
  switch (kind) {
    case Kind::kAdd:
      return forEachColumn(row, operand, columns, [](float x, float c) { return x + c; });
    case Kind::kSubtract:
      return forEachColumn(row, operand, columns, [](float x, float c) { return x - c; });
    case Kind::kMultiply:
      return forEachColumn(row, operand, columns, [](float x, float c) { return x * c; });
    case Kind::kDivide:
      return forEachColumn(row, operand, columns, [](float x, float c) { return x / c; });
    case Kind::kMax:
      return forEachColumn(row, operand, columns, [](float x, float c) { return x < c ? c : x; });
    default:
      return forEachColumn(row, operand, columns, [](float x, float c) { return x > c ? c : x; });
  }
}

/// Sum of every 16th number, then of these by halves, whatever the width of vectors.
float sumOf(const float* values, int count) {
  std::array<float, kLineValues> sums{};
  int first = 0;
  for (; first + kLineValues <= count; first += kLineValues) {
    for (int j = 0; j < kLineValues; ++j) {
      sums[j] += values[first + j];
    }
  }
  for (int j = 0; first + j < count; ++j) {
    sums[j] += values[first + j];
  }
  for (int half = kLineValues / 2; half > 0; half /= 2) {
    for (int j = 0; j < half; ++j) {
      sums[j] += sums[j + half];
    }
  }
  return sums[0];
}

bool isCombination(Kind kind) { return kind >= Kind::kAdd && kind <= Kind::kMin; }
bool isFunction(Kind kind) { return kind >= Kind::kTanh && kind <= Kind::kSqrt; }

const char* toString(Kind kind) {
  constexpr std::array kNames = {"matrix",  "add",      "subtract", "multiply", "divide",        "max",
                                 "min",     "tanh",     "erf",      "exp",      "exp minus one", "log",
                                 "sigmoid", "softplus", "sqrt",     "sum",      "pick",          "constant"};
  return kNames.at(static_cast<std::size_t>(kind));
}

/// Whether the operation has a width that is part of its name.
bool sayWidth(Kind kind) { return kind == Kind::kMatrix || kind >= Kind::kSum; }

/// Numbers of an operand, where sources have these columns.
std::size_t operandSize(const Operation& operation, const std::vector<int>& sources) {
  if (operation.kind == Kind::kMatrix) {
    return static_cast<std::size_t>(sources.at(0)) * operation.columns;
  }
  const bool has = operation.kind == Kind::kConstant || (isCombination(operation.kind) && sources.size() == 1);
  return has ? operation.columns : 0;
}

bool fitsColumns(const Operation& operation, const std::vector<int>& sources) {
  const auto is_same = [&](int columns) { return columns == operation.columns; };
  switch (operation.kind) {
    case Kind::kMatrix:
      return true;
    case Kind::kSum:
      return sources.at(0) % operation.columns == 0;
    case Kind::kPick:
      return static_cast<int>(operation.picked.size()) == operation.columns;
    default:
      return std::all_of(sources.begin(), sources.end(), is_same);
  }
}

bool fitsCount(Kind kind, std::size_t sources) {
  if (kind == Kind::kConstant) {
    return sources == 0;
  }
  return sources == 1 || (sources == 2 && isCombination(kind)) || (sources > 0 && kind == Kind::kPick);
}

/// Throws InternalError unless the operation fits sources of these columns.
void requireFit(const Operation& operation, const std::vector<int>& sources) {
  if (operation.columns < 1 || !fitsCount(operation.kind, sources.size()) || !fitsColumns(operation, sources) ||
      operation.operand.size() != operandSize(operation, sources)) {
    throw InternalError(std::string("operation ") + toString(operation.kind) + ": must fit the " +
                        std::to_string(sources.empty() ? 0 : sources.front()) + " columns before it");
  }
}

/// Values that the operation at `index` takes.
std::vector<int> sourcesOf(const Operation& operation, int index) {
  const bool takes_none = operation.kind == Kind::kConstant;
  return operation.sources.empty() && !takes_none ? std::vector<int>{index} : operation.sources;
}

std::string textOf(const Operation& operation, int index) {
  std::string text = toString(operation.kind);
  text += sayWidth(operation.kind) ? " " + std::to_string(operation.columns) : "";
  const std::vector<int> sources = sourcesOf(operation, index);
  if (sources.empty() || sources == std::vector<int>{index}) {
    return text;
  }
  for (std::size_t i = 0; i < sources.size(); ++i) {
    text += (i == 0 ? " (" : ", ") + std::to_string(sources[i]);
  }
  return text + ")";
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

/// Where values lie: a value has its slot until the last operation that takes it; then another value gets the slot.
struct NetworkKernel::Plan {
  explicit Plan(NetworkKernel& kernel, const std::vector<Operation>& operations)
      : slots(kernel.slots_), last_use(operations.size() + 1, -1), columns{kernel.inputs_} {
    const int count = static_cast<int>(operations.size());
    for (int i = 0; i < count; ++i) {
      for (const int source : sourcesOf(operations[i], i)) {
        if (source < 0 || source > i) {
          throw InternalError("operation " + std::to_string(i) + ": must take values before it");
        }
        last_use[source] = i;
      }
    }
    last_use.back() = count;
    slot_of.push_back(newSlot(kernel.inputs_, -1));
    for (int i = 0; i < count; ++i) {
      steps.push_back(stepOf(operations[i], i));
    }
  }

  Step stepOf(const Operation& operation, int index) {
    const std::vector<int> sources = sourcesOf(operation, index);
    std::vector<int> source_columns(sources.size());
    std::transform(sources.begin(), sources.end(), source_columns.begin(), [&](int i) { return columns[i]; });
    requireFit(operation, source_columns);
    Step step{operation.kind, sources.empty() ? 0 : source_columns[0], operation.columns,
              padded(operation.operand, operation.columns)};
    step.source = sources.empty() ? -1 : slot_of[sources[0]];
    step.other = sources.size() == 2 && isCombination(operation.kind) ? slot_of[sources[1]] : -1;
    addRuns(operation, sources, step);
    const bool in_place = (isCombination(operation.kind) || isFunction(operation.kind)) &&
                          last_use[sources[0]] == index && step.other != step.source;
    step.result = in_place ? step.source : newSlot(operation.columns, index);
    owner[step.result] = index + 1;
    slot_of.push_back(step.result);
    columns.push_back(operation.columns);
    return step;
  }

  /// A slot whose value is used no more, the widest one, or a new one.
  int newSlot(int for_columns, int index) {
    int found = -1;
    for (int slot = 0; slot < static_cast<int>(slots.size()); ++slot) {
      const bool is_free = last_use[owner[slot]] < index;
      found = is_free && (found < 0 || slots[slot].lines_per_row > slots[found].lines_per_row) ? slot : found;
    }
    if (found < 0) {
      found = static_cast<int>(slots.size());
      slots.emplace_back();
      owner.push_back(0);
    }
    slots[found].lines_per_row = std::max(slots[found].lines_per_row, linesFor(for_columns));
    return found;
  }

  void addRuns(const Operation& operation, const std::vector<int>& sources, Step& step) const {
    for (const int column : operation.picked) {
      int first = column;
      std::size_t source = 0;
      while (source < sources.size() && first >= columns[sources[source]]) {
        first -= columns[sources[source++]];
      }
      if (source == sources.size() || first < 0) {
        throw InternalError("operation pick: must take columns of its sources, not " + std::to_string(column));
      }
      append(step.runs, slot_of[sources[source]], first);
    }
  }

  /// Appends a column to the last run, or as the first of a new one.
  static void append(std::vector<Run>& runs, int slot, int column) {
    if (!runs.empty() && runs.back().slot == slot) {
      Run& run = runs.back();
      run.stride = run.count == 1 ? column - run.first : run.stride;
      if (column == run.first + run.stride * run.count) {
        ++run.count;
        return;
      }
    }
    runs.push_back({slot, column, 1, 1});
  }

  std::vector<Slot>& slots;
  std::vector<int> last_use;  // index of the last operation that takes a value
  std::vector<int> columns;   // of each value
  std::vector<int> slot_of;   // of each value
  std::vector<int> owner;     // value that a slot has
  std::vector<Step> steps;
};

NetworkKernel::NetworkKernel(int inputs, const std::vector<Operation>& operations, InstructionSet instruction_set)
    : inputs_(inputs), outputs_(inputs), instruction_set_(instruction_set), text_(std::to_string(inputs)) {
  Plan plan(*this, operations);
  outputs_ = plan.columns.back();
  result_slot_ = plan.slot_of.back();
  steps_ = std::make_shared<const std::vector<Step>>(std::move(plan.steps));
  for (Slot& slot : slots_) {
    slot.rows.resize(static_cast<std::size_t>(kBlockRows) * slot.lines_per_row);
  }
  for (std::size_t i = 0; i < operations.size(); ++i) {
    text_ += ", " + textOf(operations[i], static_cast<int>(i));
  }
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
    std::copy_n(inputs + i * inputs_, inputs_, row(0, i));
  }
  for (const Step& step : *steps_) {
    take(step, rows);
  }
  for (int i = 0; i < rows; ++i) {
    std::copy_n(row(result_slot_, i), outputs_, outputs + i * outputs_);
  }
}

void NetworkKernel::take(const Step& step, int rows) {
  if (step.kind == Kind::kMatrix) {
    return multiplyRows(step, rows);
  }
  const float* constants = step.operand.empty() ? nullptr : step.operand.front().values.data();
  for (int i = 0; i < rows; ++i) {
    float* const result = row(step.result, i);
    if (step.kind == Kind::kPick) {
      pickRow(step, i);
    } else if (step.kind == Kind::kConstant) {
      std::copy_n(constants, step.columns, result);
    } else if (step.kind == Kind::kSum) {
      const int part = step.inputs / step.columns;
      for (int j = 0; j < step.columns; ++j) {
        result[j] = sumOf(row(step.source, i) + j * part, part);
      }
    } else {
      if (step.result != step.source) {
        std::copy_n(row(step.source, i), step.columns, result);
      }
      if (isCombination(step.kind)) {
        combine(step.kind, step.other < 0 ? constants : row(step.other, i), step.columns, result);
      } else {
        applyFunction(step.kind, result, linesFor(step.columns) * kLineValues, instruction_set_);
      }
    }
  }
}

void NetworkKernel::multiplyRows(const Step& step, int rows) {
  multiply({row(step.source, 0), step.operand.front().values.data(), row(step.result, 0), rows, step.inputs,
            linesFor(step.columns) * kLineValues, slots_[step.source].lines_per_row * kLineValues,
            slots_[step.result].lines_per_row * kLineValues},
           instruction_set_);
}

void NetworkKernel::pickRow(const Step& step, int index) {
  float* target = row(step.result, index);
  for (const Run& run : step.runs) {
    const float* const source = row(run.slot, index) + run.first;
    if (run.stride == 1) {
      std::copy_n(source, run.count, target);
    } else {
      for (int j = 0; j < run.count; ++j) {
        target[j] = source[j * run.stride];
      }
    }
    target += run.count;
  }
}

}  // namespace pusht
