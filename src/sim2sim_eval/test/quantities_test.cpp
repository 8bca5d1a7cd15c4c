// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/quantities.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "bag/messages.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/results/episodes_csv.hpp"
#include "sim2sim_protocol/results/headline.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/statistics.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_protocol/results/table.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {
namespace {

/// With probes of every sort.
Protocol withProbes() {
  Protocol protocol;
  protocol.reanchor = {1, 5};
  return protocol;
}

/// Twenty episodes in which every quantity of every rollout has a value of its own.
std::vector<EpisodeResult> distinctEpisodes(const Protocol& protocol) {
  std::vector<EpisodeResult> episodes(20);
  double value = 0.5;
  for (EpisodeResult& episode : episodes) {
    episode.index = static_cast<int>(&episode - episodes.data());
    episode.rollouts.resize(protocol.rolloutNames().size());
    for (RolloutResult& rollout : episode.rollouts) {
      rollout.quantities.fill(std::nan(""));
    }
    forEachQuantity(protocol, [&](std::size_t rollout, std::size_t i) {
      episode.rollouts[rollout].quantities[i] = value += 0.0001220703125;  // a power of two: sums are exact
    });
  }
  return episodes;
}

/// The cells of a table of CSV.
std::vector<std::vector<std::string>> cellsOf(const std::string& csv) {
  std::vector<std::vector<std::string>> lines;
  std::istringstream text(csv);
  for (std::string line; std::getline(text, line);) {
    std::istringstream cells(line + ",");
    lines.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) {
      lines.back().push_back(cell);
    }
  }
  return lines;
}

TEST(Quantities, SayTheSameInCsvAndMessage) {
  const Protocol protocol = withProbes();
  const std::vector<EpisodeResult> episodes = distinctEpisodes(protocol);
  const auto lines = cellsOf(episodesCsv(protocol, episodes));
  const std::size_t rollouts = protocol.rolloutNames().size();
  ASSERT_EQ(lines.size(), 1 + episodes.size() * rollouts);
  for (std::size_t line = 1; line < lines.size(); ++line) {
    const EpisodeResult& episode = episodes.at((line - 1) / rollouts);
    const std::size_t rollout = (line - 1) % rollouts;
    const auto message = toMessage(protocol, episode, ros::Time(1.0)).rollouts.at(rollout);
    EXPECT_EQ(lines[line].at(2), message.mode);
    const std::vector<std::size_t> columns = protocol.quantityColumns();
    ASSERT_EQ(message.quantities.size(), columns.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const Quantity& quantity = kQuantities[columns[i]];
      const std::string column = std::string(quantity.name) + "_" + quantity.unit;
      const auto at = std::find(lines[0].begin(), lines[0].end(), column) - lines[0].begin();
      ASSERT_LT(at, static_cast<std::ptrdiff_t>(lines[0].size())) << column;
      EXPECT_EQ(message.quantities[i].name + "_" + message.quantities[i].unit, column);
      if (std::isnan(episode.rollouts[rollout].quantities[i])) {
        EXPECT_EQ(lines[line].at(at), "") << column;
        EXPECT_TRUE(std::isnan(message.quantities[i].value)) << column;
      } else {
        EXPECT_EQ(std::stod(lines[line].at(at)), message.quantities[i].value) << column;
        EXPECT_EQ(episode.rollouts[rollout].at(kQuantities[i].name), message.quantities[i].value) << column;
      }
    }
  }
}

TEST(Quantities, SayTheSameInMetricsStatisticsAndMessage) {
  RunConfiguration configuration;
  configuration.protocol = withProbes();
  const std::vector<EpisodeResult> episodes = distinctEpisodes(configuration.protocol);
  const std::vector<std::string> rollouts = configuration.protocol.rolloutNames();
  const Summary summary = summarize(configuration.protocol, episodes);
  const nlohmann::json figures = metrics(configuration, summary);
  const nlohmann::json distributions = statistics(configuration, episodes);
  const auto message = summaryMessage(configuration, summary, ros::Time(1.0));
  std::size_t next = 0;
  forEachQuantity(configuration.protocol, [&](std::size_t rollout, std::size_t i) {
    double mean = 0.0;
    for (const EpisodeResult& episode : episodes) {
      mean += episode.rollouts[rollout].quantities[i] / 20.0;
    }
    const auto& told = message.means.at(next++);
    const std::string column = std::string(kQuantities[i].name) + "_" + kQuantities[i].unit;
    EXPECT_EQ(told.unit, kQuantities[i].unit);
    EXPECT_NEAR(summary.means[rollout][i].value, mean, 1e-12) << told.name;
    EXPECT_EQ(told.value, printedMean(summary, rollout, i).value) << told.name;
    EXPECT_NEAR(figures.at(told.name + "_" + told.unit), mean, 1e-6) << told.name;
    const bool is_anchor_error = std::string(kQuantities[i].name).rfind("anchor_", 0) == 0;
    EXPECT_EQ(figures.at(told.name + "_interval_" + told.unit).size(), is_anchor_error ? 0U : 2U) << told.name;
    const nlohmann::json& distribution = distributions.at("rollouts").at(rollouts[rollout]).at(column);
    EXPECT_EQ(distribution.at("mean"), figures.at(told.name + "_" + told.unit)) << column;
    EXPECT_EQ(distribution.at("episodes"), 20) << column;
  });
  EXPECT_EQ(message.means.size(), next);
  const Headline headline = headlineOf(configuration, summary.outcomes, summary.endings);
  EXPECT_EQ(distributions.at("headline"), toJson(headline));
  EXPECT_EQ(message.verdict, nameOf(headline.verdict));
  EXPECT_EQ(message.headline, headline.text());
  EXPECT_EQ(message.caveat, headline.caveat);
  EXPECT_NE(table(configuration, summary).find(headline.text() + "\n"), std::string::npos);
  for (const auto& mean : message.means) {  // all episodes are as far from the null model: no interval, no verdict
    const bool is_whole = mean.name == "mean_pos_divergence" || mean.name == "mean_ang_divergence";
    const bool is_early = mean.name.find("engine_replay_early_") == 0 && mean.name.find("null") == std::string::npos;
    EXPECT_EQ(mean.mark, is_whole || is_early ? "(?)" : "") << mean.name;
  }
}

/// What is shown computes nothing: texts of the message are those of the terminal.
TEST(Texts, OfTheMessageAreThoseOfTheTerminal) {
  RunConfiguration configuration;
  configuration.protocol.until_decided = 0.33;  // which decides how many digits a transfer has
  std::vector<EpisodeResult> episodes(400, distinctEpisodes(configuration.protocol).front());
  for (std::size_t i = 0; i < episodes.size(); ++i) {
    episodes[i].rollouts[kReferenceClosed].success = i < 250;
    episodes[i].rollouts[kEngineClosed].success = i < 82;
  }
  const Summary summary = summarize(configuration.protocol, episodes);
  const auto message = summaryMessage(configuration, summary, ros::Time(1.0));
  const std::string text = table(configuration, summary);
  EXPECT_EQ(message.transfer_text.substr(0, 6), "32.8 %") << message.transfer_text;
  EXPECT_NE(text.find(message.transfer_text), std::string::npos) << text;
  EXPECT_EQ(message.reference.text, "250/400  0.625");
  EXPECT_EQ(message.engine.text, "82/400  0.205");
  EXPECT_NE(text.find(message.engine.text.substr(8)), std::string::npos) << text;
  for (const auto& mean : message.means) {
    if (mean.name == "mean_pos_divergence" || mean.name == "mean_ang_divergence") {
      EXPECT_NE(text.find(mean.text), std::string::npos) << mean.text;
      EXPECT_EQ(mean.text.substr(mean.text.size() - mean.mark.size()), mean.mark);
    }
  }
  const auto none = summaryMessage(configuration, std::nullopt, ros::Time(1.0));
  EXPECT_EQ(none.transfer_text + none.reference.text + none.engine.text + none.means.front().text, "");
}

TEST(Quantities, AreInTheTableIfTheyAreDivergences) {
  RunConfiguration configuration;
  const Summary summary = summarize(configuration.protocol, distinctEpisodes(configuration.protocol));
  const std::string text = table(configuration, summary);
  for (std::size_t i = 0; i < kQuantities.size(); ++i) {
    const std::string figure = cell(summary.means[kEngineReplay][i], kQuantities[i].unit);
    const auto is_of = [i](const DivergencePair& pair) { return pair.divergence == std::string(kQuantities[i].name); };
    EXPECT_EQ(text.find(figure) != std::string::npos,
              std::any_of(kDivergencePairs.begin(), kDivergencePairs.end(), is_of))
        << kQuantities[i].name;
  }
}

TEST(Quantities, AreFoundByTheirNames) {
  for (std::size_t i = 0; i < kQuantities.size(); ++i) {
    EXPECT_EQ(quantityIndex(kQuantities[i].name), i);
  }
  EXPECT_THROW(quantityIndex("beauty"), std::out_of_range);
}

}  // namespace
}  // namespace sim2sim
