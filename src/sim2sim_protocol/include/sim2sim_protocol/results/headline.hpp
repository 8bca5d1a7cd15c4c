// SPDX-License-Identifier: BSD-3-Clause
/// Headline of a run: does the skill transfer? Question and answer are one sentence each. Terminal, statistics.json,
/// messages, panel, picture and page all show this text.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

/// Bounds of the scale of words [share of the reference's success]. Between kNotEnough and kWhole the skill transfers
/// in part.
constexpr double kMore = 1.1;       ///< an interval beyond: more success, so the two are not alike
constexpr double kWhole = 0.9;      ///< an interval from here on up: it transfers
constexpr double kNotEnough = 0.5;  ///< an interval up to here: it does not transfer

/// Verdict on the interval [low, high] of the transfer.
enum class TransferVerdict {
  kExceeds,            ///< kMore < low
  kTransfers,          ///< kWhole <= low <= kMore
  kTransfersInPart,    ///< kNotEnough <= low, high < kWhole
  kAtMostInPart,       ///< low < kNotEnough < high < kWhole
  kDoesNotTransfer,    ///< high <= kNotEnough
  kCannotSay,          ///< low < kWhole <= high, or fewer than kFewestEpisodes
  kNothingToTransfer,  ///< the reference never succeeds
  kNotAsked            ///< there is no engine
};

/// Name in files: "exceeds", "transfers", "transfers_in_part", "at_most_in_part", "does_not_transfer", "cannot_say",
/// "nothing_to_transfer", "not_asked".
std::string nameOf(TransferVerdict verdict);

/// Verdict on an interval of the transfer. kNothingToTransfer and kNotAsked are not among its results.
TransferVerdict verdictOf(const Interval& transfer);

/// Interval of the transfer that holds: that of its outcomes, or transferSequence() if the run ends when it is decided.
/// Empty if there is none.
std::optional<Interval> transferInterval(const Protocol& protocol, const Outcomes& outcomes);

/// Share of the reference's success in percent: "31". It gets more digits if it would otherwise be printed on the other
/// side of a bound of the scale, or of the share that decides the end of the run: 0.4996 is "49.96", not "50".
std::string transferNumber(const RunConfiguration& configuration, double share);

/// Question and answer, for the policy and the simulators of a run. Both simulators are named with what is changed of
/// them, and with the loop, unless it is plain.
struct Headline {
  TransferVerdict verdict = TransferVerdict::kCannotSay;
  std::string question;
  std::string caveat;  ///< what to know before the answer: most failures of a role are stuck; empty: nothing
  std::string answer;

  /// Question and answer in one line.
  std::string text() const { return question + " " + answer; }
};

/// Headline of the finished episodes of a run, by the successes of the engine in closed loop. The verdict is on
/// transferInterval().
Headline headlineOf(const RunConfiguration& configuration, const Outcomes& outcomes, const EndingsOfPairs& endings);

/// Headline as JSON: "headline" in statistics.json.
nlohmann::json toJson(const Headline& headline);

/// Title of a simulator for use within a sentence: "the two-mass engine", "Chipmunk". Parameters may follow the title.
std::string inSentence(const std::string& title);

}  // namespace sim2sim
