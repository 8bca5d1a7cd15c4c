// SPDX-License-Identifier: BSD-3-Clause
#include "ranking_coverage.hpp"

#include <array>
#include <boost/math/constants/constants.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "coverage_tables.hpp"
#include "known_truths.hpp"
#include "sim2sim_statistics/crossed.hpp"
#include "sim2sim_statistics/ranking.hpp"

namespace sim2sim {
namespace {

/// Policies and initial states (starts) of a run.
struct Shape {
  std::size_t policies;
  std::size_t starts;
};

constexpr std::array kShapes = {Shape{8, 200},  Shape{8, 1000},  Shape{12, 200}, Shape{12, 1000},
                                Shape{20, 200}, Shape{20, 1000}, Shape{40, 200}, Shape{40, 1000}};

/// Population of policies, in two simulators. An episode succeeds where skill + difficulty of the start + chance is
/// above 0, the latter two standard normal; the starts' difficulties in the two simulators correlate by 0.5.
struct Skills {
  std::string name;
  double deviation;    ///< of the true success rates, roughly
  double correlation;  ///< of the skills in the two simulators
  double shared;       ///< correlation of chance in the two simulators: what a policy meets at a start in both
  bool two_kinds;      ///< policies are good or bad, with a normal rest that makes 30 % of the variance
};

constexpr double kHalf = 0.5;
constexpr double kOfKinds = 0.7;  ///< part of the variance between the two kinds

std::array<double, 2> correlated(double correlation, Random& random) {
  const double first = normal(random);
  return {first, correlation * first + std::sqrt(1.0 - correlation * correlation) * normal(random)};
}

/// Skills of one policy.
std::array<double, 2> skill(const Skills& skills, Random& random) {
  // Slope of the success rate at a skill of 0: density of the normal distribution, of difficulty and chance together.
  const double scale = skills.deviation * std::sqrt(2.0 * boost::math::constants::two_pi<double>());
  std::array<double, 2> values = correlated(skills.correlation, random);
  if (skills.two_kinds) {
    const double kind = uniform(random) < kHalf ? 1.0 : -1.0;
    const double other = uniform(random) < kHalf * (1.0 + skills.correlation) ? kind : -kind;
    values[0] = std::sqrt(kOfKinds) * kind + std::sqrt(1.0 - kOfKinds) * values[0];
    values[1] = std::sqrt(kOfKinds) * other + std::sqrt(1.0 - kOfKinds) * values[1];
  }
  return {scale * values[0], scale * values[1]};
}

/// Success rate over all starts.
double rateOf(double skill) { return cdf(boost::math::normal(), std::sqrt(kHalf) * skill); }

using Rows = std::vector<std::vector<double>>;

/// Successes in the reference and in the test.
std::array<CrossedTable, 2> episodes(const Skills& skills, const Shape& shape, Random& random) {
  constexpr double kDifficulties = 0.5;
  std::vector<std::array<double, 2>> difficulties;
  for (std::size_t start = 0; start < shape.starts; ++start) {
    difficulties.push_back(correlated(kDifficulties, random));
  }
  Rows reference(shape.policies, std::vector<double>(shape.starts));
  Rows test = reference;
  for (std::size_t policy = 0; policy < shape.policies; ++policy) {
    const std::array<double, 2> of_policy = skill(skills, random);
    for (std::size_t start = 0; start < shape.starts; ++start) {
      const std::array<double, 2> chance = correlated(skills.shared, random);
      reference[policy][start] = of_policy[0] + difficulties[start][0] + chance[0] > 0.0 ? 1.0 : 0.0;
      test[policy][start] = of_policy[1] + difficulties[start][1] + chance[1] > 0.0 ? 1.0 : 0.0;
    }
  }
  return {CrossedTable(reference), CrossedTable(test)};
}

/// Truths of a population; those of the rank violation and of the agreement depend on the shape.
struct Truth {
  double pearson;
  double spearman;
  double kendall;
  double violation;
  std::array<double, kAgreementBins.size()> agreement;
};

/// Share of the pairs that agree, by the difference in the reference: plain counting.
std::array<double, kAgreementBins.size()> agreementOf(const std::vector<double>& reference,
                                                      const std::vector<double>& test) {
  std::array<double, kAgreementBins.size()> pairs = {};
  std::array<double, kAgreementBins.size()> agreeing = {};
  for (std::size_t i = 0; i < reference.size(); ++i) {
    for (std::size_t j = 0; j < reference.size(); ++j) {
      const double difference = reference[i] - reference[j];
      if (difference > kSame) {
        std::size_t bin = kAgreementBins.size() - 1;
        while (difference < kAgreementBins.at(bin) - kSame) {
          --bin;
        }
        pairs.at(bin) += 1.0;
        agreeing.at(bin) += test[i] > test[j] ? 1.0 : test[i] == test[j] ? 0.5 : 0.0;
      }
    }
  }
  for (std::size_t bin = 0; bin < pairs.size(); ++bin) {
    agreeing.at(bin) /= pairs.at(bin);
  }
  return agreeing;
}

Random populationNumber(std::uint64_t seed) { return Random(seed); }

Truth truthOf(const Skills& skills, const Shape& shape) {
  constexpr std::size_t kPolicies = 2000;  // rank correlations take their square
  constexpr int kRuns = 10'000;            // of the violation
  constexpr std::size_t kMeasured = 1500;  // policies whose pairs are counted
  Random random = populationNumber(1);
  Truth truth = {};
  constexpr int kPopulations = 4;
  for (int i = 0; i < kPopulations; ++i) {
    std::vector<double> reference;
    std::vector<double> test;
    for (std::size_t policy = 0; policy < kPolicies; ++policy) {
      const std::array<double, 2> values = skill(skills, random);
      reference.push_back(rateOf(values[0]));
      test.push_back(rateOf(values[1]));
    }
    truth.pearson += pearson(reference, test) / kPopulations;
    truth.spearman += spearman(reference, test) / kPopulations;
    truth.kendall += kendallTauB(reference, test) / kPopulations;
  }
  for (int run = 0; run < kRuns; ++run) {
    std::vector<double> reference;
    std::vector<double> test;
    for (std::size_t policy = 0; policy < shape.policies; ++policy) {
      const std::array<double, 2> values = skill(skills, random);
      reference.push_back(rateOf(values[0]));
      test.push_back(rateOf(values[1]));
    }
    truth.violation += meanMaximumRankViolation(test, reference) / kRuns;
  }
  const auto [reference, test] = episodes(skills, {kMeasured, shape.starts}, random);
  truth.agreement = agreementOf(reference.rowMeans(), test.rowMeans());
  return truth;
}

constexpr std::size_t kFigures = 4 + kAgreementBins.size();
constexpr std::array<const char*, kFigures> kFigureNames = {"Pearson",
                                                            "Spearman",
                                                            "Kendall",
                                                            "rank violation",
                                                            "agreement, 0-0.05",
                                                            "agreement, 0.05-0.1",
                                                            "agreement, 0.1-0.2",
                                                            "agreement, 0.2-1"};

/// Coverage of each figure, whether a ranking is found, and whether there is an interval.
constexpr std::size_t kQuestions = kFigures + 2;

Answers<kQuestions> ask(const Skills& skills, const Shape& shape, const Truth& truth, Random& random) {
  const auto [reference, test] = episodes(skills, shape, random);
  const RankingComparison found = compareRankings(reference, test, static_cast<std::uint32_t>(random()));
  Answers<kQuestions> answers = {
      holds(found.pearson.interval, truth.pearson), holds(found.spearman.interval, truth.spearman),
      holds(found.kendall.interval, truth.kendall), holds(found.violation.interval, truth.violation)};
  for (std::size_t bin = 0; bin < truth.agreement.size(); ++bin) {
    answers.at(4 + bin) = holds(found.agreement.at(bin).share.interval, truth.agreement.at(bin));
  }
  answers.at(kFigures) = found.verdict != RankingVerdict::kCannotSay;
  answers.at(kFigures + 1) = found.kendall.interval.has_value();
  return answers;
}

std::vector<Skills> populations() {
  std::vector<Skills> all;
  for (const double correlation : {0.0, 0.5, 0.9}) {
    const std::string name = "correlation " + fixedText(correlation, 1);
    all.push_back({name + ", deviation 0.1", 0.1, correlation, 0.0, false});
    all.push_back({name + ", deviation 0.05, shared chance", 0.05, correlation, 0.6, false});
    all.push_back({name + ", deviation 0.1, two kinds", 0.1, correlation, 0.0, true});
  }
  all.push_back({"all policies alike", 0.0, 0.0, 0.0, false});
  all.push_back({"all policies alike, shared chance", 0.0, 0.0, 0.6, false});
  return all;
}

std::string percent(const Proportion& share) { return fixedText(100.0 * share.value(), 1); }

}  // namespace

void rankings(Simulation& simulation) {
  std::vector<std::string> columns = {"interval", "population"};
  for (const Shape& shape : kShapes) {
    columns.push_back(std::to_string(shape.policies) + " x " + std::to_string(shape.starts));
  }
  const std::vector<Skills> all = populations();
  std::vector<std::array<std::array<Proportion, kQuestions>, kShapes.size()>> shares(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < kShapes.size(); ++j) {
      const Truth truth = truthOf(all[i], kShapes.at(j));
      shares[i].at(j) =
          simulation.ask<kQuestions>([&](Random& random) { return ask(all[i], kShapes.at(j), truth, random); });
    }
  }
  printHead("Share of repetitions in which the interval between simulators holds the truth [%], nominal 95", columns);
  for (std::size_t figure = 0; figure < kFigures; ++figure) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (all[i].deviation > 0.0 || figure >= 4) {
        std::vector<std::string> cells = {kFigureNames.at(figure), all[i].name};
        for (const auto& of_shape : shares[i]) {
          cells.push_back(coverageCell(of_shape.at(figure)));
        }
        printRow(cells);
      }
    }
  }
  columns[0] = "answer";
  printHead("Share of repetitions [%]", columns);
  for (const auto& [question, name] : {std::pair(kFigures + 1, "has intervals"), std::pair(kFigures, "a verdict")}) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      std::vector<std::string> cells = {name, all[i].name};
      for (const auto& of_shape : shares[i]) {
        cells.push_back(percent(of_shape.at(question)));
      }
      printRow(cells);
    }
  }
}

}  // namespace sim2sim
