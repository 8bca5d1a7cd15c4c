// SPDX-License-Identifier: BSD-3-Clause
/// The question of a run and its answer in one sentence: does the skill transfer? Terminal, statistics.json, messages,
/// panel, picture and page all show this text.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/pairs.hpp"

namespace sim2sim {

/// Bounds of the scale of words, as shares of the reference's success. Between them the skill transfers in part.
constexpr double kWhole = 0.9;      ///< an interval from here on up: it transfers
constexpr double kMore = 1.1;       ///< an interval beyond: it transfers, and more
constexpr double kNotEnough = 0.5;  ///< an interval up to here: it does not transfer

/// Verdict on the interval [low, high] of the transfer.
enum class TransferVerdict {
  kTransfers,         ///< kWhole <= low
  kTransfersInPart,   ///< kNotEnough <= low, high < kWhole
  kAtMostInPart,      ///< low < kNotEnough < high < kWhole
  kDoesNotTransfer,   ///< high <= kNotEnough
  kCannotSay,         ///< low < kWhole <= high, or fewer than kFewestEpisodes
  kNothingToTransfer  ///< the reference never succeeds
};

/// "transfers", "transfers_in_part", "at_most_in_part", "does_not_transfer", "cannot_say", "nothing_to_transfer"
std::string nameOf(TransferVerdict verdict);

/// Verdict that follows from the interval of the transfer.
TransferVerdict verdictOf(const Interval& transfer);

/// A share of the reference's success in percent: "31". It has as many digits as it takes to be printed on its side of
/// each bound of the scale, and of the share that decides the end of the run: 0.4996 is "49.96", not "50".
std::string transferNumber(const RunConfiguration& configuration, double share);

/// Question of a run and its answer in a sentence.
struct Headline {
  TransferVerdict verdict = TransferVerdict::kCannotSay;
  std::string question;
  std::string answer;  ///< for the policy and the simulators of the run

  /// Question and answer in one line.
  std::string text() const { return question + " " + answer; }
};

/// The headline of the finished episodes of a run; `successes` has the reference first. The interval behind it is
/// Tang's, or transferSequence() in a run that ends when it is decided.
Headline headlineOf(const RunConfiguration& configuration, const PairTable& successes);

/// "headline" in statistics.json.
nlohmann::json toJson(const Headline& headline);

/// A simulator's title inside a sentence, perhaps with parameters behind it: "the two-mass engine", "Chipmunk".
std::string inSentence(const std::string& title);

}  // namespace sim2sim
