// SPDX-License-Identifier: BSD-3-Clause
/// Contrast of runs over the same episodes of the same reference: paired differences of a run from a baseline run. They
/// have one policy in other engines, or with other parameters of one; or other policies in one engine.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sim2sim_protocol/results/run_results.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/pairs.hpp"
#include "sim2sim_statistics/sequential.hpp"

namespace sim2sim {

/// Mean paired difference of one figure, other - baseline, in the figure's unit. Of success it is the difference of the
/// rates, with Tango's interval and McNemar's mid-p.
struct ContrastRow {
  std::string name;  ///< key of the mean in metrics.json, without its unit
  std::string unit;  ///< empty: success, transfer
  int episodes;      ///< number of episodes that have the figure in both runs
  Difference difference;
  std::optional<double> adjusted_p{};  ///< after Holm, over the whole family
  /// [episodes] after which the sign was decided, if watched after each of them; DifferenceSequence, of success
  /// AnyDifference. None: not yet, or few episodes carry the difference (isCarriedByFew()), for which that method is
  /// not made, or that is not known (Quantity::hasIntervals()).
  std::optional<int> decided_after{};

  bool isFinding() const { return adjusted_p && *adjusted_p <= 1.0 - kConfidence && difference.value != 0.0; }
};

/// Paired successes of two runs in one simulator.
struct SuccessChange {
  PairTable counts;           ///< first: the baseline
  std::vector<int> lost{};    ///< episodes in which only the baseline succeeds
  std::vector<int> gained{};  ///< episodes in which only the other succeeds
};

/// What two policies differ in, besides the engine's figures.
struct PolicyContrast {
  SuccessChange reference;
  Outcomes baseline;  ///< of each policy: its transfer
  Outcomes other;
};

/// All differences of one run from the baseline. With repeats they are by start (results/starts.hpp), and nothing is
/// watched episode by episode.
struct Contrast {
  std::string title;                         ///< name of the run among all that are compared
  std::string against;                       ///< of the baseline, likewise
  SuccessChange engine{};                    ///< successes in the engine
  std::optional<PolicyContrast> policies{};  ///< none of two engines
  std::vector<ContrastRow> rows{};           ///< success first; of policies in the reference, in the engine, transfer

  /// Whether there is a row of that name. Without an engine there is that of success in the reference alone.
  bool has(const std::string& name) const;

  /// Row of that name; there is one.
  const ContrastRow& row(const std::string& name) const;
};

/// Names of the rows of success and transfer.
inline constexpr const char* kReferenceSuccessRow = "reference_success_rate";
inline constexpr const char* kSuccessRow = "engine_success_rate";
inline constexpr const char* kTransferRow = "transfer";

/// Contrasts each of `others` with `baseline`. The p-values of all figures of all contrasts are one family for Holm's
/// correction. Throws as pairingOf(), and InvalidInput if some differ in the engine and others in the policy.
std::vector<Contrast> contrastsOf(const RunResults& baseline, const std::vector<RunResults>& others);

/// Content of the file of `contrast --out`: the answer about all runs, a sentence and the figures of each. `contrasts`
/// are those of `others`, in order.
nlohmann::json toJson(const RunResults& baseline, const std::vector<RunResults>& others,
                      const std::vector<Contrast>& contrasts);

/// Table of all figures for the terminal, below the answer in words.
std::string table(const RunResults& baseline, const std::vector<RunResults>& others,
                  const std::vector<Contrast>& contrasts);

}  // namespace sim2sim
