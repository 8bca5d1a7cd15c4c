// SPDX-License-Identifier: BSD-3-Clause
/// How many episodes a question takes: with 80 % power, tested at 5 % on both sides.
#pragma once

#include <optional>

namespace sim2sim {

constexpr double kPower = 0.8;          ///< how often a difference that is there must be found
constexpr int kMostEpisodes = 100'000;  ///< of a plan for rates, and of an answer

/// The smallest mean of paired differences that Student's t finds in `episodes` pairs, in the unit of their standard
/// deviation. At least kFewestPairs episodes.
/// Source: the normal approximation, (z_0.975 + z_0.8) s / sqrt(n). The t test itself finds it in 75.7 % of cases with
/// 20 pairs, in 78.4 % with 50, in 79.6 % with 200.
double smallestDifference(double standard_deviation, int episodes);

/// How many episodes it takes to find that mean difference, at least kFewestPairs; none if more than kMostEpisodes.
std::optional<int> episodesFor(double standard_deviation, double difference);

/// How often McNemar's mid-p test finds that two success rates differ, if they differ by `difference` and in a share
/// `discordant` of all pairs only one succeeds. 0 <= difference <= discordant <= 1.
/// Source: summed over all outcomes, as in S. W. Duffy, "Asymptotic and Exact Power for the McNemar Test and its
/// Analogue with R Controls per Case" (Biometrics, 1984).
double mcnemarPower(double discordant, double difference, int episodes);

/// The smallest difference of success rates that McNemar's mid-p test finds in `episodes` pairs, if in a share
/// `discordant` in (0, 1] of them only one succeeds; none if it finds not even the largest possible, `discordant`.
std::optional<double> smallestRateDifference(double discordant, int episodes);

/// How many episodes it takes to find that difference of success rates, in (0, discordant]; none if more than
/// kMostEpisodes. One episode fewer is not enough.
std::optional<int> episodesForRates(double discordant, double difference);

}  // namespace sim2sim
