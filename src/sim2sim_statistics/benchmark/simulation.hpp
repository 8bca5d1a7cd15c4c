// SPDX-License-Identifier: BSD-3-Clause
/// Monte Carlo experiments: repetitions of a question whose answer is yes or no.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <future>
#include <optional>
#include <random>
#include <vector>

#include "known_truths.hpp"

namespace sim2sim {

/// Share of repetitions with the answer yes, among those that have an answer.
struct Proportion {
  std::int64_t yes = 0;
  std::int64_t all = 0;

  double value() const { return static_cast<double>(yes) / static_cast<double>(all); }
  double error(double p) const { return std::sqrt(p * (1.0 - p) / static_cast<double>(all)); }
};

/// Answers of one repetition to N questions; none where there is nothing to measure.
template <std::size_t N>
using Answers = std::array<std::optional<bool>, N>;

/// Repeater of experiments, in threads. Each experiment has random numbers of its own, by block of repetitions, so the
/// number of threads does not change the answers.
class Simulation {
 public:
  Simulation(int repetitions, std::uint64_t seed) : repetitions_(repetitions), seed_(seed) {}

  /// Shares over all repetitions of an experiment that answers N questions.
  template <std::size_t N>
  std::array<Proportion, N> ask(const std::function<Answers<N>(Random&)>& repetition) {
    constexpr int kBlocks = 16;
    ++experiment_;
    std::vector<std::future<std::array<Proportion, N>>> blocks;
    blocks.reserve(kBlocks);
    for (int block = 0; block < kBlocks; ++block) {
      blocks.push_back(std::async(std::launch::async, [this, block, &repetition] {
        std::seed_seq seeds = {seed_ & 0xffffffffU, seed_ >> 32U, experiment_, static_cast<std::uint64_t>(block)};
        Random random(seeds);
        std::array<Proportion, N> shares;
        const int repetitions = repetitions_ * (block + 1) / kBlocks - repetitions_ * block / kBlocks;
        for (int i = 0; i < repetitions; ++i) {
          const Answers<N> answers = repetition(random);
          for (std::size_t question = 0; question < N; ++question) {
            shares[question].yes += answers[question].value_or(false) ? 1 : 0;
            shares[question].all += answers[question] ? 1 : 0;
          }
        }
        return shares;
      }));
    }
    std::array<Proportion, N> total;
    for (auto& block : blocks) {
      const std::array<Proportion, N> shares = block.get();
      for (std::size_t question = 0; question < N; ++question) {
        total[question].yes += shares[question].yes;
        total[question].all += shares[question].all;
      }
    }
    return total;
  }

  /// Share over all repetitions of an experiment that answers one question.
  Proportion ask(const std::function<std::optional<bool>(Random&)>& repetition) {
    return ask<1>([&](Random& random) { return Answers<1>{repetition(random)}; })[0];
  }

 private:
  int repetitions_;
  std::uint64_t seed_;
  std::uint64_t experiment_ = 0;
};

/// Sample of size `n`.
inline std::vector<double> drawn(const std::function<double(Random&)>& draw, int n, Random& random) {
  std::vector<double> samples(n);
  std::generate(samples.begin(), samples.end(), [&] { return draw(random); });
  return samples;
}

}  // namespace sim2sim
