// SPDX-License-Identifier: BSD-3-Clause
/// Agreement of two simulators on which of two policies is the better one. Private to the rankings.
#pragma once

#include "rank_figures.hpp"
#include "sim2sim_statistics/ranking.hpp"

namespace sim2sim {

/// Agreement of the pairs whose rates in the reference differ by at least `from` and less than `to`.
PairAgreement agreementOf(const PolicyRates& rates, double from, double to);

}  // namespace sim2sim
