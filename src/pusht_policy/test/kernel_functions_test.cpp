// SPDX-License-Identifier: BSD-3-Clause
// The kernel's functions against those of the C library in long double, over the whole range of float32.
#include "../src/kernel_functions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace pusht {
namespace {

using Kind = Operation::Kind;
using Real = long double;

struct KernelFunction {
  const char* name;
  Kind kind;
  Real (*expected)(Real x);
};

const std::vector<KernelFunction> kFunctions = {
    {"tanh", Kind::kTanh, [](Real x) { return std::tanh(x); }},
    {"erf", Kind::kErf, [](Real x) { return std::erf(x); }},
    {"exp", Kind::kExp, [](Real x) { return std::exp(x); }},
    {"expm1", Kind::kExpMinusOne, [](Real x) { return std::expm1(x); }},
    {"log", Kind::kLog, [](Real x) { return std::log(x); }},
    {"sigmoid", Kind::kSigmoid, [](Real x) { return 1.0L / (1.0L + std::exp(-x)); }},
    {"softplus", Kind::kSoftplus, [](Real x) { return std::max(x, 0.0L) + std::log1p(std::exp(-std::abs(x))); }},
    {"sqrt", Kind::kSqrt, [](Real x) { return std::sqrt(x); }},
};

/// Numbers of all exponents and both signs, denormal ones among them, zeros, infinities, and NaN.
std::vector<float> allOverTheRange() {
  constexpr std::uint64_t kStep = 25'013;  // of the bits, a prime
  std::vector<float> numbers = {0.0F, -0.0F, std::numeric_limits<float>::infinity(),
                                -std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()};
  for (std::uint64_t pattern = 1; pattern < (std::uint64_t{1} << 32U); pattern += kStep) {
    const auto bits = static_cast<std::uint32_t>(pattern);
    std::memcpy(&numbers.emplace_back(), &bits, sizeof(bits));
  }
  numbers.resize((numbers.size() + kLineValues - 1) / kLineValues * kLineValues);
  return numbers;
}

std::uint32_t bitsOf(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof(bits));
  return bits;
}

std::vector<float> applied(Kind kind, std::vector<float> values, InstructionSet instruction_set) {
  applyFunction(kind, values.data(), static_cast<int>(values.size()), instruction_set);
  return values;
}

/// Distance in units of the last place of the expected float.
double ulps(float actual, Real expected) {
  const float rounded = std::abs(static_cast<float>(expected));
  const double ulp = std::nextafter(rounded, std::numeric_limits<float>::infinity()) - rounded;
  return static_cast<double>(std::abs(actual - expected)) / ulp;
}

TEST(KernelFunctions, AreWithinTheirBoundAllOverTheRange) {
  constexpr double kBound = 0.501;
  const std::vector<float> x = allOverTheRange();
  for (const KernelFunction& function : kFunctions) {
    const std::vector<float> y = applied(function.kind, x, availableInstructionSets().back());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Real expected = function.expected(x[i]);
      if (std::isnan(expected) || std::isnan(x[i])) {
        ASSERT_TRUE(std::isnan(y[i])) << function.name << " of " << x[i];
      } else if (std::isinf(static_cast<float>(expected))) {
        ASSERT_EQ(y[i], static_cast<float>(expected)) << function.name << " of " << x[i];
      } else {
        ASSERT_LE(ulps(y[i], expected), kBound) << function.name << " of " << x[i] << " is " << y[i];
      }
    }
  }
}

/// Every thousandth float; once all 4 billion were compared (docs/determinism.md).
TEST(KernelFunctions, TanhHasTheBitsOfTheRoundedDouble) {
  const std::vector<float> x = allOverTheRange();
  const std::vector<float> y = applied(Kind::kTanh, x, availableInstructionSets().back());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const auto expected = static_cast<float>(std::tanh(static_cast<double>(x[i])));
    ASSERT_TRUE(std::isnan(expected) || bitsOf(y[i]) == bitsOf(expected)) << x[i];
  }
}

TEST(KernelFunctions, HaveTheSameBitsOnEveryInstructionSet) {
  std::vector<float> x = allOverTheRange();
  x.erase(std::remove_if(x.begin(), x.end(), [](float value) { return std::isnan(value) || value < 0.0F; }), x.end());
  x.resize(x.size() / kLineValues * kLineValues);
  for (const double sign : {1.0, -1.0}) {
    std::vector<float> signed_x = x;
    for (float& value : signed_x) {
      value *= static_cast<float>(sign);
    }
    for (const KernelFunction& function : kFunctions) {
      const std::vector<float> baseline = applied(function.kind, signed_x, InstructionSet::kBaseline);
      for (const InstructionSet instruction_set : availableInstructionSets()) {
        const std::vector<float> y = applied(function.kind, signed_x, instruction_set);
        for (std::size_t i = 0; i < y.size(); ++i) {
          const bool same = bitsOf(y[i]) == bitsOf(baseline[i]);
          ASSERT_TRUE(same || (std::isnan(y[i]) && std::isnan(baseline[i]))) << function.name << " of " << signed_x[i];
        }
      }
    }
  }
}

}  // namespace
}  // namespace pusht
