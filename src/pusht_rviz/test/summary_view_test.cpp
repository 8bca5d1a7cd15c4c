// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_rviz/summary_view.hpp"

#include <gmock/gmock.h>

#include <QLabel>
#include <QVBoxLayout>

#include "headless.hpp"
#include "pusht_rviz/curves.hpp"
#include "pusht_rviz/episode_strip.hpp"
#include "pusht_rviz/episodes_model.hpp"
#include "pusht_rviz/theme.hpp"

namespace pusht_rviz {
namespace {
constexpr int kWidth = 360;   // [px] of the panel in a window of 1366x768
constexpr int kHeight = 445;  // [px] of a tab there, below a failure of two lines

TEST(SummaryView, IsWholeBesideTheCurvesInASmallWindow) {
  headlessApplication();
  EpisodesModel episodes;
  auto* const strip = new EpisodeStrip(&episodes);
  strip->setRun(100, 0);
  auto* const summary = new SummaryView(strip);
  QWidget tab;
  auto* const column = new QVBoxLayout(&tab);
  column->setContentsMargins(0, 0, 0, 0);
  column->addWidget(summary);
  column->addWidget(new Curves, 1);
  tab.setStyleSheet(theme::styleSheet());
  pusht_msgs::Summary shown;
  shown.headline =
      "Does the skill transfer? So far at most in part: with this policy the rigid-body engine keeps 41 % [23, 68] of "
      "MuJoCo's success (45 of 50 episodes).";
  summary->show(shown);
  tab.resize(kWidth, kHeight);
  tab.show();
  QApplication::processEvents();
  const auto* const headline = summary->findChild<QLabel*>("headline");
  EXPECT_GE(headline->height(), 3 * headline->fontMetrics().lineSpacing()) << "a long one";
  EXPECT_GE(headline->height(), headline->heightForWidth(headline->width()));
  EXPECT_GE(summary->height(), summary->heightForWidth(summary->width()));
  EXPECT_LE(column->minimumHeightForWidth(kWidth), kHeight) << "nothing is cut at the edge";
}

}  // namespace
}  // namespace pusht_rviz
