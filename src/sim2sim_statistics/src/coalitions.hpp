// SPDX-License-Identifier: BSD-3-Clause
/// Coalitions as sets, and the rules of games.
#pragma once

#include <bitset>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <cstddef>
#include <vector>

#include "sim2sim_statistics/common.hpp"
#include "sim2sim_statistics/cooperative_game.hpp"

namespace sim2sim {

/// Random numbers of Boost, which are the same with every standard library.
using Random = boost::random::mt19937;
using UniformIndex = boost::random::uniform_int_distribution<std::size_t>;

constexpr Coalition kNone = 0;

inline Coalition only(int player) { return Coalition{1} << player; }

inline bool isOn(Coalition on, int player) { return (on & only(player)) != 0; }

inline std::size_t sizeOf(Coalition on) { return std::bitset<kMostSampledPlayers>(on).count(); }

/// Throws std::domain_error unless there are from 1 to `most` players.
void requirePlayers(int players, int most);

/// Throws std::domain_error unless `gaps` of `coalition` are finite and as many as there are episodes, at least one.
void requireGaps(Coalition coalition, const std::vector<double>& gaps, std::size_t episodes);

/// Number of players in `orders`. Throws std::domain_error unless there is an order, and each has every player once.
int requireOrders(const std::vector<Order>& orders);

}  // namespace sim2sim
