// SPDX-License-Identifier: BSD-3-Clause
/// A cooperative game: players switch on one after the other, and each set of players that are on has a gap that is
/// left. Here the players are the switches of a simulator, and the gap is its distance from another one.
/// A set of players is a coalition. All coalitions play the same episodes. Gaps are in any unit.
/// All functions throw std::domain_error, with value and rule, for input that breaks the rules given.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace sim2sim {

using Coalition = std::uint32_t;  ///< bit i is 1 if player i is on
using Order = std::vector<int>;   ///< every player once, in the order in which they are switched on

constexpr int kMostPlayers = 16;  ///< of a game with all its coalitions; their number doubles with each player
constexpr int kMostSampledPlayers = std::numeric_limits<Coalition>::digits;  ///< of a game with some of them

/// The gap of every coalition in every episode.
class Game {
 public:
  /// From 1 to kMostPlayers players; `gaps` by coalition, 2^players of them, and episode, at least one; all finite.
  Game(int players, const std::vector<std::vector<double>>& gaps);

  int players() const { return players_; }
  int episodes() const { return episodes_; }
  Coalition all() const { return (Coalition{1} << players_) - 1; }
  double gap(Coalition on, int episode) const { return gaps_[(static_cast<std::size_t>(episode) << players_) | on]; }
  /// Of the episodes, summed in order.
  double meanGap(Coalition on) const { return mean_gaps_[on]; }

 private:
  int players_;
  int episodes_ = 0;
  std::vector<double> gaps_;  ///< by episode and coalition
  std::vector<double> mean_gaps_;
};

/// The mean gaps along an order, from none on to all on.
std::vector<double> staircase(const Game& game, const Order& order);

/// The order whose staircase has the least area, over all orders; where steps to within kSame lead to the same, the
/// player of the lower index goes first. It is the best in these episodes, so its staircase flatters it in others.
Order bestOrder(const Game& game);

/// `count` >= 1 random orders of 1 to kMostSampledPlayers players, each independent of the others and as probable as
/// any. They are the same everywhere, and those of a smaller count begin those of a larger one.
/// Source: R. A. Fisher and F. Yates, "Statistical Tables" (1938); R. Durstenfeld, "Algorithm 235" (1964).
std::vector<Order> drawOrders(int players, int count, std::uint32_t seed);

/// What to draw: where there are too many switches for all their combinations.
struct OrderSample {
  std::vector<std::string> players;
  int orders = 0;
  std::uint32_t seed = 0;

  std::vector<Order> draw() const { return drawOrders(static_cast<int>(players.size()), orders, seed); }
};

/// Rising, each once: the coalitions along these orders and along their reverses.
std::vector<Coalition> coalitionsAlong(const std::vector<Order>& orders);

}  // namespace sim2sim
