// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/result_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <stdexcept>
#include <string>

#include "pusht_task/files.hpp"
#include "sim2sim_protocol/probes.hpp"
#include "sim2sim_protocol/reference_cache.hpp"

namespace sim2sim {
namespace {

/// The table that Python reads.
nlohmann::json table() { return nlohmann::json::parse(pusht::readFile(RESULT_FILES, "table")); }

TEST(ResultFiles, AreThoseOfTheTableThatPythonReads) {
  const nlohmann::json rows = table();
  ASSERT_EQ(rows.size(), std::size(kResultFiles));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(kResultFiles[i].key, rows[i].at("key"));
    EXPECT_EQ(kResultFiles[i].name, rows[i].at("name"));
    EXPECT_EQ(kResultFiles[i].in, rows[i].at("in"));
    EXPECT_EQ(kResultFiles[i].format, rows[i].value("format", 0));
    EXPECT_EQ(kResultFiles[i].streamed, rows[i].value("streamed", false));
  }
}

TEST(ResultFiles, HaveKeysAndNamesOfTheirOwn) {
  for (const ResultFile& one : kResultFiles) {
    for (const ResultFile& other : kResultFiles) {
      EXPECT_EQ(&one == &other, std::string(one.key) == other.key);
      EXPECT_EQ(&one == &other, std::string(one.name) == other.name);
    }
  }
  EXPECT_THROW(resultFile("metric"), std::out_of_range);
}

/// What users have on disk stays readable: a new name would lose it.
TEST(ResultFiles, KeepTheirNames) {
  EXPECT_STREQ(kMetricsFile, "metrics.json");
  EXPECT_STREQ(kEpisodesFile, "episodes.csv");
  EXPECT_STREQ(kBandsFile, "divergence.csv");
  EXPECT_STREQ(kJournalFile, "episodes.journal");
  EXPECT_EQ(rowFolder("a", 7), std::filesystem::path("a/rows/007"));
  EXPECT_EQ(rowFolder("a", 1234), std::filesystem::path("a/rows/1234"));
}

TEST(ReferenceCachePattern, FollowsFromTheProbes) {
  const std::regex pattern(ReferenceCache::filePattern());
  EXPECT_TRUE(std::regex_match("10007.reference", pattern));
  EXPECT_TRUE(std::regex_match("0123456789abcdef.reference", pattern));
  EXPECT_TRUE(std::regex_match("10007#2.reference", pattern)) << "a repeat";
  for (const Probe& probe : floorProbes()) {
    EXPECT_TRUE(std::regex_match("10007." + probe.name, pattern)) << probe.name;
  }
  EXPECT_TRUE(std::regex_match("10007." + modelVariant("cone=elliptic:impratio=1e+06", true).name, pattern));
  EXPECT_FALSE(std::regex_match("10007." + stateResetReplay(5).name, pattern)) << "is no rollout of the reference";
  EXPECT_FALSE(std::regex_match("notes.reference", pattern));
}

}  // namespace
}  // namespace sim2sim
