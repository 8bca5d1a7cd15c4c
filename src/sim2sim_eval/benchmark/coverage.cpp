// SPDX-License-Identifier: BSD-3-Clause
// Coverage of intervals and error rates of tests, on simulated episodes whose truth is known. docs/statistics.md has
// its output.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <iostream>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "known_truths.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/pairs.hpp"
#include "sim2sim_statistics/sequential.hpp"
#include "simulation.hpp"

namespace sim2sim {
namespace {

constexpr int kLooks = 2000;  ///< after each of so many episodes
const std::vector<int> kSizes = {10, 20, 50, 500};

// ---- What is printed

/// Which side of the nominal share is to be marked: `kWorse` is all for a test that promises no more than a bound.
enum class Marks { kBoth, kWorse };

/// Share in percent, with its standard error. Bold if it is worse than nominal by more than two standard errors, in
/// brackets if it is better.
std::string cell(const Proportion& share, double nominal, bool more_is_worse, Marks marks) {
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

std::string coverageCell(const Proportion& share) { return cell(share, kConfidence, false, Marks::kBoth); }
std::string errorCell(const Proportion& share) { return cell(share, kErrorRate, true, Marks::kBoth); }
std::string boundCell(const Proportion& share) { return cell(share, kErrorRate, true, Marks::kWorse); }

void printRow(const std::vector<std::string>& cells) {
  std::cout << "|";
  for (const std::string& text : cells) {
    std::cout << " " << text << " |";
  }
  std::cout << "\n" << std::flush;
}

void printHead(const std::string& title, std::vector<std::string> columns) {
  std::cout << "\n" << title << "\n\n";
  printRow(columns);
  std::fill(columns.begin(), columns.end(), "---");
  printRow(columns);
}

std::vector<std::string> withSizes(std::vector<std::string> columns) {
  for (const int n : kSizes) {
    columns.push_back("n = " + std::to_string(n));
  }
  return columns;
}

/// A row with a cell for each number of episodes.
void printSizes(const std::string& what, const std::string& of, const std::function<std::string(int)>& cell_of) {
  std::vector<std::string> cells = {what, of};
  std::transform(kSizes.begin(), kSizes.end(), std::back_inserter(cells), cell_of);
  printRow(cells);
}

std::optional<bool> holds(const std::optional<Interval>& interval, double truth) {
  return interval ? std::optional(interval->low <= truth && truth <= interval->high) : std::nullopt;
}

/// The interval of so many episodes.
using MakeInterval = std::function<std::optional<Interval>(int, Random&)>;

void printCoverage(Simulation& simulation, const std::string& what, const std::string& of, double truth,
                   const MakeInterval& make) {
  printSizes(what, of, [&](int n) {
    return coverageCell(simulation.ask([&](Random& random) { return holds(make(n, random), truth); }));
  });
}

void intervals(Simulation& simulation, const World& world) {
  printHead("Share of repetitions in which the interval holds the truth [%], nominal 95",
            withSizes({"interval", "population"}));
  for (const Rates& rates : world.rates) {
    printCoverage(simulation, "Wilson", rates.name, rates.second(), [&](int n, Random& random) {
      const PairTable table = rates.draw(n, random);
      return wilsonInterval(table.both + table.second_only, n);
    });
  }
  for (const Population& population : world.populations) {
    printCoverage(simulation, "mean, log-t", population.name, population.mean, [&](int n, Random& random) {
      return meanOf(drawn(population.draw, n, random), population.limit).interval;
    });
  }
  for (const Population& population : world.populations) {
    printCoverage(simulation, "median, order statistics", population.name, population.median,
                  [&](int n, Random& random) { return medianOf(drawn(population.draw, n, random)).interval; });
  }
  for (const Rates& rates : world.rates) {
    printCoverage(simulation, "difference of rates, Tango", rates.name, rates.second() - rates.first(),
                  [&](int n, Random& random) { return tangoInterval(rates.draw(n, random)); });
  }
  for (const Rates& rates : world.rates) {
    printCoverage(simulation, "transfer, Tang", rates.name, rates.second() / rates.first(),
                  [&](int n, Random& random) { return tangInterval(rates.draw(n, random)); });
  }
  for (const Differences& differences : world.differences) {
    printCoverage(simulation, "paired difference, t", differences.name, differences.mean,
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
  return {"discordant " + pusht::fixedText(discordant, 2), 0.0, 0.5 * discordant, 0.5 * discordant};
}

void tests(Simulation& simulation, const World& world) {
  printHead("Share of repetitions in which a test finds a difference that is not there [%], nominal 5",
            withSizes({"test", "population"}));
  for (const auto& [name, test] :
       {std::pair("McNemar mid-p", &mcnemarMidP), std::pair("McNemar exact", &mcnemarExact)}) {
    for (const double discordant : {0.27, 0.55, 1.0}) {
      const Rates rates = equallyGood(discordant);
      printSizes(name, rates.name, [&, test = test](int n) {
        return errorCell(simulation.ask([&](Random& random) { return finds(test(rates.draw(n, random))); }));
      });
    }
  }
  for (const Differences& differences : world.differences) {
    printSizes("paired difference, t", differences.name + ", mean moved to 0", [&](int n) {
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
    printSizes(names.at(i), "20 rows as good as the baseline", [&](int n) { return errorCell(families[n].at(i)); });
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
      const std::string share = pusht::fixedText(rates.second() / rates.first(), 3);
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
}

}  // namespace
}  // namespace sim2sim

int main(int argc, char** argv) {
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
    sim2sim::study(repetitions, seed, episodes);
  } catch (const CLI::Success& request) {  // --help
    return app.exit(request);
  } catch (const CLI::ParseError& error) {
    std::cerr << "coverage: " << error.what() << "\n";
    return static_cast<int>(pusht::ExitCode::kInvalidInput);
  } catch (const std::exception& failure) {
    std::cerr << "coverage: " << failure.what() << "\n";
    return static_cast<int>(pusht::exitCodeOf(failure));
  }
}
