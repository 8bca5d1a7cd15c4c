// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/cooperative_game.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <string>
#include <utility>

#include "coalitions.hpp"
#include "sim2sim_statistics/common.hpp"
#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {
namespace {

void requireOrder(const Order& order, int players) {
  if (order.size() != static_cast<std::size_t>(players)) {
    refuse("players in an order:", order.size(), std::to_string(players));
  }
  Coalition seen = kNone;
  for (const int player : order) {
    if (player < 0 || player >= players || isOn(seen, player)) {
      refuse("player in an order:", player, "from 0 to " + std::to_string(players - 1) + ", and each once");
    }
    seen |= only(player);
  }
}

/// By coalition: the least sum of the mean gaps of those that follow it up to all on.
using LeastAreas = std::vector<double>;

/// Least area of the coalitions that follow `on` if `next` is the next player.
double areaWith(const Game& game, const LeastAreas& least, Coalition on, int next) {
  return game.meanGap(on | only(next)) + least[on | only(next)];
}

LeastAreas leastAreas(const Game& game) {
  LeastAreas least(std::size_t{game.all()} + 1, std::numeric_limits<double>::infinity());
  least[game.all()] = 0.0;
  for (Coalition on = game.all(); on-- > kNone;) {
    for (int player = 0; player < game.players(); ++player) {
      if (!isOn(on, player)) {
        least[on] = std::min(least[on], areaWith(game, least, on, player));
      }
    }
  }
  return least;
}

Order drawOrder(int players, Random& random) {
  Order order(static_cast<std::size_t>(players));
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t last = order.size() - 1; last > 0; --last) {
    std::swap(order[last], order[UniformIndex(0, last)(random)]);
  }
  return order;
}

}  // namespace

void requirePlayers(int players, int most) {
  if (players < 1 || players > most) {
    refuse("number of players", players, "from 1 to " + std::to_string(most));
  }
}

void requireGaps(Coalition coalition, const std::vector<double>& gaps, std::size_t episodes) {
  const std::string of_coalition = " of coalition " + std::to_string(coalition);
  if (gaps.empty() || gaps.size() != episodes) {
    refuse("episodes" + of_coalition + ":", gaps.size(), "at least 1, and as many as those of the first coalition");
  }
  for (std::size_t episode = 0; episode < episodes; ++episode) {
    if (!std::isfinite(gaps[episode])) {
      refuse("gap" + of_coalition + " in episode " + std::to_string(episode) + ":", gaps[episode], "a finite number");
    }
  }
}

int requireOrders(const std::vector<Order>& orders) {
  if (orders.empty()) {
    refuse("number of orders", 0, "at least 1");
  }
  const int players = static_cast<int>(std::min<std::size_t>(orders.front().size(), kMostSampledPlayers + 1));
  requirePlayers(players, kMostSampledPlayers);
  for (const Order& order : orders) {
    requireOrder(order, players);
  }
  return players;
}

Game::Game(int players, const std::vector<std::vector<double>>& gaps) : players_(players) {
  requirePlayers(players, kMostPlayers);
  const std::size_t coalitions = std::size_t{1} << players;
  if (gaps.size() != coalitions) {
    refuse("number of coalitions", gaps.size(), std::to_string(coalitions));
  }
  const std::size_t episodes = gaps.front().size();
  for (Coalition on = kNone; on < coalitions; ++on) {
    requireGaps(on, gaps[on], episodes);
    mean_gaps_.push_back(averageOf(gaps[on]));
  }
  episodes_ = static_cast<int>(episodes);
  for (std::size_t episode = 0; episode < episodes; ++episode) {
    std::transform(gaps.begin(), gaps.end(), std::back_inserter(gaps_),
                   [episode](const auto& of_coalition) { return of_coalition[episode]; });
  }
}

std::vector<double> staircase(const Game& game, const Order& order) {
  requireOrder(order, game.players());
  Coalition on = kNone;
  std::vector<double> steps = {game.meanGap(on)};
  for (const int player : order) {
    on |= only(player);
    steps.push_back(game.meanGap(on));
  }
  return steps;
}

Order bestOrder(const Game& game) {
  const LeastAreas least = leastAreas(game);
  Order order;
  for (Coalition on = kNone; on != game.all(); on |= only(order.back())) {
    int next = 0;
    // kSame, for rounding must not choose between equals.
    while (isOn(on, next) || areaWith(game, least, on, next) > least[on] + kSame) {
      ++next;
    }
    order.push_back(next);
  }
  return order;
}

std::vector<Order> drawOrders(int players, int count, std::uint32_t seed) {
  requirePlayers(players, kMostSampledPlayers);
  if (count < 1) {
    refuse("number of orders", count, "at least 1");
  }
  Random random(seed);
  std::vector<Order> orders(static_cast<std::size_t>(count));
  std::generate(orders.begin(), orders.end(), [&] { return drawOrder(players, random); });
  return orders;
}

std::vector<Coalition> coalitionsAlong(const std::vector<Order>& orders) {
  requireOrders(orders);
  std::vector<Coalition> coalitions = {kNone};
  const auto add = [&coalitions](auto first, auto last) {
    Coalition on = kNone;
    for (; first != last; ++first) {
      on |= only(*first);
      coalitions.push_back(on);
    }
  };
  for (const Order& order : orders) {
    add(order.begin(), order.end());
    add(order.rbegin(), order.rend());
  }
  std::sort(coalitions.begin(), coalitions.end());
  coalitions.erase(std::unique(coalitions.begin(), coalitions.end()), coalitions.end());
  return coalitions;
}

}  // namespace sim2sim
