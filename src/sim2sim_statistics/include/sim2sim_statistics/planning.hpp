// SPDX-License-Identifier: BSD-3-Clause
/// Planning: number of episodes to find a difference with 80 % power, in a two-sided test at 5 %. Functions throw
/// std::domain_error, with value and rule, for input out of range.
#pragma once

#include <optional>

namespace sim2sim {

constexpr double kPower = 0.8;          ///< probability of finding a difference that is there
constexpr int kMostEpisodes = 100'000;  ///< largest number of episodes in plans and answers

/// Smallest mean of paired differences that Student's t finds in `episodes` >= kFewestPairs pairs, in the unit of
/// `standard_deviation`, which is that of the differences.
/// Source: normal approximation, (z_0.975 + z_0.8) s / sqrt(n). The t test itself finds it in 75.7 % of cases with
/// 20 pairs, in 78.4 % with 50, in 79.6 % with 200.
double smallestDifference(double standard_deviation, int episodes);

/// Number of episodes to find a mean difference, at least kFewestPairs; none if more than kMostEpisodes.
std::optional<int> episodesFor(double standard_deviation, double difference);

/// Power of McNemar's mid-p test: probability of finding that two success rates differ, if they differ by `difference`
/// and only one succeeds in a share `discordant` of all pairs. 0 <= difference <= discordant <= 1.
/// Source: summed over all outcomes, as in S. W. Duffy, "Asymptotic and Exact Power for the McNemar Test and its
/// Analogue with R Controls per Case" (Biometrics, 1984).
double mcnemarPower(double discordant, double difference, int episodes);

/// Smallest difference of success rates that McNemar's mid-p test finds in `episodes` pairs, if only one succeeds in a
/// share `discordant` in (0, 1] of them. None if it does not even find the largest possible one, `discordant`.
std::optional<double> smallestRateDifference(double discordant, int episodes);

/// Smallest number of episodes to find a difference of success rates, in (0, discordant]; none if more than
/// kMostEpisodes.
std::optional<int> episodesForRates(double discordant, double difference);

}  // namespace sim2sim
