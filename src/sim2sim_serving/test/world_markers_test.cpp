// SPDX-License-Identifier: BSD-3-Clause
// What is written around a table. The geometry is tested where pictures are made of it.
#include "sim2sim_serving/world_markers.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "pusht_task/constants.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace pusht {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::SizeIs;
using ::testing::StartsWith;
using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

constexpr double kSeen = 0.006;  // [m] by which one thing must be over another for rviz to tell from above
constexpr double kWallEnd = kWallInnerFace + 0.04;

pusht_msgs::DescribeResponse description(const std::string& block_damp) {
  pusht_msgs::DescribeResponse description;
  description.name = "two_mass";
  description.title = "two-mass engine";
  description.parameters = {parameter("block_damp", block_damp), parameter("contact_iterations", "4")};
  for (const auto& [name, value] : {std::pair("block_damp", "6.0"), std::pair("contact_iterations", "4")}) {
    description.parameter_descriptors.emplace_back();
    description.parameter_descriptors.back().name = name;
    description.parameter_descriptors.back().default_value = value;
  }
  return description;
}

Caption captionAt(std::uint32_t steps) {
  WorldState state;
  state.tee_position = {0.3, -0.4};
  state.tee_yaw = -1.5;
  Caption caption = captionOf(description("20.0"));
  caption.moment = {7, steps, state};
  return caption;
}

Caption captionWith(std::vector<std::string> settings) {
  Caption caption;
  caption.settings = std::move(settings);
  return caption;
}

std::vector<Marker> textsOf(const Caption& caption) {
  std::vector<Marker> texts;
  for (const Marker& marker : captionMarkers("engine", caption).markers) {
    if (marker.type == Marker::TEXT_VIEW_FACING && marker.action == Marker::ADD) {
      texts.push_back(marker);
    }
  }
  return texts;
}

/// From the top.
std::vector<std::string> linesOf(const Caption& caption) {
  std::vector<Marker> texts = textsOf(caption);
  std::sort(texts.begin(), texts.end(),
            [](const Marker& a, const Marker& b) { return a.pose.position.y > b.pose.position.y; });
  std::vector<std::string> lines(texts.size());
  std::transform(texts.begin(), texts.end(), lines.begin(), [](const Marker& text) { return text.text; });
  return lines;
}

/// The lines below those of the world.
std::vector<std::string> settingsOf(const std::vector<std::string>& settings) {
  Caption caption = captionAt(0);
  caption.settings = settings;
  std::vector<std::string> lines = linesOf(caption);
  lines.erase(lines.begin(), lines.begin() + 4);
  return lines;
}

std::set<std::pair<std::string, int>> namesOf(const MarkerArray& array) {
  std::set<std::pair<std::string, int>> names;
  for (const Marker& marker : array.markers) {
    names.emplace(marker.ns, marker.id);
  }
  return names;
}

TEST(Captions, SayWhatTheSimulatorIsAndHowItsWorldIs) {
  EXPECT_THAT(linesOf(captionAt(12)),
              ElementsAre("two-mass engine", "episode 7, 1.2 s", "tee at x 0.300 m, y -0.400 m, yaw -1.50 rad",
                          "0.500 m, 1.50 rad off target", "block_damp 20.0"));
}

TEST(Captions, SayThatNoEpisodeHasBegun) {
  EXPECT_THAT(linesOf(captionOf(description("6.0"))),
              ElementsAre("two-mass engine", "waits for a reset", "as shipped"));
}

TEST(Captions, NameASimulatorWithoutTitle) {
  pusht_msgs::DescribeResponse plain = description("6.0");
  plain.title.clear();
  EXPECT_EQ(captionOf(plain).title, "two_mass");
}

TEST(Captions, HaveEveryParameterOfWhichNoDefaultIsKnown) {
  pusht_msgs::DescribeResponse silent = description("6.0");
  silent.parameter_descriptors.clear();
  EXPECT_THAT(captionOf(silent).settings, ElementsAre("block_damp 6.0", "contact_iterations 4"));
}

TEST(Captions, BreakAndCutWhatDoesNotFit) {
  const std::string word(40, 'x');
  EXPECT_THAT(settingsOf({word, word}), ElementsAre(word + ", " + word));
  EXPECT_THAT(settingsOf({word, word, word}), ElementsAre(word + ", " + word + ",", word));
  const std::vector<std::string> cut = settingsOf({word, word, word, word, word});
  ASSERT_THAT(cut, SizeIs(2));
  EXPECT_THAT(cut[1], AllOf(StartsWith(word + ", " + word), EndsWith("..."), SizeIs(105)));
}

TEST(Captions, CutBetweenLettersOfSeveralBytes) {
  std::string umlauts;
  for (int i = 0; i < 60; ++i) {
    umlauts += "\xC3\xA4";
  }
  const std::vector<std::string> even = settingsOf({umlauts});
  const std::vector<std::string> odd = settingsOf({"x" + umlauts});
  EXPECT_THAT(even, ElementsAre(umlauts.substr(0, 102) + "..."));
  EXPECT_THAT(odd, ElementsAre("x" + umlauts.substr(0, 100) + "..."));
}

TEST(Captions, ReplaceEachOther) {
  const MarkerArray before = captionMarkers("engine", captionAt(3));
  EXPECT_EQ(namesOf(before), namesOf(captionMarkers("engine", captionOf(description("6.0")))));
  EXPECT_THAT(namesOf(before), SizeIs(before.markers.size()));
  MarkerArray whole = worldMarkers("engine");
  whole.markers.insert(whole.markers.end(), before.markers.begin(), before.markers.end());
  EXPECT_THAT(namesOf(whole), SizeIs(whole.markers.size())) << "and nothing else";
  for (const Marker& marker : captionMarkers("engine", Caption{}).markers) {
    EXPECT_EQ(marker.header.frame_id, "engine/table");
    EXPECT_EQ(marker.ns, "engine/caption");
    EXPECT_TRUE(marker.frame_locked);
  }
}

TEST(Captions, StandBesideTheTableOnCardsThatNoPusherCovers) {
  std::vector<Marker> cards;
  for (const Marker& marker : captionMarkers("engine", captionAt(3)).markers) {
    if (marker.type == Marker::CUBE) {
      EXPECT_GE(marker.pose.position.z, 2.0 * kPusherFrameHeight + kSeen);
      EXPECT_GE(std::abs(marker.pose.position.y) - 0.5 * marker.scale.y, kWallEnd);
      cards.push_back(marker);
    }
  }
  for (const Marker& text : textsOf(captionWith({std::string(100, 'x'), std::string(100, 'x')}))) {
    EXPECT_TRUE(std::any_of(cards.begin(), cards.end(), [&](const Marker& card) {
      return std::abs(text.pose.position.y - card.pose.position.y) + 0.5 * text.scale.z <= 0.5 * card.scale.y &&
             text.pose.position.z >= card.pose.position.z + kSeen;
    })) << text.text;
  }
}

TEST(Captions, OfNothingDrawNoText) {
  EXPECT_THAT(linesOf(Caption{}), ElementsAre("waits for a reset", "as shipped"));
  for (const Marker& marker : captionMarkers("engine", Caption{}).markers) {
    if (marker.type == Marker::TEXT_VIEW_FACING) {
      EXPECT_EQ(marker.action == Marker::DELETE, marker.text.empty());
    }
  }
}

}  // namespace
}  // namespace pusht
