// SPDX-License-Identifier: BSD-3-Clause
/// Two engines, or two settings of one, over the same episodes of the same reference: what differs, pair by pair.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/pairs.hpp"
#include "sim2sim_statistics/sequential.hpp"

namespace sim2sim {

/// The results of a run, or of a row of a sweep, as its folder has them.
struct RunResults {
  std::filesystem::path folder;
  nlohmann::json metrics;
  Protocol protocol;
  std::vector<EpisodeResult> episodes;

  /// What tells it from others, for people: "two-mass engine, block_damp 20.0".
  std::string title() const;

  /// The engine in `metrics`: its name, title, parameters, and the names of those that are changed.
  const nlohmann::json& engine() const;
};

/// Throws InvalidInput, naming the file, if `folder` does not hold the results of a whole run.
RunResults readResults(const std::filesystem::path& folder);

/// The folders of all rows of a sweep, in order; `folder` itself if it is a run. Throws InvalidInput if it is neither.
std::vector<std::filesystem::path> runsIn(const std::filesystem::path& folder);

/// One figure of two runs: the mean over episodes of the difference, other - baseline.
struct ContrastRow {
  std::string name;  ///< of the mean in metrics.json, without its unit
  std::string unit;
  int episodes;  ///< that have the figure in both
  Difference difference;
  std::optional<double> adjusted_p{};  ///< after Holm, over the whole family
  /// [episodes] after which the sign was decided, if watched after each of them; DifferenceSequence. None: not yet.
  std::optional<int> decided_after{};
};

struct Contrast {
  std::string title;                   ///< of the other, by what tells it from the rest
  PairTable successes;                 ///< of the engine; first: the baseline
  std::optional<Interval> interval{};  ///< of the difference of the rates, Tango's
  double p;                            ///< McNemar's, mid-p
  double adjusted_p{};                 ///< after Holm, over the whole family
  std::optional<int> decided_after{};  ///< as in ContrastRow; AnyDifference
  std::vector<int> lost{};             ///< episodes in which only the baseline succeeds
  std::vector<int> gained{};           ///< episodes in which only the other succeeds
  std::vector<ContrastRow> rows{};
};

/// Throws InvalidInput if two runs do not pair: policy, starts, horizon, probes, reference, or what the reference did
/// are not the same.
void requirePairs(const RunResults& baseline, const RunResults& other);

/// Each of `others` against `baseline`. The p-values of all figures of all contrasts are one family. Throws as
/// requirePairs().
std::vector<Contrast> contrast(const RunResults& baseline, const std::vector<RunResults>& others);

/// `contrasts` are those of `others`, in order. With the answer of all, and a sentence for each.
nlohmann::json toJson(const RunResults& baseline, const std::vector<RunResults>& others,
                      const std::vector<Contrast>& contrasts);

/// Table of all figures for the terminal, below the answer in words.
std::string table(const RunResults& baseline, const std::vector<RunResults>& others,
                  const std::vector<Contrast>& contrasts);

}  // namespace sim2sim
