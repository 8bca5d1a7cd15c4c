// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/network_kernel.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "libtorch_testing.hpp"
#include "network_testing.hpp"
#include "pusht_task/error.hpp"

namespace pusht {
namespace {

using testing::bits;
using Kind = Operation::Kind;
using Floats = std::vector<float>;

const std::vector<int> kWidths = {1, 3, 10, 17, 64, 100, 512};
const std::vector<int> kBatches = {1, 2, 3, 5, 6, 7, 8, 16, 33};
constexpr int kMaxRows = 33;

Floats randomFloats(int count, double bound) {
  static NumpyGenerator generator(1);
  return testing::randomValues(generator, count, bound);
}

/// A network with one of every kind of operation: normalization, two layers, tanh.
std::vector<Operation> randomNetwork(int inputs, int hidden, int outputs) {
  const double scale = 1.0 / std::sqrt(hidden);
  return {{Kind::kSubtract, inputs, randomFloats(inputs, 1.0)},
          {Kind::kMultiply, inputs, Floats(inputs, 2.0F)},
          {Kind::kDivide, inputs, randomFloats(inputs, 1.0)},
          {Kind::kMax, inputs, Floats(inputs, -1.0F)},
          {Kind::kMin, inputs, Floats(inputs, 1.0F)},
          {Kind::kMatrix, hidden, randomFloats(inputs * hidden, 1.0)},
          {Kind::kAdd, hidden, randomFloats(hidden, 1.0)},
          {Kind::kMax, hidden, Floats(hidden, 0.0F)},
          {Kind::kMatrix, outputs, randomFloats(hidden * outputs, scale)},
          {Kind::kTanh, outputs, {}}};
}

/// What an operation means, as plainly as can be.
Floats slowly(const Operation& operation, const Floats& row) {
  Floats result(operation.columns);
  for (int j = 0; j < operation.columns; ++j) {
    const float x = operation.kind == Kind::kMatrix ? 0.0F : row[j];
    const float c = operation.kind == Kind::kTanh ? 0.0F : operation.operand[j];
    switch (operation.kind) {
      case Kind::kMatrix:
        for (std::size_t k = 0; k < row.size(); ++k) {
          result[j] += row[k] * operation.operand[k * operation.columns + j];
        }
        break;
      case Kind::kAdd:
        result[j] = x + c;
        break;
      case Kind::kSubtract:
        result[j] = x - c;
        break;
      case Kind::kMultiply:
        result[j] = x * c;
        break;
      case Kind::kDivide:
        result[j] = x / c;
        break;
      case Kind::kMax:
        result[j] = std::max(x, c);
        break;
      case Kind::kMin:
        result[j] = std::min(x, c);
        break;
      case Kind::kTanh:
        result[j] = static_cast<float>(std::tanh(static_cast<double>(x)));
        break;
      default:
        throw std::logic_error("no operation of this test");
    }
  }
  return result;
}

Floats slowly(const std::vector<Operation>& operations, Floats row) {
  for (const Operation& operation : operations) {
    row = slowly(operation, row);
  }
  return row;
}

Floats run(NetworkKernel& kernel, const Floats& inputs) {
  Floats outputs(inputs.size() / kernel.inputs() * kernel.outputs());
  kernel.run(inputs, outputs);
  return outputs;
}

Floats firstRows(const Floats& rows, int count, int columns) { return {rows.begin(), rows.begin() + count * columns}; }

std::vector<int> range(int count) {
  std::vector<int> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

/// Every 16th number first, then these by halves.
float sumInHalves(const Floats& values) {
  Floats sums(16);
  for (std::size_t i = 0; i < values.size(); ++i) {
    sums[i % 16] += values[i];
  }
  for (std::size_t half = 8; half > 0; half /= 2) {
    for (std::size_t j = 0; j < half; ++j) {
      sums[j] += sums[j + half];
    }
  }
  return sums[0];
}

class NetworkKernelOn : public ::testing::TestWithParam<InstructionSet> {};

TEST_P(NetworkKernelOn, HasTheBitsOfThePlainLoopForAnyBatch) {
  for (const int inputs : {1, 10}) {
    for (const int hidden : kWidths) {
      for (const int outputs : {2, 17}) {
        SCOPED_TRACE(std::to_string(inputs) + " " + std::to_string(hidden) + " " + std::to_string(outputs));
        const std::vector<Operation> operations = randomNetwork(inputs, hidden, outputs);
        NetworkKernel kernel(inputs, operations, GetParam());
        const Floats rows = randomFloats(kMaxRows * inputs, 2.0);
        Floats expected;
        for (int i = 0; i < kMaxRows; ++i) {
          const Floats row = slowly(operations, {rows.begin() + i * inputs, rows.begin() + (i + 1) * inputs});
          expected.insert(expected.end(), row.begin(), row.end());
        }
        for (const int batch : kBatches) {
          EXPECT_EQ(bits(run(kernel, firstRows(rows, batch, inputs))), bits(firstRows(expected, batch, outputs)))
              << "batch of " << batch;
        }
      }
    }
  }
}

TEST_P(NetworkKernelOn, KeepsRowsApartThatAreNotFinite) {
  NetworkKernel kernel(10, randomNetwork(10, 64, 2), GetParam());
  Floats rows = randomFloats(7 * 10, 1.0);
  const Floats before = run(kernel, rows);
  rows[3 * 10 + 4] = std::numeric_limits<float>::quiet_NaN();
  const Floats after = run(kernel, rows);
  for (int row = 0; row < 7; ++row) {
    if (row == 3) {
      EXPECT_TRUE(std::isnan(after[row * 2]) && std::isnan(after[row * 2 + 1]));
    } else {
      EXPECT_EQ(after[row * 2], before[row * 2]);
      EXPECT_EQ(after[row * 2 + 1], before[row * 2 + 1]);
    }
  }
}

TEST_P(NetworkKernelOn, AgreesWithLibtorch) {
  for (const int inputs : kWidths) {
    for (const int outputs : kWidths) {
      const Floats matrix = randomFloats(inputs * outputs, 1.0 / std::sqrt(inputs));
      const Floats bias = randomFloats(outputs, 1.0);
      Floats rows = randomFloats(kMaxRows * inputs, 1.0);
      std::replace_if(
          rows.begin(), rows.end(), [](float x) { return x < -0.5F; }, -0.0F);
      NetworkKernel kernel(
          inputs,
          {{Kind::kMatrix, outputs, matrix}, {Kind::kAdd, outputs, bias}, {Kind::kMax, outputs, Floats(outputs, 0.0F)}},
          GetParam());
      const auto tensor = [](const Floats& values, int height, int width) {
        return torch::from_blob(const_cast<float*>(values.data()), {height, width});
      };
      const torch::Tensor weight = tensor(matrix, inputs, outputs).t().contiguous();
      for (const int batch : kBatches) {
        SCOPED_TRACE(std::to_string(batch) + " rows of " + std::to_string(inputs) + " to " + std::to_string(outputs));
        const torch::Tensor result =
            torch::relu(torch::linear(tensor(rows, batch, inputs), weight, tensor(bias, 1, outputs)[0]));
        const Floats expected(result.data_ptr<float>(), result.data_ptr<float>() + result.numel());
        const Floats actual = run(kernel, firstRows(rows, batch, inputs));
        for (std::size_t i = 0; i < actual.size(); ++i) {
          ASSERT_NEAR(actual[i], expected[i], 1e-5F);
        }
        if (testing::onReferenceBlas()) {
          EXPECT_EQ(bits(actual), bits(expected));
        }
      }
    }
  }
}

TEST(NetworkKernel, IsTestedOnTheReferenceBlasIfThatIsAskedFor) {
  if (std::getenv("PUSHT_REQUIRE_REFERENCE_BLAS") != nullptr) {
    EXPECT_TRUE(testing::onReferenceBlas()) << "the active BLAS is " << activeBlas();
  }
}

/// A graph that uses every value again, wider and narrower, so that slots change their owners.
TEST_P(NetworkKernelOn, HasTheBitsOfPlainLoopsOnSeveralPaths) {
  constexpr int kColumns = 40;
  const Floats matrix = randomFloats(10 * kColumns, 1.0);
  NetworkKernel kernel(10,
                       {{Kind::kMatrix, kColumns, matrix},
                        {Kind::kMultiply, kColumns, {}, {1, 1}},
                        {Kind::kPick, 90, {}, {2, 0, 1}, range(90)},
                        {Kind::kSum, 2, {}, {3}},
                        {Kind::kPick, 10, {}, {4, 0}, {0, 0, 0, 0, 0, 1, 1, 1, 2, 11}},
                        {Kind::kConstant, 10, Floats(10, 0.5F)},
                        {Kind::kSubtract, 10, {}, {6, 5}},
                        {Kind::kMax, 10, {}, {7, 0}},
                        {Kind::kDivide, 10, Floats(10, 3.0F)}},
                       GetParam());
  EXPECT_EQ(kernel.operations(),
            "10, matrix 40, multiply (1, 1), pick 90 (2, 0, 1), sum 2, pick 10 (4, 0), constant 10, subtract (6, 5), "
            "max (7, 0), divide");
  const Floats rows = randomFloats(kMaxRows * 10, 2.0);
  Floats expected;
  for (int i = 0; i < kMaxRows; ++i) {
    const Floats x(rows.begin() + i * 10, rows.begin() + (i + 1) * 10);
    const Floats product = slowly({Kind::kMatrix, kColumns, matrix}, x);
    Floats all;
    std::transform(product.begin(), product.end(), std::back_inserter(all), [](float p) { return p * p; });
    all.insert(all.end(), x.begin(), x.end());
    all.insert(all.end(), product.begin(), product.end());
    const std::array<float, 2> sums = {sumInHalves({all.begin(), all.begin() + 45}),
                                       sumInHalves({all.begin() + 45, all.end()})};
    for (int j = 0; j < 10; ++j) {
      const float picked = j < 5 ? sums[0] : j < 8 ? sums[1] : j == 8 ? x[0] : x[9];
      expected.push_back(std::max(0.5F - picked, x[j]) / 3.0F);
    }
  }
  for (const int batch : kBatches) {
    EXPECT_EQ(bits(run(kernel, firstRows(rows, batch, 10))), bits(firstRows(expected, batch, 10)));
  }
}

INSTANTIATE_TEST_SUITE_P(, NetworkKernelOn, ::testing::ValuesIn(availableInstructionSets()), [](const auto& info) {
  std::string name = toString(info.param);
  name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
  return name;
});

TEST(NetworkKernel, SaysWhatItDoes) {
  const NetworkKernel kernel(10, randomNetwork(10, 64, 2));
  EXPECT_EQ(kernel.operations(), "10, subtract, multiply, divide, max, min, matrix 64, add, max, matrix 2, tanh");
}

TEST(NetworkKernel, RefusesOperationsThatDoNotFit) {
  EXPECT_THROW(NetworkKernel(3, {{Kind::kAdd, 2, {1.0F, 2.0F}}}), InternalError);
  EXPECT_THROW(NetworkKernel(3, {{Kind::kAdd, 3, {1.0F, 2.0F}}}), InternalError);
  EXPECT_THROW(NetworkKernel(3, {{Kind::kMatrix, 2, Floats(5)}}), InternalError);
  EXPECT_THROW(NetworkKernel(3, {{Kind::kTanh, 3, Floats(3)}}), InternalError);
  EXPECT_THROW(NetworkKernel(3, {{Kind::kMatrix, 0, {}}}), InternalError);
  EXPECT_THROW(NetworkKernel(3, {{Kind::kAdd, 3, {}, {0, 1}}}), InternalError) << "a value that comes later";
  EXPECT_THROW(NetworkKernel(3, {{Kind::kAdd, 3, Floats(3), {0, 0}}}), InternalError);
  EXPECT_THROW(NetworkKernel(3, {{Kind::kPick, 1, {}, {0}, {3}}}), InternalError);
  EXPECT_THROW(NetworkKernel(3, {{Kind::kSum, 2, {}}}), InternalError);
  EXPECT_THROW(NetworkKernel(3, {{Kind::kConstant, 2, Floats(1)}}), InternalError);
}

TEST(NetworkKernel, RefusesRowsThatDoNotFit) {
  NetworkKernel kernel(3, {{Kind::kMatrix, 2, Floats(6)}});
  Floats outputs(2);
  EXPECT_THROW(kernel.run(Floats(4), outputs), InternalError);
  EXPECT_THROW(kernel.run(Floats(6), outputs), InternalError);
}

}  // namespace
}  // namespace pusht
