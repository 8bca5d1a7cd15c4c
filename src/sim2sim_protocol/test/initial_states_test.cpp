// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/initial_states.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/refusal.hpp"
#include "pusht_testing/scenarios.hpp"
#include "pusht_testing/temporary_folder.hpp"

namespace sim2sim {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

class StartsTest : public ::testing::Test {
 protected:
  InitialStates read(const std::string& csv, int first, int count) const {
    pusht::writeFile(path_, csv);
    return readInitialStates(path_, first, count);
  }
  std::string refusal(const std::string& csv) const {
    return pusht::testing::refusalOf([&] { read(csv, 0, 1); });
  }

  const std::filesystem::path& path() const { return path_; }

 private:
  pusht::testing::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "starts.csv";
};

TEST_F(StartsTest, ComeBackBitForBit) {
  std::vector<pusht::WorldState> states;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    states.push_back(seed % 2 == 0 ? pusht::spawn(seed) : pusht::testing::movingState(seed));
  }
  const InitialStates starts = read(initialStatesCsv(states), 30, 200);
  for (int i = 0; i < 200; ++i) {
    EXPECT_EQ(starts.at(30 + i), states[static_cast<std::size_t>(i)]) << i;
  }
  EXPECT_EQ(starts.hash(), InitialStates(states, 0).hash());
  EXPECT_THROW(starts.at(29), std::out_of_range);
  EXPECT_THROW(starts.at(230), std::out_of_range);
}

TEST_F(StartsTest, ColumnsComeInAnyOrderAndVelocitiesMayBeLeftOut) {
  const InitialStates starts =
      read("tee_yaw, tee_y,tee_x,pusher_y,pusher_x\r\n0.5,0.1,-0.2,1e-1,-.25\r\n,,,,not read any more", 0, 1);
  pusht::WorldState wanted;
  wanted.pusher_position = {-0.25, 0.1};
  wanted.tee_position = {-0.2, 0.1};
  wanted.tee_yaw = 0.5;
  EXPECT_EQ(starts.at(0), wanted);
}

TEST_F(StartsTest, HashAndNameTellStartsApart) {
  const std::vector<pusht::WorldState> states = {pusht::spawn(1), pusht::spawn(2), pusht::spawn(1)};
  const InitialStates starts(states, 7);
  EXPECT_EQ(starts.keyOf(7), starts.keyOf(9));
  EXPECT_NE(starts.keyOf(7), starts.keyOf(8));
  EXPECT_NE(starts.hash(), InitialStates({states[0], states[1]}, 7).hash());
  EXPECT_EQ(starts.hash(), InitialStates::named(starts.hash()).hash());
}

TEST_F(StartsTest, WhatIsNoStartIsRefusedByLineValueAndRule) {
  const std::string head = "pusher_x,pusher_y,tee_x,tee_y,tee_yaw";
  EXPECT_THAT(refusal(head + "\n"), HasSubstr("has 0 rows: must have at least 1, one for each episode"));
  EXPECT_THAT(refusal(""), HasSubstr("has 0 rows"));
  EXPECT_THAT(refusal(head + "\n0,0,0,0,x\n"), HasSubstr("line 2: tee_yaw 'x': must be a decimal number"));
  EXPECT_THAT(refusal(head + "\n0,0,0,0,1e300\n"), HasSubstr("line 2: reset: tee_yaw 1e+300 rad: must be within"));
  EXPECT_THAT(refusal(head + "\n0,0,0,0,nan\n"), HasSubstr("tee_yaw 'nan': must be a decimal number"));
  EXPECT_THAT(refusal(head + "\n0,0,0,0\n"), HasSubstr("line 2: 4 values: must be 5"));
  EXPECT_THAT(refusal(head + "\n0,0,0,0,0,0\n"), HasSubstr("line 2: 6 values: must be 5"));
  EXPECT_THAT(refusal(head + "\n0,0,1e9,0,0\n"), HasSubstr("line 2: reset: tee_x 1000000000.0 m: must be within"));
  EXPECT_THAT(refusal(head + ",mass\n"), HasSubstr("line 1: column 'mass': must be one of: pusher_x, pusher_y"));
  EXPECT_THAT(refusal(head + ",tee_x\n"), HasSubstr("column 'tee_x': must appear only once"));
  EXPECT_THAT(refusal("pusher_x,pusher_y,tee_x,tee_y\n"), HasSubstr("column 'tee_yaw': is missing"));
}

constexpr const char* kTaken = "not refused";

/// Starts that are given to a run.
class GivenStartsTest : public StartsTest {
 protected:
  std::string refusalOfRun(const std::string& rows, int count, bool may_overlap = false) const {
    pusht::writeFile(path(), "pusher_x,pusher_y,tee_x,tee_y,tee_yaw\n" + rows);
    return pusht::testing::refusalOf([&] { givenInitialStates(path(), 0, count, may_overlap); });
  }
};

TEST_F(GivenStartsTest, BeyondTheTableAreRefused) {
  EXPECT_THAT(refusalOfRun("0.2,0,0,0,0\n222,97,256,256,0.785\n", 2),
              HasSubstr("line 3: pusher_x 222.0 m: the table ends at 0.39 m; pixels or millimeters?"));
  EXPECT_THAT(refusalOfRun("0.5,0,0,0,0\n", 1), EndsWith("line 2: pusher_x 0.5 m: the table ends at 0.39 m"));
  EXPECT_THAT(refusalOfRun("0.2,0,0,-0.4,0\n", 1), HasSubstr("tee_y -0.4 m: the table ends"));
  EXPECT_EQ(refusalOfRun("0.2,0,0,0,0\n222,97,256,256,0.785\n", 1), kTaken) << "the second start is not needed";
}

/// The pusher's radius is 0.015 m; the bar ends at 0.06 m, and the walls are at 0.39 m.
TEST_F(GivenStartsTest, ThatOverlapNeedAWord) {
  EXPECT_THAT(refusalOfRun("0.02,0,0,0,0\n", 1), HasSubstr("line 2: pusher and tee overlap by 0.03 m: must be at"));
  EXPECT_THAT(refusalOfRun("0.071,0,0,0,0\n", 1), HasSubstr("pusher and tee overlap by 0.004 m"));
  EXPECT_EQ(refusalOfRun("0.073,0,0,0,0\n", 1), kTaken) << "as deep as a contact";
  EXPECT_THAT(refusalOfRun("0.38,0,0,0,0\n", 1), HasSubstr("pusher and walls overlap by 0.005 m"));
  EXPECT_THAT(refusalOfRun("0,0.3,0.34,0,0\n", 1), HasSubstr("tee and walls overlap by 0.01 m"));
  EXPECT_THAT(refusalOfRun("0,0.3,0,-0.3,0\n", 1), HasSubstr("tee and walls overlap by 0.015 m")) << "the stem";
  EXPECT_EQ(refusalOfRun("0,0.3,0,-0.3,3.14159\n", 1), kTaken) << "the stem is on the other side";
  EXPECT_EQ(refusalOfRun("0.02,0,0,0,0\n", 1, true), kTaken);
}

TEST_F(GivenStartsTest, InDegreesAreRefused) {
  EXPECT_THAT(refusalOfRun("0.2,0,0,0,45\n", 1), HasSubstr("tee_yaw 45.0 rad: must be within a turn, 2 pi; degrees?"));
  EXPECT_EQ(refusalOfRun("0.2,0,0,0,-6.2\n", 1), kTaken);
}

TEST_F(GivenStartsTest, ThatAreOneStartAreRefused) {
  const std::string row = "0.2,0,0,0,0\n";
  EXPECT_THAT(refusalOfRun(row + "0.3,0,0,0,0\n" + row, 3), HasSubstr("line 4: is the start of line 2 again"));
  EXPECT_EQ(refusalOfRun(row + "0.3,0,0,0,0\n" + row, 2), kTaken);
}

/// No spawn is refused, so that --write-starts gives what --starts takes.
TEST_F(GivenStartsTest, OfSpawnSeedsAreTaken) {
  std::vector<pusht::WorldState> states;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    states.push_back(pusht::spawn(pusht::kFirstSpawnSeed + seed));
  }
  pusht::writeFile(path(), initialStatesCsv(states));
  EXPECT_EQ(pusht::testing::refusalOf([&] { givenInitialStates(path(), 0, 2000, false); }), kTaken);
}

}  // namespace
}  // namespace sim2sim
