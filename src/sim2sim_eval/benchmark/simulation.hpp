// SPDX-License-Identifier: BSD-3-Clause
/// Repeated experiments with random numbers, and tables of how often they say yes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <future>
#include <iostream>
#include <iterator>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "known_truths.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/sequential.hpp"

namespace sim2sim {

/// How many of the repetitions that have an answer say yes.
struct Share {
  std::int64_t yes = 0;
  std::int64_t all = 0;

  double value() const { return static_cast<double>(yes) / static_cast<double>(all); }
  double error(double p) const { return std::sqrt(p * (1.0 - p) / static_cast<double>(all)); }
};

/// What one repetition says to each of N questions; none where there is nothing to say.
template <std::size_t N>
using Answers = std::array<std::optional<bool>, N>;

/// Repeats experiments. Each has random numbers of its own, in blocks, so that threads change nothing.
class Simulation {
 public:
  Simulation(int repetitions, std::uint64_t seed) : repetitions_(repetitions), seed_(seed) {}

  template <std::size_t N>
  std::array<Share, N> ask(const std::function<Answers<N>(Random&)>& repetition) {
    constexpr int kBlocks = 16;
    ++experiment_;
    std::vector<std::future<std::array<Share, N>>> blocks;
    blocks.reserve(kBlocks);
    for (int block = 0; block < kBlocks; ++block) {
      blocks.push_back(std::async(std::launch::async, [this, block, &repetition] {
        std::seed_seq seeds = {seed_ & 0xffffffffU, seed_ >> 32U, experiment_, static_cast<std::uint64_t>(block)};
        Random random(seeds);
        std::array<Share, N> shares;
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
    std::array<Share, N> total;
    for (auto& block : blocks) {
      const std::array<Share, N> shares = block.get();
      for (std::size_t question = 0; question < N; ++question) {
        total[question].yes += shares[question].yes;
        total[question].all += shares[question].all;
      }
    }
    return total;
  }

  Share ask(const std::function<std::optional<bool>(Random&)>& repetition) {
    return ask<1>([&](Random& random) { return Answers<1>{repetition(random)}; })[0];
  }

 private:
  int repetitions_;
  std::uint64_t seed_;
  std::uint64_t experiment_ = 0;
};

inline std::vector<double> drawn(const std::function<double(Random&)>& draw, int n, Random& random) {
  std::vector<double> samples(n);
  std::generate(samples.begin(), samples.end(), [&] { return draw(random); });
  return samples;
}

/// Which side of the nominal share is to be marked: `kWorse` is all for a test that promises no more than a bound.
enum class Marks { kBoth, kWorse };

/// In percent, with its standard error. Bold if it is worse than nominal by more than two standard errors, in brackets
/// if it is better.
inline std::string cell(const Share& share, double nominal, bool more_is_worse, Marks marks) {
  if (share.all == 0) {
    return "none";
  }
  const std::string text =
      pusht::fixedText(100.0 * share.value(), 1) + " ± " + pusht::fixedText(100.0 * share.error(share.value()), 1);
  const double deviation = (share.value() - nominal) / share.error(nominal) * (more_is_worse ? 1.0 : -1.0);
  if (deviation > 2.0) {
    return "**" + text + "**";
  }
  return deviation < -2.0 && marks == Marks::kBoth ? "(" + text + ")" : text;
}

inline std::string coverageCell(const Share& share) { return cell(share, kConfidence, false, Marks::kBoth); }
inline std::string errorCell(const Share& share) { return cell(share, kErrorRate, true, Marks::kBoth); }
inline std::string boundCell(const Share& share) { return cell(share, kErrorRate, true, Marks::kWorse); }

inline void printRow(const std::vector<std::string>& cells) {
  std::cout << "|";
  for (const std::string& text : cells) {
    std::cout << " " << text << " |";
  }
  std::cout << "\n" << std::flush;
}

inline void printHead(const std::string& title, std::vector<std::string> columns) {
  std::cout << "\n" << title << "\n\n";
  printRow(columns);
  std::fill(columns.begin(), columns.end(), "---");
  printRow(columns);
}

inline std::vector<std::string> withSizes(const std::vector<int>& sizes, std::vector<std::string> columns) {
  for (const int n : sizes) {
    columns.push_back("n = " + std::to_string(n));
  }
  return columns;
}

/// A row with a cell for each number of episodes.
inline void printSizes(const std::vector<int>& sizes, const std::string& what, const std::string& of,
                       const std::function<std::string(int)>& cell_of) {
  std::vector<std::string> cells = {what, of};
  std::transform(sizes.begin(), sizes.end(), std::back_inserter(cells), cell_of);
  printRow(cells);
}

inline std::optional<bool> holds(const std::optional<Interval>& interval, double truth) {
  return interval ? std::optional(interval->low <= truth && truth <= interval->high) : std::nullopt;
}

/// The interval of so many episodes.
using MakeInterval = std::function<std::optional<Interval>(int, Random&)>;

inline void printCoverage(Simulation& simulation, const std::vector<int>& sizes, const std::string& what,
                          const std::string& of, double truth, const MakeInterval& make) {
  printSizes(sizes, what, of, [&](int n) {
    return coverageCell(simulation.ask([&](Random& random) { return holds(make(n, random), truth); }));
  });
}

}  // namespace sim2sim
