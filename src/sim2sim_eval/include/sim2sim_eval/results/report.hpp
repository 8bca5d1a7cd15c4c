// SPDX-License-Identifier: BSD-3-Clause
/// What a run says: its metrics, its rows, its table.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim2sim_eval/protocol/protocol.hpp"
#include "sim2sim_eval/results/run_configuration.hpp"
#include "sim2sim_eval/results/statistics.hpp"

namespace sim2sim {

struct SuccessRate {
  int successes;
  double rate;
  Interval interval;
};

struct Summary {
  int episodes;
  SuccessRate reference;
  SuccessRate engine;
  std::optional<double> transfer;  ///< engine over reference success; none if the reference never succeeds
  std::array<std::array<Mean, kQuantities.size()>, kModeCount> means;  ///< over episodes; NaN where there is none

  const Mean& mean(Mode mode, std::string_view quantity) const { return means[mode][quantityIndex(quantity)]; }
};

/// The name in metrics.json of the mean of a quantity in a mode: "mean_pos_divergence" as the course has it, or
/// "engine_closed_final_angle_error". The key is NAME_UNIT, that of the interval NAME_interval_UNIT.
std::string metricName(Mode mode, const Quantity& quantity);

/// Of at least one episode, in index order.
Summary summarize(const std::vector<EpisodeResult>& episodes);

/// metrics.json: the course's keys and ours, rounded to six decimals; keys `mj_...` only where MuJoCo is the reference.
/// `summary` is that of the whole run.
nlohmann::json metrics(const RunConfiguration& configuration, const Summary& summary);

/// Says that the policy looks untrained or stale, if it does; else empty. The course's guard: for checkpoints, which
/// `provenance`, as in provenance.json, knows by a SHA-256; not for scripts or what somebody's own node runs.
std::string doubtAboutPolicy(const nlohmann::json& metrics, const nlohmann::json& provenance);

/// The text of a JSON file: sorted keys, indent 2, ASCII.
std::string jsonText(const nlohmann::json& json);

/// episodes.csv: one row per episode and mode, reals in shortest round-trip form.
std::string episodesCsv(const std::vector<EpisodeResult>& episodes);

/// The episodes that episodesCsv() has written. Throws InvalidInput, naming the line, if the text is anything else.
std::vector<EpisodeResult> episodesFromCsv(const std::string& text);

/// "0.0817 m [0.0700, 0.0934]", "11  0.220 [0.128, 0.352]": figures with their intervals, for people.
std::string cell(const SuccessRate& rate);
std::string cell(const Mean& mean, const std::string& unit);

/// The mean divergences of the replay, one cell after the other.
std::string divergences(const Summary& summary, const std::string& separator);

/// The figures of a run for people.
std::string table(const RunConfiguration& configuration, const Summary& summary);

}  // namespace sim2sim
