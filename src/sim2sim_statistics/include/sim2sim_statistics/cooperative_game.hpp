// SPDX-License-Identifier: BSD-3-Clause
/// Cooperative games: each set of players that are switched on (a coalition) leaves a gap. The players may be the
/// switches of a simulator, and the gap its distance from another one. All coalitions play the same episodes. Gaps are
/// in any unit. All functions throw std::domain_error, with value and rule, for input that breaks the rules given.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace sim2sim {

using Coalition = std::uint32_t;  ///< set of players: bit i is 1 if player i is on
using Order = std::vector<int>;   ///< every player once, in the order in which they are switched on

/// Largest number of players of a game with all its coalitions, whose number doubles with each player.
constexpr int kMostPlayers = 16;
/// Largest number of players of a game with some of its coalitions.
constexpr int kMostSampledPlayers = std::numeric_limits<Coalition>::digits;

/// A game with all its coalitions: the gap of each in every episode.
class Game {
 public:
  /// `gaps` are by coalition, 2^players of them, and by episode, at least one; all finite. From 1 to kMostPlayers
  /// players.
  Game(int players, const std::vector<std::vector<double>>& gaps);

  int players() const { return players_; }
  int episodes() const { return episodes_; }
  Coalition all() const { return (Coalition{1} << players_) - 1; }
  double gap(Coalition on, int episode) const { return gaps_[(static_cast<std::size_t>(episode) << players_) | on]; }
  /// Mean gap over the episodes, summed in order.
  double meanGap(Coalition on) const { return mean_gaps_[on]; }

 private:
  int players_;
  int episodes_ = 0;
  std::vector<double> gaps_;  ///< by episode and coalition
  std::vector<double> mean_gaps_;
};

/// Mean gaps along an order, from none on to all on.
std::vector<double> staircase(const Game& game, const Order& order);

/// Order whose staircase has the least area. Among orders that are equal to within kSame, the player of the lower index
/// goes first. The order is the best in these episodes, so its staircase is too optimistic for others.
Order bestOrder(const Game& game);

/// Draws `count` >= 1 random orders of 1 to kMostSampledPlayers players, independent and uniform. They are the same
/// with every compiler and library, and those of a smaller count begin those of a larger one. Source: R. A. Fisher and
/// F. Yates, "Statistical Tables" (1938); R. Durstenfeld, "Algorithm 235" (1964).
std::vector<Order> drawOrders(int players, int count, std::uint32_t seed);

/// Random orders to draw, for games with too many players for all coalitions.
struct OrderSample {
  std::vector<std::string> players;
  int orders = 0;
  std::uint32_t seed = 0;

  std::vector<Order> draw() const { return drawOrders(static_cast<int>(players.size()), orders, seed); }
};

/// Coalitions along these orders and along their reverses, each once, rising.
std::vector<Coalition> coalitionsAlong(const std::vector<Order>& orders);

}  // namespace sim2sim
