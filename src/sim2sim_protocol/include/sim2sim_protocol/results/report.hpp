// SPDX-License-Identifier: BSD-3-Clause
/// What a run says: its metrics, its rows, its table.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_statistics/sequential.hpp"

namespace sim2sim {

/// The name in metrics.json of the mean of a quantity in a rollout: "mean_pos_divergence" as the course has it, or
/// "engine_closed_final_angle_error". The key is NAME_UNIT, that of the interval NAME_interval_UNIT.
std::string metricName(const std::string& rollout, const Quantity& quantity);

/// metrics.json: the course's keys and ours, rounded to six decimals; keys `mj_...` only where MuJoCo is the reference.
/// `summary` is that of the whole run.
nlohmann::json metrics(const RunConfiguration& configuration, const Summary& summary);

/// The interval of the transfer that holds: Tang's, or transferSequence() in a run that ends when it is decided.
std::optional<Interval> transferInterval(const RunConfiguration& configuration, const Outcomes& outcomes);

/// What a run that ends when it is decided says of `share`: for metrics.json, and for people. The intervals of the
/// other figures are those of a run of fixed length: they hold less often where a run was stopped by what it found.
/// "holds_when_stopped" names those that do hold.
nlohmann::json decision(const TransferBet& bet, double share);
std::string decisionText(const TransferBet& bet, double share);

/// Says that the policy looks untrained or stale, if it does; else empty. The course's guard: for checkpoints, which
/// `provenance`, as in provenance.json, knows by a SHA-256; not for scripts or what somebody's own node runs.
std::string doubtAboutPolicy(const nlohmann::json& metrics, const nlohmann::json& provenance);

/// The text of a JSON file: sorted keys, indent 2, ASCII.
std::string jsonText(const nlohmann::json& json);

/// episodes.csv: one row per episode and rollout of the protocol, reals in shortest round-trip form.
std::string episodesCsv(const Protocol& protocol, const std::vector<EpisodeResult>& episodes);

/// The episodes that episodesCsv() has written. Throws InvalidInput, naming the line, if the text is anything else.
std::vector<EpisodeResult> episodesFromCsv(const Protocol& protocol, const std::string& text);

/// statistics.json: the headline; and of every quantity in every rollout the number of episodes that have it, mean,
/// standard deviation, median and quantiles.
nlohmann::json statistics(const RunConfiguration& configuration, const std::vector<EpisodeResult>& episodes);

/// "0.0817 m [0.0700, 0.0934]", "11  0.220 [0.128, 0.352]": figures with their intervals, for people.
std::string cell(const SuccessRate& rate);
std::string cell(const Estimate& estimate, const std::string& unit);

/// "0.220 [0.128, 0.352]": a rate without its count.
std::string shareText(const SuccessRate& rate);

/// "37 % [21 %, 61 %]": the transfer with the interval that holds, in the digits of transferNumber(). In words where
/// the reference never succeeds.
std::string transferText(const RunConfiguration& configuration, const Outcomes& outcomes);

/// The mean of a quantity in a rollout as metrics.json has it: the course rounds its own to six decimals.
Estimate printedMean(const Summary& summary, std::size_t rollout, std::size_t quantity);

/// The mark of a mean divergence of the replay, as in text.hpp; empty for other quantities.
std::string markOf(const Summary& summary, std::string_view divergence);

/// markOf() with a blank before it, to stand behind the figure; empty if there is no mark.
std::string doubtMark(const Summary& summary, std::string_view divergence);

/// The mean divergences of the replay, one cell after the other.
std::string divergences(const Summary& summary, const std::string& separator);

/// The headline and the figures of a run for people.
std::string table(const RunConfiguration& configuration, const Summary& summary);

}  // namespace sim2sim
