// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/protocol/quantities.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "sim2sim_eval/bag/messages.hpp"
#include "sim2sim_eval/results/report.hpp"

namespace sim2sim {
namespace {

/// Two episodes in which every quantity of every mode has a value of its own.
std::vector<EpisodeResult> distinctEpisodes() {
  std::vector<EpisodeResult> episodes(2);
  double value = 0.5;
  for (EpisodeResult& episode : episodes) {
    episode.index = static_cast<int>(&episode - episodes.data());
    for (const Mode mode : kModes) {
      episode.modes[mode].quantities.fill(std::nan(""));
    }
    forEachQuantity([&](Mode mode, std::size_t i) { episode.modes[mode].quantities[i] = value += 0.25; });
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
  const std::vector<EpisodeResult> episodes = distinctEpisodes();
  const auto lines = cellsOf(episodesCsv(episodes));
  for (std::size_t line = 1; line < lines.size(); ++line) {
    const EpisodeResult& episode = episodes.at((line - 1) / kModeCount);
    const Mode mode = kModes.at((line - 1) % kModeCount);
    const auto message = toMessage(episode, ros::Time(1.0)).rollouts.at(mode);
    ASSERT_EQ(message.quantities.size(), kQuantities.size());
    for (std::size_t i = 0; i < kQuantities.size(); ++i) {
      const std::string column = std::string(kQuantities[i].name) + "_" + kQuantities[i].unit;
      const auto at = std::find(lines[0].begin(), lines[0].end(), column) - lines[0].begin();
      ASSERT_LT(at, static_cast<std::ptrdiff_t>(lines[0].size())) << column;
      EXPECT_EQ(message.quantities[i].name + "_" + message.quantities[i].unit, column);
      if (has(mode, kQuantities[i])) {
        EXPECT_EQ(std::stod(lines[line].at(at)), message.quantities[i].value) << column;
        EXPECT_EQ(episode.modes[mode].at(kQuantities[i].name), message.quantities[i].value) << column;
      } else {
        EXPECT_EQ(lines[line].at(at), "") << column;
        EXPECT_TRUE(std::isnan(message.quantities[i].value)) << column;
      }
    }
  }
}

TEST(Quantities, SayTheSameInMetricsAndMessage) {
  const std::vector<EpisodeResult> episodes = distinctEpisodes();
  const Summary summary = summarize(episodes);
  const RunConfiguration configuration;
  const nlohmann::json figures = metrics(configuration, summary);
  const auto message = summaryMessage(configuration, summary, ros::Time(1.0));
  std::size_t next = 0;
  forEachQuantity([&](Mode mode, std::size_t i) {
    const double mean = (episodes[0].modes[mode].quantities[i] + episodes[1].modes[mode].quantities[i]) / 2.0;
    const auto& told = message.means.at(next++);
    EXPECT_EQ(told.unit, kQuantities[i].unit);
    EXPECT_EQ(told.value, mean) << told.name;
    EXPECT_EQ(figures.at(told.name + "_" + told.unit), mean) << told.name;
    EXPECT_EQ(figures.at(told.name + "_interval_" + told.unit).size(), 2U) << told.name;
  });
  EXPECT_EQ(message.means.size(), next);
}

TEST(Quantities, HaveTheirLineInTheTableIfTheyCompare) {
  const Summary summary = summarize(distinctEpisodes());
  const RunConfiguration configuration;
  const std::string text = table(configuration, summary);
  for (std::size_t i = 0; i < kQuantities.size(); ++i) {
    const std::string figure = cell(summary.means[kEngineReplay][i], kQuantities[i].unit);
    EXPECT_EQ(text.find(figure) != std::string::npos, kQuantities[i].compares) << kQuantities[i].name;
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
