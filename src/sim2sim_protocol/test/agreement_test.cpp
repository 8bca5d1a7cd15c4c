// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/agreement.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "sim2sim_protocol/results/agreement_files.hpp"
#include "sim2sim_statistics/tails.hpp"

namespace sim2sim {
namespace {

constexpr double kStill = 0.01;  ///< [m] divergence of a tee that never moves

const Quantity& positionDivergence() { return kQuantities[quantityIndex("mean_position_divergence")]; }

/// Simulators that stand at these places [m] on a line, in the mean; each episode scales all distances alike, and has
/// some noise of each pair.
AgreementSamples onALine(const std::vector<double>& places, int episodes, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> scale(0.5, 1.5);
  std::uniform_real_distribution<double> noise(0.9, 1.1);
  AgreementSamples samples;
  samples.pairs.assign(places.size(), std::vector<DistanceSamples>(places.size()));
  samples.variants.resize(places.size());
  for (int episode = 0; episode < episodes; ++episode) {
    const double of_episode = scale(random);
    for (std::size_t i = 0; i < places.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const double distance = std::abs(places[i] - places[j]) * of_episode * noise(random);
        for (DistanceSamples* pair : {&samples.pairs[i][j], &samples.pairs[j][i]}) {
          pair->divergence.push_back(distance);
          pair->null_model.push_back(kStill);
        }
      }
    }
  }
  return samples;
}

TEST(AgreementFigures, RecoverPlantedDistances) {
  const std::vector<double> places = {0.0, 0.001, 0.004};
  const AgreementFigures figures = figuresOf(onALine(places, 400, 1), positionDivergence());
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_EQ(figures.distances[i][i].value, 0.0);
    EXPECT_FALSE(figures.distances[i][i].interval);
    for (std::size_t j = 0; j < i; ++j) {
      const Estimate& distance = figures.distances[i][j];
      const double planted = std::abs(places[i] - places[j]);
      EXPECT_NEAR(distance.value, planted, 0.05 * planted);
      EXPECT_LT(distance.interval->low, planted);
      EXPECT_GT(distance.interval->high, planted);
      EXPECT_EQ(distance.value, figures.distances[j][i].value);
      EXPECT_EQ(distance.interval->low, figures.distances[j][i].interval->low);
      EXPECT_EQ(distance.interval->high, figures.distances[j][i].interval->high);
    }
  }
  EXPECT_NEAR(figures.others[0].value, 0.0025, 0.00015);
  EXPECT_NEAR(figures.others[1].value, 0.0020, 0.00015);
  EXPECT_NEAR(figures.others[2].value, 0.0035, 0.0002);
  ASSERT_TRUE(figures.centrality);
  EXPECT_GT((*figures.centrality)[1].most, 0.99);
  EXPECT_GT((*figures.centrality)[2].least, 0.99);
}

TEST(AgreementFigures, HaveTheIntervalsOfARunsDivergences) {
  AgreementSamples samples = onALine({0.0, 0.001}, 30, 2);
  samples.variants[1].push_back(samples.pairs[0][1]);
  const AgreementFigures figures = figuresOf(samples, positionDivergence());
  const Interval interval = *tailMeanInterval(samples.pairs[0][1].divergence, kStill);
  for (const Estimate& estimate : {figures.distances[0][1], figures.variants[1][0], figures.others[0]}) {
    EXPECT_NEAR(estimate.interval->low, interval.low, 1e-9);
    EXPECT_NEAR(estimate.interval->high, interval.high, 1e-9);
  }
  EXPECT_TRUE(figures.variants[0].empty());
  EXPECT_NEAR((*figures.centrality)[0].most, 0.5, 1e-9);  // of two, none is more central
}

TEST(AgreementFigures, CountBothWays) {
  AgreementSamples samples = onALine({0.0, 0.001, 0.002}, 20, 3);
  for (double& distance : samples.pairs[0][1].divergence) {
    distance *= 3.0;  // along the episodes of the first it is farther
  }
  const AgreementFigures figures = figuresOf(samples, positionDivergence());
  EXPECT_NEAR(figures.distances[0][1].value, 3.0 * figures.distances[1][0].value, 1e-9);
  EXPECT_NEAR(figures.others[0].value,
              (figures.distances[0][1].value + figures.distances[1][0].value + 2.0 * figures.distances[0][2].value) / 4,
              1e-9);
}

TEST(AgreementFigures, HaveNoIntervalsOfFewEpisodes) {
  const AgreementFigures figures = figuresOf(onALine({0.0, 0.001}, kFewestEpisodes - 1, 4), positionDivergence());
  EXPECT_FALSE(figures.distances[0][1].interval);
  EXPECT_FALSE(figures.others[0].interval);
  EXPECT_FALSE(figures.centrality);
}

Agreement twoSimulators(int episodes) {
  const AgreementFigures figures = figuresOf(onALine({0.0, 0.001}, episodes, 5), positionDivergence());
  Agreement agreement;
  agreement.run = {{"policy", "bc"}, {"episodes", episodes}};
  agreement.simulators = {{"mujoco", {"mujoco", "MuJoCo"}, {}}, {"other", {"other", "the other"}, {}}};
  agreement.replays = {{5, {figures, figures}}, {0, {figures, figures}}};
  return agreement;
}

TEST(AgreementFiles, SayWhatThereIs) {
  Agreement agreement = twoSimulators(30);
  const nlohmann::json both = toJson(agreement);
  EXPECT_TRUE(both.at("reference").is_null());
  EXPECT_EQ(both.at("replays")[0].at("reset_every"), 5);
  EXPECT_TRUE(both.at("replays")[1].at("reset_every").is_null());
  const nlohmann::json& position = both.at("replays")[0].at("position");
  EXPECT_EQ(position.at("distances")[0][0].at("value"), 0.0);
  EXPECT_NEAR(position.at("distances")[0][1].at("value").get<double>(), 0.001, 0.0002);
  EXPECT_EQ(position.at("most_central"), nlohmann::json({0.5, 0.5}));
  EXPECT_NE(table(agreement).find("the actions of each row's simulator"), std::string::npos);
  agreement.reference = agreement.simulators.front().record;
  const std::string text = table(agreement);
  EXPECT_NE(text.find("the actions of MuJoCo"), std::string::npos);
  EXPECT_NE(text.find("position [mm], reset to the reference's state every 5 control steps"), std::string::npos);
  EXPECT_NE(text.find("angle [mrad], in open loop"), std::string::npos);
  EXPECT_NE(text.find("most central"), std::string::npos);
}

TEST(AgreementFiles, HaveNoSharesOfFewEpisodes) {
  const Agreement agreement = twoSimulators(5);
  EXPECT_TRUE(toJson(agreement).at("replays")[0].at("angle").at("most_central").is_null());
  EXPECT_EQ(table(agreement).find("most central"), std::string::npos);
}

}  // namespace
}  // namespace sim2sim
