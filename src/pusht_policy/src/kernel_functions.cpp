// SPDX-License-Identifier: BSD-3-Clause
#include "kernel_functions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#pragma GCC diagnostic ignored "-Wpsabi"  // vectors as arguments: all of it is inlined

namespace pusht {
namespace {

// A function is written once, over vectors of doubles of any width: every lane does the same operations in the same
// order, and `-ffp-contract=off` keeps multiplication and addition apart.

struct TwoLanes {
  using Floats = float __attribute__((vector_size(8), may_alias, aligned(4)));
  using Doubles = double __attribute__((vector_size(16)));
  using Integers = std::uint64_t __attribute__((vector_size(16)));
};
struct FourLanes {
  using Floats = float __attribute__((vector_size(16), may_alias, aligned(4)));
  using Doubles = double __attribute__((vector_size(32)));
  using Integers = std::uint64_t __attribute__((vector_size(32)));
};
struct EightLanes {
  using Floats = float __attribute__((vector_size(32), may_alias, aligned(4)));
  using Doubles = double __attribute__((vector_size(64)));
  using Integers = std::uint64_t __attribute__((vector_size(64)));
};

constexpr int kMantissaBits = 52;
constexpr std::uint64_t kOneBits = std::uint64_t{1023} << kMantissaBits;
constexpr double kRounder = 0x1.8p52;  // added and subtracted, it rounds to an integer, which is in its last bits
constexpr double kLn2High = 0x1.62e42feep-1;  // times an exponent, it is exact
constexpr double kLn2Low = 0x1.a39ef35793c76p-33;

template <class Lanes>
struct Functions {
  using Doubles = typename Lanes::Doubles;
  using Integers = typename Lanes::Integers;

  [[gnu::always_inline]] static Doubles all(double value) { return value - Doubles{}; }

  template <std::size_t kCount>
  [[gnu::always_inline]] static Doubles polynomial(const std::array<double, kCount>& coefficients, const Doubles& x) {
    Doubles sum = all(coefficients[kCount - 1]);
#pragma GCC unroll 32
    for (int i = static_cast<int>(kCount) - 2; i >= 0; --i) {
      sum = sum * x + coefficients[i];
    }
    return sum;
  }

  /// Parts of e^x = power + power * rest, where power is one of 2 and |rest| < 0.42.
  struct Exponential {
    Doubles power;
    Doubles rest;
  };

  /// Taylor's series on +-ln(2) / 2, to 2e-17. Beyond the bounds, which are in the range of double, the float result is
  /// 0 or infinite.
  [[gnu::always_inline]] static Exponential exponential(const Doubles& argument) {
    constexpr double kLeast = -700.0;
    constexpr double kMost = 700.0;
    constexpr double kPerLn2 = 0x1.71547652b82fep0;
    static constexpr std::array kSeries = {1.0 / 2,       1.0 / 6,        1.0 / 24,        1.0 / 120,
                                           1.0 / 720,     1.0 / 5040,     1.0 / 40320,     1.0 / 362880,
                                           1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800};
    const Doubles at_least = argument < kLeast ? all(kLeast) : argument;
    const Doubles x = at_least > kMost ? all(kMost) : at_least;
    const Doubles shifted = x * kPerLn2 + kRounder;
    const Doubles exponent = shifted - kRounder;
    const Doubles r = x - exponent * kLn2High - exponent * kLn2Low;
    const Doubles rest = r + r * r * polynomial(kSeries, r);
    return {(Doubles)(((Integers)shifted << kMantissaBits) + kOneBits), rest};
  }

  [[gnu::always_inline]] static Doubles exp(const Doubles& x) {
    const Exponential e = exponential(x);
    return e.power + e.power * e.rest;
  }

  [[gnu::always_inline]] static Doubles expMinusOne(const Doubles& x) {
    const Exponential e = exponential(x);
    return e.power * e.rest + (e.power - 1.0);
  }

  [[gnu::always_inline]] static Doubles sigmoid(const Doubles& x) { return 1.0 / (1.0 + exp(-x)); }

  [[gnu::always_inline]] static Doubles magnitude(const Doubles& x) { return (Doubles)((Integers)x & ~kSignBit); }
  [[gnu::always_inline]] static Doubles withSignOf(const Doubles& x, const Doubles& magnitude) {
    return (Doubles)((Integers)magnitude | ((Integers)x & kSignBit));
  }

  [[gnu::always_inline]] static Doubles tanh(const Doubles& x) {
    const Doubles e = expMinusOne(-2.0 * magnitude(x));
    return withSignOf(x, (0.0 - e) / (e + 2.0));
  }

  /// x times a polynomial in x^2 up to 4, a Chebyshev fit with a relative error of 2e-11; beyond, the float is 1.
  [[gnu::always_inline]] static Doubles erf(const Doubles& x) {
    constexpr double kMost = 4.0;
    static constexpr std::array kFit = {0.353530995644115022,     -0.17657623321207172,      0.131675116723653611,
                                        -0.107710449040000534,    0.0902090009164634716,     -0.0747277260711611664,
                                        0.0598867995441831537,    -0.0457664819493776951,    0.0330614691469806,
                                        -0.0224661834254027106,   0.0143457370256611412,     -0.00863003774965730007,
                                        0.00486462751615975456,   -0.00253035653071606083,   0.00127232419626191736,
                                        -0.000673086548474439132, 0.000299180998130682474,   -0.0000723168414684691726,
                                        0.000031074384035564711,  -0.0000367141020877584915, 0.0000132555242082359636};
    const Doubles bounded = magnitude(x) > kMost ? withSignOf(x, all(kMost)) : x;
    return bounded * polynomial(kFit, bounded * bounded / 8.0 - 1.0);
  }

  /// log(1 + x) + exponent * ln(2), from the series of 2 atanh(x / (2 + x)), for 1 + x in sqrt(1/2) to sqrt(2).
  [[gnu::always_inline]] static Doubles logOf(const Doubles& x, const Doubles& exponent) {
    static constexpr std::array kSeries = {1.0 / 3,  1.0 / 5,  1.0 / 7,  1.0 / 9, 1.0 / 11,
                                           1.0 / 13, 1.0 / 15, 1.0 / 17, 1.0 / 19};
    const Doubles s = x / (2.0 + x);
    const Doubles s2 = s * s;
    return exponent * kLn2High + (2.0 * (s + s * s2 * polynomial(kSeries, s2)) + exponent * kLn2Low);
  }

  [[gnu::always_inline]] static Doubles log(const Doubles& x) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const Integers shifted = (Integers)x + (kOneBits - kSqrtHalfBits);
    const Integers power = (shifted & kExponentBits) - kOneBits;  // the exponent, where a double has it
    const Doubles exponent = (Doubles)(((shifted >> kMantissaBits) - 1023U) + kRounderBits) - kRounder;
    const Doubles result = logOf((Doubles)((Integers)x - power) - 1.0, exponent);
    const Doubles of_positive = x == kInfinity ? all(kInfinity) : result;
    return x > 0.0 ? of_positive : (x == 0.0 ? all(-kInfinity) : all(std::numeric_limits<double>::quiet_NaN()));
  }

  /// log(1 + e^x) = max(x, 0) + log(1 + e^-|x|).
  [[gnu::always_inline]] static Doubles softplus(const Doubles& x) {
    const Doubles e = exp(-magnitude(x));
    const auto is_large = e > 0x1.a827999fcef32p-2;  // sqrt(2) - 1
    const Doubles logarithm = logOf(is_large ? (e - 1.0) / 2.0 : e, is_large ? all(1.0) : all(0.0));
    return (x > 0.0 ? x : (x == x ? all(0.0) : x)) + logarithm;
  }

  static constexpr std::uint64_t kSignBit = std::uint64_t{1} << 63U;
  static constexpr std::uint64_t kExponentBits = std::uint64_t{0xfff} << kMantissaBits;
  static constexpr std::uint64_t kSqrtHalfBits = 0x3fe6a09e667f3bcdU;
  static constexpr std::uint64_t kRounderBits = 0x4338000000000000U;
};

template <class Lanes, typename Lanes::Doubles (*kFunction)(const typename Lanes::Doubles&)>
[[gnu::always_inline]] inline void forEachVector(float* values, int count) {
  using Floats = typename Lanes::Floats;
  constexpr int kLanes = sizeof(Floats) / sizeof(float);
#pragma GCC unroll 2
  for (int i = 0; i < count; i += kLanes) {
    auto& floats = *reinterpret_cast<Floats*>(values + i);
    floats = __builtin_convertvector(kFunction(__builtin_convertvector(floats, typename Lanes::Doubles)), Floats);
  }
}

template <class Lanes>
[[gnu::always_inline]] inline void applyAll(Operation::Kind function, float* values, int count) {
  using F = Functions<Lanes>;
  switch (function) {
    case Operation::Kind::kTanh:
      return forEachVector<Lanes, F::tanh>(values, count);
    case Operation::Kind::kErf:
      return forEachVector<Lanes, F::erf>(values, count);
    case Operation::Kind::kExp:
      return forEachVector<Lanes, F::exp>(values, count);
    case Operation::Kind::kExpMinusOne:
      return forEachVector<Lanes, F::expMinusOne>(values, count);
    case Operation::Kind::kLog:
      return forEachVector<Lanes, F::log>(values, count);
    case Operation::Kind::kSigmoid:
      return forEachVector<Lanes, F::sigmoid>(values, count);
    case Operation::Kind::kSoftplus:
      return forEachVector<Lanes, F::softplus>(values, count);
    default:
      break;
  }
}

void applyBaseline(Operation::Kind function, float* values, int count) { applyAll<TwoLanes>(function, values, count); }

#if defined(__x86_64__)
[[gnu::target("avx2")]] void applyAvx2(Operation::Kind function, float* values, int count) {
  applyAll<FourLanes>(function, values, count);
}

[[gnu::target("avx512f")]] void applyAvx512(Operation::Kind function, float* values, int count) {
  applyAll<EightLanes>(function, values, count);
}
#endif

}  // namespace

void applyFunction(Operation::Kind function, float* values, int count, InstructionSet instruction_set) {
  if (function == Operation::Kind::kSqrt) {  // exact everywhere
    std::transform(values, values + count, values, [](float x) { return std::sqrt(x); });
    return;
  }
  switch (instruction_set) {
#if defined(__x86_64__)
    case InstructionSet::kAvx512:
      return applyAvx512(function, values, count);
    case InstructionSet::kAvx2:
      return applyAvx2(function, values, count);
#endif
    default:
      return applyBaseline(function, values, count);
  }
}

}  // namespace pusht
