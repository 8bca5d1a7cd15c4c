// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/reference_cache.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/scenarios.hpp"
#include "pusht_testing/temporary_folder.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const std::string kStart = "10007";
const std::string kOther = "10008";
const std::string kRollout = "reference";
const nlohmann::json kKey = {{"policy", "one"}};

pusht::Trace someTrace() {
  pusht::TwoMassEngine engine;
  pusht::Rollout rollout = pusht::begin(engine, pusht::spawn(10'007));
  for (int step = 0; step < 20; ++step) {
    pusht::advance(rollout, engine, pusht::testing::chase(engine.state()));
  }
  return rollout.trace();
}

class ReferenceCacheTest : public ::testing::Test {
 protected:
  /// The one file in the folder.
  fs::path file() const {
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path())) {
      if (entry.is_regular_file()) {
        return entry.path();
      }
    }
    return {};
  }

  /// What find() says of the file after a change to its text.
  std::string refusalAfter(const std::function<void(std::string&)>& change) {
    std::string text = pusht::readFile(file(), "file");
    change(text);
    pusht::writeFile(file(), text);
    try {
      cache_.find(kStart, kRollout);
      return "";
    } catch (const pusht::BadDependency& error) {
      return error.what();
    }
  }

  pusht::testing::TemporaryFolder folder_;
  ReferenceCache cache_{folder_.path() / "cache", kKey};
};

TEST_F(ReferenceCacheTest, KeepsARolloutBitForBit) {
  const pusht::Trace trace = someTrace();
  EXPECT_FALSE(cache_.find(kStart, kRollout));
  cache_.keep(kStart, kRollout, trace);
  const auto found = ReferenceCache(folder_.path() / "cache", kKey).find(kStart, kRollout);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->states, trace.states);
  EXPECT_EQ(found->actions, trace.actions);
  EXPECT_FALSE(cache_.find(kOther, kRollout));
  EXPECT_FALSE(cache_.find(kStart, "floor_1e-6"));
  EXPECT_FALSE(ReferenceCache(folder_.path() / "cache", {{"policy", "another"}}).find(kStart, kRollout));
}

TEST_F(ReferenceCacheTest, RefusesADamagedFileByName) {
  cache_.keep(kStart, kRollout, someTrace());
  EXPECT_THAT(refusalAfter([](std::string& text) { text[text.size() - 5] ^= 1; }),
              HasSubstr("10007.reference: is damaged"));
  EXPECT_THAT(refusalAfter([](std::string& text) { text.resize(text.size() / 2); }), HasSubstr("is damaged"));
  EXPECT_THAT(refusalAfter([](std::string& text) { text.resize(10); }), HasSubstr("must begin as"));
  EXPECT_THAT(refusalAfter([](std::string& text) { text.clear(); }), HasSubstr("must begin as"));
}

TEST_F(ReferenceCacheTest, NamesTheFormatThatItDoesNotKnow) {
  cache_.keep(kStart, kRollout, someTrace());
  const auto older = [](std::string& text) {
    text.replace(text.find("reference rollout 3"), 19, "reference rollout 2");
  };
  EXPECT_THAT(refusalAfter(older),
              HasSubstr("10007.reference: format \"reference rollout 2\": must be \"reference rollout "
                        "3\"; another version of the suite wrote it; delete it"));
}

TEST_F(ReferenceCacheTest, RefusesAFileOfAnotherKeyOrStart) {
  ReferenceCache other(folder_.path() / "other", {{"policy", "another"}});
  other.keep(kStart, kRollout, someTrace());
  const fs::path foreign = file();
  cache_.keep(kStart, kRollout, someTrace());
  const auto refusal = [&](const std::string& start) -> std::string {
    try {
      cache_.find(start, kRollout);
      return "";
    } catch (const pusht::BadDependency& error) {
      return error.what();
    }
  };
  const fs::path folder = folder_.path() / "cache" / pusht::sha256(kKey.dump()).substr(0, 16);
  fs::copy_file(folder / "10007.reference", folder / "10008.reference");
  EXPECT_THAT(refusal(kOther), HasSubstr("10008.reference: belongs to another run"));
  fs::copy_file(folder / "10007.reference", folder / "10008.floor_1e-6");
  EXPECT_THROW(cache_.find(kOther, "floor_1e-6"), pusht::BadDependency);
  fs::copy_file(foreign, folder / "10007.reference", fs::copy_options::overwrite_existing);
  EXPECT_THAT(refusal(kStart), HasSubstr("10007.reference: belongs to another run"));
}

TEST_F(ReferenceCacheTest, AFolderThatCannotBeWrittenIsARuntimeFault) {
  std::ofstream(folder_.path() / "file") << "no folder";
  EXPECT_THROW(ReferenceCache(folder_.path() / "file", kKey), pusht::RuntimeFault);
  fs::remove_all(folder_.path() / "cache");
  EXPECT_THROW(cache_.keep(kStart, kRollout, someTrace()), pusht::RuntimeFault);
}

}  // namespace
}  // namespace sim2sim
