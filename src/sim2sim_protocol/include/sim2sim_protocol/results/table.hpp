// SPDX-License-Identifier: BSD-3-Clause
/// Table of a run for people, and its cells.
#pragma once

#include <string>
#include <string_view>

#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/sequential.hpp"

namespace sim2sim {

/// Headline and figures of a run, in lines.
std::string table(const RunConfiguration& configuration, const Summary& summary);

/// decision() in words, above the table.
std::string decisionText(const TransferBet& bet, double share);

/// "37 % [21 %, 61 %]": transfer with the interval that holds, in the digits of transferNumber(). In words where the
/// reference never succeeds.
std::string transferText(const RunConfiguration& configuration, const Outcomes& outcomes);

/// "0.220 [0.128, 0.352]"
std::string shareText(const SuccessRate& rate);

/// "11  0.220 [0.128, 0.352]"
std::string cell(const SuccessRate& rate);

/// "0.0817 m [0.0700, 0.0934]"
std::string cell(const Estimate& estimate, const std::string& unit);

/// Mean divergences of the replay in open loop, one cell after the other.
std::string divergences(const Summary& summary, const std::string& separator);

/// Mark of a mean divergence of the replay, as in text.hpp; empty for other quantities.
std::string markOf(const Summary& summary, std::string_view divergence);

/// markOf() with a blank before it, to stand behind the figure; empty without a mark.
std::string doubtMark(const Summary& summary, std::string_view divergence);

}  // namespace sim2sim
