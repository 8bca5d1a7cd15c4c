// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/messages.hpp"

#include <gtest/gtest.h>

namespace sim2sim {
namespace {

TEST(KnobsFrom, HaveTheTypeThatTheirTextShows) {
  const auto knobs = knobsFrom({pusht::parameter("walls", "true"), pusht::parameter("friction", "false"),
                                pusht::parameter("sweeps", "20"), pusht::parameter("drag", "20.0"),
                                pusht::parameter("shape", "two discs"), pusht::parameter("limit", "inf"),
                                pusht::parameter("code", "010")});
  EXPECT_EQ(
      knobs.dump(),
      R"({"walls":true,"friction":false,"sweeps":20,"drag":20.0,"shape":"two discs","limit":"inf","code":"010"})");
  RunConfiguration configuration;
  configuration.knobs = knobs;
  EXPECT_EQ(configurationHash(configuration), "6b3ad3f0aa39") << "as Python prints them";
  EXPECT_EQ(configurationFrom(describe(configuration)).knobs, knobs) << "and back";
}

}  // namespace
}  // namespace sim2sim
