// SPDX-License-Identifier: BSD-3-Clause
/// metrics.json: the figures of a whole run, under the course's keys and ours.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/sequential.hpp"

namespace sim2sim {

/// Name of a quantity's mean in a rollout: "mean_pos_divergence" as in the course, or
/// "engine_closed_final_angle_error". The mean's key is NAME_UNIT, that of its interval NAME_interval_UNIT.
std::string metricName(const std::string& rollout, const Quantity& quantity);

/// Content of metrics.json. With repeats it has the number of starts and the split variances besides. Figures are
/// rounded as readable() says, success rates and the course's means to six decimals, p-values not at all. Keys `mj_...`
/// appear only if MuJoCo is the reference.
nlohmann::json metrics(const RunConfiguration& configuration, const Summary& summary);

/// Mean of a quantity in a rollout as metrics.json has it: the course rounds its own to six decimals.
Estimate printedMean(const Summary& summary, std::size_t rollout, std::size_t quantity);

/// "decision" in metrics.json, for a run that ends when it is decided whether the engine keeps `share` of the
/// reference's success. "holds_when_stopped" names the intervals that hold whenever the run stops; the others are null.
nlohmann::json decision(const TransferBet& bet, double share);

/// Warning that the policy looks untrained or stale, because it never succeeds in the reference; empty otherwise. Only
/// checkpoints are judged: policies with a SHA-256 in `provenance`, the content of provenance.json. The course has the
/// same guard.
std::string doubtAboutPolicy(const nlohmann::json& metrics, const nlohmann::json& provenance,
                             const Endings& reference = {});

/// Note beside the figures of a policy that draws random numbers (the key `noise` of the policy in `provenance`), if
/// each start was played once; empty otherwise, and where a loop has noise of its own, which the simulators' parameters
/// say.
std::string noteOnNoise(const RunConfiguration& configuration, const nlohmann::json& provenance);

}  // namespace sim2sim
