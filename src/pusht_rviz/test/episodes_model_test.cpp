// SPDX-License-Identifier: BSD-3-Clause
#include "episodes_model.hpp"

#include <gmock/gmock.h>

#include <string>

namespace pusht_rviz {
namespace {

pusht_msgs::RolloutResult rollout(const std::string& mode, std::uint32_t steps, bool success) {
  pusht_msgs::RolloutResult made;
  made.mode = mode;
  made.steps = steps;
  made.success = success ? 1 : 0;
  made.ending = success ? "success" : "stuck";
  made.still_step = 41;
  made.pusher_ending = "moving";
  return made;
}

pusht_msgs::EpisodeResult episode(std::uint64_t index, bool engine_success = false) {
  pusht_msgs::EpisodeResult made;
  made.episode = index;
  made.seed = 10000 + index;
  made.rollouts = {rollout("reference_closed", 123, true), rollout("engine_closed", 300, engine_success),
                   rollout("engine_replay", 123, false), rollout("floor_1e-6", 999, true)};
  made.rollouts[2].parting_step = 14;
  made.rollouts[2].parting_cause = "sticking_on_bar";
  made.rollouts[2].parting_first = "pusher";
  return made;
}

QString shown(const EpisodesModel& model, int row, int column) {
  return model.data(model.index(row, column), Qt::DisplayRole).toString();
}

TEST(EpisodesModel, ShowsOutcomesAndPartingInWords) {
  EpisodesModel model;
  model.add({episode(7)});
  EXPECT_EQ(shown(model, 0, EpisodesModel::kEpisode), "7");
  EXPECT_EQ(shown(model, 0, EpisodesModel::kSeed), "10007");
  EXPECT_EQ(shown(model, 0, EpisodesModel::kReference), QString::fromUtf8("✓ solved"));
  EXPECT_EQ(shown(model, 0, EpisodesModel::kEngine), QString::fromUtf8("✗ stuck"));
  EXPECT_EQ(shown(model, 0, EpisodesModel::kFirstDivergence), "1.4 s");
  EXPECT_EQ(shown(model, 0, EpisodesModel::kCause), "sticking on bar");
  EXPECT_EQ(model.row(0).steps, 300U) << "of the modes: probes do not count";
  const QString tip = model.data(model.index(0, EpisodesModel::kCause), Qt::ToolTipRole).toString();
  const QString ending = model.data(model.index(0, EpisodesModel::kEngine), Qt::ToolTipRole).toString();
  EXPECT_EQ(ending,
            QString::fromUtf8("engine, closed loop: ✗ stuck after 30.0 s: its tee lies still from 4.1 s on; its "
                              "pusher then: moving"));
  EXPECT_TRUE(tip.contains("first to be elsewhere: pusher")) << tip.toStdString();
}

TEST(EpisodesModel, ShowsAReplayThatStays) {
  pusht_msgs::EpisodeResult result = episode(0);
  result.rollouts[2].parting_step = 0;
  result.seed = 0;
  EpisodesModel model;
  model.add({result});
  EXPECT_EQ(shown(model, 0, EpisodesModel::kFirstDivergence), QString::fromUtf8("–"));
  EXPECT_EQ(shown(model, 0, EpisodesModel::kCause), "stays together");
  EXPECT_EQ(shown(model, 0, EpisodesModel::kSeed), QString::fromUtf8("–")) << "its start was given";
}

TEST(EpisodesModel, ReplacesAnEpisodeThatIsThere) {
  EpisodesModel model;
  model.add({episode(0), episode(1)});
  model.add({episode(1, true), episode(2)});
  model.add({episode(3), episode(3, true)});
  EXPECT_EQ(model.rowCount(), 4);
  EXPECT_TRUE(model.row(1).engine.success);
  EXPECT_TRUE(model.row(3).engine.success);
}

TEST(EpisodesModel, FindsEpisodes) {
  EpisodesModel model;
  model.add({episode(5), episode(6), episode(9)});
  EXPECT_EQ(model.rowOfEpisode(6), 1);
  EXPECT_EQ(model.rowOfEpisode(7), std::nullopt);
  model.clear();
  EXPECT_EQ(model.rowCount(), 0);
  EXPECT_EQ(model.rowOfEpisode(6), std::nullopt);
}

TEST(EpisodesModel, InsertsManyAtOnce) {
  EpisodesModel model;
  int insertions = 0;
  QObject::connect(&model, &EpisodesModel::rowsInserted, [&] { ++insertions; });
  std::vector<pusht_msgs::EpisodeResult> many;
  for (std::uint64_t i = 0; i < 10'000; ++i) {
    many.push_back(episode(i));
  }
  model.add(many);
  EXPECT_EQ(model.rowCount(), 10'000);
  EXPECT_EQ(insertions, 1);
}

TEST(EpisodesModel, IsATableAndNoTree) {
  EpisodesModel model;
  model.add({episode(0)});
  EXPECT_EQ(model.rowCount(model.index(0, 0)), 0);
  EXPECT_EQ(model.columnCount(model.index(0, 0)), 0);
  EXPECT_FALSE(model.data(model.index(5, 0), Qt::DisplayRole).isValid());
  EXPECT_EQ(model.headerData(EpisodesModel::kSeed, Qt::Horizontal, Qt::DisplayRole).toString(), "seed");
}

}  // namespace
}  // namespace pusht_rviz
