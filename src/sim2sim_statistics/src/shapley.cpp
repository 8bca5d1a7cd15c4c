// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/shapley.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/binomial.hpp>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>
#include <limits>
#include <utility>

#include "coalitions.hpp"
#include "sim2sim_statistics/common.hpp"
#include "sim2sim_statistics/tails.hpp"

namespace sim2sim {
namespace {

/// `of(episode)` of all episodes, as paired differences.
template <class OfEpisode>
Difference overEpisodes(const Game& game, const std::optional<double>& extreme, const OfEpisode& of) {
  std::vector<double> differences(static_cast<std::size_t>(game.episodes()));
  for (int episode = 0; episode < game.episodes(); ++episode) {
    differences[static_cast<std::size_t>(episode)] = of(episode);
  }
  return pairedDifference(differences, extreme);
}

/// `of(player, episode)` of all episodes, by player.
template <class OfPlayer>
std::vector<Difference> ofEveryPlayer(const Game& game, const std::optional<double>& extreme, const OfPlayer& of) {
  std::vector<Difference> differences(static_cast<std::size_t>(game.players()));
  for (int player = 0; player < game.players(); ++player) {
    const auto of_player = [&](int episode) { return of(player, episode); };
    differences[static_cast<std::size_t>(player)] = overEpisodes(game, extreme, of_player);
  }
  return differences;
}

/// By number s: how probable it is that in a random order of n players a given one comes right after s given others,
/// s! (n - s - 1)! / n!.
std::vector<double> precedences(int n) {
  std::vector<double> weights;
  for (int s = 0; s < n; ++s) {
    const auto others = static_cast<unsigned>(n - 1);
    weights.push_back(1.0 / (n * boost::math::binomial_coefficient<double>(others, static_cast<unsigned>(s))));
  }
  return weights;
}

using Rows = std::vector<std::vector<double>>;

Rows zeros(std::size_t rows, int columns) { return Rows(rows, std::vector<double>(static_cast<std::size_t>(columns))); }

/// Gap that each player removes.
struct Contributions {
  Rows by_episode;  ///< and player; the mean over all orders
  Rows by_order;    ///< and player; the mean over all episodes. None if the orders are no sample
};

Contributions contributionsOf(const Game& game) {
  const std::vector<double> weights = precedences(game.players());
  Rows by_episode = zeros(static_cast<std::size_t>(game.episodes()), game.players());
  for (int episode = 0; episode < game.episodes(); ++episode) {
    std::vector<double>& removed = by_episode[static_cast<std::size_t>(episode)];
    for (Coalition before = kNone; before < game.all(); ++before) {
      const double weight = weights[sizeOf(before)];
      const double gap = game.gap(before, episode);
      for (int player = 0; player < game.players(); ++player) {
        if (!isOn(before, player)) {
          removed[static_cast<std::size_t>(player)] += weight * (gap - game.gap(before | only(player), episode));
        }
      }
    }
  }
  return {std::move(by_episode), {}};
}

/// Adds the gap that each player removes along one order to both kinds of means.
template <class Player>
void addAlong(Player first, Player last, const std::map<Coalition, std::vector<double>>& gaps, std::size_t orders,
              std::vector<double>& of_order, Rows& by_episode) {
  Coalition on = kNone;
  const std::vector<double>* before = &gaps.at(on);
  for (; first != last; ++first) {
    on |= only(*first);
    const std::vector<double>* after = &gaps.at(on);
    const auto player = static_cast<std::size_t>(*first);
    for (std::size_t episode = 0; episode < by_episode.size(); ++episode) {
      const double half = 0.5 * ((*before)[episode] - (*after)[episode]);  // the reverse adds the other half
      of_order[player] += half / static_cast<double>(by_episode.size());
      by_episode[episode][player] += half / static_cast<double>(orders);
    }
    before = after;
  }
}

Contributions contributionsOf(int players, const std::vector<Order>& orders,
                              const std::map<Coalition, std::vector<double>>& gaps) {
  Contributions contributions = {zeros(gaps.at(kNone).size(), players), zeros(orders.size(), players)};
  for (std::size_t i = 0; i < orders.size(); ++i) {
    const auto add = [&](auto first, auto last) {
      addAlong(first, last, gaps, orders.size(), contributions.by_order[i], contributions.by_episode);
    };
    add(orders[i].begin(), orders[i].end());
    add(orders[i].rbegin(), orders[i].rend());
  }
  return contributions;
}

std::vector<double> column(const Rows& rows, std::size_t player) {
  std::vector<double> values(rows.size());
  std::transform(rows.begin(), rows.end(), values.begin(), [player](const auto& row) { return row[player]; });
  return values;
}

/// Interval of the mean of a table from the means of its rows and of its columns, both of which are samples.
std::optional<Interval> crossedInterval(double mean, const std::vector<double>& by_episode,
                                        const std::vector<double>& by_order) {
  const auto episodes = static_cast<double>(by_episode.size());
  const auto orders = static_cast<double>(by_order.size());
  if (episodes < kFewestPairs || orders < kFewestOrders) {
    return std::nullopt;
  }
  const double of_episodes = std::pow(standardDeviation(by_episode), 2) / episodes;
  const double of_orders = std::pow(standardDeviation(by_order), 2) / orders;
  const double squared_error = of_episodes + of_orders;
  if (std::sqrt(squared_error) <= kSame) {
    return std::nullopt;
  }
  const double freedom = squared_error * squared_error /
                         (of_episodes * of_episodes / (episodes - 1.0) + of_orders * of_orders / (orders - 1.0));
  const boost::math::students_t t(freedom);
  const double half_width = quantile(t, 0.5 * (1.0 + kConfidence)) * std::sqrt(squared_error);
  return Interval{mean - half_width, mean + half_width};
}

bool areCarriedByFew(const std::vector<double>& values, const std::optional<double>& extreme) {
  return extreme && isCarriedByFew(values, *extreme);
}

Estimate estimateOf(const Contributions& contributions, std::size_t player, const std::optional<double>& extreme) {
  const std::vector<double> by_episode = column(contributions.by_episode, player);
  const Difference difference = pairedDifference(by_episode, extreme);
  if (contributions.by_order.empty()) {
    return {difference.value, difference.interval};
  }
  if (areCarriedByFew(by_episode, extreme)) {
    return {difference.value, std::nullopt};
  }
  return {difference.value, crossedInterval(difference.value, by_episode, column(contributions.by_order, player))};
}

/// Adds the mean of as many rows as there are, drawn with replacement.
void addResampled(const Rows& rows, Random& random, std::vector<double>& sums) {
  const UniformIndex any(0, rows.size() - 1);
  const double weight = 1.0 / static_cast<double>(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::vector<double>& row = rows[any(random)];
    for (std::size_t player = 0; player < sums.size(); ++player) {
      sums[player] += weight * row[player];
    }
  }
}

Interval percentiles(std::vector<double>& draws) {
  std::sort(draws.begin(), draws.end());
  return {quantileOf(draws, 0.5 * (1.0 - kConfidence)), quantileOf(draws, 0.5 * (1.0 + kConfidence))};
}

/// By player; empty if there may be nothing to share.
std::vector<Interval> partIntervals(const Contributions& contributions, const std::vector<double>& values) {
  Random random(kResampleSeed);
  Rows parts(values.size(), std::vector<double>(kResamples));
  std::vector<double> drawn(values.size());
  for (std::size_t resample = 0; resample < kResamples; ++resample) {
    std::fill(drawn.begin(), drawn.end(), 0.0);
    addResampled(contributions.by_episode, random, drawn);
    if (!contributions.by_order.empty()) {
      addResampled(contributions.by_order, random, drawn);
      std::transform(drawn.begin(), drawn.end(), values.begin(), drawn.begin(), std::minus<>());  // it is in twice
    }
    const double gap = sumOf(drawn);
    if (gap <= kSame) {
      return {};
    }
    for (std::size_t player = 0; player < drawn.size(); ++player) {
      parts[player][resample] = drawn[player] / gap;
    }
  }
  std::vector<Interval> intervals;
  std::transform(parts.begin(), parts.end(), std::back_inserter(intervals), percentiles);
  return intervals;
}

/// The parts of shares that have none yet.
void addParts(const Contributions& contributions, const std::vector<double>& values,
              const std::optional<double>& extreme, std::vector<Share>& shares) {
  const double gap = sumOf(values);
  if (gap <= kSame) {
    return;
  }
  for (Share& share : shares) {
    share.part = share.value / gap;
  }
  if (std::none_of(shares.begin(), shares.end(), [](const Share& share) { return share.interval.has_value(); })) {
    return;
  }
  std::vector<double> wholes;  // by episode
  std::transform(contributions.by_episode.begin(), contributions.by_episode.end(), std::back_inserter(wholes), sumOf);
  if (areCarriedByFew(wholes, extreme)) {
    return;
  }
  const std::vector<Interval> intervals = partIntervals(contributions, values);
  for (std::size_t player = 0; player < intervals.size(); ++player) {
    if (shares[player].interval && !areCarriedByFew(column(contributions.by_episode, player), extreme)) {
      shares[player].part_interval = intervals[player];
    }
  }
}

std::vector<Share> sharesOf(const Contributions& contributions, const std::optional<double>& extreme) {
  std::vector<Share> shares;
  std::vector<double> values;
  for (std::size_t player = 0; player < contributions.by_episode.front().size(); ++player) {
    const Estimate estimate = estimateOf(contributions, player, extreme);
    shares.push_back({estimate.value, estimate.interval, std::numeric_limits<double>::quiet_NaN(), std::nullopt});
    values.push_back(estimate.value);
  }
  addParts(contributions, values, extreme, shares);
  return shares;
}

/// Interaction of two players in one episode.
double interactionIn(const Game& game, int episode, int first, int second, const std::vector<double>& weights) {
  double sum = 0.0;
  for (Coalition before = kNone; before <= game.all(); ++before) {
    if (!isOn(before, first) && !isOn(before, second)) {
      const double of_first_alone = game.gap(before, episode) - game.gap(before | only(first), episode);
      const double of_first_after_second =
          game.gap(before | only(second), episode) - game.gap(before | only(first) | only(second), episode);
      sum += weights[sizeOf(before)] * (of_first_after_second - of_first_alone);
    }
  }
  return sum;
}

}  // namespace

std::vector<Share> shares(const Game& game, const std::optional<double>& extreme) {
  return sharesOf(contributionsOf(game), extreme);
}

std::vector<Interaction> interactions(const Game& game, const std::optional<double>& extreme) {
  const std::optional<double> twice = extreme ? std::optional(2.0 * *extreme) : std::nullopt;
  const std::vector<double> weights = precedences(game.players() - 1);  // the pair counts as one player
  std::vector<Interaction> found;
  for (int first = 0; first < game.players(); ++first) {
    for (int second = first + 1; second < game.players(); ++second) {
      const auto of = [&](int episode) { return interactionIn(game, episode, first, second, weights); };
      found.push_back({first, second, overEpisodes(game, twice, of)});
    }
  }
  return found;
}

std::vector<Difference> alone(const Game& game, const std::optional<double>& extreme) {
  return ofEveryPlayer(game, extreme, [&game](int player, int episode) {
    return game.gap(kNone, episode) - game.gap(only(player), episode);
  });
}

std::vector<Difference> leaveOneOut(const Game& game, const std::optional<double>& extreme) {
  return ofEveryPlayer(game, extreme, [&game, all = game.all()](int player, int episode) {
    return game.gap(all ^ only(player), episode) - game.gap(all, episode);
  });
}

std::vector<Difference> stepsAlong(const Game& game, const Order& order, const std::optional<double>& extreme) {
  if (requireOrders({order}) != game.players()) {
    refuse("number of players in an order", order.size(), "that of the game");
  }
  std::vector<Difference> steps;
  Coalition before = kNone;
  for (const int player : order) {
    const Coalition after = before | only(player);
    steps.push_back(overEpisodes(game, extreme, [&game, before, after](int episode) {
      return game.gap(before, episode) - game.gap(after, episode);
    }));
    before = after;
  }
  return steps;
}

std::vector<Share> sampledShares(const std::vector<Order>& orders, const std::map<Coalition, std::vector<double>>& gaps,
                                 const std::optional<double>& extreme) {
  const int players = requireOrders(orders);
  for (const Coalition on : coalitionsAlong(orders)) {
    const auto played = gaps.find(on);
    if (played == gaps.end()) {
      refuse("coalition", on, "among those with gaps: it is along an order or its reverse");
    }
    requireGaps(on, played->second, gaps.at(kNone).size());
  }
  return sharesOf(contributionsOf(players, orders, gaps), extreme);
}

}  // namespace sim2sim
