// SPDX-License-Identifier: BSD-3-Clause
// Coverage of intervals and error rates of tests, on simulated episodes whose truth is known. docs/statistics
// has its output, as data; coverage_figure.py makes it.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <iostream>
#include <map>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "coverage_tables.hpp"
#include "crossed_coverage.hpp"
#include "equivalent_coverage.hpp"
#include "known_truths.hpp"
#include "ranking_coverage.hpp"
#include "repeat_coverage.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/pairs.hpp"
#include "sim2sim_statistics/sequential.hpp"
#include "simulation.hpp"
#include "tail_coverage.hpp"
#include "transfer_coverage.hpp"

namespace sim2sim {
namespace {

constexpr int kLooks = 2000;  ///< after each of so many episodes
const std::vector<int> kSizes = {10, 20, 50, 500};

void intervals(Simulation& simulation, const World& world) {
  printHead("Share of repetitions in which the interval holds the truth [%], nominal 95",
            withSizes(kSizes, {"interval", "population"}));
  for (const Rates& rates : world.rates) {
    printCoverage(simulation, kSizes, "Wilson", rates.name, rates.second(), [&](int n, Random& random) {
      const PairTable table = rates.draw(n, random);
      return wilsonInterval(table.both + table.second_only, n);
    });
  }
  for (const Population& population : world.populations) {
    printCoverage(simulation, kSizes, "mean, log-t", population.name, population.mean, [&](int n, Random& random) {
      return meanOf(drawn(population.draw, n, random), population.limit).interval;
    });
  }
  for (const Population& population : world.populations) {
    printCoverage(simulation, kSizes, "median, order statistics", population.name, population.median,
                  [&](int n, Random& random) { return medianOf(drawn(population.draw, n, random)).interval; });
  }
  for (const Rates& rates : world.rates) {
    printCoverage(simulation, kSizes, "difference of rates, Tango", rates.name, rates.second() - rates.first(),
                  [&](int n, Random& random) { return tangoInterval(rates.draw(n, random)); });
  }
  for (const Rates& rates : world.rates) {
    printCoverage(simulation, kSizes, "transfer, Tang", rates.name, rates.second() / rates.first(),
                  [&](int n, Random& random) { return tangInterval(rates.draw(n, random)); });
  }
  for (const Differences& differences : world.differences) {
    printCoverage(simulation, kSizes, "paired difference, t", differences.name, differences.mean,
                  [&](int n, Random& random) { return meanDifference(drawn(differences.draw, n, random)).interval; });
  }
}

std::optional<bool> finds(const std::optional<double>& p) { return p ? std::optional(*p <= kErrorRate) : std::nullopt; }

/// The rows of a sweep, all as good as the baseline: one finding is one too many. Answers: t uncorrected, after Holm,
/// and Bonferroni's simultaneous intervals.
Answers<3> family(int n, Random& random) {
  constexpr int kRows = 20;
  constexpr double kCorrelation = 0.73;  // of each with what the start does to all rows
  std::vector<std::vector<double>> differences(kRows, std::vector<double>(n));
  for (int i = 0; i < n; ++i) {
    const double start = std::sqrt(kCorrelation) * normal(random);
    const auto row = [&] { return kPosition.at(start + std::sqrt(1.0 - kCorrelation) * normal(random)); };
    const double baseline = row();
    for (std::vector<double>& of_row : differences) {
      of_row[i] = row() - baseline;
    }
  }
  std::vector<double> p;
  bool excluded = false;
  for (const std::vector<double>& of_row : differences) {
    const Difference difference = meanDifference(of_row, 1.0 - (1.0 - kConfidence) / kRows);
    if (!difference.p) {
      return {};
    }
    p.push_back(*difference.p);
    excluded = excluded || !*holds(difference.interval, 0.0);
  }
  const auto least = [](const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); };
  return {finds(least(p)), finds(least(holm(p))), excluded};
}

/// Two equally good ones, of whose pairs that share is discordant.
Rates equallyGood(double discordant) {
  return {"discordant " + fixedText(discordant, 2), 0.0, 0.5 * discordant, 0.5 * discordant};
}

void tests(Simulation& simulation, const World& world) {
  printHead("Share of repetitions in which a test finds a difference that is not there [%], nominal 5",
            withSizes(kSizes, {"test", "population"}));
  for (const auto& [name, test] :
       {std::pair("McNemar mid-p", &mcnemarMidP), std::pair("McNemar exact", &mcnemarExact)}) {
    for (const double discordant : {0.27, 0.55, 1.0}) {
      const Rates rates = equallyGood(discordant);
      printSizes(kSizes, name, rates.name, [&, test = test](int n) {
        return errorCell(simulation.ask([&](Random& random) { return finds(test(rates.draw(n, random))); }));
      });
    }
  }
  for (const Differences& differences : world.differences) {
    printSizes(kSizes, "paired difference, t", differences.name + ", mean moved to 0", [&](int n) {
      return errorCell(simulation.ask([&](Random& random) {
        std::vector<double> samples = drawn(differences.draw, n, random);
        for (double& sample : samples) {
          sample -= differences.mean;
        }
        return finds(meanDifference(samples).p);
      }));
    });
  }
  std::map<int, std::array<Proportion, 3>> families;
  for (const int n : kSizes) {
    families[n] = simulation.ask<3>([n](Random& random) { return family(n, random); });
  }
  const std::array names = {"t, not corrected", "t, Holm", "t, Bonferroni's intervals"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    printSizes(kSizes, names.at(i), "20 rows as good as the baseline",
               [&](int n) { return errorCell(families[n].at(i)); });
  }
}

/// At the share that the engine just keeps: which of the two verdicts is given.
Answers<2> watchTransfer(const Rates& rates, Random& random) {
  TransferBet bet(rates.second() / rates.first());
  for (int i = 0; i < kLooks && bet.verdict() == Verdict::kUndecided; ++i) {
    const auto [reference, engine] = rates.draw(random);
    bet.add(reference, engine);
  }
  return {bet.verdict() == Verdict::kKeeps, bet.verdict() == Verdict::kDoesNot};
}

/// Whether the truth is outside of any of the intervals at a few looks.
bool leavesSequence(const Rates& rates, Random& random) {
  PairTable table;
  for (const int look : {10, 20, 50, 100, 200, 500, 1000, kLooks}) {
    while (table.pairs() < look) {
      const auto [reference, engine] = rates.draw(random);
      table.add(reference, engine);
    }
    if (!*holds(transferSequence(table), rates.second() / rates.first())) {
      return true;
    }
  }
  return false;
}

bool watchAnyDifference(const Rates& rates, Random& random) {
  AnyDifference test;
  for (int i = 0; i < kLooks && !test.differ(); ++i) {
    const auto [first, second] = rates.draw(random);
    test.add(first, second);
  }
  return test.differ();
}

bool watchDifference(const Differences& differences, Random& random) {
  DifferenceSequence sequence;
  for (int i = 0; i < kLooks && sequence.sign() == Sign::kUndecided; ++i) {
    sequence.add(differences.draw(random) - differences.mean);
  }
  return sequence.sign() != Sign::kUndecided;
}

/// Test for one look, used after each episode: what not to do.
bool watchMidP(const Rates& rates, Random& random) {
  PairTable table;
  while (table.pairs() < kLooks) {
    const auto [first, second] = rates.draw(random);
    table.add(first, second);
    if (first != second && mcnemarMidP(table) <= kErrorRate) {
      return true;
    }
  }
  return false;
}

void watching(Simulation& simulation, const World& world) {
  printHead("Share of runs with a wrong verdict [%], looked at after each of 2 000 episodes, at most 5",
            {"verdict", "population", "wrong"});
  for (const Rates& rates : world.rates) {
    if (rates.second() <= rates.first() && rates.second() > 0.0) {
      const auto shares = simulation.ask<2>([&](Random& random) { return watchTransfer(rates, random); });
      const std::string share = fixedText(rates.second() / rates.first(), 3);
      printRow({"keeps more than " + share, rates.name + ", just that", boundCell(shares[0])});
      printRow({"keeps less than " + share, rates.name + ", just that", boundCell(shares[1])});
    }
  }
  for (const Rates& rates : world.rates) {
    if (rates.first() == 0.0) {
      continue;
    }
    printRow({"transfer is outside of its sequence, 8 looks", rates.name,
              boundCell(simulation.ask([&](Random& random) { return std::optional(leavesSequence(rates, random)); }))});
  }
  for (const double discordant : {0.27, 0.55, 1.0}) {
    const Rates rates = equallyGood(discordant);
    printRow({"any difference", rates.name, boundCell(simulation.ask([&](Random& random) {
                return std::optional(watchAnyDifference(rates, random));
              }))});
  }
  for (const Differences& differences : world.differences) {
    printRow({"sign of the mean difference", differences.name + ", mean moved to 0",
              boundCell(simulation.ask(
                  [&](Random& random) { return std::optional(watchDifference(differences, random)); }))});
  }
  for (const double discordant : {0.27, 0.55}) {
    const Rates rates = equallyGood(discordant);
    printRow({"McNemar mid-p, which is not for watching", rates.name,
              boundCell(simulation.ask([&](Random& random) { return std::optional(watchMidP(rates, random)); }))});
  }
}

void study(int repetitions, std::uint64_t seed, const std::string& episodes) {
  World world = shippedPolicy();
  if (!episodes.empty()) {
    addFile(episodes, world);
  }
  Simulation simulation(repetitions, seed);
  std::cout << repetitions << " repetitions, seed " << seed
            << ". Each figure has its standard error. Bold: worse than nominal by more than two standard errors. In "
               "brackets: better by more than two.\n";
  intervals(simulation, world);
  tests(simulation, world);
  watching(simulation, world);
  tails(simulation);
  // Whole tables of episodes take longer.
  Simulation of_crossed(std::max(1, repetitions / 2), seed);
  crossed(of_crossed);
  Simulation of_rankings(std::max(1, repetitions / 8), seed);
  rankings(of_rankings);
  Simulation of_equivalents(repetitions, seed);
  equivalents(of_equivalents);
  Simulation of_repeats(std::max(1, repetitions / 2), seed);
  repeats(of_repeats);
  Simulation of_transfers(std::max(1, repetitions / 2), seed);
  transferDifferences(of_transfers);
}

// Exit codes of the suite's commands (docs/faults.md).
constexpr int kInvalidInput = 2;
constexpr int kRuntimeFault = 4;
constexpr int kInternalError = 70;

int run(int argc, char** argv) {
  CLI::App app("Shows by simulation how often the intervals and tests are right; prints Markdown.", "coverage");
  int repetitions = 4000;
  std::uint64_t seed = 0;
  std::string episodes;
  app.add_option("--repetitions", repetitions, "of each experiment")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--seed", seed, "of the random numbers")->capture_default_str();
  app.add_option("--episodes", episodes, "episodes.csv of a run, whose episodes are one more population");
  try {
    app.parse(argc, argv);
    study(repetitions, seed, episodes);
    return 0;
  } catch (const CLI::Success& request) {  // --help
    return app.exit(request);
  } catch (const CLI::ParseError& error) {
    std::cerr << "coverage: " << error.what() << "\n";
    return kInvalidInput;
  } catch (const std::domain_error& refusal) {
    std::cerr << "coverage: " << refusal.what() << "\n";
    return kInvalidInput;
  } catch (const std::bad_alloc& failure) {
    std::cerr << "coverage: " << failure.what() << "\n";
    return kRuntimeFault;
  } catch (const std::exception& failure) {
    std::cerr << "coverage: " << failure.what() << "\n";
    return kInternalError;
  }
}

}  // namespace
}  // namespace sim2sim

int main(int argc, char** argv) { return sim2sim::run(argc, argv); }
